//! A column for Python.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

use column_twin::assessment::{
    AssessmentInput, ImpactEvaluation, ResidualCapacity, assess, imperfection, observe_and_rest,
    respond_and_rest,
};
use column_twin::column::{Impact, Model, PushDownPoint, SimulationError, State, push_down};
use column_twin::parameters::{
    CatalogueVehicle, NodeName, Parameter, ParameterFaults, Parameters, Source, Value,
};
use column_twin::results::{CapacityFields, HistoryColumns, ImpactFields};
use column_twin::study::{BatchEnd, StudyColumn, StudyError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::batch::{NUMBERS, ROW_BYTES, Row, batch, interruptible};
use crate::fault;
use crate::risk::{Request, risk};
use crate::study::{self, GivenAxis};
use crate::values::{doubles, numbers, object, value};

/// The velocities below and at a critical one \[m/s\].
type Bracket = (Option<f64>, Option<f64>);

/// Names and values that change parameters.
type Changes<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// Numbers and codes of an evaluation, see `_evaluation.py`.
type Evaluated = ([f64; NUMBERS], [u8; 3]);

/// Name, value, unit and meaning of a parameter.
type Described<'py> = (String, Bound<'py, PyAny>, &'static str, &'static str);

/// Shortening, force and v1 of a push-down.
type Curve<'py> = [Bound<'py, PyByteArray>; 3];

/// A column that is prepared once for many impacts.
#[pyclass(frozen, module = "column_twin._native")]
pub struct Column {
    study: StudyColumn,
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

