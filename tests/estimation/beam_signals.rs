//! Signals that the fibre beam makes: impacts on a column whose truth is known, by another model than that of the estimator.

use std::path::Path;

use column_beam::{
    BeamColumn, BeamError, BowAxes, History, Instrument, Sampling, Shape, Steel, Torsion, history,
};
use column_twin::column::{CrushCurve, CrushSpring, Impact, RolledSection, Support, Vehicle};
use column_twin::estimation::{Readings, with_sensor_errors};
use column_twin::parameters::{Parameters, parse_override};
use column_twin::sensors::{Quantity, Sensor};

use super::signals::{PERIOD, industrial};

/// Lengths below and above the impact point \[m\].
const LENGTHS: [f64; 2] = [0.8, 3.2];

/// Times before and after contact \[s\].
pub const BEFORE: f64 = 0.05;
pub const AFTER: f64 = 0.35;

/// Steps of the beam between two samples.
const STEPS: u32 = 5;

/// A made impact with its truth.
pub struct BeamSignal {
    pub impact: Impact,
    pub truth: History,
}

pub fn spring(points: &[[f64; 2]]) -> CrushSpring {
    let envelope = CrushCurve::new(points).expect("a curve");
    CrushSpring {
        unloading_stiffness: envelope.steepest_slope(),
        envelope,
        slack: 0.0,
    }
}

pub fn deformable(masses: &[f64], springs: &[CrushSpring], velocity: f64) -> Impact {
    let vehicle = Vehicle::new(masses, springs).expect("a vehicle");
    Impact {
        vehicle: Some(vehicle),
        ..Impact::rigid(vehicle.total_mass(), velocity)
    }
}

/// A front with a stiffness \[N/m\] up to a force \[N\] that then stays.
pub fn plateau(stiffness: f64, force: f64) -> CrushSpring {
    spring(&[[force / stiffness, force], [10.0, force]])
}

/// Impacts by name. Those that begin with `held` were kept aside while the estimator was changed.
pub fn impact(name: &str) -> Impact {
    match name {
        "light_rigid_12" => Impact::rigid(250.0, 12.0),
        "light_rigid_2" => Impact::rigid(300.0, 2.0),
        "two_mass_car_16" => deformable(
            &[150.0, 1100.0],
            &[spring(&[[1.0, 2e9]]), plateau(1.2e6, 220e3)],
            16.0,
        ),
        "crush_car_15" => deformable(&[1300.0], &[plateau(1.0e6, 260e3)], 15.0),
        "crush_lorry_8" => deformable(&[20e3], &[plateau(2.5e6, 560e3)], 8.0),
        "forklift_2" => deformable(&[4000.0], &[spring(&[[1.0, 3e6]])], 2.0),
        "stiffening_car_9" => {
            let front = spring(&[[0.2, 40e3], [0.5, 100e3], [0.8, 400e3]]);
            deformable(&[2500.0], &[front], 9.0)
        }
        "folding_lorry_9" => {
            let front = spring(&[[0.1, 300e3], [0.25, 60e3], [0.4, 700e3]]);
            deformable(&[9000.0], &[front], 9.0)
        }
        "strong_lorry_16" => deformable(&[18e3], &[plateau(3e6, 900e3)], 16.0),
        "holding_lorry_15" => deformable(&[20e3], &[plateau(3e6, 830e3)], 15.0),
        "leaving_lorry_12" => deformable(&[8200.0], &[plateau(3e6, 868e3)], 12.4),
        "crushed_lorry_14" => deformable(&[12e3], &[plateau(3e6, 850e3)], 14.0),
        "held_light_rigid_9" => Impact::rigid(400.0, 9.0),
        "held_light_rigid_1" => Impact::rigid(500.0, 1.2),
        "held_two_mass_car_11" => deformable(
            &[250.0, 1300.0],
            &[spring(&[[1.0, 2e8]]), plateau(0.8e6, 180e3)],
            11.0,
        ),
        "held_crush_car_10" => deformable(&[1900.0], &[plateau(1.5e6, 200e3)], 10.0),
        "held_crush_lorry_6" => deformable(&[12e3], &[plateau(4e6, 610e3)], 6.0),
        "held_forklift_3" => deformable(&[2500.0], &[spring(&[[1.0, 2e6]])], 3.0),
        _ => panic!("no impact {name}"),
    }
}

