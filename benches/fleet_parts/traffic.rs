//! Simulated traffic over a fleet that is recorded: whether its memory stays flat, and whether every recording verifies.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use column_twin::evidence::verify;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{
    ImpactEvent, ImpactReport, ResetColumnRequest, ResetColumnResponse,
};
use column_twin::messages::std_msgs::Header;
use column_twin::ros::{Names, Node, qos};
use futures::StreamExt;

use super::domain::{Domain, PATIENCE};
use super::processor::{resident_mebibytes, share_during};
use super::program::Program;
use super::{arguments, write_fleet};

/// What the traffic is like.
pub struct Traffic {
    pub columns: usize,
    /// Impacts per second.
    pub rate: f64,
    pub seconds: u64,
    pub seed: u64,
}

/// How long a line of the table takes, and the shortest one.
const MINUTE: Duration = Duration::from_secs(60);

/// One reset comes after so many impacts.
const IMPACTS_PER_RESET: u64 = 20;

/// Time for the last responses before the fleet is stopped.
const LAST_RESPONSES: Duration = Duration::from_secs(5);

/// Largest file of the recordings \[B\], so that an hour has several.
const MAX_FILE_SIZE: u64 = 200_000_000;

/// Pseudorandom numbers (`SplitMix64`), the same for the same seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// Uniform in (0, 1).
    fn unit(&mut self) -> f64 {
        ((self.next() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn column(&mut self, columns: usize) -> String {
        format!("c{}", self.next() % columns as u64)
    }
}

/// What one minute of the traffic has found.
struct Counts {
    sent: u64,
    resets: u64,
    reports: Arc<AtomicU64>,
}

pub fn traffic(traffic: &Traffic) {
    let folder = tempfile::tempdir().expect("a folder");
    write_fleet(folder.path(), traffic.columns, true, false);
    let domain = Domain::fresh();
    let mut command = Process::new(env!("CARGO_BIN_EXE_column-twin"));
    arguments(&mut command);
    command.args(["--ros-args", "-p", "record.mode:=events"]);
    command.args(["-p", "record.directory:=recordings", "-p"]);
    command.arg(format!("record.max_file_size:={MAX_FILE_SIZE}"));
    let mut program = Program::spawn(&domain, folder.path(), command);
    program.wait_for("is ready in domain");
    println!(
        "\n{} columns, {} impacts per second over {} s, seed {}",
        traffic.columns, traffic.rate, traffic.seconds, traffic.seed
    );
    println!(
        "{:>8} {:>9} {:>9} {:>7} {:>9} {:>10} {:>10} {:>6}",
        "time [s]", "impacts", "reports", "resets", "CPU [%]", "RSS [MiB]", "disk [MB]", "files"
    );
    let recordings = folder.path().join("recordings");
    drive(traffic, &domain, program.id(), &recordings);
    let (status, _, log) = program.terminate();
    println!("the fleet ended with {status}");
    let errors = log.iter().filter(|it| it.contains("[ERROR]"));
    errors.take(10).for_each(|it| println!("  {it}"));
    verified(&recordings);
}

fn drive(traffic: &Traffic, domain: &Domain, id: u32, recordings: &Path) {
    let names = Names::new("/", "traffic", &[]).expect("valid");
    let mut node = Node::new(&domain.environment, names).expect("a node");
    let events = node.publisher(&qos::IMPACT_EVENT).expect("a publisher");
    let resets = node
        .client::<ResetColumnRequest, ResetColumnResponse>(&qos::Endpoint {
            name: "/column_twin/reset_column",
            ..qos::RESET_COLUMN
        })
        .expect("a client");
    let mut counts = Counts {
        sent: 0,
        resets: 0,
        reports: Arc::default(),
    };
    let subscription = node
        .subscription::<ImpactReport>(&qos::IMPACT_REPORT)
        .expect("a subscription");
    let reports = Arc::clone(&counts.reports);
    let peers = node.participant_events();
    // It ends with the process.
    thread::spawn(move || {
        let counting = subscription.async_stream().for_each(|_| {
            reports.fetch_add(1, Ordering::Relaxed);
            futures::future::ready(())
        });
        futures::executor::block_on(futures::future::join(peers, counting));
    });
    let matched = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(events.guid(), 1, matched));
    let mut random = Random(traffic.seed);
    let begun = Instant::now();
    let end = Duration::from_secs(traffic.seconds);
    let line = MINUTE.min(end);
    let mut next = Duration::ZERO;
    let mut hit = Vec::new();
    while begun.elapsed() < end {
        let until = (begun.elapsed() + line).min(end);
        let busy = share_during(id, || {
            while begun.elapsed() < until {
                // The times between impacts are exponentially distributed.
                next += Duration::from_secs_f64(-random.unit().ln() / traffic.rate);
                thread::sleep(next.min(until).saturating_sub(begun.elapsed()));
                if next > until {
                    break;
                }
                let column = random.column(traffic.columns);
                hit.push(column.clone());
                counts.sent += 1;
                let event = event(column, counts.sent, &mut random);
                events.publish(event).expect("sent");
                if counts.sent.is_multiple_of(IMPACTS_PER_RESET) {
                    let index = random.next() as usize % hit.len();
                    let column_id = hit.swap_remove(index);
                    let request = ResetColumnRequest { column_id };
                    resets.send_request(request).expect("sent");
                    counts.resets += 1;
                }
                while let Ok(Some(_)) = resets.receive_response() {}
            }
        });
        print_line(begun.elapsed(), &counts, busy, id, recordings);
    }
    thread::sleep(LAST_RESPONSES);
    print_line(begun.elapsed(), &counts, f64::NAN, id, recordings);
}

fn event(column_id: String, number: u64, random: &mut Random) -> ImpactEvent {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .expect("after 1970");
    let stamp = i64::try_from(since.as_nanos()).expect("before 2262");
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).expect("a time"),
            frame_id: String::new(),
        },
        column_id,
        event_id: format!("traffic {number}"),
        mass: random.between(500.0, 3_000.0),
        velocity: random.between(0.5, 5.0),
        ..ImpactEvent::default()
    }
}

