//! The wording that summary and report share.

use crate::column::{BaseForces, BaseReport, End, Impact, Outcome};
use crate::figures::units::{ROUND_OFF, significant};
use crate::parameters::{Parameters, RIGID, component_in_words};

/// The outcome of an impact, for a sentence that is a line of its own.
#[must_use]
pub fn outcome_in_words(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Elastic => "elastic: no hinge has yielded",
        Outcome::Plastic => "plastic: hinges or webs have yielded",
        Outcome::Collapsed => "COLLAPSED: the column has lost its shape or its equilibrium",
        Outcome::Fractured => {
            "FRACTURED: a hinge, a web or the base passed its ultimate deformation"
        }
    }
}

/// Why a response ended.
#[must_use]
pub fn end_in_words(end: End) -> &'static str {
    match end {
        End::AtRest => "at rest",
        End::DurationReached => "stopped at response.duration, not at rest",
        End::Collapsed => "collapsed",
        End::Fractured => "fractured",
        End::NotConverged => "stopped where the equations did not converge",
    }
}

/// What takes the place of the residual displacement of a response that leaves none.
#[must_use]
pub fn instead_of_a_residual(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Fractured => "fractures",
        _ => "collapses",
    }
}

/// One line that describes the column and the vehicle of this name that hits it, `length_below` \[m\] above its base. `impact` has the
/// whole velocity of the vehicle; where it travels in another direction \[rad\] than 0, the line says what the two bars see of it.
#[must_use]
pub fn title(
    parameters: &Parameters,
    vehicle: &str,
    impact: &Impact,
    length_below: f64,
    direction: f64,
) -> String {
    let mut text = described(parameters, vehicle, impact, length_below, "");
    if let Some(component) = component_in_words(direction) {
        text += "; ";
        text += &component;
    }
    text
}

/// Column and hit, with `angle` behind the speed.
pub(super) fn described(
    parameters: &Parameters,
    vehicle: &str,
    impact: &Impact,
    length_below: f64,
    angle: &str,
) -> String {
    let section = parameters.section().name;
    format!(
        "{}: {}, {} kg at {} m/s ({} km/h){angle}, {} m above the base",
        section.unwrap_or(&parameters.settings().column_id),
        vehicle_in_words(vehicle),
        short(impact.mass),
        short(impact.velocity),
        short(3.6 * impact.velocity),
        short(length_below),
    )
}

/// A length in millimetres with three digits, as the second opinion has it.
pub(super) fn millimetres(metres: f64) -> String {
    let metres = if metres.abs() < ROUND_OFF {
        0.0
    } else {
        metres
    };
    format!("{} mm", significant(1e3 * metres, 3))
}

/// The vehicle of this name in words.
fn vehicle_in_words(name: &str) -> &str {
    match name {
        "" => "user-defined vehicle",
        RIGID => "rigid mass",
        name => name,
    }
}

/// Four significant digits without trailing zeros.
#[must_use]
pub fn short(value: f64) -> String {
    let text = significant(value, 4);
    text.parse::<f64>()
        .map_or(text, |rounded| rounded.to_string())
}

/// At most this many characters of a text, the last of them dots where it is longer.
pub(super) fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let kept: String = text.chars().take(most.saturating_sub(3)).collect();
    kept + "..."
}

/// A length as a part of another one, such as `L/36`.
pub(super) fn part_of(length: f64, whole: f64) -> String {
    let part = whole / length.abs();
    match part {
        part if part.is_nan() => "not a number".to_owned(),
        part if part >= 1e4 => "less than L/10000".to_owned(),
        part if part >= 9.5 => format!("L/{part:.0}"),
        part => format!("L/{part:.1}"),
    }
}

/// The reactions of the base that summaries and reports show, with their names.
pub fn base_rows(base: &BaseReport) -> Vec<(&'static str, &BaseForces)> {
    let plateau = base.plateau.iter().map(|it| ("plateau", it));
    let peaks = [
        ("largest shear", &base.peak_shear),
        ("shear reversed after release", &base.reversed_shear),
        ("largest moment of hinge 3", &base.peak_moment),
        ("moment to be checked", &base.checked_moment),
        ("least compression", &base.least_compressed),
        ("largest compression", &base.most_compressed),
    ];
    plateau
        .chain(peaks)
        .filter(|(_, forces)| **forces != BaseForces::default())
        .collect()
}

/// Shear \[kN\], moment \[kNm\] and normal force \[kN\], tension positive, with a decimal.
pub fn in_kilo(forces: &BaseForces) -> [String; 3] {
    // Adding zero makes -0 and 0 the same.
    [forces.shear, forces.moment, forces.normal_force].map(|it| format!("{:.1}", 1e-3 * it + 0.0))
}
