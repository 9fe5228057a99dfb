//! How often the intervals of the estimates hold the truth, over made impacts of the fibre beam, which is not the model of the
//! estimator. Kinds of vehicles, their numbers, the column and the errors of the sensors, scales included, are drawn from a seed.
//!
//! Arguments: kinds by parts of their names; `impacts=N` of each kind (6); `seed=N` of the first impact (1); `each` prints every
//! estimate. The seeds from 9000 on were kept aside while the estimator was changed.
//!
//! A column that collapses has no peak, so none is compared; where peaks are fewer than impacts, the table says of how many. The last
//! rows leave out every interval that the estimate calls "not known".
//!
//! A second table has how many of the last estimates are as close to the truth as [`Reached`] asks for, and a third one the time that all
//! estimates of an impact take together, on all processors.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use beam_signals::{AFTER, BEFORE, BeamSignal, column, deformable, parameters, plateau, spring};
use column_beam::BeamColumn;
use column_twin::column::Impact;
use column_twin::estimation::{Estimator, ImpactEstimate, Readings, estimate_prepared, hypotheses};
use column_twin::sensors::{Quantity, Sensor};
use column_twin::standing::StandingColumn;
use signals::Normal;

#[allow(dead_code)] // the tests use the rest of it
#[path = "../tests/estimation/signals.rs"]
mod signals;

#[allow(dead_code)] // the tests use the rest of it
#[path = "../tests/estimation/beam_signals.rs"]
mod beam_signals;

/// Kinds of impacts that are drawn.
const KINDS: [&str; 9] = [
    "rigid",
    "light_rigid",
    "slow",
    "elastic_front",
    "crushed_front",
    "two_masses",
    "any_curve",
    "strong",
    "at_the_limit",
];

/// Times after contact at which estimates are compared \[s\]; the last one is all data.
const INSTANTS: [(f64, &str); 4] = [
    (0.0099, "10 ms"),
    (0.0299, "30 ms"),
    (0.0999, "100 ms"),
    (10.0, "end"),
];

/// What is compared, by the names of an estimate.
const NAMES: [&str; QUANTITIES] = ["mass", "velocity", "momentum", "peak"];

/// How many these are.
const QUANTITIES: usize = 4;

/// Ratio of the ends of an interval up to which it states a number.
const CONFIDENT: f64 = 2.0;

/// Standard deviations of what the column differs by from its parameters, relative to these: yield strength, Young's modulus, mass,
/// load.
const DEVIATIONS: [f64; 4] = [0.03, 0.02, 0.05, 0.05];

/// Standard deviation of the scale of a sensor, relative to it, beside its gain error: it is some centimetres off its declared height.
fn scale_deviation(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::BendingStrain => 0.04,
        _ => 0.05,
    }
}

/// What is counted of a kind of impacts at one time.
#[derive(Default)]
struct Count {
    estimates: u32,
    /// Truths below, in and above the intervals.
    below: [u32; QUANTITIES],
    inside: [u32; QUANTITIES],
    above: [u32; QUANTITIES],
    /// Intervals of the momentum that exclude the truth although their ends differ by less than [`CONFIDENT`].
    confident_and_wrong: u32,
    /// Ratios of the ends of the intervals.
    widths: [Vec<f64>; QUANTITIES],
}

impl Count {
    /// Counts the quantities whose truth is known.
    fn take(&mut self, estimate: &ImpactEstimate, truth: [Option<f64>; QUANTITIES]) {
        let all = [
            estimate.mass,
            estimate.velocity,
            estimate.momentum,
            estimate.peak_v1,
        ];
        self.estimates += 1;
        for (k, (interval, truth)) in all.into_iter().zip(truth).enumerate() {
            let Some(truth) = truth else {
                continue;
            };
            let counted = match (truth < interval.low, truth > interval.high) {
                (true, _) => &mut self.below,
                (_, true) => &mut self.above,
                _ => &mut self.inside,
            };
            counted[k] += 1;
            self.widths[k].push(interval.high / interval.low);
        }
        let momentum = estimate.momentum;
        let excludes = truth[2].is_some_and(|it| !(momentum.low..=momentum.high).contains(&it));
        self.confident_and_wrong += u32::from(excludes && momentum.high < CONFIDENT * momentum.low);
    }

    fn print(&self, kind: &str, time: &str) {
        let each = (0..QUANTITIES).map(|k| {
            let mut widths = self.widths[k].clone();
            widths.sort_by(f64::total_cmp);
            let median = widths.get(widths.len() / 2).copied().unwrap_or(f64::NAN);
            let counts = [self.below[k], self.inside[k], self.above[k]];
            let compared: u32 = counts.iter().sum();
            if compared == 0 {
                return "not compared".to_owned();
            }
            let [below, inside, above] =
                counts.map(|it| 100.0 * f64::from(it) / f64::from(compared));
            let of = match compared == self.estimates {
                true => String::new(),
                false => format!(" of {compared}"),
            };
            format!("{inside:.0} %{of} ({below:.0} below, {above:.0} above; {median:.2})")
        });
        let each: Vec<_> = each.collect();
        println!(
            "| {kind} | {time} | {} | {} | {} |",
            self.estimates,
            each.join(" | "),
            self.confident_and_wrong
        );
    }
}

