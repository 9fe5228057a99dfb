//! What recording costs: throughput of our writer, with and without a seal, against the bare mcap crate, what one seal costs, and
//! what a sender waits for the recorder.
//!
//!     cargo bench --bench recording [-- --seconds 60]
//!
//! Ratios are of one run, the writers in turn, so that what else the machine does falls on both.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use column_twin::live::{RealTime, request_for_publisher};
use column_twin::messages::column_twin_msgs::ColumnState;
use column_twin::messages::{INTERFACES, Message, cdr};
use column_twin::recording::{
    self, ChunkCompression, Entry, OfferedQos, Recorder, RecorderOptions, SealKey, TopicInfo,
    Writer, WriterOptions,
};

/// Messages of one measurement of the throughput.
const MESSAGES: u64 = 200_000;

/// Measurements, of which the middle one counts.
const ROUNDS: usize = 5;

/// Messages per second of the long run.
const RATE: u32 = 10_000;

fn topic() -> TopicInfo {
    let qos = OfferedQos {
        reliable: true,
        transient_local: false,
        depth: 1000,
    };
    recording::topic("/column_state", "column_twin_msgs/msg/ColumnState", qos)
        .expect("a definition")
}

/// A state as it may be, padded to 500 bytes by its identity.
fn entry(index: i64) -> Entry {
    let mut state = ColumnState {
        column_id: "x".repeat(260),
        event_id: "event".to_owned(),
        ..ColumnState::default()
    };
    let x = index as f64;
    [state.v1, state.u1, state.beta1, state.u2] = [x.sin(), x.cos(), 1.0 / (x + 1.0), x.sqrt()];
    [
        state.kinetic_energy,
        state.elastic_energy,
        state.plastic_work,
    ] = [x.exp_m1(), x * 0.3, x / 7.0];
    let data = cdr::encode(&state).expect("it is short").into();
    Entry {
        topic: 0,
        log_time: index,
        publish_time: index,
        data,
        checkpoint: false,
    }
}

fn main() {
    let mut arguments = std::env::args();
    let seconds = match arguments.find(|it| it == "--seconds") {
        Some(_) => arguments
            .next()
            .and_then(|it| it.parse().ok())
            .expect("a number of seconds"),
        None => 60,
    };
    let folder = tempfile::tempdir().expect("a directory");
    throughput(folder.path());
    one_seal(folder.path());
    long_run(folder.path(), seconds);
}

fn throughput(folder: &Path) {
    let entries: Vec<Entry> = (0..1000).map(entry).collect();
    println!(
        "throughput, {MESSAGES} messages of {} bytes, median of {ROUNDS}",
        entries[0].data.len()
    );
    println!(
        "{:<6} {:>16} {:>16} {:>8} {:>16} {:>14} {:>14}",
        "", "ours [1/s]", "mcap [1/s]", "ratio", "sealed [1/s]", "sealed/ours", "ours [MB/s]"
    );
    for compression in [
        ChunkCompression::None,
        ChunkCompression::Lz4,
        ChunkCompression::Zstd,
    ] {
        let key = SealKey::fresh().expect("random numbers");
        let mut rates: Vec<(f64, f64, f64)> = (0..ROUNDS)
            .map(|round| {
                let directory = folder.join(format!("{compression:?}{round}"));
                let rate = |time: Duration| MESSAGES as f64 / time.as_secs_f64();
                let [ours, sealed] = [None, Some(key.clone())].map(|seal| {
                    let rate = rate(ours(&directory, compression, seal, &entries));
                    std::fs::remove_dir_all(&directory).expect("it was made");
                    rate
                });
                let file = folder.join("bare.mcap");
                let bare = rate(bare(&file, compression, &entries));
                std::fs::remove_file(file).expect("it was made");
                (ours, bare, sealed)
            })
            .collect();
        rates.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
        let (ours, bare, _) = rates[ROUNDS / 2];
        rates.sort_by(|a, b| (a.2 / a.0).total_cmp(&(b.2 / b.0)));
        let (unsealed, _, sealed) = rates[ROUNDS / 2];
        let name = format!("{compression:?}").to_lowercase();
        let megabytes = ours * entries[0].data.len() as f64 * 1e-6;
        println!(
            "{name:<6} {ours:>16.0} {bare:>16.0} {:>8.2} {sealed:>16.0} {:>14.2} {megabytes:>14.0}",
            ours / bare,
            sealed / unsealed
        );
    }
}

