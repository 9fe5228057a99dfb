//! What one conceivable impact would have let the sensors read, and how it would have ended.

use crate::column::{ColumnProperties, End, Impact, Model, Progress, Report, Response, State};
use crate::estimation::inference::lanes::{Lanes, WIDTH, ZERO, lanes};
use crate::estimation::simulation::probe::{Rest, SteppedProbe};
use crate::sensors::Sensor;
use crate::standing::StandingColumn;

/// Time after contact that a prediction covers \[s\].
pub(crate) const HORIZON: f64 = 0.5;

/// Shortest cell of a prediction, and longest time step \[ns\].
const CELL_NANOS: u64 = 100_000;

/// Cells grow with the time after contact, of which they are this share.
const CELL_SHARE: f64 = 0.02;

/// Shortest averaging that a prediction resolves \[s\].
const LEAST_CELL: f64 = 0.5e-3;

/// Times the recommended step by which a response may be stepped here: its error is small beside that of the model.
const STEPS_OF_RECOMMENDED: u64 = 5;

/// Steps grow with the time after contact, too, of which they are this share: readings are compared as means over a fifth of it, up to
/// 10 ms.
const STEP_SHARE: f64 = 0.008;

/// Steps per slowest period of the column at least, once they grow: they follow what a vehicle does to the column, and conserve the energy of
/// its vibration, of which only means are compared by then \[A\].
const STEPS_PER_PERIOD: f64 = 10.0;

/// The instants after contact at which predictions are known \[s\], the same for all of them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TimeGrid {
    edges: Vec<f64>,
    nanos: Vec<u64>,
    /// Whether responses are followed no further than to the last edge.
    is_cut: bool,
}

/// A place between two edges of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    index: usize,
    share: f64,
    /// Time after the last edge \[s\].
    beyond: f64,
}

impl TimeGrid {
    pub fn new() -> Self {
        let mut nanos = vec![0];
        let mut last = 0;
        while (last as f64) < HORIZON * 1e9 {
            let cell = (CELL_SHARE * last as f64).max(LEAST_CELL * 1e9);
            last += (cell / CELL_NANOS as f64).round().max(1.0) as u64 * CELL_NANOS;
            nanos.push(last);
        }
        let edges = nanos.iter().map(|&nanos| 1e-9 * nanos as f64).collect();
        Self {
            edges,
            nanos,
            is_cut: false,
        }
    }

    /// The part of it that readings until an instant \[s\] need: a response is followed until then, and not to its end.
    pub fn until(&self, time: f64) -> Self {
        let needed = self.edges.partition_point(|&edge| edge <= time) + 1;
        match needed < self.edges.len() {
            true => Self {
                edges: self.edges[..needed].to_vec(),
                nanos: self.nanos[..needed].to_vec(),
                is_cut: true,
            },
            false => self.clone(),
        }
    }

    /// The instants \[s\].
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// The place of an instant \[s\]; those before contact are at contact.
    pub fn place(&self, time: f64) -> Place {
        let last = self.edges.len() - 1;
        let time = time.max(0.0);
        if time >= self.edges[last] {
            return Place {
                index: last - 1,
                share: 1.0,
                beyond: time - self.edges[last],
            };
        }
        let index = self.edges.partition_point(|&edge| edge <= time) - 1;
        Place {
            index,
            share: (time - self.edges[index]) / (self.edges[index + 1] - self.edges[index]),
            beyond: 0.0,
        }
    }
}

impl Place {
    /// The edge before it, and which share of the way to the next one it is.
    pub fn between(&self) -> (usize, f64) {
        (self.index, self.share)
    }
}

/// What one impact lets the sensors read, and how it ends.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Prediction {
    /// The integrals of the sensors' readings from contact to each edge of the grid, edge by edge.
    integrals: Vec<Lanes>,
    /// Readings of the sensors after the last edge.
    at_end: Vec<Lanes>,
    /// The column at rest afterwards; `None` if it does not stand, has no equilibrium, or is not followed so far.
    pub rest: Option<Box<State>>,
    pub report: Report,
}

