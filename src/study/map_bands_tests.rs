//! Tests of the lines of limits and of the bands of boundaries against plain responses with their full assessment.

use std::path::PathBuf;

use super::*;
use crate::assessment::{
    Action, ActionRange, AssessmentInput, Assumption, OpenVerdict, ResidualCapacity, assess,
    respond_and_rest,
};
use crate::column::{Impact, Model, Report};
use crate::parameters::{Parameters, parse_override};

fn car(overrides: &[&str]) -> Parameters {
    let file = [env!("CARGO_MANIFEST_DIR"), "config", "heb220_s355.yaml"];
    let overrides: Vec<_> = ["vehicle.name:=mid_car"]
        .iter()
        .chain(overrides)
        .map(|it| parse_override(it))
        .collect();
    Parameters::load(&[file.iter().collect::<PathBuf>()], &overrides).expect("parameters")
}

fn map(parameters: &Parameters) -> DamageMap {
    let axes = [
        MapAxis::parse("mass=1200:2400:3").expect("an axis"),
        MapAxis::parse("velocity=2:30:60").expect("an axis"),
    ];
    DamageMap::new(parameters, None, axes).expect("a map")
}

/// The plain response to the car with this mass and velocity.
fn response(parameters: &Parameters, mass: f64, velocity: f64) -> (Impact, Report, bool) {
    let column = StudyColumn::undamaged(parameters).expect("a column");
    let impact = column
        .impact(None, Some(mass), velocity)
        .expect("an impact");
    let properties = parameters.column_properties();
    let duration = parameters.response_duration();
    let (report, rest) = respond_and_rest(&properties, &impact, duration).expect("a response");
    let model = Model::new(&properties.before(&impact)).expect("a column");
    let remaining =
        ResidualCapacity::compute(parameters, &model, rest.as_ref()).expect("a capacity");
    let input = AssessmentInput::of_response(parameters, &model, &impact, &report, remaining);
    let assessment = assess(&input);
    let names = ["base_shear", "base_moment", "base_uplift"];
    let base_fails = assessment
        .criteria
        .iter()
        .any(|it| names.contains(&it.name) && it.margin.is_some_and(|margin| margin < 0.0));
    (impact, report, base_fails)
}

/// Just below each line no plain response has a web that yields or a base that fails, and just above it each has.
#[test]
fn the_lines_of_the_limits_are_those_of_plain_responses() {
    let parameters = car(&[]);
    let map = map(&parameters);
    let refined = map.refine(&Batch::default()).expect("boundaries");
    assert_eq!(refined.limits.len(), 2);
    let mut lines = 0;
    for boundary in &refined.limits {
        for point in &boundary.points {
            let mass = map.rows().number(point.row).expect("a mass");
            let Some(velocity) = point.place.value() else {
                continue;
            };
            for (factor, expected) in [(0.97, false), (1.03, true)] {
                let (_, report, base_fails) = response(&parameters, mass, factor * velocity);
                let found = match boundary.limit {
                    Limit::WebYields => report.webs.iter().any(|web| web.first_yield.is_some()),
                    Limit::BaseFails => base_fails,
                };
                let limit = boundary.limit;
                assert_eq!(
                    found, expected,
                    "{limit:?}, {mass} kg, {factor} x {velocity} m/s"
                );
            }
            lines += 1;
        }
    }
    assert!(lines >= 4, "{:?}", refined.limits);
}

/// Without shear there is no line of it, and without a base to check none of that.
#[test]
fn a_column_without_a_limit_has_no_line_of_it() {
    let parameters = car(&["shear.model:=none", "support.base:=pinned"]);
    let refined = map(&parameters)
        .refine(&Batch::default())
        .expect("boundaries");
    assert_eq!(refined.limits, []);
}

/// The range of a verdict, computed by plain responses, reaches a class with a change just inside of its band, and not just outside.
#[test]
fn a_band_ends_where_the_range_of_the_verdict_does() {
    let parameters = car(&[]);
    let map = map(&parameters);
    let refined = map.refine(&Batch::default()).expect("boundaries");
    let bands = map.bands(&refined, &Batch::default()).expect("bands");
    assert!(bands.complete && !bands.varied.contains(&Assumption::Speed));
    assert!(bands.not_varied.is_empty(), "{:?}", bands.not_varied);
    // At most 14 changes, 4 classes, the rows, and 10 responses for each.
    assert!(bands.responses < 14 * 4 * 3 * 10, "{}", bands.responses);
    let column = StudyColumn::undamaged(&parameters).expect("a column");
    let mut compared = 0;
    for action in [Action::Restrict, Action::Evacuate] {
        let band = bands.in_row(0, action, 1).expect("a band");
        let boundary = refined
            .value_at(&map, 0, action, 1800.0)
            .expect("a boundary");
        assert!(
            band.low <= boundary && boundary <= band.high,
            "{band:?} {boundary}"
        );
        let found = |velocity: f64| {
            let impact = column
                .impact(None, Some(1800.0), velocity)
                .expect("an impact");
            let properties = parameters.column_properties();
            let verdict = OpenVerdict {
                action: column.action(&impact).expect("a response"),
                not_evaluated: Vec::new(),
            };
            let range = ActionRange::of_action(
                &parameters,
                &properties,
                &impact,
                0.0,
                None,
                &verdict,
                &mut || true,
            );
            let all = range.expect("a range").variations;
            let changed = all.iter().filter(|it| it.assumption != Assumption::Speed);
            let reached: Vec<bool> = changed.map(|it| it.action >= action).collect();
            (
                reached.contains(&true) || verdict.action >= action,
                reached.contains(&false),
            )
        };
        if band.low_by.is_some() {
            assert!(!found(0.97 * band.low).0, "{action:?} {band:?}");
            assert!(found(1.03 * band.low).0, "{action:?} {band:?}");
            compared += 1;
        }
        if band.high_by.is_some() && band.high < 29.0 {
            assert!(found(0.97 * band.high).1, "{action:?} {band:?}");
            assert!(!found(1.03 * band.high).1, "{action:?} {band:?}");
            compared += 1;
        }
    }
    assert!(compared > 0, "{:?}", bands.bands);
    // The bands do not depend on the threads.
    let one = map.bands(&refined, &Batch::of_threads(std::num::NonZeroUsize::new(1)));
    assert_eq!(one.expect("bands"), bands);
}