/// The time of one flush with and without a seal; a recorder flushes at most 40 times per second.
fn one_seal(folder: &Path) {
    const FLUSHES: u32 = 2000;
    let entry = entry(1);
    let time = |seal: Option<SealKey>| {
        let directory = folder.join("flushes");
        let options = WriterOptions {
            sync: false,
            seal,
            ..WriterOptions::default()
        };
        let mut writer = Writer::create(&directory, &options, &[topic()]).expect("a recording");
        let begin = Instant::now();
        for _ in 0..FLUSHES {
            writer.write(&entry).expect("room");
            writer.flush().expect("room");
        }
        let each = begin.elapsed() / FLUSHES;
        let bytes = writer.finish().expect("room").bytes / u64::from(FLUSHES);
        std::fs::remove_dir_all(&directory).expect("it was made");
        (each, bytes)
    };
    let ((plain, plain_bytes), (sealed, sealed_bytes)) = (
        time(None),
        time(Some(SealKey::fresh().expect("random numbers"))),
    );
    println!(
        "\na flush with one message: {plain:?} and {plain_bytes} bytes, with a seal {sealed:?} and {sealed_bytes} bytes"
    );
}

fn ours(
    directory: &Path,
    compression: ChunkCompression,
    seal: Option<SealKey>,
    entries: &[Entry],
) -> Duration {
    let options = WriterOptions {
        compression,
        seal,
        sync: false,
        ..WriterOptions::default()
    };
    let begin = Instant::now();
    let mut writer = Writer::create(directory, &options, &[topic()]).expect("a recording");
    for index in 0..MESSAGES {
        let entry = &entries[usize::try_from(index).expect("it is small") % entries.len()];
        writer.write(entry).expect("room");
    }
    writer.finish().expect("room");
    begin.elapsed()
}

fn bare(path: &Path, compression: ChunkCompression, entries: &[Entry]) -> Duration {
    let options = mcap::WriteOptions::new()
        .profile("ros2")
        .compression(compression.into())
        .compression_threads(0)
        .chunk_size(Some(1 << 20))
        .disable_seeking(true);
    let begin = Instant::now();
    let file = BufWriter::new(File::create(path).expect("a file"));
    let mut writer = options.create(file).expect("a recording");
    let interface = ColumnState::INTERFACE;
    let text = interface.schema_text(INTERFACES).expect("a definition");
    let schema = writer
        .add_schema(&interface.ros_name(), "ros2msg", text.as_bytes())
        .expect("room");
    let channel_id = writer
        .add_channel(schema, "/column_state", "cdr", &Default::default())
        .expect("room");
    for index in 0..MESSAGES {
        let entry = &entries[usize::try_from(index).expect("it is small") % entries.len()];
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: u32::try_from(index).expect("it is small"),
            log_time: entry.log_time as u64,
            publish_time: entry.publish_time as u64,
        };
        writer
            .write_to_known_channel(&header, &entry.data)
            .expect("room");
    }
    writer.finish().expect("room");
    begin.elapsed()
}

fn long_run(folder: &Path, seconds: u32) {
    println!("\n{RATE} messages/s for {seconds} s, synchronised to the disk and sealed");
    // As the node's publishing thread, which is the sender: else what is measured is who else wants the processor.
    request_for_publisher(&RealTime::default());
    let recorder = Recorder::start(
        RecorderOptions {
            seal: Some(SealKey::fresh().expect("random numbers")),
            ..RecorderOptions::new(folder, SystemTime::now())
        },
        vec![topic()],
    )
    .expect("a recorder");
    let entries: Vec<Entry> = (0..1000).map(entry).collect();
    let (mut waits, mut longest_queue) = (Vec::new(), 0);
    let begin = Instant::now();
    for index in 0..RATE * seconds {
        let due = Duration::from_nanos(1_000_000_000 / u64::from(RATE)) * index;
        while let Some(early) = due.checked_sub(begin.elapsed()) {
            std::thread::sleep(early);
        }
        let entry = entries[index as usize % entries.len()].clone();
        let before = Instant::now();
        recorder.record(entry);
        waits.push(before.elapsed());
        if index % 1000 == 0 {
            longest_queue = longest_queue.max(recorder.statistics().queue.len);
        }
    }
    let statistics = recorder.stop();
    waits.sort();
    let at = |share: f64| waits[((waits.len() - 1) as f64 * share) as usize];
    let above = waits
        .iter()
        .filter(|it| **it > Duration::from_micros(100))
        .count();
    println!(
        "written {}, lost {}, longest queue seen {longest_queue}",
        statistics.written, statistics.lost
    );
    println!(
        "a sender waits: median {:?}, p99.9 {:?}, p99.99 {:?}, worst {:?}; longer than 0.1 ms: {above}",
        at(0.5),
        at(0.999),
        at(0.9999),
        at(1.0)
    );
}
