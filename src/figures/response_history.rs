//! The history of a response, from which the figures are drawn.

use column_beam::Movement;

use super::chart::{Curve, TimeChart};
use super::page::Stroke;
use super::units::Unit;
use crate::column::{ForceSpectrum, MAX_MASSES, Outcome, Report, Sample, Vehicle, YieldExponents};
use crate::observables::{Observable, each};
use crate::twin::Lengths;

/// The history of a response with its outcome and what is known of the hinges.
#[derive(Debug, Clone, Copy)]
pub struct ResponseHistory<'a> {
    /// One line that describes column and impact.
    pub title: &'a str,
    /// The samples, in the order of time.
    pub samples: &'a [Sample],
    /// The outcome.
    pub report: &'a Report,
    /// The response spectrum of the contact force, of every step; `None` where only published states are known, which are too few.
    pub spectrum: Option<&'a ForceSpectrum>,
    /// Exponents of the hinges' yield surface.
    pub yield_surface: YieldExponents,
    /// `M^p` \[N m\].
    pub resistance_moment: f64,
    /// `N^p` \[N\].
    pub resistance_axial: f64,
    /// Undeformed lengths of the bars.
    pub lengths: Lengths,
    /// The deformable vehicle; `None` for a rigid one.
    pub vehicle: Option<Vehicle>,
    /// The same hit by the fibre beam, if it was computed.
    pub beam: Option<&'a Movement>,
}

impl ResponseHistory<'_> {
    /// First and last time of the history \[s\].
    pub(super) fn span(&self) -> (f64, f64) {
        let time = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.time);
        (time(self.samples.first()), time(self.samples.last()))
    }

    /// A quantity over time.
    pub(super) fn over_time(&self, quantity: impl Fn(&Sample) -> f64) -> Vec<(f64, f64)> {
        self.samples
            .iter()
            .map(|sample| (sample.time, quantity(sample)))
            .collect()
    }

    /// What is observed over time, as a curve with its name.
    pub(super) fn curve(&self, what: &Observable, index: usize, stroke: Stroke) -> Curve {
        let points = self.over_time(|sample| what.value(sample, index));
        Curve::line(what.in_figures(index), points, stroke)
    }

    /// The largest magnitude of what is observed \[SI unit\].
    pub(super) fn largest(&self, what: &[Observable]) -> f64 {
        let of_all =
            |(it, index): (&Observable, usize)| self.over_time(|sample| it.value(sample, index));
        let values = each(what, MAX_MASSES)
            .flat_map(of_all)
            .map(|(_, value)| value);
        values
            .filter(|value| value.is_finite())
            .fold(0.0, |largest, value| largest.max(value.abs()))
    }

    /// A chart without curves over the whole history.
    pub(super) fn chart<'a>(
        &'a self,
        title: &'a str,
        key: &'a str,
        quantity: &'a str,
        unit: Unit,
    ) -> TimeChart<'a> {
        TimeChart {
            title,
            lines: [self.title, key],
            quantity,
            unit,
            span: self.span(),
            events: self.events(),
            ..TimeChart::default()
        }
    }

    /// First contact, last separation, collapse and the fracturing of a hinge, as far as they have happened.
    pub(super) fn events(&self) -> Vec<(f64, &'static str)> {
        let report = self.report;
        let at_end = |outcome| (report.outcome == outcome).then_some(report.end_time);
        [
            (report.first_contact_time, "contact"),
            (report.release_time, "separation"),
            (at_end(Outcome::Collapsed), "collapse"),
            (at_end(Outcome::Fractured), "fractured"),
        ]
        .into_iter()
        .filter_map(|(time, name)| Some((time?, name)))
        .collect()
    }

    /// The outcome as a verb.
    pub(super) fn outcome(&self) -> &'static str {
        match self.report.outcome {
            Outcome::Elastic => "stays elastic",
            Outcome::Plastic => "deforms plastically",
            Outcome::Collapsed => "collapses",
            Outcome::Fractured => "is fractured",
        }
    }

    /// The unit for times of this history.
    pub(super) fn time_unit(&self) -> Unit {
        let (from, to) = self.span();
        Unit::time(from.abs().max(to.abs()))
    }
}
