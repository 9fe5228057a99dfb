//! Lateness of the stream at 1 kHz while eight sensors send 10 000 samples per second each, and while an impact that they detect is
//! estimated, compared with the same node without sensors.

use std::fmt::Write as _;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use column_twin::column::Impact;
use column_twin::estimation::{Readings, simulate_sensors};
use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEstimate, TwinStatus};
use column_twin::parameters::Parameters;
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::{Arrival, Peer};
use super::program::Program;
use super::stream::Impacts;
use super::table::{Ranked, number, row};

const LONGEST: Duration = Duration::from_secs(60);

/// Name, quantity, height \[m\], noise.
const SENSORS: [(&str, &str, f64, f64); 8] = [
    ("a1", "acceleration", 0.5, 0.02),
    ("a2", "acceleration", 1.0, 0.02),
    ("a3", "acceleration", 2.0, 0.02),
    ("v1", "displacement", 1.0, 1e-4),
    ("v2", "displacement", 2.0, 1e-4),
    ("s1", "bending_strain", 0.1, 1e-6),
    ("s2", "bending_strain", 2.0, 1e-6),
    ("s3", "axial_strain", 2.0, 1e-6),
];

/// Rest between two impacts that the sensors detect, in samples: the next one is detected after a second in which nothing was.
const REST: usize = 25_000;

/// What strikes the column of the sensors: it remains elastic.
const MASS: f64 = 200.0;
const VELOCITY: f64 = 0.5;

/// Time after contact in which estimates are computed \[ns\].
const ESTIMATING: i64 = 600_000_000;

/// A program that plays a table of readings until it is dropped.
struct Measuring(Child);

impl Measuring {
    fn start(domain: &Domain, folder: &Path) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_column-twin"))
            .args(["measure", "readings.csv", "--config", "sensors.yaml"])
            .current_dir(folder)
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        Self(child.expect("the program that was built with this benchmark"))
    }
}

impl Drop for Measuring {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn write_sensors(path: &Path) -> std::io::Result<()> {
    let names: Vec<&str> = SENSORS.iter().map(|it| it.0).collect();
    let mut text = format!(
        "/**:\n  ros__parameters:\n    sensors:\n      names: [{}]\n",
        names.join(", ")
    );
    for (name, quantity, height, noise) in SENSORS {
        let _ = writeln!(
            text,
            "      {name}: {{quantity: {quantity}, height: {height:?}, noise: {noise:?}, rate: 10000.0}}"
        ); // a String takes everything
    }
    std::fs::write(path, text)
}

/// Impacts with rest before each of them, for this time.
fn write_readings(folder: &Path, span: Duration) {
    let parameters = Parameters::load(&[folder.join("sensors.yaml")], &[]).expect("sensors");
    let sensors = parameters.sensors();
    let simulate = |impact: Impact, seed| {
        simulate_sensors(
            &parameters.column_properties(),
            &impact,
            0.5,
            &sensors,
            seed,
        )
        .expect("a response")
    };
    let struck = simulate(Impact::rigid(MASS, VELOCITY), 1);
    // The readings before the impact: noise alone.
    let count = sensors.len();
    let before = struck.times.iter().take_while(|time| **time < 0.0).count();
    let still = &struck.values[..before * count];
    let mut values = Vec::new();
    let rows = (1e4 * span.as_secs_f64()) as usize;
    while values.len() < rows * count {
        for _ in 0..REST.div_ceil(before) {
            values.extend_from_slice(still);
        }
        values.extend_from_slice(&struck.values);
    }
    let readings = Readings {
        sensors: count,
        times: (0..values.len() / count)
            .map(|row| 1e-4 * row as f64)
            .collect(),
        values,
    };
    let file = File::create(folder.join("readings.csv")).expect("a file");
    readings.write_csv(file, &sensors).expect("room");
}

/// What one run has shown.
struct Seen {
    /// Lateness of the states \[ms\], those while nothing is estimated first.
    late: [Vec<f64>; 2],
    estimates: usize,
    overruns: u64,
    worst: f64,
}

fn measure(span: Duration, has_sensors: bool) -> Seen {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    write_sensors(&folder.path().join("sensors.yaml")).expect("a file");
    let arguments = [
        "--params-file",
        "sensors.yaml",
        "-p",
        "estimation.accept:=never",
    ];
    let arguments = if has_sensors { &arguments[..] } else { &[] };
    if has_sensors {
        write_readings(folder.path(), span + Duration::from_secs(2));
    }
    let _program = Program::ready(&domain, folder.path(), arguments);
    let mut peer = Peer::new(&domain);
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |_: ColumnState, it| it,
        |it| it.header.stamp,
    );
    let statuses = peer.reader(
        &qos::TWIN_STATUS,
        |it: TwinStatus, _| it,
        |it| it.header.stamp,
    );
    let estimates = peer.reader(
        &qos::IMPACT_ESTIMATE,
        |it: ImpactEstimate, arrival| (it.event_id, arrival.stamp),
        |it| it.header.stamp,
    );
    let _measuring = has_sensors.then(|| Measuring::start(&domain, folder.path()));
    Impacts::new(&mut peer).for_a_while(span);
    let contacts: Vec<_> = estimates.arrivals.try_iter().collect();
    let last = statuses.arrivals.try_iter().last().expect("a status");
    let mut late = [Vec::new(), Vec::new()];
    for Arrival { stamp, source, .. } in states.arrivals.try_iter() {
        let estimating = |(_, contact): &(String, i64)| {
            (*contact..contact.saturating_add(ESTIMATING)).contains(&stamp)
        };
        let is_estimating = contacts.iter().any(estimating);
        late[usize::from(is_estimating)].push(1e-6 * (source - stamp) as f64);
    }
    Seen {
        late,
        estimates: contacts.len(),
        overruns: last.overruns,
        worst: 1e3 * last.worst_lateness,
    }
}

pub fn run(span: Duration) {
    let span = span.min(LONGEST);
    println!(
        "responses for {} s, published at 1 kHz; {} sensors at 10 kHz in batches of 10 ms; ratios to the node without sensors",
        span.as_secs(),
        SENSORS.len()
    );
    let without = measure(span, false);
    let with = measure(span, true);
    let counts = |it: &Seen| {
        [
            number(it.worst),
            it.overruns.to_string(),
            it.estimates.to_string(),
        ]
    };
    row(
        "",
        ["worst [ms]", "skipped", "estimates"].map(str::to_owned),
    );
    row("solver without sensors", counts(&without));
    row("solver with sensors", counts(&with));
    row(
        "published after its deadline",
        [
            "samples",
            "p50 [ms]",
            "p99 [ms]",
            "max [ms]",
            "ratio p50",
            "ratio p99",
        ]
        .map(str::to_owned),
    );
    let [alone, _] = without.late;
    let alone = Ranked::new(alone);
    let [at_rest, estimating] = with.late.map(Ranked::new);
    for (name, late) in [
        ("without sensors", &alone),
        ("with sensors, nothing is detected", &at_rest),
        ("with sensors, an impact is estimated", &estimating),
    ] {
        let [p50, p99] = [50.0, 99.0].map(|it| late.percentile(it));
        let ratios = [50.0, 99.0].map(|it| late.percentile(it) / alone.percentile(it));
        let cells = [p50, p99, late.max(), ratios[0], ratios[1]].map(number);
        row(name, std::iter::once(late.len().to_string()).chain(cells));
    }
}
