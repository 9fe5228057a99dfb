//! The first line of the report.

use super::reported_impact::ReportedImpact;
use crate::column::{End, HINGE_NAMES, Outcome};
use crate::figures::units::{Unit, significant};
use crate::shape::HINGE_PLACES;

/// How bad an outcome is, for its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tone {
    Calm,
    Warning,
    Alarm,
}

impl Tone {
    /// Name of the style class.
    pub fn class(self) -> &'static str {
        match self {
            Self::Calm => "calm",
            Self::Warning => "warning",
            Self::Alarm => "alarm",
        }
    }
}

/// The verdict on one impact.
pub(super) struct Verdict {
    pub tone: Tone,
    /// The first line.
    pub headline: String,
    /// What decides, with its margin.
    pub reason: String,
    /// What the verdict leaves open.
    pub reservation: Option<String>,
}

impl Verdict {
    /// The verdict of the model.
    pub fn of(impact: &ReportedImpact) -> Self {
        let report = &impact.report;
        let hinge = impact.governing_hinge();
        let named = format!("hinge {} ({})", HINGE_NAMES[hinge], HINGE_PLACES[hinge]);
        let unit = Unit::length(report.max_v1);
        let (tone, headline, reason) = match report.outcome {
            Outcome::Elastic => {
                let utilisation = report.hinges[hinge].max_utilisation;
                (
                    Tone::Calm,
                    "No permanent deformation is predicted".to_owned(),
                    format!(
                        "No hinge of the model yields. The most highly utilised one, {named}, reaches a utilisation of \
                         {utilisation:.3}, where 1 is yielding: a margin of {:.3}. The impact point moves {} at most.",
                        1.0 - utilisation,
                        unit.show(report.max_v1),
                    ),
                )
            }
            Outcome::Plastic => {
                let rotation = report.hinges[hinge].plastic_rotation;
                let remains = report.residual_v1.map_or(
                    "permanent deformation is predicted, without an equilibrium at its end"
                        .to_owned(),
                    |residual| {
                        format!(
                            "{} of permanent displacement are predicted",
                            unit.show(residual)
                        )
                    },
                );
                (
                    Tone::Warning,
                    capitalised(&remains),
                    format!(
                        "{} of 4 hinges yield; the largest plastic rotation is {} rad ({:.1}°), at {named}. The impact point \
                         moves {} at most.",
                        report
                            .hinges
                            .iter()
                            .filter(|it| it.first_yield.is_some())
                            .count(),
                        significant(rotation, 3),
                        rotation.to_degrees(),
                        unit.show(report.max_v1),
                    ),
                )
            }
            Outcome::Collapsed => (
                Tone::Alarm,
                "Collapse is predicted".to_owned(),
                format!(
                    "The column of the model loses its shape or its equilibrium {} after the event.",
                    Unit::time(report.end_time).show(report.end_time),
                ),
            ),
            Outcome::Severed => {
                let rotation = report.hinges[hinge].plastic_rotation;
                (
                    Tone::Alarm,
                    "The column is severed".to_owned(),
                    format!(
                        "{} tears {} after the event, at a plastic rotation of {} rad ({:.1}°); a torn hinge carries nothing.",
                        capitalised(&named),
                        Unit::time(report.end_time).show(report.end_time),
                        significant(rotation, 3),
                        rotation.to_degrees(),
                    ),
                )
            }
        };
        Self {
            tone,
            headline,
            reason,
            reservation: (report.end == End::DurationReached).then(|| {
                format!(
                    "The computation ended after {} (response.duration), before the column came to rest: what happens \
                     later is not included.",
                    Unit::time(report.end_time).show(report.end_time),
                )
            }),
        }
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
