//! Damage maps: what an impact leads to, over a plane of two quantities.

use std::collections::{HashSet, VecDeque};
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::axis::{self, AxisValue, MapAxis, MapQuantity};
use super::axis_problem::MAX_CELLS;
use super::batch::{Batch, BatchEnd};
use super::map_error::MapError;
use super::map_variants::{Variant, check_compared, precedence, with_mass_of_rigid, with_vehicle};
use super::study_column::{Assumed, Evaluation, Glance, StudyColumn, StudyError};
use super::verdict_model::{StudyOpinion, VerdictModel};
use crate::column::Impact;
use crate::parameters::{Parameters, RIGID, Value};
use crate::second_opinion::JointVerdict;

/// Columns that are kept for the cells that follow. A map has one per value of an axis of the column, and cells that follow one
/// another share it; processors work on cells some distance apart.
const KEPT_COLUMNS: usize = 256;

/// A map over two axes, for one column or for several that are compared.
///
/// Its cells are numbered: variant by variant, in each of them row by row, in each row from the first to the last value of
/// [`DamageMap::columns`]. A cell depends on nothing but its number, so that any part of a map can be computed anywhere.
///
/// ```
/// use column_twin::parameters::Parameters;
/// use column_twin::study::{Batch, DamageMap, MapAxis};
///
/// let axes = [MapAxis::parse("velocity=5:20:4")?, MapAxis::parse("mass=1000:3000:2")?];
/// let map = DamageMap::new(&Parameters::default(), Some("mid_car"), axes)?;
/// assert_eq!(map.len(), 8);
/// // One row for each mass, with the velocities in it.
/// assert_eq!(map.rows().quantity().name(), "mass");
/// let table = map.table(&Batch::default())?;
/// assert!(table.max_v1[3] > table.max_v1[0]);
/// // A single cell is the same, bit for bit.
/// assert_eq!(map.cell(3).result.map(|it| it.max_v1), Ok(table.max_v1[3]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct DamageMap {
    variants: Vec<Variant>,
    rows: MapAxis,
    columns: MapAxis,
    /// By which model the impacts are judged.
    model: VerdictModel,
    /// What each variant has that its parameters do not say; empty where that is nothing.
    assumed: Vec<Assumed>,
    /// The column that earlier impacts have damaged, before the vehicle of each variant; empty where every cell is an impact on an
    /// undamaged one.
    damaged: Vec<StudyColumn>,
    /// The columns that were needed last.
    kept: Mutex<VecDeque<(ColumnKey, KeptColumn)>>,
}

/// Which column a cell needs: the variant, and the places on the axes that belong to the column.
type ColumnKey = (usize, Option<u64>, Option<u64>);
/// A column, or why there is none; empty until the first cell that needs it computes it.
type KeptColumn = Arc<OnceLock<Result<StudyColumn, String>>>;

/// The place of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellPlace {
    /// Number of the variant, from 0.
    pub variant: usize,
    /// Place on the axis of the rows, from 0.
    pub row: u64,
    /// Place on the axis of the columns, from 0.
    pub column: u64,
}

/// One cell of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapCell {
    /// Its number, from 0.
    pub index: u64,
    /// Its place.
    pub place: CellPlace,
    /// What the impact leads to, or why that could not be computed.
    pub result: Result<Evaluation, String>,
    /// What the fibre beam says, or why it says nothing; `None` where it was not asked, or where there is no result.
    pub second_opinion: Option<Result<StudyOpinion, String>>,
}

/// The cells of a map as columns of equal length; a value that does not exist is NaN.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MapTable {
    /// Number of the cell.
    pub index: Vec<u64>,
    /// Number of the variant.
    pub variant: Vec<usize>,
    /// Place on the axis of the rows.
    pub row: Vec<u64>,
    /// Place on the axis of the columns.
    pub column: Vec<u64>,
    /// What the impact leads to, or why that could not be computed.
    pub result: Vec<Result<Evaluation, String>>,
    /// Peak displacement of the impact point \[m\].
    pub max_v1: Vec<f64>,
    /// Residual displacement of the impact point \[m\]; NaN where the column does not stand.
    pub residual_v1: Vec<f64>,
    /// Largest contact force \[N\].
    pub peak_contact_force: Vec<f64>,
    /// Residual axial capacity \[N\].
    pub residual_capacity: Vec<f64>,
    /// Residual capacity over that of the undamaged column.
    pub capacity_ratio: Vec<f64>,
    /// Largest plastic rotation of a hinge \[rad\].
    pub max_plastic_rotation: Vec<f64>,
}

