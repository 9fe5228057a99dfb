//! The cost of a step of a response: the paper's example with steps of 10 microseconds, followed to its end, and the same
//! column hit by deformable vehicles of one to three masses; with the argument `shear` only what the shear of its webs costs.

#[path = "../tests/example/mod.rs"]
mod example;

use std::hint::black_box;
use std::time::{Duration, Instant};

use column_mechanics::{
    ColumnProperties, Impact, Model, Progress, Response, RolledSection, State, Vehicle,
    begin_impact, respond, simulate, step,
};
use example::{ceb, example, lorry};

/// Longest response \[s\].
const DURATION: f64 = 2.0;

/// Runs of each measurement, of which the fastest counts: other load on the machine can only slow them down.
const RUNS: usize = 50;

const EXPONENTS: [(&str, [&str; 3]); 3] = [
    (
        "ellipse",
        [
            "yield_surface.alpha:=2.0",
            "yield_surface.beta:=2.0",
            "yield_surface.gamma:=2.0",
        ],
    ),
    (
        "Duan-Chen",
        [
            "yield_surface.alpha:=1.0",
            "yield_surface.beta:=1.3",
            "yield_surface.gamma:=1.0",
        ],
    ),
    (
        "1.7, 2.6, 1.9",
        [
            "yield_surface.alpha:=1.7",
            "yield_surface.beta:=2.6",
            "yield_surface.gamma:=1.9",
        ],
    ),
];

/// The strength of the hinges: constant, with strain rate, with strain rate and hardening.
const STRENGTHS: [&str; 3] = ["constant", "rate", "rate and hardening"];

/// Steps for which their costs are compared: the column yields during most of them.
const STRENGTH_STEPS: u32 = 3_000;

/// The properties with a strength of [`STRENGTHS`].
fn strengthened(properties: &ColumnProperties, strength: &str) -> ColumnProperties {
    ColumnProperties {
        rate: (strength != STRENGTHS[0]).then(ceb),
        hardening_ratio: if strength == STRENGTHS[2] { 0.01 } else { 0.0 },
        ..*properties
    }
}

const SCHEMES: [&str; 2] = ["midpoint", "conserving_midpoint"];

/// Time of one step \[ns\], and Newton iterations per step.
struct Cost {
    /// `step` alone.
    step: f64,
    /// `respond`: extremes, energy balance and report included.
    response: f64,
    /// `simulate`: a sample of every step included.
    sampled: f64,
    newton_iterations: f64,
}

fn fastest(steps: u64, mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let began = Instant::now();
        run();
        began.elapsed()
    };
    let least = (0..RUNS).map(once).min().unwrap_or(Duration::ZERO);
    least.as_secs_f64() * 1e9 / steps as f64
}

fn cost(properties: &ColumnProperties, impact: &Impact) -> Cost {
    let model = Model::new(properties).expect("a column");
    let mut end = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut end, *impact, DURATION).expect("an impact");
    while response
        .advance(&model, &mut end, u64::MAX)
        .expect("a step")
        == Progress::Running
    {}
    let steps = end.step;
    let mut start = State::at_rest(&model);
    begin_impact(&model, &mut start, *impact).expect("an impact");
    Cost {
        step: fastest(steps, || {
            let mut state = start;
            for _ in 0..steps {
                step(black_box(&model), &mut state).expect("a step");
            }
            black_box(state);
        }),
        response: fastest(steps, || {
            let report = respond(black_box(properties), impact, DURATION);
            black_box(report).expect("a response");
        }),
        sampled: fastest(steps, || {
            let report = simulate(black_box(properties), impact, DURATION, &mut |sample| {
                black_box(sample);
            });
            black_box(report).expect("a response");
        }),
        newton_iterations: end.newton_iterations as f64 / steps as f64,
    }
}

