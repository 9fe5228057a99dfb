//! The sensors of a fleet on the wire: what several columns detect at once, a sensor that dies, and batches for columns that are
//! elsewhere, in one recording that is verified.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command as Process, Stdio};

use column_twin::column::Impact;
use column_twin::estimation::{Readings, simulate_sensors};
use column_twin::evidence::{verify, verify_column};
use column_twin::messages::column_twin_msgs::{
    CorrectDamageRequest, CorrectDamageResponse, FleetStatus, ImpactEstimate, ImpactReport,
};
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::parameters::{Parameters, parse_override};
use column_twin::recording::Reader;
use column_twin::ros::qos;
use column_twin::twin::RejectionCode;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::domain::Domain;
use super::incoming::{Incoming, reader};
use super::node::call;
use super::program::Program;

/// What all columns share: a laser and a strain gauge at 2 kHz.
const SHARED: &str = "\
/**:
  ros__parameters:
    solver: {dt: 1.0e-4}
    response: {duration: 0.3}
    real_time: {priority: 0, lock_memory: false, threads: 2}
    record: {mode: always, directory: recordings}
    estimation: {accept: automatic}
    sensors:
      names: [laser, gauge]
      laser: {quantity: displacement, height: 1.0, noise: 1.0e-4, rate: 2000.0}
      gauge: {quantity: bending_strain, height: 0.1, noise: 1.0e-6, rate: 2000.0}
";

/// Rows of a second.
const RATE: usize = 2000;

/// Seconds of rest before an impact, and after it.
const BEFORE: usize = 3;
const AFTER: usize = 3;

/// What happens to a column.
#[derive(Clone, Copy, PartialEq)]
enum Fate {
    /// A rigid mass of 1.5 t hits it with this speed.
    Struck(f64),
    /// Nothing but noise.
    Quiet,
    /// Nothing, and its strain gauge dies after a second.
    Dying,
}

/// The table of the readings.
fn readings(parameters: &Parameters, fate: Fate, seed: u64) -> Readings {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let sensors = parameters.sensors();
    // Approximately normal.
    let mut noise = || -> f64 {
        let uniform = |bits: u32| f64::from(bits) / f64::from(u32::MAX) - 0.5;
        (0..12).map(|_| uniform(random.next_u32())).sum()
    };
    let mut rows: Vec<[f64; 2]> = Vec::new();
    let mut still = |seconds: usize, level: [f64; 2]| -> Vec<[f64; 2]> {
        (0..seconds * RATE)
            .map(|_| [0, 1].map(|k| level[k] + sensors[k].noise * noise()))
            .collect()
    };
    match fate {
        Fate::Struck(velocity) => {
            rows.extend(still(BEFORE, [0.0; 2]));
            let properties = parameters.column_properties();
            let impact = Impact::rigid(1500.0, velocity);
            let struck = simulate_sensors(&properties, &impact, 1.0, &sensors, seed);
            let struck = struck.expect("simulated");
            rows.extend(struck.rows().map(|(_, values)| [values[0], values[1]]));
            let tail = &rows[rows.len() - RATE / 20..];
            let mean = |k: usize| tail.iter().map(|row| row[k]).sum::<f64>() / tail.len() as f64;
            let remains = [mean(0), mean(1)];
            rows.extend(still(AFTER, remains));
        }
        Fate::Quiet | Fate::Dying => rows.extend(still(BEFORE + AFTER, [0.0; 2])),
    }
    if fate == Fate::Dying {
        rows.iter_mut().skip(RATE).for_each(|row| row[1] = f64::NAN);
    }
    Readings {
        sensors: 2,
        times: (0..rows.len()).map(|it| it as f64 / RATE as f64).collect(),
        values: rows.concat(),
    }
}

/// Plays a table to the fleet, as the sensors of a column would.
fn measure(domain: &Domain, folder: &Path, column: &str, fate: Fate, seed: u64) -> Child {
    let shared = folder.join("shared.yaml");
    let parameters = Parameters::load(&[shared], &[parse_override("record.mode:=off")]);
    let parameters = parameters.expect("admissible");
    let file = File::create(folder.join(format!("{column}.csv"))).expect("created");
    let table = readings(&parameters, fate, seed);
    table
        .write_csv(file, &parameters.sensors())
        .expect("written");
    let mut command = Process::new(env!("CARGO_BIN_EXE_column-twin"));
    command
        .args(["measure", &format!("{column}.csv"), "--timeout", "60"])
        .args([
            "--config",
            "shared.yaml",
            "-p",
            &format!("column_id:={column}"),
        ])
        .current_dir(folder)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .stdout(Stdio::null())
        .spawn()
        .expect("the program that was built with this test")
}

