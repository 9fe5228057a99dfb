//! The search for the boundaries of the classes in one row of a map.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;

use super::axis::{AxisValue, MapAxis};
use super::critical::{ACTIONS, CRITICAL_TOLERANCE};
use super::map::DamageMap;
use super::study_column::Glance;
use crate::assessment::Action;

/// Intervals of the scan of a row whose axis is not logarithmic.
const LINEAR_INTERVALS: u32 = 12;
/// Largest ratio of two values that follow each other in the scan of a logarithmic row.
const SCAN_RATIO: f64 = 1.2;
/// Places below a boundary, each 2 % or two hundredths of the axis from the next, at which a class that has bands is looked for
/// once more.
const BAND_PROBES: u32 = 8;
/// Part of the width of a narrow bracket to which the end of the part of a row that can be computed is known.
const EDGE_SHARE: f64 = 0.01;

/// Where the class changes along a row, seen from its lowest value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum RowBoundary {
    /// Between two values of the axis of the columns that differ by at most 1 %; 1 % of the range where the axis contains 0.
    Between {
        /// The lower value.
        below: f64,
        /// The upper value.
        at: f64,
        /// Whether the action is reached at the upper value, and not at the lower one.
        rising: bool,
    },
    /// The action is reached in the whole row, or in the part of it that can be computed, as far as it was looked at.
    Always,
    /// The action is not reached in the row, as far as it was looked at.
    Never,
    /// No impact of the row can be computed, such as those of a column that cannot bear its load, or one between others
    /// that can.
    Infeasible,
}

impl RowBoundary {
    /// The place on the axis that both values enclose; `None` where the class does not change.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Between { below, at, .. } => Some(0.5 * (below + at)),
            Self::Always | Self::Never | Self::Infeasible => None,
        }
    }
}

/// Why there are no boundaries.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RefineError {
    /// The axis of the columns has names or only some numbers.
    #[error(
        "no boundary can be searched along {0}, whose values are listed; give it as from:to:number of points"
    )]
    NotARange(&'static str),
    /// An impact that could not be computed.
    #[error("{label}, {row}, {column}: {fault}")]
    Impact {
        /// The variant.
        label: String,
        /// The row with its value.
        row: String,
        /// The column with its value.
        column: String,
        /// Why not.
        fault: String,
    },
    /// The system gives no threads.
    #[error("cannot start the threads: {0}")]
    Threads(String),
}

impl From<rayon::ThreadPoolBuildError> for RefineError {
    fn from(error: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(error.to_string())
    }
}

/// Something other than a class of action that has a boundary in a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The web of a bar yields in shear.
    WebYields,
    /// The connection of the base fails: its utilisation exceeds 1.
    BaseFails,
}

impl Limit {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::WebYields, Self::BaseFails];

    /// Its name in files: `web_yields` or `base_fails`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WebYields => "web_yields",
            Self::BaseFails => "base_fails",
        }
    }

    /// Its name for people.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::WebYields => "web yields in shear",
            Self::BaseFails => "base connection fails",
        }
    }
}

/// What has a boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Event {
    /// The action is at least that of a class.
    Class(Action),
    Limit(Limit),
}

impl Event {
    /// Every one: the classes, then the limits.
    pub const ALL: [Self; ACTIONS.len() + Limit::ALL.len()] = [
        Self::Class(ACTIONS[0]),
        Self::Class(ACTIONS[1]),
        Self::Class(ACTIONS[2]),
        Self::Class(ACTIONS[3]),
        Self::Limit(Limit::ALL[0]),
        Self::Limit(Limit::ALL[1]),
    ];

    /// Whether an impact leads to it.
    pub fn holds(self, glance: Glance) -> bool {
        match self {
            Self::Class(action) => glance.action >= action,
            Self::Limit(Limit::WebYields) => glance.web_yields,
            Self::Limit(Limit::BaseFails) => glance.base_fails,
        }
    }
}

/// An axis as the search sees it: logarithmic, if all values are above 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    logarithmic: bool,
    /// Its ends, on the scale.
    pub(super) ends: [f64; 2],
}