impl DamageMap {
    /// The map of one column. The vehicle is that of the parameters where none is named; what no axis varies has the value
    /// of the parameters. Of the two axes, the one that belongs to the column makes the rows, then a vehicle, then the mass.
    ///
    /// # Errors
    /// Axes that depend on each other, too many cells, or values that the parameters do not admit.
    pub fn new(
        parameters: &Parameters,
        vehicle: Option<&str>,
        axes: [MapAxis; 2],
    ) -> Result<Self, MapError> {
        Self::comparing(parameters, vehicle, &[], axes)
    }

    /// The map of the same column with each combination of some values, such as sections and loads, to compare them. Each of them
    /// is a variant.
    ///
    /// # Errors
    /// As [`new`](Self::new), too many combinations, and a comparison of what an axis varies.
    pub fn comparing(
        parameters: &Parameters,
        vehicle: Option<&str>,
        compared: &[MapAxis],
        axes: [MapAxis; 2],
    ) -> Result<Self, MapError> {
        check_compared(compared, &axes)?;
        let with_mass = with_mass_of_rigid(parameters, vehicle, compared.iter().chain(&axes))?;
        let parameters = with_vehicle(with_mass.as_ref().unwrap_or(parameters), vehicle)?;
        Self::of_variants(Variant::of_values(&parameters, compared)?, axes)
    }

    /// The map of several columns, over the same axes.
    ///
    /// # Errors
    /// As [`new`](Self::new), and two columns of the same label.
    pub fn of_variants(mut variants: Vec<Variant>, axes: [MapAxis; 2]) -> Result<Self, MapError> {
        let [first, second] = &axes;
        if first.excludes(second) {
            let [first, second] = [first, second].map(|axis| axis.quantity().name());
            return Err(MapError::SameQuantity(first, second));
        }
        let [mut rows, mut columns] = axes;
        if precedence(columns.quantity()) < precedence(rows.quantity()) {
            std::mem::swap(&mut rows, &mut columns);
        }
        if variants.is_empty() {
            return Err(MapError::NoVariant);
        }
        let cells = (variants.len() as u64)
            .checked_mul(rows.len())
            .and_then(|cells| cells.checked_mul(columns.len()));
        if cells.is_none_or(|cells| cells > MAX_CELLS) {
            return Err(MapError::TooManyCells {
                variants: variants.len(),
                rows: rows.len(),
                columns: columns.len(),
            });
        }
        let twice = {
            let mut labels = HashSet::new();
            variants.iter().find(|it| !labels.insert(it.label.as_str()))
        };
        if let Some(twice) = twice {
            return Err(MapError::SameLabel(twice.label.clone()));
        }
        for variant in &mut variants {
            let varied = [&rows, &columns].into_iter();
            if let Some(with_mass) = with_mass_of_rigid(&variant.parameters, None, varied)? {
                variant.parameters = with_mass;
            }
            rows.check_on(&variant.parameters)?;
            columns.check_on(&variant.parameters)?;
        }
        Ok(Self {
            variants,
            rows,
            columns,
            model: VerdictModel::Bars,
            assumed: Vec::new(),
            damaged: Vec::new(),
            kept: Mutex::default(),
        })
    }

    /// The map of a column that earlier impacts have damaged: every cell is one more impact on it, at the height of its hinges.
    ///
    /// # Errors
    /// As [`comparing`](Self::comparing), and an axis that belongs to the column.
    pub fn of_damaged(
        column: &StudyColumn,
        vehicle: Option<&str>,
        compared: &[MapAxis],
        axes: [MapAxis; 2],
    ) -> Result<Self, MapError> {
        let mut varied = axes.iter().chain(compared).map(MapAxis::quantity);
        if let Some(varied) = varied.find(MapQuantity::is_of_the_column) {
            return Err(MapError::DamagedColumnVaries(varied.name()));
        }
        let map = Self::comparing(column.parameters(), vehicle, compared, axes)?;
        let damaged = map
            .variants
            .iter()
            .map(|it| column.with_impact_of(&it.parameters));
        let damaged = damaged.collect::<Result<_, _>>()?;
        Ok(Self { damaged, ..map })
    }

