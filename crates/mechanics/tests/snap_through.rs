//! A massless top that snaps through: a result with a reason that a displacement test confirms, never a fault of the program.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

use column_mechanics::{ColumnProperties, End, Impact, Model, Progress, Response, Scheme, State};
use serde_json::Value;

/// Positions of the top that the displacement test tries.
const POSITIONS: u32 = 20_000;

/// A bar of 24 mm clear length whose web has sheared by 80 degrees when its top, without mass, is about to snap through.
fn sheared() -> (ColumnProperties, Impact) {
    let case: Value =
        serde_json::from_str(include_str!("data/sheared_snap_through.json")).expect("JSON");
    let read = |part: &str| case[part].clone();
    (
        serde_json::from_value(read("column")).expect("a column"),
        serde_json::from_value(read("impact")).expect("an impact"),
    )
}

/// How a response ends, when \[s\], and its last two states.
fn end(column: &ColumnProperties, impact: &Impact) -> (End, f64, [State; 2]) {
    let model = Model::new(column).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, *impact, 1e3).expect("an impact");
    let mut last = [state; 2];
    loop {
        let progress = response
            .advance(&model, &mut state, u64::MAX)
            .unwrap_or_else(|error| panic!("{error}"));
        if let Progress::Over(end) = progress {
            return (end, model.time_of_step(state.step), last);
        }
        last = [last[1], state];
    }
}

/// The largest force \[N\] by which bar and spring exceed the load while the top is lowered from where it is until the upper bar
/// lies across the column, with the impact point held at `v1` \[m\]. By hand: an elastic bar between two ends, and a
/// web that flows under the moments that it bears. The hinges are elastic and do not enter.
fn most_that_is_left(column: &ColumnProperties, state: &State, v1: f64) -> f64 {
    let [_, length] = column.clear_lengths();
    let plastic = &state.plastic.above;
    let shortened = plastic.elongation[0] + plastic.elongation[1] + plastic.shear_elongation;
    let [first, second] = state.forces.above.moment;
    let web = first + second;
    let (u1, from) = (state.displacement.u1, state.displacement.u2);
    let across = length + u1;
    (0..POSITIONS)
        .map(|k| from + (across - from) * f64::from(k) / f64::from(POSITIONS))
        .map(|u2| {
            let x = length - (u2 - u1);
            let chord = x.hypot(v1);
            let normal = column.axial_rigidity / length * (chord - length - shortened);
            let resistance = -normal * x / chord + web * v1 / (chord * chord);
            resistance + column.top_spring_stiffness * u2 - column.top_load
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

/// The conserving scheme stopped with "step 121 did not converge at 1.723e-8 s, the smallest part tried".
#[test]
fn a_sheared_bar_whose_massless_top_snaps_through_collapses_and_is_no_fault() {
    let (column, impact) = sheared();
    let (found, time, [_, last]) = end(&column, &impact);
    assert_eq!(found, End::Collapsed);
    // It still stood at the last step, and one step later there is no place left where it could.
    let scale = 1e-3 * column.top_load;
    let here = most_that_is_left(&column, &last, last.displacement.v1);
    let secs = column.step_nanos as f64 * 1e-9;
    let next = last.displacement.v1 + 1.5 * last.velocity.v1 * secs;
    let there = most_that_is_left(&column, &last, next);
    assert!(here > scale, "{here} N are left at {time} s");
    assert!(there < -scale, "{there} N are left a step later");
    // Both schemes say so, with shorter and longer steps, at the same time.
    for scheme in [Scheme::ConservingMidpoint, Scheme::Midpoint] {
        for [times, parts] in [[1, 1], [1, 2], [1, 4], [1, 16], [2, 1]] {
            let column = ColumnProperties {
                scheme,
                step_nanos: column.step_nanos * times / parts,
                ..column
            };
            let (found, other, _) = end(&column, &impact);
            assert_eq!(found, End::Collapsed, "{scheme:?} {times}/{parts}");
            assert!(
                (other - time).abs() <= 4.0 * secs,
                "{scheme:?}, {times}/{parts} of the step: {other} s, not {time} s"
            );
        }
    }
}
