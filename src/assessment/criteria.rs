//! The criteria as data: names, editions, tags, actions; and how each is evaluated.

use std::borrow::Cow;

use super::base::{AT_REST, BaseDemand, ConnectedBase, FAILED_ANCHORS};
use super::criterion::{Action, PART_OF_LENGTH};
use super::definition::{Definition, Evaluation, NotEvaluated, Relation};
use super::input::{AssessedShear, AssessmentInput};
use super::remaining::ResidualCapacity;
use super::rotation_limits::{HingeSlenderness, rotation_before_buckling};
use super::section_class::{SectionClass, section_class};
use crate::column::RolledSection;
use crate::parameters::Provenance;

/// Spring constant of a vehicle in Annex C of EN 1991-1-7 \[N/m\] (JCSS Probabilistic Model Code, 2.18).
const ANNEX_C_STIFFNESS: f64 = 300e3;

/// What to give where the dimensions of the section are not known.
const NO_DIMENSIONS: NotEvaluated = NotEvaluated::Missing(Cow::Borrowed(
    "the section is user-defined and the dimensions of its plates are not known; give section.name without overriding its \
     properties",
));

/// An impact is judged without knowing where the column came to rest.
const NO_EQUILIBRIUM: NotEvaluated = NotEvaluated::Missing(Cow::Borrowed(
    "the equilibrium in which the column comes to rest is not known; measure its bow",
));

/// The web of the column does not yield in shear.
const NO_SHEAR: NotEvaluated = NotEvaluated::Missing(Cow::Borrowed(
    "the web is not known, or shear.model is none, and a hit near a support may shear the web long before the column bends; give \
     section.name, or section.height, section.web_thickness, section.width and section.flange_thickness",
));

const NO_IMPACT: NotEvaluated = NotEvaluated::NotApplicable(Cow::Borrowed("no impact is given"));

const PROGRAM: &str = "column_twin";
const ASCE: &str = "ASCE/SEI 41-17, table 9-6";
const AISC: &str = "ANSI/AISC 342-21, table C3.6";
const LIGNOS: &str = "Lignos et al. 2019, monotonic";
const PDC: &str = "PDC-TR 06-08, support rotation";
const TABLE_4_1: &str = "EN 1991-1-7:2006, table 4.1";
const DAMAGE: &str = "damage index D = 1 - N_u / N_u undamaged";
const LINKS: &str = "ASCE/SEI 41-17, links that yield in shear, rotation b";
const WEB: &str = "largest plastic shear angle of a web";
const HINGE: &str = "largest plastic rotation, of hinges 1a and 1b together";
const RESISTANCE: &str =
    "remaining buckling resistance about the weaker axis, over the applied load N";
const TIMES_RATIO: &str = "EN 1993-1-1:2005, 6.3.1, times N_u / N_u undamaged of the push-down";
const BOW: &str = "residual bow over the height L";
const BENT: &str = "residual bow over the height L, or of the bent part over its length";
const SUPPORT: &str = "largest rotation of a bar at its support";
const BASE_SHEAR: &str = "EN 1993-1-8:2005, 6.2.2, without partial factors";
const BASE_MOMENT: &str = "EN 1993-1-8:2005, 6.2.8, without partial factors";
const RESERVE: &str =
    "N_u, remaining buckling resistance about the strong axis, over the applied load N";

/// Reserve below which a column is shored.
const SHORING_RESERVE: f64 = 1.5;
const RESERVE_OF_ALL: &str = "N_u, remaining buckling resistance about the strong axis, over the applied load N or two thirds of top.load, \
                              whichever is larger";
const RESISTANCE_OF_ALL: &str = "remaining buckling resistance about the weaker axis, over the applied load N or two thirds of top.load, \
                                 whichever is larger";

