//! What each sensor has read, and their prediction by the weighted responses.

use crate::estimation::inference::block_layout::Block;
use crate::estimation::inference::estimate::CredibleInterval;
use crate::estimation::inference::member::Member;
use crate::estimation::inference::model_error::ModelError;
use crate::estimation::inference::prediction::TimeGrid;
use crate::estimation::inference::weighing::Observed;
use crate::sensors::Sensor;

/// What one sensor has read after an impact, and what the responses say that it reads.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorComparison {
    /// Index of the sensor.
    pub sensor: usize,
    /// Whether its readings count for the estimate; those of a sensor that contradicts the others do not.
    pub counts: bool,
    /// Spans of time over which the sensor has read, in their order. Those that the estimate cannot use are not among them.
    pub means: Vec<ComparedMean>,
}

/// The mean of a sensor's readings over a span of time, measured and predicted, in the unit of the sensor and relative to the
/// column at rest before the impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedMean {
    /// Middle of the span, after the detected instant of contact \[s\]; negative before it.
    pub time: f64,
    /// What was measured.
    pub measured: f64,
    /// What is predicted for it, with noise and the model's own error.
    pub predicted: CredibleInterval,
}

/// What the comparison rests on.
pub(crate) struct Compared<'a> {
    pub members: &'a [Member],
    /// Weights of the members, which add up to 1.
    pub weights: &'a [f64],
    pub observed: &'a [Observed],
    pub sensors: &'a [Sensor],
    pub ignored: &'a [bool],
    pub grid: &'a TimeGrid,
}

impl Compared<'_> {
    /// Compares the readings of every sensor.
    pub fn sensors(&self) -> Vec<SensorComparison> {
        (0..self.sensors.len())
            .map(|sensor| SensorComparison {
                sensor,
                counts: !self.ignored[sensor],
                means: self.means(sensor),
            })
            .collect()
    }

    fn means(&self, sensor: usize) -> Vec<ComparedMean> {
        let error = ModelError::of(self.sensors[sensor].quantity);
        let blocks = self.observed.iter();
        blocks
            .filter_map(|(block, means)| {
                let mean = means[sensor]?;
                let time = block.start + 0.5 * block.length;
                let shape = error.deviation(time, &mean);
                let [predicted, variance] = self.predicted(sensor, *block, error);
                let deviation = (variance + shape * shape + mean.variance).sqrt();
                Some(ComparedMean {
                    time,
                    measured: mean.mean,
                    predicted: CredibleInterval::normal(predicted, deviation),
                })
            })
            .collect()
    }

    /// Mean and variance of what the responses predict for a block, with the factor between column and model that the data
    /// suggest for each response. If the sensor does not count, its own data suggest nothing.
    fn predicted(&self, sensor: usize, block: Block, error: ModelError) -> [f64; 2] {
        let prior = 1.0 / (error.scale * error.scale);
        let (mut first, mut second) = (0.0, 0.0);
        let likely = self.members.iter().zip(self.weights);
        for (member, weight) in likely.filter(|(_, weight)| **weight > 0.0) {
            let integral = |time: f64| {
                let place = self.grid.place(time - member.delay);
                member.prediction.integral(sensor, place)
            };
            let end = block.start + block.length;
            let predicted = (integral(end) - integral(block.start)) / block.length;
            let [_, cross, squares] = match self.ignored[sensor] {
                true => [0.0; 3],
                false => member.sums(sensor),
            };
            let information = squares + prior;
            let factor = 1.0 + cross / information;
            first += weight * factor * predicted;
            second += weight * (factor * factor + 1.0 / information) * predicted * predicted;
        }
        [first, (second - first * first).max(0.0)]
    }
}
