//! What a map shows, for people and as JSON: classes with their shares, critical velocities, the largest numbers.

use std::fmt::{self, Display};

use serde::Serialize;

use column_twin::assessment::Action;
use column_twin::figures::units::{Unit, significant};
use column_twin::report::short;
use column_twin::study::{
    ACTIONS, AxisValue, CellPlace, DamageMap, Evaluation, MapAxis, MapCell, RefinedMap,
    RowBoundary, VerdictModel,
};

/// Rows of which the summary shows the critical values.
const SHOWN_ROWS: u64 = 5;
/// Every class, least severe first.
const CLASSES: usize = ACTIONS.len() + 1;

/// The summary of the cells that were computed, in a memory that does not depend on their number.
pub(super) struct MapSummary<'a> {
    map: &'a DamageMap,
    /// Cells of each class.
    classes: [u64; CLASSES],
    faults: u64,
    first_fault: Option<(CellPlace, String)>,
    opinions: Opinions,
    rows: Vec<CriticalRow>,
    extremes: [Option<Extreme>; EXTREMES.len()],
}

/// What the fibre beam says of the cells, where it is asked.
#[derive(Debug, Default, Serialize)]
struct Opinions {
    /// Cells with a second opinion.
    known: u64,
    /// Cells in which its verdict counts.
    counts: u64,
    /// Cells in which it counts and is more severe than that of the two bars.
    decides: u64,
    /// Cells without one, judged by the two bars alone.
    none: u64,
    #[serde(skip)]
    first_reason: Option<(CellPlace, String)>,
}

impl Opinions {
    fn add(&mut self, cell: &MapCell) {
        match &cell.second_opinion {
            None => {}
            Some(Ok(it)) => {
                self.known += 1;
                self.counts += u64::from(!it.opinion.counts.is_empty());
                self.decides += u64::from(it.opinion.decides);
            }
            Some(Err(reason)) => {
                self.none += 1;
                self.first_reason
                    .get_or_insert_with(|| (cell.place, reason.clone()));
            }
        }
    }
}

/// The critical values in one row.
#[derive(Debug, Clone, Serialize)]
struct CriticalRow {
    variant: String,
    row: RowValue,
    #[serde(skip)]
    place: (usize, u64),
    critical: [Critical; ACTIONS.len()],
}

/// The value of a row.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
enum RowValue {
    Number(f64),
    Name(String),
}

/// Where a row reaches a class.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Critical {
    /// No cell of the row has it, as far as the row was computed.
    NotReached,
    /// Not known: a cell of the row could not be computed, and those before it do not have it.
    NotComputed,
    /// The lowest value of the row has it already.
    AtMost(f64),
    /// Between two values.
    Between(f64, f64),
}

/// A number at its largest or smallest.
#[derive(Debug, Clone, Copy, Serialize)]
struct Extreme {
    value: f64,
    #[serde(skip)]
    place: CellPlace,
}

/// A number of a response; `None` where it says nothing.
type NumberOf = fn(&Evaluation) -> Option<f64>;

