//! The column as it is, and what happens when something hits it.

use std::sync::Arc;

use super::look_ahead::{LookAhead, Outlook};
use crate::column::{
    ColumnProperties, Impact, Model, Phase, Report, Response, State, residual_state,
};
use crate::parameters::{Parameter, Parameters, Value};

/// Heights that differ by less than this are the same hinges \[m\].
pub const HEIGHT_TOLERANCE: f64 = 1e-3;

/// What hits the column: the part of an event that the mechanics needs. `None` takes the parameter's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blow {
    /// \[kg\], > 0.
    pub mass: f64,
    /// Speed of the vehicle towards the column, over the ground; the closing speed on a column at rest
    /// \[m/s\], > 0.
    pub velocity: f64,
    /// Distance to the column \[m\], >= 0.
    pub gap: Option<f64>,
    /// Newton's coefficient of restitution, 0 to 1.
    pub restitution: Option<f64>,
    /// Above the base \[m\].
    pub height: Option<f64>,
}

/// Whether the column can take an impact.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    /// It stands.
    Standing,
    /// It has collapsed.
    Collapsed,
    /// It cannot be computed any further, for this reason.
    Faulted(Arc<str>),
}

/// The column as it is at one instant, all that a what-if needs: at rest with its damage, or in motion.
#[derive(Debug, Clone)]
pub struct Present {
    pub(super) column_id: Arc<str>,
    pub(super) parameters: Arc<Parameters>,
    pub(super) model: Model,
    pub(super) state: State,
    pub(super) condition: Condition,
}

/// A forecast of an impact that has not happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// What it would do.
    pub report: Report,
    /// What computing it took \[s\].
    pub compute_time: f64,
}

/// A column that has just been hit.
#[derive(Debug, Clone)]
pub(super) struct Met {
    pub model: Model,
    pub state: State,
    pub response: Response,
}

impl Present {
    /// What a blow would do to the column. Runs in the caller's thread and touches nothing. `column_id` empty means
    /// this column; `stopwatch` tells monotonic nanoseconds.
    ///
    /// # Errors
    /// Why the blow would be refused, or could not be followed to its end.
    pub fn predict(
        &self,
        column_id: &str,
        blow: &Blow,
        stopwatch: &dyn Fn() -> u64,
    ) -> Result<Prediction, String> {
        if !column_id.is_empty() {
            self.check_column(column_id)?;
        }
        let impact = self.impact_of(blow)?;
        let mut ahead = LookAhead::new(self.meet(impact, blow.height)?);
        match ahead.run(u64::MAX, stopwatch) {
            Outlook::Over { report, .. } => Ok(Prediction {
                report,
                compute_time: ahead.compute_time(),
            }),
            Outlook::Failed(reason) => Err(reason),
            Outlook::Running => Err("the look ahead was broken off".to_owned()),
        }
    }

    /// # Errors
    /// Another column is meant.
    pub(super) fn check_column(&self, column_id: &str) -> Result<(), String> {
        if *column_id == *self.column_id {
            return Ok(());
        }
        let found = super::impacts::shortened(column_id);
        Err(format!(
            "column_id is \"{found}\"; this twin is of column \"{}\"",
            self.column_id
        ))
    }

    /// The blow with what it leaves open taken from the parameters, every number checked against the one table.
    ///
    /// # Errors
    /// All numbers that are not finite or out of their range.
    pub(super) fn impact_of(&self, blow: &Blow) -> Result<Impact, String> {
        let otherwise = self.parameters.impact();
        let impact = Impact {
            mass: blow.mass,
            velocity: blow.velocity,
            gap: blow.gap.unwrap_or(otherwise.gap),
            restitution: blow.restitution.unwrap_or(otherwise.restitution),
        };
        let faults: Vec<_> = [
            fault_of("mass", "impact.mass", impact.mass),
            fault_of("velocity", "impact.velocity", impact.velocity),
            fault_of("gap", "impact.gap", impact.gap),
            fault_of("restitution", "impact.restitution", impact.restitution),
        ]
        .into_iter()
        .flatten()
        .collect();
        if faults.is_empty() {
            Ok(impact)
        } else {
            Err(faults.join("; "))
        }
    }

