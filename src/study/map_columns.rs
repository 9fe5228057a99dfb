//! The columns of a map in files: one table of names, units and values for every format.

use super::axis::AxisValue;
use super::map::{DamageMap, MapCell};
use super::study_column::Evaluation;
use crate::assessment::Action;
use crate::results::outcome_word;

/// A column of a table in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct TableColumn {
    /// Its name, which ends with the unit.
    pub name: String,
    /// The kind of its values.
    pub kind: ColumnKind,
    /// SI unit; empty where there is none.
    pub unit: &'static str,
    /// Its meaning, in one line.
    pub meaning: &'static str,
}

/// The kind of the values of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Whole numbers that may be missing.
    Whole,
    /// Numbers that may be missing.
    Number,
    /// Words that may be missing.
    Text,
}

/// A value in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TableValue<'a> {
    /// A whole number; `None` if it does not exist.
    Whole(Option<u64>),
    /// A number; `None` if it does not exist.
    Number(Option<f64>),
    /// A word; `None` if it does not exist.
    Text(Option<&'a str>),
}

/// A result of an impact: name, unit, meaning, and the value.
type ResultColumn = (
    &'static str,
    ColumnKind,
    &'static str,
    &'static str,
    fn(&Evaluation) -> TableValue<'static>,
);

/// What is written of every impact that was computed.
const RESULTS: [ResultColumn; 13] = [
    (
        "action",
        ColumnKind::Text,
        "",
        "required action: none, inspect, restrict, shore or evacuate",
        |it| TableValue::Text(Some(Action::name(it.action))),
    ),
    (
        "action_level",
        ColumnKind::Whole,
        "",
        "the action as a number, from 0 (none) to 4 (evacuate)",
        |it| TableValue::Whole(Some(it.action as u64)),
    ),
    (
        "deciding_criterion",
        ColumnKind::Text,
        "",
        "the criterion that decides; docs/assessment.md lists them",
        |it| TableValue::Text(Some(it.deciding_criterion)),
    ),
    (
        "outcome",
        ColumnKind::Text,
        "",
        "elastic, plastic, collapsed or fractured",
        |it| TableValue::Text(Some(outcome_word(it.outcome))),
    ),
    (
        "max_v1_m",
        ColumnKind::Number,
        "m",
        "peak displacement of the impact point",
        |it| TableValue::Number(Some(it.max_v1)),
    ),
    (
        "residual_v1_m",
        ColumnKind::Number,
        "m",
        "residual displacement of the impact point; missing where the column does not stand",
        |it| TableValue::Number(it.residual_v1),
    ),
    (
        "peak_contact_force_n",
        ColumnKind::Number,
        "N",
        "largest contact force",
        |it| TableValue::Number(Some(it.peak_contact_force)),
    ),
    (
        "residual_capacity_n",
        ColumnKind::Number,
        "N",
        "largest force of the push-down; 0 where the column carries nothing",
        |it| TableValue::Number(Some(it.residual_capacity)),
    ),
    (
        "capacity_ratio",
        ColumnKind::Number,
        "",
        "force of the push-down over the force of the undamaged column",
        |it| TableValue::Number(Some(it.capacity_ratio)),
    ),
    (
        "reserve",
        ColumnKind::Number,
        "",
        "N_u, this ratio times the buckling resistance about the strong axis, over the applied load N; missing without a compressive load",
        |it| TableValue::Number(it.reserve),
    ),
    (
        "max_plastic_rotation_rad",
        ColumnKind::Number,
        "rad",
        "largest plastic rotation of a hinge",
        |it| TableValue::Number(Some(it.max_plastic_rotation)),
    ),
    (
        "max_plastic_shear_rad",
        ColumnKind::Number,
        "rad",
        "largest plastic shear angle of a web; above 0 it has yielded in shear",
        |it| TableValue::Number(Some(it.max_plastic_shear)),
    ),
    (
        "base_utilisation",
        ColumnKind::Number,
        "",
        "largest utilisation of the connection of the base; above 1 it fails; missing where the base is not known",
        |it| TableValue::Number(it.base_utilisation),
    ),
];

impl DamageMap {
    /// The columns of the map in a file: number of the cell, variant, the values on both axes, and the results.
    #[must_use]
    pub fn table_columns(&self) -> Vec<TableColumn> {
        let column = |name: &str, kind, unit, meaning| TableColumn {
            name: name.to_owned(),
            kind,
            unit,
            meaning,
        };
        let mut columns = vec![
            column(
                "cell",
                ColumnKind::Whole,
                "",
                "number of the cell in the whole map, from 0",
            ),
            column(
                "variant",
                ColumnKind::Text,
                "",
                "the column that was hit: its column_id, or the compared variant",
            ),
        ];
        columns.extend([self.rows(), self.columns()].map(|axis| {
            let quantity = axis.quantity();
            let kind = match quantity.is_named() {
                true => ColumnKind::Text,
                false => ColumnKind::Number,
            };
            column(
                &quantity.column_name(),
                kind,
                quantity.unit(),
                "value on an axis of the map",
            )
        }));
        columns.extend(
            RESULTS.map(|(name, kind, unit, meaning, _)| column(name, kind, unit, meaning)),
        );
        columns.push(column(
            "fault",
            ColumnKind::Text,
            "",
            "why the impact could not be computed; then the results are missing",
        ));
        columns
    }

    /// The values of a cell, in the order of [`table_columns`](Self::table_columns).
    pub fn table_values<'a>(&'a self, cell: &'a MapCell) -> impl Iterator<Item = TableValue<'a>> {
        let place = cell.place;
        let value = |value| match value {
            AxisValue::Number(number) => TableValue::Number(Some(number)),
            AxisValue::Name(name) => TableValue::Text(Some(name)),
        };
        let head = [
            TableValue::Whole(Some(cell.index)),
            TableValue::Text(Some(&self.variants()[place.variant].label)),
            value(self.rows().value(place.row)),
            value(self.columns().value(place.column)),
        ];
        let results = RESULTS
            .iter()
            .map(|(_, kind, .., value)| match (&cell.result, kind) {
                (Ok(evaluation), _) => value(evaluation),
                (Err(_), ColumnKind::Whole) => TableValue::Whole(None),
                (Err(_), ColumnKind::Number) => TableValue::Number(None),
                (Err(_), ColumnKind::Text) => TableValue::Text(None),
            });
        let fault = TableValue::Text(cell.result.as_ref().err().map(String::as_str));
        head.into_iter().chain(results).chain([fault])
    }
}
