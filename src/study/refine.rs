//! The boundaries of the action classes of a map, computed only where the classes change.

use std::sync::atomic::AtomicU64;

use serde::Serialize;

use super::axis::MapAxis;
use super::batch::{Batch, BatchEnd};
use super::map::DamageMap;
use super::row_search::{Event, Expected, Limit, RefineError, Row, RowBoundary, Scale};
use crate::assessment::Action;

/// Intervals between the rows that are scanned from one end to the other.
const SCANNED_INTERVALS: u64 = 4;
/// Intervals between the rows whose boundaries are always searched; between them, only where they are not where the rows
/// beside them let expect them.
const LEAST_INTERVALS: u64 = 8;
/// Events that have a boundary: classes and limits.
const EVENTS: usize = Event::ALL.len();

/// The boundaries of the action classes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RefinedMap {
    /// One for each variant and each of [`ACTIONS`](super::ACTIONS), variant by variant.
    pub boundaries: Vec<ClassBoundary>,
    /// Where a web yields in shear and where the base fails, for each variant that has such a limit.
    pub limits: Vec<LimitBoundary>,
    /// The rows that cannot be computed, or not in whole, in the order in which they were found.
    pub faults: Vec<RowFault>,
    /// Number of responses.
    pub responses: u64,
    /// Whether the boundaries are known to 1 % everywhere; not after an interruption.
    pub complete: bool,
}

/// A row that cannot be computed in whole.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RowFault {
    /// Number of the variant.
    pub variant: usize,
    /// Place of the row on its axis, from 0.
    pub row: u64,
    /// The first of its impacts that cannot be computed, and why.
    pub reason: String,
    /// The lowest and the highest value on the axis of the columns between which the boundaries of the row were searched;
    /// `None` where it is infeasible.
    pub computed: Option<[f64; 2]>,
}

/// The boundary of one class: along it, the action changes between less than `action` and at least `action`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassBoundary {
    /// Number of the variant.
    pub variant: usize,
    /// The class.
    pub action: Action,
    /// Where it is in the rows that were computed, in their order. Between two rows it is known to 1 % by interpolation,
    /// logarithmic along an axis whose values are all above 0.
    pub points: Vec<BoundaryPoint>,
}

/// The line of one limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimitBoundary {
    /// Number of the variant.
    pub variant: usize,
    /// The limit.
    pub limit: Limit,
    /// As those of a [`ClassBoundary`].
    pub points: Vec<BoundaryPoint>,
}

/// A boundary in one row of a map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoundaryPoint {
    /// Place of the row on its axis, from 0.
    pub row: u64,
    /// Where it is.
    pub place: RowBoundary,
}

impl RefinedMap {
    /// The value on the axis of the columns at which a class begins, at any value on the axis of the rows: interpolated between the
    /// rows that were computed. `None` where a class does not begin in one of both.
    #[must_use]
    pub fn value_at(
        &self,
        map: &DamageMap,
        variant: usize,
        action: Action,
        row_value: f64,
    ) -> Option<f64> {
        let boundary = self
            .boundaries
            .iter()
            .find(|it| it.variant == variant && it.action == action)?;
        point_at(map, &boundary.points, row_value)
    }

    /// As [`value_at`](Self::value_at), of a limit.
    #[must_use]
    pub fn limit_at(
        &self,
        map: &DamageMap,
        variant: usize,
        limit: Limit,
        row_value: f64,
    ) -> Option<f64> {
        let found = self.limits.iter();
        let boundary = found
            .into_iter()
            .find(|it| it.variant == variant && it.limit == limit)?;
        point_at(map, &boundary.points, row_value)
    }

    /// Whether a class holds in the whole row that is the nearest to a value on the axis of the rows.
    #[must_use]
    pub fn always_at(
        &self,
        map: &DamageMap,
        variant: usize,
        action: Action,
        row_value: f64,
    ) -> bool {
        let boundary = self
            .boundaries
            .iter()
            .find(|it| it.variant == variant && it.action == action);
        let distance = |point: &&BoundaryPoint| {
            let number = map.rows().number(point.row).unwrap_or(point.row as f64);
            (number - row_value).abs()
        };
        let nearest = boundary.and_then(|it| {
            it.points
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        });
        nearest.is_some_and(|point| point.place == RowBoundary::Always)
    }
}

