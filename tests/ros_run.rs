//! Tests `run` and `watch` from their arguments to SIGTERM, with remapped names. The only test of its process, because a
//! second signal ends the process at once.
#![cfg(feature = "ros")]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

#[path = "ros/domain.rs"]
mod domain;

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::sync::mpsc::channel;
use std::thread;

use column_twin::column::ImpactSpecification;
use column_twin::ros::{
    ImpactOptions, ImpactOutcome, ImpactRequest, RosArguments, RunOptions, Shown, run, send_impact,
    watch,
};
use signal_hook::consts::SIGTERM;

use domain::{Domain, PATIENCE};

#[test]
fn run_impact_and_watch_meet_under_other_names_and_end_with_sigterm() {
    let domain = Domain::fresh();
    let environment = domain.environment.clone();
    let line = "run --ros-args -r __ns:=/garage -r impact_event:=/camera/impact -p top.load:=2e5 -p column_id:=a3 \
                -p state.directory:='' -p real_time.priority:=0 -p real_time.lock_memory:=false";
    let (own, ros) = RosArguments::split(line.split(' ').map(OsString::from)).unwrap();
    assert_eq!(own, ["run"]);
    let rules = ros.remap_rules.clone();
    let options = RunOptions {
        ros,
        environment: environment.clone(),
        ..RunOptions::default()
    };
    let node = thread::spawn(move || run(&options));
    let (sender, lines) = channel();
    let (watched, watch_rules) = (environment.clone(), rules.clone());
    let watcher = thread::spawn(move || {
        watch(&watched, &watch_rules, &mut |shown| {
            if let Shown::Line(line) = shown {
                let _ = sender.send(line.to_owned());
            }
            ControlFlow::Continue(())
        })
    });
    let impact = ImpactOptions {
        column_id: Some("a3".to_owned()),
        request: ImpactRequest {
            event_id: Some("e1".to_owned()),
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity: 1.0,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            match_timeout: PATIENCE,
            answer_timeout: PATIENCE,
        },
    };
    let mut printed = Vec::new();
    let outcome = send_impact(&environment, &rules, &impact, &mut |line| {
        printed.push(line.to_owned())
    });
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    assert!(printed[0].contains("/camera/impact"), "{printed:?}");
    let shown = || lines.recv_timeout(PATIENCE).expect("a line");
    assert!(shown().starts_with("watching /garage/column_state in domain"));
    // The forecast is kept for late joiners.
    while !shown().starts_with("forecast of e1: ") {}
    signal_hook::low_level::raise(SIGTERM).unwrap();
    node.join().unwrap().unwrap();
    watcher.join().unwrap().unwrap();
}
