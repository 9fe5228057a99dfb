//! The node of a fleet on the wire, and the command as a user types it.

use std::fs;
use std::path::Path;
use std::process::Command as Process;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use column_twin::column::ImpactSpecification;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{
    ColumnState, FleetStatus, ImpactEvent, ImpactReport, PredictImpactRequest,
    PredictImpactResponse, ResetColumnRequest, ResetColumnResponse, TwinStatus,
};
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::{FleetColumns, FleetSources, NodeName};
use column_twin::ros::{
    ImpactOptions, ImpactOutcome, ImpactRequest, LiveColumns, Names, RowImpactOptions, TwinNode,
    qos, send_impact, send_row_impact,
};

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::program::Program;

const NODE: &str = "\
/**:
  ros__parameters:
    solver: {dt: 1.0e-4}
    response: {duration: 0.2}
    state: {directory: ''}
    real_time: {priority: 0, lock_memory: false, threads: 2}
";

/// The parameter file of a fleet of columns `c0`, `c1` and so on.
pub fn yaml(columns: usize) -> String {
    let columns = (0..columns).map(|it| format!("/hall/c{it}:\n  ros__parameters:\n"));
    NODE.to_owned() + &columns.collect::<String>()
}

pub fn fleet(columns: usize) -> FleetColumns {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fleet.yaml");
    fs::write(&path, yaml(columns)).expect("written");
    let sources = FleetSources {
        files: vec![path],
        ..FleetSources::default()
    };
    FleetColumns::load(&NodeName::default(), &sources).expect("right")
}

pub struct Running {
    pub node: TwinNode,
    pub fleet: Arc<LiveColumns>,
}

impl Running {
    pub fn start(domain: &Domain, columns: usize) -> Self {
        let (fleet, outputs) = LiveColumns::start_fleet(&self::fleet(columns)).expect("starts");
        let names = Names::new("/", "column_twin", &[]).expect("valid");
        let node = TwinNode::start(
            &domain.environment,
            names,
            Arc::clone(&fleet),
            outputs,
            None,
            None,
        );
        Self {
            node: node.expect("a node"),
            fleet,
        }
    }
}

pub fn event(column: &str, id: &str, stamp: i64) -> ImpactEvent {
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).expect("a time"),
            frame_id: String::new(),
        },
        column_id: column.to_owned(),
        event_id: id.to_owned(),
        mass: 1500.0,
        velocity: 8.0,
        ..ImpactEvent::default()
    }
}

#[test]
fn columns_share_topics_and_events_for_others_are_ignored() {
    let domain = Domain::fresh();
    let running = Running::start(&domain, 3);
    let mut node = reader(&domain);
    let publisher = node
        .publisher::<ImpactEvent>(&qos::IMPACT_EVENT)
        .expect("a publisher");
    let states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
    let reports = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_REPORT);
    let statuses = Incoming::<FleetStatus>::start(&mut node, &qos::FLEET_STATUS);
    let matched = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(publisher.guid(), 1, matched));
    let stamp = running.fleet.now();
    for (column, id) in [("elsewhere", "x"), ("c2", "a"), ("c0", "b")] {
        publisher.publish(event(column, id, stamp)).expect("sent");
    }
    let mut reported: Vec<_> = (0..2)
        .map(|_| reports.next())
        .map(|it| (it.column_id, it.event_id))
        .collect();
    reported.sort();
    let pairs = [("c0", "b"), ("c2", "a")].map(|(column, id)| (column.to_owned(), id.to_owned()));
    assert_eq!(reported, pairs);
    let mut predicted = std::collections::BTreeSet::new();
    forecasts.find("both forecasts", |it| {
        predicted.insert((it.column_id.clone(), it.event_id.clone()));
        predicted.len() == pairs.len()
    });
    assert!(predicted.iter().eq(&pairs));
    assert!(
        states
            .messages
            .try_iter()
            .all(|it| it.column_id == "c0" || it.column_id == "c2")
    );
    let hit = |status: &FleetStatus, id: &str| {
        status.columns.iter().any(|it| {
            it.event_id == id && it.phase == TwinStatus::IDLE && it.impacts_since_reset == 1
        })
    };
    let status = statuses.find("the status of the columns that were hit", |it| {
        hit(it, "a") || hit(it, "b")
    });
    assert_eq!((status.columns_total, status.ignored), (3, 1));
    drop((states, forecasts, reports, statuses));
    running.node.stop();
}

