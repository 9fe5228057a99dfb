//! From the messages of sensors to an impact of the twin: what a signal of a fibre-beam model leads to in a running node.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use column_twin::column::Impact;
use column_twin::estimation::{Readings, simulate_sensors};
use column_twin::evidence::verify;
use column_twin::messages::column_twin_msgs::{
    ConfirmEstimateRequest, ConfirmEstimateResponse, CredibleInterval, ImpactEstimate, ImpactEvent,
    ImpactReport, TwinStatus,
};
use column_twin::parameters::{Parameters, parse_override};
use column_twin::ros::Node;
use column_twin::ros::qos::{self, Endpoint};
use column_twin::sensors::Sensor;
use tempfile::TempDir;

use super::domain::Domain;
use super::loopback::{Incoming, Outgoing, PATIENCE, event, reader};
use super::program::Program;
use super::signals::{Normal, Signal};

/// Columns of the signal: acceleration and displacement of the impact point, strain near the base.
const CHOSEN: [usize; 3] = [1, 3, 4];

/// Rest before the signal and after it, in samples: 4 s and 3 s.
const BEFORE: usize = 40_000;
const AFTER: usize = 30_000;

/// The end of the signal whose mean is what remains, in samples. The column is at rest 80 ms after contact in both tables; a longer
/// end would contain the impact itself, and what remains would be too small.
const TAIL: usize = 300;

const COLUMN: &str = "heb220_s355";

fn config(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("config").join(name)
}

/// The column and its sensors as in the signal of the fibre beam, which is held by a spring at its top and knows no shear, and
/// whose steel hardly hardens.
const OVERRIDES: [&str; 9] = [
    "top.spring_stiffness:=1.0e7",
    "shear.model:=none",
    "hardening.ratio:=0.0",
    "softening.model:=none",
    "geometry.length_below:=0.8",
    "geometry.length_above:=3.2",
    "sensors.accelerometer.height:=0.8",
    "sensors.laser.height:=0.8",
    "sensors.base_strain.height:=0.022",
];

/// The vehicle that strikes in both tables: a rigid mass \[kg\] with this speed \[m/s\].
const MASS: f64 = 1500.0;
const SPEED: f64 = 10.0;

/// A running program with the industrial sensors, and a table of what they read when it is struck.
struct Struck {
    domain: Domain,
    folder: TempDir,
    program: Program,
    node: Node,
}

impl Struck {
    fn new(readings: fn(&Parameters) -> Readings, arguments: &[&str]) -> Self {
        let (domain, folder) = (Domain::fresh(), TempDir::new().unwrap());
        let (column, sensors) = (
            config("heb220_s355.yaml"),
            config("sensors_industrial.yaml"),
        );
        let overrides = OVERRIDES.map(parse_override);
        let parameters = Parameters::load(&[column.clone(), sensors.clone()], &overrides).unwrap();
        let path = folder.path().join("readings.csv");
        write_table(readings(&parameters), &parameters.sensors(), &path);
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command.arg("run");
        command.arg("--config").arg(column);
        command.arg("--config").arg(sensors);
        command.args(["--ros-args", "-p", "state.directory:=''"]);
        for parameter in OVERRIDES.iter().chain(arguments) {
            command.args(["-p", parameter]);
        }
        let mut program = Program::spawn(&domain, folder.path(), command);
        program.wait_for("is ready in domain");
        let node = reader(&domain);
        Self {
            domain,
            folder,
            program,
            node,
        }
    }

    /// Plays the table.
    fn measure(&self) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command.args(["measure", "readings.csv", "--timeout", "30"]);
        for name in ["heb220_s355.yaml", "sensors_industrial.yaml"] {
            command.arg("--config").arg(config(name));
        }
        let domain_id = self.domain.environment.domain_id.to_string();
        command
            .args(OVERRIDES.iter().flat_map(|it| ["-p", it]))
            .current_dir(self.folder.path())
            .env("ROS_DOMAIN_ID", domain_id)
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stdout(Stdio::null())
            .spawn()
            .unwrap()
    }

    fn listen<M: serde::de::DeserializeOwned + Send + 'static>(
        &mut self,
        endpoint: &Endpoint,
    ) -> Incoming<M> {
        Incoming::start(&mut self.node, endpoint)
    }
}