/// Every criterion, in the order of the names in the table of parameters: the most severe first, so that the first of
/// equally severe ones decides.
pub(super) const DEFINITIONS: &[Definition] = &[
    Definition {
        name: "collapse",
        title: "Stability during the hit",
        cause: "the column collapses or fractures during the hit and carries nothing",
        edition: PROGRAM,
        tag: Provenance::Computed,
        unit: "",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: "collapse or fractured hinge, web or base in the response (1: yes)",
        consequence: "the column has lost its shape, its equilibrium, a hinge or its base and carries nothing",
        evaluate: |input| {
            let lost = input.collapsed || input.fractured;
            Ok((if lost { 1.0 } else { 0.0 }, 0.0))
        },
    },
    Definition {
        name: "ultimate_rotation",
        title: "Plastic rotation: section fractures",
        cause: "the section is bent so far that it tears",
        edition: LIGNOS,
        tag: Provenance::Read,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: HINGE,
        consequence: "the section is fractured and the column carries nothing",
        evaluate: |input| {
            // A fractured hinge lies beyond its limit, whatever remains of its rotation.
            let by_shear = input
                .shear
                .as_ref()
                .is_some_and(AssessedShear::is_fractured);
            let by_base = input.fractured_base().is_some();
            let beyond = if input.fractured && !by_shear && !by_base {
                input.ultimate_rotation * (1.0 + f64::EPSILON)
            } else {
                0.0
            };
            let rotation = input.largest_rotation();
            let value = if rotation < beyond { beyond } else { rotation };
            Ok((value, input.ultimate_rotation))
        },
    },
    Definition {
        name: "ultimate_shear_angle",
        title: "Plastic shear of the web: web fractures",
        cause: "the web is sheared so far that it tears",
        edition: LINKS,
        tag: Provenance::Assumed,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: WEB,
        consequence: "the web is fractured and the column carries nothing",
        evaluate: |input| {
            let shear = input.shear.as_ref().ok_or(NO_SHEAR)?;
            Ok((shear.largest_angle(), shear.ultimate_angle))
        },
    },
    Definition {
        name: "capacity_reserve_1",
        title: "Buckling resistance left, strong axis, over the load",
        cause: "the buckling resistance that is left is smaller than the load",
        edition: TIMES_RATIO,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtLeast,
        action: Action::Evacuate,
        value: RESERVE,
        consequence: "the column cannot carry its load",
        evaluate: |input| reserve(&input.remaining, 1.0),
    },
    Definition {
        name: "remaining_resistance",
        title: "Buckling resistance left, weaker axis, over the load",
        cause: "the buckling resistance that is left about the weaker axis is smaller than the load",
        edition: TIMES_RATIO,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtLeast,
        action: Action::Evacuate,
        value: RESISTANCE,
        consequence: "the load exceeds the characteristic buckling resistance that is left",
        evaluate: |input| resistance(&input.remaining, 1.0),
    },
    Definition {
        name: "damage_80",
        title: "Axial resistance lost: collapse",
        cause: "more than 80 % of the axial resistance is lost",
        edition: DAMAGE,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: "loss of axial capacity",
        consequence: "the damage is that of a collapse",
        evaluate: |input| Ok((input.remaining.damage, 0.8)),
    },
    Definition {
        name: "capacity_reserve_1_5",
        title: "Buckling resistance left, strong axis, with a reserve of 1.5",
        cause: "the buckling resistance that is left is less than 1.5 times the load",
        edition: TIMES_RATIO,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtLeast,
        action: Action::Shore,
        value: RESERVE_OF_ALL,
        consequence: "the load must be taken off the column",
        evaluate: |input| reserve(&with_all_of_the_load(input), SHORING_RESERVE),
    },
    Definition {
        name: "remaining_resistance_1_5",
        title: "Buckling resistance left, weaker axis, with a reserve of 1.5",
        cause: "the buckling resistance that is left about the weaker axis is less than 1.5 times the load",
        edition: TIMES_RATIO,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtLeast,
        action: Action::Shore,
        value: RESISTANCE_OF_ALL,
        consequence: "less is left of the characteristic buckling resistance than a load with its partial factors needs",
        evaluate: |input| resistance(&with_all_of_the_load(input), SHORING_RESERVE),
    },
    Definition {
        name: "residual_bow_100",
        title: "Residual bow over the height: resistance not reliable",
        cause: "the column stays bent so far that its buckling resistance must not be relied on",
        edition: PROGRAM,
        tag: Provenance::Assumed,
        unit: PART_OF_LENGTH,
        relation: Relation::AtMost,
        action: Action::Shore,
        value: BOW,
        consequence: "the column is bent so far that its buckling resistance must not be relied on",
        evaluate: |input| bow(input, AssessmentInput::bow_of_column, 100.0),
    },
    Definition {
        name: "capping_rotation",
        title: "Plastic rotation: local buckling",
        cause: "the section is bent so far that its plates buckle and its resistance falls",
        edition: "Lignos et al. 2019, monotonic, for classes 1 and 2; 0.01 rad at most for class 3, none for class 4",
        tag: Provenance::Assumed,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Shore,
        value: HINGE,
        consequence: "local buckling lowers the moment of the hinge, so that the computed capacity is too high",
        evaluate: |input| {
            let rotation = input.largest_rotation();
            let Some(section) = &input.section else {
                // Without any, no limit is exceeded.
                return Err(match rotation {
                    0.0 => NotEvaluated::NotApplicable(Cow::Borrowed("no hinge has yielded")),
                    _ => NO_DIMENSIONS,
                });
            };
            let strength = input.yield_strength;
            let (height, ratio) = (input.height(), input.axial_ratio());
            let limit = rotation_before_buckling(section, strength, height, ratio);
            Ok((rotation, limit))
        },
    },
    Definition {
        name: "damage_50",
        title: "Axial resistance lost: high damage",
        cause: "more than half of the axial resistance is lost",
        edition: DAMAGE,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtMost,
        action: Action::Shore,
        value: "loss of axial capacity",
        consequence: "the damage is high",
        evaluate: |input| Ok((input.remaining.damage, 0.5)),
    },
    Definition {
        name: "residual_bow_250",
        title: "Residual bow of the bent part: beyond the curves",
        cause: "the column stays bent further than the buckling curves allow for",
        edition: "EN 1993-1-1:2005, table 5.1, e0 of buckling curve b",
        tag: Provenance::Assumed,
        unit: PART_OF_LENGTH,
        relation: Relation::AtMost,
        action: Action::Restrict,
        value: BENT,
        consequence: "the bow is larger than the one that the buckling curves contain, so that they do not hold",
        evaluate: |input| bow(input, AssessmentInput::bow_of_bent_part, 250.0),
    },
    Definition {
        name: "damage_20",
        title: "Axial resistance lost: medium damage",
        cause: "more than a fifth of the axial resistance is lost",
        edition: DAMAGE,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtMost,
        action: Action::Restrict,
        value: "loss of axial capacity",
        consequence: "the damage is medium",
        evaluate: |input| Ok((input.remaining.damage, 0.2)),
    },
    Definition {
        name: "residual_bow_750",
        title: "Residual bow of the bent part: tolerance of erection",
        cause: "the column is less straight than the tolerance of erection allows",
        edition: "EN 1090-2:2018, straightness of a column",
        tag: Provenance::Assumed,
        unit: PART_OF_LENGTH,
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: BENT,
        consequence: "the column is less straight than the tolerance of erection allows; its shape must be measured",
        evaluate: |input| bow(input, AssessmentInput::bow_of_bent_part, 750.0),
    },
    Definition {
        name: "plastic_flow",
        title: "Yielding in bending",
        cause: "the steel has yielded in bending",
        edition: PROGRAM,
        tag: Provenance::Assumed,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: HINGE,
        consequence: "the steel has yielded; connections and welds must be looked at",
        evaluate: |input| Ok((input.largest_rotation(), 0.0)),
    },
    // The base, in one block.
    Definition {
        name: "base_anchors_1_3",
        title: "Base anchors, force over resistance",
        cause: "the anchors of the base may be broken",
        edition: BASE_SHEAR,
        tag: Provenance::Assumed,
        unit: "",
        relation: Relation::AtMost,
        action: Action::Restrict,
        value: "largest force in the anchors over 1 ms, shear or uplift, with 1.25 times the strength of a column that has flowed, \
                over their resistance",
        consequence: "the anchors may be broken",
        evaluate: |input| {
            let (base, demand) = base(input)?;
            let used = base.shear(demand).ratio().max(base.uplift(demand).ratio());
            Ok((used, FAILED_ANCHORS))
        },
    },
    Definition {
        name: "base_shear",
        title: "Base, shear: anchors and friction",
        cause: "the shear force exceeds the resistance of the base plate's anchors",
        edition: BASE_SHEAR,
        tag: Provenance::Assumed,
        unit: "N",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: "largest shear force of the base over 1 ms, with 1.25 times the strength of a column that has flowed",
        consequence: "the anchors slip or shear off; the base plate and its anchors must be looked at",
        evaluate: |input| {
            let (base, demand) = base(input)?;
            let used = base.shear(demand);
            Ok((used.demand, used.resistance))
        },
    },
    Definition {
        name: "base_moment",
        title: "Base, moment: plate, anchors, concrete",
        cause: "the moment exceeds the resistance of the base plate",
        edition: BASE_MOMENT,
        tag: Provenance::Assumed,
        unit: "N m",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: "moment of the base to be checked, with 1.25 times the strength of a column that has flowed",
        consequence: "anchors, plate or concrete yield; the base plate must be looked at",
        evaluate: |input| {
            let (base, demand) = base(input)?;
            if !base.bears_moment {
                return Err(NotEvaluated::NotApplicable(Cow::Borrowed(
                    "a pinned base bears no moment",
                )));
            }
            let used = base.moment(demand);
            Ok((used.demand, used.resistance))
        },
    },
    Definition {
        name: "base_uplift",
        title: "Base, uplift: anchors in tension",
        cause: "the base is lifted with more force than its anchors bear",
        edition: BASE_MOMENT,
        tag: Provenance::Assumed,
        unit: "N",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: "largest tension of the base over 1 ms, with 1.25 times the strength of a column that has flowed",
        consequence: "the anchors are pulled out of the foundation or fractured",
        evaluate: |input| {
            let (base, demand) = base(input)?;
            let used = base.uplift(demand);
            Ok((used.demand, used.resistance))
        },
    },
    Definition {
        name: "shear_flow",
        title: "Yielding of the web in shear",
        cause: "the web has yielded in shear",
        edition: PROGRAM,
        tag: Provenance::Assumed,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: WEB,
        consequence: "the web has yielded in shear; web, base plate, anchors and welds must be looked at",
        evaluate: |input| {
            let shear = input.shear.as_ref().ok_or(NO_SHEAR)?;
            Ok((shear.largest_angle(), 0.0))
        },
    },
    Definition {
        name: "asce41_cp",
        title: "Plastic rotation: collapse prevention (seismic)",
        cause: "the rotation exceeds collapse prevention of ASCE 41",
        edition: ASCE,
        tag: Provenance::Recalled,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: HINGE,
        consequence: "collapse prevention (b) is not given after repeated cycles",
        evaluate: |input| rotation(input, |hinge| hinge.asce41().b),
    },
    Definition {
        name: "asce41_ls",
        title: "Plastic rotation: life safety (seismic)",
        cause: "the rotation exceeds life safety of ASCE 41",
        edition: ASCE,
        tag: Provenance::Recalled,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Shore,
        value: HINGE,
        consequence: "life safety (0.75 b) is not given after repeated cycles",
        evaluate: |input| rotation(input, |hinge| 0.75 * hinge.asce41().b),
    },
    Definition {
        name: "asce41_io",
        title: "Plastic rotation: immediate occupancy (seismic)",
        cause: "the rotation exceeds immediate occupancy of ASCE 41",
        edition: ASCE,
        tag: Provenance::Recalled,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Restrict,
        value: HINGE,
        consequence: "immediate occupancy (0.5 a) is not given",
        evaluate: |input| rotation(input, |hinge| 0.5 * hinge.asce41().a),
    },
    Definition {
        name: "aisc342_cp",
        title: "Plastic rotation: collapse prevention (seismic)",
        cause: "the rotation exceeds collapse prevention of AISC 342",
        edition: AISC,
        tag: Provenance::Recalled,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: HINGE,
        consequence: "collapse prevention (b) is not given after repeated cycles",
        evaluate: |input| rotation(input, |hinge| hinge.aisc342().b),
    },
    Definition {
        name: "aisc342_ls",
        title: "Plastic rotation: life safety (seismic)",
        cause: "the rotation exceeds life safety of AISC 342",
        edition: AISC,
        tag: Provenance::Recalled,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Shore,
        value: HINGE,
        consequence: "life safety (0.75 b) is not given after repeated cycles",
        evaluate: |input| rotation(input, |hinge| 0.75 * hinge.aisc342().b),
    },
    Definition {
        name: "aisc342_io",
        title: "Plastic rotation: immediate occupancy (seismic)",
        cause: "the rotation exceeds immediate occupancy of AISC 342",
        edition: AISC,
        tag: Provenance::Recalled,
        unit: "rad",
        relation: Relation::AtMost,
        action: Action::Restrict,
        value: HINGE,
        consequence: "immediate occupancy (0.5 a) is not given",
        evaluate: |input| rotation(input, |hinge| 0.5 * hinge.aisc342().a),
    },
    Definition {
        name: "support_rotation_20",
        title: "Rotation at the supports: failure (blast)",
        cause: "the bars turn so far at their supports that blast practice expects failure",
        edition: PDC,
        tag: Provenance::Recalled,
        unit: "deg",
        relation: Relation::AtMost,
        action: Action::Evacuate,
        value: SUPPORT,
        consequence: "blast practice expects the member to fail",
        evaluate: |input| Ok((input.support_rotation(), 20.0)),
    },
    Definition {
        name: "support_rotation_10",
        title: "Rotation at the supports: heavy damage (blast)",
        cause: "the bars turn so far at their supports that blast practice expects heavy damage",
        edition: PDC,
        tag: Provenance::Recalled,
        unit: "deg",
        relation: Relation::AtMost,
        action: Action::Shore,
        value: SUPPORT,
        consequence: "blast practice expects heavy damage",
        evaluate: |input| Ok((input.support_rotation(), 10.0)),
    },
    Definition {
        name: "support_rotation_3",
        title: "Rotation at the supports: moderate damage (blast)",
        cause: "the bars turn so far at their supports that blast practice expects moderate damage",
        edition: PDC,
        tag: Provenance::Recalled,
        unit: "deg",
        relation: Relation::AtMost,
        action: Action::Restrict,
        value: SUPPORT,
        consequence: "blast practice expects moderate damage",
        evaluate: |input| Ok((input.support_rotation(), 3.0)),
    },
    Definition {
        name: "crush_force",
        title: "Strength of the vehicle's front over that of the column",
        cause: "the vehicle's front is stronger than the column",
        edition: PROGRAM,
        tag: Provenance::Assumed,
        unit: "N",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: "largest crush force of the vehicle's front",
        consequence: "the front is stronger than the plastic plateau F0 of the column, so that the column gives way first",
        evaluate: |input| {
            let impact = input.impact.ok_or(NO_IMPACT)?;
            let force = impact.front_force.ok_or(NotEvaluated::NotApplicable(
                "the vehicle is rigid: its front has no crush force".into(),
            ))?;
            Ok((force, input.plateau))
        },
    },
    Definition {
        name: "equivalent_static_force",
        title: "Equivalent static force of the impact",
        cause: "the equivalent static force of the impact exceeds the plastic resistance of the column",
        edition: "EN 1991-1-7:2006, annex C, v sqrt(k m) with k = 300 kN/m (JCSS 2.18)",
        tag: Provenance::Read,
        unit: "N",
        relation: Relation::AtMost,
        action: Action::Inspect,
        value: "equivalent static force of the impact",
        consequence: "the force of the code exceeds the plastic plateau F0 of the column",
        evaluate: |input| {
            let impact = input.impact.ok_or(NO_IMPACT)?;
            let force = impact.velocity.abs() * (ANNEX_C_STIFFNESS * impact.mass).sqrt();
            Ok((force, input.plateau))
        },
    },
    Definition {
        name: "table_4_1_motorway",
        title: "Design force of a motorway",
        cause: "the design force of a motorway exceeds the plastic resistance of the column",
        evaluate: |input| Ok((1000e3, input.plateau)),
        ..TABLE_4_1_FORCE
    },
    Definition {
        name: "table_4_1_rural",
        title: "Design force of a rural road",
        cause: "the design force of a rural road exceeds the plastic resistance of the column",
        evaluate: |input| Ok((750e3, input.plateau)),
        ..TABLE_4_1_FORCE
    },
    Definition {
        name: "table_4_1_urban",
        title: "Design force of an urban road",
        cause: "the design force of an urban road exceeds the plastic resistance of the column",
        evaluate: |input| Ok((500e3, input.plateau)),
        ..TABLE_4_1_FORCE
    },
    Definition {
        name: "table_4_1_courtyard_lorry",
        title: "Design force of a courtyard, lorries",
        cause: "the design force of lorries in a courtyard exceeds the plastic resistance of the column",
        evaluate: |input| Ok((150e3, input.plateau)),
        ..TABLE_4_1_FORCE
    },
    Definition {
        name: "table_4_1_courtyard_car",
        title: "Design force of a courtyard, cars",
        cause: "the design force of cars in a courtyard exceeds the plastic resistance of the column",
        evaluate: |input| Ok((50e3, input.plateau)),
        ..TABLE_4_1_FORCE
    },
];