/// The column as the estimator knows it: without shear, hardening and a limit of rotation, which the beam does not have.
pub fn parameters() -> Parameters {
    let overrides = [
        format!("geometry.length_below:={:?}", LENGTHS[0]),
        format!("geometry.length_above:={:?}", LENGTHS[1]),
        "top.spring_stiffness:=1e7".to_owned(),
        "shear.model:=none".to_owned(),
        "hardening.ratio:=0.0".to_owned(),
        "softening.model:=none".to_owned(),
        "assessment.ultimate_rotation:=0.0".to_owned(),
    ];
    let overrides: Vec<_> = overrides.iter().map(|text| parse_override(text)).collect();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    Parameters::load(&[file], &overrides).expect("parameters")
}

/// HEB 220 of S355 with 500 kN.
pub fn column() -> BeamColumn {
    BeamColumn {
        shape: Shape::Rolled(RolledSection {
            depth: 0.220,
            width: 0.220,
            web_thickness: 9.5e-3,
            flange_thickness: 16e-3,
            root_radius: 18e-3,
        }),
        steel: Steel {
            young_modulus: 210e9,
            poisson_ratio: 0.3,
            yield_strength: 355e6,
            hardening_ratio: 1e-4,
            density: 7850.0,
            tensile_strength: None,
        },
        length_below: LENGTHS[0],
        length_above: LENGTHS[1],
        base: Support::BuiltIn,
        top: Support::BuiltIn,
        top_spring_stiffness: 1e7,
        top_mass: 0.0,
        top_load: 500e3,
        rate: None,
        shear: false,
        max_shear_hardening: 0.0,
        torsion: Torsion::SaintVenant,
        torsion_constant: None,
        residual_stress: false,
        bow: 0.0,
        bow_axes: BowAxes::Both,
        bumper_height: 0.0,
        elements: 0,
        fibres: 0,
        step_nanos: 0,
    }
}

/// Acceleration at three quarters of the height, displacement at the impact, bending strain 0.1 depths above the base and at
/// half the height.
pub fn sensors() -> Vec<Sensor> {
    let all = industrial(LENGTHS[0], LENGTHS[0] + LENGTHS[1]);
    [2, 3, 4, 5].map(|k: usize| all[k].clone()).to_vec()
}

impl BeamSignal {
    /// What these sensors read of an impact with this name, and for this time after contact \[s\], without errors.
    pub fn make(name: &str, sensors: &[Sensor], after: f64) -> Self {
        Self::of(&column(), impact(name), sensors, after).expect("a response")
    }

    /// The same of any impact on a column.
    pub fn of(
        column: &BeamColumn,
        impact: Impact,
        sensors: &[Sensor],
        after: f64,
    ) -> Result<Self, BeamError> {
        let instruments: Vec<Instrument> = sensors
            .iter()
            .map(|sensor| match sensor.quantity {
                Quantity::Displacement => Instrument::Displacement(sensor.height),
                Quantity::Acceleration => Instrument::Acceleration(sensor.height),
                Quantity::BendingStrain => Instrument::BendingStrain(sensor.height),
                other => panic!("no instrument for {other:?}"),
            })
            .collect();
        let sampling = Sampling {
            period: PERIOD,
            steps: STEPS,
            samples: (after / PERIOD).round() as usize,
        };
        let truth = history(column, &impact, &instruments, &sampling)?;
        Ok(Self { impact, truth })
    }

    /// Momentum of the vehicle \[N s\].
    pub fn momentum(&self) -> f64 {
        self.impact.mass * self.impact.velocity
    }

    /// The readings with the errors of the sensors by this seed, `before` \[s\] of them before contact.
    pub fn readings(&self, sensors: &[Sensor], before: f64, seed: u64) -> Readings {
        let still = (before / PERIOD).round() as usize;
        let mut exact = Readings {
            sensors: sensors.len(),
            ..Readings::default()
        };
        for row in 0..still + self.truth.rows.len() {
            exact.times.push(row as f64 * PERIOD);
            match row.checked_sub(still + 1) {
                Some(row) => exact.values.extend(&self.truth.rows[row]),
                None => exact.values.extend(vec![0.0; sensors.len()]),
            }
        }
        with_sensor_errors(&exact, sensors, seed)
    }
}