    /// Whether earlier impacts have damaged the column.
    #[must_use]
    pub fn is_of_damaged(&self) -> bool {
        !self.damaged.is_empty()
    }

    /// The same map, judged by another model than the two bars.
    ///
    /// # Errors
    /// The model needs the fibre beam, and a column switches it off, or is damaged.
    pub fn judged_by(self, model: VerdictModel) -> Result<Self, MapError> {
        if self.is_of_damaged() && model != VerdictModel::Bars {
            return Err(MapError::DamagedByBeam(model));
        }
        for variant in &self.variants {
            model.check_on(&variant.parameters)?;
        }
        Ok(Self { model, ..self })
    }

    /// By which model the impacts are judged.
    #[must_use]
    pub fn model(&self) -> VerdictModel {
        self.model
    }

    /// The map of other columns over the same axes, with what their parameters do not say.
    pub(super) fn with_variants(&self, variants: Vec<Variant>, assumed: Vec<Assumed>) -> Self {
        Self {
            variants,
            rows: self.rows.clone(),
            columns: self.columns.clone(),
            model: self.model,
            assumed,
            damaged: Vec::new(),
            kept: Mutex::default(),
        }
    }

    /// Number of cells.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a map is never empty")]
    pub fn len(&self) -> u64 {
        self.variants.len() as u64 * self.rows.len() * self.columns.len()
    }

    /// The columns that are compared; one where nothing is compared.
    #[must_use]
    pub fn variants(&self) -> &[Variant] {
        &self.variants
    }

    /// The axis of the rows.
    #[must_use]
    pub fn rows(&self) -> &MapAxis {
        &self.rows
    }

    /// The axis of the columns: of mass and velocity, the velocity.
    #[must_use]
    pub fn columns(&self) -> &MapAxis {
        &self.columns
    }

    /// The place of the cell of this number.
    #[must_use]
    pub fn place(&self, index: u64) -> CellPlace {
        let row = index / self.columns.len();
        CellPlace {
            variant: (row / self.rows.len()) as usize,
            row: row % self.rows.len(),
            column: index % self.columns.len(),
        }
    }

    /// The number of the cell at this place.
    #[must_use]
    pub fn index(&self, place: CellPlace) -> u64 {
        (place.variant as u64 * self.rows.len() + place.row) * self.columns.len() + place.column
    }

    /// The cells of a contiguous part of the map: part `number`, from 1, of `count` parts, which together are the map.
    #[must_use]
    pub fn shard(&self, number: u64, count: u64) -> Range<u64> {
        let at = |part: u64| {
            let cells = u128::from(self.len()) * u128::from(part) / u128::from(count.max(1));
            u64::try_from(cells).unwrap_or(self.len()).min(self.len())
        };
        at(number.saturating_sub(1))..at(number)
    }

    /// Computes one cell, whose number must be less than [`len`](Self::len).
    #[must_use]
    pub fn cell(&self, index: u64) -> MapCell {
        let place = self.place(index);
        let values = [self.rows.value(place.row), self.columns.value(place.column)];
        let (result, second_opinion) = match self.model {
            VerdictModel::Bars => {
                let places = [Some(place.row), Some(place.column)];
                let result = self.judged(place.variant, places, values, StudyColumn::evaluate);
                (result, None)
            }
            VerdictModel::Beam | VerdictModel::Both => match self.by_both(place.variant, values) {
                Ok((evaluation, opinion)) => (Ok(evaluation), Some(opinion)),
                Err(fault) => (Err(fault), None),
            },
        };
        MapCell {
            index,
            place,
            result,
            second_opinion,
        }
    }

