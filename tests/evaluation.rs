//! An evaluation against the plain simulation with its full assessment, cell by cell.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use column_twin::assessment::{
    AssessmentInput, ResidualCapacity, assess, largest_plastic_rotation, respond_and_rest,
};
use column_twin::column::{Impact, Model, Outcome};
use column_twin::parameters::{Parameters, parse_override};
use column_twin::study::{Batch, Evaluation, StudyColumn};

/// Relative error that is admitted of the peak displacement.
const TOLERANCE: f64 = 1e-3;

/// Of the residual capacity: where a hinge fractures in the push-down, it depends on the residual state with a factor of up to
/// ten.
const CAPACITY_TOLERANCE: f64 = 5e-3;

/// Of the largest contact force; the largest difference, 3.5e-3, is that of rigid masses that fracture the web.
const FORCE_TOLERANCE: f64 = 4e-3;

fn parameters(file: &str, overrides: &[&str]) -> Parameters {
    let file: PathBuf = [env!("CARGO_MANIFEST_DIR"), "config", file]
        .iter()
        .collect();
    let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
    Parameters::load(&[file], &overrides).expect("parameters")
}

/// What the plain simulation and the full assessment say.
fn plain(parameters: &Parameters, impact: &Impact) -> Evaluation {
    let properties = parameters.column_properties();
    let model = Model::new(&properties).expect("a column");
    let (report, rest) =
        respond_and_rest(&properties, impact, parameters.response_duration()).expect("a response");
    let remaining =
        ResidualCapacity::compute(parameters, &model, rest.as_ref()).expect("a capacity");
    let input = AssessmentInput::of_response(parameters, &model, impact, &report, remaining);
    let assessment = assess(&input);
    let rotations = report.hinges.map(|hinge| hinge.plastic_rotation);
    Evaluation {
        action: assessment.action,
        deciding_criterion: assessment.deciding_criterion,
        outcome: report.outcome,
        max_v1: report.max_v1,
        residual_v1: report.residual_v1,
        peak_contact_force: report.peak_contact_force,
        residual_capacity: remaining.now.force,
        capacity_ratio: remaining.ratio,
        reserve: remaining.reserve,
        max_plastic_rotation: largest_plastic_rotation(&rotations),
        max_plastic_shear: report
            .webs
            .iter()
            .fold(0.0, |most, web| most.max(web.plastic_angle.abs())),
        // The boundaries of maps are compared with the criteria of the base.
        base_utilisation: None,
    }
}

/// The impact of cell `index` of a map of `points` masses from 500 to 20 000 kg times `points` velocities from 1 to 25 m/s.
fn cell(column: &StudyColumn, vehicle: &str, points: u64, index: u64) -> Impact {
    let part = |k: u64| k as f64 / (points - 1) as f64;
    let mass = 500.0 + 19_500.0 * part(index / points);
    let velocity = 1.0 + 24.0 * part(index % points);
    let impact = column.impact(Some(vehicle), Some(mass), velocity);
    impact.expect("an impact")
}

/// Relative difference, 0 if both are 0.
fn difference(found: f64, expected: f64) -> f64 {
    if found == expected {
        return 0.0;
    }
    ((found - expected) / expected).abs()
}