impl Prediction {
    /// Follows an impact on the column, whose properties these are. `None` if they make no column or a step does not converge.
    pub fn compute(
        column: &StandingColumn,
        properties: &ColumnProperties,
        impact: &Impact,
        sensors: &[Sensor],
        grid: &TimeGrid,
    ) -> Option<Self> {
        let mut properties = properties.before(impact);
        let recommended = Model::new(&ColumnProperties {
            step_nanos: 0,
            ..properties
        })
        .ok()?
        .properties
        .step_nanos;
        let parts = CELL_NANOS.div_ceil(STEPS_OF_RECOMMENDED * recommended);
        properties.step_nanos = CELL_NANOS / parts;
        let model = Model::new(&properties).ok()?.solved_roughly();
        let step_nanos = properties.step_nanos;
        let longest = 1e9 * model.slowest_period / STEPS_PER_PERIOD;
        // Steps that are made as one, so long after contact.
        let at_once = |nanos: u64| {
            let nanos = (STEP_SHARE * nanos as f64).min(longest);
            (nanos as u64 / step_nanos).max(1) as u32
        };
        let mut state = column.state(&model);
        let mut probes: Vec<_> = sensors
            .iter()
            .map(|sensor| SteppedProbe::new(&model, &state, sensor))
            .collect();
        let mut last = lanes(sensors.len());
        let mut response = Response::begin(&model, &mut state, *impact, 2.0 * HORIZON).ok()?;
        let mut integrals = Vec::with_capacity(grid.nanos.len() * last.len());
        let mut end = None;
        let mut rest = None;
        let at_rest = |whole: &Model| column.state(whole);
        let mut sums = lanes(sensors.len());
        integrals.extend_from_slice(&sums);
        let mut last_nanos = 0;
        for &edge in &grid.nanos[1..] {
            while last_nanos < edge {
                let left = (edge - last_nanos) / step_nanos;
                let steps = at_once(last_nanos).min(left as u32);
                let nanos = u64::from(steps) * step_nanos;
                let secs = 1e-9 * nanos as f64;
                last_nanos += nanos;
                if end.is_none()
                    && let Progress::Over(over) = response
                        .advance_unobserved(&model, &mut state, steps, u64::MAX)
                        .ok()?
                {
                    end = Some(over);
                    rest = Rest::after(&model, &state, over, at_rest);
                    for (probe, sensor) in probes.iter_mut().zip(sensors) {
                        probe.settle(&state, sensor, rest.as_ref());
                    }
                }
                let each = probes.iter_mut().zip(sensors);
                let readings = last.as_flattened_mut().iter_mut();
                for ((probe, sensor), reading) in each.zip(readings) {
                    *reading = sensor.clipped(probe.read(&state, secs));
                }
                for (sum, reading) in sums.iter_mut().zip(&last) {
                    *sum = std::array::from_fn(|k| sum[k] + secs * reading[k]);
                }
            }
            integrals.extend_from_slice(&sums);
        }
        let end = match end {
            Some(end) => end,
            None if grid.is_cut => End::DurationReached,
            None => loop {
                if let Progress::Over(end) = response
                    .advance_unobserved(&model, &mut state, at_once(last_nanos), u64::MAX)
                    .ok()?
                {
                    rest = Rest::after(&model, &state, end, at_rest);
                    break end;
                }
            },
        };
        let report = response.report(&model, &state, end);
        if !sums.as_flattened().iter().all(|sum| sum.is_finite()) {
            return None;
        }
        Some(Self {
            at_end: last,
            integrals,
            rest: rest.map(|rest| Box::new(rest.after)),
            report,
        })
    }

    /// Adds to the integrals of the readings, at each instant and for each group of sensors, so many times what `more` says.
    pub fn add(&mut self, grid: &TimeGrid, more: impl Fn(f64, usize) -> Lanes, times: f64) {
        let groups = self.at_end.len();
        for (edge, integrals) in grid
            .edges
            .iter()
            .zip(self.integrals.chunks_exact_mut(groups))
        {
            for (group, integrals) in integrals.iter_mut().enumerate() {
                let more = more(*edge, group);
                for (integral, more) in integrals.iter_mut().zip(more) {
                    *integral += times * more;
                }
            }
        }
    }

