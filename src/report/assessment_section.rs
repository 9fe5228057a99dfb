//! Criteria and remaining capacity as tables.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::facts::fact;
use super::words::short;
use crate::assessment::Criterion;
use crate::column::{BucklingResistance, Capacity, CapacityEnd};
use crate::figures::units::{Unit, significant};
use crate::parameters::Provenance;

/// Every criterion with value, limit, margin and tag: first those that decide.
pub(super) fn criteria(assessed: &Assessed) -> Markup {
    let deciding = assessed.assessment.deciding_criterion;
    let of = |decides: bool| {
        let criteria = assessed.assessment.criteria.iter();
        criteria.filter(move |criterion| criterion.decides == decides)
    };
    html! {
        h3 { "Criteria" }
        table {
            caption { "Criteria that decide the severity. The margin is relative to the limit; a negative one is exceeded." }
            (head())
            tbody { @for criterion in of(true) { (row(criterion, criterion.name == deciding)) } }
        }
        table {
            caption { "Other criteria, for information; the parameter " code { "assessment.criteria" } " chooses those that decide." }
            (head())
            tbody { @for criterion in of(false) { (row(criterion, false)) } }
        }
        p.note {
            "Tags: "
            @for (index, tag) in Provenance::ALL.into_iter().enumerate() {
                @if index > 0 { "; " }
                "[" (tag) "] " (tag.meaning())
            }
            "."
        }
    }
}

fn head() -> Markup {
    html! {
        thead {
            tr {
                th { "criterion, edition" } th.number { "value" } th.number { "limit" } th.number { "margin" }
                th { "tag" } th { "if exceeded" }
            }
        }
    }
}

fn row(criterion: &Criterion, is_deciding: bool) -> Markup {
    let exceeded = criterion.exceeded == Some(true);
    let number =
        |value: Option<f64>| value.map_or("-".to_owned(), |value| quantity(value, criterion.unit));
    html! {
        tr.exceeded[exceeded].deciding[is_deciding] {
            th scope="row" {
                (criterion.name.replace('_', " "))
                @if is_deciding { " (decides)" }
                br;
                small { (criterion.edition) }
                @if criterion.exceeded.is_none() { br; small { (criterion.statement) } }
            }
            td.number { (number(criterion.value)) }
            td.number { (number(criterion.limit)) }
            td.number {
                @match (criterion.margin, criterion.limit) {
                    (Some(_), Some(limit)) if limit == 0.0 => { @if exceeded { "exceeded" } @else { "met" } }
                    (Some(margin), _) => { (margin_in_words(margin)) }
                    (None, _) => { "not evaluated" }
                }
            }
            td { "[" (criterion.tag) "]" }
            td { (criterion.severity) }
        }
    }
}

/// A margin in per cent, with a decimal where it is small.
fn margin_in_words(margin: f64) -> String {
    let percent = 100.0 * margin;
    match percent.abs() < 10.0 {
        true => format!("{percent:+.1} %"),
        false => format!("{percent:+.0} %"),
    }
}

/// A number of a criterion with its unit.
fn quantity(value: f64, unit: &str) -> String {
    match unit {
        "N" => Unit::force(value).show(value),
        "" => significant(value, 3),
        unit => format!("{} {unit}", significant(value, 3)),
    }
}

/// The remaining capacity, virgin against now.
pub(super) fn capacity(assessed: &Assessed) -> Markup {
    let remaining = &assessed.remaining;
    let force = |si: f64| Unit::force(si).show(si);
    let governs = |is_weak: bool| match is_weak {
        true => "the weak axis governs",
        false => "the plane of the impact governs",
    };
    html! {
        table.facts {
            tbody {
                (fact("Load, N_Ed", &assessed.assessment.load))
                (fact("Push-down of the virgin column", capacity_in_words(&remaining.virgin)))
                (fact("Push-down of the column as it is", capacity_in_words(&remaining.now)))
                (fact("Ratio, damage index", format!("{} of the virgin column; D = {}", significant(remaining.ratio, 3), significant(remaining.damage, 3))))
                (fact("N_u", format!("{}: this ratio times the resistance about the strong axis", force(remaining.axial_capacity))))
                (fact("Reserve, N_u / N_Ed", remaining.reserve.map_or("none: no compressive load".to_owned(), |it| significant(it, 3))))
                (fact("Buckling resistance, strong axis", resistance(&remaining.strong)))
                (fact("Buckling resistance, weak axis", remaining.weak.as_ref().map_or(
                    "not known: the dimensions of the section are not given".to_owned(), resistance)))
                (fact("Remaining resistance", match (remaining.resistance, remaining.weak_axis_governs()) {
                    (Some(found), Some(is_weak)) => format!("{}; {}", force(found), governs(is_weak)),
                    _ => "not known without the weak axis".to_owned(),
                }))
            }
        }
        p.note {
            "The push-down finds the largest static force in the plane of the impact, with the plastic deformation as it is and a \
             bow of " (Unit::length(remaining.virgin.imperfection).show(remaining.virgin.imperfection))
            ". It is too stiff for slender columns, so that its ratio alone counts, times the buckling resistance of the code. The \
             model is plane: about the weak axis the same ratio is assumed to be left [A]."
        }
    }
}

fn capacity_in_words(capacity: &Capacity) -> String {
    let force = Unit::force(capacity.force).show(capacity.force);
    match capacity.end {
        CapacityEnd::NoEquilibrium => {
            "0 kN: the column has no equilibrium and carries nothing".to_owned()
        }
        _ if capacity.is_lower_bound() => {
            format!("at least {force}: the push-down could not be followed to its end")
        }
        _ => format!(
            "{force}, at a displacement of {}",
            Unit::length(capacity.v1).show(capacity.v1)
        ),
    }
}

fn resistance(resistance: &BucklingResistance) -> String {
    format!(
        "{} (EN 1993-1-1, 6.3.1: curve {}, buckling length {} m, slenderness {})",
        Unit::force(resistance.force).show(resistance.force),
        format!("{:?}", resistance.curve).to_lowercase(),
        short(resistance.buckling_length),
        significant(resistance.slenderness, 3),
    )
}