/// A signal of a model of other authorship.
fn fibre_beam(_: &Parameters) -> Readings {
    Signal::read("s02_rigid_10").readings(&CHOSEN, 3).1
}

/// What the model itself says that the sensors read, with their errors by a seed.
fn own_model(parameters: &Parameters) -> Readings {
    let (properties, sensors) = (parameters.column_properties(), parameters.sensors());
    let impact = Impact::rigid(MASS, SPEED);
    simulate_sensors(&properties, &impact, 0.5, &sensors, 7).unwrap()
}

/// The readings of an impact between a column at rest and what remains of it, with the noise of the sensors.
fn write_table(impact: Readings, sensors: &[Sensor], path: &Path) {
    let rows: Vec<_> = impact.rows().map(|(_, values)| values.to_vec()).collect();
    let mean = |rows: &[Vec<f64>]| -> Vec<f64> {
        let sum = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>();
        (0..CHOSEN.len())
            .map(|k| sum(k) / rows.len() as f64)
            .collect()
    };
    // Contact is at least 50 ms after its beginning.
    let (rest, remains) = (mean(&rows[..400]), mean(&rows[rows.len() - TAIL..]));
    let mut normal = Normal::new(4);
    let mut still = |level: &[f64], count: usize| -> Vec<Vec<f64>> {
        let each = |_| {
            let noisy = level.iter().zip(sensors);
            noisy
                .map(|(level, sensor)| level + sensor.noise * normal.next())
                .collect()
        };
        (0..count).map(each).collect()
    };
    let (before, after) = (still(&rest, BEFORE), still(&remains, AFTER));
    let all = [before, rows, after].concat();
    let readings = Readings {
        sensors: CHOSEN.len(),
        times: (0..all.len()).map(|index| 1e-4 * index as f64).collect(),
        values: all.concat(),
    };
    let file = File::create(path).unwrap();
    readings.write_csv(file, sensors).unwrap();
}

fn holds(it: &CredibleInterval, truth: f64) -> bool {
    (it.low..=it.high).contains(&truth)
}

#[test]
fn an_impact_that_is_detected_becomes_one_of_the_twin_and_its_recording_is_verified() {
    let arguments = [
        "estimation.accept:=automatic",
        "record.mode:=always",
        "record.directory:=recordings",
        // The camera's event is not too old on a busy machine.
        "event.max_age:=600.0",
    ];
    let mut struck = Struck::new(fibre_beam, &arguments);
    let estimates = struck.listen::<ImpactEstimate>(&qos::IMPACT_ESTIMATE);
    let reports = struck.listen::<ImpactReport>(&qos::IMPACT_REPORT);
    let statuses = struck.listen::<TwinStatus>(&qos::TWIN_STATUS);
    let events = Outgoing::<ImpactEvent>::start(&struck.domain, &qos::IMPACT_EVENT);
    let mut measuring = struck.measure();
    let mut known = BTreeSet::new();
    let accepted = estimates.find("an accepted estimate", |it| {
        known.insert(it.event_id.clone());
        it.decision == ImpactEstimate::DECISION_ACCEPTED
    });
    // A camera has seen the same impact.
    let stamp = accepted.header.stamp.to_nanos().unwrap() + 20_000_000;
    let seen = ImpactEvent {
        column_id: COLUMN.to_owned(),
        ..event("camera", stamp, MASS, SPEED)
    };
    assert!(events.publish(seen));
    let last = estimates.find("the final estimate", |it| {
        known.insert(it.event_id.clone());
        it.is_final
    });
    println!("{last:#?}");
    assert_eq!(known.len(), 1, "{known:?}");
    assert_eq!(last.merged_event_id, "camera");
    assert_eq!(last.column_id, COLUMN);
    assert!(holds(&last.momentum, MASS * SPEED), "{last:#?}");
    // The table ends with seconds in which nothing happens.
    assert!(measuring.wait().unwrap().success());
    let report = reports.find("a report", |it| it.event_id == last.event_id);
    assert!(report.residual_v1 > 0.04, "{report:#?}");
    let merged = statuses.find("the merged event", |it| it.events_merged == 1);
    assert_eq!(merged.impacts_since_reset, 1, "{merged:#?}");
    // The accepted one is that of the sensors.
    assert_eq!((merged.events_accepted, merged.events_rejected), (1, 0));
    drop((estimates, reports, statuses, events));
    let (status, _, log) = struck.program.terminate();
    assert!(status.success(), "{log:#?}");
    let detected = log
        .iter()
        .filter(|it| it.contains("have detected an impact"));
    assert_eq!(detected.count(), 1, "{log:#?}");
    let recordings = std::fs::read_dir(struck.folder.path().join("recordings")).unwrap();
    let recordings: Vec<_> = recordings.map(|it| it.unwrap().path()).collect();
    let [recording] = &recordings[..] else {
        panic!("{recordings:?}");
    };
    let found = verify(recording).unwrap();
    println!("{found}");
    assert!(found.is_equal(), "{found}");
    assert!(found.estimates.compared > 3, "{found}");
    assert_eq!(
        found.estimates.compared, found.estimates.recorded,
        "{found}"
    );
    assert_eq!(found.unchecked, Vec::<String>::new(), "{found}");
}