#[test]
fn columns_of_a_fleet_detect_their_impacts_and_the_recording_is_verified() {
    let fates = [
        ("c0", Fate::Struck(6.0)),
        ("c1", Fate::Struck(9.0)),
        ("c2", Fate::Dying),
        ("c3", Fate::Quiet),
        ("elsewhere", Fate::Quiet),
    ];
    let (domain, folder) = (Domain::fresh(), tempfile::tempdir().expect("a folder"));
    let folder = folder.path();
    fs::write(folder.join("shared.yaml"), SHARED).expect("written");
    let columns = (0..4).map(|it| format!("/hall/c{it}:\n  ros__parameters: {{}}\n"));
    let fleet = SHARED.to_owned() + &columns.collect::<String>();
    fs::write(folder.join("fleet.yaml"), fleet).expect("written");
    let mut command = Process::new(env!("CARGO_BIN_EXE_column-twin"));
    command.args(["fleet", "--params-file", "fleet.yaml"]);
    command.args(["--ros-args", "-p", "state.directory:=states"]);
    let mut program = Program::spawn(&domain, folder, command);
    program.wait_for("is ready in domain");
    let mut node = reader(&domain);
    let estimates = Incoming::<ImpactEstimate>::start(&mut node, &qos::IMPACT_ESTIMATE);
    let reports = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_REPORT);
    let statuses = Incoming::<FleetStatus>::start(&mut node, &qos::FLEET_STATUS);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let measuring: Vec<Child> = (1..)
        .zip(fates)
        .map(|(seed, (column, fate))| measure(&domain, folder, column, fate, seed))
        .collect();
    let mut last = BTreeMap::new();
    estimates.find("the final estimates", |it| {
        if it.is_final && it.decision == ImpactEstimate::DECISION_ACCEPTED {
            last.insert(it.column_id.clone(), it.clone());
        }
        last.len() == 2
    });
    for (column, fate) in fates {
        let Fate::Struck(velocity) = fate else {
            assert!(!last.contains_key(column), "{column} was not struck");
            continue;
        };
        let momentum = &last[column].momentum;
        let truth = 1500.0 * velocity;
        assert!((momentum.mean / truth - 1.0).abs() < 0.2, "{momentum:?}");
    }
    let mut reported = BTreeSet::new();
    reports.find("the reports", |it| {
        reported.insert(it.column_id.clone());
        reported.len() == 2
    });
    assert!(reported.iter().eq(last.keys()));
    let dead = statuses.find("the dead sensor", |status| {
        let of = |id: &str| status.columns.iter().find(|it| it.column_id == id);
        of("c2").is_some_and(|it| it.sensor_problem.contains("gauge is dead"))
    });
    assert_eq!((dead.sensors_total, dead.dropped_measurements), (8, 0));
    assert!(dead.sensors_faulty >= 1);
    diagnostics.find("batches for a column that is elsewhere", |array| {
        let sensors = array
            .status
            .iter()
            .find(|it| it.name.ends_with(": sensors"));
        let strays = |it: &&column_twin::messages::diagnostic_msgs::KeyValue| {
            it.key == "batches for columns that are elsewhere or have no sensors"
        };
        sensors
            .and_then(|it| it.values.iter().find(strays))
            .is_some_and(|it| it.value != "0")
    });
    // Somebody measures on a column that is not in the fleet, and on one that is not damaged.
    let correct_damage = |column: &str| -> CorrectDamageResponse {
        let endpoint = qos::Endpoint {
            name: "/column_twin/correct_damage",
            ..qos::CORRECT_DAMAGE
        };
        let request = CorrectDamageRequest {
            column_id: column.to_owned(),
            quantity: CorrectDamageRequest::DISPLACEMENT,
            height: 1.0,
            value: 0.0,
            deviation: 1e-3,
        };
        call(&domain, endpoint, &request)
    };
    let answer = correct_damage("elsewhere");
    let other = RejectionCode::OtherColumn.number();
    assert_eq!((answer.success, answer.rejection_code), (false, other));
    let answer = correct_damage("c3");
    assert_ne!(answer.rejection_code, other, "{answer:?}");
    for mut child in measuring {
        assert!(child.wait().expect("a child").success());
    }
    drop((estimates, reports, statuses, diagnostics));
    let (status, _, log) = program.terminate();
    assert!(status.success(), "{log:#?}");
    let is_told = |text: &str| log.iter().any(|it| it.contains(text));
    assert!(is_told("sensor gauge of column \"c2\" is dead"), "{log:#?}");
    let entries = fs::read_dir(folder.join("recordings")).expect("readable");
    let recordings: Vec<_> = entries.map(|it| it.expect("readable").path()).collect();
    let [recording] = &recordings[..] else {
        panic!("{recordings:?}");
    };
    let found = verify(recording).expect("readable");
    println!("{found}");
    assert!(found.is_equal(), "{found}");
    assert!(found.estimates.compared > 6, "{found}");
    assert_eq!(
        found.estimates.compared, found.estimates.recorded,
        "{found}"
    );
    assert_eq!(found.unchecked, Vec::<String>::new(), "{found}");
    let reader = Reader::open(recording).expect("readable");
    let alone = verify_column(&reader, "c1").expect("readable");
    assert!(alone.is_equal(), "{alone}");
    assert!(alone.estimates.compared > 3, "{alone}");
    assert_eq!(alone.estimates.compared, alone.estimates.recorded);
}