fn print_line(at: Duration, counts: &Counts, busy: f64, id: u32, recordings: &Path) {
    let files = mcap_files(recordings);
    let bytes: u64 = files
        .iter()
        .filter_map(|it| it.metadata().ok())
        .map(|it| it.len())
        .sum();
    println!(
        "{:>8.0} {:>9} {:>9} {:>7} {:>9.1} {:>10.1} {:>10.1} {:>6}",
        at.as_secs_f64(),
        counts.sent,
        counts.reports.load(Ordering::Relaxed),
        counts.resets,
        100.0 * busy,
        resident_mebibytes(id),
        1e-6 * bytes as f64,
        files.len()
    );
}

fn mcap_files(recordings: &Path) -> Vec<PathBuf> {
    let inside = |path: PathBuf| fs::read_dir(path).into_iter().flatten().flatten();
    let folders = inside(recordings.to_path_buf());
    let files = folders.flat_map(|it| inside(it.path()));
    let mut files: Vec<_> = files
        .map(|it| it.path())
        .filter(|it| it.extension().is_some_and(|it| it == "mcap"))
        .collect();
    files.sort();
    files
}

/// Verifies every recording.
fn verified(recordings: &Path) {
    let files = mcap_files(recordings);
    let mut bad = 0;
    for file in &files {
        let begun = Instant::now();
        let found = match verify(file) {
            Ok(found) => found,
            Err(error) => {
                bad += 1;
                println!("{}: {error}", file.display());
                continue;
            }
        };
        let is_good = found.is_equal() && found.unchecked_reasons == 0 && found.missing() == 0;
        println!(
            "verified in {:.1} s: {} columns, {} commands, {} messages and {} states at rest compared, {} differences, {} missing, \
             {} not checked",
            begun.elapsed().as_secs_f64(),
            found.columns.len(),
            found.inputs,
            found.compared(),
            found.states_at_rest,
            found.differences,
            found.missing(),
            found.unchecked_messages(),
        );
        if !is_good {
            bad += 1;
            println!("{found}");
        }
    }
    println!("{} recordings, {bad} of them not verified", files.len());
}
