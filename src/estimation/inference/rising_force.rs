//! How the readings of the bars differ from those of the fibre beam under a soft front.
//!
//! A soft front prescribes a force. As long as the column is elastic, bars and beam answer it linearly, so that one response of each to a
//! force that rises at a steady rate tells the difference under any curve of force over crush: a bend of the curve is another such force,
//! which begins later, because the vehicle is hardly slowed down at first.

use crate::column::{Impact, Model, Vehicle};
use crate::estimation::inference::beam_readings::{BeamReadings, Factors, PERIOD};
use crate::estimation::inference::hypothesis::{ImpactPoint, loaded_along};
use crate::estimation::inference::lanes::{Lanes, WIDTH, lanes};
use crate::estimation::inference::prediction::{Prediction, TimeGrid};
use crate::parameters::Parameters;
use crate::sensors::{Quantity, Sensor};
use crate::standing::StandingColumn;

/// Time after contact from which on the readings are no longer corrected \[s\]: the difference is small then beside the reading.
const UNTIL: f64 = 20e-3;

/// The front by which it is found out: its stiffness relative to that of the column, and the mass \[kg\] and the speed \[m/s\] of the vehicle.
/// The column moves by a tenth of a millimetre and remains elastic.
const STIFFNESS: f64 = 1e-3;
const MASS: f64 = 1e5;
const SPEED: f64 = 5.0;

/// As the parameters describe the column.
const AS_DESCRIBED: Factors = Factors {
    yield_strength: 1.0,
    young_modulus: 1.0,
    density: 1.0,
    load: 1.0,
};

/// The difference, for the sensors of one column.
#[derive(Debug, Clone)]
pub(crate) struct RisingForce {
    /// Integral over time of what the beam reads more than the bars, by the rate of the force, at each edge of the grid up to [`UNTIL`] and
    /// for each group of sensors.
    integrals: Vec<Vec<Lanes>>,
    /// For each sensor whether it is corrected.
    corrected: Vec<bool>,
}

impl RisingForce {
    /// By the undamaged column, whose elastic response is about that of a damaged one. `None` where bars or beam do not follow the force.
    pub fn new(
        beam: &BeamReadings,
        parameters: &Parameters,
        sensors: &[Sensor],
        grid: &TimeGrid,
    ) -> Option<Self> {
        let column = StandingColumn::undamaged(parameters);
        let properties = column.properties(parameters);
        let stiffness = STIFFNESS * Model::new(&properties).ok()?.transverse_stiffness();
        let vehicle = Vehicle::new(&[MASS], &[loaded_along(&[[1.0, stiffness]])?]).ok()?;
        let impact = Impact {
            vehicle: Some(vehicle),
            ..Impact::rigid(MASS, SPEED)
        };
        let unlimited: Vec<Sensor> = sensors
            .iter()
            .map(|it| Sensor {
                range: 0.0,
                ..it.clone()
            })
            .collect();
        let by_bars = Prediction::compute(&column, &properties, &impact, &unlimited, grid)?;
        let rows = (UNTIL / PERIOD).round() as usize;
        let by_beam = beam.follow(&impact, AS_DESCRIBED, rows)?;
        let mut corrected = vec![false; sensors.len()];
        let rate = stiffness * SPEED;
        let edges = grid.edges().iter().copied();
        let edges: Vec<f64> = edges.take_while(|edge| *edge <= UNTIL).collect();
        let mut integrals = vec![lanes(sensors.len()); edges.len()];
        // Its accelerations are those of waves, of which a mean tells little.
        let each = beam.sensors().enumerate();
        for (place, sensor) in
            each.filter(|(_, it)| sensors[*it].quantity != Quantity::Acceleration)
        {
            corrected[sensor] = true;
            let (mut sum, mut last, mut row) = (0.0, 0.0, 0);
            for (edge, integrals) in edges.iter().zip(&mut integrals) {
                while (row as f64 + 0.5) * PERIOD < *edge {
                    let next = by_beam[row][place];
                    sum += 0.5 * PERIOD * (last + next);
                    (last, row) = (next, row + 1);
                }
                let of_bars = by_bars.integral(sensor, grid.place(*edge));
                integrals[sensor / WIDTH][sensor % WIDTH] = (sum - of_bars) / rate;
            }
        }
        Some(Self {
            integrals,
            corrected,
        })
    }

    /// Whether the readings of a sensor are corrected.
    pub fn corrects(&self, sensor: usize) -> bool {
        self.corrected[sensor]
    }

    /// Corrects what the sensors read of an impact by a soft front.
    pub fn correct(
        &self,
        prediction: &mut Prediction,
        grid: &TimeGrid,
        impact: &Impact,
        point: &ImpactPoint,
    ) {
        let Some(spring) = impact.vehicle.as_ref().and_then(|it| it.springs().first()) else {
            return;
        };
        let (mut begin, mut last_slope) = ([0.0; 2], 0.0);
        for &[crush, force] in spring.envelope.points() {
            let slope = (force - begin[1]) / (crush - begin[0]);
            let since = begin[0] / impact.velocity;
            // A stiff front does not prescribe the force, but the motion.
            let rate = (slope - last_slope) / (1.0 + slope.max(0.0) / point.stiffness);
            let rate = rate * impact.velocity;
            if !(slope.is_finite() && since < UNTIL) {
                return;
            }
            prediction.add(
                grid,
                |edge, group| self.integral(grid, edge - since, group),
                rate,
            );
            (begin, last_slope) = ([crush, force], slope);
        }
    }

    /// The integral up to a time \[s\] of the sensors of one group.
    fn integral(&self, grid: &TimeGrid, time: f64, group: usize) -> Lanes {
        let (index, share) = grid.place(time).between();
        let last = self.integrals.len() - 1;
        let [a, b] = [index, index + 1].map(|edge| self.integrals[edge.min(last)][group]);
        std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
    }
}
