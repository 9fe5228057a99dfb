//! The capacity of a column under the names that programs see.

use serde::Serialize;

use crate::assessment::{
    Action, Assessment, Criterion, MissingData, PARTIAL_FACTOR, ResidualCapacity,
};
use crate::column::CapacityEnd;
use crate::parameters::LoadBasis;

fields! {
    /// The capacity of a column for programs, in SI units; the names are a stable interface. A value that does not exist is null. The
    /// state tells what has happened to the column.
    pub struct CapacityFields<'a> of(state_of_column: &'a str, remaining: &ResidualCapacity, assessment: &'a Assessment) {}
    state: &'a str = state_of_column;
    undamaged_capacity_n: f64 = remaining.undamaged.force;
    undamaged_end: CapacityEnd = remaining.undamaged.end;
    residual_capacity_n: f64 = remaining.now.force;
    residual_end: CapacityEnd = remaining.now.end;
    lower_bound: bool = remaining.now.is_lower_bound() || remaining.undamaged.is_lower_bound();
    capacity_ratio: f64 = remaining.ratio;
    damage: f64 = remaining.damage;
    carried_load_n: f64 = remaining.carried_load;
    load: &'a str = &assessment.load;
    load_basis: LoadBasis = assessment.load_basis;
    gamma_m: f64 = PARTIAL_FACTOR;
    axial_capacity_n: f64 = remaining.axial_capacity;
    reserve: Option<f64> = remaining.reserve;
    imperfection_m: f64 = remaining.undamaged.imperfection;
    v1_at_undamaged_capacity_m: f64 = remaining.undamaged.v1;
    v1_at_residual_capacity_m: f64 = remaining.now.v1;
    strong_axis_resistance_n: f64 = remaining.strong.force;
    weak_axis_resistance_n: Option<f64> = remaining.weak.map(|weak| weak.force);
    remaining_resistance_n: Option<f64> = remaining.resistance;
    action: Action = assessment.action;
    at_least: bool = assessment.at_least;
    deciding_criterion: &'a str = assessment.deciding_criterion;
    reason: &'a str = &assessment.reason;
    not_evaluated: &'a [MissingData] = &assessment.not_evaluated;
    criteria: &'a [Criterion] = &assessment.criteria;
}
