//! The checks as a table: the names people use, clause and edition, value, limit, utilisation, and what follows.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::words::part_of;
use crate::assessment::{Action, Criterion, UNIT_OF_BOW};
use crate::figures::units::significant;
use crate::parameters::Provenance;

/// Most rows and reasons why something was not evaluated on the page of the checks: what the default criteria fill.
const MAX_LINES: usize = 23;

/// The same where the others stand in the annex: their names and clauses may be longer.
const MAX_LINES_OF_MORE: usize = 19;

/// The checks that decide, on one page: those that are exceeded, those that could not be evaluated, and the others.
pub(super) fn deciding(assessed: &Assessed) -> Markup {
    let all = ordered(assessed, true);
    let (shown, more) = all.split_at(on_the_page(&all));
    html! {
        h2 { "Checks that decide" }
        (table(assessed, shown))
        @if !more.is_empty() { p.note { (more.len()) " further checks that decide stand in the annex." } }
        p.note {
            "Resistances are characteristic ones (γ_M = 1.0). Tags: "
            @for (index, tag) in Provenance::ALL.into_iter().enumerate() {
                @if index > 0 { "; " }
                "[" (tag) "] " (tag.meaning())
            }
            "."
        }
    }
}

/// The checks that do not stand on the page of the checks.
pub(super) fn others(assessed: &Assessed) -> Markup {
    let all = ordered(assessed, true);
    let more = &all[on_the_page(&all)..];
    html! {
        @if !more.is_empty() {
            h3 { "Further checks that decide" }
            (table(assessed, more))
        }
        h3 { "Checks for information" }
        p { "They do not decide; the parameter " code { "assessment.criteria" } " chooses those that do." }
        (table(assessed, &ordered(assessed, false)))
    }
}

/// How many of these checks fit on their page.
fn on_the_page(all: &[&Criterion]) -> usize {
    let lines = |count: usize| count + reasons(&all[..count]).len();
    if lines(all.len()) <= MAX_LINES {
        return all.len();
    }
    (0..=all.len())
        .rev()
        .find(|count| lines(*count) <= MAX_LINES_OF_MORE)
        .unwrap_or(0)
}

/// Why checks could not be evaluated, each reason once.
fn reasons<'c>(rows: &[&'c Criterion]) -> Vec<&'c str> {
    let mut reasons: Vec<&str> = Vec::new();
    for it in rows.iter().filter(|it| it.exceeded.is_none()) {
        if !reasons.contains(&it.statement.as_str()) {
            reasons.push(&it.statement);
        }
    }
    reasons
}

/// The most severe exceeded ones first, then those without data, then the others by their utilisation.
fn ordered(assessed: &Assessed, decides: bool) -> Vec<&Criterion> {
    let criteria = assessed.criteria.iter();
    let mut all: Vec<_> = criteria.filter(|it| it.decides == decides).collect();
    let rank = |it: &Criterion| match it.exceeded {
        Some(true) => 0,
        None => 1,
        Some(false) => 2,
    };
    all.sort_by(|one, other| {
        let action = || other.action.cmp(&one.action);
        let used = || {
            let [one, other] = [one, other].map(|it| utilisation(it).unwrap_or(0.0));
            other.total_cmp(&one)
        };
        rank(one).cmp(&rank(other)).then_with(|| match rank(one) {
            2 => used(),
            _ => action(),
        })
    });
    all
}

fn table(assessed: &Assessed, rows: &[&Criterion]) -> Markup {
    let deciding = assessed.assessment.deciding_criterion;
    let is_none = assessed.assessment.action == Action::None;
    let reasons = reasons(rows);
    let note = |it: &Criterion| reasons.iter().position(|reason| *reason == it.statement);
    html! {
        table.checks {
            thead {
                tr {
                    th { "check" } th { "clause and edition" } th.number { "value" } th.number { "limit" }
                    th.number { "used" } th { "result" }
                }
            }
            tbody {
                @for criterion in rows {
                    @let exceeded = criterion.exceeded == Some(true);
                    tr.exceeded[exceeded].deciding[criterion.name == deciding && !is_none] {
                        th scope="row" { (criterion.title) }
                        td { (clause(criterion)) " [" (criterion.tag) "]" }
                        td.number { (value_in_words(criterion).unwrap_or_else(|| "-".to_owned())) }
                        td.number { (limit_in_words(criterion).unwrap_or_else(|| "-".to_owned())) }
                        td.number { (utilisation_in_words(criterion)) }
                        td {
                            @match (criterion.exceeded, note(criterion)) {
                                (Some(true), _) => { strong { (criterion.action.name().to_uppercase()) } }
                                (Some(false), _) => { "met" }
                                (None, Some(index)) => { "not evaluated " sup { (index + 1) } }
                                (None, None) => { "not evaluated" }
                            }
                        }
                    }
                }
            }
        }
        @if !reasons.is_empty() {
            ol.reasons { @for reason in &reasons { li { (reason) } } }
        }
    }
}

/// Document, edition and clause of the limit.
fn clause(criterion: &Criterion) -> &'static str {
    match criterion.edition {
        "column_twin" => "this program",
        edition => edition,
    }
}

/// Value over limit, or limit over value where the value has to be at least the limit; `None` where the limit is 0 or nothing
/// was evaluated.
pub(super) fn utilisation(criterion: &Criterion) -> Option<f64> {
    let (value, limit, margin) = (criterion.value?, criterion.limit?, criterion.margin?);
    if limit == 0.0 {
        return None;
    }
    let is_at_most = (limit - value) * margin >= 0.0;
    Some(if is_at_most {
        value / limit
    } else {
        limit / value
    })
}

fn utilisation_in_words(criterion: &Criterion) -> String {
    match utilisation(criterion) {
        None => "-".to_owned(),
        Some(used) if used > 10.0 => "> 1000 %".to_owned(),
        Some(used) => format!("{:.0} %", 100.0 * used),
    }
}

/// The value with its unit, as people write it; `None` where it was not evaluated.
pub(super) fn value_in_words(criterion: &Criterion) -> Option<String> {
    let value = criterion.value?;
    Some(match (criterion.name, criterion.limit) {
        ("collapse", _) => if value > 0.0 { "lost" } else { "kept" }.to_owned(),
        (_, Some(0.0)) if value == 0.0 => "none".to_owned(),
        _ => quantity(value, criterion.unit),
    })
}

/// The limit with its unit.
pub(super) fn limit_in_words(criterion: &Criterion) -> Option<String> {
    let limit = criterion.limit?;
    Some(match (criterion.name, limit) {
        ("collapse", _) => "kept".to_owned(),
        (_, 0.0) => "none".to_owned(),
        _ if criterion.unit == "rad" => format!("{} rad", significant(limit, 2)),
        _ => quantity(limit, criterion.unit),
    })
}

/// A number of a criterion with its unit: bows as a part of the length, rotations with their degrees.
fn quantity(value: f64, unit: &str) -> String {
    match unit {
        "N" => format!("{:.0} kN", 1e-3 * value),
        "N m" => format!("{:.0} kNm", 1e-3 * value),
        UNIT_OF_BOW => part_of(value, 1.0),
        "rad" => format!("{} rad ({:.1}°)", significant(value, 2), value.to_degrees()),
        "deg" => format!("{value:.1}°"),
        "" => format!("{value:.2}"),
        unit => format!("{} {unit}", significant(value, 3)),
    }
}
