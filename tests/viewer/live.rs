//! A running twin with viewers that are not there, cannot be, or are served.

use std::net::{Ipv4Addr, TcpListener};

use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::live::{Clock, Live, LiveOptions, RealTime, SystemClock};
use column_twin::parameters::Value;
use column_twin::twin::{ImpactEvent, Input, Twin};
use column_twin::viewer::{LiveViewer, Telling, VIEWER_QUEUE, output_queue};

use super::twin::{LiveColumn, bits, parameters, without_viewer};

const VELOCITIES: [f64; 2] = [3.0, 2.0];

fn free_port() -> i64 {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
    i64::from(listener.local_addr().expect("its address").port())
}

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
    let port = free_port();
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
    let port = free_port();
    let end = same(&[
        ("mode", Value::from("connect")),
        ("port", Value::from(port)),
    ]);
    assert_eq!(end.said.len(), 1, "{:?}", end.said);
    assert!(end.said[0].contains("no viewer answers"), "{:?}", end.said);
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

/// Processor time of this process so far \[s\].
fn processor_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("readable");
    let after_name = stat.rsplit(')').next().expect("a name");
    let fields: Vec<_> = after_name.split_whitespace().collect();
    let ticks: f64 = fields[11..13]
        .iter()
        .map(|it| it.parse::<f64>().expect("a number"))
        .sum();
    ticks / 100.0
}

/// In real time, with an impact every 40 ms, so that the column never comes to rest: 1000 states a second. Prints what the
/// viewer's side costs; the target is 5 % of a core.
#[test]
#[ignore = "slow: 30 s of real time"]
fn what_pictures_in_real_time_cost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("a name").to_owned();
    for mode in ["off", "serve", "save"] {
        let parameters = parameters(&[
            ("mode", Value::from(mode)),
            ("port", Value::from(free_port())),
            ("directory", Value::from(path.as_str())),
        ]);
        let clock = SystemClock::new();
        let now = clock.now();
        let twin = Twin::new((*parameters).clone(), None, Box::new(|| 0), now).expect("stands");
        let mut options = LiveOptions {
            real_time: RealTime::none(),
            ..LiveOptions::default()
        };
        options.outputs.push(output_queue());
        let live = Live::start(twin, clock, options).expect("starts");
        let outputs = live.outputs(VIEWER_QUEUE).expect("there");
        let telling: Telling = Arc::new(|_, _| ());
        let viewer = LiveViewer::start(&parameters, outputs, now, telling).expect("a thread");
        let clock = SystemClock::new();
        let (began, before) = (Instant::now(), processor_time());
        for impact in 0..250 {
            let event = ImpactEvent {
                event_id: format!("impact-{impact}"),
                column_id: "column".to_owned(),
                stamp: clock.now(),
                impact_mass: 200.0,
                velocity: 0.3,
                gap: None,
                restitution: None,
                height: None,
            };
            live.submit(Input::Impact(event)).expect("room");
            let next = Duration::from_millis(40) * (impact + 1);
            std::thread::sleep(next.saturating_sub(began.elapsed()));
        }
        let (elapsed, cost) = (began.elapsed().as_secs_f64(), processor_time() - before);
        let queues = live.statistics().queues;
        let states = queues
            .iter()
            .find(|it| it.name == "states to viewer")
            .expect("there");
        println!(
            "{mode}: {:.1} % of a core, {:.0} states a second, {} lost",
            100.0 * cost / elapsed,
            states.pushed as f64 / elapsed,
            if mode == "off" { 0 } else { states.dropped },
        );
        if let Some(viewer) = viewer {
            viewer.stop();
        }
        live.stop().expect("no panic");
    }
}