#[test]
fn an_impact_that_is_detected_waits_for_the_service_that_confirms_it() {
    /// As another node calls it.
    const CONFIRM: Endpoint = Endpoint {
        name: "/column_twin/confirm_estimate",
        ..qos::CONFIRM_ESTIMATE
    };
    let mut struck = Struck::new(own_model, &["estimation.accept:=confirmation"]);
    let estimates = struck.listen::<ImpactEstimate>(&qos::IMPACT_ESTIMATE);
    let reports = struck.listen::<ImpactReport>(&qos::IMPACT_REPORT);
    let client = struck
        .node
        .client::<ConfirmEstimateRequest, ConfirmEstimateResponse>(&CONFIRM)
        .unwrap();
    let mut measuring = struck.measure();
    let last = estimates.find("the final estimate", |it| it.is_final);
    assert_eq!(last.decision, ImpactEstimate::DECISION_PENDING, "{last:#?}");
    println!("{last:#?}");
    assert!(reports.newest().is_none());
    // Without an error of the model, nothing but the way of the data can move the truth out of the intervals.
    assert!(holds(&last.momentum, MASS * SPEED), "{last:#?}");
    assert!(holds(&last.mass, MASS), "{last:#?}");
    assert!(holds(&last.velocity, SPEED), "{last:#?}");
    // The column reads at rest. Responses with a fractured hinge at the same place used to have up to 15 % of the probability.
    assert!(last.collapsed < 0.01, "{last:#?}");
    let width = (last.momentum.high - last.momentum.low) / last.momentum.mean;
    // A part of the probability belongs to vehicles with a hard, light front, behind which there may be more.
    assert!(width < 0.5, "{last:#?}");
    let deadline = Instant::now() + PATIENCE;
    let request = ConfirmEstimateRequest {
        column_id: COLUMN.to_owned(),
        event_id: last.event_id.clone(),
        accept: true,
    };
    let answer = loop {
        assert!(
            Instant::now() < deadline,
            "{} does not answer",
            CONFIRM.name
        );
        // A request that is sent before the service is found is lost.
        client.send_request(request.clone()).unwrap();
        std::thread::park_timeout(Duration::from_millis(200));
        if let Ok(Some((_, answer))) = client.receive_response() {
            break answer;
        }
    };
    assert!(answer.success, "{answer:?}");
    let report = reports.find("a report", |it| it.event_id == last.event_id);
    assert!(report.residual_v1 > 0.04, "{report:#?}");
    let accepted = estimates.find("the accepted estimate", |it| {
        it.decision == ImpactEstimate::DECISION_ACCEPTED
    });
    assert_eq!(accepted.update, last.update);
    assert!(measuring.wait().unwrap().success());
    drop((estimates, reports));
    let (status, _, log) = struck.program.terminate();
    assert!(status.success(), "{log:#?}");
}