#[test]
fn a_late_joiner_learns_of_all_columns() {
    const COLUMNS: usize = 250;
    let domain = Domain::fresh();
    let running = Running::start(&domain, COLUMNS);
    for _ in 0..2 {
        let mut node = reader(&domain);
        let statuses = Incoming::<FleetStatus>::start(&mut node, &qos::FLEET_STATUS);
        let mut known = std::collections::BTreeSet::new();
        let last = statuses.find("all columns", |status| {
            assert!(status.columns.len() <= column_twin::fleet::MAX_STATUSES_PER_MESSAGE);
            known.extend(status.columns.iter().map(|it| it.column_id.clone()));
            known.len() == COLUMNS
        });
        assert_eq!(last.columns_total as usize, COLUMNS);
        drop(statuses);
    }
    running.node.stop();
}

/// Asks a service of the fleet until it answers: a request that is sent before the service is found is lost.
pub fn call<Request, Response>(
    domain: &Domain,
    endpoint: qos::Endpoint,
    request: &Request,
) -> Response
where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    let mut node = reader(domain);
    let client = node
        .client::<Request, Response>(&endpoint)
        .expect("a client");
    let deadline = Instant::now() + PATIENCE;
    loop {
        assert!(
            Instant::now() < deadline,
            "{} does not answer",
            endpoint.name
        );
        client.send_request(request.clone()).expect("sent");
        std::thread::park_timeout(Duration::from_millis(200));
        if let Ok(Some((_, answer))) = client.receive_response() {
            return answer;
        }
    }
}

#[test]
fn services_name_a_column() {
    let domain = Domain::fresh();
    let running = Running::start(&domain, 2);
    let predict = qos::Endpoint {
        name: "/column_twin/predict",
        ..qos::PREDICT
    };
    let reset = qos::Endpoint {
        name: "/column_twin/reset_column",
        ..qos::RESET_COLUMN
    };
    let ask = |column: &str| PredictImpactRequest {
        column_id: column.to_owned(),
        mass: 1500.0,
        velocity: 8.0,
        gap: f64::NAN,
        restitution: f64::NAN,
        height: f64::NAN,
        ..PredictImpactRequest::default()
    };
    let answer: PredictImpactResponse = call(&domain, predict, &ask("c1"));
    assert!(answer.success, "{}", answer.message);
    assert_eq!(answer.report.column_id, "c1");
    assert!(answer.report.max_v1 > 0.0);
    for other in ["", "c2"] {
        let answer: PredictImpactResponse = call(&domain, predict, &ask(other));
        assert_eq!(
            (answer.success, answer.rejection_code),
            (false, TwinStatus::REJECTED_OTHER_COLUMN)
        );
        assert!(
            answer.message.contains("is not in this fleet of 2 columns"),
            "{}",
            answer.message
        );
    }
    let of = |column: &str| ResetColumnRequest {
        column_id: column.to_owned(),
    };
    let answer: ResetColumnResponse = call(&domain, reset, &of("c0"));
    assert!(answer.success, "{}", answer.message);
    let answer: ResetColumnResponse = call(&domain, reset, &of("c9"));
    assert_eq!(
        (answer.success, answer.rejection_code),
        (false, TwinStatus::REJECTED_OTHER_COLUMN)
    );
    running.node.stop();
}

