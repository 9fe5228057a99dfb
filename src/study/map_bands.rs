//! The bands of the boundaries between actions: between which values each of them lies if what is not known exactly of the impact
//! and of the column differs.
//!
//! As in the range of a verdict ([`ActionRange`](crate::assessment::ActionRange)), each assumption is changed alone to the ends of
//! its range. Only the boundaries are searched anew, each around its place on the map, in some of its rows.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use serde::Serialize;

use super::axis::{MapAxis, MapQuantity};
use super::batch::{Batch, BatchEnd};
use super::critical::ACTIONS;
use super::map::DamageMap;
use super::map_variants::Variant;
use super::refine::{BoundaryPoint, RefinedMap};
use super::row_search::{Event, Expected, RefineError, Row, RowBoundary, Scale};
use super::study_column::Assumed;
use crate::assessment::{Action, Assumption, ConnectedBase, HARDENING_BAND, OVERSTRENGTH};
use crate::parameters::{Parameters, Value};

/// Most rows of a map in which the bands are computed; between them they are interpolated. Rows with names are all computed.
const BAND_ROWS: usize = 9;

/// The bands of the boundaries of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapBands {
    /// One for each variant and each of [`ACTIONS`], variant by variant.
    pub bands: Vec<BoundaryBand>,
    /// What was changed.
    pub varied: Vec<Assumption>,
    /// What could not be changed, with the reason; what an axis of the map varies is not changed, either.
    pub not_varied: Vec<(Assumption, String)>,
    /// Number of responses.
    pub responses: u64,
    /// Whether all of them were computed; not after an interruption.
    pub complete: bool,
}

/// The band of the boundary of one class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundaryBand {
    /// Number of the variant.
    pub variant: usize,
    /// The class.
    pub action: Action,
    /// In the rows that were computed, in their order.
    pub points: Vec<BandPoint>,
}

/// Between which values on the axis of the columns a boundary lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BandPoint {
    /// Place of the row on its axis, from 0.
    pub row: u64,
    /// The lowest value; the end of the axis where the class may hold in the whole row.
    pub low: f64,
    /// The highest value; the end of the axis where the class may not be reached.
    pub high: f64,
    /// What alone leads to the lowest value; `None` where nothing leads below the boundary.
    pub low_by: Option<Assumption>,
    /// What alone leads to the highest value; `None` where nothing leads above the boundary.
    pub high_by: Option<Assumption>,
}

/// An assumption that is changed to one end of its range.
struct Changed {
    assumption: Assumption,
    changes: Vec<(&'static str, Value)>,
    assumed: Assumed,
}

/// One row of the map with one assumption changed.
struct Job {
    /// Variant of the changed map.
    changed: usize,
    row: u64,
    /// Where the boundaries of the classes are on the map.
    known: [Option<RowBoundary>; ACTIONS.len()],
}

/// Where the boundaries of the classes are, or why they cannot be computed.
type Found = Result<[Option<RowBoundary>; ACTIONS.len()], RefineError>;

impl MapBands {
    /// The band of a class at any value on the axis of the rows: interpolated between the rows that were computed.
    #[must_use]
    pub fn at(
        &self,
        map: &DamageMap,
        variant: usize,
        action: Action,
        row_value: f64,
    ) -> Option<[f64; 2]> {
        let mut bands = self.bands.iter();
        let band = bands.find(|it| it.variant == variant && it.action == action)?;
        let ends = |pick: fn(&BandPoint) -> f64| {
            let points = band.points.iter().map(|point| {
                let value = pick(point);
                BoundaryPoint {
                    row: point.row,
                    place: RowBoundary::Between {
                        below: value,
                        at: value,
                        rising: true,
                    },
                }
            });
            super::refine::point_at(map, &points.collect::<Vec<_>>(), row_value)
        };
        Some([ends(|it| it.low)?, ends(|it| it.high)?])
    }

