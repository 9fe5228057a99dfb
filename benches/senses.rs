//! What measurements cost while nothing happens: 16 sensors at 10 kHz in batches of 10 ms, from the bytes of their messages to the
//! detection.
//!
//! Processor time of the thread, so that other load on the machine falsifies the figures little.

use std::hint::black_box;

use column_twin::incoming::raw_batch;
use column_twin::live::MeasurementQueue;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin::Measurement;
use column_twin::messages::std_msgs::Header;
use column_twin::senses::{Batch, Detector, Intake, Quantity, Sensor};
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

fn processor_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
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
    let queue = MeasurementQueue::new();
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

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("Load: {}", load.trim());
    intake();
}
