//! Collapses under way, beside impacts that the column just survives.
//!
//! A collapse is inevitable from the first instant on from which the column gives way even if the vehicle vanished. The impacts are
//! drawn by a seed, on columns that differ from what the estimator knows of them; nothing in the estimator was chosen by them.

use std::sync::OnceLock;

use column_twin::column::{
    ColumnProperties, End, Impact, Model, Progress, Response, State, Vehicle, simulate,
};
use column_twin::estimation::{
    Estimator, Readings, RecordedImpact, estimate_prepared, hypotheses, simulate_sensors,
};
use column_twin::parameters::Parameters;
use column_twin::sensors::Sensor;
use column_twin::standing::StandingColumn;

use super::beam_signals::{plateau, spring};
use super::made_impacts::{parameters, real_column};
use super::signals::{Normal, industrial};

/// Lengths below and above the impact point \[m\].
const COLUMN: [f64; 2] = [1.0, 3.0];

/// Speeds, relative to the least one at which the column collapses.
const COLLAPSES: [f64; 3] = [1.1, 1.25, 1.6];
const NEAR_MISSES: [f64; 3] = [0.95, 0.85, 0.7];

/// How long after a collapse has become inevitable it has to be told \[s\].
const WITHIN: f64 = 0.020;

/// Longest time for which a response is followed \[s\].
const LONGEST: f64 = 1.0;

/// The readings end so long after the event \[s\].
const END: f64 = 0.35;

/// Instants at which it is tried whether the vehicle may vanish are so far apart \[s\].
const SPACING: f64 = 0.5e-3;

fn gives_way(end: End) -> bool {
    matches!(end, End::Collapsed | End::Fractured)
}

/// How the response ends that continues from here.
fn end_of(model: &Model, mut response: Response, mut state: State) -> End {
    loop {
        match response.advance(model, &mut state, u64::MAX) {
            Ok(Progress::Running) => {}
            Ok(Progress::Over(end)) => return end,
            Err(fault) => panic!("{fault}"),
        }
    }
}

/// The first instant after the event from which on the column gives way without the vehicle, too \[s\]; `None` if it stands.
fn inevitable(column: &ColumnProperties, impact: &Impact) -> Option<f64> {
    let model = Model::new(&column.before(impact)).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, *impact, LONGEST).expect("an impact");
    let mut instants = vec![(0.0, response, state)];
    loop {
        let progress = response.advance(&model, &mut state, 1).expect("a step");
        let now = model.time_of_step(state.step);
        if let Progress::Over(end) = progress {
            if !gives_way(end) {
                return None;
            }
            break;
        }
        if now >= SPACING * instants.len() as f64 {
            instants.push((now, response, state));
        }
    }
    let is_inevitable = |(_, response, state): &(f64, Response, State)| {
        let mut alone = *state;
        alone.impactor = None;
        gives_way(end_of(&model, *response, alone))
    };
    let first = instants.partition_point(|it| !is_inevitable(it));
    // It gives way in the last step otherwise.
    Some(
        instants
            .get(first)
            .map_or(model.time_of_step(state.step), |it| it.0),
    )
}

/// The least speed at which this vehicle makes the column give way \[m/s\], to 1 %.
fn critical_speed(column: &ColumnProperties, with: &dyn Fn(f64) -> Impact) -> f64 {
    let is_too_fast = |speed: f64| {
        let report = simulate(column, &with(speed), LONGEST, &mut |_| {}).expect("a response");
        !report.outcome.stands()
    };
    let [mut low, mut high] = [0.3_f64, 40.0];
    assert!(!is_too_fast(low) && is_too_fast(high));
    while high > 1.01 * low {
        let middle = (low * high).sqrt();
        match is_too_fast(middle) {
            true => high = middle,
            false => low = middle,
        }
    }
    high
}

fn drawn(normal: &mut Normal, median: f64, deviation: f64) -> f64 {
    median * (deviation * normal.next().clamp(-1.5, 1.5)).exp()
}

