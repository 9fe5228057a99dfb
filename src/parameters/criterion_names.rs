//! The names of the criteria of an assessment, among which `assessment.criteria` chooses.

/// Names of the criteria of an assessment; `docs/assessment.md` describes them.
pub const CRITERION_NAMES: &[&str] = &[
    "collapse",
    "ultimate_rotation",
    "ultimate_shear_angle",
    "capacity_reserve_1",
    "remaining_resistance",
    "damage_80",
    "capacity_reserve_1_5",
    "remaining_resistance_1_5",
    "residual_bow_100",
    "capping_rotation",
    "damage_50",
    "residual_bow_250",
    "damage_20",
    "residual_bow_750",
    "plastic_flow",
    "base_anchors_1_3",
    "base_shear",
    "base_moment",
    "base_uplift",
    "shear_flow",
    "asce41_cp",
    "asce41_ls",
    "asce41_io",
    "aisc342_cp",
    "aisc342_ls",
    "aisc342_io",
    "support_rotation_20",
    "support_rotation_10",
    "support_rotation_3",
    "crush_force",
    "equivalent_static_force",
    "table_4_1_motorway",
    "table_4_1_rural",
    "table_4_1_urban",
    "table_4_1_courtyard_lorry",
    "table_4_1_courtyard_car",
];

/// The criteria that decide the action unless the user chooses others: the first twenty, to `shear_flow`.
pub const DEFAULT_CRITERIA: &[&str] = CRITERION_NAMES.split_at(20).0;

// A criterion that is inserted must not change which ones decide.
const LAST: &str = DEFAULT_CRITERIA[DEFAULT_CRITERIA.len() - 1];
const _: () = assert!(matches!(LAST.as_bytes(), b"shear_flow"));
