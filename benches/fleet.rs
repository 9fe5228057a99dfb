//! A fleet of columns in one process: what it costs at rest, how fast it starts, and how fast its forecasts are.
//!
//! `cargo bench --bench fleet -- 1000` with another number of columns. `cargo bench --bench fleet -- traffic --seconds 3600` lets an
//! hour of simulated traffic pass over a fleet that is recorded, and verifies the recordings; `--columns`, `--rate` (impacts per
//! second) and `--seed` change it. `cargo bench --bench fleet -- hit` measures the forecasts only.
#![allow(clippy::disallowed_methods)] // as in a test: short-lived threads and channels of its own

#[path = "../tests/ros/domain.rs"]
mod domain;
#[path = "live/processor.rs"]
#[allow(dead_code)] // the benchmark of the node uses more of it
mod processor;
#[path = "../tests/ros/program.rs"]
#[allow(dead_code)] // the tests use more of it
mod program;
#[path = "live/table.rs"]
#[allow(dead_code)] // the benchmark of the node uses more of it
mod table;
#[path = "fleet_parts/traffic.rs"]
mod traffic;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command as Process;
use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::column::ImpactSpecification;
use column_twin::fleet::make_twins;
use column_twin::live::{
    Clock, FleetOptions, LiveFleet, RealTime, Receiver, SystemClock, monotonic_nanos,
};
use column_twin::messages::column_twin_msgs::FleetStatus;
use column_twin::parameters::{FleetColumn, Parameters, Value};
use column_twin::ros::{Names, Node, qos};
use column_twin::twin::{Command, ImpactCommand, Output};
use futures::StreamExt;

use domain::{Domain, PATIENCE};
use processor::{resident_mebibytes, share_together};
use program::Program;
use table::{Ranked, number, row};

/// Columns of the fleet, if none are given.
const COLUMNS: usize = 1_000;

/// How long the fleet is watched at rest.
const AT_REST: Duration = Duration::from_secs(20);

/// Columns that are hit within a millisecond, and how often.
const HIT: usize = 10;
const ROUNDS: usize = 20;

/// Rounds with one column, whose forecasts are fewer.
const ROUNDS_OF_ONE: usize = 60;

/// The aims.
const SHARE: f64 = 0.01;
const MEBIBYTES: f64 = 200.0;
const THREADS: f64 = 16.0;
const FILES: f64 = 500.0;
const PACKETS: f64 = 50.0;
const START: f64 = 2.0;
const DISCOVERY: f64 = 1.0;
const BYTES: f64 = 20_000.0;
/// Of a forecast \[ms\], and what the last of several may take beyond its processor time divided by the solver threads.
const FORECAST: f64 = 5.0;
const BEYOND: f64 = 2.0;

/// Traffic, if nothing else is given: short.
const TRAFFIC_SECONDS: u64 = 60;
const IMPACTS_PER_SECOND: f64 = 3.0;
const SEED: u64 = 1;

/// The value of an option such as `--seconds 3600`.
fn option<T: std::str::FromStr>(name: &str, or: T) -> T {
    let mut arguments = std::env::args().skip_while(|it| it != name).skip(1);
    match arguments.next() {
        None => or,
        Some(text) => text
            .parse()
            .unwrap_or_else(|_| panic!("{name} is {text:?}, expected a number")),
    }
}

fn main() {
    if std::env::args().any(|it| it == "traffic") {
        return traffic::traffic(&traffic::Traffic {
            columns: option("--columns", COLUMNS),
            rate: option("--rate", IMPACTS_PER_SECOND),
            seconds: option("--seconds", TRAFFIC_SECONDS),
            seed: option("--seed", SEED),
        });
    }
    if std::env::args().any(|it| it == "hit") {
        return hit();
    }
    let given = std::env::args().filter_map(|it| it.parse().ok()).next();
    let columns = given.unwrap_or(COLUMNS);
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load {}", load.trim());
    for kind in ["equal", "different"] {
        at_rest(columns, kind == "equal", false);
    }
    if cfg!(feature = "viewer") {
        at_rest(columns, true, true);
    }
    memory();
    critical_velocities();
    hit();
}

