//! Damage maps and critical velocities for Python.

use std::num::NonZeroUsize;

use column_twin::parameters::Parameters;
use column_twin::study::{
    AxisValue, AxisValues, CriticalVelocity, DamageMap, MapAxis, MapError, MapQuantity,
};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::batch::{Codes, NUMBERS, ROW_BYTES, Row, batch, interruptible};
use crate::fault;

/// An axis as Python gives it: in the notation of the command line, or as a name with its values.
#[derive(FromPyObject)]
pub enum GivenAxis {
    /// `velocity=1:25:100`
    Text(String),
    /// A range: name, from, to, number of points.
    Range(String, f64, f64, u64),
    /// Numbers.
    Numbers(String, Vec<f64>),
    /// Names of a catalogue.
    Names(String, Vec<String>),
}

impl GivenAxis {
    pub fn axis(self) -> PyResult<MapAxis> {
        let quantity = |name: &str| {
            MapQuantity::named(name).map_err(|problem| fault::input(format!("{name}: {problem}")))
        };
        let axis = match self {
            Self::Text(text) => MapAxis::parse(&text),
            Self::Range(name, from, to, count) => MapAxis::range(quantity(&name)?, from, to, count),
            Self::Numbers(name, numbers) => {
                MapAxis::of(quantity(&name)?, AxisValues::Numbers(numbers))
            }
            Self::Names(name, names) => MapAxis::of(quantity(&name)?, AxisValues::Names(names)),
        };
        axis.map_err(|fault| fault::input(fault.to_string()))
    }
}

/// An axis for Python: name, title, unit, and its numbers or names.
fn described<'py>(py: Python<'py>, axis: &MapAxis) -> PyResult<Bound<'py, PyDict>> {
    let quantity = axis.quantity();
    let all = PyDict::new(py);
    all.set_item("name", quantity.name())?;
    all.set_item("title", quantity.title())?;
    all.set_item("unit", quantity.unit())?;
    let values = (0..axis.len()).map(|index| axis.value(index));
    if quantity.is_named() {
        let names: Vec<String> = values.map(|value| value.to_string()).collect();
        all.set_item("values", names)?;
    } else {
        let number = |value| match value {
            AxisValue::Number(number) => number,
            AxisValue::Name(_) => f64::NAN,
        };
        all.set_item("values", values.map(number).collect::<Vec<f64>>())?;
    }
    Ok(all)
}

/// Computes a map: its axes and labels, its cells as rows of bytes, and why some could not be computed.
pub fn map<'py>(
    py: Python<'py>,
    parameters: &Parameters,
    vehicle: Option<&str>,
    axes: [GivenAxis; 2],
    compared: Option<GivenAxis>,
    threads: Option<NonZeroUsize>,
) -> PyResult<Bound<'py, PyDict>> {
    let [first, second] = axes;
    let axes = [first.axis()?, second.axis()?];
    let compared = compared.map(GivenAxis::axis).transpose()?;
    let map = match &compared {
        Some(compared) => DamageMap::comparing(parameters, vehicle, compared, axes),
        None => DamageMap::new(parameters, vehicle, axes),
    };
    let map = map.map_err(|reason| rejected(&reason))?;
    let batch = batch(py, threads, map.len())?;
    let table = interruptible(py, &batch, |batch| map.table(batch))?;
    let table = table.map_err(|reason| fault::no_threads(&reason))?;

    let result = PyDict::new(py);
    result.set_item("rows", described(py, map.rows())?)?;
    result.set_item("columns", described(py, map.columns())?)?;
    let labels: Vec<&str> = map.variants().iter().map(|it| it.label.as_str()).collect();
    result.set_item("labels", labels)?;
    let failures = PyDict::new(py);
    for (index, result) in table.result.iter().enumerate() {
        if let Err(reason) = result {
            failures.set_item(index, reason)?;
        }
    }
    result.set_item("failures", failures)?;
    let bytes = PyByteArray::new_with(py, ROW_BYTES * table.result.len(), |bytes| {
        let (chunks, _) = bytes.as_chunks_mut::<ROW_BYTES>();
        for (chunk, result) in chunks.iter_mut().zip(&table.result) {
            let row = match result {
                // Mass and velocity are those of the axes.
                Ok(evaluation) => Row::of([f64::NAN; 2], evaluation),
                Err(_) => Row {
                    numbers: [f64::NAN; NUMBERS],
                    codes: Codes::UNKNOWN,
                },
            };
            row.write(chunk);
        }
        Ok(())
    })?;
    result.set_item("cells", bytes)?;
    Ok(result)
}

fn rejected(reason: &MapError) -> PyErr {
    match reason {
        MapError::Parameters(faults) => fault::parameters(faults),
        other => fault::input(other.to_string()),
    }
}

/// The velocities around a critical one: the largest below it and the smallest above it that were computed \[m/s\].
pub fn bracket(velocity: CriticalVelocity) -> (Option<f64>, Option<f64>) {
    match velocity {
        CriticalVelocity::Between { below, at } => (Some(below), Some(at)),
        CriticalVelocity::AtMost { lowest } => (None, Some(lowest)),
        CriticalVelocity::Above { highest } => (Some(highest), None),
    }
}
