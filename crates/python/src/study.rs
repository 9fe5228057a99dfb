//! Damage maps and critical velocities for Python.

use std::num::NonZeroUsize;
use std::sync::Arc;

use column_twin::column::is_direction;
use column_twin::parameters::CatalogueVehicle;
use column_twin::study::{
    AxisValue, AxisValues, BatchEnd, CriticalVelocity, DamageMap, MapAxis, MapError, MapQuantity,
    StudyColumn, Variant, VerdictModel, arranged_axes,
};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};
use rayon::ThreadPoolBuildError;

use crate::batch::{CELL_BYTES, Codes, NUMBERS, Row, abandonable, batch, interruptible};
use crate::beam_columns::BeamColumns;
use crate::fault;

/// The parameter of the direction of travel \[rad\].
const DIRECTION: &str = "impact.direction";

/// An axis as Python gives it: in the notation of the command line, or as a name with its values.
#[derive(FromPyObject)]
pub enum GivenAxis {
    /// `velocity=1:25:100`
    Text(String),
    /// A range: name, from, to, number of points.
    Range(String, f64, f64, u64),
    /// Numbers.
    Numbers(String, Vec<f64>),
    /// Names of a catalogue.
    Names(String, Vec<String>),
}

impl GivenAxis {
    pub fn axis(self) -> PyResult<MapAxis> {
        let quantity = |name: &str| {
            // Python gives it in rad everywhere, the notation of the command line in degrees.
            let native = if name == MapQuantity::Direction.name() {
                DIRECTION
            } else {
                name
            };
            MapQuantity::named(native).map_err(|problem| fault::input(format!("{name}: {problem}")))
        };
        let axis = match self {
            Self::Text(text) => MapAxis::parse(&text),
            Self::Range(name, from, to, count) => MapAxis::range(quantity(&name)?, from, to, count),
            Self::Numbers(name, numbers) => {
                MapAxis::of(quantity(&name)?, AxisValues::Numbers(numbers))
            }
            Self::Names(name, names) => MapAxis::of(quantity(&name)?, AxisValues::Names(names)),
        };
        let axis = axis.map_err(|fault| fault::input(fault.to_string()))?;
        if is_direction_in_rad(axis.quantity())
            && let Some(beyond) = axis
                .ends()
                .and_then(|ends| ends.into_iter().find(|it| !is_direction(*it)))
        {
            return Err(fault::input(format!(
                "direction: {beyond} is out of range; expected angles above -pi and at most pi, in rad, such as np.radians({beyond})"
            )));
        }
        Ok(axis)
    }
}

fn is_direction_in_rad(quantity: MapQuantity) -> bool {
    matches!(quantity, MapQuantity::Parameter(it) if it.name == DIRECTION)
}

/// Name and title of what varies: a direction is one in rad, too.
fn names(quantity: MapQuantity) -> [&'static str; 2] {
    let named = match is_direction_in_rad(quantity) {
        true => MapQuantity::Direction,
        false => quantity,
    };
    [named.name(), named.title()]
}

/// The model of this name, by which impacts are judged.
pub fn model_named(name: &str) -> PyResult<VerdictModel> {
    VerdictModel::named(name).ok_or_else(|| {
        fault::input(format!(
            "model: expected 'bars', 'beam' or 'both', found '{name}'"
        ))
    })
}

/// An axis for Python: name, title, unit, and its numbers or names.
fn described<'py>(py: Python<'py>, axis: &MapAxis) -> PyResult<Bound<'py, PyDict>> {
    let quantity = axis.quantity();
    let all = PyDict::new(py);
    let [name, title] = names(quantity);
    all.set_item("name", name)?;
    all.set_item("title", title)?;
    all.set_item("unit", quantity.unit())?;
    let values = (0..axis.len()).map(|index| axis.value(index));
    if quantity.is_named() {
        let names: Vec<String> = values.map(|value| value.to_string()).collect();
        all.set_item("values", names)?;
    } else {
        let number = |value| match value {
            AxisValue::Number(number) => number,
            AxisValue::Name(_) => f64::NAN,
        };
        all.set_item("values", values.map(number).collect::<Vec<f64>>())?;
    }
    Ok(all)
}

