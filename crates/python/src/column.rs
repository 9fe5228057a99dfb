//! A column for Python.

use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use column_twin::assessment::{
    AssessmentInput, BaseDemand, ResidualCapacity, imperfection, respond_and_rest,
};
use column_twin::column::{Impact, Model, PushDownPoint, State, push_down};
use column_twin::parameters::{
    CatalogueVehicle, FleetColumns, FleetSources, NodeName, ParameterFaults, Parameters, Source,
    Value,
};
use column_twin::second_opinion::EarlierHit;
use column_twin::study::StudyColumn;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyByteArray, PyDict};
use serde::{Deserialize, Serialize};

use crate::batch::{NUMBERS, Row, abandonable};
use crate::capacity::{Curve, capacity_json, curve};
use crate::checks::Checks;
use crate::fault;
use crate::history::{KnownDamage, Simulated};
use crate::impacts::{Arrays, evaluate};
use crate::risk::{Request, risk};
use crate::sensors;
use crate::study::{self, MapRequest, model_named};
use crate::values::{doubles, object, value};

/// The velocities below and at a critical one \[m/s\].
type Bracket = (Option<f64>, Option<f64>);

/// Names and values that change parameters.
type Changes<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// Numbers and codes of an evaluation, see `_evaluation.py`.
type Evaluated = ([f64; NUMBERS], [u8; 3]);

/// Name, value, unit and meaning of a parameter.
type Described<'py> = (String, Bound<'py, PyAny>, &'static str, &'static str);

/// Columns with their identifiers.
type NamedColumns = Vec<(String, Column)>;

/// A column that is prepared once for many impacts, undamaged or at rest with its damage.
#[pyclass(frozen, module = "column_twin._native")]
#[derive(Clone)]
pub struct Column {
    pub study: Arc<StudyColumn>,
    /// The impacts that have damaged it, for the fibre beam.
    pub hits: Arc<[EarlierHit]>,
    /// The damage that they leave in the beam, once an impact has needed it.
    pub beam_damage: Arc<OnceLock<KnownDamage>>,
    /// The values that are computed with, by the names of their parameters, once one has been read: one alone would take as long as
    /// all.
    values: Arc<OnceLock<HashMap<String, Value>>>,
}

/// A column as it is written for other processes.
#[derive(Serialize, Deserialize)]
struct Written {
    parameters: Parameters,
    /// The damaged column at rest; `None` for an undamaged one.
    rest: Option<State>,
    /// What has damaged it has put this into the base.
    base: Option<BaseDemand>,
    /// What has damaged it.
    hits: Vec<EarlierHit>,
}

#[pymethods]
impl Column {
    /// The defaults, changed by the parameter files and then by the values, with warnings about deprecated ones.
    #[staticmethod]
    fn load(files: Vec<PathBuf>, changes: Changes<'_>) -> PyResult<(Self, Vec<String>)> {
        let mut sources: Vec<_> = files.into_iter().map(Source::File).collect();
        for (name, given) in changes {
            let given = value(&name, &given)?;
            sources.push(Source::Value(name, given));
        }
        let (parameters, warnings) = Parameters::load_in_order(&NodeName::default(), sources)
            .map_err(|faults| fault::parameters(&faults))?;
        let warnings = warnings.iter().map(ToString::to_string).collect();
        Ok((Self::of(&parameters)?, warnings))
    }

    /// The columns of a fleet with their identifiers, in its order, and warnings about their parameters.
    #[staticmethod]
    fn fleet(
        py: Python<'_>,
        files: Vec<PathBuf>,
        table: Option<PathBuf>,
    ) -> PyResult<(NamedColumns, Vec<String>)> {
        let sources = FleetSources {
            files,
            table,
            arguments: vec![],
        };
        abandonable(py, move || {
            let fleet = FleetColumns::load(&NodeName::default(), &sources)
                .map_err(|faults| fault::parameters(&faults))?;
            let columns = fleet.columns.into_iter().map(|it| {
                let column = Self::of(&it.parameters)?;
                Ok((it.name, column))
            });
            let warnings = fleet.warnings.iter().map(ToString::to_string).collect();
            Ok::<_, PyErr>((columns.collect::<PyResult<_>>()?, warnings))
        })?
    }