impl Scale {
    pub(super) fn of(axis: &MapAxis) -> Option<Self> {
        let [from, to] = axis.ends()?;
        let logarithmic = from > 0.0;
        let at = |value: f64| if logarithmic { libm::log(value) } else { value };
        Some(Self {
            logarithmic,
            ends: [at(from), at(to)],
        })
    }

    /// The place of a value.
    pub(super) fn at(&self, value: f64) -> f64 {
        if self.logarithmic {
            libm::log(value)
        } else {
            value
        }
    }

    /// The value at a place.
    pub(super) fn value(&self, at: f64) -> f64 {
        if self.logarithmic { libm::exp(at) } else { at }
    }

    pub(super) fn extent(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// Width of a bracket that is narrow enough.
    fn tolerance(&self) -> f64 {
        match self.logarithmic {
            true => libm::log1p(CRITICAL_TOLERANCE),
            false => CRITICAL_TOLERANCE * self.extent(),
        }
    }

    fn scan_intervals(&self) -> u32 {
        match self.logarithmic {
            true => (libm::ceil(self.extent() / libm::log(SCAN_RATIO)) as u32).clamp(1, 64),
            false => LINEAR_INTERVALS,
        }
    }
}

/// The impacts that are known in a row, by their place on the scale, ascending.
pub(super) struct Row<'a> {
    pub(super) map: &'a DamageMap,
    /// Responses of all rows.
    pub(super) responses: &'a AtomicU64,
    /// The axis of the columns.
    scale: Scale,
    /// The part of the row that can be computed, on the scale.
    ends: [f64; 2],
    variant: usize,
    row: u64,
    known: Vec<(f64, Glance)>,
}