fn about(normal: &mut Normal, median: f64, deviation: f64) -> f64 {
    median * (deviation * normal.next().clamp(-2.0, 2.0)).exp()
}

/// An impact of this kind.
fn drawn(kind: &str, normal: &mut Normal) -> Impact {
    let mut about = |median: f64, deviation: f64| about(normal, median, deviation);
    match kind {
        "rigid" => Impact::rigid(about(1500.0, 0.4), about(5.0, 0.4)),
        "light_rigid" => Impact::rigid(about(220.0, 0.4), about(4.0, 0.6)),
        "slow" => Impact::rigid(about(800.0, 0.7), about(0.6, 0.4)),
        "elastic_front" => {
            let stiffness = about(600e3, 0.7);
            let front = spring(&[[1.0, stiffness]]);
            deformable(&[about(2000.0, 0.6)], &[front], about(6.0, 0.5))
        }
        "crushed_front" => {
            let front = plateau(about(1.5e6, 0.5), about(300e3, 0.4));
            deformable(&[about(2500.0, 0.8)], &[front], about(9.0, 0.4))
        }
        "two_masses" => {
            let mass = about(1800.0, 0.6);
            let front = about(0.12, 0.4) * mass;
            let hard = spring(&[[1.0, about(5e8, 0.7)]]);
            let crushed = plateau(about(1.2e6, 0.5), about(250e3, 0.4));
            deformable(&[front, mass - front], &[hard, crushed], about(10.0, 0.4))
        }
        "any_curve" => {
            let (mut crush, mut force) = (0.0, 0.0);
            let points: Vec<[f64; 2]> = (0..5)
                .map(|_| {
                    crush += about(0.12, 0.6);
                    force += about(60e3, 1.0);
                    [crush, force]
                })
                .collect();
            deformable(&[about(2500.0, 0.8)], &[spring(&points)], about(8.0, 0.4))
        }
        "strong" => {
            let front = plateau(about(3e6, 0.5), about(900e3, 0.3));
            deformable(&[about(12e3, 0.5)], &[front], about(13.0, 0.3))
        }
        // The force is about what the column resists.
        "at_the_limit" => {
            let front = plateau(about(3e6, 0.3), about(860e3, 0.02));
            deformable(&[about(10e3, 0.4)], &[front], about(14.0, 0.2))
        }
        _ => unreachable!("{kind}"),
    }
}

/// The column as it is.
fn real_column(normal: &mut Normal) -> BeamColumn {
    let known = column();
    let [strength, stiffness, mass, load] =
        DEVIATIONS.map(|it| 1.0 + it * normal.next().clamp(-2.5, 2.5));
    BeamColumn {
        steel: column_beam::Steel {
            yield_strength: strength * known.steel.yield_strength,
            young_modulus: stiffness * known.steel.young_modulus,
            density: mass * known.steel.density,
            ..known.steel
        },
        top_load: load * known.top_load,
        ..known
    }
}

/// How many of the last estimates of a kind meet each of [`REACHED`], and how many were compared.
#[derive(Default)]
struct Reached([[u32; 2]; REACHED.len()]);

/// Heads of the columns, and the largest errors and widths that they allow.
const REACHED: [&str; 6] = [
    "contact within 1 ms",
    "probability of a collapse above 0.9, or below 0.1 if the column stands",
    "peak within 10 % or 1 mm",
    "interval of the peak at most 40 % or 2 mm",
    "momentum",
    "mass within 25 %",
];