/// Compares every cell of a map, and returns how many had each outcome.
fn compare(parameters: &Parameters, vehicle: &str, points: u64) -> [u64; 4] {
    let column = StudyColumn::undamaged(parameters).expect("a column");
    let compute = |index: u64| {
        let impact = cell(&column, vehicle, points, index);
        let evaluation = column.evaluate(&impact).expect("an evaluation");
        let alone = column.action(&impact).expect("an action");
        (impact, (evaluation, alone), plain(parameters, &impact))
    };
    let mut outcomes = [0; 4];
    let mut wrong = Vec::new();
    let end = Batch::default().run::<_, Box<dyn std::error::Error>>(
        points * points,
        compute,
        |cells| {
            for (impact, (found, alone), expected) in cells {
                outcomes[expected.outcome as usize] += 1;
                let Impact { mass, velocity, .. } = impact;
                let mut check = |name: &str, found: f64, expected: f64, tolerance: f64| {
                    let difference = difference(found, expected);
                    if difference.is_nan() || difference > tolerance {
                        wrong.push(format!(
                            "{mass:.1} kg at {velocity:.3} m/s: {name} {found} instead of {expected}, {difference:.1e}"
                        ));
                    }
                };
                let action = |evaluation: &Evaluation| f64::from(evaluation.action as u8);
                check("action", action(&found), action(&expected), 0.0);
                check("action alone", f64::from(alone as u8), action(&expected), 0.0);
                check("max_v1", found.max_v1, expected.max_v1, TOLERANCE);
                check(
                    "peak contact force",
                    found.peak_contact_force,
                    expected.peak_contact_force,
                    FORCE_TOLERANCE,
                );
                check(
                    "residual capacity",
                    found.residual_capacity,
                    expected.residual_capacity,
                    CAPACITY_TOLERANCE,
                );
                if found.outcome != expected.outcome
                    || found.deciding_criterion != expected.deciding_criterion
                    || found.residual_v1.is_some() != expected.residual_v1.is_some()
                {
                    wrong.push(format!(
                        "{mass:.1} kg at {velocity:.3} m/s: {:?} by {} instead of {:?} by {}",
                        found.outcome,
                        found.deciding_criterion,
                        expected.outcome,
                        expected.deciding_criterion
                    ));
                }
            }
            Ok(())
        },
    );
    end.expect("a batch");
    assert!(
        wrong.is_empty(),
        "{} faults:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    outcomes
}

#[test]
fn a_map_of_rigid_impacts_on_the_papers_column_agrees_with_simulate() {
    let outcomes = compare(&parameters("heb220_paper.yaml", &[]), "rigid", 25);
    assert!(outcomes[Outcome::Plastic as usize] > 50);
    assert!(outcomes[Outcome::Fractured as usize] > 50);
}

#[test]
fn a_map_of_cars_against_the_papers_column_agrees_with_simulate() {
    let outcomes = compare(&parameters("heb220_paper.yaml", &[]), "mid_car", 25);
    assert!(outcomes[Outcome::Elastic as usize] > 50);
    assert!(outcomes[Outcome::Plastic as usize] > 50);
    assert!(outcomes[Outcome::Fractured as usize] > 50);
}

/// A strain rate, with the hardening that belongs to it.
const STRAIN_RATE: [&str; 2] = ["rate.law:=logarithmic", "hardening.ratio:=0.005"];

#[test]
fn maps_of_a_column_with_strain_rate_agree_with_simulate() {
    let parameters = parameters("heb220_s355.yaml", &STRAIN_RATE);
    compare(&parameters, "rigid", 13);
    compare(&parameters, "mid_car", 13);
}

#[test]
fn maps_of_a_real_column_agree_with_simulate() {
    let parameters = parameters("heb220_s355.yaml", &[]);
    compare(&parameters, "rigid", 13);
    compare(&parameters, "mid_car", 13);
}

/// Other loads, vehicles and steps than those on whose maps the bounds of the quick and of the fine response were found.
#[test]
fn maps_of_other_columns_and_vehicles_agree_with_simulate() {
    let loaded = parameters("heb220_paper.yaml", &["top.load:=1.0e6"]);
    let outcomes = compare(&loaded, "van", 12);
    assert!(outcomes[Outcome::Fractured as usize] + outcomes[Outcome::Collapsed as usize] > 20);
    let rated = [&STRAIN_RATE[..], &["top.load:=3.0e5"]].concat();
    let rated = parameters("heb220_s355.yaml", &rated);
    let outcomes = compare(&rated, "suv", 12);
    assert!(outcomes[Outcome::Plastic as usize] > 10);
    assert!(outcomes[Outcome::Fractured as usize] > 20);
    compare(&rated, "lorry_8t", 8);
}

fn evaluations(column: &StudyColumn, batch: &Batch) -> Vec<Evaluation> {
    let mut all = Vec::new();
    let compute = |index| {
        let impact = cell(column, "mid_car", 9, index);
        column.evaluate(&impact).expect("an evaluation")
    };
    let end = batch.run::<_, Box<dyn std::error::Error>>(81, compute, |evaluations| {
        all.extend(evaluations);
        Ok(())
    });
    end.expect("a batch");
    all
}

#[test]
fn a_batch_has_the_same_bits_on_any_number_of_threads() {
    let column = StudyColumn::undamaged(&parameters("heb220_paper.yaml", &[])).expect("a column");
    let with = |threads| {
        let batch = Batch::on_threads(NonZeroUsize::new(threads).expect("a number"));
        let all = evaluations(&column, &batch);
        assert_eq!(batch.done(), 81);
        serde_json::to_string(&all).expect("numbers that read back to the last bit")
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
}

#[test]
fn an_interrupted_batch_delivers_a_prefix() {
    const COUNT: u64 = 20_000;
    for at in [0, 1, 100, 4_096, 10_000, COUNT - 1] {
        let batch = Batch::on_threads(NonZeroUsize::new(3).expect("a number"));
        let compute = |index| {
            if index == at {
                batch.interrupt();
            }
            index
        };
        let mut delivered = Vec::new();
        let end = batch.run::<_, Box<dyn std::error::Error>>(COUNT, compute, |indices| {
            delivered.extend(indices);
            Ok(())
        });
        let prefix: Vec<_> = (0..delivered.len() as u64).collect();
        assert_eq!(delivered, prefix);
        match end.expect("a batch") {
            column_twin::study::BatchEnd::Interrupted(count) => {
                assert_eq!(count, delivered.len() as u64);
            }
            column_twin::study::BatchEnd::Complete => assert_eq!(prefix.len() as u64, COUNT),
        }
    }
}
