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

/// A column about this: name, kind, unit, meaning, and the value.
type ColumnOf<T> = (
    &'static str,
    ColumnKind,
    &'static str,
    &'static str,
    fn(&T) -> TableValue<'static>,
);

// Columns: name, unit, kind and value; meaning.
macro_rules! columns {
    ($($name:literal, $unit:literal, $kind:ident |$it:ident| $value:expr, $meaning:literal;)*) => {
        [$(($name, ColumnKind::$kind, $unit, $meaning, |$it| TableValue::$kind($value))),*]
    };
}

/// What is written of every impact that was computed.
const RESULTS: [ColumnOf<Evaluation>; 13] = columns! {
    "action", "", Text |it| Some(Action::name(it.action)), "required action: none, inspect, restrict, shore or evacuate";
    "action_level", "", Whole |it| Some(it.action as u64), "the action as a number, from 0 (none) to 4 (evacuate)";
    "deciding_criterion", "", Text |it| Some(it.deciding_criterion), "the criterion that decides; docs/assessment.md lists them";
    "outcome", "", Text |it| Some(outcome_word(it.outcome)), "elastic, plastic, collapsed or fractured";
    "max_v1_m", "m", Number |it| Some(it.max_v1), "peak displacement of the impact point";
    "residual_v1_m", "m", Number |it| it.residual_v1,
        "residual displacement of the impact point; missing where the column does not stand";
    "peak_contact_force_n", "N", Number |it| Some(it.peak_contact_force), "largest contact force";
    "residual_capacity_n", "N", Number |it| Some(it.residual_capacity),
        "largest force of the push-down; 0 where the column carries nothing";
    "capacity_ratio", "", Number |it| Some(it.capacity_ratio), "force of the push-down over the force of the undamaged column";
    "reserve", "", Number |it| it.reserve,
        "N_u, this ratio times the buckling resistance about the strong axis, over the applied load N; missing without a compressive load";
    "max_plastic_rotation_rad", "rad", Number |it| Some(it.max_plastic_rotation), "largest plastic rotation of a hinge";
    "max_plastic_shear_rad", "rad", Number |it| Some(it.max_plastic_shear),
        "largest plastic shear angle of a web; above 0 it has yielded in shear";
    "base_utilisation", "", Number |it| it.base_utilisation,
        "largest utilisation of the connection of the base; above 1 it fails; missing where the base is not known";
};

/// What is written of what the beam says, where it was asked.
const OPINIONS: [ColumnOf<StudyOpinion>; 12] = columns! {
    "beam_action", "", Text |it| it.action.map(Action::name), "action by the fibre beam alone";
    "beam_counts", "", Whole |it| Some(u64::from(!it.opinion.counts.is_empty())),
        "1 where the verdict of the fibre beam counts beside the two bars, otherwise 0";
    "beam_decides", "", Whole |it| Some(u64::from(it.opinion.decides)),
        "1 where it counts and is more severe than the verdict of the two bars, otherwise 0";
    "beam_outcome", "", Text |it| Some(outcome_word(it.opinion.outcome())), "elastic, plastic or collapsed";
    "beam_max_displacement_m", "m", Number |it| Some(it.opinion.beam.max_displacement_m),
        "peak displacement of the impact point along the hit";
    "beam_max_sideways_m", "m", Number |it| Some(it.opinion.beam.max_sideways_m), "the same at right angles to the hit";
    "beam_residual_displacement_m", "m", Number |it| finite(it.opinion.beam.residual_displacement_m),
        "residual displacement of the impact point along the hit; missing after a collapse";
    "beam_residual_sideways_m", "m", Number |it| finite(it.opinion.beam.residual_sideways_m),
        "the same at right angles to the hit";
    "beam_undamaged_capacity_n", "N", Number |it| Some(it.opinion.capacity[0]),
        "largest force of the push-down of the undamaged fibre beam";
    "beam_residual_capacity_n", "N", Number |it| Some(it.opinion.capacity[1]),
        "the same of what the impact leaves; 0 after a collapse";
    "beam_base_shear_n", "N", Number |it| Some(it.opinion.beam.base_shear_n),
        "largest base shear along the hit, as a mean over 1 ms";
    "ratio_to_two_bars", "", Number |it| it.opinion.ratio_to_two_bars,
        "peak displacement along the hit over the peak of the two bars; missing where these do not move";
};

/// A number that may not exist.
fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
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