impl Reached {
    /// The momentum of a vehicle that has left, unless the estimate calls it "not known": within 10 % under a rigid or elastic front, and
    /// within 15 % if an elastic one has made the column yield; of any other front between half of its impulse and the impulse, within
    /// 10 %. The mass is that of rigid vehicles alone.
    fn take(&mut self, kind: &str, signal: &BeamSignal, contact: f64, last: &ImpactEstimate) {
        let (truth, momentum) = (&signal.truth, signal.momentum());
        let is_rigid = ["rigid", "light_rigid", "slow"].contains(&kind);
        let [peak, interval] = [last.peak_v1.mean, last.peak_v1.high - last.peak_v1.low];
        let within = |value: f64, of: f64, share: f64| (value / of - 1.0).abs() <= share;
        let unknown = last.not_known();
        let momentum = (truth.released && !truth.collapsed && !unknown.contains(&"momentum")).then(
            || match (is_rigid, kind) {
                (true, _) => within(last.momentum.mean, momentum, 0.10),
                (_, "elastic_front") => {
                    let share = if truth.yielded { 0.15 } else { 0.10 };
                    within(last.momentum.mean, momentum, share)
                }
                _ => (0.45..=1.1).contains(&(last.momentum.mean / truth.impulse)),
            },
        );
        let of_peak = |holds: bool| (!truth.collapsed).then_some(holds);
        let highest = truth.peak[0];
        let all = [
            Some(contact.abs() <= 1e-3),
            Some(match truth.collapsed {
                true => last.collapsed > 0.9,
                false => last.collapsed < 0.1,
            }),
            of_peak((peak - highest).abs() <= (0.1 * highest).max(1e-3)),
            of_peak(interval <= (0.4 * highest).max(2e-3)),
            momentum,
            (is_rigid && !unknown.contains(&"mass"))
                .then(|| within(last.mass.mean, signal.impact.mass, 0.25)),
        ];
        for ([reached, compared], holds) in self.0.iter_mut().zip(all) {
            *compared += u32::from(holds.is_some());
            *reached += u32::from(holds == Some(true));
        }
    }

    fn print(&self, kind: &str) {
        let each = self.0.map(|[reached, compared]| match compared {
            0 => "-".to_owned(),
            _ => format!("{reached} of {compared}"),
        });
        println!("| {kind} | {} |", each.join(" | "));
    }
}

/// The readings of sensors that are not quite where they are declared.
fn misplaced(mut readings: Readings, sensors: &[Sensor], normal: &mut Normal) -> Readings {
    let scales: Vec<f64> = sensors
        .iter()
        .map(|it| 1.0 + scale_deviation(it.quantity) * normal.next().clamp(-2.5, 2.5))
        .collect();
    for row in readings.values.chunks_mut(sensors.len()) {
        for ((value, scale), sensor) in row.iter_mut().zip(&scales).zip(sensors) {
            if !sensor.is_clipped(*value) {
                *value = sensor.clipped(scale * *value);
            }
        }
    }
    readings
}