    /// Hits a copy of the column.
    ///
    /// # Errors
    /// The column cannot take an impact, or not at this height.
    pub(super) fn meet(&self, impact: Impact, height: Option<f64>) -> Result<Met, String> {
        match &self.condition {
            Condition::Standing => {}
            Condition::Collapsed => {
                return Err("the column has collapsed; reset the twin first (~/reset)".to_owned());
            }
            Condition::Faulted(reason) => {
                return Err(format!(
                    "the twin cannot go on ({reason}); reset it first (~/reset)"
                ));
            }
        }
        let (model, mut state) = self.at_height(height)?;
        let duration = self.parameters.response_duration();
        let response = Response::begin(&model, &mut state, impact, duration)
            .map_err(|error| error.to_string())?;
        Ok(Met {
            model,
            state,
            response,
        })
    }

    /// The column with its hinges 1a and 1b at the height of an impact.
    fn at_height(&self, height: Option<f64>) -> Result<(Model, State), String> {
        let present = self.model.properties.length_below;
        let properties = self.properties_for(height)?;
        let wanted = properties.length_below;
        if same_height(wanted, present) {
            return Ok((self.model, self.state));
        }
        let refused = |why: &str| {
            Err(format!(
                "the impact is at {wanted} m above the base and hinges 1a and 1b are at {present} m, {why}"
            ))
        };
        if self.state.sample(&self.model).phase != Phase::Idle {
            return refused("where they stay while the column responds to an impact");
        }
        if is_joint_damaged(&self.state) {
            return refused(
                "where they are damaged; send impacts at that height, or reset the twin (~/reset)",
            );
        }
        let model = Model::new(&properties).map_err(|error| error.to_string())?;
        let mut state = State::at_rest(&model);
        if is_damaged(&self.state) {
            state.plastic = self.state.plastic;
            match equilibrium(&model, &state) {
                Some(residual) => state = residual,
                None => return refused("and with them moved the damaged column does not stand"),
            }
        }
        Ok((model, state))
    }

    fn properties_for(&self, height: Option<f64>) -> Result<ColumnProperties, String> {
        let mut properties = self.parameters.column_properties();
        let Some(height) = height.filter(|it| !same_height(*it, properties.length_below)) else {
            return Ok(properties);
        };
        let whole = properties.length_below + properties.length_above;
        let faults = [
            fault_of("height", "geometry.length_below", height),
            fault_of(
                "what is left of the column above it",
                "geometry.length_above",
                whole - height,
            ),
        ];
        if let Some(fault) = faults.into_iter().flatten().next() {
            return Err(format!("{fault}; the column is {whole} m high"));
        }
        properties.length_below = height;
        properties.length_above = whole - height;
        Ok(properties)
    }
}

/// Whether two heights mean the same hinges; false where one is not a number.
pub(super) fn same_height(a: f64, b: f64) -> bool {
    (a - b).abs() < HEIGHT_TOLERANCE
}

/// Whether a hinge at the impact point has flowed.
fn is_joint_damaged(state: &State) -> bool {
    state.plastic.below.has_flowed(0) || state.plastic.above.has_flowed(0)
}

/// Whether any hinge has flowed.
pub(super) fn is_damaged(state: &State) -> bool {
    is_joint_damaged(state)
        || state.plastic.below.has_flowed(1)
        || state.plastic.above.has_flowed(1)
}

/// The equilibrium of a damaged column under another load, or with its joint elsewhere, if it can stand there without
/// yielding any further.
pub(super) fn equilibrium(model: &Model, state: &State) -> Option<State> {
    const ROUND_OFF: f64 = 1e-9;
    let residual = residual_state(model, state)?;
    let hinges = residual.sample(model).hinges;
    hinges
        .iter()
        .all(|hinge| hinge.utilisation <= 1.0 + ROUND_OFF)
        .then_some(residual)
}

/// What is wrong with a number that has the range of the parameter `name`.
fn fault_of(called: &str, name: &str, number: f64) -> Option<String> {
    let problem = Parameter::named(name)?
        .check(&Value::Double(number))
        .err()?;
    Some(format!("{called} = {number}: {problem}"))
}
