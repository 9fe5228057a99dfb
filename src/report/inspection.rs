//! What must be looked at on site, with the reason: what the checks find, and what they cannot see.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::beam_words;
use super::checks::utilisation;
use super::reported_impact::ReportedImpact;
use super::words::part_of;
use crate::assessment::Criterion;
use crate::column::Outcome;
use crate::figures::units::Unit;
use crate::second_opinion::SecondOpinion;

/// How urgent a place is, the most urgent first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Urgency {
    Exceeded,
    NotChecked,
    Within,
}

/// A place to look at.
struct Place {
    urgency: Urgency,
    name: &'static str,
    signs: &'static str,
    reason: String,
}

/// A lowering of the top beside that by the load on the straight column that has to be looked for \[m\].
const LOWERING: f64 = 1e-3;

/// The list, the most urgent place first.
pub(super) fn markup(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let assessed = assessed.as_ref().ok();
    let mut places = vec![
        base(impact, assessed),
        impact_point(impact, assessed),
        web(impact, assessed),
        Place {
            urgency: Urgency::NotChecked,
            name: "Welds at base and top",
            signs: "cracks, flaked paint",
            reason: "not part of the model".to_owned(),
        },
        Place {
            urgency: Urgency::NotChecked,
            name: "Splice, beam connections",
            signs: "slipped or sheared bolts, cracked welds, bent end plates",
            reason: "not part of the model".to_owned(),
        },
    ];
    places.extend(above(impact, assessed));
    places.sort_by_key(|place| place.urgency);
    html! {
        div.look {
            h2 { "Places to inspect" }
            table.places {
                thead { tr { th { "place" } th { "look for" } th { "why" } } }
                tbody {
                    @for place in &places {
                        tr.exceeded[place.urgency == Urgency::Exceeded] {
                            th scope="row" { (place.name) } td { (place.signs) } td { (place.reason) }
                        }
                    }
                }
            }
        }
    }
}

fn base(impact: &ReportedImpact, assessed: Option<&Assessed>) -> Place {
    let all: Vec<&Criterion> = assessed.map_or(Vec::new(), |it| {
        let criteria = it.criteria.iter();
        criteria.filter(|it| it.name.starts_with("base_")).collect()
    });
    let used = |name: &str| {
        let found = all.iter().find(|it| it.name == name);
        found.and_then(|it| utilisation(it)).unwrap_or(0.0)
    };
    let parts = [
        ("base_shear", "shear"),
        ("base_moment", "moment"),
        ("base_uplift", "uplift"),
    ];
    let shares: Vec<_> = parts
        .into_iter()
        .filter(|(name, _)| used(name) > 0.0)
        .map(|(name, word)| format!("{word} {:.0} %", 100.0 * used(name)))
        .collect();
    let is_checked = all.iter().any(|it| it.value.is_some());
    let is_assumed = assessed
        .and_then(|it| it.base.as_ref())
        .is_some_and(|it| it.is_assumed);
    let (urgency, reason) = match (is_checked, all.iter().any(|it| it.exceeded == Some(true))) {
        (false, _) => (
            Urgency::NotChecked,
            "the connection is not known and was not checked".to_owned(),
        ),
        (true, exceeded) => {
            let plate = if is_assumed {
                " of an assumed plate [A]"
            } else {
                ""
            };
            let mut reason = match shares.is_empty() {
                true => "no force beyond the load".to_owned(),
                false => format!("used by {}{plate}", shares.join(", ")),
            };
            let is_oblique = impact.is_oblique();
            if is_oblique {
                reason += "; moment and uplift across the web are not known";
            }
            let urgency = match (exceeded, is_oblique) {
                (true, _) => Urgency::Exceeded,
                (false, true) => Urgency::NotChecked,
                (false, false) => Urgency::Within,
            };
            (urgency, reason)
        }
    };
    Place {
        urgency,
        name: "Base plate and anchors",
        signs: "bent plate, gap, crushed grout, cracked concrete, anchors stretched, bent or sheared",
        reason,
    }
}

