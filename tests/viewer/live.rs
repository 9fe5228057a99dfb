//! A running twin with viewers that are missing, impossible, or served.

use std::net::{Ipv4Addr, TcpListener};

use std::sync::Arc;
use std::time::Duration;

use column_twin::parameters::Value;

use super::twin::{LiveColumn, bits, parameters, without_viewer};
use super::wheel::free_port;

const VELOCITIES: [f64; 2] = [3.0, 2.0];

/// Runs with these parameters of the viewer until it has logged `text`, and checks that the states are the same as without a viewer.
fn same(viewer: &[(&str, Value)], text: &str) -> LiveColumnEnd {
    let mut column = LiveColumn::start(&parameters(viewer));
    let states: Vec<_> = VELOCITIES.iter().flat_map(|it| column.hit(*it)).collect();
    assert_eq!(bits(&states), without_viewer(&VELOCITIES));
    if !text.is_empty() {
        column.wait_for(text);
    }
    let log = Arc::clone(&column.log);
    let took = column.stop();
    println!("{viewer:?}: stopped within {took:?}");
    let lines = log.lock().expect("no panic");
    LiveColumnEnd {
        log: lines.iter().map(|(_, line)| line.clone()).collect(),
    }
}

struct LiveColumnEnd {
    log: Vec<String>,
}

#[test]
fn a_file_that_is_written_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("a name").to_owned();
    let viewer = [
        ("mode", Value::from("save")),
        ("directory", Value::from(path.as_str())),
    ];
    same(&viewer, "");
    let files: Vec<_> = std::fs::read_dir(folder.path())
        .expect("readable")
        .map(|entry| entry.expect("readable").path())
        .collect();
    assert_eq!(files.len(), 1, "{files:?}");
    let size = std::fs::metadata(&files[0]).expect("there").len();
    // Static data, and two impacts with dozens of frames each.
    assert!(size > 300_000, "{size}");
}

#[test]
fn a_file_that_cannot_be_written_is_reported_once_and_the_twin_continues() {
    let folder = tempfile::tempdir().expect("a folder");
    let occupied = folder.path().join("file");
    std::fs::write(&occupied, "").expect("written");
    let path = occupied.to_str().expect("a name").to_owned();
    let viewer = [
        ("mode", Value::from("save")),
        ("directory", Value::from(path.as_str())),
    ];
    let end = same(&viewer, "cannot write");
    assert_eq!(end.log.len(), 1, "{:?}", end.log);
    assert!(end.log[0].contains("cannot write"), "{:?}", end.log);
    assert!(end.log[0].ends_with("The twin continues without a viewer"));
}

#[test]
fn serving_changes_nothing() {
    let port = i64::from(free_port());
    let viewer = [
        ("mode", Value::from("serve")),
        ("port", Value::from(port)),
        ("memory_limit", Value::from(2_000_000_i64)),
    ];
    let end = same(&viewer, "to watch");
    let url = format!("to watch: rerun rerun+http://127.0.0.1:{port}/proxy");
    assert_eq!(end.log, [url]);
}

#[test]
fn a_port_in_use_is_reported_and_the_twin_continues() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = listener.local_addr().expect("its address").port();
    let viewer = [
        ("mode", Value::from("serve")),
        ("port", Value::from(i64::from(port))),
    ];
    let end = same(&viewer, "another program listens");
    assert_eq!(end.log.len(), 1, "{:?}", end.log);
    assert!(end.log[0].contains("another program listens"));
    assert!(end.log[0].contains("viewer.port:="), "{:?}", end.log);
}

#[test]
fn other_machines_are_not_served() {
    let viewer = [
        ("mode", Value::from("serve")),
        ("address", Value::from("0.0.0.0")),
    ];
    let end = same(&viewer, "of this machine");
    assert!(end.log[0].contains("of this machine"), "{:?}", end.log);
}

#[test]
fn a_viewer_that_does_not_answer_is_reported_once() {
    let port = i64::from(free_port());
    let viewer = [
        ("mode", Value::from("connect")),
        ("port", Value::from(port)),
    ];
    let end = same(&viewer, "no viewer answers");
    assert_eq!(end.log.len(), 1, "{:?}", end.log);
    assert!(end.log[0].contains("no viewer answers"), "{:?}", end.log);
}

/// The peer accepts the connection and closes it: reported once, however often the twin tries again.
#[test]
fn a_peer_that_hangs_up_is_reported_once() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = listener.local_addr().expect("its address").port();
    // The thread ends with the process.
    std::thread::spawn(move || listener.incoming().for_each(drop));
    let mut column = LiveColumn::start(&parameters(&[
        ("mode", Value::from("connect")),
        ("port", Value::from(i64::from(port))),
    ]));
    column.hit(3.0);
    column.wait_for("has closed the connection immediately");
    // Three more attempts.
    std::thread::park_timeout(Duration::from_millis(3_500));
    column.hit(1.0);
    let lines = column.log.lock().expect("no panic").clone();
    assert_eq!(lines.len(), 2, "{lines:?}");
    column.stop();
}

/// The peer accepts the connection and then reads nothing.
#[test]
fn a_peer_that_is_not_a_viewer_delays_nothing() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = listener.local_addr().expect("its address").port();
    same(
        &[
            ("mode", Value::from("connect")),
            ("port", Value::from(i64::from(port))),
        ],
        "",
    );
}