    /// Bytes that a prediction takes, about.
    pub fn bytes(grid: &TimeGrid, sensors: &[Sensor]) -> usize {
        let integrals = (grid.edges.len() + 1) * lanes(sensors.len()).len() * size_of::<Lanes>();
        integrals + size_of::<Self>() + size_of::<State>()
    }

    /// Integrals of the readings from contact to a place \[s, times their units\], of the sensors of one group.
    pub fn integrals(&self, group: usize, place: Place) -> Lanes {
        let groups = self.at_end.len();
        let at = place.index * groups + group;
        let (Some(a), Some(b)) = (self.integrals.get(at), self.integrals.get(at + groups)) else {
            return ZERO;
        };
        let end = &self.at_end[group];
        std::array::from_fn(|k| a[k] + place.share * (b[k] - a[k]) + place.beyond * end[k])
    }

    /// Integral of a sensor's reading from contact to a place \[s, times its unit\].
    pub fn integral(&self, sensor: usize, place: Place) -> f64 {
        self.integrals(sensor / WIDTH, place)[sensor % WIDTH]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;

    fn loaded() -> Parameters {
        let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/");
        let files = ["heb220_s355.yaml", "sensors_industrial.yaml"];
        let files = files.map(|it| format!("{config}{it}").into());
        Parameters::load(&files, &[]).expect("parameters")
    }

    /// A search took most of its time for what comes after the data.
    #[test]
    fn a_response_until_the_data_end_reads_as_the_whole_one() {
        let parameters = loaded();
        let column = StandingColumn::undamaged(&parameters);
        let (properties, sensors) = (column.properties(&parameters), parameters.sensors());
        let (grid, until) = (TimeGrid::new(), 0.04);
        let predicted = |grid: &TimeGrid| {
            let impact = Impact::rigid(1500.0, 8.0);
            Prediction::compute(&column, &properties, &impact, &sensors, grid).expect("a response")
        };
        let (whole, part) = (predicted(&grid), predicted(&grid.until(until)));
        for sensor in 0..sensors.len() {
            for time in (0..=80).map(|half| 0.5e-3 * f64::from(half)) {
                let [whole, part] =
                    [&whole, &part].map(|it| it.integral(sensor, grid.place(time)).to_bits());
                assert_eq!(whole, part, "{time} s");
            }
        }
        assert!(part.integrals.len() < whole.integrals.len());
        assert_eq!(grid.until(HORIZON), grid);
    }

    /// The steps of a prediction grow with the time after contact; the reference makes those that the model recommends.
    #[test]
    fn longer_steps_late_after_contact_lead_to_the_same_peak_and_rest() {
        let parameters = loaded();
        let column = StandingColumn::undamaged(&parameters);
        let (properties, sensors) = (column.properties(&parameters), parameters.sensors());
        for (vehicle, velocity) in [("mid_car", 12.0), ("van", 8.0), ("lorry_8t", 4.0)] {
            let changes = [
                ("vehicle.name", vehicle.into()),
                ("impact.velocity", velocity.into()),
            ];
            let impact = parameters
                .with_changes(changes)
                .expect("admissible")
                .impact();
            let grid = TimeGrid::new();
            let found = Prediction::compute(&column, &properties, &impact, &sensors, &grid);
            let found = found.expect("a response").report;
            let model = Model::new(&properties.before(&impact)).expect("a column");
            let mut state = column.state(&model);
            let begun = Response::begin(&model, &mut state, impact, 2.0 * HORIZON);
            let mut response = begun.expect("an impact");
            let end = loop {
                let progress = response.advance(&model, &mut state, u64::MAX);
                if let Progress::Over(end) = progress.expect("a step") {
                    break end;
                }
            };
            let exact = response.report(&model, &state, end);
            let residual = |it: &Report| it.residual_v1.expect("it stands");
            assert!(exact.max_v1_time > 0.025, "{vehicle}: {exact:?}");
            assert!(
                (found.max_v1 / exact.max_v1 - 1.0).abs() < 5e-3,
                "{vehicle}"
            );
            let off = residual(&found) - residual(&exact);
            assert!(off.abs() < 5e-3 * exact.max_v1, "{vehicle}: {off} m");
        }
    }
}