/// The value on the axis of the columns at any value on the axis of the rows, interpolated between points.
pub(super) fn point_at(map: &DamageMap, points: &[BoundaryPoint], row_value: f64) -> Option<f64> {
    let (rows, columns) = (Scale::of(map.rows())?, Scale::of(map.columns())?);
    let wanted = rows.at(row_value);
    let at = |point: &BoundaryPoint| map.rows().number(point.row).map(|it| rows.at(it));
    let after = points
        .iter()
        .position(|point| at(point).is_some_and(|at| at >= wanted - 1e-9 * rows.extent()))?;
    let second = &points[after];
    let first = &points[after.saturating_sub(1)];
    let (from, to) = (at(first)?, at(second)?);
    if (to - wanted).abs() <= 1e-9 * rows.extent() {
        return second.place.value();
    }
    if after == 0 {
        return None;
    }
    let part = (wanted - from) / (to - from);
    let [one, other] = [
        columns.at(first.place.value()?),
        columns.at(second.place.value()?),
    ];
    Some(columns.value(one + part * (other - one)))
}

/// The rows of one variant that are known, per event.
type Known = [Vec<(u64, RowBoundary)>; EVENTS];

/// What one job has found: for each class the boundary, and whether it is where it was expected.
type Found = [Option<(RowBoundary, bool)>; EVENTS];

/// A row that was searched.
struct Searched {
    found: Found,
    /// Where only a part of the row can be computed: why not the rest, and the values between which it was searched.
    rest: Option<(RefineError, [f64; 2])>,
}

/// A row to compute.
struct Job {
    variant: usize,
    row: u64,
    /// What is expected of each event; `None`: nothing to find.
    expected: [Option<Expected>; EVENTS],
    /// Whether the whole row is scanned, and for which events.
    scan: Option<[bool; EVENTS]>,
}

/// The boundaries of one variant while they are being traced.
struct Trace {
    known: Known,
    /// Intervals of rows in which a boundary is not certain yet, per class.
    open: [Vec<(u64, u64)>; EVENTS],
}

