//! The columns of a map in files: one table of names, units and values for every format.

use super::axis::AxisValue;
use super::map::{DamageMap, MapCell};
use super::study_column::Evaluation;
use super::verdict_model::{StudyOpinion, VerdictModel};
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

/// A result of the fibre beam: name, unit, meaning, and the value.
type OpinionColumn = (
    &'static str,
    ColumnKind,
    &'static str,
    &'static str,
    fn(&StudyOpinion) -> TableValue<'static>,
);

/// What is written of what the beam says, where it was asked.
const OPINIONS: [OpinionColumn; 12] = [
    (
        "beam_action",
        ColumnKind::Text,
        "",
        "action by the fibre beam alone",
        |it| TableValue::Text(it.action.map(Action::name)),
    ),
    (
        "beam_counts",
        ColumnKind::Whole,
        "",
        "1 where the verdict of the fibre beam counts beside the two bars, otherwise 0",
        |it| TableValue::Whole(Some(u64::from(!it.opinion.counts.is_empty()))),
    ),
    (
        "beam_decides",
        ColumnKind::Whole,
        "",
        "1 where it counts and is more severe than the verdict of the two bars, otherwise 0",
        |it| TableValue::Whole(Some(u64::from(it.opinion.decides))),
    ),
    (
        "beam_outcome",
        ColumnKind::Text,
        "",
        "elastic, plastic or collapsed",
        |it| TableValue::Text(Some(outcome_word(it.opinion.outcome()))),
    ),
    (
        "beam_max_displacement_m",
        ColumnKind::Number,
        "m",
        "peak displacement of the impact point along the hit",
        |it| TableValue::Number(Some(it.opinion.beam.max_displacement_m)),
    ),
    (
        "beam_max_sideways_m",
        ColumnKind::Number,
        "m",
        "the same at right angles to the hit",
        |it| TableValue::Number(Some(it.opinion.beam.max_sideways_m)),
    ),
    (
        "beam_residual_displacement_m",
        ColumnKind::Number,
        "m",
        "residual displacement of the impact point along the hit; missing after a collapse",
        |it| finite(it.opinion.beam.residual_displacement_m),
    ),
    (
        "beam_residual_sideways_m",
        ColumnKind::Number,
        "m",
        "the same at right angles to the hit",
        |it| finite(it.opinion.beam.residual_sideways_m),
    ),
    (
        "beam_undamaged_capacity_n",
        ColumnKind::Number,
        "N",
        "largest force of the push-down of the undamaged fibre beam",
        |it| TableValue::Number(Some(it.opinion.capacity[0])),
    ),
    (
        "beam_residual_capacity_n",
        ColumnKind::Number,
        "N",
        "the same of what the impact leaves; 0 after a collapse",
        |it| TableValue::Number(Some(it.opinion.capacity[1])),
    ),
    (
        "beam_base_shear_n",
        ColumnKind::Number,
        "N",
        "largest base shear along the hit, as a mean over 1 ms",
        |it| TableValue::Number(Some(it.opinion.beam.base_shear_n)),
    ),
    (
        "ratio_to_two_bars",
        ColumnKind::Number,
        "",
        "peak displacement along the hit over the peak of the two bars; missing where these do not move",
        |it| TableValue::Number(it.opinion.ratio_to_two_bars),
    ),
];

/// A number that may not exist.
fn finite(number: f64) -> TableValue<'static> {
    TableValue::Number(number.is_finite().then_some(number))
}

/// A value of this kind that does not exist.
fn missing(kind: ColumnKind) -> TableValue<'static> {
    match kind {
        ColumnKind::Whole => TableValue::Whole(None),
        ColumnKind::Number => TableValue::Number(None),
        ColumnKind::Text => TableValue::Text(None),
    }
}

impl DamageMap {
    /// The columns of the map in a file: number of the cell, variant, the values on both axes, and the results; where the fibre beam
    /// is asked, also the model and what the beam says.
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
        if self.model() != VerdictModel::Bars {
            columns.push(column(
                "model",
                ColumnKind::Text,
                "",
                "by which model the impact is judged: beam or both",
            ));
            columns.extend(
                OPINIONS.map(|(name, kind, unit, meaning, _)| column(name, kind, unit, meaning)),
            );
            columns.push(column(
                "no_second_opinion",
                ColumnKind::Text,
                "",
                "why the fibre beam has no answer; the verdict is then by the two bars alone",
            ));
        }
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
            .map(|(_, kind, .., value)| match &cell.result {
                Ok(evaluation) => value(evaluation),
                Err(_) => missing(*kind),
            });
        let fault = TableValue::Text(cell.result.as_ref().err().map(String::as_str));
        head.into_iter()
            .chain(results)
            .chain(self.opinion_values(cell))
            .chain([fault])
    }

    /// The values of what the beam says of a cell; none where it was not asked.
    fn opinion_values<'a>(&self, cell: &'a MapCell) -> Vec<TableValue<'a>> {
        if self.model() == VerdictModel::Bars {
            return Vec::new();
        }
        let opinion = cell.second_opinion.as_ref();
        let known = opinion.and_then(|it| it.as_ref().ok());
        let reason = opinion.and_then(|it| it.as_ref().err());
        let mut values = vec![TableValue::Text(Some(self.model().name()))];
        values.extend(OPINIONS.iter().map(|(_, kind, .., value)| match known {
            Some(opinion) => value(opinion),
            None => missing(*kind),
        }));
        values.push(TableValue::Text(reason.map(String::as_str)));
        values
    }
}
