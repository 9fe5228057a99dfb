//! Columns with sensors in the pool: what they detect is what a single twin would, bit for bit, and no column detects for another one.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::assessment::Action;
use column_twin::column::Impact;
use column_twin::estimation::{Batch, EstimateRecord, Readings, Recomputation, simulate_sensors};
use column_twin::fleet::make_twins;
use column_twin::live::{
    Clock, FleetHandle, FleetOptions, LiveFleet, RealTime, Receiver, SimClock,
};
use column_twin::parameters::{FleetColumn, Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::{Decision, Notice, NoticeLevel, Output};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

const START: Nanos = 1_800_000_000_000_000_000;

/// Samples of a batch, 10 ms, and their period \[ns\].
const SAMPLES: usize = 100;
const PERIOD: u64 = 100_000;

/// Batches of rest before the readings.
const REST: usize = 50;

/// Maximum duration of a test.
const DEADLINE: Duration = Duration::from_secs(300);

const NOISE: [f64; 2] = [1e-4, 1e-6];

/// A column with a laser and a strain gauge, or without sensors.
fn column(name: &str, load: f64, has_sensors: bool) -> FleetColumn {
    let mut values: Vec<(&str, Value)> = vec![
        ("column_id", name.into()),
        ("top.load", load.into()),
        ("solver.dt", 1e-4.into()),
        ("response.duration", 0.2.into()),
        ("estimation.accept", "automatic".into()),
        // The impacts are to leave a column that stands.
        ("shear.model", "none".into()),
    ];
    if has_sensors {
        values.extend([
            (
                "sensors.names",
                vec!["laser".to_owned(), "gauge".to_owned()].into(),
            ),
            ("sensors.laser.quantity", Value::from("displacement")),
            ("sensors.laser.height", 1.0.into()),
            ("sensors.laser.noise", NOISE[0].into()),
            ("sensors.gauge.quantity", "bending_strain".into()),
            ("sensors.gauge.height", 0.1.into()),
            ("sensors.gauge.noise", NOISE[1].into()),
        ]);
    }
    FleetColumn {
        name: format!("/{name}"),
        parameters: Arc::new(Parameters::from_values(values).expect("admissible")),
    }
}

/// Two columns that are equal, one without sensors between them, and one with another load.
fn columns() -> Vec<FleetColumn> {
    vec![
        column("a", 2e5, true),
        column("none", 2e5, false),
        column("b", 2e5, true),
        column("c", 3e5, true),
    ]
}

/// What the sensors of a column read when it is struck, or while nothing happens.
fn readings(parameters: &Parameters, velocity: Option<f64>, seed: u64) -> Vec<Vec<f32>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // Approximately normal.
    let mut noise = move || -> f64 {
        let uniform = |bits: u32| f64::from(bits) / f64::from(u32::MAX) - 0.5;
        (0..12).map(|_| uniform(random.next_u32())).sum()
    };
    let mut still = |batches: usize| -> Vec<Vec<f32>> {
        let mut each = |sensor: usize| -> Vec<f32> {
            (0..batches * SAMPLES)
                .map(|_| (NOISE[sensor] * noise()) as f32)
                .collect()
        };
        vec![each(0), each(1)]
    };
    let Some(velocity) = velocity else {
        return still(REST + 150);
    };
    let mut all = still(REST);
    let (properties, sensors) = (parameters.column_properties(), parameters.sensors());
    let impact = Impact::rigid(1500.0, velocity);
    let struck: Readings =
        simulate_sensors(&properties, &impact, 1.0, &sensors, seed).expect("simulated");
    for (_, values) in struck.rows() {
        for (course, value) in all.iter_mut().zip(values) {
            course.push(*value as f32);
        }
    }
    all
}

/// The batches of a column, as they were pushed.
fn batches(courses: &[Vec<f32>]) -> Vec<Batch> {
    let count = courses[0].len() / SAMPLES;
    let batch = |index: usize, sensor: usize| Batch {
        sensor: sensor as u16,
        first: START + (index * SAMPLES) as i64 * PERIOD as i64,
        period: PERIOD,
        values: courses[sensor][index * SAMPLES..(index + 1) * SAMPLES].into(),
    };
    (0..count)
        .flat_map(|index| (0..courses.len()).map(move |sensor| (index, sensor)))
        .map(|(index, sensor)| batch(index, sensor))
        .collect()
}

struct Fleet {
    handle: FleetHandle,
    receiver: Receiver,
    clock: Arc<SimClock>,
    received: BTreeMap<u32, Vec<Output>>,
}

impl Fleet {
    fn start(columns: &[FleetColumn]) -> Self {
        let clock = Arc::new(SimClock::new(START));
        let twins = make_twins(columns, &[], || 0, START).expect("stand");
        let options = FleetOptions {
            real_time: RealTime::none(),
            threads: 2,
            state_files: Vec::new(),
            journals: false,
            further_outputs: Vec::new(),
        };
        let (handle, receiver) =
            LiveFleet::start(twins, Arc::clone(&clock) as _, options).expect("starts");
        Self {
            handle,
            receiver,
            clock,
            received: BTreeMap::new(),
        }
    }

    fn receive(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let given_up = Instant::now() + DEADLINE;
        while !done(self) {
            assert!(Instant::now() < given_up, "no {what}");
            match self.receiver.try_next_of() {
                Some((column, output)) => self.received.entry(column).or_default().push(output),
                None => {
                    // Time passes, so that responses end, and the data of an impact.
                    self.clock.set(self.clock.now() + 1_000_000);
                    self.receiver.wait(Duration::from_millis(1));
                }
            }
        }
    }