    /// The column that `to_json` has written.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let parameters: Parameters =
            serde_json::from_str(text).map_err(|fault| fault::input(fault.to_string()))?;
        Self::of(&parameters)
    }

    /// All parameters as JSON, which reads back to the last bit.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(self.parameters()).map_err(|fault| fault::input(fault.to_string()))
    }

    /// The column with other values.
    fn with_changes(&self, changes: Changes<'_>) -> PyResult<Self> {
        let changes: PyResult<Vec<_>> = changes
            .into_iter()
            .map(|(name, given)| {
                let given = value(&name, &given)?;
                Ok((name, given))
            })
            .collect();
        let changed = self.parameters().with_changes(changes?);
        Self::of(&changed.map_err(|faults| fault::parameters(&faults))?)
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

    /// The value of one parameter; `None` if there is none of this name.
    fn get<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.parameters().get(name);
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
        let impact = self.impact(vehicle, mass, velocity)?;
        let evaluated = py.detach(|| self.study.evaluate(&impact));
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
        masses: Option<&[u8]>,
        velocities: &[u8],
        threads: Option<NonZeroUsize>,
    ) -> PyResult<Bound<'py, PyByteArray>> {
        if let Some(there) = self.struck_by(vehicle)? {
            return there.evaluate_batch(py, vehicle, masses, velocities, threads);
        }
        let velocities = numbers(velocities);
        let masses = masses.map(numbers);
        let impacts: PyResult<Vec<Impact>> = velocities
            .iter()
            .enumerate()
            .map(|(index, velocity)| {
                let mass = masses.as_ref().map(|all| all[index]);
                self.checked_impact(vehicle, mass, *velocity)
                    .map_err(|text| fault::input(format!("element {index}: {text}")))
            })
            .collect();
        let impacts = impacts?;
        let batch = batch(py, threads, impacts.len() as u64)?;
        let mut rows: Vec<Row> = Vec::with_capacity(impacts.len());
        let end = interruptible(py, &batch, |batch| {
            batch.run(
                impacts.len() as u64,
                |index| self.study.evaluate(&impacts[index as usize]),
                |results| -> Result<(), BatchFault> {
                    for result in results {
                        let index = rows.len();
                        let evaluation =
                            result.map_err(|fault| BatchFault::Impact(index, fault))?;
                        rows.push(Row::new(&impacts[index], &evaluation));
                    }
                    Ok(())
                },
            )
        })?;
        match end {
            Ok(BatchEnd::Complete) => {}
            Ok(BatchEnd::Interrupted(done)) => {
                return Err(fault::simulation(format!(
                    "the batch was interrupted after {done} impacts"
                )));
            }
            Err(BatchFault::Impact(index, reason)) => {
                let (mass, velocity) = (impacts[index].mass, impacts[index].velocity);
                return Err(fault::simulation(format!(
                    "element {index} ({mass} kg at {velocity} m/s): {reason}"
                )));
            }
            Err(BatchFault::Threads(reason)) => {
                return Err(fault::no_threads(&reason));
            }
        }
        PyByteArray::new_with(py, ROW_BYTES * rows.len(), |bytes| {
            let (chunks, _) = bytes.as_chunks_mut::<ROW_BYTES>();
            chunks
                .iter_mut()
                .zip(&rows)
                .for_each(|(chunk, row)| row.write(chunk));
            Ok(())
        })
    }

    /// A map over two axes; see `_map.py`.
    fn map<'py>(
        &self,
        py: Python<'py>,
        vehicle: Option<&str>,
        axes: [GivenAxis; 2],
        compared: Option<GivenAxis>,
        threads: Option<NonZeroUsize>,
    ) -> PyResult<Bound<'py, PyDict>> {
        study::map(py, self.parameters(), vehicle, axes, compared, threads)
    }

    /// A risk study as JSON; see `_risk.py`.
    fn risk(&self, py: Python<'_>, request: Request) -> PyResult<String> {
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
        for velocity in [lowest, highest] {
            self.impact(vehicle, mass, Some(velocity))?;
        }
        if lowest >= highest {
            return Err(fault::input(format!(
                "expected a lowest velocity below the highest; found {lowest} and {highest} m/s"
            )));
        }
        let found = py.detach(|| {
            self.study
                .critical_velocities(vehicle, mass, [lowest, highest])
        });
        let found = found.map_err(|fault| fault::study(&fault))?;
        let brackets = found.velocities.into_iter().map(study::bracket);
        Ok((brackets.collect(), found.responses))
    }

    /// One impact with its history: names and values of its columns, and the outcome as JSON.
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
    ) -> PyResult<(Vec<String>, Vec<Bound<'py, PyByteArray>>, String)> {
        if let Some(there) = self.struck_by(vehicle)? {
            return there.simulate(py, vehicle, mass, velocity);
        }
        let impact = self.impact(vehicle, mass, velocity)?;
        let name = self.vehicle_name(vehicle);
        let stated = self.with_impact(vehicle, mass, impact.velocity);
        let stated = stated.unwrap_or_else(|_| self.parameters().clone());
        let history = py
            .detach(|| self.history(&stated, &impact, &name))
            .map_err(|fault| fault::of_simulation(&fault))?;
        let columns = history.columns.iter().map(|it| doubles(py, it));
        Ok((
            history.names,
            columns.collect::<PyResult<_>>()?,
            history.outcome,
        ))
    }

    /// The capacity of the undamaged column as JSON, and its push-down.
    fn capacity<'py>(&self, py: Python<'py>) -> PyResult<(String, Curve<'py>)> {
        let computed = py.detach(|| {
            let model = self.model()?;
            let undamaged = State::at_rest(&model);
            let remaining = ResidualCapacity::compute(self.parameters(), &model, Some(&undamaged));
            let remaining = remaining.map_err(|fault| fault::of_capacity(&fault))?;
            let input = AssessmentInput::of_state(self.parameters(), &model, &undamaged, remaining);
            let json = capacity_json("undamaged", &remaining, &input)?;
            Ok::<_, PyErr>((json, self.push_down(&model, Some(&undamaged))?))
        });
        let (json, points) = computed?;
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
        if let Some(there) = self.struck_by(vehicle)? {
            return there.capacity_after(py, vehicle, mass, velocity);
        }
        let impact = self.impact(vehicle, mass, velocity)?;
        let computed = py.detach(|| {
            let model = self.model()?;
            let properties = self.parameters().column_properties();
            let duration = self.parameters().response_duration();
            let (report, rest) = respond_and_rest(&properties, &impact, duration)
                .map_err(|fault| fault::of_simulation(&fault))?;
            let remaining = ResidualCapacity::compute(self.parameters(), &model, rest.as_ref());
            let remaining = remaining.map_err(|fault| fault::of_capacity(&fault))?;
            let input = AssessmentInput::of_response(
                self.parameters(),
                &model,
                &impact,
                &report,
                remaining,
            );
            let state = format!("after {} kg at {} m/s", impact.mass, impact.velocity);
            let json = capacity_json(&state, &remaining, &input)?;
            Ok::<_, PyErr>((json, self.push_down(&model, rest.as_ref())?))
        });
        let (json, points) = computed?;
        Ok((json, curve(py, &points)?))
    }
}

/// One impact with its history.
struct History {
    /// Names of the columns.
    names: Vec<String>,
    /// Values of the columns, one per step.
    columns: Vec<Vec<f64>>,
    /// The outcome as JSON.
    outcome: String,
}