/// Name, whether the smallest counts, unit, and value.
type ExtremeOf = (&'static str, bool, fn(f64) -> Unit, NumberOf);

/// The numbers whose extremes are shown.
const EXTREMES: [ExtremeOf; 4] = [
    (
        "Largest peak v1, column stands",
        false,
        Unit::length,
        |it| it.residual_v1.map(|_| it.max_v1),
    ),
    ("Largest residual v1", false, Unit::length, |it| {
        it.residual_v1
    }),
    ("Largest contact force", false, Unit::force, |it| {
        Some(it.peak_contact_force)
    }),
    ("Least push-down, column stands", true, Unit::force, |it| {
        it.residual_v1.map(|_| it.residual_capacity)
    }),
];

impl<'a> MapSummary<'a> {
    pub fn new(map: &'a DamageMap) -> Self {
        let last = map.rows().len() - 1;
        let mut shown: Vec<u64> = (0..SHOWN_ROWS)
            .map(|part| last * part / (SHOWN_ROWS - 1))
            .collect();
        shown.dedup();
        let rows = map.variants().iter().enumerate().flat_map(|(variant, it)| {
            shown.iter().map(move |&row| CriticalRow {
                variant: it.label.clone(),
                row: match map.rows().value(row) {
                    AxisValue::Number(number) => RowValue::Number(number),
                    AxisValue::Name(name) => RowValue::Name(name.to_owned()),
                },
                place: (variant, row),
                critical: [Critical::NotReached; ACTIONS.len()],
            })
        });
        Self {
            map,
            classes: [0; CLASSES],
            faults: 0,
            first_fault: None,
            opinions: Opinions::default(),
            rows: rows.collect(),
            extremes: [None; EXTREMES.len()],
        }
    }

    pub fn add(&mut self, cell: &MapCell) {
        let place = cell.place;
        let evaluation = match &cell.result {
            Ok(evaluation) => evaluation,
            Err(fault) => {
                self.faults += 1;
                self.first_fault
                    .get_or_insert_with(|| (place, fault.clone()));
                // Whether the action would have been reached here is not known.
                let rows = self.rows.iter_mut();
                for row in rows.filter(|row| row.place == (place.variant, place.row)) {
                    for critical in &mut row.critical {
                        if *critical == Critical::NotReached {
                            *critical = Critical::NotComputed;
                        }
                    }
                }
                return;
            }
        };
        self.classes[evaluation.action as usize] += 1;
        self.opinions.add(cell);
        for ((_, smallest, _, value), extreme) in EXTREMES.iter().zip(&mut self.extremes) {
            let Some(value) = value(evaluation).filter(|it| it.is_finite()) else {
                continue;
            };
            let is_new = extreme.is_none_or(|it| match smallest {
                true => value < it.value,
                false => value > it.value,
            });
            if is_new {
                *extreme = Some(Extreme { value, place });
            }
        }
        let columns = self.map.columns();
        let wanted = (place.variant, place.row);
        let Some(row) = self.rows.iter_mut().find(|row| row.place == wanted) else {
            return;
        };
        let Some(at) = columns.number(place.column) else {
            return;
        };
        for (action, critical) in ACTIONS.into_iter().zip(&mut row.critical) {
            if *critical == Critical::NotReached && evaluation.action >= action {
                let below = place
                    .column
                    .checked_sub(1)
                    .and_then(|it| columns.number(it));
                *critical =
                    below.map_or(Critical::AtMost(at), |below| Critical::Between(below, at));
            }
        }
    }

    /// Takes the critical values from boundaries that are known more exactly.
    pub fn refine(&mut self, refined: &RefinedMap) {
        for row in &mut self.rows {
            for (action, critical) in ACTIONS.into_iter().zip(&mut row.critical) {
                let boundary = refined
                    .boundaries
                    .iter()
                    .find(|it| it.variant == row.place.0 && it.action == action);
                let point =
                    boundary.and_then(|it| it.points.iter().find(|point| point.row == row.place.1));
                match point.map(|point| point.place) {
                    Some(RowBoundary::Between {
                        below,
                        at,
                        rising: true,
                    }) => {
                        *critical = Critical::Between(below, at);
                    }
                    Some(RowBoundary::Always) => {
                        let lowest = self.map.columns().number(0).unwrap_or(f64::NAN);
                        *critical = Critical::AtMost(lowest);
                    }
                    _ => {}
                }
            }
        }
    }

    /// Cells that could not be computed.
    pub fn faults(&self) -> u64 {
        self.faults
    }

    /// The first fault with its place.
    pub fn first_fault(&self) -> Option<String> {
        let (place, fault) = self.first_fault.as_ref()?;
        Some(format!("{}: {fault}", self.at(*place)))
    }

    /// Cells that were computed.
    fn computed(&self) -> u64 {
        self.classes.iter().sum()
    }

    /// A place in words.
    fn at(&self, place: CellPlace) -> String {
        let axis = |axis: &MapAxis, index| {
            let quantity = axis.quantity();
            let value = match axis.number(index) {
                Some(number) => short(number),
                None => axis.value(index).to_string(),
            };
            format!("{} {value} {}", quantity.name(), quantity.unit())
                .trim_end()
                .to_owned()
        };
        let map = self.map;
        let variant = match map.variants() {
            [_] => String::new(),
            variants => format!("{}, ", variants[place.variant].label),
        };
        format!(
            "{variant}{}, {}",
            axis(map.rows(), place.row),
            axis(map.columns(), place.column)
        )
    }

    /// The table of the rows with their critical values; empty where the axis of the columns has names.
    fn critical_velocities(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rows, columns) = (self.map.rows().quantity(), self.map.columns());
        if columns.quantity().is_named() {
            return Ok(());
        }
        let unit = with_unit(shown_unit(columns.quantity().unit()));
        writeln!(
            f,
            "\nLowest {}{unit} at which the action is at least",
            columns.quantity().name()
        )?;
        let is_comparison = self.map.variants().len() > 1;
        let head = format!("{}{}", rows.name(), with_unit(rows.unit()));
        let lead = |variant: &str, row: &str| match is_comparison {
            true => format!("  {variant:<18}{row:<22}"),
            false => format!("  {row:<24}"),
        };
        write!(f, "{}", lead("", &head))?;
        for action in ACTIONS {
            write!(f, "{:>14}", action.name())?;
        }
        writeln!(f)?;
        let highest = columns.number(columns.len() - 1).unwrap_or(f64::NAN);
        for row in &self.rows {
            let number = match &row.row {
                RowValue::Number(number) => short(*number),
                RowValue::Name(name) => name.clone(),
            };
            write!(f, "{}", lead(&row.variant, &number))?;
            for critical in &row.critical {
                let text = match critical {
                    Critical::NotReached => format!("> {}", short(highest)),
                    Critical::NotComputed => "-".to_owned(),
                    Critical::AtMost(value) => format!("<= {}", short(*value)),
                    Critical::Between(_, at) => with_km_h(*at, columns.quantity().unit()),
                };
                write!(f, "{text:>14}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }

    /// The summary as JSON.
    pub fn json(&self) -> serde_json::Result<String> {
        #[derive(Serialize)]
        struct Fields<'a> {
            computed: u64,
            faults: u64,
            classes: std::collections::BTreeMap<&'static str, u64>,
            critical: &'a [CriticalRow],
            #[serde(skip_serializing_if = "Option::is_none")]
            second_opinions: Option<&'a Opinions>,
        }
        let asks_the_beam = self.map.model() != VerdictModel::Bars;
        serde_json::to_string(&Fields {
            computed: self.computed(),
            faults: self.faults,
            classes: Action::ALL
                .into_iter()
                .map(Action::name)
                .zip(self.classes)
                .collect(),
            critical: &self.rows,
            second_opinions: asks_the_beam.then_some(&self.opinions),
        })
    }
}

/// The unit of boundaries: speeds are shown in km/h, too.
pub(super) fn shown_unit(unit: &str) -> &str {
    match unit {
        "m/s" => "m/s (km/h)",
        unit => unit,
    }
}

/// The place of a boundary with four digits; of a speed, in km/h behind it.
pub(super) fn with_km_h(at: f64, unit: &str) -> String {
    match unit {
        "m/s" => format!("{} ({:.0})", significant(at, 4), 3.6 * at),
        _ => significant(at, 4),
    }
}

fn with_unit(unit: &str) -> String {
    match unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    }
}

/// The values of an axis in words.
pub(super) fn extent(axis: &MapAxis) -> String {
    let quantity = axis.quantity();
    match axis.ends() {
        Some([from, to]) => format!(
            "{} {} to {} {}",
            quantity.name(),
            short(from),
            short(to),
            quantity.unit()
        )
        .trim_end()
        .to_owned(),
        None => {
            let names = (0..axis.len()).map(|index| axis.value(index).to_string());
            format!(
                "{} {}",
                quantity.name(),
                names.collect::<Vec<_>>().join(", ")
            )
        }
    }
}

impl Display for MapSummary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let computed = self.computed();
        if computed > 0 {
            writeln!(f, "{:<15}{:>9}   share", "Action", "impacts")?;
            for (action, count) in Action::ALL.into_iter().zip(self.classes) {
                let share = 100.0 * count as f64 / computed as f64;
                writeln!(f, "  {:<13}{count:>9}{share:>7.1} %", action.name())?;
            }
            self.critical_velocities(f)?;
            writeln!(f)?;
        }
        for ((name, _, unit, _), extreme) in EXTREMES.iter().zip(&self.extremes) {
            if let Some(Extreme { value, place }) = extreme {
                let value_text = unit(*value).show(*value);
                writeln!(f, "{name:<32}{value_text:<12}  at {}", self.at(*place))?;
            }
        }
        if self.map.model() == VerdictModel::Bars {
            return Ok(());
        }
        let Opinions {
            known,
            counts,
            decides,
            none,
            first_reason,
        } = &self.opinions;
        writeln!(
            f,
            "Fibre beam                      its verdict counts in {counts} of {known} impacts, and is the more severe one in {decides}"
        )?;
        if let Some((place, reason)) = first_reason {
            writeln!(
                f,
                "                                {none} impacts have the verdict of the two bars alone; the first one, {}: {reason}",
                self.at(*place)
            )?;
        }
        Ok(())
    }
}
