//! Fifty ways in which a sensor can lie, each in the readings of two impacts of the fibre beam.
//!
//! A lie may do no harm, or it has to be told: by an error, by a sensor that is doubtful, or by a vehicle of an unknown kind. None may
//! move the peak by more than 10 %, outside of its interval, without a word.

use column_twin::column::Impact;
use column_twin::estimation::{
    Estimator, ImpactEstimate, Readings, UNKNOWN_VEHICLE, estimate_prepared, hypotheses,
};
use column_twin::sensors::Sensor;
use column_twin::standing::StandingColumn;

use super::beam_signals::{
    AFTER, BEFORE, BeamSignal, column, deformable, parameters, sensors, spring,
};
use super::signals::{Normal, PERIOD};

/// A sensor that lies, and how.
struct Lie {
    sensor: &'static str,
    name: &'static str,
    how: How,
}

#[derive(Clone, Copy)]
enum How {
    /// It reads so many times what it should; units and signs are factors, too.
    Factor(f64),
    /// It is at another height \[m\] than the declared one.
    Height(f64),
    /// Its cable is that of another sensor.
    Swapped(&'static str),
    /// Its samples come so late, by their times \[s\].
    Late(f64),
    /// Its clock is fast by this share.
    Fast(f64),
    /// From so long after contact on \[s\] it repeats its last value.
    Stuck(f64),
    /// The same, and it reads 0.
    Zero(f64),
    /// The same, and there are no samples.
    Dead(f64),
    /// The same, and it hangs by its cable.
    Loose(f64),
    /// It ends at this share of its largest reading, and its range says nothing of it.
    Saturated(f64),
    /// Its steps are this share of its largest reading.
    Quantised(f64),
    /// A filter of the first order at this frequency \[Hz\].
    Filtered(f64),
    /// So many times the noise that is declared.
    Noise(f64),
    /// It drifts by this share of its largest reading each second.
    Drift(f64),
    /// Of so many samples only the first one comes.
    Rate(usize),
}

const fn lie(sensor: &'static str, name: &'static str, how: How) -> Lie {
    Lie { sensor, name, how }
}

const V1: &str = "v1";
const ACCELERATION: &str = "a_075L";
const BASE: &str = "bend_base";
const MIDDLE: &str = "bend_mid";

const LIES: [Lie; 50] = [
    lie(V1, "gain 10 % too high", How::Factor(1.1)),
    lie(V1, "gain 10 % too low", How::Factor(0.9)),
    lie(V1, "gain 30 % too high", How::Factor(1.3)),
    lie(V1, "gain of one half", How::Factor(0.5)),
    lie(V1, "sign", How::Factor(-1.0)),
    lie(V1, "millimetres", How::Factor(1e3)),
    lie(V1, "0.2 m too high", How::Height(0.6)),
    lie(V1, "0.3 m too low", How::Height(1.1)),
    lie(V1, "5 ms late", How::Late(5e-3)),
    lie(V1, "5 ms early", How::Late(-5e-3)),
    lie(V1, "clock 3 % fast", How::Fast(0.03)),
    lie(V1, "stuck from 4 ms on", How::Stuck(4e-3)),
    lie(V1, "0 from 4 ms on", How::Zero(4e-3)),
    lie(V1, "dead from 4 ms on", How::Dead(4e-3)),
    lie(V1, "loose from 3 ms on", How::Loose(3e-3)),
    lie(V1, "saturated at 60 %", How::Saturated(0.6)),
    lie(V1, "quantised in fifths", How::Quantised(0.2)),
    lie(V1, "filtered at 30 Hz", How::Filtered(30.0)),
    lie(V1, "30 times the noise", How::Noise(30.0)),
    lie(V1, "drift", How::Drift(1.0)),
    lie(V1, "every second sample", How::Rate(2)),
    lie(ACCELERATION, "gain 30 % too high", How::Factor(1.3)),
    lie(ACCELERATION, "gain of one half", How::Factor(0.5)),
    lie(ACCELERATION, "sign", How::Factor(-1.0)),
    lie(ACCELERATION, "g", How::Factor(1.0 / 9.806_65)),
    lie(ACCELERATION, "2 m too high", How::Height(1.0)),
    lie(ACCELERATION, "5 ms late", How::Late(5e-3)),
    lie(ACCELERATION, "stuck from 4 ms on", How::Stuck(4e-3)),
    lie(ACCELERATION, "dead from 4 ms on", How::Dead(4e-3)),
    lie(ACCELERATION, "loose from 3 ms on", How::Loose(3e-3)),
    lie(ACCELERATION, "saturated at 20 %", How::Saturated(0.2)),
    lie(ACCELERATION, "filtered at 100 Hz", How::Filtered(100.0)),
    lie(BASE, "gain 10 % too high", How::Factor(1.1)),
    lie(BASE, "gain twice too high", How::Factor(2.0)),
    lie(BASE, "sign", How::Factor(-1.0)),
    lie(BASE, "microstrains", How::Factor(1e6)),
    lie(BASE, "0.23 m too low", How::Height(0.25)),
    lie(BASE, "5 ms late", How::Late(5e-3)),
    lie(BASE, "stuck from 4 ms on", How::Stuck(4e-3)),
    lie(BASE, "dead from 4 ms on", How::Dead(4e-3)),
    lie(BASE, "loose from 3 ms on", How::Loose(3e-3)),
    lie(BASE, "saturated at half", How::Saturated(0.5)),
    lie(BASE, "quantised in fifths", How::Quantised(0.2)),
    lie(
        BASE,
        "swapped with the gauge at mid-height",
        How::Swapped(MIDDLE),
    ),
    lie(MIDDLE, "gain 30 % too low", How::Factor(0.7)),
    lie(MIDDLE, "sign", How::Factor(-1.0)),
    lie(MIDDLE, "0.8 m too high", How::Height(1.2)),
    lie(MIDDLE, "5 ms early", How::Late(-5e-3)),
    lie(MIDDLE, "filtered at 30 Hz", How::Filtered(30.0)),
    lie(
        MIDDLE,
        "swapped with the displacement sensor",
        How::Swapped(V1),
    ),
];

/// Lies that move the peak and that nothing tells but the note that the scale of the sensor is not confirmed, with the impact. Where a rigid
/// hit makes the column yield, this note is there without a lie as well, because nothing tells the scale of the displacement: the gauges are
/// lost within milliseconds, the waves keep the accelerometer at the end of its range, and a lighter, faster vehicle explains a larger
/// displacement as well.
const TOLD_BY_THE_NOTE: [(&str, &str, &str); 4] = [
    ("rigid", V1, "gain 30 % too high"),
    ("rigid", V1, "gain of one half"),
    ("rigid", V1, "0.2 m too high"),
    ("elastic", V1, "gain 30 % too high"),
];

/// Largest error of a peak outside of its interval.
const TOLERATED: f64 = 0.10;

/// Beginning of what is told where no other sensor confirms a scale.
const NOTE: &str = "unconfirmed scale";

/// Probability of an unknown vehicle that is a doubt.
const DOUBTED: f64 = 0.5;

const SEED: u64 = 5;

/// The sensors, and behind them those that are elsewhere than they are declared.
fn sensors_and_others() -> Vec<Sensor> {
    let mut all = sensors();
    for lie in &LIES {
        if let How::Height(height) = lie.how {
            let declared = &all[index(lie.sensor)];
            all.push(Sensor {
                name: format!("{} at {height} m", lie.sensor),
                height,
                ..declared.clone()
            });
        }
    }
    all
}

fn index(name: &str) -> usize {
    let mut names = sensors().into_iter().map(|it| it.name);
    names.position(|it| it == name).expect("a sensor")
}

fn column_of(readings: &Readings, sensor: usize) -> Vec<f64> {
    readings.rows().map(|(_, values)| values[sensor]).collect()
}

/// The readings of one sensor that lies so; `exact` holds those of all sensors and of those elsewhere.
fn told(lie: &Lie, all: &[Sensor], readings: &Readings) -> Vec<f64> {
    let sensor = index(lie.sensor);
    let mut values = column_of(readings, sensor);
    let rest = values[0];
    let largest = values
        .iter()
        .fold(0.0_f64, |most, it| most.max((it - rest).abs()));
    let from = |since: f64| ((BEFORE + since) / PERIOD).round() as usize;
    let shifted = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let last = values.len() - 1;
        let at = |row: usize| (of(row as f64).round().max(0.0) as usize).min(last);
        (0..values.len()).map(|row| values[at(row)]).collect()
    };
    match lie.how {
        How::Factor(factor) => values.iter_mut().for_each(|it| *it *= factor),
        How::Height(height) => {
            let name = format!("{} at {height} m", lie.sensor);
            let there = all.iter().position(|it| it.name == name);
            values = column_of(readings, there.expect("a sensor elsewhere"));
        }
        How::Swapped(other) => values = column_of(readings, index(other)),
        How::Late(late) => values = shifted(&|row| row - late / PERIOD),
        How::Fast(share) => values = shifted(&|row| row / (1.0 + share)),
        How::Stuck(since) => {
            let held = values[from(since)];
            values[from(since)..].fill(held);
        }
        How::Zero(since) => values[from(since)..].fill(0.0),
        How::Dead(since) => values[from(since)..].fill(f64::NAN),
        How::Loose(since) => {
            for (row, value) in values.iter_mut().enumerate().skip(from(since)) {
                let hanging = (row - from(since)) as f64 * PERIOD;
                let swing = (std::f64::consts::TAU * 25.0 * hanging).sin();
                *value = rest + (*value - rest) * (-hanging / 5e-3).exp() + 0.5 * largest * swing;
            }
        }
        How::Saturated(share) => {
            let range = share * largest;
            values
                .iter_mut()
                .for_each(|it| *it = rest + (*it - rest).clamp(-range, range));
        }
        How::Quantised(share) => {
            let step = share * largest;
            values
                .iter_mut()
                .for_each(|it| *it = step * (*it / step).round());
        }
        How::Filtered(frequency) => {
            let share = 1.0 - (-std::f64::consts::TAU * frequency * PERIOD).exp();
            let mut filtered = rest;
            for value in &mut values {
                filtered += share * (*value - filtered);
                *value = filtered;
            }
        }
        How::Noise(times) => {
            let mut normal = Normal::new(SEED);
            let noise = times * all[sensor].noise;
            values
                .iter_mut()
                .for_each(|it| *it += noise * normal.next());
        }
        How::Drift(share) => {
            let step = share * largest * PERIOD;
            for (row, value) in values.iter_mut().enumerate() {
                *value += step * row as f64;
            }
        }
        How::Rate(one_of) => {
            for (row, value) in values.iter_mut().enumerate() {
                if row % one_of != 0 {
                    *value = f64::NAN;
                }
            }
        }
    }
    values
}