    /// The column that `to_json` has written.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let written: Written =
            serde_json::from_str(text).map_err(|fault| fault::input(fault.to_string()))?;
        let column = Self::of(&written.parameters)?;
        let Some(rest) = written.rest else {
            return Ok(column);
        };
        // The hinges of a damaged column are where its last vehicle has struck, which is in the parameters.
        let damaged = StudyColumn::at_rest(&written.parameters, *column.study.model(), rest);
        let damaged = damaged.map_err(|fault| fault::study(&fault))?;
        let damaged = damaged.with_base_before(written.base);
        Ok(Self::after_hits(damaged, written.hits))
    }

    /// All parameters and the damage as JSON, which reads back to the last bit.
    fn to_json(&self) -> PyResult<String> {
        let written = Written {
            parameters: self.parameters().clone(),
            rest: self.is_damaged().then(|| *self.study.rest()),
            base: self
                .study
                .base_before()
                .copied()
                .filter(|_| self.is_damaged()),
            hits: self.hits.to_vec(),
        };
        serde_json::to_string(&written).map_err(|fault| fault::input(fault.to_string()))
    }

    /// All parameters as a parameter file of ROS 2.
    fn to_yaml(&self) -> String {
        self.parameters().to_yaml()
    }

    /// The column with other values, and warnings about them.
    fn with_changes(&self, changes: Changes<'_>) -> PyResult<(Self, Vec<String>)> {
        self.expect_undamaged(
            "with_changes",
            "change the column before its first impact, and compute the impacts again",
        )?;
        let changes: PyResult<Vec<_>> = changes
            .into_iter()
            .map(|(name, given)| {
                let given = value(&name, &given)?;
                Ok((name, given))
            })
            .collect();
        let changed = self.parameters().with_changes_and_warnings(changes?);
        let (changed, warnings) = changed.map_err(|faults| fault::parameters(&faults))?;
        let warnings = warnings.iter().map(ToString::to_string).collect();
        Ok((Self::of(&changed)?, warnings))
    }

    /// Whether an earlier impact has damaged the column.
    #[getter]
    pub fn is_damaged(&self) -> bool {
        // By the beam alone, where the two bars see no damage.
        self.study.is_damaged() || !self.hits.is_empty()
    }

    /// The column that an impact leaves; `None` if it carries nothing. Without a direction \[rad\] it has that of the parameters.
    /// Whether the fibre beam has found damage is asked where the two bars find none.
    #[pyo3(signature = (vehicle, mass, velocity, direction=None, by_beam=false))]
    fn after(
        &self,
        py: Python<'_>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
        direction: Option<f64>,
        by_beam: bool,
    ) -> PyResult<Option<Self>> {
        if let Some(there) = self.struck_by(vehicle)? {
            return there.after(py, vehicle, mass, velocity, direction, by_beam);
        }
        let impact = match direction {
            Some(direction) => self
                .towards(direction)?
                .impact(py, vehicle, mass, velocity)?,
            None => self.impact(py, vehicle, mass, velocity)?,
        };
        let hit = self.whole_hit(vehicle, mass, velocity, direction)?;
        let this = self.clone();
        let left = abandonable(py, move || this.study.after(&impact))?;
        let left = left.map_err(|fault| fault::study(&fault))?;
        Ok(left.map(
            |left| match left.is_damaged() || by_beam || !self.hits.is_empty() {
                true => Self::after_hits(left, self.hits.iter().cloned().chain([hit]).collect()),
                false => Self::from(left),
            },
        ))
    }

    /// The column whose impacts have this direction of travel \[rad\], with its damage.
    fn towards(&self, direction: f64) -> PyResult<Self> {
        let changes = [("impact.direction", Value::from(direction))];
        let turned = self.parameters().with_changes(changes);
        let turned = turned.map_err(|faults| fault::parameters(&faults))?;
        let study = match self.is_damaged() {
            true => self.study.with_impact_of(&turned),
            false => StudyColumn::undamaged(&turned),
        };
        Ok(Self {
            study: Arc::new(study.map_err(|fault| fault::study(&fault))?),
            values: Arc::default(),
            ..self.clone()
        })
    }

    /// Name, value, unit and meaning of every parameter.
    fn describe<'py>(&self, py: Python<'py>) -> PyResult<Vec<Described<'py>>> {
        let rows = self.parameters().iter();
        rows.map(|(it, value)| {
            Ok((
                it.name.to_owned(),
                object(py, value)?,
                it.row.unit,
                it.row.meaning,
            ))
        })
        .collect()
    }

    /// The value of one parameter, of one that follows from others what it is; `None` if there is none of this name.
    fn get<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let values = self.values.get_or_init(|| {
            let all = self.parameters().effective_values();
            all.map(|(it, value)| (it.name.to_owned(), value)).collect()
        });
        let value = values.get(name).cloned();
        value.map(|value| object(py, value)).transpose()
    }

    /// What follows from the parameters: length of a step \[s\], `M^p` \[N m\], `N^p` \[N\], `EA` \[N\] and `EI` \[N m²\].
    fn derived(&self) -> [f64; 5] {
        let p = self.parameters().column_properties();
        [
            1e-9 * self.parameters().step_nanos() as f64,
            p.resistance_moment,
            p.resistance_axial,
            p.axial_rigidity,
            p.bending_stiffness,
        ]
    }

    /// One impact without its history.
    fn evaluate(
        &self,
        py: Python<'_>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
    ) -> PyResult<Evaluated> {
        if let Some(there) = self.struck_by(vehicle)? {
            return there.evaluate(py, vehicle, mass, velocity);
        }
        let impact = self.impact(py, vehicle, mass, velocity)?;
        let steps = self.parameters().response_duration() / self.study.model().step_secs;
        let evaluated = match steps > MANY_STEPS {
            true => {
                let this = self.clone();
                abandonable(py, move || this.study.evaluate(&impact))?
            }
            false => py.detach(|| self.study.evaluate(&impact)),
        };
        let evaluation = evaluated.map_err(|fault| fault::study(&fault))?;
        let row = Row::new(&impact, &evaluation);
        Ok((row.numbers, row.codes.0))
    }

    /// Many impacts without their histories, as rows of bytes. `masses` and `velocities` are arrays of doubles; without masses
    /// each vehicle has its own.
    fn evaluate_batch<'py>(
        &self,
        py: Python<'py>,
        vehicle: Option<&str>,
        masses: Option<PyBackedBytes>,
        velocities: PyBackedBytes,
        threads: Option<NonZeroUsize>,
    ) -> PyResult<Bound<'py, PyByteArray>> {
        if let Some(there) = self.struck_by(vehicle)? {
            return there.evaluate_batch(py, vehicle, masses, velocities, threads);
        }
        let arrays = Arrays { masses, velocities };
        let Some((mass, velocity)) = arrays.first() else {
            return PyByteArray::new_with(py, 0, |_| Ok(()));
        };
        let checks = self.checks(vehicle, mass, velocity)?;
        let fault_of = |mass, velocity| self.fault_of(vehicle, mass, velocity);
        evaluate(py, &self.study, (arrays, checks), fault_of, threads)
    }

    /// A map over two axes; see `_map.py`.
    fn map<'py>(
        &self,
        py: Python<'py>,
        request: MapRequest,
        shard: Option<[u64; 2]>,
    ) -> PyResult<Bound<'py, PyDict>> {
        study::map(py, (&self.study, self.is_damaged()), request, shard)
    }

    /// The boundaries of the actions on a map as JSON; see `_map.py`.
    fn refine(&self, py: Python<'_>, request: MapRequest) -> PyResult<String> {
        study::refine(py, (&self.study, self.is_damaged()), request)
    }

    /// What the sensors read in an impact, as a table in CSV.
    fn sensor_readings(
        &self,
        py: Python<'_>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
        seed: u64,
    ) -> PyResult<String> {
        self.expect_undamaged(
            "sensor_readings",
            "sensors are simulated on the undamaged column",
        )?;
        if let Some(there) = self.struck_by(vehicle)? {
            return there.sensor_readings(py, vehicle, mass, velocity, seed);
        }
        let impact = self.impact(py, vehicle, mass, velocity)?;
        sensors::readings(py, self.parameters(), impact, seed)
    }

    /// What struck the column by a table of readings, as JSON; `None` without an impact.
    fn estimate(&self, py: Python<'_>, table: String, seed: u64) -> PyResult<Option<String>> {
        self.expect_undamaged(
            "estimate",
            "the column is estimated as undamaged; a node estimates impacts on a damaged one",
        )?;
        sensors::estimate(py, self.parameters(), table, seed)
    }

    /// A risk study as JSON; see `_risk.py`.
    fn risk(&self, py: Python<'_>, request: Request) -> PyResult<String> {
        self.expect_undamaged("risk", "draw the impacts, and give them to evaluate_batch")?;
        risk(py, self.parameters(), &request)
    }

    /// The velocities around the critical one of each action, least severe first, and the number of responses.
    fn critical_velocities(
        &self,
        py: Python<'_>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        lowest: f64,
        highest: f64,
    ) -> PyResult<(Vec<Bracket>, usize)> {
        // A warning of the mass, which both have, is given once.
        self.impact(py, vehicle, mass, Some(lowest))?;
        let checks = self.checks(vehicle, mass, highest)?;
        if checks.impact(mass, highest).is_err() {
            return Err(fault::input(self.fault_of(vehicle, mass, highest)));
        }
        if lowest >= highest {
            return Err(fault::input(format!(
                "expected a lowest velocity below the highest; found {lowest} and {highest} m/s"
            )));
        }
        let (this, vehicle) = (self.clone(), vehicle.map(str::to_owned));
        let found = abandonable(py, move || {
            let study = &this.study;
            study.critical_velocities(vehicle.as_deref(), mass, [lowest, highest])
        })?;
        let found = found.map_err(|fault| fault::study(&fault))?;
        let brackets = found.velocities.into_iter().map(study::bracket);
        Ok((brackets.collect(), found.responses))
    }

    /// One impact with its history: names and values of its columns, and the outcome as JSON, with what the fibre beam says where the
    /// model of this name needs it.
    #[pyo3(signature = (vehicle, mass, velocity, model="bars"))]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
        model: &str,
    ) -> PyResult<(Vec<String>, Vec<Bound<'py, PyByteArray>>, String)> {
        if let Some(there) = self.struck_by(vehicle)? {
            return there.simulate(py, vehicle, mass, velocity, model);
        }
        let model = model_named(model)?;
        let switched_off = model.check_on(self.parameters());
        switched_off.map_err(|reason| fault::input(reason.to_string()))?;
        let impact = self.impact(py, vehicle, mass, velocity)?;
        let name = self.vehicle_name(vehicle);
        // The whole speed: of an oblique hit, `impact` has the component in the plane of the two bars.
        let whole = velocity.unwrap_or(self.parameters().settings().impact.velocity);
        let stated = self.with_impact(vehicle, mass, whole);
        let simulated = Simulated {
            study: Arc::clone(&self.study),
            hits: Arc::clone(&self.hits),
            beam_damage: Arc::clone(&self.beam_damage),
            stated: stated.unwrap_or_else(|_| self.parameters().clone()),
            impact,
            hit: self.whole_hit(vehicle, mass, velocity, None)?,
            vehicle_name: name,
            model,
        };
        let history = abandonable(py, move || simulated.history())??;
        let columns = history.columns.iter().map(|it| doubles(py, it));
        Ok((
            history.names,
            columns.collect::<PyResult<_>>()?,
            history.outcome,
        ))
    }

    /// The capacity of the column as it is as JSON, and its push-down.
    fn capacity<'py>(&self, py: Python<'py>) -> PyResult<(String, Curve<'py>)> {
        let this = self.clone();
        let (json, points) = abandonable(py, move || {
            let (model, rest) = (this.study.model(), this.study.rest());
            let remaining = ResidualCapacity::compute(this.parameters(), model, Some(rest));
            let remaining = remaining.map_err(|fault| fault::of_capacity(&fault))?;
            let input = AssessmentInput::of_state(this.parameters(), model, rest, remaining);
            let state = match this.is_damaged() {
                true => "damaged",
                false => "undamaged",
            };
            let json = capacity_json(state, &remaining, &input)?;
            Ok::<_, PyErr>((json, this.push_down(model, Some(rest))?))
        })??;
        Ok((json, curve(py, &points)?))
    }

    /// The capacity after one impact as JSON, and its push-down, which is empty if the column carries nothing.
    fn capacity_after<'py>(
        &self,
        py: Python<'py>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
    ) -> PyResult<(String, Curve<'py>)> {
        self.expect_undamaged(
            "capacity after an impact",
            "ask column.after(...).capacity()",
        )?;
        if let Some(there) = self.struck_by(vehicle)? {
            return there.capacity_after(py, vehicle, mass, velocity);
        }
        let impact = self.impact(py, vehicle, mass, velocity)?;
        let whole = velocity.unwrap_or(self.parameters().settings().impact.velocity);
        let this = self.clone();
        let (json, points) = abandonable(py, move || {
            let model = this.study.model();
            let properties = this.parameters().column_properties();
            let duration = this.parameters().response_duration();
            let (report, rest) = respond_and_rest(&properties, &impact, duration)
                .map_err(|fault| fault::of_simulation(&fault))?;
            let remaining = ResidualCapacity::compute(this.parameters(), model, rest.as_ref());
            let remaining = remaining.map_err(|fault| fault::of_capacity(&fault))?;
            let input =
                AssessmentInput::of_response(this.parameters(), model, &impact, &report, remaining);
            let state = format!("after {} kg at {whole} m/s", impact.mass);
            let json = capacity_json(&state, &remaining, &input)?;
            Ok::<_, PyErr>((json, this.push_down(model, rest.as_ref())?))
        })??;
        Ok((json, curve(py, &points)?))
    }
}