    /// The band of a class in one row, where it was computed.
    #[must_use]
    pub fn in_row(&self, variant: usize, action: Action, row: u64) -> Option<&BandPoint> {
        let mut bands = self.bands.iter();
        let band = bands.find(|it| it.variant == variant && it.action == action)?;
        band.points.iter().find(|it| it.row == row)
    }
}

impl DamageMap {
    /// The bands of the boundaries that [`refine`](Self::refine) has found, in at most nine rows, to 1 %: for each assumption of the
    /// range of a verdict and each end of its range, every boundary is searched around its place. What an axis varies is not
    /// changed, because the map shows it, and nothing of a column that was damaged before.
    ///
    /// That takes about 5 responses for each boundary, each row and each of at most 14 changes.
    ///
    /// # Errors
    /// An axis of columns that is not a range. A row that cannot be computed with an assumption changed is in
    /// [`MapBands::not_varied`].
    pub fn bands(&self, refined: &RefinedMap, batch: &Batch) -> Result<MapBands, RefineError> {
        let scale = Scale::of(self.columns())
            .ok_or_else(|| RefineError::NotARange(self.columns().quantity().name()))?;
        let (mut varied, mut not_varied) = (Vec::new(), Vec::new());
        let (mut variants, mut all_assumed) = (Vec::new(), Vec::new());
        // The variant of this map and the assumption of each variant of the changed one.
        let mut origins = Vec::new();
        // The damage of a column belongs to the column as it is.
        let changeable = self.variants().iter().filter(|_| !self.is_of_damaged());
        for (variant, it) in changeable.enumerate() {
            for changed in changes(&it.parameters, [self.rows(), self.columns()]) {
                let Changed {
                    assumption,
                    changes,
                    assumed,
                } = changed;
                match it.parameters.with_changes(changes) {
                    Ok(parameters) => {
                        let label = format!("{} {}", variants.len(), assumption.name());
                        variants.push(Variant { label, parameters });
                        all_assumed.push(assumed);
                        origins.push((variant, assumption));
                        if !varied.contains(&assumption) {
                            varied.push(assumption);
                        }
                    }
                    Err(faults) => not_varied.push((assumption, faults.in_one_line())),
                }
            }
        }
        let mut bands = self.boundaries_as_bands(refined);
        if variants.is_empty() {
            return Ok(MapBands {
                bands,
                varied,
                not_varied,
                responses: 0,
                complete: true,
            });
        }
        let changed = self.with_variants(variants, all_assumed);
        let jobs: Vec<Job> = (origins.iter().enumerate())
            .flat_map(|(changed, (variant, _))| {
                let rows = bands[variant * ACTIONS.len()].points.iter();
                let of_variant = refined
                    .boundaries
                    .iter()
                    .filter(|it| it.variant == *variant);
                let of_variant: Vec<_> = of_variant.collect();
                rows.map(move |point| Job {
                    changed,
                    row: point.row,
                    known: std::array::from_fn(|class| {
                        let mut points = of_variant.get(class)?.points.iter();
                        points.find(|it| it.row == point.row).map(|it| it.place)
                    }),
                })
                .collect::<Vec<_>>()
            })
            .collect();
        let responses = AtomicU64::new(0);
        let mut all: Vec<Found> = Vec::with_capacity(jobs.len());
        let compute = |index: u64| {
            let job = &jobs[index as usize];
            job.run(&mut Row::new(
                &changed,
                &responses,
                scale,
                job.changed,
                job.row,
            ))
        };
        let end = batch.run(jobs.len() as u64, compute, |part| {
            all.extend(part);
            Ok::<(), RefineError>(())
        })?;
        let ends = self.columns().ends().unwrap_or_default();
        for (job, found) in jobs.iter().zip(all) {
            let (variant, assumption) = origins[job.changed];
            let found = match found {
                Ok(found) => found,
                Err(fault) => {
                    if not_varied.iter().all(|(it, _)| *it != assumption) {
                        not_varied.push((assumption, fault.to_string()));
                    }
                    continue;
                }
            };
            for (class, place) in found.into_iter().enumerate() {
                let value = match place {
                    None | Some(RowBoundary::Infeasible) => continue,
                    Some(RowBoundary::Always) => ends[0],
                    Some(RowBoundary::Never) => ends[1],
                    Some(RowBoundary::Between { below, at, .. }) => 0.5 * (below + at),
                };
                let points = &mut bands[variant * ACTIONS.len() + class].points;
                if let Some(point) = points.iter_mut().find(|it| it.row == job.row) {
                    point.widen(value, assumption);
                }
            }
        }
        Ok(MapBands {
            bands,
            varied,
            not_varied,
            responses: responses.into_inner(),
            complete: end == BatchEnd::Complete,
        })
    }