/// The answers to a vehicle that hits several columns.
fn send_row(domain: &Domain, id: &str, columns: &[&str], velocity: f64) -> Vec<ImpactReport> {
    let options = RowImpactOptions {
        column_ids: columns.iter().map(|it| (*it).to_owned()).collect(),
        offsets: Vec::new(),
        distances: vec![5.0; columns.len()],
        request: ImpactRequest {
            event_id: Some(id.to_owned()),
            vehicle: "lorry_16t".to_owned(),
            impact: ImpactSpecification {
                mass: f64::NAN,
                velocity,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            match_timeout: PATIENCE,
            answer_timeout: PATIENCE,
        },
    };
    send_row_impact(&domain.environment, &[], &options, &mut |_| {}).expect("answers")
}

#[test]
fn a_vehicle_hits_a_row_of_columns_or_none() {
    let domain = Domain::fresh();
    let running = Running::start(&domain, 5);
    // The third column is not there: nothing is hit.
    let answers = send_row(&domain, "wrong", &["c0", "c1", "c7"], 25.0);
    for report in &answers {
        assert_eq!(
            (report.kind, report.end),
            (ImpactReport::NO_FORECAST, ImpactReport::END_REJECTED)
        );
        let expected = "column \"c7\" is not in this fleet of 5 columns";
        assert!(
            report.action_reason.contains(expected),
            "{}",
            report.action_reason
        );
    }
    assert_eq!(answers.len(), 3);
    // The same identifier, because no column has had it.
    let answers = send_row(&domain, "wrong", &["c0", "c1"], 25.0);
    let [first, second] = &answers[..] else {
        panic!("two answers");
    };
    assert_eq!(
        (first.kind, first.outcome, second.kind),
        (
            ImpactReport::FORECAST,
            ImpactReport::FRACTURED,
            ImpactReport::FORECAST
        ),
        "{}; {}",
        first.action_reason,
        second.action_reason
    );
    assert_eq!(second.velocity, first.impactor_rebound);
    assert!(
        second.vehicle.starts_with("lorry_16t@"),
        "{}",
        second.vehicle
    );
    // A slow one does not get past its first column.
    let answers = send_row(&domain, "slow", &["c2", "c3", "c4"], 1.0);
    assert_eq!(answers[0].kind, ImpactReport::FORECAST);
    for report in &answers[1..] {
        assert_eq!(
            (report.kind, report.end),
            (ImpactReport::NO_FORECAST, ImpactReport::END_NOT_HIT)
        );
        assert!(
            report
                .action_reason
                .starts_with("the row ends at column \"c2\": the column stands"),
            "{}",
            report.action_reason
        );
    }
    running.node.stop();
}

#[test]
fn the_command_impact_finds_a_column_and_asks_for_its_name() {
    let domain = Domain::fresh();
    let running = Running::start(&domain, 2);
    let send = |column: Option<&str>| {
        let options = ImpactOptions {
            column_id: column.map(str::to_owned),
            request: ImpactRequest {
                event_id: None,
                vehicle: String::new(),
                impact: ImpactSpecification {
                    mass: 1500.0,
                    velocity: 2.0,
                    gap: None,
                    restitution: None,
                    height: None,
                    direction: None,
                },
                match_timeout: PATIENCE,
                answer_timeout: PATIENCE,
            },
        };
        send_impact(&domain.environment, &[], &options, &mut |_| {})
    };
    match send(Some("c1")) {
        Ok(ImpactOutcome::Forecast(report)) => assert_eq!(report.column_id, "c1"),
        other => panic!("{other:?}"),
    }
    let several = send(None).expect_err("which one").to_string();
    assert_eq!(
        several,
        "there are twins of several columns: \"c0\", \"c1\"; choose one with --column"
    );
    running.node.stop();
}

/// Runs `column-twin fleet` with these arguments until it ends by itself; its exit code and standard error.
fn ended(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Process::new(env!("CARGO_BIN_EXE_column-twin"))
        .arg("fleet")
        .args(arguments)
        .current_dir(folder)
        .env("XDG_STATE_HOME", folder)
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .expect("the program that was built with this test");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), errors)
}