/// A map as Python asks for it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct MapRequest {
    vehicle: Option<String>,
    /// Two or more.
    axes: Vec<GivenAxis>,
    compared: Option<GivenAxis>,
    /// Name of the model that judges.
    model: String,
    threads: Option<NonZeroUsize>,
}

/// A map that is checked.
struct Planned {
    map: Arc<DamageMap>,
    /// The axes that make neither rows nor columns. The variants of the map are the combinations of the compared values and of
    /// theirs.
    further: Vec<MapAxis>,
    /// Names of the compared columns; one where nothing is compared.
    labels: Vec<String>,
    /// The first one of the axes and of the compared values \[kg\].
    smallest_mass: Option<f64>,
    threads: Option<NonZeroUsize>,
}

impl Planned {
    /// Why the smallest mass is implausible for the vehicle of the map.
    fn implausible_mass(&self) -> Option<String> {
        let smallest = self.smallest_mass?;
        self.map.variants().iter().find_map(|variant| {
            let name = &variant.parameters.settings().vehicle.name;
            CatalogueVehicle::of_crushed(name)?.implausible_mass(smallest)
        })
    }
}

impl MapRequest {
    /// The map of a column, which is damaged or not, with a warning of an implausible mass. It may have thousands of
    /// columns, which are made without the GIL.
    fn planned(
        self,
        py: Python<'_>,
        (column, is_damaged): (&Arc<StudyColumn>, bool),
    ) -> PyResult<Planned> {
        let column = Arc::clone(column);
        let planned = abandonable(py, move || self.plan(&column, is_damaged))??;
        if let Some(text) = planned.implausible_mass() {
            fault::warn(py, &format!("mass: the smallest one is the mass of {text}"))?;
        }
        Ok(planned)
    }

    fn plan(self, column: &StudyColumn, is_damaged: bool) -> PyResult<Planned> {
        let model = model_named(&self.model)?;
        let axes: PyResult<Vec<_>> = self.axes.into_iter().map(GivenAxis::axis).collect();
        let (further, axes) = arranged_axes(axes?).map_err(|reason| rejected(&reason))?;
        let compared = self.compared.map(GivenAxis::axis).transpose()?;
        let labels = match &compared {
            None => vec![column.parameters().settings().column_id.clone()],
            Some(axis) => (0..axis.len()).map(|it| Variant::label(axis, it)).collect(),
        };
        let varied: Vec<_> = compared.iter().chain(&further).cloned().collect();
        let mut masses = varied.iter().chain(&axes);
        let masses = masses.find(|it| it.quantity() == MapQuantity::Mass);
        let smallest_mass = masses.and_then(|it| it.number(0));
        let vehicle = self.vehicle.as_deref();
        let map = match is_damaged {
            true => DamageMap::of_damaged(column, vehicle, &varied, axes),
            false => DamageMap::comparing(column.parameters(), vehicle, &varied, axes),
        };
        let map = map.and_then(|map| map.judged_by(model));
        Ok(Planned {
            map: Arc::new(map.map_err(|reason| rejected(&reason))?),
            further,
            labels,
            smallest_mass,
            threads: self.threads,
        })
    }
}

