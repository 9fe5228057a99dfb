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
    "capping_rotation",
    "damage_50",
    "damage_20",
    "plastic_flow",
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

/// The criteria that decide the severity unless the user chooses others.
pub const DEFAULT_CRITERIA: &[&str] = &[
    "collapse",
    "ultimate_rotation",
    "ultimate_shear_angle",
    "capacity_reserve_1",
    "remaining_resistance",
    "damage_80",
    "capacity_reserve_1_5",
    "capping_rotation",
    "damage_50",
    "damage_20",
    "plastic_flow",
    "shear_flow",
];