/// A table of columns, which differ by their names only or also by their loads, with or without a file for the viewer.
fn write_fleet(folder: &Path, columns: usize, equal: bool, is_shown: bool) {
    let mode = if is_shown { "save" } else { "\"off\"" };
    let yaml = format!(
        "/**:\n  ros__parameters: {{state.directory: states, viewer.mode: {mode}, viewer.directory: shown}}\n"
    );
    fs::write(folder.join("fleet.yaml"), yaml).expect("written");
    let mut table = "namespace,column_id,top.load\n".to_owned();
    for number in 0..columns {
        let load = if equal { 0 } else { number };
        table += &format!("/hall/c{number},c{number},{}\n", 2.0e5 + load as f64);
    }
    fs::write(folder.join("columns.csv"), table).expect("written");
}

fn arguments(command: &mut Process) {
    command.args([
        "fleet",
        "--params-file",
        "fleet.yaml",
        "--columns",
        "columns.csv",
    ]);
}

/// Entries of a folder in `/proc`.
fn entries(path: &str) -> f64 {
    fs::read_dir(path).map_or(f64::NAN, |it| it.count() as f64)
}

/// Packets that the loopback interface of a process's network has sent.
fn packets(id: u32) -> Option<f64> {
    let text = fs::read_to_string(format!("/proc/{id}/net/dev")).ok()?;
    let line = text.lines().find_map(|it| it.trim().strip_prefix("lo:"))?;
    line.split_whitespace().nth(9)?.parse().ok()
}

fn at_rest(columns: usize, equal: bool, is_shown: bool) {
    let folder = tempfile::tempdir().expect("a folder");
    write_fleet(folder.path(), columns, equal, is_shown);
    let binary = env!("CARGO_BIN_EXE_column-twin");
    // A network of its own, so that the packets are those of the fleet.
    let domain = Domain::fresh();
    let mut command = Process::new("unshare");
    command.args([
        "--net",
        "sh",
        "-c",
        "ip link set lo up && exec \"$0\" \"$@\"",
        binary,
    ]);
    arguments(&mut command);
    let can_unshare = Process::new("unshare")
        .args(["--net", "sh", "-c", "ip link set lo up"])
        .output()
        .is_ok_and(|it| it.status.success());
    if !can_unshare {
        command = Process::new(binary);
        arguments(&mut command);
    }
    let begun = Instant::now();
    let mut program = Program::spawn(&domain, folder.path(), command);
    program.wait_for("is ready in domain");
    let start = begun.elapsed().as_secs_f64();
    let id = program.id();
    // After the start, critical velocities are computed with the lowest priority.
    let computing = Instant::now();
    let most = Duration::from_secs(30);
    while share_together(&[id], Duration::from_secs(1)) > 0.05 && computing.elapsed() < most {}
    let computed = match computing.elapsed() < most {
        true => format!("{:.0} s", computing.elapsed().as_secs_f64()),
        false => format!("more than {} s", most.as_secs()),
    };
    let before = packets(id);
    let busy = share_together(&[id], AT_REST);
    let sent = packets(id)
        .zip(before)
        .map(|(after, before)| after - before);
    let sent = sent.filter(|_| can_unshare).unwrap_or(f64::NAN);
    let kind = if equal { "equal" } else { "different" };
    let shown = if is_shown {
        ", with the viewer in mode save"
    } else {
        ""
    };
    println!(
        "\n{columns} {kind} columns at rest over {} s{shown}; critical velocities took {computed}",
        AT_REST.as_secs()
    );
    row("", ["found".into(), "/ aim".into()]);
    let rows = [
        ("processor time [% of a core]", 100.0 * busy, 100.0 * SHARE),
        ("resident memory [MiB]", resident_mebibytes(id), MEBIBYTES),
        ("threads", entries(&format!("/proc/{id}/task")), THREADS),
        (
            "file descriptors",
            entries(&format!("/proc/{id}/fd")),
            FILES,
        ),
        ("packets on lo [1/s]", sent / AT_REST.as_secs_f64(), PACKETS),
        ("start until ready [s]", start, START),
    ];
    for (name, found, aim) in rows {
        row(name, [number(found), number(found / aim)]);
    }
    program.terminate();
    if equal && !is_shown {
        discovery(columns, folder.path(), binary);
    }
}

