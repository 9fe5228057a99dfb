//! What the fibre beam says of the column, in the words of the first pages.

use super::assessed::ByBeam;
use super::impact_section::ResultRow;
use super::words::{millimetres, part_of};
use crate::column::Outcome;
use crate::figures::units::significant;
use crate::second_opinion::is_out_of_plane;

/// What the beam predicts, in one sentence.
pub(super) fn outcome(by_beam: ByBeam<'_>) -> String {
    let (opinion, _) = by_beam;
    let [peak, residual] = opinion.from_undamaged();
    match opinion.outcome() {
        Outcome::Elastic => format!(
            "By the fibre beam the column stays elastic; it moves {} at the impact point at most.",
            opinion.along_and_across(peak)
        ),
        Outcome::Plastic => format!(
            "Bow that remains: {}, by the fibre beam; displacement of the impact point {}, kink there {:.1}°.",
            bow(by_beam),
            opinion.along_and_across(residual),
            kink(by_beam).to_degrees()
        ),
        Outcome::Collapsed | Outcome::Fractured => {
            "By the fibre beam the column loses its equilibrium.".to_owned()
        }
    }
}

/// What was found at the impact point, for the list of places to inspect; `None` where the beam stays elastic.
pub(super) fn finding(by_beam: ByBeam<'_>) -> Option<String> {
    let (opinion, seen) = by_beam;
    match opinion.outcome() {
        Outcome::Elastic => None,
        Outcome::Plastic => Some(format!(
            "yielded by the fibre beam: kink {:.1}°, bow {}; measure it",
            kink(by_beam).to_degrees(),
            part_of(largest_bow(by_beam), seen.height())
        )),
        Outcome::Collapsed | Outcome::Fractured => {
            Some("collapsed by the fibre beam: look from a safe distance".to_owned())
        }
    }
}

/// Its displacements, for the table of results.
pub(super) fn rows(by_beam: ByBeam<'_>) -> Vec<ResultRow> {
    let (opinion, seen) = by_beam;
    let beam = &opinion.beam;
    let height = seen.height();
    let [peak, residual] = opinion.from_undamaged();
    let length = |name, metres: f64, time: String| ResultRow {
        name,
        value: remaining(metres),
        part: match metres.is_finite() {
            true => part_of(metres, height),
            false => String::new(),
        },
        time,
    };
    let none = String::new;
    let mut rows = vec![length(
        "peak displacement of the impact point along the hit",
        peak[0],
        format!("{} ms", significant(1e3 * beam.max_displacement_time_s, 4)),
    )];
    let is_oblique = is_out_of_plane(opinion.direction);
    if is_oblique {
        rows.push(length("the same across the hit", peak[1], none()));
    }
    rows.push(length(
        "residual displacement of the impact point along the hit",
        residual[0],
        none(),
    ));
    if is_oblique {
        rows.push(length("the same across the hit", residual[1], none()));
    }
    rows.push(length(
        "residual bow, the largest one at any height",
        largest_bow(by_beam),
        none(),
    ));
    rows.push(ResultRow {
        name: "kink that remains at the impact point",
        value: match residual[0].is_finite() {
            true => format!("{:.2}°", kink(by_beam).to_degrees()),
            false => remaining(f64::NAN),
        },
        part: none(),
        time: none(),
    });
    rows
}

/// A length that remains after the hit; the column collapses where there is none.
fn remaining(metres: f64) -> String {
    match metres.is_finite() {
        true => millimetres(metres),
        false => "collapses".to_owned(),
    }
}

/// The largest distance from the undamaged axis that remains \[m\]; NaN after a collapse.
fn largest_bow((_, seen): ByBeam<'_>) -> f64 {
    seen.largest_bow().unwrap_or(f64::NAN)
}

fn bow(by_beam: ByBeam<'_>) -> String {
    let (opinion, seen) = by_beam;
    let bow = largest_bow(by_beam);
    let at = match opinion.beam.residual_bow_height_m {
        at if at.is_finite() => format!(" at a height of {} m", significant(at, 3)),
        _ => String::new(),
    };
    format!("{} = {}{at}", millimetres(bow), part_of(bow, seen.height()))
}

/// The kink that remains at the impact point \[rad\], as it can be measured along the axis: with the shear of the web, of which the
/// plastic rotations know nothing.
fn kink((_, seen): ByBeam<'_>) -> f64 {
    seen.kink().unwrap_or(f64::NAN)
}
