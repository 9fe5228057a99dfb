//! Processor time of the viewer's scene during continuous responses, and its effect on the delay of publication.

use std::net::{Ipv4Addr, TcpListener};
use std::time::Duration;

use column_twin::messages::column_twin_msgs::ColumnState;
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::{Arrival, Peer};
use super::processor::share_during;
use super::program::Program;
use super::stream::Impacts;
use super::table::{Ranked, number, row};
use super::wheel::{Running, free_port};

const LONGEST: Duration = Duration::from_secs(20);

/// The target for the additional processor time \[s per s\].
const TARGET: f64 = 0.05;

/// The node's share of a processor, and the delay of its states \[ms\].
fn measure(span: Duration, mode: &str, port: u16, ready: &str) -> (f64, Ranked) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = [
        format!("viewer.mode:={mode}"),
        format!("viewer.port:={port}"),
    ];
    let arguments: Vec<&str> = arguments.iter().flat_map(|it| ["-p", it]).collect();
    let mut program = Program::ready(&domain, folder.path(), &arguments);
    let mut peer = Peer::new(&domain);
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |_: ColumnState, it| it,
        |it| it.header.stamp,
    );
    let mut impacts = Impacts::new(&mut peer);
    impacts.for_a_while(Duration::from_secs(1));
    if !program.seen.iter().any(|line| line.contains(ready)) {
        program.wait_for(ready);
    }
    states.arrivals.try_iter().for_each(drop);
    let share = share_during(program.id(), || impacts.for_a_while(span));
    let late = states
        .arrivals
        .try_iter()
        .map(|Arrival { stamp, source, .. }| 1e-6 * (source - stamp) as f64);
    (share, Ranked::new(late))
}

pub fn run(span: Duration) {
    let span = span.min(LONGEST);
    println!(
        "continuous slow impacts for {} s, 1000 states and 60 frames per second",
        span.as_secs()
    );
    row(
        "",
        [
            "% of a core",
            "beyond off",
            "/ target",
            "late p50 ms",
            "late p99 ms",
        ]
        .map(str::to_owned),
    );
    let silent = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let silent_port = silent.local_addr().expect("its address").port();
    let viewer_port = free_port();
    let real = Running::try_headless(viewer_port);
    let cases = [
        ("off", "off", free_port(), "is ready"),
        ("save", "save", free_port(), "the viewer file is"),
        ("serve, no viewer", "serve", free_port(), "to watch"),
        (
            "connect, viewer does not read",
            "connect",
            silent_port,
            "connected to",
        ),
        (
            "connect, real viewer",
            "connect",
            viewer_port,
            "connected to",
        ),
    ];
    let mut off = 0.0;
    for (name, mode, port, ready) in cases {
        if let (true, Err(reason)) = (port == viewer_port, &real) {
            println!("{name}: left out, because {reason}");
            continue;
        }
        let (share, late) = measure(span, mode, port, ready);
        if mode == "off" {
            off = share;
        }
        row(
            name,
            [
                number(100.0 * share),
                number(100.0 * (share - off)),
                number((share - off) / TARGET),
                number(late.percentile(50.0)),
                number(late.percentile(99.0)),
            ],
        );
    }
}
