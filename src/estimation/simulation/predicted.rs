//! What one impact lets the sensors read, to be seen beside what they have read.

use crate::column::Impact;
use crate::estimation::inference::library::corrected_sensors;
use crate::estimation::inference::prediction::{HORIZON, Prediction, TimeGrid};
use crate::parameters::Parameters;
use crate::standing::StandingColumn;

/// Readings are averaged over this time before they are compared by eye \[s\]: the vibrations of the first milliseconds, whose phase
/// no simple model knows, would hide everything else.
pub const AVERAGED_OVER: f64 = 1e-3;

/// What the sensors of these parameters read of an impact on the column at rest, for each sensor: means over [`AVERAGED_OVER`], one
/// after another from contact on. The signs are those of batches, and the readings relative to the column before the impact.
/// `None` if the response cannot be computed.
#[must_use]
pub fn predicted_means(
    column: &StandingColumn,
    parameters: &Parameters,
    impact: &Impact,
) -> Option<Vec<Vec<f64>>> {
    let sensors = corrected_sensors(parameters);
    let (properties, grid) = (column.properties(parameters), TimeGrid::new());
    let prediction = Prediction::compute(column, &properties, impact, &sensors, &grid)?;
    let count = (HORIZON / AVERAGED_OVER).round() as usize;
    let means = |sensor: usize| {
        let integral =
            |cell: usize| prediction.integral(sensor, grid.place(cell as f64 * AVERAGED_OVER));
        let each = (0..count).map(|cell| (integral(cell + 1) - integral(cell)) / AVERAGED_OVER);
        each.collect()
    };
    Some((0..sensors.len()).map(means).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::simulate_sensors;
    use crate::parameters::Value;

    /// The means of what the simulation of sensors without errors gives, which steps and filters on its own.
    #[test]
    fn the_means_are_those_of_simulated_readings() {
        let values: [(&str, Value); 9] = [
            ("impact.gap", 0.0.into()),
            (
                "sensors.names",
                vec!["laser".to_owned(), "strain".to_owned()].into(),
            ),
            ("sensors.laser.quantity", "displacement".into()),
            ("sensors.laser.height", 1.0.into()),
            ("sensors.laser.rate", 1e4.into()),
            ("sensors.strain.quantity", "bending_strain".into()),
            ("sensors.strain.height", 0.1.into()),
            ("sensors.strain.rate", 1e4.into()),
            ("sensors.strain.sign", (-1_i64).into()),
        ];
        let parameters = Parameters::from_values(values).expect("admissible");
        let impact = Impact::rigid(1500.0, 5.0);
        let column = StandingColumn::undamaged(&parameters);
        let predicted = predicted_means(&column, &parameters, &impact).expect("a response");
        let sensors = corrected_sensors(&parameters);
        let properties = parameters.column_properties();
        let readings = simulate_sensors(&properties, &impact, 0.1, &sensors, 1).expect("simulated");
        for (sensor, means) in predicted.iter().enumerate() {
            assert_eq!(means.len(), 500);
            let largest = means.iter().fold(0.0, |most: f64, it| most.max(it.abs()));
            for cell in [2, 5, 10, 20, 40] {
                let inside = readings.rows().filter(|(time, _)| {
                    let since = time / AVERAGED_OVER - f64::from(cell as u16);
                    (1e-6..1.0 + 1e-6).contains(&since)
                });
                let values: Vec<f64> = inside.map(|(_, values)| values[sensor]).collect();
                assert_eq!(values.len(), 10);
                let mean = values.iter().sum::<f64>() / 10.0;
                let off = (means[cell] - mean).abs() / largest;
                assert!(off < 0.02, "sensor {sensor}, cell {cell}: {off}");
            }
        }
    }
}
