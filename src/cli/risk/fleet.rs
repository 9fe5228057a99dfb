//! `column-twin risk` of a fleet: the probabilities for each of its columns, their sum and their ranking.

use std::fmt::Write as _;
use std::io::Write;

use serde_json::json;

use super::case::{Case, RiskArgs, RiskCommandError, write_file};
use super::numbers::{period, share};
use crate::cli::failure::{Failure, unless_closed};
use crate::cli::fleet_study::{LISTED_COLUMNS, aligned};
use crate::cli::interruption::Interruption;
use column_twin::parameters::FleetColumn;
use column_twin::study::risk::{Estimate, RiskResult};
use column_twin::study::{ACTIONS, BatchEnd, FleetKinds};
use printable::Printable;

/// A column with the result of its kind.
type Row<'a> = (&'a FleetColumn, usize, &'a RiskResult);

/// Computes the risk of each kind of columns and prints that of each column.
pub(super) fn run(arguments: &RiskArgs, output: &mut dyn Write) -> Result<(), Failure> {
    arguments.fleet.check(&[
        ("--config", !arguments.config.is_empty()),
        ("--samples-csv", arguments.samples_csv.is_some()),
        ("--measures", arguments.measures),
        ("--figures", arguments.figures.is_some()),
    ])?;
    let columns = arguments.fleet.load(&arguments.parameter)?;
    let kinds = FleetKinds::of(&columns);
    let interruption = Interruption::listen();
    let mut results = Vec::new();
    for kind in 0..kinds.count() {
        let column = &columns[kinds.first_of(kind)];
        let case = Case::of_scenario(arguments, (*column.parameters).clone())?;
        let outcome = case.compute(arguments, &interruption)?;
        // What has only a part of its samples is not comparable.
        if outcome.end != BatchEnd::Complete {
            break;
        }
        results.push(case.result(arguments, &outcome.tally));
    }
    drop(interruption);
    let mut rows: Vec<Row<'_>> = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let kind = kinds.of_column(index);
        if let Some(result) = results.get(kind) {
            rows.push((column, kind, result));
        }
    }
    let mut files = String::new();
    if let Some(path) = &arguments.csv {
        write_file(path, table(&rows).as_bytes())?;
        files = format!("CSV        {}\n", path.display());
    }
    let text = match arguments.json {
        true => json_of(arguments, columns.len(), &rows)?,
        false => format!(
            "{} columns of {} kinds, {} samples each\n\n{}{files}",
            columns.len(),
            kinds.count(),
            arguments.samples,
            ranking(arguments, &rows)
        ),
    };
    let written = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
    unless_closed(written).map_err(RiskCommandError::Output)?;
    match rows.len() == columns.len() {
        true => Ok(()),
        false => Err(RiskCommandError::FleetInterrupted {
            done: rows.len(),
            columns: columns.len(),
        }
        .into()),
    }
}

/// Expected number of columns that reach each action in the period: the sum of their probabilities, whether or not they depend on
/// one another.
fn expected(rows: &[Row<'_>]) -> Vec<f64> {
    let of_action = |index: usize| {
        let values = rows.iter().map(|(.., it)| probability(it, index).value);
        values.sum::<f64>()
    };
    (0..ACTIONS.len()).map(of_action).collect()
}

fn probability(result: &RiskResult, action: usize) -> Estimate {
    result.actions[action].in_period
}

/// The columns at the highest risk of the highest action first.
fn ranked<'a, 'b>(rows: &'b [Row<'a>]) -> Vec<&'b Row<'a>> {
    let mut order: Vec<_> = rows.iter().collect();
    order.sort_by(|a, b| {
        let actions = (0..ACTIONS.len()).rev();
        let compared = actions
            .map(|it| {
                probability(b.2, it)
                    .value
                    .total_cmp(&probability(a.2, it).value)
            })
            .find(|it| it.is_ne());
        compared
            .unwrap_or(std::cmp::Ordering::Equal)
            .then_with(|| a.0.name.cmp(&b.0.name))
    });
    order
}

fn ranking(arguments: &RiskArgs, rows: &[Row<'_>]) -> String {
    let heading = std::iter::once("column".to_owned());
    let mut lines = vec![
        heading
            .chain(ACTIONS.iter().map(ToString::to_string))
            .collect::<Vec<_>>(),
    ];
    for (column, _, result) in ranked(rows).into_iter().take(LISTED_COLUMNS) {
        let id = Printable(&column.parameters.settings().column_id).to_string();
        let probabilities = (0..ACTIONS.len()).map(|it| share(probability(result, it).value));
        lines.push(std::iter::once(id).chain(probabilities).collect());
    }
    let mut text = format!(
        "Probability of each action or a higher one {}, the columns at the highest risk first\n{}",
        period(arguments.years),
        aligned(&lines)
    );
    let more = rows.len().saturating_sub(LISTED_COLUMNS);
    if more > 0 {
        let _ = writeln!(text, "and {more} more columns; --csv writes all of them");
    }
    let _ = writeln!(
        text,
        "\nExpected number of columns {}",
        period(arguments.years)
    );
    for (action, expected) in ACTIONS.iter().zip(expected(rows)) {
        let _ = writeln!(text, "  {:<10} {expected:.3e}", action.to_string());
    }
    text.push_str(
        "Every column has the distance from the road and the traffic of the options.\n\n",
    );
    text
}

/// One row for each column, in the order of their names.
fn table(rows: &[Row<'_>]) -> String {
    let mut text = String::from("column,column_id,kind");
    for action in ACTIONS {
        let _ = write!(text, ",{action},{action}_low,{action}_high");
    }
    text.push('\n');
    for (column, kind, result) in rows {
        let id = &column.parameters.settings().column_id;
        let _ = write!(text, "{},{},{kind}", quoted(&column.name), quoted(id));
        for index in 0..ACTIONS.len() {
            let Estimate { value, low, high } = probability(result, index);
            let _ = write!(text, ",{value},{low},{high}");
        }
        text.push('\n');
    }
    text
}

/// A field of CSV.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

fn json_of(
    arguments: &RiskArgs,
    columns: usize,
    rows: &[Row<'_>],
) -> Result<String, RiskCommandError> {
    let actions = |numbers: Vec<serde_json::Value>| {
        let names = ACTIONS.iter().map(ToString::to_string);
        names.zip(numbers).collect::<serde_json::Map<_, _>>()
    };
    let row = |(column, kind, result): &&Row<'_>| {
        let in_period = (0..ACTIONS.len()).map(|it| json!(probability(result, it)));
        json!({
            "column": column.name,
            "column_id": column.parameters.settings().column_id,
            "kind": kind,
            "in_period": actions(in_period.collect()),
        })
    };
    let fields = json!({
        "scenario": arguments.scenario,
        "years": arguments.years,
        "vehicles_per_day": arguments.vehicles_per_day,
        "samples": arguments.samples,
        "seed": arguments.seed,
        "confidence": arguments.confidence,
        "complete": rows.len() == columns,
        "expected_columns": actions(expected(rows).into_iter().map(|it| json!(it)).collect()),
        "columns": ranked(rows).iter().map(row).collect::<Vec<_>>(),
    });
    serde_json::to_string_pretty(&fields)
        .map(|text| text + "\n")
        .map_err(|fault| RiskCommandError::Output(fault.into()))
}