/// The time until a reader that joins late knows all columns.
fn discovery(columns: usize, folder: &Path, binary: &str) {
    let domain = Domain::fresh();
    let mut command = Process::new(binary);
    arguments(&mut command);
    let mut program = Program::spawn(&domain, folder, command);
    program.wait_for("is ready in domain");
    let begun = Instant::now();
    let names = Names::new("/", "reader", &[]).expect("valid");
    let mut node = Node::new(&domain.environment, names).expect("a node");
    let subscription = node
        .subscription::<FleetStatus>(&qos::FLEET_STATUS)
        .expect("a subscription");
    let mut known = BTreeSet::new();
    let mut first = None;
    futures::executor::block_on(async {
        let messages = subscription.async_stream();
        futures::pin_mut!(messages);
        while known.len() < columns && begun.elapsed() < PATIENCE {
            if let Some(Ok((status, _))) = messages.next().await {
                first.get_or_insert_with(|| begun.elapsed());
                known.extend(status.columns.into_iter().map(|it| it.column_id));
            }
        }
    });
    let first = first.map_or(f64::NAN, |it| it.as_secs_f64());
    row(
        "a late reader has the first message [s]",
        [number(first), number(first / DISCOVERY)],
    );
    let all = begun.elapsed().as_secs_f64();
    row(
        "a late reader has all columns [s]",
        [number(all), number(all / DISCOVERY)],
    );
    program.terminate();
}

fn columns(count: usize) -> Vec<FleetColumn> {
    let column = |number: usize| {
        let name = format!("c{number}");
        let values = [("column_id", Value::from(name.as_str()))];
        FleetColumn {
            name: format!("/hall/{name}"),
            parameters: Arc::new(Parameters::from_values(values).expect("admissible")),
        }
    };
    (0..count).map(column).collect()
}

/// What each idle column adds.
fn memory() {
    let bytes = |count: usize| {
        let mut kept = None;
        let memory = allocation_counter::measure(|| {
            let columns = columns(count);
            let twins = make_twins(&columns, &[], || 0, 0).expect("stand");
            kept = Some((columns, twins));
        });
        memory.bytes_current as f64
    };
    bytes(1);
    let each = (bytes(300) - bytes(100)) / 200.0;
    println!();
    row(
        "bytes of each idle column",
        [number(each), number(each / BYTES)],
    );
}

/// What the thread in the background has to do for each different column.
fn critical_velocities() {
    let twins = make_twins(&columns(1), &[], || 0, 0).expect("stand");
    let task = twins[0].critical_velocity_task().expect("at rest");
    let before = thread_time();
    task.compute(&mut || true).expect("not abandoned");
    row(
        "critical velocities of one column [s of processor time]",
        [number(thread_time() - before)],
    );
}

fn impact(column: usize, id: &str, stamp: i64) -> Command {
    Command::Impact(ImpactCommand {
        event_id: id.to_owned(),
        column_id: format!("c{column}"),
        stamp,
        vehicle: String::new(),
        impact: ImpactSpecification {
            mass: 1500.0,
            velocity: 10.0,
            gap: None,
            restitution: None,
            height: None,
            direction: None,
        },
    })
}