/// Vehicles of one, two and three masses, 8 t in total.
fn vehicles() -> [(&'static str, Vehicle); 3] {
    let springs = [lorry().springs(), &lorry().springs()[1..]].concat();
    [
        ("one mass", &[8000.0][..]),
        ("two masses", &[5500.0, 2500.0]),
        ("three masses", &[5500.0, 1500.0, 1000.0]),
    ]
    .map(|(name, masses)| {
        let made = Vehicle::new(masses, &springs[..masses.len()]);
        (name, made.expect("a vehicle"))
    })
}

/// Compares deformable vehicles with a rigid one of the same mass and speed.
fn print_vehicles() {
    println!(
        "\nns per step of 10 us, fastest of {RUNS} responses to 8 t at 6 m/s, over the rigid mass's"
    );
    println!(
        "{:<20}{:<15}{:>10}{:>8}{:>8}{:>8}{:>19}",
        "scheme", "vehicle", "response", "ratio", "step", "ratio", "Newton iterations"
    );
    for scheme in SCHEMES {
        let chosen = format!("solver.scheme:={scheme}");
        let (properties, rigid) = example(&[
            &chosen,
            "solver.dt:=1.0e-5",
            "impact.mass:=8000.0",
            "impact.velocity:=6.0",
        ]);
        let base = cost(&properties, &rigid);
        let print = |name: &str, cost: &Cost| {
            println!(
                "{scheme:<20}{name:<15}{:>10.0}{:>8.2}{:>8.0}{:>8.2}{:>19.2}",
                cost.response,
                cost.response / base.response,
                cost.step,
                cost.step / base.step,
                cost.newton_iterations
            );
        };
        print("rigid", &base);
        for (name, vehicle) in vehicles() {
            let impact = Impact {
                vehicle: Some(vehicle),
                ..rigid
            };
            print(name, &cost(&properties, &impact));
        }
    }
}

/// Steps in which the column and all springs stay elastic, and vehicle and column touch.
const ELASTIC_STEPS: u64 = 1_000;

/// Compares the steps of deformable vehicles with those of a rigid one where nothing yields, so that nothing but the vehicle's
/// own equations makes the difference. The runs alternate, so that other load on the machine meets all of them.
fn print_elastic_vehicles() {
    println!(
        "\nns per step of the first {ELASTIC_STEPS} after an impact of 8 t at 0.2 m/s, all elastic"
    );
    println!(
        "{:<20}{:<15}{:>10}{:>8}",
        "scheme", "vehicle", "step", "ratio"
    );
    for scheme in SCHEMES {
        let chosen = format!("solver.scheme:={scheme}");
        let (properties, rigid) = example(&[
            &chosen,
            "solver.dt:=1.0e-5",
            "impact.mass:=8000.0",
            "impact.velocity:=0.2",
        ]);
        let model = Model::new(&properties).expect("a column");
        let deformable = vehicles().map(|(name, vehicle)| {
            let vehicle = Some(vehicle);
            (name, Impact { vehicle, ..rigid })
        });
        let mut impacts = vec![("rigid", rigid)];
        impacts.extend(deformable);
        let mut fastest = vec![Duration::MAX; impacts.len()];
        for _ in 0..RUNS {
            for ((_, impact), fastest) in impacts.iter().zip(&mut fastest) {
                let mut state = State::at_rest(&model);
                begin_impact(&model, &mut state, *impact).expect("an impact");
                let began = Instant::now();
                for _ in 0..ELASTIC_STEPS {
                    step(black_box(&model), &mut state).expect("a step");
                }
                *fastest = began.elapsed().min(*fastest);
                black_box(state);
            }
        }
        for ((name, _), time) in impacts.iter().zip(&fastest) {
            println!(
                "{scheme:<20}{name:<15}{:>10.0}{:>8.2}",
                time.as_secs_f64() * 1e9 / ELASTIC_STEPS as f64,
                time.as_secs_f64() / fastest[0].as_secs_f64()
            );
        }
    }
}

/// Time of one `step` with each of the [`STRENGTHS`] \[ns\]. The runs alternate, so that other load on the machine meets
/// all of them.
fn costs_of_strengths(properties: &ColumnProperties, impact: &Impact) -> [f64; 3] {
    costs_of(
        STRENGTHS.map(|strength| strengthened(properties, strength)),
        impact,
    )
}

/// Time of one `step` of each of some columns \[ns\], alternating.
fn costs_of<const N: usize>(columns: [ColumnProperties; N], impact: &Impact) -> [f64; N] {
    let started = columns.map(|properties| {
        let model = Model::new(&properties).expect("a column");
        let mut start = State::at_rest(&model);
        begin_impact(&model, &mut start, *impact).expect("an impact");
        (model, start)
    });
    let mut least = [f64::INFINITY; N];
    for _ in 0..4 * RUNS {
        for ((model, start), least) in started.iter().zip(&mut least) {
            let mut state = *start;
            let began = Instant::now();
            for _ in 0..STRENGTH_STEPS {
                step(black_box(model), &mut state).expect("a step");
            }
            *least = least.min(began.elapsed().as_secs_f64() * 1e9 / f64::from(STRENGTH_STEPS));
            black_box(state);
        }
    }
    least
}

/// Compares columns whose webs yield with the same ones whose webs do not, hit at the height of a car and at 1 m.
fn print_shear() {
    println!(
        "\nns per step of 10 us of HEB 220 with shear, and its ratio to that without, over {STRENGTH_STEPS} steps"
    );
    println!(
        "{:<20}{:<15}{:<20}{:>8}{:>10}{:>8}",
        "scheme", "height", "strength", "without", "shear", "ratio"
    );
    let section = RolledSection {
        depth: 0.22,
        width: 0.22,
        web_thickness: 0.0095,
        flange_thickness: 0.016,
        root_radius: 0.018,
    };
    for scheme in SCHEMES {
        for height in [0.5, 1.0] {
            for strength in STRENGTHS {
                let (properties, impact) = example(&[
                    &format!("solver.scheme:={scheme}"),
                    "solver.dt:=1.0e-5",
                    "hinge.elastic_law:=coupled",
                    "yield_surface.alpha:=1.0",
                    "yield_surface.beta:=1.3",
                    "yield_surface.gamma:=1.0",
                    &format!("geometry.length_below:={height}"),
                ]);
                let without = strengthened(&properties, strength);
                let mut shear = section.shear(355e6, 210e9, 0.3, without.hardening_ratio);
                shear.bumper_height = 0.2;
                let with = ColumnProperties {
                    shear: Some(shear),
                    ..without
                };
                let [without, with] = costs_of([without, with], &impact);
                println!(
                    "{scheme:<20}{height:<15}{strength:<20}{without:>8.0}{with:>10.0}{:>8.2}",
                    with / without
                );
            }
        }
    }
}

fn main() {
    // `cargo test --benches` only checks that the benchmark runs.
    if !std::env::args().any(|argument| argument == "--bench") {
        let (properties, impact) = example(&["solver.dt:=1.0e-3"]);
        cost(&properties, &impact);
        return;
    }
    print_shear();
    if std::env::args().any(|argument| argument == "shear") {
        return;
    }
    println!("\nns per step of 10 us, fastest of {RUNS} responses of the paper's example");
    println!(
        "{:<20}{:<15}{:>10}{:>8}{:>8}{:>14}{:>8}{:>19}",
        "scheme",
        "exponents",
        "response",
        "step",
        "ratio",
        "with samples",
        "ratio",
        "Newton iterations"
    );
    for scheme in SCHEMES {
        for (name, exponents) in EXPONENTS {
            let chosen = format!("solver.scheme:={scheme}");
            let (properties, impact) =
                example(&[&[chosen.as_str(), "solver.dt:=1.0e-5"], &exponents[..]].concat());
            let cost = cost(&properties, &impact);
            println!(
                "{scheme:<20}{name:<15}{:>10.0}{:>8.0}{:>8.2}{:>14.0}{:>8.2}{:>19.2}",
                cost.response,
                cost.step,
                cost.response / cost.step,
                cost.sampled,
                cost.sampled / cost.response,
                cost.newton_iterations
            );
        }
    }
    print_vehicles();
    print_elastic_vehicles();
    println!(
        "\nns per step of the same with strain rate and hardening, and its ratio to that with constant strength"
    );
    println!(
        "{:<20}{:<15}{:>21}{:>8}{:>22}{:>8}",
        "scheme", "exponents", "rate", "ratio", "rate and hardening", "ratio"
    );
    for scheme in SCHEMES {
        for (name, exponents) in EXPONENTS {
            let chosen = format!("solver.scheme:={scheme}");
            let (properties, impact) =
                example(&[&[chosen.as_str(), "solver.dt:=1.0e-5"], &exponents[..]].concat());
            let [constant, rate, both] = costs_of_strengths(&properties, &impact);
            println!(
                "{scheme:<20}{name:<15}{rate:>21.0}{:>8.2}{both:>22.0}{:>8.2}",
                rate / constant,
                both / constant
            );
        }
    }
}