/// Most steps of a response that is followed without a look at the signals; they take about a tenth of a second.
const MANY_STEPS: f64 = 5e5;

impl From<StudyColumn> for Column {
    fn from(study: StudyColumn) -> Self {
        Self::after_hits(study, Vec::new())
    }
}

impl Column {
    fn of(parameters: &Parameters) -> PyResult<Self> {
        let study = StudyColumn::undamaged(parameters).map_err(|fault| fault::study(&fault))?;
        Ok(Self::from(study))
    }

    /// The column that these impacts have damaged.
    fn after_hits(study: StudyColumn, hits: Vec<EarlierHit>) -> Self {
        Self {
            study: Arc::new(study),
            hits: hits.into(),
            beam_damage: Arc::default(),
            values: Arc::default(),
        }
    }

    /// What only an undamaged column has, and what to do instead.
    fn expect_undamaged(&self, call: &str, instead: &str) -> PyResult<()> {
        match self.is_damaged() {
            false => Ok(()),
            true => Err(fault::input(format!(
                "{call}: expected an undamaged column, found one that an impact has damaged; {instead}"
            ))),
        }
    }

    /// The column where this vehicle strikes it; `None` where it is that already.
    fn struck_by(&self, vehicle: Option<&str>) -> PyResult<Option<Self>> {
        let struck = self.study.struck_by(vehicle);
        let struck = struck.map_err(|fault| fault::study(&fault))?;
        Ok(struck.map(|study| Self {
            study,
            values: Arc::default(),
            ..self.clone()
        }))
    }