/// What a map is asked about one of its impacts: its variant, the numbers of its row and column if it is a cell, and its values.
type Question<T> = fn(&DamageMap, usize, [Option<u64>; 2], [AxisValue<'_>; 2]) -> Result<T, String>;

impl<'a> Row<'a> {
    /// A row of which nothing is known.
    pub(super) fn new(
        map: &'a DamageMap,
        responses: &'a AtomicU64,
        scale: Scale,
        variant: usize,
        row: u64,
    ) -> Self {
        Self {
            map,
            responses,
            scale,
            ends: scale.ends,
            variant,
            row,
            known: Vec::new(),
        }
    }

    /// What the impact at a place leads to, computed unless it is known.
    fn glance(&mut self, at: f64) -> Result<Glance, RefineError> {
        let at = at.clamp(self.ends[0], self.ends[1]);
        let place = self.known.partition_point(|(known, _)| *known < at);
        if let Some((_, glance)) = self.known.get(place).filter(|(known, _)| *known == at) {
            return Ok(*glance);
        }
        let glance = self.at(at, DamageMap::glance)?;
        self.responses.fetch_add(1, Ordering::Relaxed);
        self.known.insert(place, (at, glance));
        Ok(glance)
    }

    /// Asks the map about the impact at a place.
    fn at<T>(&self, at: f64, ask: Question<T>) -> Result<T, RefineError> {
        let (rows, columns) = (self.map.rows(), self.map.columns());
        let values = [rows.value(self.row), AxisValue::Number(self.value(at))];
        ask(self.map, self.variant, [Some(self.row), None], values).map_err(|fault| {
            RefineError::Impact {
                label: self.map.variants()[self.variant].label.clone(),
                row: format!("{} {}", rows.quantity().name(), values[0]),
                column: format!("{} {}", columns.quantity().name(), values[1]),
                fault,
            }
        })
    }

    /// Restricts the row to the part that can be computed, which is taken to be in one piece: no column bears more than its
    /// section does, for example. Returns why the rest cannot be computed, if there is a rest.
    ///
    /// # Errors
    /// No place of a scan can be computed.
    pub(super) fn restrict(&mut self) -> Result<Option<RefineError>, RefineError> {
        let admits = |row: &Self, at: f64| row.at(at, DamageMap::admits);
        let [low, high] = self.scale.ends;
        let fault = match (admits(self, low), admits(self, high)) {
            (Ok(()), Ok(())) => return Ok(None),
            (Err(fault), _) | (Ok(()), Err(fault)) => fault,
        };
        let places: Vec<f64> = self.scan_places().collect();
        let is_admitted: Vec<bool> = places.iter().map(|at| admits(self, *at).is_ok()).collect();
        let first = is_admitted.iter().position(|it| *it);
        let last = is_admitted.iter().rposition(|it| *it);
        let (Some(first), Some(last)) = (first, last) else {
            return Err(fault);
        };
        let edge = |row: &Self, mut outside: f64, mut inside: f64| {
            while (inside - outside).abs() > EDGE_SHARE * row.scale.tolerance() {
                let middle = 0.5 * (outside + inside);
                match admits(row, middle) {
                    Ok(()) => inside = middle,
                    Err(_) => outside = middle,
                }
            }
            inside
        };
        self.ends = [
            match first {
                0 => low,
                _ => edge(self, places[first - 1], places[first]),
            },
            match places.get(last + 1) {
                None => high,
                Some(beyond) => edge(self, *beyond, places[last]),
            },
        ];
        Ok(Some(fault))
    }

    /// The lowest and the highest value that can be computed.
    pub(super) fn computed(&self) -> [f64; 2] {
        self.ends.map(|end| self.value(end))
    }

    /// The places of a scan.
    fn scan_places(&self) -> impl Iterator<Item = f64> + use<> {
        let [low, high] = self.ends;
        let intervals = self.scale.scan_intervals();
        (0..=intervals).map(move |number| match number {
            number if number == intervals => high,
            number => low + f64::from(number) / f64::from(intervals) * (high - low),
        })
    }

    /// Whether the event occurs at a place.
    fn holds(&mut self, event: Event, at: f64) -> Result<bool, RefineError> {
        Ok(event.holds(self.glance(at)?))
    }

    /// Goes through the whole row until every class has changed.
    pub(super) fn scan(&mut self) -> Result<(), RefineError> {
        for place in self.scan_places() {
            self.glance(place)?;
            let has_changed = |action| self.first_change(Event::Class(action)).is_some();
            if ACTIONS.into_iter().all(has_changed) {
                break;
            }
        }
        Ok(())
    }

    /// The known places around the first change of an event.
    fn first_change(&self, event: Event) -> Option<[f64; 2]> {
        let holds = |place: &(f64, Glance)| event.holds(place.1);
        let first = holds(self.known.first()?);
        let at = self.known.iter().position(|place| holds(place) != first)?;
        Some([self.known[at - 1].0, self.known[at].0])
    }

    /// Halves a bracket until it is narrow enough.
    fn narrowed(
        &mut self,
        event: Event,
        [mut below, mut at]: [f64; 2],
    ) -> Result<RowBoundary, RefineError> {
        let first = self.holds(event, below)?;
        // Places that are known already narrow it first.
        for (known, found) in &self.known {
            if *known > below && *known < at {
                if event.holds(*found) == first {
                    below = *known;
                } else {
                    at = *known;
                    break;
                }
            }
        }
        while at - below > self.scale.tolerance() {
            let middle = 0.5 * (below + at);
            if self.holds(event, middle)? == first {
                below = middle;
            } else {
                at = middle;
            }
        }
        Ok(RowBoundary::Between {
            below: self.value(below),
            at: self.value(at),
            rising: !first,
        })
    }

    /// The place of a value on the axis of the columns.
    pub(super) fn place(&self, value: f64) -> f64 {
        self.scale.at(value)
    }

    /// The value at a place; the ends are those of the axis to the last bit.
    pub(super) fn value(&self, at: f64) -> f64 {
        let ends = self.map.columns().ends().unwrap_or_default();
        match at {
            at if at == self.scale.ends[0] => ends[0],
            at if at == self.scale.ends[1] => ends[1],
            at => self.scale.value(at),
        }
    }

    /// The lowest band of an event below a boundary that was found, or else this boundary.
    pub(super) fn lowest_band(
        &mut self,
        event: Event,
        mut found: RowBoundary,
    ) -> Result<RowBoundary, RefineError> {
        let step = 2.0 * self.scale.tolerance();
        while let RowBoundary::Between {
            below,
            rising: true,
            ..
        } = found
        {
            let mut below = self.scale.at(below);
            let mut lower = None;
            for _ in 0..BAND_PROBES {
                let at = below - step;
                if at <= self.ends[0] {
                    break;
                }
                if self.holds(event, at)? {
                    lower = Some(at);
                    break;
                }
                below = at;
            }
            let Some(at) = lower else {
                break;
            };
            // The places that were probed above it do not have the class; a place below it has not, either, sooner or later.
            let (mut below, mut upper) = (at - step, at);
            while below > self.ends[0] && self.holds(event, below)? {
                (below, upper) = (below - step, below);
            }
            let below = below.max(self.ends[0]);
            if self.holds(event, below)? {
                return Ok(RowBoundary::Always);
            }
            found = self.narrowed(event, [below, upper])?;
        }
        Ok(found)
    }

    /// The boundary of an event in a row that was scanned.
    pub(super) fn scanned(&mut self, event: Event) -> Result<RowBoundary, RefineError> {
        // The scan has ended with the classes; a limit may lie beyond.
        if matches!(event, Event::Limit(_)) && self.first_change(event).is_none() {
            self.glance(self.ends[1])?;
        }
        match self.first_change(event) {
            Some(bracket) => self.narrowed(event, bracket),
            None => self.unchanged(event, self.ends[0]),
        }
    }

    fn unchanged(&mut self, event: Event, at: f64) -> Result<RowBoundary, RefineError> {
        Ok(match self.holds(event, at)? {
            true => RowBoundary::Always,
            false => RowBoundary::Never,
        })
    }

    /// The boundary of an event where the rows beside this one let expect it; also whether it is there.
    pub(super) fn expected(
        &mut self,
        event: Event,
        expected: Expected,
    ) -> Result<(RowBoundary, bool), RefineError> {
        let [low, high] = self.ends;
        let (centre, rising, is_certain) = match expected {
            // Where neither row beside has a boundary, the end at which it would come in is enough.
            Expected::Unchanged(holds) => {
                let end = if holds { low } else { high };
                let found = self.unchanged(event, end)?;
                if (found == RowBoundary::Always) == holds {
                    return Ok((found, true));
                }
                (end, true, false)
            }
            Expected::Near { centre, rising } => (centre, rising, false),
            Expected::At { centre, rising } => (centre, rising, true),
        };
        let holds_below = |glance: Glance| event.holds(glance) != rising;
        let half = 0.499 * self.scale.tolerance();
        let (mut below, mut at) = ((centre - half).max(low), (centre + half).min(high));
        let mut step = 4.0 * half;
        let is_left = holds_below(self.glance(below)?);
        let is_right = !holds_below(self.glance(at)?);
        if is_left && is_right {
            let boundary = self.narrowed(event, [below, at])?;
            return Ok((boundary, is_certain));
        }
        // The bracket grows towards the side where the boundary must be.
        if is_left {
            while holds_below(self.glance(at)?) {
                if at >= high {
                    return Ok((self.unchanged(event, high)?, false));
                }
                below = at;
                at = (at + step).min(high);
                step *= 3.0;
            }
        } else {
            while !holds_below(self.glance(below)?) {
                if below <= low {
                    return Ok((self.unchanged(event, low)?, false));
                }
                at = below;
                below = (below - step).max(low);
                step *= 3.0;
            }
        }
        Ok((self.narrowed(event, [below, at])?, false))
    }
}

/// What the rows on both sides let expect of the row between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Expected {
    /// A boundary at this place, by interpolation.
    At { centre: f64, rising: bool },
    /// A boundary that only one of them has.
    Near { centre: f64, rising: bool },
    /// No boundary: the class holds in the whole row, or nowhere.
    Unchanged(bool),
}
