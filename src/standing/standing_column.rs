//! The column as an impact finds it: undamaged, or with the damage that earlier impacts have left.

use serde::{Deserialize, Serialize};

use super::impact_height::HEIGHT_TOLERANCE;
use super::impact_height::with_impact_height;
use crate::column::{ColumnProperties, carried_over, residual_state};
use crate::column::{Displacement, Model, PerBar, PerBarHinges, PlasticFlow, State, WebState};
use crate::parameters::Parameters;

/// A column at rest, as the next impact will find it. With the parameters it is everything on which the responses to
/// conceivable impacts depend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandingColumn {
    /// Height of hinges 1a and 1b, and with that of the impact, above the base \[m\].
    pub impact_height: f64,
    /// What earlier impacts have left; `None`: the column is undamaged.
    pub damage: Option<Damage>,
}

/// Damage of a column at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Damage {
    /// The static equilibrium under the load.
    pub displacement: Displacement,
    /// Plastic deformation of the hinges.
    pub plastic: PerBar<PlasticFlow>,
    /// Accumulated plastic rotations \[rad\], per bar: at the impact point, at the other end.
    pub accumulated_rotation: PerBarHinges,
    /// Hardening of the webs; `None` where no web has yielded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub webs: Option<PerBar<WebState>>,
}

impl StandingColumn {
    /// The undamaged column of these parameters.
    #[must_use]
    pub fn undamaged(parameters: &Parameters) -> Self {
        Self {
            impact_height: parameters.column_properties().length_below,
            damage: None,
        }
    }

    /// The column of this model in this state, which has to be at rest.
    #[must_use]
    pub fn new(model: &Model, state: &State) -> Self {
        let is_undamaged = state.plastic == PerBar::default();
        Self {
            impact_height: model.properties.length_below,
            damage: (!is_undamaged).then(|| Damage {
                displacement: state.displacement,
                plastic: state.plastic,
                accumulated_rotation: state.accumulated_rotation(),
                webs: state.sheared_webs(),
            }),
        }
    }

    /// The column in the equilibrium that it was in, by a model that has its hinges 1a and 1b where they are, and no bumper.
    pub(crate) fn settled(&self, model: &Model) -> State {
        let Some(damage) = &self.damage else {
            return State::at_rest(model);
        };
        let mut state = State::settled(model, damage.displacement, damage.plastic);
        state.set_accumulated_rotation(model, &damage.accumulated_rotation);
        if let Some(webs) = &damage.webs {
            state.set_webs(model, webs);
        }
        state
    }

    /// The properties of the column with these parameters, with its hinges 1a and 1b where they are.
    pub(crate) fn properties(&self, parameters: &Parameters) -> ColumnProperties {
        with_impact_height(&parameters.column_properties(), self.impact_height)
    }

    /// The column at rest, as a model of it says. The model may differ in its yield strength, on which the equilibrium of a
    /// column that does not flow does not depend.
    pub(crate) fn state(&self, model: &Model) -> State {
        if self.damage.is_none() {
            return State::at_rest(model);
        }
        let own = model.without_bumper();
        let state = self.settled(&own);
        if own.frame == model.frame {
            return state;
        }
        let carried = carried_over(&own, &state, model);
        residual_state(model, &carried).unwrap_or(carried)
    }

    /// Whether its hinges 1a and 1b can be there on the column of these parameters.
    #[must_use]
    pub fn fits(&self, parameters: &Parameters) -> bool {
        let p = parameters.column_properties();
        let height = p.length_below + p.length_above;
        (HEIGHT_TOLERANCE..=height - HEIGHT_TOLERANCE).contains(&self.impact_height)
    }
}