    /// An impact with the whole speed of the vehicle, where it strikes this column. Without a direction \[rad\] it has that of the
    /// parameters.
    fn whole_hit(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
        direction: Option<f64>,
    ) -> PyResult<EarlierHit> {
        let velocity = velocity.unwrap_or(self.parameters().settings().impact.velocity);
        let impacts = self.study.impacts_of(vehicle);
        let impact = impacts.and_then(|it| it.in_direction(0.0).impact(mass, velocity));
        let properties = &self.study.model().properties;
        Ok(EarlierHit {
            lengths: [properties.length_below, properties.length_above],
            impact: impact.map_err(|fault| fault::study(&fault))?,
            direction: direction.unwrap_or(self.parameters().direction()),
        })
    }

    fn parameters(&self) -> &Parameters {
        self.study.parameters()
    }

    /// The impact, checked by the one table of parameters as on the command line; with a warning of a mass that nobody can have
    /// meant.
    fn impact(
        &self,
        py: Python<'_>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
    ) -> PyResult<Impact> {
        let velocity = velocity.unwrap_or_else(|| self.parameters().settings().impact.velocity);
        let checks = self.checks(vehicle, mass, velocity)?;
        let Ok(impact) = checks.impact(mass, velocity) else {
            return Err(fault::input(self.fault_of(vehicle, mass, velocity)));
        };
        if let Some(text) = checks.implausible(&impact) {
            fault::warn(py, &format!("impact.mass is the mass of {text}"))?;
        }
        Ok(impact)
    }

