//! What measurements cost while nothing happens: 16 sensors at 10 kHz in batches of 10 ms, from the bytes of their messages to the
//! detection.
//!
//! Then what hundreds of columns of a fleet cost on which nothing happens, each with two sensors at 1 kHz: from the bytes of their
//! messages to the thread that detects impacts, in real time.
//!
//! Processor time of the thread, so that other load on the machine falsifies the figures little.

use std::collections::HashMap;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::estimation::{Batch, Detector, Intake};
use column_twin::fleet::make_twins;
use column_twin::incoming::raw_batch;
use column_twin::live::{
    Clock, FleetOptions, LiveFleet, MeasurementQueue, RealTime, SystemClock, monotonic_nanos,
};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::Measurement;
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::{FleetColumn, Parameters, Value};
use column_twin::sensors::{Quantity, Sensor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rustix::time::{ClockId, clock_gettime};

const SENSORS: usize = 16;
const RATE: i64 = 10_000;
const BATCH: usize = 100;

/// Seconds of data.
const DURATION: i64 = 20;

/// Most of a processor for intake and detection.
const TARGET: f64 = 0.1;

/// Columns of a fleet, their sensors' rate \[Hz\], samples of a batch, and seconds of real time.
const COLUMNS: [usize; 2] = [100, 400];
const FLEET_RATE: f64 = 1_000.0;
const FLEET_BATCH: usize = 10;
const FLEET_SECONDS: u64 = 10;

/// Longest wait for the prepared responses.
const PREPARED_WITHIN: Duration = Duration::from_secs(600);

fn processor_time() -> f64 {
    time_of(ClockId::ThreadCPUTime)
}

fn time_of(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Half of them accelerometers, the others strain gauges and lasers.
fn sensors() -> Vec<Sensor> {
    let sensor = |k: usize| {
        let (quantity, noise) = match k % 4 {
            0 | 1 => (Quantity::Acceleration, 0.02),
            2 => (Quantity::BendingStrain, 1e-6),
            _ => (Quantity::Displacement, 1e-4),
        };
        Sensor {
            name: format!("sensor_{k}"),
            quantity,
            height: 0.25 * k as f64,
            range: if k % 4 < 2 { 490.0 } else { 0.0 },
            noise,
            bias: 0.0,
            gain_error: 0.01,
            rate: RATE as f64,
            bandwidth: 0.5 * RATE as f64,
            reversed: k % 2 == 1,
            fibre: 0.11,
        }
    };
    (0..SENSORS).map(sensor).collect()
}

/// Approximately normal.
fn noise(random: &mut ChaCha8Rng) -> f64 {
    let uniform = |bits: u32| f64::from(bits) / f64::from(u32::MAX) - 0.5;
    let sum: f64 = (0..12).map(|_| uniform(random.next_u32())).sum();
    sum
}

/// The messages of all sensors as bytes, with the times at which they arrive \[ns\].
fn messages(sensors: &[Sensor]) -> Vec<(i64, Vec<u8>)> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let step = 1_000_000_000 / RATE * BATCH as i64;
    let epoch = 1_700_000_000_000_000_000;
    let batches = DURATION * RATE / BATCH as i64;
    let all = (0..batches).flat_map(|k| sensors.iter().map(move |sensor| (k, sensor)));
    all.map(|(k, sensor)| {
        let stamp = epoch + k * step;
        let message = Measurement {
            header: Header {
                stamp: Time::from_nanos(stamp).unwrap_or_default(),
                frame_id: String::new(),
            },
            column_id: "column".to_owned(),
            sensor_id: sensor.name.clone(),
            sample_period: 1.0 / sensor.rate,
            values: (0..BATCH)
                .map(|_| (sensor.noise * noise(&mut random)) as f32)
                .collect(),
        };
        let bytes = cdr::encode(&message).expect("a message");
        (stamp + step + 1_000_000, bytes)
    })
    .collect()
}

/// The time of the part, per second of data.
fn part<T>(name: &str, work: impl FnOnce() -> T) -> (f64, T) {
    let began = processor_time();
    let result = black_box(work());
    let share = (processor_time() - began) / DURATION as f64;
    println!("| {name} | {:.2} % |", 100.0 * share);
    (share, result)
}

fn intake() {
    let sensors = sensors();
    let messages = messages(&sensors);
    println!(
        "\n## Intake: {SENSORS} sensors at {RATE} Hz in batches of {BATCH}, {DURATION} s of data\n"
    );
    println!("| part | of one processor |\n|---|---|");
    let (decoding, decoded) = part("messages from their bytes", || {
        let decoded = messages
            .iter()
            .map(|(received, bytes)| (*received, cdr::decode::<Measurement>(bytes)));
        decoded.collect::<Vec<_>>()
    });
    let mut intake = Intake::new(&sensors, "column");
    let (taking, batches) = part("intake", || {
        let mut batches: Vec<Batch> = Vec::with_capacity(decoded.len());
        for (received, message) in &decoded {
            let message = message.as_ref().expect("readable");
            batches.extend(intake.take(&raw_batch(message), *received));
        }
        batches
    });
    assert_eq!(batches.len(), messages.len(), "nothing is lost");
    let queue = MeasurementQueue::default();
    let (queueing, count) = part("queue", || {
        let mut count = 0;
        for batch in &batches {
            queue.push(batch.clone());
            count += usize::from(queue.pop().is_some());
        }
        count
    });
    assert_eq!((count, queue.lost()), (batches.len(), 0));
    let mut detector = Detector::new(&sensors);
    let (detecting, detections) = part("detection", || {
        let mut detections = Vec::new();
        let first = batches[0].first;
        for batch in &batches {
            for (time, value) in batch.samples() {
                let time = 1e-9 * (time - first) as f64;
                detections.extend(detector.push(usize::from(batch.sensor), time, f64::from(value)));
            }
        }
        detections
    });
    assert!(detections.is_empty(), "{detections:?}");
    let total = decoding + taking + queueing + detecting;
    println!("| together | {:.2} % |", 100.0 * total);
    let word = if total <= TARGET { "kept" } else { "missed" };
    println!("\nTarget: {:.0} %, {word}.", 100.0 * TARGET);
}

/// A column with a laser and a strain gauge.
fn column(number: usize) -> FleetColumn {
    let name = format!("c{number}");
    let values: [(&str, Value); 9] = [
        ("column_id", name.as_str().into()),
        (
            "sensors.names",
            vec!["laser".to_owned(), "gauge".to_owned()].into(),
        ),
        ("sensors.laser.quantity", "displacement".into()),
        ("sensors.laser.height", 1.0.into()),
        ("sensors.laser.noise", 1e-4.into()),
        ("sensors.laser.rate", FLEET_RATE.into()),
        ("sensors.gauge.quantity", "axial_strain".into()),
        ("sensors.gauge.height", 0.1.into()),
        ("sensors.gauge.noise", 1e-6.into()),
    ];
    let values = values.into_iter();
    let values = values.chain([("sensors.gauge.rate", FLEET_RATE.into())]);
    FleetColumn {
        name: format!("/{name}"),
        parameters: Arc::new(Parameters::from_values(values).expect("admissible")),
    }
}

/// What a fleet costs while nothing happens.
fn fleets() {
    println!(
        "\n## Fleets at rest: two sensors at {FLEET_RATE} Hz on each column, in batches of {FLEET_BATCH}, {FLEET_SECONDS} s of real time\n"
    );
    println!(
        "| columns | from bytes to queue | thread that detects | other threads | columns on one processor | lost batches |\n\
         |---|---|---|---|---|---|"
    );
    for count in COLUMNS {
        fleet(count);
    }
}

fn fleet(count: usize) {
    let columns: Vec<FleetColumn> = (0..count).map(column).collect();
    let clock = Arc::new(SystemClock::new());
    let twins = make_twins(&columns, &[], monotonic_nanos, clock.now()).expect("stand");
    let options = FleetOptions {
        real_time: RealTime::none(),
        threads: 1,
        state_files: Vec::new(),
        journals: false,
        further_outputs: Vec::new(),
    };
    let (handle, _outputs) =
        LiveFleet::start(twins, Arc::clone(&clock) as _, options).expect("starts");
    let given_up = Instant::now() + PREPARED_WITHIN;
    let is_prepared = || {
        let statistics = handle.sensing_statistics().expect("sensors");
        (statistics.libraries.kinds, statistics.libraries.complete) == (1, 1)
    };
    while !is_prepared() {
        assert!(Instant::now() < given_up, "nothing is prepared");
        std::thread::park_timeout(Duration::from_millis(50));
    }
    let measurements = handle.measurements().expect("sensors").clone();
    let mut intakes: HashMap<String, (u32, Intake)> = (0..)
        .zip(&columns)
        .map(|(index, column)| {
            let id = column.parameters.settings().column_id.clone();
            let intake = Intake::new(&column.parameters.sensors(), &id);
            (id, (index, intake))
        })
        .collect();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let courses: Vec<f32> = (0..1 << 16).map(|_| noise(&mut random) as f32).collect();
    let step = Duration::from_secs_f64(FLEET_BATCH as f64 / FLEET_RATE);
    let (first, began) = (clock.now(), Instant::now());
    let rounds = FLEET_SECONDS * FLEET_RATE as u64 / FLEET_BATCH as u64;
    let (mut own, mut encoding, mut next) = (0.0, 0.0, 0_usize);
    let before = time_of(ClockId::ProcessCPUTime);
    let sensing_before = sensing_time();
    for round in 1..=rounds {
        let due = step * u32::try_from(round).expect("few");
        std::thread::park_timeout(due.saturating_sub(began.elapsed()));
        let started = processor_time();
        let stamp = first + (step * u32::try_from(round - 1).expect("few")).as_nanos() as i64;
        let messages: Vec<Vec<u8>> = (0..count)
            .flat_map(|column| [("laser", 1e-4), ("gauge", 1e-6)].map(|it| (column, it)))
            .map(|(column, (sensor, size))| {
                next = (next + 61) % (courses.len() - FLEET_BATCH);
                let values = courses[next..next + FLEET_BATCH].iter();
                let message = Measurement {
                    header: Header {
                        stamp: Time::from_nanos(stamp).unwrap_or_default(),
                        frame_id: String::new(),
                    },
                    column_id: format!("c{column}"),
                    sensor_id: sensor.to_owned(),
                    sample_period: 1.0 / FLEET_RATE,
                    values: values.map(|it| size * it).collect(),
                };
                cdr::encode(&message).expect("a message")
            })
            .collect();
        let encoded = processor_time();
        encoding += encoded - started;
        let received = clock.now();
        for bytes in &messages {
            let message = cdr::decode::<Measurement>(bytes).expect("readable");
            let (index, intake) = intakes.get_mut(&message.column_id).expect("a column");
            if let Ok(batch) = intake.take(&raw_batch(&message), received) {
                measurements.push(*index, batch);
            }
        }
        own += processor_time() - encoded;
    }
    let seconds = began.elapsed().as_secs_f64();
    let sensing = (sensing_time() - sensing_before) / seconds;
    let all = (time_of(ClockId::ProcessCPUTime) - before) / seconds;
    let (own, encoding) = (own / seconds, encoding / seconds);
    let others = (all - own - encoding - sensing).max(0.0);
    let lost: u64 = (0..count as u32).map(|it| measurements.lost_of(it)).sum();
    let on_one = count as f64 / (own + sensing + others);
    println!(
        "| {count} | {:.1} % | {:.1} % | {:.1} % | {on_one:.0} | {lost} |",
        100.0 * own,
        100.0 * sensing,
        100.0 * others
    );
    handle.stop().expect("no panic");
}

/// Processor time of the threads of this program that detect impacts \[s\].
fn sensing_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let each = tasks.filter_map(|task| {
        let folder = task.ok()?.path();
        let name = std::fs::read_to_string(folder.join("comm")).ok()?;
        if !column_twin::live::SENSING_THREAD.starts_with(name.trim()) {
            return None;
        }
        let statistics = std::fs::read_to_string(folder.join("schedstat")).ok()?;
        let nanos: f64 = statistics.split_whitespace().next()?.parse().ok()?;
        Some(1e-9 * nanos)
    });
    each.sum()
}

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("Load: {}", load.trim());
    intake();
    fleets();
}
