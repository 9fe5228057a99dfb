//! The refined boundaries of a map as a table, for files and for people.

use std::fmt::Write as _;

use column_twin::assessment::Assumption;
use column_twin::figures::units::significant;
use column_twin::report::short;
use column_twin::study::{
    ACTIONS, AxisValue, ColumnKind, DamageMap, Limit, MapBands, RefinedMap, RowBoundary,
    TableColumn, TableValue,
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
            "action".into(),
            text,
            "",
            "the class that is reached at the boundary; missing at the line of a limit",
        ),
        column(
            "limit".into(),
            text,
            "",
            "web_yields: the web of a bar yields in shear; base_fails: the connection of the base fails; missing at a class",
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
            format!("band_low_{along}"),
            number,
            columns.unit(),
            "lowest value within the ranges of the assumptions, with --bands in some rows",
        ),
        column(
            format!("band_high_{along}"),
            number,
            columns.unit(),
            "highest value within the ranges of the assumptions",
        ),
        column(
            "band_low_by".into(),
            text,
            "",
            "the assumption that leads to the lowest value",
        ),
        column(
            "band_high_by".into(),
            text,
            "",
            "the assumption that leads to the highest value",
        ),
        column(
            "fault".into(),
            text,
            "",
            "why an impact of the row could not be computed",
        ),
    ]
}

