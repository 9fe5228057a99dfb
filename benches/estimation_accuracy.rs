//! How close the estimates are to the truth on signals of the fibre beam, which is not the model of the estimator, and on
//! those of `tests/data/signals/`.
//!
//! Arguments choose signals by parts of their names, `seeds=N` the number of streams of noise, and `before=S` how many seconds
//! of readings there are before the contact.
//! Signals whose names begin with `held` were kept aside while the estimator was changed. Each cell is the mean of the estimate
//! over the truth with the ends of its 90 % interval, after 10, 30 and 100 ms of data and after all of them.

use std::time::Instant;

use beam_signals::{AFTER, BEFORE, BeamSignal};
use column_twin::estimation::{
    CredibleInterval, Estimator, ImpactEstimate, Readings, estimate_prepared, hypotheses,
};
use column_twin::parameters::Parameters;
use column_twin::sensors::Sensor;
use column_twin::standing::StandingColumn;
use signals::Signal;

#[allow(dead_code)] // the tests use the rest of it
#[path = "../tests/estimation/signals.rs"]
mod signals;

#[allow(dead_code)] // the tests use the rest of it
#[path = "../tests/estimation/beam_signals.rs"]
mod beam_signals;

/// Impacts of the fibre beam.
const NAMES: [&str; 6] = [
    "light_rigid_12",
    "light_rigid_2",
    "two_mass_car_16",
    "crush_car_15",
    "crush_lorry_8",
    "forklift_2",
];

/// Those that were kept aside.
const HELD: [&str; 6] = [
    "held_light_rigid_9",
    "held_light_rigid_1",
    "held_two_mass_car_11",
    "held_crush_car_10",
    "held_crush_lorry_6",
    "held_forklift_3",
];

/// Times after contact at which estimates are compared \[s\]; the last one is all data.
const INSTANTS: [f64; 4] = [0.0099, 0.0299, 0.0999, 10.0];

/// Sensors of the signals of `tests/data/signals/`.
const SETS: [(&str, &[usize]); 3] = [("1", &[3]), ("2", &[3, 4]), ("4", &[2, 3, 4, 5])];

/// What a signal's truth is.
struct Truth {
    name: String,
    contact: f64,
    mass: f64,
    velocity: f64,
    peak: f64,
    impulse: f64,
}

/// Intervals that hold the truth, of mass, speed, momentum, peak, and their number.
#[derive(Default)]
struct Coverage {
    held: [u32; 4],
    all: u32,
}

fn ratio(of: &CredibleInterval, truth: f64) -> String {
    let [mean, low, high] = [of.mean, of.low, of.high].map(|it| it / truth);
    format!("{mean:>5.2} [{low:>5.2} {high:>5.2}]")
}

fn estimator(parameters: &Parameters, sensors: &[Sensor]) -> Estimator {
    let column = StandingColumn::undamaged(parameters);
    let hypotheses = hypotheses(parameters);
    let mut estimator =
        Estimator::new(parameters, &column, sensors.to_vec(), hypotheses, 1).expect("sensors");
    while !estimator.prepare() {}
    estimator
}

