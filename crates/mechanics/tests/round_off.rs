//! Equations whose residual cannot fall any further because of round-off are solved.

use column_mechanics::{ColumnProperties, End, Impact, Model, Progress, Response, Scheme, State};
use serde_json::Value;

/// A hit 45 mm above the base at 36 m/s, whose web flows within the first step.
fn low_hit() -> (ColumnProperties, Impact) {
    let case: Value =
        serde_json::from_str(include_str!("data/sheared_low_hit.json")).expect("JSON");
    let read = |part: &str| case[part].clone();
    (
        serde_json::from_value(read("column")).expect("a column"),
        serde_json::from_value(read("impact")).expect("an impact"),
    )
}

/// How a response ends, when \[s\], and where the impact point is then \[m\].
fn end(column: &ColumnProperties, impact: &Impact) -> (End, f64, f64) {
    let model = Model::new(column).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, *impact, 1e3).expect("an impact");
    loop {
        let progress = response
            .advance(&model, &mut state, u64::MAX)
            .unwrap_or_else(|error| panic!("{error}"));
        if let Progress::Over(end) = progress {
            return (end, model.time_of_step(state.step), state.displacement.v1);
        }
    }
}

/// The conserving scheme stopped with "step 0 did not converge at 4.749e-8 s": `beta1` is 3.6e-6 of the angle by which the short
/// bar turns, whose round-off was taken for an error of `beta1`.
#[test]
fn a_small_rotation_beside_a_large_chord_angle_converges() {
    let (column, impact) = low_hit();
    let with = |scheme, step_nanos| ColumnProperties {
        scheme,
        step_nanos,
        ..column
    };
    let (fine, time, v1) = end(&with(Scheme::ConservingMidpoint, 1_000), &impact);
    assert_eq!(fine, End::Collapsed);
    for scheme in [Scheme::ConservingMidpoint, Scheme::Midpoint] {
        for step_nanos in [column.step_nanos, 20_000] {
            let (found, at, reached) = end(&with(scheme, step_nanos), &impact);
            assert_eq!(found, End::Collapsed);
            let steps = 3e-9 * step_nanos as f64;
            assert!((at - time).abs() <= steps, "{scheme:?}: {at} s, {time} s");
            let moved = steps * impact.velocity;
            assert!(
                (reached - v1).abs() <= moved,
                "{scheme:?}: {reached} m, {v1} m"
            );
        }
    }
}