/// Hands every row of the table to `write`: the boundaries of the classes, then the lines of the limits.
pub(super) fn boundary_rows<E>(
    map: &DamageMap,
    refined: &RefinedMap,
    bands: Option<&MapBands>,
    mut write: impl FnMut(&[TableValue<'_>]) -> Result<(), E>,
) -> Result<(), E> {
    let classes = refined.boundaries.iter().flat_map(|boundary| {
        let of = (boundary.variant, Some(boundary.action), None);
        boundary.points.iter().map(move |point| (of, point))
    });
    let limits = refined.limits.iter().flat_map(|boundary| {
        let of = (boundary.variant, None, Some(boundary.limit));
        boundary.points.iter().map(move |point| (of, point))
    });
    for ((variant, action, limit), point) in classes.chain(limits) {
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
        let fault = (refined.faults.iter()).find(|it| (it.variant, it.row) == (variant, point.row));
        let band = bands
            .zip(action)
            .and_then(|(bands, action)| bands.in_row(variant, action, point.row));
        let by = |by: Option<Assumption>| TableValue::Text(by.map(Assumption::name));
        write(&[
            TableValue::Text(Some(&map.variants()[variant].label)),
            TableValue::Text(action.map(|it| it.name())),
            TableValue::Text(limit.map(Limit::name)),
            match map.rows().value(point.row) {
                AxisValue::Number(number) => TableValue::Number(Some(number)),
                AxisValue::Name(name) => TableValue::Text(Some(name)),
            },
            TableValue::Text(Some(kind)),
            TableValue::Number(below),
            TableValue::Number(at),
            TableValue::Number(band.map(|it| it.low)),
            TableValue::Number(band.map(|it| it.high)),
            by(band.and_then(|it| it.low_by)),
            by(band.and_then(|it| it.high_by)),
            TableValue::Text(fault.map(|it| it.reason.as_str())),
        ])?;
    }
    Ok(())
}

/// The bands in the rows in which they were computed, for people.
pub(super) fn show_bands(map: &DamageMap, bands: &MapBands) -> String {
    let (rows, columns) = (map.rows().quantity(), map.columns().quantity());
    let unit = |unit: &str| match unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let words = |all: &[Assumption]| {
        let names: Vec<_> = all.iter().map(|it| it.name()).collect();
        names.join(", ")
    };
    let mut text = format!(
        "Bands of the boundaries: {}{}, with one of these changed at a time to the ends of its range: {}; {} responses\n",
        columns.name(),
        unit(columns.unit()),
        words(&bands.varied),
        bands.responses,
    );
    let ends = map.columns().ends().unwrap_or([f64::NAN; 2]);
    // A band that reaches an end of the axis may go on.
    let end = |value: f64| match value {
        value if value >= ends[1] => format!("> {}", short(ends[1])),
        value if value <= ends[0] => format!("<= {}", short(ends[0])),
        value => significant(value, 3),
    };
    let head = format!("{}{}", rows.name(), unit(rows.unit()));
    let _ = write!(text, "  {head:<24}");
    for action in ACTIONS {
        let _ = write!(text, "{:>18}", action.name());
    }
    text.push('\n');
    for (variant, it) in map.variants().iter().enumerate() {
        if map.variants().len() > 1 {
            let _ = writeln!(text, "{}", it.label);
        }
        let of_variant: Vec<_> = (bands.bands.iter())
            .filter(|it| it.variant == variant)
            .collect();
        let first = of_variant.first().map_or(&[][..], |it| &it.points);
        for point in first {
            let value = match map.rows().value(point.row) {
                AxisValue::Number(number) => short(number),
                AxisValue::Name(name) => name.to_owned(),
            };
            let _ = write!(text, "  {value:<24}");
            for action in ACTIONS {
                let band = bands.in_row(variant, action, point.row);
                let shown = band.map_or(String::new(), |it| match it.low >= ends[1] {
                    true => end(it.low),
                    false => format!("{} to {}", end(it.low), end(it.high)),
                });
                let _ = write!(text, "{shown:>18}");
            }
            text.push('\n');
        }
    }
    for (assumption, reason) in &bands.not_varied {
        let _ = writeln!(text, "  not changed: {}: {reason}", assumption.name());
    }
    text.push('\n');
    text
}

/// The boundaries in the rows that were computed for every class, at most nine of them.
pub(super) fn show_boundaries(map: &DamageMap, refined: &RefinedMap) -> String {
    let (rows, columns) = (map.rows().quantity(), map.columns().quantity());
    let unit = |unit: &str| match unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let mut text = format!(
        "Lowest {}{} at which the action changes to at least\n",
        columns.name(),
        unit(shown_unit(columns.unit()))
    );
    let head = format!("{}{}", rows.name(), unit(rows.unit()));
    let _ = write!(text, "  {head:<24}");
    for action in ACTIONS {
        let _ = write!(text, "{:>14}", action.name());
    }
    for limit in Limit::ALL {
        let _ = write!(text, "{:>14}", limit.name().replace('_', " "));
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
            .filter(|row| (0..ACTIONS.len()).all(|class| place(class, *row).is_some()))
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
            let of_limit = |limit: Limit| {
                let mut limits = refined.limits.iter();
                let boundary = limits.find(|it| (it.variant, it.limit) == (variant, limit))?;
                let point = boundary.points.iter().find(|point| point.row == row);
                point.map(|point| point.place)
            };
            let classes = (0..ACTIONS.len()).map(|class| place(class, row));
            for found in classes.chain(Limit::ALL.map(of_limit)) {
                // Of a row that cannot be computed in whole, the ends of its part.
                let computed = (refined.faults.iter())
                    .find(|it| (it.variant, it.row) == (variant, row))
                    .and_then(|it| it.computed);
                let ends = computed.or(map.columns().ends()).unwrap_or([f64::NAN; 2]);
                let shown = match found {
                    Some(RowBoundary::Between {
                        at, rising: true, ..
                    }) => with_km_h(at, columns.unit()),
                    Some(RowBoundary::Between { below, .. }) => {
                        format!("{} (falls)", significant(below, 4))
                    }
                    Some(RowBoundary::Always) => format!("<= {}", short(ends[0])),
                    Some(RowBoundary::Never) => format!("> {}", short(ends[1])),
                    Some(RowBoundary::Infeasible) => "infeasible".to_owned(),
                    // The variant has no such limit, or it was not searched in this row.
                    None => "-".to_owned(),
                };
                let _ = write!(text, "{shown:>14}");
            }
            text.push('\n');
        }
    }
    text.push('\n');
    text
}