    /// Checks of the impacts of this vehicle. Of an unknown one all faults of the impact are told.
    fn checks(&self, vehicle: Option<&str>, mass: Option<f64>, velocity: f64) -> PyResult<Checks> {
        Checks::new(&self.study, vehicle, mass.is_some())
            .ok_or_else(|| fault::input(self.fault_of(vehicle, mass, velocity)))
    }

    /// What the table has against an impact, in its words; otherwise what the mechanics has.
    fn fault_of(&self, vehicle: Option<&str>, mass: Option<f64>, velocity: f64) -> String {
        if mass.is_some_and(f64::is_nan) {
            return "impact.mass: NaN is not a finite number; expected the total mass in kg, or no mass for the vehicle's own"
                .to_owned();
        }
        if let Err(faults) = self.with_impact(vehicle, mass, velocity) {
            return faults.to_string();
        }
        match self.study.impact(vehicle, mass, velocity) {
            Ok(impact) => impact.check().err().map(|fault| fault.to_string()),
            Err(fault) => Some(fault.to_string()),
        }
        .unwrap_or_else(|| "the impact is out of range".to_owned())
    }

    /// The parameters with this impact, as the command line has them.
    fn with_impact(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: f64,
    ) -> Result<Parameters, ParameterFaults> {
        let mut changes = vec![("impact.velocity", Value::from(velocity))];
        if let Some(name) = vehicle {
            changes.push(("vehicle.name", Value::from(name)));
        }
        let own_mass = vehicle.is_some_and(|name| CatalogueVehicle::named(name).is_some());
        if let Some(mass) = mass.or(own_mass.then_some(0.0)) {
            changes.push(("impact.mass", Value::from(mass)));
        }
        self.parameters().with_changes(changes)
    }

    /// The name of the vehicle as the catalogue spells it; empty if it is given by numbers.
    fn vehicle_name(&self, vehicle: Option<&str>) -> String {
        match vehicle.map(str::trim).filter(|name| !name.is_empty()) {
            None => self.parameters().settings().vehicle.name.clone(),
            Some(name) => match CatalogueVehicle::named(name) {
                Some(known) => known.name.clone(),
                None => column_twin::parameters::RIGID.to_owned(),
            },
        }
    }

    fn push_down(&self, model: &Model, state: Option<&State>) -> PyResult<Vec<PushDownPoint>> {
        let mut points = Vec::new();
        if let Some(state) = state {
            let bow = imperfection(self.parameters());
            push_down(model, state, bow, &mut |point| points.push(*point))
                .map_err(|fault| fault::of_capacity(&fault))?;
        }
        Ok(points)
    }
}
