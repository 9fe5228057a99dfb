//! A managed node: what it takes and gives out in each state, with real peers.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use column_twin::live::LiveOptions;
use column_twin::messages::column_twin_msgs::{ImpactEvent, ImpactReport, TwinStatus};
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::messages::lifecycle_msgs::{
    ChangeStateRequest, ChangeStateResponse, Transition, TransitionEvent,
};
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{ImpactOutcome, LiveColumns, Names, Node, StartOptions, TwinNode};
use ros2_client::Client;

use super::domain::Domain;
use super::live_twin::parameters;
use super::loopback::{Incoming, Outgoing, PATIENCE, event, impact, now, reader};
use super::program::Program;

/// The services and the topic of the node, as others name them.
const CHANGE_STATE: Endpoint = Endpoint {
    name: "/column_twin/change_state",
    ..qos::CHANGE_STATE
};
const TRANSITION_EVENT: Endpoint = Endpoint {
    name: "/column_twin/transition_event",
    ..qos::TRANSITION_EVENT
};

/// Starts a managed node; the receiver is told when it is asked to shut down.
fn managed(domain: &Domain) -> (TwinNode, Receiver<()>) {
    let (columns, outputs) =
        LiveColumns::start_one(parameters(&[]), LiveOptions::default()).unwrap();
    let names = Names::new("/", "column_twin", &[]).unwrap();
    let (asked, shut_down) = sync_channel(1);
    let options = StartOptions {
        managed: Some(Box::new(move || asked.try_send(()).unwrap())),
        ..StartOptions::default()
    };
    let environment = &domain.environment;
    let node = TwinNode::start_with(environment, names, columns, outputs, None, None, options);
    (node.unwrap(), shut_down)
}

/// Asks for transitions, as `ros2 lifecycle set` does.
struct Manager(Client<ChangeStateRequest, ChangeStateResponse>);

impl Manager {
    /// Asks until there is an answer: a request that is sent before the service is found is lost, so that the first transition must
    /// be one that is rejected.
    fn meet(domain: &Domain) -> (Node, Self) {
        let mut node = reader(domain);
        let manager = Self(node.client(&CHANGE_STATE).unwrap());
        let deadline = Instant::now() + PATIENCE;
        while manager.asked("deactivate", Duration::from_millis(500)) != Some(false) {
            assert!(
                Instant::now() < deadline,
                "~/change_state does not answer, or accepts a transition of another state"
            );
        }
        // Answers to earlier requests.
        while manager.answered(Duration::from_millis(500)).is_some() {}
        (node, manager)
    }

    fn asked(&self, label: &str, patience: Duration) -> Option<bool> {
        let request = ChangeStateRequest {
            transition: Transition {
                id: 0,
                label: label.to_owned(),
            },
        };
        self.0.send_request(request).unwrap();
        self.answered(patience)
    }

    fn answered(&self, patience: Duration) -> Option<bool> {
        let deadline = Instant::now() + patience;
        while Instant::now() < deadline {
            if let Ok(Some((_, answer))) = self.0.receive_response() {
                return Some(answer.success);
            }
            std::thread::park_timeout(Duration::from_millis(10));
        }
        None
    }

    fn change(&self, label: &str) -> bool {
        let answer = self.asked(label, PATIENCE);
        answer.unwrap_or_else(|| panic!("no answer to {label}"))
    }
}

fn rejected(array: &DiagnosticArray) -> Option<u64> {
    let mut values = array.status.iter().flat_map(|status| &status.values);
    let value = values.find(|it| it.key == "rejected while not active")?;
    value.value.parse().ok()
}

#[test]
fn only_an_active_node_takes_impacts_and_no_impact_is_lost_unseen() {
    let domain = Domain::fresh();
    let (twin, shut_down) = managed(&domain);
    let (mut node, manager) = Manager::meet(&domain);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let transitions = Incoming::<TransitionEvent>::start(&mut node, &TRANSITION_EVENT);
    let deadline = Instant::now() + PATIENCE;
    assert!(twin.matches().wait_for_peer(transitions.guid, deadline));
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
    let reports = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_REPORT);

    // Unconfigured: nobody subscribes to impacts.
    diagnostics.find("the state", |it| {
        it.status
            .iter()
            .any(|it| it.message == "unconfigured: impacts are rejected")
    });
    let nobody = impact(&domain, 1500.0, Duration::from_millis(300));
    assert!(nobody.unwrap_err().contains("no twin subscribes"));
    assert!(!manager.change("activate"));

    // Inactive: they are counted and rejected.
    assert!(manager.change("configure"));
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    assert!(events.publish(event("too early", now(), 1500.0, 1.0)));
    diagnostics.find("the rejected impact", |it| rejected(it) == Some(1));
    assert!(statuses.newest().is_none(), "an inactive node is silent");

    // Active: as every twin.
    assert!(manager.change("activate"));
    let status = statuses.find("the status", |_| true);
    assert_eq!((status.events_accepted, status.events_rejected), (0, 0));
    assert!(events.publish(ImpactEvent {
        // A long approach: the node is deactivated before the end of the response.
        gap: 1.5,
        ..event("in time", now(), 1500.0, 1.0)
    }));
    let forecast = forecasts.next();
    assert_eq!(forecast.event_id, "in time");
    assert!(!manager.change("configure"));
    // In the middle of the response, whose end is still told.
    assert!(reports.newest().is_none(), "the response has ended");
    assert!(manager.change("deactivate"));
    assert_eq!(reports.next().event_id, "in time");
    statuses.find("the end of the response", |it| {
        it.events_accepted == 1 && it.is_at_rest()
    });
    assert!(events.publish(event("too late", now(), 1500.0, 1.0)));
    diagnostics.find("the second rejected impact", |it| rejected(it) == Some(2));

    assert!(manager.change("cleanup"));
    assert!(manager.change("shutdown"));
    shut_down.recv_timeout(PATIENCE).unwrap();
    assert!(!manager.change("shutdown"));
    let mut ids = Vec::new();
    transitions.find("the last transition", |it| {
        ids.push(it.transition.id);
        it.transition.id == 50
    });
    assert_eq!(ids, [1, 10, 3, 30, 4, 40, 2, 20, 5, 50]);
    drop((
        diagnostics,
        transitions,
        statuses,
        forecasts,
        reports,
        events,
    ));
    twin.stop();
}

#[test]
fn a_node_that_is_configured_again_takes_impacts_again() {
    let domain = Domain::fresh();
    let (twin, _shut_down) = managed(&domain);
    let (_node, manager) = Manager::meet(&domain);
    for label in [
        "configure",
        "activate",
        "deactivate",
        "cleanup",
        "configure",
        "activate",
    ] {
        assert!(manager.change(label), "{label}");
    }
    match impact(&domain, 1500.0, PATIENCE) {
        Ok(ImpactOutcome::Forecast(report)) => assert!(report.max_v1 > 0.0),
        other => panic!("{other:?}"),
    }
    twin.stop();
}

#[test]
fn the_transition_to_finalized_ends_the_process_in_order() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_column-twin"));
    command.args(["run", "--managed"]);
    let mut program = Program::spawn(&domain, folder.path(), command);
    let ready = program.wait_for("is ready in domain");
    assert!(ready.contains("it is managed and unconfigured"), "{ready}");
    let (_node, manager) = Manager::meet(&domain);
    assert!(manager.change("configure"));
    assert!(manager.change("shutdown"), "the answer is sent");
    let (status, log) = program.end();
    assert!(status.success(), "{status}: {log:#?}");
    assert!(
        log.iter().any(|line| line.ends_with("stopping")),
        "{log:#?}"
    );
}
