//! Where the energy is: kinetic + elastic + plastic work + impact loss + damping work - P u2 is constant.

use serde::{Deserialize, Serialize};

use super::assembly;
use super::model::Model;
use super::state::State;

/// What has been dissipated since the event, and what the sum was then \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Dissipated in the hinges.
    pub plastic_work: f64,
    /// Lost in percussions.
    pub impact_loss: f64,
    /// Done against damping.
    pub damping_work: f64,
    /// Kinetic energy that the impactor brought.
    pub input: f64,
    /// Elastic energy at the event.
    pub initial_elastic: f64,
    /// `P u2` at the event.
    pub initial_load_work: f64,
    /// The constant that the sum is held to.
    pub initial_total: f64,
}

/// The entries that follow from the state \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic energy of the column's masses.
    pub column_kinetic: f64,
    /// Kinetic energy of the impactor.
    pub impactor_kinetic: f64,
    /// Elastic energy of hinges and top spring.
    pub elastic: f64,
    /// `P u2`.
    pub load_work: f64,
}

impl Energies {
    /// Kinetic + elastic - load work \[J\].
    pub fn mechanical(&self) -> f64 {
        self.column_kinetic + self.impactor_kinetic + self.elastic - self.load_work
    }
}

impl Ledger {
    /// A fresh ledger for a state that an impactor of kinetic energy `input` \[J\] has just been given to.
    pub(crate) fn open(energies: &Energies, input: f64) -> Self {
        Self {
            input,
            initial_elastic: energies.elastic,
            initial_load_work: energies.load_work,
            initial_total: energies.mechanical(),
            ..Self::default()
        }
    }

    /// What the ledger fails to close by \[J\].
    pub fn residual(&self, energies: &Energies) -> f64 {
        energies.mechanical() + self.plastic_work + self.impact_loss + self.damping_work
            - self.initial_total
    }
}

/// The energies of a state.
pub fn energies(model: &Model, state: &State) -> Energies {
    let u = &state.displacement;
    let chords = assembly::chords(model, u);
    let strains = assembly::elastic_strains(&chords, u, &state.plastic);
    let spring = model.properties.top_spring_stiffness;
    let velocity = &state.velocity;
    let square = |x: f64| x * x;
    Energies {
        column_kinetic: 0.5
            * (model.impact_point_mass * (square(velocity.v1) + square(velocity.u1))
                + model.properties.top_mass * square(velocity.u2)),
        impactor_kinetic: state.impactor.map_or(0.0, |i| i.kinetic_energy()),
        elastic: model.below.elastic_energy(&strains.below)
            + model.above.elastic_energy(&strains.above)
            + 0.5 * spring * square(u.u2),
        load_work: model.properties.top_load * u.u2,
    }
}