/// The number of an argument `name=N`.
fn number(arguments: &[String], name: &str) -> Option<u64> {
    arguments
        .iter()
        .find_map(|it| it.strip_prefix(name)?.strip_prefix('=')?.parse().ok())
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let impacts = number(&arguments, "impacts").unwrap_or(6);
    let first = number(&arguments, "seed").unwrap_or(1);
    let prints_each = arguments.iter().any(|it| it == "each");
    let chosen: Vec<&String> = arguments
        .iter()
        .filter(|it| !it.starts_with("--") && !it.contains('=') && *it != "each")
        .collect();
    let kinds = KINDS
        .into_iter()
        .filter(|kind| chosen.is_empty() || chosen.iter().any(|it| kind.contains(it.as_str())));
    let (parameters, sensors) = (parameters(), beam_signals::sensors());
    let undamaged = StandingColumn::undamaged(&parameters);
    let hypotheses = hypotheses(&parameters);
    let mut estimator =
        Estimator::new(&parameters, &undamaged, sensors.clone(), hypotheses, 1).expect("sensors");
    while !estimator.prepare() {}
    let mut counts: BTreeMap<(usize, usize), Count> = BTreeMap::new();
    let mut stated: BTreeMap<usize, Count> = BTreeMap::new();
    let mut reached: BTreeMap<usize, Reached> = BTreeMap::new();
    let mut durations: BTreeMap<usize, Vec<Duration>> = BTreeMap::new();
    let mut undetected = 0;
    for (of_kind, kind) in kinds.clone().enumerate() {
        for seed in first..first + impacts {
            let mut normal = Normal::new(seed);
            let (real, impact) = (real_column(&mut normal), drawn(kind, &mut normal));
            let signal = match BeamSignal::of(&real, impact, &sensors, AFTER) {
                Ok(signal) => signal,
                Err(fault) => {
                    println!("{kind}, seed {seed}: the beam does not follow it: {fault}");
                    continue;
                }
            };
            let readings = signal.readings(&sensors, BEFORE, seed);
            let readings = misplaced(readings, &sensors, &mut normal);
            let begun = Instant::now();
            let found = estimate_prepared(&mut estimator, &readings).expect("sensors");
            let duration = begun.elapsed();
            let Some(found) = found else {
                undetected += 1;
                println!("{kind}, seed {seed}: not detected");
                continue;
            };
            durations.entry(of_kind).or_default().push(duration);
            let Impact { mass, velocity, .. } = signal.impact;
            let momentum = signal.momentum();
            let contact = found.detection.contact;
            let last = found.estimates.last().expect("an estimate");
            reached
                .entry(of_kind)
                .or_default()
                .take(kind, &signal, contact.time - BEFORE, last);
            // A collapse ends the readings, and its peak is only the last of them.
            let peak = (!signal.truth.collapsed).then_some(signal.truth.peak[0]);
            let truth = [Some(mass), Some(velocity), Some(momentum), peak];
            if prints_each {
                println!(
                    "{kind}, seed {seed}: {mass:.0} kg at {velocity:.2} m/s, peak {:.2} mm at {:.0} ms, J/(m v) {:.2}, yielded {}, released {}, \
                     collapsed {}, contact detected {:+.1} ms off, with a deviation of {:.1} ms",
                    1e3 * signal.truth.peak[0],
                    1e3 * signal.truth.peak[1],
                    signal.truth.impulse / momentum,
                    signal.truth.yielded,
                    signal.truth.released,
                    signal.truth.collapsed,
                    1e3 * (contact.time - BEFORE),
                    1e3 * contact.deviation,
                );
            }
            for (at, (instant, name)) in INSTANTS.into_iter().enumerate() {
                let is_due = |it: &&ImpactEstimate| it.data_until - BEFORE >= instant;
                let estimate = found.estimates.iter().find(is_due).unwrap_or(last);
                counts
                    .entry((of_kind, at))
                    .or_default()
                    .take(estimate, truth);
                let unknown = estimate.not_known();
                let known = |k: usize| truth[k].filter(|_| !unknown.contains(&NAMES[k]));
                let known = std::array::from_fn(known);
                stated.entry(at).or_default().take(estimate, known);
                if prints_each {
                    let ratio = |k: usize| {
                        let Some(truth) = truth[k] else {
                            return "not compared".to_owned();
                        };
                        let all = [
                            estimate.mass,
                            estimate.velocity,
                            estimate.momentum,
                            estimate.peak_v1,
                        ];
                        let [mean, low, high] =
                            [all[k].mean, all[k].low, all[k].high].map(|it| it / truth);
                        format!("{mean:.2} [{low:.2} {high:.2}]")
                    };
                    let vehicles = &estimate.vehicle_probabilities;
                    println!(
                        "  {name:>6} m {} v {} mv {} peak {} collapsed {:.2} {} {:.2} {} {:.2} eff {:.0} {:?}",
                        ratio(0),
                        ratio(1),
                        ratio(2),
                        ratio(3),
                        estimate.collapsed,
                        vehicles[0].0,
                        vehicles[0].1,
                        vehicles[1].0,
                        vehicles[1].1,
                        estimate.effective_sample_size,
                        estimate.doubtful_sensors,
                    );
                }
            }
        }
    }
    println!(
        "Truths in the 90 % intervals (below, above; median ratio of the ends), and intervals of the momentum that exclude the truth \
         although their ends differ by less than {CONFIDENT}; {undetected} impacts were not detected.\n"
    );
    println!("| kind | data | impacts | mass | speed | momentum | peak | confident and wrong |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut all: BTreeMap<usize, Count> = BTreeMap::new();
    for (of_kind, kind) in kinds.clone().enumerate() {
        for (at, (_, name)) in INSTANTS.into_iter().enumerate() {
            let Some(count) = counts.get(&(of_kind, at)) else {
                continue;
            };
            count.print(kind, name);
            let sum = all.entry(at).or_default();
            sum.estimates += count.estimates;
            sum.confident_and_wrong += count.confident_and_wrong;
            for k in 0..QUANTITIES {
                sum.below[k] += count.below[k];
                sum.inside[k] += count.inside[k];
                sum.above[k] += count.above[k];
                sum.widths[k].extend(&count.widths[k]);
            }
        }
    }
    for (of, sums) in [
        ("all", &all),
        ("all but those that are \"not known\"", &stated),
    ] {
        for (at, (_, name)) in INSTANTS.into_iter().enumerate() {
            if let Some(sum) = sums.get(&at) {
                sum.print(of, name);
            }
        }
    }
    println!(
        "\nLast estimates that meet each requirement, without quantities that they call \"not known\".\n\n| kind | {} |\n|---{}|",
        REACHED.join(" | "),
        "|---".repeat(REACHED.len()),
    );
    for (of_kind, kind) in kinds.clone().enumerate() {
        if let Some(reached) = reached.get(&of_kind) {
            reached.print(kind);
        }
    }
    println!("\n| kind | impacts | time of one: median | largest |\n|---|---|---|---|");
    for (of_kind, kind) in kinds.enumerate() {
        let Some(times) = durations.get_mut(&of_kind) else {
            continue;
        };
        times.sort_unstable();
        let [median, largest] =
            [times[times.len() / 2], times[times.len() - 1]].map(|it| it.as_secs_f64());
        println!(
            "| {kind} | {} | {median:.2} s | {largest:.2} s |",
            times.len()
        );
    }
}
