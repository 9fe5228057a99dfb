//! The rows of the table about the load and the buckling lengths with which a verdict is made.

use super::parameter::{Admissible, Applies, DefaultValue, Parameter};

/// Of an effective length: a column held by several storeys of bracing has less than 0.5, one above a soft joint more than 2.
const BUCKLING_FACTOR: Admissible = Admissible::RealOrZero {
    min: 0.05,
    max: 20.0,
    zero: "from the supports",
};

/// How much of what the structure above takes counts.
pub(super) const REDISTRIBUTION_LIMIT: Parameter = Parameter {
    name: "top.redistribution_limit",
    unit: "N",
    default: DefaultValue::Double(0.0),
    admissible: Admissible::RealOrZero {
        min: 1.0,
        max: 1e9,
        zero: "none counts",
    },
    applies: Applies::AtOnce,
    meaning: "largest force that the structure above is proven to take off the column. The verdict compares with top.load less the force that the spring takes, at most this; needs top.redistribution_proof and a top.spring_stiffness. The response has the whole \
              spring in any case",
};

/// By what.
pub(super) const REDISTRIBUTION_PROOF: Parameter = Parameter {
    name: "top.redistribution_proof",
    unit: "",
    default: DefaultValue::Text(""),
    admissible: Admissible::Text {
        min_chars: 0,
        max_chars: 200,
    },
    applies: Applies::AtOnce,
    meaning: "where the proof of top.redistribution_limit is found, such as the number of a calculation; every verdict states it",
};

/// Which load it is.
pub(super) const LOAD_BASIS: Parameter = Parameter {
    name: "top.load_basis",
    unit: "",
    default: DefaultValue::Text("present"),
    admissible: Admissible::Choice(&["present", "accidental"]),
    applies: Applies::AtOnce,
    meaning: "meaning of top.load, which every verdict states. present: the load that the column carries now; accidental: the load of the \
              accidental combination of EN 1990 (6.4.3.3), with its psi factors",
};

/// `K_y`.
pub(super) const BUCKLING_FACTOR_STRONG: Parameter = Parameter {
    name: "capacity.buckling_factor_strong",
    unit: "",
    default: DefaultValue::Double(0.0),
    admissible: BUCKLING_FACTOR,
    applies: Applies::AtOnce,
    meaning: "K_y: buckling length about the strong axis, in the plane of the impact, over the height of the column",
};

/// `K_z`.
pub(super) const BUCKLING_FACTOR_WEAK: Parameter = Parameter {
    name: "capacity.buckling_factor_weak",
    unit: "",
    default: DefaultValue::Double(0.0),
    admissible: BUCKLING_FACTOR,
    applies: Applies::AtOnce,
    meaning: "K_z: buckling length about the weak axis over the height of the column; 1 for a base plate with two rows of anchors next to the web, which holds the weak axis as a pin",
};
