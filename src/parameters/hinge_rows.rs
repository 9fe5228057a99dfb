//! The rows of the table about the strength of a hinge over its rotation.

use super::parameter::{Admissible, Applies, DefaultValue, Parameter};

/// `b` of a named section unless it is given: docs/theory.md gives the reasons.
pub(super) const HARDENING_OF_NAMED: f64 = 0.01;

/// The same where the strength grows with the strain rate, too.
pub(super) const HARDENING_WITH_RATE: f64 = 0.005;

/// Of the steel.
pub(super) const HARDENING_RATIO: Parameter = Parameter {
    name: "hardening.ratio",
    unit: "",
    default: DefaultValue::Double(HARDENING_OF_NAMED),
    admissible: Admissible::Real { min: 0.0, max: 0.1 },
    applies: Applies::AfterResponse,
    meaning: "b: slope of the stress-strain curve after yield over Young's modulus, from first yield on; it enlarges the whole yield \
              surface with the plastic rotation. Unless given, 0.01 for a section by name, 0.005 with a rate.law, 0 for a user-defined one; 12 measured columns need 0.006 to 0.05 (docs/theory.md). 0 is on the safe side for displacements and on \
              the unsafe side for forces",
};

/// Local buckling.
pub(super) const SOFTENING_MODEL: Parameter = Parameter {
    name: "softening.model",
    unit: "",
    default: DefaultValue::Text("backbone"),
    admissible: Admissible::Choice(&["none", "backbone"]),
    applies: Applies::AfterResponse,
    meaning: "how a hinge loses strength when its flanges and web buckle locally. backbone: its moment falls with the accumulated \
              plastic rotation beyond the capping rotation, as in a monotonic test (Lignos 2019); none: it does not. Unless given, \
              backbone for a section by name, none for a user-defined one; with assessment.ultimate_rotation: 0 there is none",
};

pub(super) const SOFTENING_CAPPING_ROTATION: Parameter = Parameter {
    name: "softening.capping_rotation",
    unit: "rad",
    default: DefaultValue::Double(0.0),
    admissible: Admissible::RealOrZero {
        min: 1e-4,
        max: 3.0,
        zero: "from the section, its length and top.load",
    },
    applies: Applies::AfterResponse,
    meaning: "theta_p: plastic rotation at which the moment begins to fall, and at which hardening ends",
};

pub(super) const SOFTENING_POST_CAPPING_ROTATION: Parameter = Parameter {
    name: "softening.post_capping_rotation",
    unit: "rad",
    default: DefaultValue::Double(0.0),
    admissible: Admissible::RealOrZero {
        min: 1e-4,
        max: 10.0,
        zero: "from the section, its length and top.load",
    },
    applies: Applies::AfterResponse,
    meaning: "theta_pc: further plastic rotation over which the moment would fall to zero",
};

pub(super) const SOFTENING_RESIDUAL: Parameter = Parameter {
    name: "softening.residual",
    unit: "",
    default: DefaultValue::Double(0.0),
    admissible: Admissible::RealOrZero {
        min: 1e-3,
        max: 1.0,
        zero: "from the section, its length and top.load; none for a user-defined section",
    },
    applies: Applies::AfterResponse,
    meaning: "moment that remains, relative to that at the capping rotation",
};