/// Why a batch ended early.
enum BatchFault {
    Impact(usize, StudyError),
    Threads(rayon::ThreadPoolBuildError),
}

impl From<rayon::ThreadPoolBuildError> for BatchFault {
    fn from(reason: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(reason)
    }
}

impl Column {
    fn of(parameters: &Parameters) -> PyResult<Self> {
        let study = StudyColumn::undamaged(parameters).map_err(|fault| fault::study(&fault))?;
        Ok(Self { study })
    }

    /// The column where this vehicle strikes it; `None` where it is that already.
    fn struck_by(&self, vehicle: Option<&str>) -> PyResult<Option<Self>> {
        let struck = self.study.struck_by(vehicle);
        let struck = struck.map_err(|fault| fault::study(&fault))?;
        Ok(struck.map(|there| Self {
            study: StudyColumn::clone(&there),
        }))
    }

    fn parameters(&self) -> &Parameters {
        self.study.parameters()
    }

    fn model(&self) -> PyResult<Model> {
        let model = Model::new(&self.parameters().column_properties());
        model.map_err(|fault| fault::of_simulation(&SimulationError::from(fault)))
    }

    /// The impact, checked by the one table of parameters as on the command line.
    fn impact(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: Option<f64>,
    ) -> PyResult<Impact> {
        let velocity = velocity.unwrap_or_else(|| self.parameters().settings().impact.velocity);
        self.checked_impact(vehicle, mass, velocity)
            .map_err(fault::input)
    }

    fn checked_impact(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: f64,
    ) -> Result<Impact, String> {
        let in_range = admits("impact.velocity", velocity)
            && mass.is_none_or(|mass| admits("impact.mass", mass));
        let fault = if in_range {
            match self.study.impact(vehicle, mass, velocity) {
                Ok(impact) if impact.check().is_ok() => return Ok(impact),
                Ok(impact) => impact.check().err().map(|fault| fault.to_string()),
                Err(fault) => Some(fault.to_string()),
            }
        } else {
            None
        };
        // What the table has against it, in its words; otherwise what the mechanics has.
        match self.with_impact(vehicle, mass, velocity) {
            Err(faults) => Err(faults.to_string()),
            Ok(_) => Err(fault.unwrap_or_else(|| "the impact is out of range".to_owned())),
        }
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

    /// `stated` are the parameters with the impact.
    fn history(
        &self,
        stated: &Parameters,
        impact: &Impact,
        vehicle_name: &str,
    ) -> Result<History, SimulationError> {
        let parameters = self.parameters();
        let properties = parameters.column_properties();
        let masses = impact.vehicle.map_or(0, |it| it.masses().len());
        let table = HistoryColumns::new(masses);
        let names = table.names();
        let mut columns = vec![Vec::new(); names.len()];
        let start = Instant::now();
        let ended = observe_and_rest(
            &properties,
            impact,
            parameters.response_duration(),
            |model, state| {
                let mut column = columns.iter_mut();
                table.values(&state.sample(model), |value| {
                    if let Some(column) = column.next() {
                        column.push(value);
                    }
                });
            },
        )?;
        let solve_time = start.elapsed();
        let evaluation = ImpactEvaluation::complete(stated, &properties, impact, ended)?;
        let fields = ImpactFields::of(&evaluation, vehicle_name, solve_time);
        Ok(History {
            outcome: serde_json::to_string(&fields).expect("numbers and words"),
            names,
            columns,
        })
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

/// Whether the table of parameters admits the number.
fn admits(name: &str, number: f64) -> bool {
    Parameter::named(name).is_some_and(|it| it.check(&Value::Double(number)).is_ok())
}

fn capacity_json(
    state: &str,
    remaining: &ResidualCapacity,
    input: &AssessmentInput,
) -> PyResult<String> {
    let assessment = assess(input);
    serde_json::to_string(&CapacityFields::of(state, remaining, &assessment))
        .map_err(|fault| fault::simulation(fault.to_string()))
}

fn curve<'py>(py: Python<'py>, points: &[PushDownPoint]) -> PyResult<Curve<'py>> {
    let column = |value: fn(&PushDownPoint) -> f64| {
        let values: Vec<f64> = points.iter().map(value).collect();
        doubles(py, &values)
    };
    Ok([
        column(|point| point.shortening)?,
        column(|point| point.force)?,
        column(|point| point.v1)?,
    ])
}
