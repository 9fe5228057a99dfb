//! What the sensors of a column read, and what struck it by their readings.

use column_twin::column::Impact;
use column_twin::estimation::{Readings, estimate_recorded, simulate_sensors};
use column_twin::parameters::Parameters;
use pyo3::prelude::*;

use crate::batch::abandonable;
use crate::fault;

/// The readings of the sensors in a simulated impact, as the table that `column-twin simulate --readings` writes.
pub fn readings(
    py: Python<'_>,
    parameters: &Parameters,
    impact: Impact,
    seed: u64,
) -> PyResult<String> {
    let sensors = parameters.sensors();
    if sensors.is_empty() {
        return Err(no_sensors());
    }
    let properties = parameters.column_properties();
    let duration = parameters.response_duration();
    abandonable(py, move || {
        let readings = simulate_sensors(&properties, &impact, duration, &sensors, seed)
            .map_err(|reason| fault::of_simulation(&reason))?;
        let mut table = Vec::new();
        readings
            .write_csv(&mut table, &sensors)
            .map_err(|reason| fault::simulation(reason.to_string()))?;
        String::from_utf8(table).map_err(|reason| fault::simulation(reason.to_string()))
    })?
}

/// What struck the column by the readings of its sensors: the estimates as JSON, the last one by all readings; `None` without an
/// impact.
pub fn estimate(
    py: Python<'_>,
    parameters: &Parameters,
    table: String,
    seed: u64,
) -> PyResult<Option<String>> {
    let sensors = parameters.sensors();
    if sensors.is_empty() {
        return Err(no_sensors());
    }
    let parameters = parameters.clone();
    let estimated = abandonable(py, move || {
        let readings = Readings::from_csv(table.as_bytes(), &sensors)
            .map_err(|reason| fault::input(reason.to_string()))?;
        estimate_recorded(&parameters, &sensors, &readings, seed, &mut |_| ())
            .map_err(|reason| fault::input(reason.to_string()))
    })??;
    estimated
        .map(|impact| serde_json::to_string(&impact.estimates))
        .transpose()
        .map_err(|reason| fault::simulation(reason.to_string()))
}

fn no_sensors() -> PyErr {
    fault::input(
        "the column has no sensors; expected sensors.names with the parameters of each, such as in config/sensors_industrial.yaml"
            .to_owned(),
    )
}
