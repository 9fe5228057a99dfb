//! What a step costs: the paper's example, 60 ms of it.

#[path = "../tests/example/mod.rs"]
mod example;

use std::hint::black_box;
use std::time::{Duration, Instant};

use column_mechanics::{Model, State, simulate, step};
use criterion::{Criterion, Throughput};
use example::example;

/// Length of the response \[ns\].
const RESPONSE_NANOS: u64 = 60_000_000;

const EXPONENTS: [(&str, [&str; 3]); 2] = [
    (
        "ellipse",
        [
            "yield_surface.alpha:=2.0",
            "yield_surface.beta:=2.0",
            "yield_surface.gamma:=2.0",
        ],
    ),
    (
        "duan_chen",
        [
            "yield_surface.alpha:=1.0",
            "yield_surface.beta:=1.3",
            "yield_surface.gamma:=1.0",
        ],
    ),
];

const SCHEMES: [&str; 2] = ["midpoint", "conserving_midpoint"];

/// The column and its state at the event.
fn start(scheme: &str, exponents: &[&str], dt: &str) -> (Model, State) {
    let scheme = format!("solver.scheme:={scheme}");
    let (properties, impact) = example(&[&[scheme.as_str(), dt], exponents].concat());
    let model = Model::new(&properties).expect("a column");
    let mut state = State::at_rest(&model);
    begin_impact(&model, &mut state, impact).expect("an impact");
    (model, state)
}

/// The state at the end of the response.
fn respond(model: &Model, start: &State) -> State {
    let mut state = *start;
    for _ in 0..RESPONSE_NANOS / model.properties.step_nanos {
        step(model, &mut state).expect("a step");
    }
    state
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step of 10 us");
    for scheme in SCHEMES {
        for (name, exponents) in EXPONENTS {
            let (model, state) = start(scheme, &exponents, "solver.dt:=1.0e-5");
            group.throughput(Throughput::Elements(
                RESPONSE_NANOS / model.properties.step_nanos,
            ));
            group.bench_function(format!("{scheme}/{name}"), |bencher| {
                bencher.iter(|| respond(black_box(&model), black_box(&state)));
            });
        }
    }
    group.finish();
}

fn responses(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("response of 60 ms");
    for scheme in SCHEMES {
        for (name, exponents) in EXPONENTS {
            let chosen = format!("solver.scheme:={scheme}");
            let overrides = [&[chosen.as_str(), "solver.dt:=2.0e-5"], &exponents[..]].concat();
            let (properties, impact) = example(&overrides);
            group.bench_function(format!("{scheme}/{name}"), |bencher| {
                bencher.iter(|| {
                    simulate(black_box(&properties), &impact, 0.06, &mut |sample| {
                        black_box(sample);
                    })
                });
            });
        }
    }
    group.finish();
}

/// Time of a step \[ns\] and Newton corrections per step. Every run takes the same steps, so each slice of the response
/// counts with the least time that any run took for it: what else the machine does falls out.
fn cost(scheme: &str, exponents: &[&str]) -> (f64, f64) {
    const RUNS: usize = 50;
    const SLICE: usize = 50;
    let (model, state) = start(scheme, exponents, "solver.dt:=1.0e-5");
    let steps = RESPONSE_NANOS / model.properties.step_nanos;
    let mut least = vec![Duration::MAX; steps as usize / SLICE];
    let mut end = state;
    for _ in 0..RUNS {
        end = state;
        for slice in &mut least {
            let began = Instant::now();
            for _ in 0..SLICE {
                step(black_box(&model), &mut end).expect("a step");
            }
            *slice = began.elapsed().min(*slice);
        }
    }
    let total: Duration = least.iter().sum();
    (
        total.as_secs_f64() * 1e9 / steps as f64,
        end.corrections as f64 / steps as f64,
    )
}

/// Least time of a whole response at 20 us over some runs \[ms\], model, observer and report included.
fn whole_response(scheme: &str, exponents: &[&str]) -> f64 {
    const RUNS: usize = 50;
    let scheme = format!("solver.scheme:={scheme}");
    let (properties, impact) =
        example(&[&[scheme.as_str(), "solver.dt:=2.0e-5"], exponents].concat());
    let once = || {
        let began = Instant::now();
        let report = simulate(black_box(&properties), &impact, 0.06, &mut |sample| {
            black_box(sample);
        });
        black_box(report).expect("a response");
        began.elapsed()
    };
    let least = (0..RUNS).map(|_| once()).min().unwrap_or_default();
    least.as_secs_f64() * 1e3
}

fn print_ratios() {
    println!("\nns per step of 10 us (corrections per step), least of 50 runs in slices");
    println!(
        "{:<12}{:>18}{:>18}{:>18}",
        "exponents", "midpoint", "energy", "energy/midpoint"
    );
    for (name, exponents) in EXPONENTS {
        let [midpoint, energy] = SCHEMES.map(|scheme| cost(scheme, &exponents));
        let shown = |(nanos, corrections): (f64, f64)| format!("{nanos:.0} ({corrections:.2})");
        println!(
            "{name:<12}{:>18}{:>18}{:>18.2}",
            shown(midpoint),
            shown(energy),
            energy.0 / midpoint.0
        );
    }
    println!("\nms per response of 60 ms with steps of 20 us, least of 50 runs");
    for (name, exponents) in EXPONENTS {
        let [midpoint, energy] = SCHEMES.map(|scheme| whole_response(scheme, &exponents));
        println!(
            "{name:<12}{midpoint:>18.2}{energy:>18.2}{:>18.2}",
            energy / midpoint
        );
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    steps(&mut criterion);
    responses(&mut criterion);
    criterion.final_summary();
    // `cargo test --benches` only asks whether the benchmarks run.
    if std::env::args().any(|argument| argument == "--bench") {
        print_ratios();
    }
}
