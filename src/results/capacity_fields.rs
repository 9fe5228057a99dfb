//! The capacity of a column under the names that programs see.

use serde::Serialize;

use crate::assessment::{
    Action, Assessment, Criterion, MissingData, PARTIAL_FACTOR, ResidualCapacity,
};
use crate::column::CapacityEnd;
use crate::parameters::LoadBasis;

/// The capacity of a column for programs, in SI units; the names are a stable interface. A value that does not exist is null.
#[derive(Debug, Serialize)]
pub struct CapacityFields<'a> {
    state: &'a str,
    undamaged_capacity_n: f64,
    undamaged_end: CapacityEnd,
    residual_capacity_n: f64,
    residual_end: CapacityEnd,
    lower_bound: bool,
    capacity_ratio: f64,
    damage: f64,
    carried_load_n: f64,
    load: &'a str,
    load_basis: LoadBasis,
    gamma_m: f64,
    axial_capacity_n: f64,
    reserve: Option<f64>,
    imperfection_m: f64,
    v1_at_undamaged_capacity_m: f64,
    v1_at_residual_capacity_m: f64,
    strong_axis_resistance_n: f64,
    weak_axis_resistance_n: Option<f64>,
    remaining_resistance_n: Option<f64>,
    action: Action,
    at_least: bool,
    deciding_criterion: &'a str,
    reason: &'a str,
    not_evaluated: &'a [MissingData],
    criteria: &'a [Criterion],
}

impl<'a> CapacityFields<'a> {
    /// The fields of these results; `state` tells what has happened to the column.
    #[must_use]
    pub fn of(state: &'a str, remaining: &ResidualCapacity, assessment: &'a Assessment) -> Self {
        Self {
            state,
            undamaged_capacity_n: remaining.undamaged.force,
            undamaged_end: remaining.undamaged.end,
            residual_capacity_n: remaining.now.force,
            residual_end: remaining.now.end,
            lower_bound: remaining.now.is_lower_bound() || remaining.undamaged.is_lower_bound(),
            capacity_ratio: remaining.ratio,
            damage: remaining.damage,
            carried_load_n: remaining.carried_load,
            load: &assessment.load,
            load_basis: assessment.load_basis,
            gamma_m: PARTIAL_FACTOR,
            axial_capacity_n: remaining.axial_capacity,
            reserve: remaining.reserve,
            imperfection_m: remaining.undamaged.imperfection,
            v1_at_undamaged_capacity_m: remaining.undamaged.v1,
            v1_at_residual_capacity_m: remaining.now.v1,
            strong_axis_resistance_n: remaining.strong.force,
            weak_axis_resistance_n: remaining.weak.map(|weak| weak.force),
            remaining_resistance_n: remaining.resistance,
            action: assessment.action,
            at_least: assessment.at_least,
            deciding_criterion: assessment.deciding_criterion,
            reason: &assessment.reason,
            not_evaluated: &assessment.not_evaluated,
            criteria: &assessment.criteria,
        }
    }
}
