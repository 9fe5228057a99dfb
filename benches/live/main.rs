//! Benchmarks of the live node, as tables of ratios measured in one run: `cargo bench --bench live -- [PARTS] [--seconds S]`.
//!
//! | part | measured quantity |
//! |---|---|
//! | `stream` | 1 kHz to rclpy and to a Rust reader: losses, order, delay of publication, latency, compared with a bare publisher |
//! | `sensors` | lateness of the 1 kHz stream with eight sensors at 10 kHz, while they detect nothing and while an impact is estimated, against the same without sensors |
//! | `forecast` | time from an event to its forecast over DDS, compared with a bare echo |
//! | `opinion` | time from a forecast to the same forecast with the second opinion of the fibre beam, and the forecast with and without it |
//! | `idle` | processor time of the node at rest |
//! | `many` | forty nodes on one machine, each in a process of its own, at rest |
//! | `stop` | time from SIGTERM during a response to the end of the program |
//! | `viewer` | processor time of the viewer's scene, and its effect on the delay of publication |
//! | `soak` | 1 kHz for as long as `--seconds` says: losses, memory of the node over time; with DDS security if `ROS_SECURITY_KEYSTORE` names a keystore with the enclaves `/column_twin` and `/operator` |
//! | `everything` | forecast, 1 kHz stream and processor time at rest with a client of Foxglove, MQTT and metrics, in turns with the same without; needs mosquitto and the feature `alarm`, with `foxglove` for its client |
//! | `alarm` | time from the publication of a forecast to the alarm at a subscriber of an MQTT broker; needs mosquitto and the feature `alarm` |
//! | `load` | lateness of the solver while other programs use all processors |
//!
//! Without PARTS all of them run. The node is `column-twin run`; the peers are separate processes. Everything runs on loopback in
//! an unused domain.
// A reader listens without a bound: it ends with the benchmark.
#![allow(clippy::disallowed_methods)]

#[cfg(feature = "alarm")]
mod alarm;
mod bare;
#[cfg(feature = "alarm")]
mod everything;
mod forecast;
mod idle;
mod load;
mod many;
mod opinion;
mod peers;
mod processor;
mod sensors;
mod soak;
mod stop;
mod stream;
mod table;
#[cfg(feature = "viewer")]
mod viewer;

#[path = "../../tests/ros/domain.rs"]
mod domain;
#[allow(dead_code)] // the tests use more of it
#[cfg(all(feature = "alarm", feature = "foxglove"))]
#[path = "../../tests/ros/foxglove_socket.rs"]
mod foxglove_socket;
#[allow(dead_code)] // the tests use more of it
#[path = "../../tests/ros/program.rs"]
mod program;
#[allow(dead_code)] // the tests of the crate use more of it
#[cfg(feature = "alarm")]
#[path = "../../crates/alarm/tests/peers/programs.rs"]
mod programs;
#[allow(dead_code)] // the tests of the viewer use more of it
#[cfg(feature = "viewer")]
#[allow(clippy::duplicate_mod)] // each brings the function that finds a free port
#[path = "../../tests/viewer/wheel.rs"]
mod wheel;

use std::time::Duration;

#[cfg(feature = "alarm")]
use domain::PATIENCE;

/// The arguments of the command line.
struct Arguments {
    parts: Vec<String>,
    seconds: u64,
}

/// A part of the benchmark, which takes the duration of its measurement.
type Part = (&'static str, fn(Duration));

const PARTS: &[Part] = &[
    ("stream", stream::run),
    ("sensors", sensors::run),
    ("forecast", forecast::run),
    ("opinion", opinion::run),
    ("idle", idle::run),
    ("many", many::run),
    ("stop", stop::run),
    #[cfg(feature = "viewer")]
    ("viewer", viewer::run),
    #[cfg(feature = "alarm")]
    ("everything", everything::run),
    #[cfg(feature = "alarm")]
    ("alarm", alarm::run),
    ("load", load::run),
    ("soak", soak::run),
];

fn arguments() -> Result<Arguments, String> {
    let mut wishes = Arguments {
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
                let names: Vec<_> = PARTS.iter().map(|(name, _)| *name).collect();
                let names = names.join(", ");
                return Err(format!("{other}: expected --seconds S, or some of {names}"));
            }
        }
    }
    Ok(wishes)
}

/// Prints the load of the machine, which affects all results.
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
    // `cargo test --benches` only checks that the benchmark starts.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let wishes = arguments().unwrap_or_else(|wrong| {
        eprintln!("{wrong}");
        std::process::exit(2);
    });
    for (name, run) in PARTS {
        if wishes.parts.is_empty() || wishes.parts.iter().any(|it| *it == *name) {
            println!("\n== {name}");
            print_load();
            run(Duration::from_secs(wishes.seconds));
        }
    }
}