    /// What a search for boundaries needs to know of the impact at values that need not be those of a cell: with the place on an
    /// axis where the value is one of the axis.
    pub(super) fn glance(
        &self,
        variant: usize,
        places: [Option<u64>; 2],
        values: [AxisValue<'_>; 2],
    ) -> Result<Glance, String> {
        match self.model {
            VerdictModel::Bars => self.judged(variant, places, values, StudyColumn::glance),
            VerdictModel::Beam | VerdictModel::Both => {
                let (evaluation, _) = self.by_both(variant, values)?;
                Ok(Glance::from(&evaluation))
            }
        }
    }

    /// The impact at these values by both models, as the plain simulation computes it, and what the beam says, or why it says
    /// nothing.
    fn by_both(
        &self,
        variant: usize,
        values: [AxisValue<'_>; 2],
    ) -> Result<(Evaluation, Result<StudyOpinion, String>), String> {
        let base = &self.variants[variant].parameters;
        let axes = [&self.rows, &self.columns].into_iter().zip(values);
        // The rows come first: a vehicle brings its own mass along, which an axis of masses replaces.
        let changes = axes.flat_map(|(axis, value)| axis.changes(base, value));
        let parameters = base
            .with_changes(changes)
            .map_err(|faults| faults.in_one_line())?;
        let joint = JointVerdict::of_parameters(&parameters).map_err(|fault| fault.to_string())?;
        let judged = self.model.evaluation(joint);
        let (evaluation, opinion) = judged.map_err(|reason| reason.to_string())?;
        Ok((evaluation, opinion.map_err(|reason| reason.to_string())))
    }

    /// Whether the web of a variant can yield in shear, and whether its base is checked; neither where there is no column at the
    /// first values of the axes.
    pub(super) fn limits(&self, variant: usize) -> [bool; 2] {
        let values = [self.rows.value(0), self.columns.value(0)];
        let limits = self.judged(variant, [Some(0), Some(0)], values, |column, _| {
            Ok(column.limits())
        });
        limits.unwrap_or_default()
    }

    /// Whether the impact at these values can be computed: the column is admissible, and so is the vehicle with its mass. No
    /// response is computed.
    pub(super) fn admits(
        &self,
        variant: usize,
        places: [Option<u64>; 2],
        values: [AxisValue<'_>; 2],
    ) -> Result<(), String> {
        self.judged(variant, places, values, |_, _| Ok(()))
    }

    fn judged<T>(
        &self,
        variant: usize,
        places: [Option<u64>; 2],
        values: [AxisValue<'_>; 2],
        judge: fn(&StudyColumn, &Impact) -> Result<T, StudyError>,
    ) -> Result<T, String> {
        let evaluated = |column: &StudyColumn| {
            let struck = column.struck_by(self.vehicle(values));
            let struck = struck.map_err(|fault| fault.to_string())?;
            let column = struck.as_deref().unwrap_or(column);
            let impact = self
                .impact(column, values)
                .map_err(|fault| fault.to_string())?;
            judge(column, &impact).map_err(|fault| fault.to_string())
        };
        let key = |axis: &MapAxis, place: Option<u64>| match axis.quantity().is_of_the_column() {
            // A value between those of the axis has a column of its own, which is not kept.
            true => place.map(Some),
            false => Some(None),
        };
        match (key(&self.rows, places[0]), key(&self.columns, places[1])) {
            (Some(row), Some(column)) => {
                let kept = self.kept((variant, row, column));
                let made = kept.get_or_init(|| self.study_column(variant, values));
                made.as_ref().map_err(Clone::clone).and_then(evaluated)
            }
            _ => evaluated(&self.study_column(variant, values)?),
        }
    }

    /// The vehicle at these values, if it varies.
    fn vehicle<'v>(&self, values: [AxisValue<'v>; 2]) -> Option<&'v str> {
        let axes = [&self.rows, &self.columns].into_iter().zip(values);
        axes.rev().find_map(|(axis, value)| match value {
            AxisValue::Name(name) if axis.quantity() == MapQuantity::Vehicle => Some(name),
            _ => None,
        })
    }

    /// The impact on a column at these values.
    fn impact(
        &self,
        column: &StudyColumn,
        values: [AxisValue<'_>; 2],
    ) -> Result<Impact, StudyError> {
        let settings = column.parameters().settings();
        let vehicle = self.vehicle(values);
        let (mut mass, mut velocity) = (None, settings.impact.velocity);
        let mut direction = settings.impact.direction;
        for (axis, value) in [&self.rows, &self.columns].into_iter().zip(values) {
            match (axis.quantity(), value) {
                (MapQuantity::Mass, AxisValue::Number(number)) => mass = Some(number),
                (MapQuantity::Velocity, AxisValue::Number(number)) => velocity = number,
                (MapQuantity::Direction, AxisValue::Number(degrees)) => {
                    direction = degrees.to_radians();
                }
                (MapQuantity::Parameter(it), AxisValue::Number(radians))
                    if it.name == axis::DIRECTION =>
                {
                    direction = radians;
                }
                _ => {}
            }
        }
        // A rigid mass has no mass of its own.
        if vehicle == Some(RIGID) {
            mass = mass.or(Some(settings.impact.mass));
        }
        let impacts = column.impacts_of(vehicle)?.in_direction(direction);
        impacts.impact(mass, velocity)
    }

    fn study_column(
        &self,
        variant: usize,
        values: [AxisValue<'_>; 2],
    ) -> Result<StudyColumn, String> {
        if let Some(damaged) = self.damaged.get(variant) {
            return Ok(damaged.clone());
        }
        let base = &self.variants[variant].parameters;
        let axes = [&self.rows, &self.columns].into_iter().zip(values);
        let changes: Vec<_> = axes
            .filter(|(axis, _)| axis.quantity().is_of_the_column())
            .flat_map(|(axis, value)| axis.changes(base, value))
            .collect();
        let changed = base
            .with_changes(changes)
            .map_err(|faults| faults.in_one_line())?;
        let assumed = match self.assumed.get(variant) {
            // Of what the axes vary, the base has its part.
            Some(Assumed::LargestStrength(nominal)) => {
                let strength = nominal.settings().steel.yield_strength;
                let nominal =
                    changed.with_changes([("steel.yield_strength", Value::Double(strength))]);
                let nominal = nominal.map_err(|faults| faults.in_one_line())?;
                Assumed::LargestStrength(Arc::new(nominal))
            }
            other => other.cloned().unwrap_or_default(),
        };
        StudyColumn::assuming(&changed, &assumed).map_err(|fault| fault.to_string())
    }

    /// The place of a column among those that are kept; the longest kept one goes.
    fn kept(&self, key: ColumnKey) -> KeptColumn {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, column)) = kept.iter().rev().find(|(of, _)| *of == key) {
            return column.clone();
        }
        if kept.len() == KEPT_COLUMNS {
            kept.pop_front();
        }
        let column = KeptColumn::default();
        kept.push_back((key, column.clone()));
        column
    }

    /// Computes some cells on all processors and hands them to `sink` in their order, in chunks. The memory does not depend
    /// on their number.
    ///
    /// # Errors
    /// The first error of `sink`, or of the system that gives no threads.
    pub fn compute<E: From<rayon::ThreadPoolBuildError>>(
        &self,
        batch: &Batch,
        cells: Range<u64>,
        sink: impl FnMut(Vec<MapCell>) -> Result<(), E>,
    ) -> Result<BatchEnd, E> {
        let count = cells.end.saturating_sub(cells.start);
        batch.run(count, |offset| self.cell(cells.start + offset), sink)
    }

    /// Computes the whole map, in memory. An interrupted batch leaves a table of the cells that are done.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn table(&self, batch: &Batch) -> Result<MapTable, rayon::ThreadPoolBuildError> {
        let mut table = MapTable::default();
        let end = self.compute(batch, 0..self.len(), |cells| {
            cells.into_iter().for_each(|cell| table.push(cell));
            Ok(())
        });
        end.map(|_| table)
    }
}

impl MapTable {
    /// Appends a cell.
    pub fn push(&mut self, cell: MapCell) {
        let evaluation = cell.result.as_ref().ok();
        let number = |value: fn(&Evaluation) -> f64| evaluation.map_or(f64::NAN, value);
        self.index.push(cell.index);
        self.variant.push(cell.place.variant);
        self.row.push(cell.place.row);
        self.column.push(cell.place.column);
        self.max_v1.push(number(|it| it.max_v1));
        self.residual_v1
            .push(number(|it| it.residual_v1.unwrap_or(f64::NAN)));
        self.peak_contact_force
            .push(number(|it| it.peak_contact_force));
        self.residual_capacity
            .push(number(|it| it.residual_capacity));
        self.capacity_ratio.push(number(|it| it.capacity_ratio));
        self.max_plastic_rotation
            .push(number(|it| it.max_plastic_rotation));
        self.result.push(cell.result);
    }
}