    fn of(&self, column: u32) -> &[Output] {
        self.received.get(&column).map_or(&[], Vec::as_slice)
    }

    /// The estimates of a column, each once.
    fn estimates(&self, column: u32) -> Vec<Arc<EstimateRecord>> {
        let mut records: Vec<Arc<EstimateRecord>> = Vec::new();
        for output in self.of(column) {
            if let Output::Estimate(it) = output
                && records
                    .last()
                    .is_none_or(|last| last.update < it.record.update)
            {
                records.push(Arc::clone(&it.record));
            }
        }
        records
    }

    fn has_accepted(&self, column: u32) -> bool {
        let accepted =
            |it: &Output| matches!(it, Output::Estimate(it) if it.decision == Decision::Accepted);
        self.of(column).iter().any(accepted)
    }
}

#[test]
fn two_of_four_columns_detect_an_impact_each_its_own_and_the_others_nothing() {
    let columns = columns();
    let velocities = [Some(6.0), None, None, Some(9.0)];
    let mut fleet = Fleet::start(&columns);
    let given: Vec<Vec<Batch>> = (0_u64..)
        .zip(columns.iter().zip(velocities))
        .map(|(seed, (column, velocity))| {
            let has_sensors = !column.parameters.sensors().is_empty();
            match has_sensors {
                true => batches(&readings(&column.parameters, velocity, seed)),
                false => Vec::new(),
            }
        })
        .collect();
    let measurements = fleet.handle.measurements().expect("sensors").clone();
    // Where nothing is prepared the first impact takes longer, but is detected all the same.
    let longest = given.iter().map(Vec::len).max().expect("columns");
    for index in 0..longest {
        for (column, batches) in (0..).zip(&given) {
            if let Some(batch) = batches.get(index) {
                let end = batch.end();
                fleet.clock.set(fleet.clock.now().max(end));
                measurements.push(column, batch.clone());
            }
        }
    }
    fleet.receive("final estimates", |it| {
        [0, 3].iter().all(|column| {
            let last = it.estimates(*column).pop();
            last.is_some_and(|last| last.is_final) && it.has_accepted(*column)
        })
    });
    fleet.receive("reports", |it| {
        let has_report = |column| {
            it.of(column)
                .iter()
                .any(|it| matches!(it, Output::Report(_)))
        };
        has_report(0) && has_report(3)
    });
    for column in [1, 2] {
        assert!(fleet.estimates(column).is_empty(), "column {column}");
    }
    assert!((0..4).all(|column| measurements.lost_of(column) == 0));
    for (column, truth) in [(0_u32, 1500.0 * 6.0), (3, 1500.0 * 9.0)] {
        let records = fleet.estimates(column);
        let momentum = &records.last().expect("estimates").estimate.momentum;
        assert!((momentum.mean / truth - 1.0).abs() < 0.15, "{momentum:?}");
        // A single twin that is fed the same.
        let parameters = &columns[column as usize].parameters;
        let known = |number: u64| given[column as usize].get(number as usize);
        let mut single = Recomputation::new(parameters);
        for record in &records {
            let again = single.repeat(record, known).expect("computed again");
            assert_eq!(format!("{again:?}"), format!("{record:?}"));
        }
    }
    let statistics = fleet.handle.sensing_statistics().expect("sensors");
    assert_eq!(statistics.lost_estimates, 0);
    assert_eq!(statistics.libraries.beyond, 0);
    // A severe verdict is told as an error, too.
    let verdicts = [Action::Shore, Action::Evacuate].map(|it| it.name().to_uppercase() + ": ");
    let is_verdict = |text: &str| verdicts.iter().any(|it| text.contains(it));
    let is_fault = |it: &Notice| it.level == NoticeLevel::Error && !is_verdict(&it.text);
    let errors: Vec<_> = fleet
        .received
        .values()
        .flatten()
        .filter(|it| matches!(it, Output::Notice(it) if is_fault(it)))
        .collect();
    assert!(errors.is_empty(), "{errors:#?}");
    fleet.handle.stop().expect("no panic");
}

#[test]
fn equal_columns_share_what_is_prepared_and_a_damaged_one_does_not() {
    let columns = vec![
        column("a", 2e5, true),
        column("b", 2e5, true),
        column("none", 2e5, false),
    ];
    let mut fleet = Fleet::start(&columns);
    let libraries = |fleet: &Fleet| {
        let statistics = fleet.handle.sensing_statistics();
        statistics.expect("sensors").libraries
    };
    fleet.receive("a complete library", |it| libraries(it).complete == 1);
    assert_eq!(libraries(&fleet).kinds, 1);
    let measurements = fleet.handle.measurements().expect("sensors").clone();
    for batch in batches(&readings(&columns[0].parameters, Some(9.0), 1)) {
        fleet.clock.set(fleet.clock.now().max(batch.end()));
        measurements.push(0, batch);
    }
    fleet.receive("a report", |it| {
        it.of(0).iter().any(|it| matches!(it, Output::Report(_)))
            && it.estimates(0).last().is_some_and(|it| it.is_final)
    });
    let first = &fleet.estimates(0)[0];
    assert!(first.prepared > 1, "everything was prepared");
    fleet.receive("the damaged column", |it| libraries(it).kinds == 2);
    fleet.handle.stop().expect("no panic");
}

#[test]
fn a_fleet_without_sensors_has_no_thread_for_them() {
    let fleet = Fleet::start(&[column("none", 2e5, false)]);
    assert!(fleet.handle.measurements().is_none());
    assert_eq!(fleet.handle.sensing_statistics(), None);
    fleet.handle.stop().expect("no panic");
}
