//! What sensors read in a simulated impact, with their errors.

use crate::column::{ColumnProperties, Impact, Model, Progress, Response, SimulationError, State};
use crate::estimation::intake::readings::Readings;
use crate::estimation::simulation::probe::{Rest, SteppedProbe};
use crate::numerics::Random;
use crate::sensors::Sensor;

/// Time before the event during which the sensors read the column at rest \[s\].
const LEAD: f64 = 0.1;

/// Time after the end of the response during which they read it again \[s\].
const TAIL: f64 = 0.05;

/// What the sensors read during an impact on the undamaged column that is followed for at most `max_duration` \[s\], from
/// 0.1 s before the event, which is at time 0. Gain errors and biases are drawn once for each sensor, noise for each
/// sample; the same seed gives the same readings.
///
/// Each reading passes, in this order: the sign, the filter against aliasing (Butterworth, second order), gain error and
/// bias, noise, clipping.
///
/// # Errors
/// As [`simulate`](crate::column::simulate).
pub fn simulate_sensors(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
    sensors: &[Sensor],
    seed: u64,
) -> Result<Readings, SimulationError> {
    let model = Model::new(&properties.before(impact))?;
    let secs = 1e-9 * model.properties.step_nanos as f64;
    let mut state = State::at_rest(&model);
    let mut random = Random::new(seed);
    let mut channels: Vec<_> = sensors
        .iter()
        .map(|sensor| Channel::new(&model, &state, sensor, secs, &mut random))
        .collect();
    let mut samples: Vec<Sampled> = Vec::new();
    let mut response = Response::begin(&model, &mut state, *impact, max_duration)?;
    let mut over_since = None;
    let mut step = 0_u64;
    for (sensor, channel) in channels.iter_mut().enumerate() {
        while channel.next_time() < 0.0 {
            channel.take(sensor, 0.0, &mut random, &mut samples);
        }
    }
    loop {
        if over_since.is_none()
            && let Progress::Over(end) = response.advance(&model, &mut state, 1)?
        {
            over_since = Some(step);
            let rest = Rest::after(&model, &state, end, State::at_rest);
            for channel in &mut channels {
                channel.probe.settle(&state, channel.sensor, rest.as_ref());
            }
        }
        step += 1;
        let time = step as f64 * secs;
        for (sensor, channel) in channels.iter_mut().enumerate() {
            channel.advance(&state, secs);
            while channel.next_time() <= time {
                let filtered = channel.at(time, secs);
                channel.take(sensor, filtered, &mut random, &mut samples);
            }
        }
        if over_since.is_some_and(|since| (step - since) as f64 * secs >= TAIL) {
            return Ok(table(samples, sensors.len()));
        }
    }
}

/// What the sensors read where `exact` holds the readings without errors, row by row, in the order of the sensors: with gain errors and
/// biases that are drawn once for each sensor, noise for each sample, and clipping. The same seed gives the same readings.
#[must_use]
pub fn with_sensor_errors(exact: &Readings, sensors: &[Sensor], seed: u64) -> Readings {
    let mut random = Random::new(seed);
    let errors: Vec<_> = sensors
        .iter()
        .map(|sensor| Errors::draw(sensor, &mut random))
        .collect();
    let mut readings = exact.clone();
    for row in readings.values.chunks_exact_mut(sensors.len().max(1)) {
        for (value, (errors, sensor)) in row.iter_mut().zip(errors.iter().zip(sensors)) {
            *value = errors.reading(sensor, *value, &mut random);
        }
    }
    readings
}

/// The errors of a sensor that stay.
struct Errors {
    gain: f64,
    bias: f64,
}

impl Errors {
    fn draw(sensor: &Sensor, random: &mut Random) -> Self {
        Self {
            gain: 1.0 + sensor.gain_error * random.normal(),
            bias: sensor.bias * random.normal(),
        }
    }

    /// What the sensor reads of an exact value.
    fn reading(&self, sensor: &Sensor, exact: f64, random: &mut Random) -> f64 {
        sensor.clipped(self.gain * exact + self.bias + sensor.noise * random.normal())
    }
}

/// A sample of one sensor.
struct Sampled {
    time: f64,
    sensor: usize,
    value: f64,
}

/// Rows of the samples that share a time.
fn table(mut samples: Vec<Sampled>, sensors: usize) -> Readings {
    samples.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.sensor.cmp(&b.sensor)));
    let mut readings = Readings {
        sensors,
        ..Readings::default()
    };
    for sample in samples {
        if readings.times.last() != Some(&sample.time) {
            readings.times.push(sample.time);
            let length = readings.values.len() + sensors;
            readings.values.resize(length, f64::NAN);
        }
        let row = readings.values.len() - sensors;
        readings.values[row + sample.sensor] = sample.value;
    }
    readings
}

struct Channel<'a> {
    sensor: &'a Sensor,
    probe: SteppedProbe,
    filter: LowPass,
    /// Filtered reading at the last step and at the one before.
    filtered: [f64; 2],
    errors: Errors,
    /// Number of the next sample; 0 is at the event.
    next: i64,
}

impl<'a> Channel<'a> {
    fn new(
        model: &Model,
        state: &State,
        sensor: &'a Sensor,
        secs: f64,
        random: &mut Random,
    ) -> Self {
        Self {
            sensor,
            probe: SteppedProbe::new(model, state, sensor),
            filter: LowPass::new(sensor.bandwidth, secs),
            filtered: [0.0; 2],
            errors: Errors::draw(sensor, random),
            next: -((LEAD * sensor.rate).round() as i64),
        }
    }

    fn next_time(&self) -> f64 {
        self.next as f64 / self.sensor.rate
    }

    /// Reads the column after a step.
    fn advance(&mut self, state: &State, secs: f64) {
        let reading = self.probe.read(state, secs);
        self.filtered = [self.filter.next(reading), self.filtered[0]];
    }

    /// The filtered reading at the next sample, which lies in the step that ends at `time`.
    fn at(&self, time: f64, secs: f64) -> f64 {
        let share = ((time - self.next_time()) / secs).clamp(0.0, 1.0);
        self.filtered[0] + share * (self.filtered[1] - self.filtered[0])
    }

    fn take(
        &mut self,
        sensor: usize,
        filtered: f64,
        random: &mut Random,
        samples: &mut Vec<Sampled>,
    ) {
        samples.push(Sampled {
            time: self.next_time(),
            sensor,
            value: self.errors.reading(self.sensor, filtered, random),
        });
        self.next += 1;
    }
}

/// A Butterworth filter of the second order, by the bilinear transform.
struct LowPass {
    b: f64,
    a: [f64; 2],
    input: [f64; 2],
    output: [f64; 2],
}

impl LowPass {
    fn new(bandwidth: f64, secs: f64) -> Self {
        // A filter close to the rate of the steps passes what the steps resolve.
        let turn = (std::f64::consts::PI * bandwidth * secs).min(1.5);
        let k = libm::tan(turn);
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
        Self {
            b: k * k * norm,
            a: [
                2.0 * (k * k - 1.0) * norm,
                (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm,
            ],
            input: [0.0; 2],
            output: [0.0; 2],
        }
    }

    fn next(&mut self, input: f64) -> f64 {
        let [first, second] = self.input;
        let output = self.b * (input + 2.0 * first + second)
            - self.a[0] * self.output[0]
            - self.a[1] * self.output[1];
        self.input = [input, first];
        self.output = [output, self.output[0]];
        output
    }
}
