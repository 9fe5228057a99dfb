//! The equivalent static force of a contact over the period of what it pushes.

use super::page::{Drawn, Stroke, colour};
use super::path_chart::{PathAxis, PathChart, PathLine};
use super::response_history::ResponseHistory;
use super::units::Unit;
use crate::column::ForceSpectrum;

/// The longest period that the figure shows \[s\].
const LONGEST: f64 = 0.5;

/// Draws the response spectrum of the contact force, with the line of its impulse, which it follows at long periods; `None` where
/// the spectrum is not known or nothing has touched the column.
pub(super) fn force_spectrum(response: &ResponseHistory<'_>) -> Option<Drawn<String>> {
    let spectrum = response.spectrum?;
    (response.report.impulse > 0.0).then(|| draw(response, spectrum))
}

fn draw(response: &ResponseHistory<'_>, spectrum: &ForceSpectrum) -> Drawn<String> {
    let forces = spectrum.equivalent_forces();
    let spectrum = ForceSpectrum::periods().into_iter().zip(forces);
    let points: Vec<_> = spectrum.filter(|(period, _)| *period <= LONGEST).collect();
    let largest = points.iter().map(|point| point.1).fold(0.0, f64::max);
    let impulse = response.report.impulse;
    let by_impulse = |period: f64| std::f64::consts::TAU * impulse / period;
    // As far as it is not far above the spectrum.
    let line = points
        .iter()
        .map(|(period, _)| (*period, by_impulse(*period)));
    let line = line.filter(|(_, force)| *force <= 1.1 * largest).collect();
    PathChart {
        title: "Equivalent static force of the contact",
        lines: [
            response.title,
            "largest force in the spring of an undamped oscillator that the contact force pushes",
        ],
        x: PathAxis {
            name: "period of the oscillator",
            unit: Unit::time(LONGEST),
            includes: &[0.0],
        },
        y: PathAxis {
            name: "equivalent static force",
            unit: Unit::force(largest),
            includes: &[0.0],
        },
        paths: vec![
            PathLine::new(
                "equivalent static force",
                points,
                Stroke::solid(colour::CONTACT, 14),
            ),
            PathLine::new(
                "impulse times circular frequency",
                line,
                Stroke::dashed(colour::FAINT, 8),
            ),
        ],
        marks: Vec::new(),
        keys: Vec::new(),
    }
    .draw()
}
