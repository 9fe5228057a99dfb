//! `column-twin map` of a fleet: the critical velocities of one vehicle for each of its columns.

use std::fmt::Write as _;
use std::io::Write;
use std::time::Instant;

use super::arguments::MapArgs;
use super::error::{Ended, MapCommandError};
use super::files::Files;
use crate::cli::failure::{Exit, Failure};
use crate::cli::fleet_study::{LISTED_COLUMNS, aligned};
use crate::cli::interruption::Interruption;
use column_twin::parameters::FleetColumn;
use column_twin::study::{
    ACTIONS, BatchEnd, ColumnKind, CriticalVelocities, CriticalVelocity, FleetKinds,
    LIMIT_VELOCITIES, StudyColumn, TableColumn, TableValue, part_of,
};
use printable::Printable;

/// What is known of one kind of columns.
struct KindResult {
    vehicle: String,
    mass: f64,
    found: Result<CriticalVelocities, String>,
}

/// Computes the critical velocities of the columns and writes the requested files.
pub(super) fn run(arguments: &MapArgs, output: &mut dyn Write) -> Result<(), Failure> {
    arguments.check_fleet()?;
    let overrides = arguments.fleet_overrides()?;
    let all = arguments.fleet.load(&overrides)?;
    let part = match arguments.part()? {
        None => 0..all.len(),
        Some((number, parts)) => part_of(all.len(), number, parts),
    };
    let columns = &all[part];
    let range = arguments.velocities()?;
    let kinds = FleetKinds::of(columns);
    let to_error = arguments.takes_standard_output();
    let metadata = vec![
        ("format", "column_twin fleet velocities 1".to_owned()),
        ("column_twin", format!("\"{}\"", env!("CARGO_PKG_VERSION"))),
        ("columns_of_the_fleet", all.len().to_string()),
        (
            "shard",
            arguments.shard.clone().unwrap_or_else(|| "1/1".to_owned()),
        ),
        ("velocity_from_m_s", range[0].to_string()),
        ("velocity_to_m_s", range[1].to_string()),
    ];
    let mut files = Files::create(
        arguments,
        &table_columns(),
        &metadata,
        "columns",
        &mut *output,
    )
    .map_err(MapCommandError::from)?;
    let batch = arguments.batch(kinds.count() as u64);
    let start = Instant::now();
    let mut results: Vec<KindResult> = Vec::new();
    let interruption = Interruption::listen();
    let end = interruption.watch(&batch, kinds.count() as u64, "kinds of columns", || {
        batch.run(
            kinds.count() as u64,
            |kind| compute(&columns[kinds.first_of(kind as usize)], range),
            |part| {
                results.extend(part);
                Ok::<(), MapCommandError>(())
            },
        )
    })?;
    drop(interruption);
    let elapsed = start.elapsed();
    let mut rows: Vec<(&FleetColumn, usize, &KindResult)> = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let kind = kinds.of_column(index);
        if let Some(result) = results.get(kind) {
            rows.push((column, kind, result));
        }
    }
    for (column, kind, result) in &rows {
        write_row(&mut files, column, *kind, result).map_err(MapCommandError::from)?;
    }
    let responses: usize = results
        .iter()
        .filter_map(|it| it.found.as_ref().ok())
        .map(|it| it.responses)
        .sum();
    let is_complete = end == BatchEnd::Complete;
    let closing = [
        ("complete", is_complete.to_string()),
        ("columns_done", rows.len().to_string()),
    ];
    let written = files.finish(&closing).map_err(MapCommandError::from)?;
    let mut text = format!(
        "{} columns of {} kinds, {responses} responses in {:.1} s on {} threads\n\n",
        columns.len(),
        kinds.count(),
        elapsed.as_secs_f64(),
        arguments.thread_count(kinds.count() as u64),
    );
    text.push_str(&ranking(&rows, range));
    text.push_str(&written);
    let mut missing = Vec::new();
    if !is_complete {
        let files = match arguments.writes_files() {
            true => "; the files contain these",
            false => "",
        };
        missing.push(format!(
            "interrupted: {} of {} columns are done{files}",
            rows.len(),
            columns.len()
        ));
    }
    let faults = rows
        .iter()
        .filter_map(|(column, _, it)| Some((column, it.found.as_ref().err()?)));
    let faults: Vec<_> = faults.collect();
    if let Some((column, fault)) = faults.first() {
        missing.push(format!(
            "{} columns could not be computed; the first one, {}: {fault}",
            faults.len(),
            column.name
        ));
    }
    let missing = (!missing.is_empty()).then(|| missing.join("\n"));
    Ended { text, missing }.print(to_error, output)
}

fn compute(column: &FleetColumn, range: [f64; 2]) -> KindResult {
    let parameters = &column.parameters;
    let vehicle = parameters.settings().vehicle.name.clone();
    let computed = StudyColumn::undamaged(parameters).and_then(|study| {
        let mass = study.impact(None, None, range[0])?.mass;
        Ok((mass, study.critical_velocities(None, None, range)?))
    });
    match computed {
        Ok((mass, found)) => KindResult {
            vehicle,
            mass,
            found: Ok(found),
        },
        Err(error) => KindResult {
            vehicle,
            mass: f64::NAN,
            found: Err(error.to_string()),
        },
    }
}

