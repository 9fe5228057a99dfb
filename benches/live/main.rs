//! How the live node does, as tables with ratios measured in one run: `cargo bench --bench live -- [PARTS] [--seconds S]`.
//!
//! | part | what is measured |
//! |---|---|
//! | `stream` | 1 kHz to rclpy and to a Rust reader: losses, order, lateness of publication, latency, against a bare publisher |
//! | `forecast` | from an event to its forecast on the wire, against a bare echo |
//! | `idle` | processor time of the node at rest |
//! | `stop` | from SIGTERM during a response to the end |
//! | `viewer` | what pictures cost, and whether anything is later for them, wherever they go |
//! | `load` | the solver while other programs take all processors |
//!
//! Without parts all of them run. The node is `column-twin run` as a user starts it; the peers are processes of their own.
//! Everything stays on loopback in a domain that nobody else uses.
// A reader listens without a bound: it ends with the benchmark.
#![allow(clippy::disallowed_methods)]

mod bare;
mod forecast;
mod idle;
mod load;
mod peers;
mod processor;
mod stop;
mod stream;
mod table;
mod viewer;

#[path = "../../tests/ros/domain.rs"]
mod domain;
#[allow(dead_code)] // the tests use more of it
#[path = "../../tests/ros/program.rs"]
mod program;
#[allow(dead_code)] // the tests of the viewer use more of it
#[path = "../../tests/viewer/wheel.rs"]
mod wheel;

use std::time::Duration;

/// What the command line asks for.
struct Wishes {
    parts: Vec<String>,
    seconds: u64,
}

/// A part, with the time that it may take.
type Part = (&'static str, fn(Duration));

const PARTS: [Part; 6] = [
    ("stream", stream::run),
    ("forecast", forecast::run),
    ("idle", idle::run),
    ("stop", stop::run),
    ("viewer", viewer::run),
    ("load", load::run),
];

fn wishes() -> Result<Wishes, String> {
    let mut wishes = Wishes {
        parts: Vec::new(),
        seconds: 60,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--bench" => {}
            "--seconds" => {
                let seconds = arguments.next().unwrap_or_default();
                wishes.seconds = seconds.parse().ok().filter(|it| *it > 0).ok_or_else(|| {
                    format!("--seconds {seconds}: expected a whole number above 0")
                })?;
            }
            part if PARTS.iter().any(|(name, _)| *name == part) => {
                wishes.parts.push(part.to_owned());
            }
            other => {
                let names = PARTS.map(|(name, _)| name).join(", ");
                return Err(format!("{other}: expected --seconds S, or some of {names}"));
            }
        }
    }
    Ok(wishes)
}

/// What else the machine does, which no number means anything without.
pub fn print_load() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let one_minute = load.split(' ').next().unwrap_or("?");
    let processors = std::thread::available_parallelism().map_or(0, usize::from);
    println!("{processors} processors; load of the last minute {one_minute}");
}

fn main() {
    if bare::is_asked_for() {
        return;
    }
    // `cargo test --benches` only asks whether it runs.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let wishes = wishes().unwrap_or_else(|wrong| {
        eprintln!("{wrong}");
        std::process::exit(2);
    });
    for (name, run) in PARTS {
        if wishes.parts.is_empty() || wishes.parts.iter().any(|it| it == name) {
            println!("\n== {name}");
            print_load();
            run(Duration::from_secs(wishes.seconds));
        }
    }
}