/// Why the impact point may be as it was.
const ELASTIC: &str = "stays elastic as a bar; dents are not part of the model";

fn impact_point(impact: &ReportedImpact, assessed: Option<&Assessed>) -> Place {
    let (urgency, reason) = match assessed.and_then(Assessed::by_beam) {
        Some(by_beam) => match beam_words::finding(by_beam) {
            Some(finding) => (Urgency::Exceeded, finding),
            None => (Urgency::Within, ELASTIC.to_owned()),
        },
        None => by_two_bars(impact),
    };
    Place {
        urgency,
        name: "Impact point, foot, top",
        signs: "kink, dented flange, buckled flange or web, cracks; measure the bow with a straight line",
        reason,
    }
}

/// How the two bars leave the impact point.
fn by_two_bars(impact: &ReportedImpact) -> (Urgency, String) {
    let report = &impact.report;
    match (report.outcome, report.residual_v1) {
        (Outcome::Elastic, _) if impact.is_oblique() => (
            Urgency::NotChecked,
            "checked for the component of the hit in the direction of the web only".to_owned(),
        ),
        (Outcome::Elastic, _) => (Urgency::Within, ELASTIC.to_owned()),
        (Outcome::Plastic, Some(residual)) => (
            Urgency::Exceeded,
            format!(
                "yielded: kink {:.1}°, bow {}; measure it",
                impact.kink().to_degrees(),
                part_of(residual, impact.height())
            ),
        ),
        (Outcome::Plastic, None) => (Urgency::Exceeded, "yielded; measure the bow".to_owned()),
        (Outcome::Collapsed | Outcome::Fractured, _) => (
            Urgency::Exceeded,
            "collapsed or fractured: look from a safe distance".to_owned(),
        ),
    }
}

fn web(impact: &ReportedImpact, assessed: Option<&Assessed>) -> Place {
    let report = &impact.report;
    let largest =
        |of: fn(&crate::column::WebReport) -> f64| report.webs.iter().map(of).fold(0.0, f64::max);
    let used = largest(|web| web.max_utilisation);
    let angle = largest(|web| web.plastic_angle.abs());
    let is_checked = impact.model.properties.shear.is_some() && assessed.is_some();
    let (urgency, reason) = match (is_checked, angle > 0.0) {
        (false, _) => (Urgency::NotChecked, "shear was not checked".to_owned()),
        (true, true) => (
            Urgency::Exceeded,
            format!("sheared by {:.1}° beyond yield", angle.to_degrees()),
        ),
        (true, false) if impact.is_oblique() => (
            Urgency::NotChecked,
            "shear was checked for the component of the hit in the direction of the web only"
                .to_owned(),
        ),
        (true, false) => (
            Urgency::Within,
            format!(
                "shear {:.0} % of its resistance; crippling is not checked",
                100.0 * used
            ),
        ),
    };
    Place {
        urgency,
        name: "Web below and above the hit",
        signs: "diagonal folds, flaked paint, crippling behind the flange",
        reason,
    }
}

/// The structure above, where the top has become lower.
fn above(impact: &ReportedImpact, assessed: Option<&Assessed>) -> Option<Place> {
    let report = &impact.report;
    let beam = assessed.and_then(Assessed::beam);
    let reason = match beam.map_or(report.outcome, SecondOpinion::outcome) {
        Outcome::Collapsed | Outcome::Fractured => {
            "the column gives no support any more".to_owned()
        }
        Outcome::Elastic => return None,
        Outcome::Plastic if impact.is_oblique() => {
            "how far the bent column lowers the top was not computed".to_owned()
        }
        Outcome::Plastic => {
            // A straight column is shortened by its load already.
            let before = impact.samples.first().map_or(0.0, |it| it.u2);
            let lowered = report.residual_u2? - before;
            if lowered < LOWERING {
                return None;
            }
            format!("the top is {} lower", Unit::length(lowered).show(lowered))
        }
    };
    Some(Place {
        urgency: Urgency::Exceeded,
        name: "Beams and floor above",
        signs: "sag, cracks, doors that jam",
        reason,
    })
}
