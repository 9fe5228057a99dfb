//! The memory of a node with readers over many impacts and resets.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEvent, ImpactReport, TwinStatus,
};
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::messages::sensor_msgs::JointState;
use column_twin::messages::std_srvs::{TriggerRequest, TriggerResponse};
use column_twin::messages::visualization_msgs::MarkerArray;
use column_twin::ros::qos::{self, Endpoint};
use futures::executor::block_on;

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::loopback::{Outgoing, event, now};
use super::program::Program;

/// Share of the impacts until buffers, caches and the allocator's arenas have the size that they keep: now and then a thread that
/// computes critical velocities has not ended when the next one starts, and then needs an arena of its own.
const SETTLING_SHARE: u32 = 3;

/// Memory that comes and goes with the load of the machine \[MB\]. RustDDS 0.15.1 grew by 6 to 20 kB at each impact.
const MAX_GROWTH: f64 = 2.0;

/// In how many spans of impacts in a row the memory may grow by more: with a leak it grows in each.
const MAX_SPANS: usize = 3;

/// Lets a column be hit and reset so many times, with a reader of every topic, and prints the memory as a table.
fn flat_over(impacts: u32, every: u32) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "-p",
        "state.directory:=\"\"",
        "-p",
        "real_time.priority:=0",
        "-p",
        "response.duration:=0.02",
    ];
    let program = Program::ready(&domain, folder.path(), &arguments);
    let mut node = reader(&domain);
    let states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let forces = Incoming::<HingeForces>::start(&mut node, &qos::HINGE_FORCES);
    let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
    let reports = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_REPORT);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let joints = Incoming::<JointState>::start(&mut node, &qos::JOINT_STATES);
    let markers = Incoming::<MarkerArray>::start(&mut node, &qos::MARKERS);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let reset = Endpoint {
        name: "/column_twin/reset",
        ..qos::RESET
    };
    let reset = node
        .client::<TriggerRequest, TriggerResponse>(&reset)
        .unwrap();
    // A request or an answer that comes before its reader is known is lost.
    let deadline = Instant::now() + PATIENCE;
    while !matches!(reset.receive_response(), Ok(Some(_))) {
        assert!(Instant::now() < deadline, "the node resets nothing");
        reset.send_request(TriggerRequest::default()).unwrap();
        std::thread::park_timeout(Duration::from_millis(200));
    }
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let begin = Instant::now();
    println!("{:>8} {:>10} {:>8}", "impacts", "MB", "s");
    let mut number = 0;
    let mut hit = |count: u32| {
        let mut last = program.megabytes();
        for _ in 0..count {
            number += 1;
            let id = format!("e{number}");
            assert!(events.publish(event(&id, now(), 1500.0, 10.0)));
            reports.find("the report", |report| report.event_id == id);
            let answer = block_on(reset.async_call_service(TriggerRequest::default())).unwrap();
            assert!(answer.success, "{}", answer.message);
            drop((states.newest(), forces.newest(), forecasts.newest()));
            drop((statuses.newest(), joints.newest(), markers.newest()));
            drop(diagnostics.newest());
            if number % every == 0 {
                last = program.megabytes();
                let took = begin.elapsed().as_secs_f64();
                println!("{number:>8} {last:>10.2} {took:>8.1}");
            }
        }
        last
    };
    let settling = impacts / SETTLING_SHARE;
    let mut before = hit(settling);
    // Queues that have never been as full as on a loaded machine grow once; a leak grows in every span.
    let grown: Vec<f64> = (0..MAX_SPANS)
        .map(|_| {
            let after = hit(impacts - settling);
            let growth = after - std::mem::replace(&mut before, after);
            println!("{growth:.2} MB over {} impacts", impacts - settling);
            growth
        })
        .take_while(|growth| *growth >= MAX_GROWTH)
        .collect();
    assert!(grown.len() < MAX_SPANS, "{grown:?} MB");
    drop(events);
    assert!(program.terminate().0.success());
}

#[test]
fn impacts_and_resets_do_not_grow_the_memory() {
    flat_over(1500, 100);
}

#[test]
#[ignore = "slow: ten thousand impacts take ten minutes"]
fn ten_thousand_impacts_and_resets_do_not_grow_the_memory() {
    flat_over(10_000, 1000);
}
