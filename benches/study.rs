//! What a cell of a map costs: an evaluation against the plain simulation with its full assessment, the parts of an evaluation,
//! one thread against two, and the memory of streamed batches.
//!
//! Processor time of the thread, so that other load on the machine falsifies the figures little; ratios are of one run.

use std::hint::black_box;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

use column_twin::assessment::{AssessmentInput, ResidualCapacity, assess, respond_and_rest};
use column_twin::column::{Impact, Model, State, StudyModel, residual_state};
use column_twin::parameters::Parameters;
use column_twin::study::{Batch, StudyColumn};
use rustix::time::{ClockId, clock_gettime};

/// Points of each axis.
const POINTS: u64 = 40;

const CASES: [(&str, &str); 4] = [
    ("heb220_paper.yaml", "rigid"),
    ("heb220_paper.yaml", "mid_car"),
    ("heb220_s355.yaml", "rigid"),
    ("heb220_s355.yaml", "mid_car"),
];

/// Processor time of this thread \[us\] that `compute` takes per impact.
fn cost<T>(impacts: &[Impact], mut compute: impl FnMut(&Impact) -> T) -> f64 {
    let now = || {
        let time = clock_gettime(ClockId::ThreadCPUTime);
        time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 * 1e-3
    };
    let began = now();
    for impact in impacts {
        black_box(compute(black_box(impact)));
    }
    (now() - began) / impacts.len() as f64
}

/// A map of masses from 500 to 20 000 kg and velocities from 1 to 25 m/s.
fn map(column: &StudyColumn, vehicle: &str, points: u64) -> Vec<Impact> {
    let part = |k: u64| k as f64 / (points - 1) as f64;
    let cells = (0..points * points).map(|index| {
        let mass = 500.0 + 19_500.0 * part(index / points);
        column.impact(Some(vehicle), Some(mass), 1.0 + 24.0 * part(index % points))
    });
    cells.filter_map(Result::ok).collect()
}

fn resident_kilobytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok())
        .unwrap_or(0)
}

fn on_threads(column: &StudyColumn, impacts: &[Impact], threads: usize) -> f64 {
    let batch = Batch::on_threads(NonZeroUsize::new(threads).expect("a number"));
    let began = Instant::now();
    let compute = |index: u64| column.evaluate(&impacts[index as usize]).is_ok();
    batch
        .run::<_, Box<dyn std::error::Error>>(impacts.len() as u64, compute, |_| Ok(()))
        .expect("a batch");
    impacts.len() as f64 / began.elapsed().as_secs_f64()
}

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load {}", load.trim());
    println!(
        "us of a processor per cell of {POINTS} x {POINTS}; the plain simulation for every 16th of them\n{:<20}{:<10}{:>9}{:>9}{:>7}{:>10}{:>10}{:>11}{:>11}{:>11}{:>7}",
        "column",
        "vehicle",
        "plain",
        "evaluate",
        "ratio",
        "response",
        "residual",
        "capacity",
        "1 thread/s",
        "2 threads",
        "ratio"
    );
    for (file, vehicle) in CASES {
        let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "config", file]
            .iter()
            .collect();
        let parameters = Parameters::load(&[path], &[]).expect("parameters");
        let properties = parameters.column_properties();
        let column = StudyColumn::undamaged(&parameters).expect("a column");
        let model = Model::new(&properties).expect("a column");
        let study = StudyModel::new(&properties, 1.0).expect("a column");
        let impacts = map(&column, vehicle, POINTS);
        let few: Vec<_> = impacts.iter().step_by(16).copied().collect();
        let duration = parameters.response_duration();
        let plain = cost(&few, |impact| {
            let (report, rest) =
                respond_and_rest(&properties, impact, duration).expect("a response");
            let remaining =
                ResidualCapacity::compute(&parameters, &model, rest.as_ref()).expect("a capacity");
            assess(&AssessmentInput::of_response(
                &parameters,
                &model,
                impact,
                &report,
                remaining,
            ))
        });
        let screen = cost(&impacts, |impact| {
            column.evaluate(impact).expect("an evaluation")
        });
        let undamaged = State::at_rest(&model);
        let mut ends = Vec::new();
        let response = cost(&impacts, |impact| {
            let response = study.respond(&undamaged, impact, duration);
            ends.push(response.expect("a response"));
        });
        let mut of_ends = impacts.iter().zip(&ends);
        let residual = cost(&impacts, |_| {
            let (_, end) = of_ends.next().expect("as many");
            end.rest.and_then(|_| residual_state(&model, &end.last))
        });
        let mut of_ends = ends.iter();
        let capacity = cost(&impacts, |_| {
            let end = of_ends.next().expect("as many");
            let flowed = end.rest.filter(|rest| rest.plastic != undamaged.plastic);
            let bow = column_twin::assessment::imperfection(&parameters);
            flowed.map(|rest| column_twin::column::capacity(&model, &rest, bow))
        });
        let [one, two] = [1, 2].map(|threads| on_threads(&column, &impacts, threads));
        println!(
            "{file:<20}{vehicle:<10}{plain:>9.1}{screen:>9.1}{:>7.1}{response:>10.1}{residual:>10.2}{capacity:>11.1}{one:>11.0}{two:>11.0}{:>7.2}",
            plain / screen,
            two / one
        );
    }
    println!("\nresident kB after streaming light computations");
    for count in [10_000_u64, 1_000_000] {
        Batch::default()
            .run::<_, Box<dyn std::error::Error>>(count, |index| [index; 16], |_| Ok(()))
            .expect("a batch");
        println!("{count:>10} {}", resident_kilobytes());
    }
}
