//! Changes of parameters: applied between two steps, waiting for the end of a response, or refused, never half.

use std::sync::Arc;

use super::present::{equilibrium, is_damaged, same_height};
use crate::column::{ColumnProperties, Model, Scheme, State};
use crate::parameters::{Applies, Parameter, Parameters, Value};

/// What became of a change of parameters that was not refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// All parameters had these values already.
    Nothing,
    /// Applied.
    Applied,
    /// Valid, and applied when the present response is over.
    Waits,
}

/// A column in its equilibrium.
#[derive(Debug, Clone)]
pub(super) struct AtRest {
    pub model: Model,
    pub state: State,
}

/// What the column is made of, apart from what stands on it and how it is computed: a damage belongs to it.
pub(super) fn what_the_column_is(parameters: &Parameters) -> ColumnProperties {
    ColumnProperties {
        top_spring_stiffness: 0.0,
        top_mass: 0.0,
        top_load: 0.0,
        damping_ratio: 0.0,
        scheme: Scheme::ConservingMidpoint,
        step_nanos: 1,
        ..parameters.column_properties()
    }
}

/// `from` with some values changed, validated as a whole.
///
/// # Errors
/// All that is wrong, or which of them are read-only.
pub(super) fn validated(
    from: &Parameters,
    changes: &[(String, Value)],
) -> Result<Parameters, String> {
    let changed = from
        .with_changes(changes.iter().cloned())
        .map_err(|faults| faults.to_string())?;
    let fixed: Vec<_> = changed
        .changed_from(from)
        .into_iter()
        .filter(|parameter| parameter.applies == Applies::Restart)
        .map(|parameter| parameter.name)
        .collect();
    if fixed.is_empty() {
        return Ok(changed);
    }
    Err(format!(
        "{} cannot be changed while the node runs; restart it with the new value",
        fixed.join(", ")
    ))
}

/// Whether any of these parameters must wait for the end of a response.
pub(super) fn must_wait(changed: &[&'static Parameter]) -> bool {
    changed
        .iter()
        .any(|parameter| parameter.applies != Applies::AtOnce)
}

/// The column `present`, at rest, with other parameters.
///
/// # Errors
/// The new column does not stand, or is another one than that which is damaged.
pub(super) fn changed_column(
    present: &AtRest,
    from: &Parameters,
    to: &Parameters,
) -> Result<AtRest, String> {
    let mut properties = to.column_properties();
    if !is_damaged(&present.state) {
        let model = Model::new(&properties).map_err(|error| error.to_string())?;
        return Ok(AtRest {
            model,
            state: State::at_rest(&model),
        });
    }
    if what_the_column_is(from) != what_the_column_is(to) {
        return Err("the column is damaged, and its lengths, section, steel, resistances, hinges and supports belong to \
             its damage; reset the twin first (~/reset)"
            .to_owned());
    }
    move_joint(&mut properties, present.model.properties.length_below);
    let model = Model::new(&properties).map_err(|error| error.to_string())?;
    if same_statics(&model.properties, &present.model.properties) {
        return Ok(AtRest {
            model,
            state: present.state,
        });
    }
    match equilibrium(&model, &present.state) {
        Some(state) => Ok(AtRest { model, state }),
        None => Err("with these values the damaged column does not stand".to_owned()),
    }
}

/// Hinges 1a and 1b at the height of an earlier impact.
pub(super) fn move_joint(properties: &mut ColumnProperties, height: f64) {
    if !same_height(height, properties.length_below) {
        let whole = properties.length_below + properties.length_above;
        properties.length_below = height;
        properties.length_above = whole - height;
    }
}

/// Whether two columns of the same make have the same equilibria.
fn same_statics(a: &ColumnProperties, b: &ColumnProperties) -> bool {
    (a.top_spring_stiffness, a.top_load) == (b.top_spring_stiffness, b.top_load)
}

/// Changes that wait for the end of the response.
#[derive(Debug)]
pub(super) struct Waiting {
    pub parameters: Arc<Parameters>,
    /// Who asked last.
    pub source: Arc<str>,
}
