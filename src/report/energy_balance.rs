//! Where the energy of an impact went.

use crate::column::Report;

/// One entry of the balance.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyEntry {
    /// What the energy is or does.
    pub name: String,
    /// Energy \[J\].
    pub energy: f64,
}

/// The energy balance at the end of a response.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyBalance {
    /// Where the energy is at the end.
    pub spent: Vec<EnergyEntry>,
    /// By the impactor \[J\].
    pub by_impactor: f64,
    /// By the load \[J\].
    pub by_load: f64,
}

impl EnergyBalance {
    /// The supplied energy \[J\].
    #[must_use]
    pub fn supplied(&self) -> f64 {
        self.by_impactor + self.by_load
    }

    /// The sum of the entries \[J\].
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.spent.iter().map(|entry| entry.energy).sum()
    }
}

impl From<&Report> for EnergyBalance {
    fn from(report: &Report) -> Self {
        let mut spent = Vec::new();
        let mut add = |name: &str, energy: f64| {
            spent.push(EnergyEntry {
                name: name.to_owned(),
                energy,
            });
        };
        add("plastic work in the hinges", report.plastic_work);
        let vehicle = &report.vehicle;
        for (index, dissipated) in vehicle.dissipated[..vehicle.masses].iter().enumerate() {
            match vehicle.masses {
                1 => add("crush of the vehicle", *dissipated),
                _ => add(&format!("crush of spring {}", index + 1), *dissipated),
            }
        }
        add("lost in impact impulses", report.impact_loss);
        add("damping", report.damping_work);
        add("kinetic energy of the column", report.column_kinetic_energy);
        add(
            "kinetic energy of the impactor",
            report.impactor_kinetic_energy,
        );
        if vehicle.masses > 0 {
            add("elastic energy of the vehicle", vehicle.elastic_energy);
        }
        add("change of the elastic energy", report.elastic_energy_change);
        Self {
            spent,
            by_impactor: report.input_energy,
            by_load: report.load_work,
        }
    }
}
