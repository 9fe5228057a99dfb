//! The refined boundaries of a map as a table, for files and for people.

use std::fmt::Write as _;

use column_twin::figures::units::significant;
use column_twin::report::short;
use column_twin::study::{
    AxisValue, ColumnKind, DamageMap, RefinedMap, RowBoundary, SEVERITIES, TableColumn, TableValue,
};

use super::summary::{shown_unit, with_km_h};

/// Most rows that people are shown, per variant.
const SHOWN_ROWS: usize = 9;

/// The columns of the boundaries in a file.
pub(super) fn boundary_columns(map: &DamageMap) -> Vec<TableColumn> {
    let (rows, columns) = (map.rows().quantity(), map.columns().quantity());
    let column = |name: String, kind, unit, meaning| TableColumn {
        name,
        kind,
        unit,
        meaning,
    };
    let row_kind = match rows.is_named() {
        true => ColumnKind::Text,
        false => ColumnKind::Number,
    };
    let (number, text) = (ColumnKind::Number, ColumnKind::Text);
    let along = columns.column_name();
    vec![
        column("variant".into(), text, "", "the column that was hit"),
        column(
            "severity".into(),
            text,
            "",
            "the class that is reached at the boundary",
        ),
        column(rows.column_name(), row_kind, rows.unit(), "the row"),
        column(
            "boundary".into(),
            text,
            "",
            "rising, falling, always, never or infeasible",
        ),
        column(
            format!("below_{along}"),
            number,
            columns.unit(),
            "lower value of the bracket of at most 1 %",
        ),
        column(
            format!("at_{along}"),
            number,
            columns.unit(),
            "upper value of the bracket",
        ),
        column(
            "fault".into(),
            text,
            "",
            "why an impact of the row could not be computed",
        ),
    ]
}

/// Hands every row of the table to `write`.
pub(super) fn boundary_rows<E>(
    map: &DamageMap,
    refined: &RefinedMap,
    mut write: impl FnMut(&[TableValue<'_>]) -> Result<(), E>,
) -> Result<(), E> {
    for boundary in &refined.boundaries {
        for point in &boundary.points {
            let (kind, below, at) = match point.place {
                RowBoundary::Between {
                    below,
                    at,
                    rising: true,
                } => ("rising", Some(below), Some(at)),
                RowBoundary::Between {
                    below,
                    at,
                    rising: false,
                } => ("falling", Some(below), Some(at)),
                RowBoundary::Always => ("always", None, None),
                RowBoundary::Never => ("never", None, None),
                RowBoundary::Infeasible => ("infeasible", None, None),
            };
            let fault = (refined.faults.iter())
                .find(|it| (it.variant, it.row) == (boundary.variant, point.row));
            write(&[
                TableValue::Text(Some(&map.variants()[boundary.variant].label)),
                TableValue::Text(Some(boundary.severity.name())),
                match map.rows().value(point.row) {
                    AxisValue::Number(number) => TableValue::Number(Some(number)),
                    AxisValue::Name(name) => TableValue::Text(Some(name)),
                },
                TableValue::Text(Some(kind)),
                TableValue::Number(below),
                TableValue::Number(at),
                TableValue::Text(fault.map(|it| it.reason.as_str())),
            ])?;
        }
    }
    Ok(())
}

/// The boundaries in the rows that were computed for every class, at most nine of them.
pub(super) fn show_boundaries(map: &DamageMap, refined: &RefinedMap) -> String {
    let (rows, columns) = (map.rows().quantity(), map.columns().quantity());
    let unit = |unit: &str| match unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let mut text = format!(
        "Lowest {}{} at which the severity changes to at least\n",
        columns.name(),
        unit(shown_unit(columns.unit()))
    );
    let head = format!("{}{}", rows.name(), unit(rows.unit()));
    let _ = write!(text, "  {head:<24}");
    for severity in SEVERITIES {
        let _ = write!(text, "{:>14}", severity.name());
    }
    text.push('\n');
    for (variant, it) in map.variants().iter().enumerate() {
        let of_variant: Vec<_> = refined
            .boundaries
            .iter()
            .filter(|it| it.variant == variant)
            .collect();
        let place = |class: usize, row: u64| {
            let points = of_variant.get(class).map(|it| &it.points)?;
            points
                .iter()
                .find(|point| point.row == row)
                .map(|point| point.place)
        };
        let Some(first) = of_variant.first() else {
            continue;
        };
        let complete: Vec<u64> = first
            .points
            .iter()
            .map(|point| point.row)
            .filter(|row| (0..SEVERITIES.len()).all(|class| place(class, *row).is_some()))
            .collect();
        if map.variants().len() > 1 {
            let _ = writeln!(text, "{}", it.label);
        }
        let shown = SHOWN_ROWS.min(complete.len());
        for number in 0..shown {
            let row = complete[number * (complete.len() - 1) / (shown - 1).max(1)];
            let value = match map.rows().value(row) {
                AxisValue::Number(number) => short(number),
                AxisValue::Name(name) => name.to_owned(),
            };
            let _ = write!(text, "  {value:<24}");
            for class in 0..SEVERITIES.len() {
                // Of a row that cannot be computed in whole, the ends of its part.
                let computed = (refined.faults.iter())
                    .find(|it| (it.variant, it.row) == (variant, row))
                    .and_then(|it| it.computed);
                let ends = computed.or(map.columns().ends()).unwrap_or([f64::NAN; 2]);
                let shown = match place(class, row) {
                    Some(RowBoundary::Between {
                        at, rising: true, ..
                    }) => with_km_h(at, columns.unit()),
                    Some(RowBoundary::Between { below, .. }) => {
                        format!("{} (falls)", significant(below, 4))
                    }
                    Some(RowBoundary::Always) => format!("<= {}", short(ends[0])),
                    Some(RowBoundary::Never) => format!("> {}", short(ends[1])),
                    Some(RowBoundary::Infeasible) => "infeasible".to_owned(),
                    None => String::new(),
                };
                let _ = write!(text, "{shown:>14}");
            }
            text.push('\n');
        }
    }
    text.push('\n');
    text
}