impl DamageMap {
    /// The boundaries of the action classes, to 1 % along the axis of the columns, with a small part of the responses of the map.
    ///
    /// Five rows are scanned from their lowest value, in ratios of at most 1.2 along an axis whose values are above 0, until
    /// every class has changed; the first change counts, as for
    /// [`CriticalSearch`](super::CriticalSearch). Action need not grow along a row, and a class may come in bands; below the boundary that was
    /// found, a lower band is looked for in eight steps of 2 %. In the rows between them, each boundary is searched around the place that
    /// interpolation lets expect. Halves of an interval between two rows are computed in turn, down to the rows of the map, until the
    /// boundary of the middle row is within 1 % of the expected one. Islands of another class that no scan meets are not found.
    /// Rows that have names are scanned one by one.
    ///
    /// An interrupted batch leaves the boundaries that are known, and `complete` is false.
    ///
    /// # Errors
    /// An axis of columns that is not a range. Rows with impacts that cannot be computed are in [`RefinedMap::faults`]: their
    /// boundaries are those of the part that can.
    ///
    /// ```
    /// use column_twin::assessment::Action;
    /// use column_twin::parameters::Parameters;
    /// use column_twin::study::{Batch, DamageMap, MapAxis};
    ///
    /// let axes = [MapAxis::parse("mass=1000:2000:3")?, MapAxis::parse("velocity=1:20:100")?];
    /// let map = DamageMap::new(&Parameters::default(), None, axes)?;
    /// let refined = map.refine(&Batch::default())?;
    /// assert!(refined.complete && refined.responses < map.len());
    /// let evacuate = refined.boundaries.last().expect("one for each action");
    /// assert_eq!(evacuate.action, Action::Evacuate);
    /// let place = evacuate.points[1].place.value().expect("a boundary");
    /// assert!((1.0..20.0).contains(&place));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn refine(&self, batch: &Batch) -> Result<RefinedMap, RefineError> {
        let scale = Scale::of(self.columns())
            .ok_or_else(|| RefineError::NotARange(self.columns().quantity().name()))?;
        let rows = RowScale {
            axis: self.rows(),
            scale: Scale::of(self.rows()),
        };
        let responses = AtomicU64::new(0);
        let mut traces: Vec<Trace> = self.variants().iter().map(|_| Trace::new()).collect();
        let last = self.rows().len() - 1;
        let scanned = match rows.scale {
            None => (0..=last).collect(),
            Some(_) => part_rows(last, SCANNED_INTERVALS),
        };
        let sought: Vec<[bool; EVENTS]> = (0..traces.len()).map(|it| self.sought(it)).collect();
        let mut jobs: Vec<Job> = (0..traces.len())
            .flat_map(|variant| {
                let sought = sought[variant];
                let rows = scanned.iter();
                rows.map(move |row| Job::scan(variant, *row, sought))
            })
            .collect();
        let mut complete = true;
        let mut faults = Vec::new();
        let always_halved = last.div_ceil(LEAST_INTERVALS);
        while !jobs.is_empty() && complete {
            let mut found: Vec<Result<Searched, RefineError>> = Vec::with_capacity(jobs.len());
            let compute = |index: u64| {
                let job = &jobs[index as usize];
                job.run(&mut Row::new(self, &responses, scale, job.variant, job.row))
            };
            let end = batch.run(jobs.len() as u64, compute, |part| {
                found.extend(part);
                Ok::<(), RefineError>(())
            })?;
            complete = end == BatchEnd::Complete;
            for (job, found) in jobs.iter().zip(found) {
                let (found, fault) = match found {
                    Err(fault @ RefineError::Impact { .. }) => {
                        (job.infeasible(), Some((fault, None)))
                    }
                    searched => {
                        let Searched { found, rest } = searched?;
                        (found, rest.map(|(fault, ends)| (fault, Some(ends))))
                    }
                };
                let (variant, row) = (job.variant, job.row);
                let is_new = |it: &RowFault| (it.variant, it.row) != (variant, row);
                if let Some((fault, computed)) = fault
                    && faults.iter().all(is_new)
                {
                    faults.push(RowFault {
                        variant,
                        row,
                        reason: fault.to_string(),
                        computed,
                    });
                }
                traces[variant].take(job, found, always_halved);
            }
            if rows.scale.is_none() {
                break;
            }
            if jobs.iter().any(|job| job.scan.is_some()) {
                traces.iter_mut().for_each(Trace::open_all);
            }
            jobs = (traces.iter_mut().enumerate())
                .flat_map(|(variant, trace)| trace.jobs(variant, &rows, &scale))
                .collect();
        }
        let (mut boundaries, mut limits) = (Vec::new(), Vec::new());
        for (variant, trace) in traces.into_iter().enumerate() {
            for (index, (event, known)) in Event::ALL.into_iter().zip(trace.known).enumerate() {
                let point = |(row, place)| BoundaryPoint { row, place };
                let points: Vec<_> = known.into_iter().map(point).collect();
                match event {
                    Event::Class(action) => boundaries.push(ClassBoundary {
                        variant,
                        action,
                        points,
                    }),
                    Event::Limit(limit) if sought[variant][index] => limits.push(LimitBoundary {
                        variant,
                        limit,
                        points,
                    }),
                    Event::Limit(_) => {}
                }
            }
        }
        Ok(RefinedMap {
            boundaries,
            limits,
            faults,
            responses: responses.into_inner(),
            complete,
        })
    }

    /// Which events a variant can have.
    fn sought(&self, variant: usize) -> [bool; EVENTS] {
        let [web, base] = self.limits(variant);
        Event::ALL.map(|event| match event {
            Event::Class(_) => true,
            Event::Limit(Limit::WebYields) => web,
            Event::Limit(Limit::BaseFails) => base,
        })
    }
}

/// Rows at equal distances, with both ends.
fn part_rows(last: u64, intervals: u64) -> Vec<u64> {
    let mut rows: Vec<u64> = (0..=intervals)
        .map(|part| last * part / intervals)
        .collect();
    rows.dedup();
    rows
}

/// The axis of the rows.
struct RowScale<'a> {
    axis: &'a MapAxis,
    /// `None` if the rows have names.
    scale: Option<Scale>,
}

impl RowScale<'_> {
    /// The part of the way from one row to another at which a row between them is.
    fn part(&self, row: u64, between: (u64, u64)) -> f64 {
        let at = |row: u64| {
            let number = self.axis.number(row).unwrap_or(row as f64);
            self.scale.map_or(number, |scale| scale.at(number))
        };
        let (first, second) = (at(between.0), at(between.1));
        (at(row) - first) / (second - first)
    }
}

impl Job {
    fn scan(variant: usize, row: u64, sought: [bool; EVENTS]) -> Self {
        Self {
            variant,
            row,
            expected: [None; EVENTS],
            scan: Some(sought),
        }
    }

    /// Whether an event is looked for in a scan.
    fn scans(&self, event: usize) -> bool {
        self.scan.is_some_and(|sought| sought[event])
    }

    /// What a row is that cannot be computed.
    fn infeasible(&self) -> Found {
        std::array::from_fn(|event| {
            let is_sought = self.expected[event].is_some() || self.scans(event);
            is_sought.then_some((RowBoundary::Infeasible, false))
        })
    }

