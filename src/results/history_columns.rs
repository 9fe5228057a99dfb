//! The columns of the history of one impact.

use crate::column::{
    BaseForces, HINGE_NAMES, HingeSample, HingeState, MAX_MASSES, Phase, Sample, VehicleSample,
    WEB_NAMES, WebSample,
};

type Column = (&'static str, fn(&Sample) -> f64);
type VehicleColumn = (
    &'static str,
    &'static str,
    fn(&VehicleSample) -> [f64; MAX_MASSES],
);
type WebColumn = (&'static str, &'static str, fn(&WebSample) -> f64);
type BaseColumn = (&'static str, fn(&BaseForces) -> f64);
type HingeColumn = (&'static str, &'static str, fn(&HingeSample) -> f64);

/// Columns of column and impactor, named as in `tests/data/heb220_ellipse.csv`. `Na` is the normal force of hinges 1a and
/// 3, `Nb` that of 1b and 2.
const COLUMNS: [Column; 24] = [
    ("t_s", |sample| sample.time),
    ("v1_m", |sample| sample.v1),
    ("u1_m", |sample| sample.u1),
    ("beta1_rad", |sample| sample.beta1),
    ("u2_m", |sample| sample.u2),
    ("vc_m", |sample| sample.impactor_position),
    ("v1dot_m_s", |sample| sample.v1_rate),
    ("u1dot_m_s", |sample| sample.u1_rate),
    ("u2dot_m_s", |sample| sample.u2_rate),
    ("vcdot_m_s", |sample| sample.impactor_velocity),
    ("gap_m", |sample| sample.gap),
    ("Na_N", |sample| sample.normal_forces()[0]),
    ("Nb_N", |sample| sample.normal_forces()[1]),
    ("contact_force_N", |sample| sample.contact_force),
    ("impact_impulse_Ns", |sample| sample.impact_impulse),
    ("impulse_Ns", |sample| sample.impulse),
    ("kinetic_energy_J", |sample| sample.kinetic_energy),
    ("elastic_energy_J", |sample| sample.elastic_energy),
    ("plastic_work_J", |sample| sample.plastic_work),
    ("impact_loss_J", |sample| sample.impact_loss),
    ("damping_work_J", |sample| sample.damping_work),
    ("load_work_J", |sample| sample.load_work),
    ("ledger_residual_J", |sample| sample.ledger_residual),
    ("in_contact", |sample| {
        f64::from(u8::from(sample.phase == Phase::Contact))
    }),
];

/// Columns of every hinge: text before its name, unit, and value.
const HINGE_COLUMNS: [HingeColumn; 8] = [
    ("M", "Nm", |hinge| hinge.moment),
    ("theta", "rad", |hinge| hinge.rotation),
    ("delta", "m", |hinge| hinge.elongation),
    ("theta_p", "rad", |hinge| hinge.plastic_rotation),
    ("delta_p", "m", |hinge| hinge.plastic_elongation),
    ("utilisation", "-", |hinge| hinge.utilisation),
    ("dynamic_factor", "-", |hinge| hinge.dynamic_factor),
    ("state", "-", |hinge| state_number(hinge.state)),
];

/// 0 elastic, 1 plastic, 2 unloaded.
fn state_number(state: HingeState) -> f64 {
    match state {
        HingeState::Elastic => 0.0,
        HingeState::Plastic => 1.0,
        HingeState::Unloaded => 2.0,
    }
}

/// Columns of the web of every bar: text before its name, unit, and value; 0 where the webs do not yield in shear.
const WEB_COLUMNS: [WebColumn; 5] = [
    ("V", "N", |web| web.shear_force),
    ("gamma_p", "rad", |web| web.plastic_angle),
    ("shear_utilisation", "-", |web| web.utilisation),
    ("shear_dynamic_factor", "-", |web| web.dynamic_factor),
    ("shear_state", "-", |web| state_number(web.state)),
];

/// Columns of what the column bears upon its base, with the inertia of the lower bar.
const BASE_COLUMNS: [BaseColumn; 3] = [
    ("base_shear_N", |base| base.shear),
    ("base_moment_Nm", |base| base.moment),
    ("base_normal_force_N", |base| base.normal_force),
];

/// Columns of every spring of a deformable vehicle and of the mass behind it, numbered from the front: text before the
/// number, unit, and values.
const VEHICLE_COLUMNS: [VehicleColumn; 5] = [
    ("crush", "m", |vehicle| vehicle.crush),
    ("permanent_crush", "m", |vehicle| vehicle.permanent_crush),
    ("crush_force", "N", |vehicle| vehicle.force),
    ("vehicle_dissipated", "J", |vehicle| vehicle.dissipated),
    ("vehicle_velocity", "m_s", |vehicle| vehicle.velocity),
];

/// The columns of a history: of column and impactor, of every hinge and web, of the base, and of a deformable vehicle. Their names carry the unit
/// and are a stable interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HistoryColumns {
    /// Masses of the vehicle, each with the spring in front of it; 0 for a rigid one.
    masses: usize,
}

impl HistoryColumns {
    /// The columns for a vehicle of so many masses, 0 for a rigid one; at most [`MAX_MASSES`].
    #[must_use]
    pub fn new(masses: usize) -> Self {
        Self {
            masses: masses.min(MAX_MASSES),
        }
    }

    /// Their names, each with its unit.
    #[must_use]
    pub fn names(self) -> Vec<String> {
        let mut names: Vec<String> = COLUMNS.iter().map(|(name, _)| (*name).to_owned()).collect();
        let named = |before: &str, unit: &str, name: &str| match unit {
            "-" => format!("{before}_{name}"),
            _ => format!("{before}{name}_{unit}"),
        };
        for (before, unit, _) in HINGE_COLUMNS {
            names.extend(HINGE_NAMES.map(|hinge| named(before, unit, hinge)));
        }
        for (before, unit, _) in WEB_COLUMNS {
            names.extend(WEB_NAMES.map(|web| named(before, unit, web)));
        }
        names.extend(BASE_COLUMNS.map(|(name, _)| name.to_owned()));
        for (before, unit, _) in VEHICLE_COLUMNS {
            names.extend((1..=self.masses).map(|number| format!("{before}{number}_{unit}")));
        }
        if self.masses > 0 {
            names.push("vehicle_elastic_energy_J".to_owned());
        }
        names
    }

    /// Gives the values of one sample to `take`, in the order of the names.
    pub fn values(self, sample: &Sample, mut take: impl FnMut(f64)) {
        for (_, value) in COLUMNS {
            take(value(sample));
        }
        for (_, _, value) in HINGE_COLUMNS {
            sample.hinges.iter().for_each(|hinge| take(value(hinge)));
        }
        for (_, _, value) in WEB_COLUMNS {
            sample.webs.iter().for_each(|web| take(value(web)));
        }
        for (_, value) in BASE_COLUMNS {
            take(value(&sample.base));
        }
        for (_, _, values) in VEHICLE_COLUMNS {
            let values = values(&sample.vehicle);
            values[..self.masses].iter().for_each(|value| take(*value));
        }
        if self.masses > 0 {
            take(sample.vehicle.elastic_energy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_one_value() {
        for masses in 0..=MAX_MASSES {
            let columns = HistoryColumns::new(masses);
            let names = columns.names();
            let mut values = 0;
            columns.values(&Sample::default(), |_| values += 1);
            assert_eq!(names.len(), values);
            let mut unique = names.clone();
            unique.sort();
            unique.dedup();
            assert_eq!(unique.len(), values);
        }
    }
}
