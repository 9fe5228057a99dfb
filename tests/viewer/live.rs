//! A running twin with viewers that are not there, cannot be, or are served.

use std::net::{Ipv4Addr, TcpListener};

use std::sync::Arc;
use std::time::Duration;

use column_twin::parameters::Value;

use super::twin::{LiveColumn, bits, parameters, without_viewer};
use super::wheel::free_port;

const VELOCITIES: [f64; 2] = [3.0, 2.0];

/// Runs with these parameters of the viewer, compares with nobody looking, and says how long the stop took.
fn same(viewer: &[(&str, Value)]) -> LiveColumnEnd {
    let mut column = LiveColumn::start(&parameters(viewer));
    let states: Vec<_> = VELOCITIES.iter().flat_map(|it| column.hit(*it)).collect();
    assert_eq!(bits(&states), without_viewer(&VELOCITIES));
    let said = Arc::clone(&column.said);
    let took = column.stop();
    println!("{viewer:?}: stopped within {took:?}");
    let lines = said.lock().expect("no panic");
    LiveColumnEnd {
        said: lines.iter().map(|(_, line)| line.clone()).collect(),
    }
}

struct LiveColumnEnd {
    said: Vec<String>,
}

#[test]
fn a_file_that_is_written_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("a name").to_owned();
    same(&[
        ("mode", Value::from("save")),
        ("directory", Value::from(path.as_str())),
    ]);
    let files: Vec<_> = std::fs::read_dir(folder.path())
        .expect("readable")
        .map(|entry| entry.expect("readable").path())
        .collect();
    assert_eq!(files.len(), 1, "{files:?}");
    let size = std::fs::metadata(&files[0]).expect("there").len();
    // Statics, two impacts of some dozen pictures each.
    assert!(size > 300_000, "{size}");
}

#[test]
fn a_file_that_cannot_be_written_is_said_once_and_the_twin_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let occupied = folder.path().join("file");
    std::fs::write(&occupied, "").expect("written");
    let path = occupied.to_str().expect("a name").to_owned();
    let end = same(&[
        ("mode", Value::from("save")),
        ("directory", Value::from(path.as_str())),
    ]);
    assert_eq!(end.said.len(), 1, "{:?}", end.said);
    assert!(end.said[0].contains("cannot write"), "{:?}", end.said);
    assert!(end.said[0].ends_with("The twin goes on without pictures"));
}

#[test]
fn serving_changes_nothing() {
    let port = i64::from(free_port());
    let end = same(&[
        ("mode", Value::from("serve")),
        ("port", Value::from(port)),
        ("memory_limit", Value::from(2_000_000_i64)),
    ]);
    let url = format!("to look: rerun rerun+http://127.0.0.1:{port}/proxy");
    assert_eq!(end.said, [url]);
}

#[test]
fn a_port_that_is_taken_is_said_and_the_twin_goes_on() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = listener.local_addr().expect("its address").port();
    let end = same(&[
        ("mode", Value::from("serve")),
        ("port", Value::from(i64::from(port))),
    ]);
    assert_eq!(end.said.len(), 1, "{:?}", end.said);
    assert!(end.said[0].contains("another program listens"));
    assert!(end.said[0].contains("viewer.port:="), "{:?}", end.said);
}

#[test]
fn others_are_not_served() {
    let end = same(&[
        ("mode", Value::from("serve")),
        ("address", Value::from("0.0.0.0")),
    ]);
    assert!(end.said[0].contains("of this machine"), "{:?}", end.said);
}

#[test]
fn a_viewer_that_does_not_answer_is_said_once() {
    let port = i64::from(free_port());
    let end = same(&[
        ("mode", Value::from("connect")),
        ("port", Value::from(port)),
    ]);
    assert_eq!(end.said.len(), 1, "{:?}", end.said);
    assert!(end.said[0].contains("no viewer answers"), "{:?}", end.said);
}

/// It takes the connection and hangs up: said once, however often it is tried.
#[test]
fn a_peer_that_hangs_up_is_said_once() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = listener.local_addr().expect("its address").port();
    // Ends with the process.
    std::thread::spawn(move || listener.incoming().for_each(drop));
    let mut column = LiveColumn::start(&parameters(&[
        ("mode", Value::from("connect")),
        ("port", Value::from(i64::from(port))),
    ]));
    column.hit(3.0);
    column.wait_for("as soon as it was there");
    // Three more attempts.
    std::thread::park_timeout(Duration::from_millis(3_500));
    column.hit(1.0);
    let said = column.said.lock().expect("no panic").clone();
    assert_eq!(said.len(), 2, "{said:?}");
    column.stop();
}

/// It takes the connection and then not a byte.
#[test]
fn a_peer_that_is_no_viewer_holds_up_nobody() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    let port = listener.local_addr().expect("its address").port();
    same(&[
        ("mode", Value::from("connect")),
        ("port", Value::from(i64::from(port))),
    ]);
}