#[test]
fn bad_input_ends_the_command_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("fleet.yaml"), yaml(2)).expect("written");
    fs::write(folder.join("many.yaml"), yaml(257)).expect("written");
    fs::write(
        folder.join("bad.csv"),
        "namespace,column_id,top.load\n/a,a,heavy\n",
    )
    .expect("written");
    let with = |more: &[&str]| ended(folder, &[&["--params-file", "fleet.yaml"], more].concat());
    for (end, expected) in [
        (
            ended(folder, &[]),
            "a fleet needs columns: give --params-file FILE, --columns FILE, or both",
        ),
        (
            ended(folder, &["--params-file", "absent.yaml"]),
            "absent.yaml",
        ),
        (with(&["--columns", "bad.csv"]), "bad.csv:2"),
        (with(&["--select", "a9,/roof/*"]), "has no a9, /roof/*"),
        (
            with(&[
                "--params-file",
                "many.yaml",
                "--ros-args",
                "-p",
                "sensors.names:=[laser]",
                "-p",
                "sensors.laser.quantity:=displacement",
                "-p",
                "sensors.laser.rate:=1000.0",
                "-p",
                "sensors.laser.height:=1.0",
                "-p",
                "sensors.laser.topic:=lasers",
            ]),
            "name 257 topics of their own",
        ),
        (with(&["--ros-args", "-p", "top.laod:=1.0"]), "top.laod"),
    ] {
        let (code, errors) = end;
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.contains(expected), "{expected}\n{errors}");
    }
}

pub fn program(domain: &Domain, folder: &Path) -> Program {
    let mut command = Process::new(env!("CARGO_BIN_EXE_column-twin"));
    command.args(["fleet", "--params-file", "fleet.yaml"]);
    command.args(["--ros-args", "-p", "state.directory:=states"]);
    let mut program = Program::spawn(domain, folder, command);
    program.wait_for("is ready in domain");
    program
}

#[test]
fn a_fleet_keeps_its_damage_and_its_state_directory_for_itself() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("fleet.yaml"), yaml(3)).expect("written");
    let first = program(&domain, folder);
    let arguments = [
        "--params-file",
        "fleet.yaml",
        "--ros-args",
        "-p",
        "state.directory:=states",
    ];
    let (code, errors) = ended(folder, &arguments);
    assert_eq!(code, Some(1), "{errors}");
    assert!(
        errors.contains("the state directory states is in use by another running fleet"),
        "{errors}"
    );
    let mut node = reader(&domain);
    let publisher = node
        .publisher::<ImpactEvent>(&qos::IMPACT_EVENT)
        .expect("a publisher");
    let reports = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_REPORT);
    let deadline = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(publisher.guid(), 1, deadline));
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .expect("a time");
    let stamp = i64::try_from(since.as_nanos()).expect("a time");
    publisher.publish(event("c1", "a", stamp)).expect("sent");
    assert_eq!(reports.next().column_id, "c1");
    drop(reports);
    let (status, _, log) = first.terminate();
    assert!(status.success(), "{log:#?}");
    assert!(
        log.iter()
            .any(|it| it.contains("column \"c1\": impact \"a\" accepted")),
        "{log:#?}"
    );
    let mut files: Vec<_> = fs::read_dir(folder.join("states"))
        .expect("a folder")
        .map(|it| {
            it.expect("an entry")
                .file_name()
                .into_string()
                .expect("text")
        })
        .collect();
    files.sort();
    assert_eq!(files, ["c1.json", "fleet.lock"]);
    let second = program(&domain, folder);
    let restored = second
        .seen
        .iter()
        .any(|it| it.contains("the damage of 1 columns was restored from states"));
    assert!(restored, "{:#?}", second.seen);
    let mut node = reader(&domain);
    let statuses = Incoming::<FleetStatus>::start(&mut node, &qos::FLEET_STATUS);
    let status = statuses.find("all columns", |it| it.columns.len() == 3);
    let hit: Vec<_> = status
        .columns
        .iter()
        .map(|it| it.residual_v1 > 1e-4)
        .collect();
    assert_eq!(hit, [false, true, false]);
    drop(statuses);
    assert!(second.terminate().0.success());
}
