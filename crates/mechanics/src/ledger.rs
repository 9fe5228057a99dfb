//! Energy balance: kinetic + elastic (column and vehicle) + plastic work + impact loss + damping work + crush of the
//! vehicle - P u2 - F x_c is constant, with the transverse force `F` on the vehicle and the position `x_c` of its centre of mass.

use serde::{Deserialize, Serialize};

use super::vehicle::MAX_MASSES;

/// Energy dissipated since the event, and the constant of the balance \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Dissipated in the hinges and webs; the share of each web is in [`WebState::work`](super::WebState::work).
    pub plastic_work: f64,
    /// Lost in impact impulses.
    pub impact_loss: f64,
    /// Done against damping.
    pub damping_work: f64,
    /// Dissipated in each spring of a deformable vehicle, front first.
    pub vehicle_dissipated: [f64; MAX_MASSES],
    /// Kinetic energy of the impactor at the event.
    pub input: f64,
    /// Elastic energy at the event.
    pub initial_elastic: f64,
    /// `P u2 + F x_c` at the event.
    pub initial_load_work: f64,
    /// The constant of the balance.
    pub initial_total: f64,
}

/// The entries that follow from the state \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic energy of the column's masses.
    pub column_kinetic: f64,
    /// Kinetic energy of the impactor.
    pub impactor_kinetic: f64,
    /// Elastic energy of the hinges and of the top spring.
    pub elastic: f64,
    /// Elastic energy of the springs of a deformable vehicle.
    pub vehicle_elastic: f64,
    /// `P u2 + F x_c`: the load on the top, and the transverse force on the vehicle times the position of its centre of mass.
    pub load_work: f64,
}

impl Energies {
    /// Kinetic + elastic - load work \[J\].
    pub fn mechanical(&self) -> f64 {
        self.column_kinetic + self.impactor_kinetic + self.elastic + self.vehicle_elastic
            - self.load_work
    }
}

impl Ledger {
    /// A new ledger for a state that has just received an impactor of kinetic energy `input` \[J\].
    pub(crate) fn open(energies: &Energies, input: f64) -> Self {
        Self {
            input,
            initial_elastic: energies.elastic,
            initial_load_work: energies.load_work,
            initial_total: energies.mechanical(),
            ..Self::default()
        }
    }

    /// The error of the balance \[J\].
    pub fn residual(&self, energies: &Energies) -> f64 {
        let crushed: f64 = self.vehicle_dissipated.iter().sum();
        energies.mechanical() + self.plastic_work + self.impact_loss + self.damping_work + crushed
            - self.initial_total
    }
}