/// A vehicle by its kind, as a function of its speed.
fn vehicle(kind: &str, normal: &mut Normal) -> Box<dyn Fn(f64) -> Impact> {
    let mut about = |median, deviation| drawn(normal, median, deviation);
    let (mass, springs) = match kind {
        "rigid" => (about(3000.0, 0.5), None),
        "elastic" => (
            about(6000.0, 0.5),
            Some(spring(&[[1.0, about(800e3, 0.5)]])),
        ),
        "crushed" => (
            about(9000.0, 0.4),
            Some(plateau(about(3e6, 0.5), about(1.1e6, 0.2))),
        ),
        _ => unreachable!("{kind}"),
    };
    let vehicle = springs.map(|it| Vehicle::new(&[mass], &[it]).expect("a vehicle"));
    Box::new(move |speed| Impact {
        vehicle,
        ..Impact::rigid(mass, speed)
    })
}

fn sensors() -> Vec<Sensor> {
    let all = industrial(COLUMN[0], COLUMN[0] + COLUMN[1]);
    [2, 3, 4, 5].map(|k: usize| all[k].clone()).to_vec()
}

fn known() -> Parameters {
    parameters(COLUMN)
}

/// An estimator for them, prepared once.
fn prepared() -> Estimator {
    static PREPARED: OnceLock<Estimator> = OnceLock::new();
    let prepare = || {
        let parameters = known();
        let column = StandingColumn::undamaged(&parameters);
        let hypotheses = hypotheses(&parameters);
        let mut estimator =
            Estimator::new(&parameters, &column, sensors(), hypotheses, 1).expect("sensors");
        while !estimator.prepare() {}
        estimator
    };
    PREPARED.get_or_init(prepare).clone()
}

/// What the estimator says of an impact on the column as it is.
fn estimated(column: &ColumnProperties, impact: &Impact, seed: u64) -> RecordedImpact {
    let sensors = sensors();
    let readings = simulate_sensors(column, impact, LONGEST, &sensors, seed).expect("readings");
    let rows = readings.times.partition_point(|time| *time < END);
    let readings = Readings {
        times: readings.times[..rows].to_vec(),
        values: readings.values[..rows * sensors.len()].to_vec(),
        ..readings
    };
    estimate_prepared(&mut prepared(), &readings)
        .expect("sensors")
        .unwrap_or_else(|| panic!("{impact:?} is not detected"))
}

fn course(found: &RecordedImpact) -> String {
    let each = found
        .estimates
        .iter()
        .map(|it| format!("{:.0}:{:.2}", 1e3 * it.data_until, it.collapsed));
    each.collect::<Vec<_>>().join(" ")
}

#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn a_collapse_is_told_within_20_ms_of_becoming_inevitable_and_a_near_miss_is_none() {
    let known = known().column_properties();
    let mut normal = Normal::new(31);
    let (mut late, mut wrong, mut count) = (Vec::new(), Vec::new(), 0);
    for kind in ["rigid", "elastic", "crushed"] {
        for seed in 0..3 {
            let column = real_column(&known, &mut normal);
            let with = vehicle(kind, &mut normal);
            let critical = critical_speed(&column, &with);
            for factor in COLLAPSES.into_iter().chain(NEAR_MISSES) {
                let impact = with(factor * critical);
                let since = inevitable(&column, &impact);
                let found = estimated(&column, &impact, seed);
                let first = found.estimates.iter().find(|it| it.tells_collapse());
                let first = first.map(|it| it.data_until);
                let last = found.estimates.last().expect("an estimate");
                let case = format!(
                    "{kind} {seed}: {:.0} kg at {factor} of {critical:.1} m/s, inevitable {:.1?}, told {:.1?}, last {:.2} {} {:?}; {}",
                    impact.mass,
                    since.map(|it| 1e3 * it),
                    first.map(|it| 1e3 * it),
                    last.collapsed,
                    last.vehicle_probabilities[0].0,
                    last.doubtful_sensors,
                    course(&found),
                );
                println!("{case}");
                count += 1;
                let is_late = |since: f64| {
                    first.is_none_or(|first| first > since + WITHIN) || !last.tells_collapse()
                };
                match since {
                    Some(since) if is_late(since) => late.push(case),
                    Some(_) => {}
                    None if first.is_some() => wrong.push(case),
                    None => {}
                }
            }
        }
    }
    println!("{count} impacts");
    assert!(late.is_empty(), "late: {late:#?}");
    assert!(wrong.is_empty(), "wrong: {wrong:#?}");
}