/// The readings of all sensors as they are declared, with this lie.
fn with_lie(lie: Option<&Lie>, all: &[Sensor], readings: &Readings) -> Readings {
    let count = sensors().len();
    let mut columns: Vec<Vec<f64>> = (0..count).map(|it| column_of(readings, it)).collect();
    if let Some(lie) = lie {
        if let How::Swapped(other) = lie.how {
            columns[index(other)] = column_of(readings, index(lie.sensor));
        }
        columns[index(lie.sensor)] = told(lie, all, readings);
    }
    let rows = 0..readings.times.len();
    Readings {
        sensors: count,
        times: readings.times.clone(),
        values: rows
            .flat_map(|row| columns.iter().map(move |it| it[row]))
            .collect(),
    }
}

/// What tells that something is wrong with this lie, if anything does. That no other sensor confirms the scale of the one that lies is told
/// of this lie only if it is one of scale.
fn doubt(estimate: &ImpactEstimate, lie: Option<&Lie>) -> Option<String> {
    if !estimate.doubtful_sensors.is_empty() {
        return Some(estimate.doubtful_sensors.join(" and "));
    }
    let mut unknown = estimate.vehicle_probabilities.iter();
    let unknown = unknown.find(|(name, share)| name == UNKNOWN_VEHICLE && *share >= DOUBTED);
    if let Some((name, share)) = unknown {
        return Some(format!("{name} vehicle {:.0} %", 100.0 * share));
    }
    let of_scale = lie.filter(|it| {
        let changes_scale = matches!(it.how, How::Factor(_) | How::Height(_) | How::Filtered(_));
        let names = &estimate.scale_not_confirmed;
        changes_scale && names.iter().any(|name| name == it.sensor)
    });
    of_scale.map(|it| format!("{NOTE} of {}", it.sensor))
}