    /// Bands without width in the rows whose boundaries are all known, at most nine of them where the rows are numbers.
    fn boundaries_as_bands(&self, refined: &RefinedMap) -> Vec<BoundaryBand> {
        let ends = self.columns().ends().unwrap_or_default();
        let mut bands = Vec::new();
        for variant in 0..self.variants().len() {
            let of_variant = refined.boundaries.iter().filter(|it| it.variant == variant);
            let of_variant: Vec<_> = of_variant.collect();
            let place = |class: usize, row: u64| {
                let mut points = of_variant.get(class)?.points.iter();
                points.find(|it| it.row == row).map(|it| it.place)
            };
            let is_known = |row: &u64| {
                (0..ACTIONS.len())
                    .all(|class| place(class, *row).is_some_and(|it| it != RowBoundary::Infeasible))
            };
            let first = of_variant.first().map_or(&[][..], |it| &it.points);
            let known: Vec<u64> = first.iter().map(|it| it.row).filter(is_known).collect();
            let rows: Vec<u64> = match self.rows().ends() {
                Some(_) if known.len() > BAND_ROWS => (0..BAND_ROWS)
                    .map(|it| known[it * (known.len() - 1) / (BAND_ROWS - 1)])
                    .collect(),
                _ => known,
            };
            for (class, action) in ACTIONS.into_iter().enumerate() {
                let point = |row: &u64| {
                    let value = match place(class, *row)? {
                        RowBoundary::Always => ends[0],
                        RowBoundary::Never => ends[1],
                        between => between.value()?,
                    };
                    Some(BandPoint {
                        row: *row,
                        low: value,
                        high: value,
                        low_by: None,
                        high_by: None,
                    })
                };
                bands.push(BoundaryBand {
                    variant,
                    action,
                    points: rows.iter().filter_map(point).collect(),
                });
            }
        }
        bands
    }
}

impl BandPoint {
    fn widen(&mut self, value: f64, by: Assumption) {
        if value < self.low {
            (self.low, self.low_by) = (value, Some(by));
        }
        if value > self.high {
            (self.high, self.high_by) = (value, Some(by));
        }
    }
}

impl Job {
    fn run(&self, row: &mut Row<'_>) -> Found {
        row.restrict()?;
        let mut found = [None; ACTIONS.len()];
        for ((action, known), found) in ACTIONS.into_iter().zip(self.known).zip(&mut found) {
            let expected = match known {
                None | Some(RowBoundary::Infeasible) => continue,
                Some(RowBoundary::Always) => Expected::Unchanged(true),
                Some(RowBoundary::Never) => Expected::Unchanged(false),
                Some(RowBoundary::Between { below, at, rising }) => Expected::Near {
                    centre: 0.5 * (row.place(below) + row.place(at)),
                    rising,
                },
            };
            let (place, _) = row.expected(Event::Class(action), expected)?;
            *found = Some(place);
        }
        Ok(found)
    }
}

/// Every assumption at the ends of its range, without those that an axis varies.
fn changes(parameters: &Parameters, axes: [&MapAxis; 2]) -> Vec<Changed> {
    let settings = parameters.settings();
    let properties = parameters.column_properties();
    let ranges = &settings.assessment;
    let mut all: Vec<Changed> = Vec::new();
    let mut add = |assumption, changes: Vec<(&'static str, Value)>| {
        all.push(Changed {
            assumption,
            changes,
            assumed: Assumed::Nothing,
        });
    };
    let both = |width: f64| [-width, width].into_iter().filter(|end| *end != 0.0);
    for end in both(ranges.range_velocity) {
        let velocity = settings.impact.velocity * (1.0 + end);
        add(
            Assumption::Speed,
            vec![("impact.velocity", velocity.into())],
        );
    }
    for end in both(ranges.range_height) {
        let changes = vec![
            (
                "geometry.length_below",
                (properties.length_below + end).into(),
            ),
            (
                "geometry.length_above",
                (properties.length_above - end).into(),
            ),
        ];
        add(Assumption::Height, changes);
    }
    for end in both(ranges.range_front) {
        let factor = settings.vehicle.force_factor * (1.0 + end);
        add(
            Assumption::FrontForce,
            vec![("vehicle.force_factor", factor.into())],
        );
    }
    if settings.vehicle.narrow_object {
        add(
            Assumption::NarrowObject,
            vec![("vehicle.narrow_object", false.into())],
        );
    }
    let law = match properties.rate {
        Some(_) => "none",
        None => "logarithmic",
    };
    // The default of the hardening follows the law, and is not what is changed here.
    let own = properties.hardening_ratio;
    let changes = vec![("rate.law", law.into()), ("hardening.ratio", own.into())];
    add(Assumption::StrainRate, changes);
    let [least, most] = HARDENING_BAND;
    let mut weakest = vec![("hardening.ratio", least.min(own).into())];
    if let Some(shear) = &properties.shear {
        // Without its flanges, as the weak end of the band has it.
        weakest.push(("resistance.shear", shear.web_resistance.into()));
    }
    add(Assumption::Hardening, weakest);
    let changes = vec![
        ("hardening.ratio", most.max(own).into()),
        ("softening.model", "none".into()),
    ];
    add(Assumption::Hardening, changes);
    if settings.top.spring_stiffness > 0.0 {
        add(
            Assumption::TopSpring,
            vec![("top.spring_stiffness", 0.0.into())],
        );
    }
    if settings.resistance.moment == 0.0 {
        let strength = OVERSTRENGTH * parameters.steel().yield_strength;
        all.push(Changed {
            assumption: Assumption::YieldStrength,
            changes: vec![("steel.yield_strength", strength.into())],
            assumed: Assumed::LargestStrength(Arc::new(parameters.clone())),
        });
    }
    if ConnectedBase::of(parameters).is_ok_and(|base| base.is_assumed && base.bears_moment) {
        all.push(Changed {
            assumption: Assumption::BasePlate,
            changes: Vec::new(),
            assumed: Assumed::PlateInResponse,
        });
    }
    let has_vehicle = parameters.impact().vehicle.is_some();
    let is_varied = |axis: &MapAxis, changed: &Changed| {
        let names = |prefix: &str| {
            changed
                .changes
                .iter()
                .any(|(name, _)| name.starts_with(prefix))
        };
        match axis.quantity() {
            MapQuantity::Velocity => names("impact.velocity"),
            MapQuantity::Height => names("geometry."),
            // Each of several vehicles strikes at its own height, with its own share of the front.
            MapQuantity::Vehicle => names("geometry.") || names("vehicle.narrow_object"),
            MapQuantity::Parameter(it) => {
                names(it.name) || (it.name.starts_with("geometry.") && names("geometry."))
            }
            MapQuantity::Mass | MapQuantity::Section | MapQuantity::Direction => false,
        }
    };
    let vehicles_vary = axes.iter().any(|it| it.quantity() == MapQuantity::Vehicle);
    all.retain(|changed| {
        let needs_front = matches!(
            changed.assumption,
            Assumption::FrontForce | Assumption::NarrowObject
        );
        (has_vehicle || vehicles_vary || !needs_front)
            && !axes.iter().any(|axis| is_varied(axis, changed))
    });
    all
}