/// Computes a map, or the part `shard` (a number, from 1, and the number of parts): its axes and labels, its cells as rows of
/// bytes, why some could not be computed, and what the fibre beam says of them.
pub fn map<'py>(
    py: Python<'py>,
    column: (&Arc<StudyColumn>, bool),
    request: MapRequest,
    shard: Option<[u64; 2]>,
) -> PyResult<Bound<'py, PyDict>> {
    let planned = request.planned(py, column)?;
    let map = planned.map;
    let cells = shard.map_or(0..map.len(), |[number, parts]| map.shard(number, parts));
    let count = cells.end - cells.start;
    let batch = batch(py, planned.threads, count)?;
    let first = cells.start;
    let its_map = Arc::clone(&map);
    let computed = interruptible(py, &batch, move |batch| {
        let mut bytes = Vec::with_capacity(CELL_BYTES * count as usize);
        let mut failed = Vec::new();
        let mut beam = BeamColumns::of(&its_map);
        let end = its_map.compute(batch, cells, |cells| {
            for cell in cells {
                beam.push(&its_map, &cell);
                let row = match cell.result {
                    // Mass and velocity are those of the axes.
                    Ok(evaluation) => Row::of([f64::NAN; 2], &evaluation),
                    Err(reason) => {
                        failed.push((cell.index - first, reason));
                        Row {
                            numbers: [f64::NAN; NUMBERS],
                            codes: Codes::UNKNOWN,
                        }
                    }
                };
                bytes.extend_from_slice(&row.bytes_of_cell());
            }
            Ok::<_, ThreadPoolBuildError>(())
        })?;
        Ok::<_, ThreadPoolBuildError>((end, bytes, failed, beam))
    })?;
    let (end, bytes, failed, beam) = computed.map_err(|reason| fault::no_threads(&reason))?;
    if let BatchEnd::Interrupted(done) = end {
        return Err(fault::simulation(format!(
            "the map was interrupted after {done} cells"
        )));
    }

    let result = PyDict::new(py);
    result.set_item("rows", described(py, map.rows())?)?;
    result.set_item("columns", described(py, map.columns())?)?;
    let further: PyResult<Vec<_>> = planned
        .further
        .iter()
        .map(|axis| described(py, axis))
        .collect();
    result.set_item("further", further?)?;
    result.set_item("labels", planned.labels)?;
    let failures = PyDict::new(py);
    for (index, reason) in failed {
        failures.set_item(index, reason)?;
    }
    result.set_item("failures", failures)?;
    result.set_item("first", first)?;
    result.set_item("model", map.model().name())?;
    result.set_item("beam", beam.into_py(py)?)?;
    result.set_item("cells", PyByteArray::new(py, &bytes))?;
    Ok(result)
}

/// The boundaries of the actions and limits on a map, with its axes and labels, as JSON.
pub fn refine(
    py: Python<'_>,
    column: (&Arc<StudyColumn>, bool),
    request: MapRequest,
) -> PyResult<String> {
    let planned = request.planned(py, column)?;
    if let Some(axis) = planned.further.first() {
        let [name, _] = names(axis.quantity());
        return Err(fault::input(format!(
            "refined_map: expected two axes, in whose plane the boundaries lie; found {}. Give the column one value of {name}, or compare \
             its values: compare={{\"{name}\": [...]}}",
            2 + planned.further.len()
        )));
    }
    let map = planned.map;
    let batch = batch(py, planned.threads, map.len())?;
    let its_map = Arc::clone(&map);
    let refined = interruptible(py, &batch, move |batch| its_map.refine(batch))?
        .map_err(|reason| fault::input(reason.to_string()))?;
    let axis = |axis: &MapAxis| {
        let [name, _] = names(axis.quantity());
        serde_json::json!({"name": name, "unit": axis.quantity().unit(), "values": numbers(axis)})
    };
    let all = serde_json::json!({
        "rows": axis(map.rows()),
        "columns": axis(map.columns()),
        "model": map.model().name(),
        "labels": planned.labels,
        "refined": refined,
    });
    Ok(all.to_string())
}

/// The numbers of an axis; nothing of names.
fn numbers(axis: &MapAxis) -> Vec<f64> {
    (0..axis.len())
        .filter_map(|index| axis.number(index))
        .collect()
}

fn rejected(reason: &MapError) -> PyErr {
    match reason {
        MapError::Parameters(faults) => fault::parameters(faults),
        other => fault::input(other.to_string()),
    }
}

/// The velocities around a critical one: the largest below it and the smallest above it that were computed \[m/s\].
pub fn bracket(velocity: CriticalVelocity) -> (Option<f64>, Option<f64>) {
    match velocity {
        CriticalVelocity::Between { below, at } => (Some(below), Some(at)),
        CriticalVelocity::AtMost { lowest } => (None, Some(lowest)),
        CriticalVelocity::Above { highest } => (Some(highest), None),
    }
}