    fn run(&self, row: &mut Row<'_>) -> Result<Searched, RefineError> {
        let rest = row.restrict()?.map(|fault| (fault, row.computed()));
        let mut found = [None; EVENTS];
        if self.scan.is_some() {
            row.scan()?;
        }
        for (index, event) in Event::ALL.into_iter().enumerate() {
            found[index] = match self.expected[index] {
                Some(expected) => match row.expected(event, expected)? {
                    (found, true) => Some((found, true)),
                    (found, false) => Some((row.lowest_band(event, found)?, false)),
                },
                None if self.scans(index) => {
                    let found = row.scanned(event)?;
                    Some((row.lowest_band(event, found)?, false))
                }
                None => None,
            };
        }
        Ok(Searched { found, rest })
    }
}

impl Trace {
    fn new() -> Self {
        Self {
            known: Default::default(),
            open: Default::default(),
        }
    }

    /// Enters the boundaries of a row. The intervals beside it are open, unless the boundary was where it was expected, and the
    /// interval that this row has halved was not wider than `always_halved`.
    fn take(&mut self, job: &Job, found: Found, always_halved: u64) {
        for (class, found) in found.into_iter().enumerate() {
            let Some((boundary, is_expected)) = found else {
                continue;
            };
            let known = &mut self.known[class];
            let place = known.partition_point(|(row, _)| *row < job.row);
            known.insert(place, (job.row, boundary));
            if job.scan.is_some() {
                continue;
            }
            let (before, after) = (known[place - 1].0, known[place + 1].0);
            if !is_expected || after - before > always_halved {
                self.open[class].extend([(before, job.row), (job.row, after)]);
            }
        }
    }

    /// Opens every interval between the rows that are known.
    fn open_all(&mut self) {
        for (open, known) in self.open.iter_mut().zip(&self.known) {
            *open = known
                .windows(2)
                .map(|pair| (pair[0].0, pair[1].0))
                .collect();
        }
    }

    /// The middle rows of the open intervals, which are then no longer open; of intervals without a row between them there is none.
    fn jobs(&mut self, variant: usize, rows: &RowScale<'_>, scale: &Scale) -> Vec<Job> {
        let mut jobs: Vec<Job> = Vec::new();
        for (class, open) in std::mem::take(&mut self.open).into_iter().enumerate() {
            for (before, after) in open {
                let row = before + (after - before) / 2;
                if row == before {
                    continue;
                }
                let boundary = |row: u64| {
                    let known = &self.known[class];
                    known
                        .iter()
                        .find(|(of, _)| *of == row)
                        .map(|(_, boundary)| *boundary)
                };
                let (Some(first), Some(second)) = (boundary(before), boundary(after)) else {
                    continue;
                };
                if [first, second] == [RowBoundary::Infeasible; 2] {
                    continue;
                }
                let part = rows.part(row, (before, after));
                let job = match jobs.iter().position(|job| job.row == row) {
                    Some(index) => index,
                    None => {
                        jobs.push(Job {
                            variant,
                            row,
                            expected: [None; EVENTS],
                            scan: None,
                        });
                        jobs.len() - 1
                    }
                };
                jobs[job].expected[class] = Some(expectation(first, second, part, scale));
            }
        }
        jobs
    }
}

/// What two rows let expect of a row at this part of the way between them.
fn expectation(first: RowBoundary, second: RowBoundary, part: f64, scale: &Scale) -> Expected {
    let place = |boundary: RowBoundary| match boundary {
        RowBoundary::Between { below, at, rising } => {
            Some((0.5 * (scale.at(below) + scale.at(at)), rising))
        }
        RowBoundary::Always | RowBoundary::Never | RowBoundary::Infeasible => None,
    };
    // Beside a row that cannot be computed, the other one says what to expect.
    let (first, second) = match (first, second) {
        (RowBoundary::Infeasible, known) | (known, RowBoundary::Infeasible) => (known, known),
        both => both,
    };
    match (place(first), place(second)) {
        (Some((one, rising)), Some((other, also))) if rising == also => Expected::At {
            centre: one + part * (other - one),
            rising,
        },
        (Some((centre, rising)), _) | (None, Some((centre, rising))) => {
            Expected::Near { centre, rising }
        }
        (None, None) if first == second => Expected::Unchanged(first == RowBoundary::Always),
        (None, None) => Expected::Near {
            centre: 0.5 * (scale.ends[0] + scale.ends[1]),
            rising: true,
        },
    }
}
