//! What engineers call the criteria, and what it means in plain words that one is exceeded.

/// The wording of one criterion.
#[derive(Debug, Clone, Copy)]
pub(super) struct CheckName {
    /// Name of the criterion, as in the parameter `assessment.criteria`.
    criterion: &'static str,
    /// What engineers call it.
    pub name: &'static str,
    /// The cause of the action if it is exceeded, as a part of a sentence.
    pub cause: &'static str,
}

const fn named(criterion: &'static str, name: &'static str, cause: &'static str) -> CheckName {
    CheckName {
        criterion,
        name,
        cause,
    }
}

const NAMES: &[CheckName] = &[
    named(
        "collapse",
        "Stability during the hit",
        "the column collapses or fractures during the hit and carries nothing",
    ),
    named(
        "ultimate_rotation",
        "Plastic rotation: section fractures",
        "the section is bent so far that it tears",
    ),
    named(
        "ultimate_shear_angle",
        "Plastic shear of the web: web fractures",
        "the web is sheared so far that it tears",
    ),
    named(
        "capacity_reserve_1",
        "Buckling resistance left, strong axis, over the load",
        "the buckling resistance that is left is smaller than the load",
    ),
    named(
        "remaining_resistance",
        "Buckling resistance left, weaker axis, over the load",
        "the buckling resistance that is left about the weaker axis is smaller than the load",
    ),
    named(
        "damage_80",
        "Axial resistance lost: collapse",
        "more than 80 % of the axial resistance is lost",
    ),
    named(
        "capacity_reserve_1_5",
        "Buckling resistance left, strong axis, with a reserve of 1.5",
        "the buckling resistance that is left is less than 1.5 times the load",
    ),
    named(
        "remaining_resistance_1_5",
        "Buckling resistance left, weaker axis, with a reserve of 1.5",
        "the buckling resistance that is left about the weaker axis is less than 1.5 times the load",
    ),
    named(
        "residual_bow_100",
        "Residual bow over the height: resistance not reliable",
        "the column stays bent so far that its buckling resistance must not be relied on",
    ),
    named(
        "capping_rotation",
        "Plastic rotation: local buckling",
        "the section is bent so far that its plates buckle and its resistance falls",
    ),
    named(
        "damage_50",
        "Axial resistance lost: high damage",
        "more than half of the axial resistance is lost",
    ),
    named(
        "residual_bow_250",
        "Residual bow of the bent part: buckling curves do not hold",
        "the column stays bent further than the buckling curves allow for",
    ),
    named(
        "damage_20",
        "Axial resistance lost: medium damage",
        "more than a fifth of the axial resistance is lost",
    ),
    named(
        "residual_bow_750",
        "Residual bow of the bent part: tolerance of erection",
        "the column is no longer as straight as it has to be erected",
    ),
    named(
        "plastic_flow",
        "Yielding in bending",
        "the steel has yielded in bending",
    ),
    named(
        "base_anchors_1_3",
        "Base anchors, failed",
        "the anchors of the base no longer hold the column",
    ),
    named(
        "base_shear",
        "Base, shear: anchors and friction",
        "the shear force exceeds the resistance of the base plate's anchors",
    ),
    named(
        "base_moment",
        "Base, moment: plate, anchors, concrete",
        "the moment exceeds the resistance of the base plate",
    ),
    named(
        "base_uplift",
        "Base, uplift: anchors in tension",
        "the base is lifted with more force than its anchors bear",
    ),
    named(
        "shear_flow",
        "Yielding of the web in shear",
        "the web has yielded in shear",
    ),
    named(
        "asce41_cp",
        "Plastic rotation: collapse prevention (seismic)",
        "the rotation exceeds collapse prevention of ASCE 41",
    ),
    named(
        "asce41_ls",
        "Plastic rotation: life safety (seismic)",
        "the rotation exceeds life safety of ASCE 41",
    ),
    named(
        "asce41_io",
        "Plastic rotation: immediate occupancy (seismic)",
        "the rotation exceeds immediate occupancy of ASCE 41",
    ),
    named(
        "aisc342_cp",
        "Plastic rotation: collapse prevention (seismic)",
        "the rotation exceeds collapse prevention of AISC 342",
    ),
    named(
        "aisc342_ls",
        "Plastic rotation: life safety (seismic)",
        "the rotation exceeds life safety of AISC 342",
    ),
    named(
        "aisc342_io",
        "Plastic rotation: immediate occupancy (seismic)",
        "the rotation exceeds immediate occupancy of AISC 342",
    ),
    named(
        "support_rotation_20",
        "Rotation at the supports: failure (blast)",
        "the bars turn so far at their supports that blast practice expects failure",
    ),
    named(
        "support_rotation_10",
        "Rotation at the supports: heavy damage (blast)",
        "the bars turn so far at their supports that blast practice expects heavy damage",
    ),
    named(
        "support_rotation_3",
        "Rotation at the supports: moderate damage (blast)",
        "the bars turn so far at their supports that blast practice expects moderate damage",
    ),
    named(
        "crush_force",
        "Strength of the vehicle's front over that of the column",
        "the vehicle's front is stronger than the column",
    ),
    named(
        "equivalent_static_force",
        "Equivalent static force of the impact",
        "the equivalent static force of the impact exceeds the plastic resistance of the column",
    ),
    named(
        "table_4_1_motorway",
        "Design force of a motorway",
        "the design force of a motorway exceeds the plastic resistance of the column",
    ),
    named(
        "table_4_1_rural",
        "Design force of a rural road",
        "the design force of a rural road exceeds the plastic resistance of the column",
    ),
    named(
        "table_4_1_urban",
        "Design force of an urban road",
        "the design force of an urban road exceeds the plastic resistance of the column",
    ),
    named(
        "table_4_1_courtyard_lorry",
        "Design force of a courtyard, lorries",
        "the design force of lorries in a courtyard exceeds the plastic resistance of the column",
    ),
    named(
        "table_4_1_courtyard_car",
        "Design force of a courtyard, cars",
        "the design force of cars in a courtyard exceeds the plastic resistance of the column",
    ),
];

impl CheckName {
    /// What is compared with the limit, without what it means to exceed it.
    pub fn quantity(&self) -> &'static str {
        self.name.split(": ").next().unwrap_or(self.name)
    }
}

/// The wording of the criterion of this name.
pub(super) fn check_name(criterion: &'static str) -> CheckName {
    let found = NAMES.iter().find(|it| it.criterion == criterion);
    found.copied().unwrap_or(named(
        criterion,
        criterion,
        "a limit of the checks is exceeded",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::CRITERION_NAMES;

    /// No report names a check by an identifier.
    #[test]
    fn every_criterion_has_a_name_that_people_use() {
        for criterion in CRITERION_NAMES {
            let found = check_name(criterion);
            assert!(
                !found.name.contains('_') && found.name != *criterion,
                "{criterion}"
            );
            assert!(
                found.cause.len() > 20 && !found.cause.ends_with('.'),
                "{criterion}"
            );
        }
        for (index, it) in NAMES.iter().enumerate() {
            assert!(CRITERION_NAMES.contains(&it.criterion), "{}", it.criterion);
            assert!(
                NAMES[..index]
                    .iter()
                    .all(|before| before.criterion != it.criterion)
            );
        }
    }
}