/// The connection of the base and what it has to bear.
fn base(input: &AssessmentInput) -> Result<(&ConnectedBase, &BaseDemand), NotEvaluated> {
    match (&input.base, &input.base_demand) {
        (Some(base), Some(demand)) => Ok((base, demand)),
        // Nothing has happened to it.
        (Some(base), None) if input.impact.is_none() && input.largest_rotation() == 0.0 => {
            Ok((base, &AT_REST))
        }
        (Some(_), None) => Err(NotEvaluated::Missing(Cow::Borrowed(
            "the reactions of the base are known of an impact only",
        ))),
        (None, _) => Err(NotEvaluated::Missing(
            input
                .no_base
                .clone()
                .unwrap_or_else(|| {
                    "the connection of the base is not known; give base.connection".to_owned()
                })
                .into(),
        )),
    }
}

/// A force of Table 4.1, in the direction of the traffic, which does not depend on the impact.
const TABLE_4_1_FORCE: Definition = Definition {
    name: "",
    title: "",
    cause: "",
    edition: TABLE_4_1,
    tag: Provenance::Recalled,
    unit: "N",
    relation: Relation::AtMost,
    action: Action::Inspect,
    value: "indicative equivalent static force of this road class",
    consequence: "the force of the code exceeds the plastic plateau F0 of the column",
    evaluate: |_| Err(NO_IMPACT),
};