fn show(estimator: &mut Estimator, readings: &Readings, truth: &Truth, coverage: &mut Coverage) {
    let begun = Instant::now();
    let Some(found) = estimate_prepared(estimator, readings).expect("sensors") else {
        println!("{:<26} not detected", truth.name);
        return;
    };
    let took = begun.elapsed().as_secs_f64();
    let off = 1e3 * (found.detection.contact.time - truth.contact);
    println!("{} contact {off:.2} ms off, {took:.1} s", truth.name);
    for instant in INSTANTS {
        let at = |it: &&ImpactEstimate| it.data_until - truth.contact >= instant;
        let last = found.estimates.last().expect("an estimate");
        let it = found.estimates.iter().find(at).unwrap_or(last);
        let pairs = [
            (it.mass, truth.mass),
            (it.velocity, truth.velocity),
            (it.momentum, truth.mass * truth.velocity),
            (it.peak_v1, truth.peak),
        ];
        for ((interval, truth), held) in pairs.iter().zip(&mut coverage.held) {
            *held += u32::from((interval.low..=interval.high).contains(truth));
        }
        coverage.all += 1;
        let [mass, velocity, momentum, peak] = pairs.map(|(of, truth)| ratio(&of, truth));
        let (name, share) = &it.vehicle_probabilities[0];
        println!(
            "{:>6.0} mv {momentum}  mv/J {:>4.2}  m {mass}  v {velocity}  peak {peak}  yielded {:.2}  {name} {share:.2}  eff. \
             {:.0}  {:?}",
            1e3 * (it.data_until - truth.contact),
            it.momentum.mean / truth.impulse,
            it.yielded,
            it.effective_sample_size,
            it.doubtful_sensors,
        );
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let seeds: u64 = arguments
        .iter()
        .find_map(|it| it.strip_prefix("seeds=")?.parse().ok())
        .unwrap_or(2);
    let before: f64 = arguments
        .iter()
        .find_map(|it| it.strip_prefix("before=")?.parse().ok())
        .unwrap_or(BEFORE);
    let chosen: Vec<&String> = arguments
        .iter()
        .filter(|it| !it.starts_with("--") && !it.contains('='))
        .collect();
    let wanted = |name: &str| {
        let is_held = name.starts_with("held");
        match chosen.is_empty() {
            true => !is_held,
            false => chosen
                .iter()
                .any(|it| name.contains(it.as_str()) && (!is_held || it.contains("held"))),
        }
    };
    let mut coverage = Coverage::default();
    let sensors = beam_signals::sensors();
    let names: Vec<_> = NAMES.into_iter().chain(HELD).collect();
    if names.iter().any(|name| wanted(name)) {
        let mut estimator = estimator(&beam_signals::parameters(), &sensors);
        for name in names.into_iter().filter(|name| wanted(name)) {
            let signal = BeamSignal::make(name, &sensors, AFTER);
            let made = &signal.truth;
            println!(
                "{name}: peak {:.2} mm at {:.0} ms, J/(m v) {:.2}, yielded {}, released {}, collapsed {}",
                1e3 * made.peak[0],
                1e3 * made.peak[1],
                made.impulse / signal.momentum(),
                made.yielded,
                made.released,
                made.collapsed,
            );
            for seed in 1..=seeds {
                let truth = Truth {
                    name: format!("  seed {seed}"),
                    contact: before,
                    mass: signal.impact.mass,
                    velocity: signal.impact.velocity,
                    peak: made.peak[0],
                    impulse: made.impulse,
                };
                let readings = signal.readings(&sensors, before, seed);
                show(&mut estimator, &readings, &truth, &mut coverage);
            }
        }
    }
    for name in signals::NAMES.into_iter().filter(|name| wanted(name)) {
        let signal = Signal::read(name);
        for (count, chosen) in SETS {
            let (sensors, _) = signal.readings(chosen, 1);
            let mut estimator = estimator(&signal.parameters(), &sensors);
            for seed in 1..=seeds {
                let (_, readings) = signal.readings(chosen, seed);
                let truth = Truth {
                    name: format!("{name}, {count} sensors, seed {seed}"),
                    contact: signal.number("contact_instant"),
                    mass: signal.number("mass"),
                    velocity: signal.number("speed"),
                    peak: signal.number("peak_v1"),
                    impulse: signal.number("impulse"),
                };
                show(&mut estimator, &readings, &truth, &mut coverage);
            }
        }
    }
    let share = |held: u32| 100.0 * f64::from(held) / f64::from(coverage.all.max(1));
    let [mass, velocity, momentum, peak] = coverage.held.map(share);
    println!(
        "{} estimates; intervals that hold the truth: mass {mass:.0} %, speed {velocity:.0} %, momentum {momentum:.0} %, peak \
         {peak:.0} %",
        coverage.all
    );
}