/// Forecasts of the paper's impact: of one column, and of ten that are hit at once; without ROS, and with as many solver threads
/// as by default and one less, in turns.
fn hit() {
    let alone = alone();
    println!("\none forecast takes {} ms in one thread", number(alone));
    let most = FleetOptions::threads_of(&Parameters::default());
    for (hit, rounds, title) in [
        (1, ROUNDS_OF_ONE, "one column hit"),
        (HIT, ROUNDS, "ten columns hit at once"),
    ] {
        for threads in [most, most - 1].into_iter().filter(|it| *it > 0) {
            let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
            let Hit {
                each,
                last_of,
                lost,
            } = hit_with(hit, rounds, threads);
            println!(
                "\n{title}, {rounds} times, {threads} solver threads, load {}; outputs lost: {lost}",
                load.split(' ').next().unwrap_or_default()
            );
            row(
                "",
                ["p50 ms", "p99 ms", "max ms", "p99 / aim"].map(Into::into),
            );
            let aim = alone * hit.div_ceil(threads) as f64 + BEYOND;
            for (name, ranked, aim) in [
                ("each forecast after its event", each, FORECAST),
                ("the last forecast", last_of, aim),
            ] {
                let ranked = Ranked::new(ranked);
                let cells = [
                    ranked.percentile(50.0),
                    ranked.percentile(99.0),
                    ranked.max(),
                    ranked.percentile(99.0) / aim,
                ];
                row(name, cells.map(number));
            }
        }
    }
}

/// Median of the processor time of a forecast \[ms\].
fn alone() -> f64 {
    let mut times = Vec::new();
    for round in 0..ROUNDS {
        let mut twins = make_twins(&columns(1), &[], || 0, 0).expect("stand");
        let mut out = Vec::new();
        let before = thread_time();
        twins[0]
            .handle(impact(0, &format!("e{round}"), 0), 0, &mut out)
            .expect("accepted");
        while twins[0].awaits_forecast() {
            twins[0].run_ahead(1_000, 0, &mut out);
        }
        times.push(1e3 * (thread_time() - before));
    }
    Ranked::new(times).percentile(50.0)
}

/// Processor time of this thread \[s\].
fn thread_time() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Times from the events on \[ms\].
struct Hit {
    each: Vec<f64>,
    last_of: Vec<f64>,
    lost: u64,
}

fn hit_with(hit: usize, rounds: usize, threads: usize) -> Hit {
    let columns = columns(100);
    let clock = Arc::new(SystemClock::new());
    let twins = make_twins(&columns, &[], monotonic_nanos, clock.now()).expect("stand");
    let options = FleetOptions {
        real_time: RealTime::default(),
        threads,
        state_files: Vec::new(),
        journals: false,
        further_outputs: Vec::new(),
    };
    let (handle, mut receiver) =
        LiveFleet::start(twins, Arc::clone(&clock) as _, options).expect("starts");
    let (mut last_of, mut each) = (Vec::new(), Vec::new());
    for round in 0..rounds {
        let stamp = clock.now();
        let begun = Instant::now();
        for column in 0..hit {
            let column = round % 5 * HIT + column;
            let command = impact(column, &format!("e{round}"), stamp);
            handle.submit(column as u32, command).expect("room");
        }
        let (mut forecasts, mut reports) = (BTreeSet::new(), 0);
        while reports < hit {
            match next(&mut receiver) {
                (column, Output::Forecast(_)) if forecasts.insert(column) => {
                    each.push(1e3 * begun.elapsed().as_secs_f64());
                    if forecasts.len() == hit {
                        last_of.push(1e3 * begun.elapsed().as_secs_f64());
                    }
                }
                (_, Output::Report(_)) => reports += 1,
                _ => {}
            }
        }
        for column in 0..hit {
            let column = (round % 5 * HIT + column) as u32;
            let source = "bench".into();
            handle
                .execute(column, Command::Reset { source })
                .expect("reset");
        }
    }
    let statistics = handle.stop().expect("no panic");
    let lost = statistics.queues.iter().map(|it| it.dropped).sum();
    Hit {
        each,
        last_of,
        lost,
    }
}

/// The next output.
fn next(receiver: &mut Receiver) -> (u32, Output) {
    loop {
        match receiver.try_next_of() {
            Some(next) => return next,
            None => receiver.wait(Duration::from_millis(1)),
        }
    }
}