/// The columns of the files.
fn table_columns() -> Vec<TableColumn> {
    let text = |name: &str, meaning| TableColumn {
        name: name.to_owned(),
        kind: ColumnKind::Text,
        unit: "",
        meaning,
    };
    let number = |name: String, unit, meaning| TableColumn {
        name,
        kind: ColumnKind::Number,
        unit,
        meaning,
    };
    let whole = |name: &str, meaning| TableColumn {
        name: name.to_owned(),
        kind: ColumnKind::Whole,
        unit: "",
        meaning,
    };
    let mut columns = vec![
        text("column", "name of the column, with its namespace"),
        text("column_id", "identifier of the column"),
        whole("kind", "columns of one kind differ by their names only"),
        text(
            "vehicle",
            "name of the vehicle in the catalogue, or rigid; empty: user-defined",
        ),
        number("mass_kg".to_owned(), "kg", "total mass of the vehicle"),
    ];
    columns.extend(ACTIONS.map(|it| {
        number(
            format!("critical_velocity_{it}_m_s"),
            "m/s",
            "highest velocity found below the lowest one of this action; 0: the lowest velocity leads to it; none: no velocity does",
        )
    }));
    columns.push(whole(
        "responses",
        "responses from which the velocities follow",
    ));
    columns.push(text("fault", "why the column could not be computed"));
    columns
}

fn write_row(
    files: &mut Files<'_>,
    column: &FleetColumn,
    kind: usize,
    result: &KindResult,
) -> Result<(), super::MapFileError> {
    let found = result.found.as_ref().ok();
    let mut values = vec![
        TableValue::Text(Some(&column.name)),
        TableValue::Text(Some(&column.parameters.settings().column_id)),
        TableValue::Whole(Some(kind as u64)),
        TableValue::Text(Some(&result.vehicle)),
        TableValue::Number(result.mass.is_finite().then_some(result.mass)),
    ];
    for index in 0..ACTIONS.len() {
        let velocity = found.and_then(|it| safe_velocity(it.velocities[index]));
        values.push(TableValue::Number(velocity));
    }
    values.push(TableValue::Whole(found.map(|it| it.responses as u64)));
    values.push(TableValue::Text(
        result.found.as_ref().err().map(String::as_str),
    ));
    files.row(&values)
}

/// The highest velocity found at which an action is not reached \[m/s\]; 0 if the lowest one leads to it, `None` if none does.
fn safe_velocity(found: CriticalVelocity) -> Option<f64> {
    match found {
        CriticalVelocity::Between { below, .. } => Some(below),
        CriticalVelocity::AtMost { .. } => Some(0.0),
        CriticalVelocity::Above { .. } => None,
    }
}

/// The weakest columns first: those that the lowest velocity of the highest action endangers.
fn ranking(rows: &[(&FleetColumn, usize, &KindResult)], range: [f64; 2]) -> String {
    let velocities = |it: &KindResult| -> [f64; ACTIONS.len()] {
        match &it.found {
            Ok(found) => found
                .velocities
                .map(|it| safe_velocity(it).unwrap_or(f64::INFINITY)),
            Err(_) => [-1.0; ACTIONS.len()], // nothing is known, so that they come first
        }
    };
    let mut order: Vec<_> = rows.iter().collect();
    order.sort_by(|a, b| {
        let (a_v, b_v) = (velocities(a.2), velocities(b.2));
        let compared = a_v.iter().zip(&b_v).rev().map(|(a, b)| a.total_cmp(b));
        let first = compared.into_iter().find(|it| it.is_ne());
        first
            .unwrap_or(std::cmp::Ordering::Equal)
            .then_with(|| a.0.name.cmp(&b.0.name))
    });
    let mut lines = vec![
        ["column", "vehicle", "mass kg"]
            .into_iter()
            .map(str::to_owned)
            .chain(ACTIONS.iter().map(|it| format!("{it} m/s")))
            .collect::<Vec<_>>(),
    ];
    for (column, _, result) in order.iter().take(LISTED_COLUMNS) {
        let id = &column.parameters.settings().column_id;
        let vehicle = match result.vehicle.as_str() {
            "" => "user-defined",
            name => name,
        };
        let mut line = vec![
            Printable(id).to_string(),
            vehicle.to_owned(),
            format!("{:.0}", result.mass),
        ];
        line.extend(velocities(result).map(|it| match it {
            it if it.is_infinite() => format!("> {}", range[1]),
            0.0 => format!("< {}", range[0]),
            it if it < 0.0 => "failed".to_owned(),
            it => format!("{it:.2}"),
        }));
        lines.push(line);
    }
    let mut text = "Velocities that lead to an action, the weakest columns first\n".to_owned()
        + &aligned(&lines);
    let more = order.len().saturating_sub(LISTED_COLUMNS);
    if more > 0 {
        let _ = writeln!(text, "and {more} more columns; --csv writes all of them");
    }
    text.push('\n');
    text
}

impl MapArgs {
    /// # Errors
    /// Options that a study of a fleet does not have.
    fn check_fleet(&self) -> Result<(), Failure> {
        self.check_outputs()?;
        self.fleet.check(&self.options_of_one_column())
    }

    /// The range of the search \[m/s\].
    fn velocities(&self) -> Result<[f64; 2], Failure> {
        let Some(text) = self.velocity() else {
            return Ok(LIMIT_VELOCITIES);
        };
        let range = text.split_once(':').and_then(|(from, to)| {
            let (from, to): (f64, f64) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
            (from > 0.0 && from < to && to.is_finite()).then_some([from, to])
        });
        range.ok_or_else(|| {
            let text: String = text.chars().take(60).collect();
            Failure::plain(
                Exit::BadInput,
                format!(
                    "--velocity {text}: a study of a fleet searches critical velocities; expected a range from:to [m/s], such as 1:40"
                ),
            )
        })
    }

    /// The part of the columns that `--shard` names, and the number of parts.
    fn part(&self) -> Result<Option<(usize, usize)>, Failure> {
        let Some((number, parts)) = self.shard_numbers()? else {
            return Ok(None);
        };
        let whole = |it: u64| usize::try_from(it).unwrap_or(usize::MAX);
        Ok(Some((whole(number), whole(parts))))
    }
}
