//! A shard moves: its process stops while columns respond, and another one starts elsewhere on the same state directory.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command as Process;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, ImpactReport, TwinStatus};
use column_twin::ros::{Node, Publisher, qos};

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::node::event;
use super::program::Program;

/// Responses of ten seconds, which are under way when the first process is stopped. However long the move takes, an event that its
/// sender sends again is not too old.
const YAML: &str = "\
/**:
  ros__parameters:
    solver: {dt: 1.0e-4}
    response: {duration: 10.0}
    event: {max_age: 600.0}
    real_time: {priority: 0, lock_memory: false, threads: 2}
/hall/c0: {ros__parameters: {}}
/hall/c1: {ros__parameters: {}}
/hall/c2: {ros__parameters: {}}
";

fn run(domain: &Domain, folder: &Path, states: &Path) -> Program {
    fs::write(folder.join("fleet.yaml"), YAML).expect("written");
    let mut command = Process::new(env!("CARGO_BIN_EXE_column-twin"));
    let directory = format!("state.directory:={}", states.display());
    command.args(["fleet", "--params-file", "fleet.yaml"]);
    command.args(["--ros-args", "-p", &directory]);
    let mut program = Program::spawn(domain, folder, command);
    program.wait_for("is ready in domain");
    program
}

fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(since.expect("a time").as_nanos()).expect("a time")
}

/// A publisher of events that the fleet reads.
fn sender(node: &mut Node) -> Publisher<ImpactEvent> {
    let publisher = node
        .publisher::<ImpactEvent>(&qos::IMPACT_EVENT)
        .expect("a publisher");
    let deadline = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(publisher.guid(), 1, deadline));
    publisher
}

#[test]
fn a_shard_that_moves_in_the_middle_of_impacts_loses_nothing() {
    let folders = [(); 3].map(|()| tempfile::tempdir().expect("a folder"));
    let [here, there, states] = [0, 1, 2].map(|it: usize| folders[it].path());
    let domain = Domain::fresh();
    let first = run(&domain, here, states);
    let mut node = reader(&domain);
    let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
    let moving = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let publisher = sender(&mut node);
    for column in ["c1", "c2"] {
        publisher.publish(event(column, "a", now())).expect("sent");
    }
    let mut predicted = BTreeMap::new();
    forecasts.find("both forecasts", |it| {
        predicted.insert(it.column_id.clone(), it.residual_v1);
        predicted.len() == 2
    });
    moving.find("a column in motion", |it| it.phase == TwinStatus::FREE);
    drop((forecasts, moving));
    drop(node);
    let (status, _, log) = first.terminate();
    assert!(status.success(), "{log:#?}");
    let lost = log.iter().filter(|it| it.contains("lost"));
    assert_eq!(lost.collect::<Vec<_>>(), Vec::<&String>::new());

    // While no process has the shard, there is an impact whose sender sends it again.
    let during_the_move = now();
    let second = run(&domain, there, states);
    let mut node = reader(&domain);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let mut restored = BTreeMap::new();
    statuses.find("all columns", |it| {
        restored.insert(it.column_id.clone(), it.residual_v1);
        restored.len() == 3
    });
    assert_eq!(restored.remove("c0"), Some(0.0));
    for (column, residual) in &predicted {
        assert!(*residual > 1e-4, "{column}: {residual}");
        // Saved as text and in equilibrium again.
        let found = restored[column];
        assert!(
            (found - residual).abs() <= 1e-9 * residual,
            "{column}: predicted {residual}, restored {found}"
        );
    }
    let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
    let publisher = sender(&mut node);
    let again = event("c1", "b", during_the_move);
    publisher.publish(again).expect("sent");
    let forecast = forecasts.find("the forecast", |it| it.event_id == "b");
    assert_eq!(forecast.kind, ImpactReport::FORECAST);
    assert!(forecast.max_v1 > predicted["c1"]);
    drop((statuses, forecasts));
    drop(node);
    let (status, _, log) = second.terminate();
    assert!(status.success(), "{log:#?}");
}
