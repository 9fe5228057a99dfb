//! The capacity of a column for Python.

use column_twin::assessment::{AssessmentInput, ResidualCapacity, assess};
use column_twin::column::PushDownPoint;
use column_twin::results::CapacityFields;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::fault;
use crate::values::doubles;

/// Shortening, force and v1 of a push-down.
pub type Curve<'py> = [Bound<'py, PyByteArray>; 3];

/// The capacity of a column in this state as JSON.
pub fn capacity_json(
    state: &str,
    remaining: &ResidualCapacity,
    input: &AssessmentInput,
) -> PyResult<String> {
    let assessment = assess(input);
    serde_json::to_string(&CapacityFields::of(state, remaining, &assessment))
        .map_err(|fault| fault::simulation(fault.to_string()))
}

/// The points of a push-down as arrays.
pub fn curve<'py>(py: Python<'py>, points: &[PushDownPoint]) -> PyResult<Curve<'py>> {
    let column = |value: fn(&PushDownPoint) -> f64| {
        let values: Vec<f64> = points.iter().map(value).collect();
        doubles(py, &values)
    };
    Ok([
        column(|point| point.shortening)?,
        column(|point| point.force)?,
        column(|point| point.v1)?,
    ])
}