fn impacts() -> [(&'static str, Impact); 2] {
    [
        ("rigid", Impact::rigid(1500.0, 5.0)),
        (
            "elastic",
            deformable(&[2000.0], &[spring(&[[1.0, 600e3]])], 6.0),
        ),
    ]
}

fn estimator() -> Estimator {
    let parameters = parameters();
    let column = StandingColumn::undamaged(&parameters);
    let hypotheses = hypotheses(&parameters);
    let mut estimator =
        Estimator::new(&parameters, &column, sensors(), hypotheses, 1).expect("sensors");
    while !estimator.prepare() {}
    estimator
}

/// They moved the peak by up to one half without a word.
#[test]
fn a_wrong_gain_a_cut_off_peak_a_drift_and_a_dead_sensor_are_named() {
    let mut estimator = estimator();
    let all = sensors_and_others();
    let [(_, rigid), (_, elastic)] = impacts();
    for (struck, name) in [
        (elastic, "gain of one half"),
        (elastic, "saturated at 60 %"),
        (rigid, "drift"),
        (rigid, "dead from 4 ms on"),
    ] {
        let signal = BeamSignal::of(&column(), struck, &all, AFTER).expect("a response");
        let readings = signal.readings(&all, BEFORE, SEED);
        let lie = LIES.iter().find(|it| it.sensor == V1 && it.name == name);
        let found = estimate_prepared(&mut estimator, &with_lie(lie, &all, &readings));
        let found = found.expect("sensors").expect("an impact");
        let last = found.estimates.last().expect("an estimate");
        assert!(
            last.doubtful_sensors.contains(&V1.to_owned()),
            "{name}: {last:#?}"
        );
    }
}

/// A wrong gain moved the peak of a hit that makes the column yield without a word: nothing else tells the scale of the displacement there.
#[test]
fn a_peak_that_rests_on_one_scale_says_so_unless_the_gauges_confirm_it() {
    let mut estimator = estimator();
    let all = sensors_and_others();
    let [(_, rigid), (_, elastic)] = impacts();
    for (struck, lie, names) in [
        (rigid, None, &[V1] as &[&str]),
        (elastic, None, &[]),
        // The gauges do not contradict it surely, but they do not confirm it.
        (elastic, Some("gain 30 % too high"), &[V1]),
    ] {
        let signal = BeamSignal::of(&column(), struck, &all, AFTER).expect("a response");
        let readings = signal.readings(&all, BEFORE, SEED);
        let lie = LIES
            .iter()
            .find(|it| it.sensor == V1 && Some(it.name) == lie);
        let found = estimate_prepared(&mut estimator, &with_lie(lie, &all, &readings));
        let found = found.expect("sensors").expect("an impact");
        let last = found.estimates.last().expect("an estimate");
        assert_eq!(last.scale_not_confirmed, names, "{last:#?}");
        assert!(last.doubtful_sensors.is_empty(), "{last:#?}");
        assert_eq!(last.scale_reservation().is_some(), !names.is_empty());
    }
}

/// Among them are those that moved the peak by 10 to 60 % outside of its interval: a gain, a wrong height, a swap.
#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn none_of_fifty_lies_moves_the_peak_without_a_doubt_named() {
    let mut estimator = estimator();
    let all = sensors_and_others();
    let (mut silent, mut by_note) = (Vec::new(), Vec::new());
    println!("| impact | sensor | lie | peak | 90 % interval | told |");
    println!("|---|---|---|---|---|---|");
    for (impact, struck) in impacts() {
        let signal = BeamSignal::of(&column(), struck, &all, AFTER).expect("a response");
        let readings = signal.readings(&all, BEFORE, SEED);
        let peak = signal.truth.peak[0];
        for lie in std::iter::once(None).chain(LIES.iter().map(Some)) {
            let (sensor, name) = lie.map_or(("-", "no lie"), |it| (it.sensor, it.name));
            let row = format!("| {impact} | {sensor} | {name} |");
            let found = match estimate_prepared(&mut estimator, &with_lie(lie, &all, &readings)) {
                Ok(Some(found)) => found,
                Ok(None) => {
                    println!("{row} | | not detected |");
                    silent.push((impact, sensor, name));
                    continue;
                }
                Err(fault) => {
                    println!("{row} | | error: {fault} |");
                    continue;
                }
            };
            let last = found.estimates.last().expect("an estimate");
            let [mean, low, high] =
                [last.peak_v1.mean, last.peak_v1.low, last.peak_v1.high].map(|it| it / peak);
            let doubt = doubt(last, lie);
            println!(
                "{row} {mean:.2} | {low:.2} to {high:.2} | {} |",
                doubt.as_deref().unwrap_or("-")
            );
            let is_moved = (mean - 1.0).abs() > TOLERATED && !(low..=high).contains(&1.0);
            match &doubt {
                None if is_moved => silent.push((impact, sensor, name)),
                Some(doubt) if is_moved && doubt.starts_with(NOTE) => {
                    by_note.push((impact, sensor, name));
                }
                _ => {}
            }
            if lie.is_none() {
                assert!(!is_moved && doubt.is_none(), "{impact}: {last:#?}");
            }
        }
    }
    assert!(
        silent.is_empty(),
        "lies that move the peak without a word: {silent:?}"
    );
    assert_eq!(by_note, TOLD_BY_THE_NOTE);
}