/// That there is a load with which a resistance can be compared.
fn loaded(remaining: &ResidualCapacity) -> Result<(), NotEvaluated> {
    let load = remaining.carried_load;
    if load > 0.0 {
        return Ok(());
    }
    Err(NotEvaluated::NotApplicable(Cow::Owned(format!(
        "the column carries no compressive load ({:.1} kN), so that there is no reserve to compare",
        load / 1e3
    ))))
}

/// The remaining capacity, where `N` counts with so much of `top.load` that a column that cannot bear all of that by itself has no
/// more than the limit of 1.5: it is shored, even where the structure above is proven to take what it lacks.
fn with_all_of_the_load(input: &AssessmentInput) -> ResidualCapacity {
    input
        .remaining
        .counting(input.load.top_load / SHORING_RESERVE)
}

fn reserve(remaining: &ResidualCapacity, limit: f64) -> Evaluation {
    loaded(remaining)?;
    Ok((remaining.reserve.unwrap_or(f64::NAN), limit))
}

fn resistance(remaining: &ResidualCapacity, limit: f64) -> Evaluation {
    loaded(remaining)?;
    let times = remaining.resistance_over_load().ok_or(NO_DIMENSIONS)?;
    Ok((times, limit))
}

/// A smaller bow over its length is round-off of the static equilibrium of a straight column; the smallest limit is 1/750.
const ROUND_OFF_OF_BOW: f64 = 1e-12;

/// A bow over its length against a part of that length.
fn bow(input: &AssessmentInput, bow: fn(&AssessmentInput) -> Option<f64>, part: f64) -> Evaluation {
    match bow(input) {
        Some(bow) if bow < ROUND_OFF_OF_BOW => Ok((0.0, 1.0 / part)),
        Some(bow) => Ok((bow, 1.0 / part)),
        None if input.collapsed || input.fractured => Err(NotEvaluated::NotApplicable(
            "the column has no equilibrium that remains".into(),
        )),
        None => Err(NO_EQUILIBRIUM),
    }
}

/// Why the limits of a code for compact sections do not hold for a section; `None` if they do.
fn not_compact(input: &AssessmentInput, section: &RolledSection) -> Option<NotEvaluated> {
    let found = section_class(section, input.yield_strength, input.axial_ratio());
    (found.class > SectionClass::Two).then(|| {
        NotEvaluated::Missing(Cow::Owned(format!(
            "the limit holds for compact sections, and this one is of {found}; let capping_rotation decide"
        )))
    })
}

fn rotation(input: &AssessmentInput, limit: fn(&HingeSlenderness) -> f64) -> Evaluation {
    let section = input.section.as_ref().ok_or(NO_DIMENSIONS)?;
    if let Some(reason) = not_compact(input, section) {
        return Err(reason);
    }
    let hinge = HingeSlenderness::of(section, input.height(), input.axial_ratio());
    Ok((input.largest_rotation(), limit(&hinge)))
}
