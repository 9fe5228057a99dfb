//! What may have struck the column, before anything is measured.

use crate::column::{CrushCurve, CrushSpring, Impact, Vehicle};
use crate::parameters::{Parameters, vehicle_catalogue};

/// Unknowns of a hypothesis: the logarithms of mass, velocity, factor of the front, factor of the yield strength.
pub(crate) const UNKNOWNS: usize = 4;

/// Velocities that are considered \[m/s\].
const VELOCITY_RANGE: [f64; 2] = [0.2, 45.0];

/// Least mass that is considered \[kg\].
const LEAST_MASS: f64 = 30.0;

/// Median of the velocity \[m/s\] and standard deviation of its logarithm: wide \[A\].
const VELOCITY: [f64; 2] = [7.0, 0.8];

/// Standard deviation of the logarithm of the yield strength \[A\], about the given one.
const YIELD_SCATTER: f64 = 0.05;

/// Scatter of a factor that has none: the density needs a width.
const NO_SCATTER: f64 = 1e-3;

/// Median stiffness of an elastic front \[N/m\] and standard deviation of its logarithm (JCSS Probabilistic Model Code, 2.18:
/// 300 kN/m with a standard deviation of 60 kN/m \[T\]).
const JCSS_STIFFNESS: [f64; 2] = [300e3, 0.2];

/// The same for a vehicle of which nothing is known \[A\].
const ANY_STIFFNESS: [f64; 2] = [600e3, 1.0];

/// What the front of a vehicle does.
#[derive(Debug, Clone, PartialEq)]
pub enum Front {
    /// It is rigid.
    Rigid,
    /// It is one elastic spring, whose stiffness is the factor of the front \[N/m\].
    Elastic,
    /// It is that of a given vehicle, with its forces times the factor of the front.
    Vehicle(Box<Vehicle>),
}

/// A kind of vehicle that may have struck.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Its name: of the catalogue, or `rigid`, `elastic` for any elastic front, `configured` for the vehicle of the parameters.
    pub name: String,
    /// What its front does.
    pub front: Front,
    /// Height of its bumper \[m\].
    pub bumper_height: f64,
    /// Its probability before anything is measured.
    pub probability: f64,
    /// Medians of the unknowns, as logarithms.
    pub(crate) mean: [f64; UNKNOWNS],
    /// Their standard deviations.
    pub(crate) deviation: [f64; UNKNOWNS],
}

/// The hypotheses for a column: a rigid mass, elastic fronts, every vehicle of the catalogue, and the vehicle of the
/// parameters where that is none of these. Their probabilities are assumptions \[A\].
#[must_use]
pub fn hypotheses(parameters: &Parameters) -> Vec<Hypothesis> {
    let make = |name: &str,
                front,
                weight: f64,
                [mass, mass_scatter]: [f64; 2],
                [factor, scatter]: [f64; 2]| {
        let ln = libm::log;
        Hypothesis {
            name: name.to_owned(),
            front,
            bumper_height: parameters.bumper_named(name),
            probability: weight,
            mean: [ln(mass), ln(VELOCITY[0]), ln(factor), 0.0],
            deviation: [mass_scatter, VELOCITY[1], scatter, YIELD_SCATTER],
        }
    };
    let mut all = vec![
        make("rigid", Front::Rigid, 2.0, [1500.0, 1.0], [1.0, NO_SCATTER]),
        make("elastic", Front::Elastic, 1.0, [3000.0, 1.0], ANY_STIFFNESS),
    ];
    let name = &parameters.settings().vehicle.name;
    for entry in vehicle_catalogue() {
        let is_configured = entry.name == *name;
        let weight = if is_configured { 5.0 } else { 0.6 };
        if entry.name == "en1991_elastic" {
            let weight = if is_configured { 5.0 } else { 1.5 };
            all.push(make(
                &entry.name,
                Front::Elastic,
                weight,
                [1700.0, 0.5],
                JCSS_STIFFNESS,
            ));
        } else if let Ok(Some(vehicle)) = parameters.vehicle_named(&entry.name) {
            let scatter = entry.force_variation.value.coefficient.max(NO_SCATTER);
            let mass = [vehicle.total_mass(), 0.3];
            all.push(make(
                &entry.name,
                Front::Vehicle(Box::new(vehicle)),
                weight,
                mass,
                [1.0, scatter],
            ));
        }
    }
    if let Some(vehicle) = parameters.impact().vehicle
        && !all.iter().any(|it| it.name == *name)
    {
        let mass = [vehicle.total_mass(), 0.5];
        all.push(Hypothesis {
            bumper_height: parameters.impact().bumper_height,
            ..make(
                "configured",
                Front::Vehicle(Box::new(vehicle)),
                5.0,
                mass,
                [1.0, 0.2],
            )
        });
    }
    let sum: f64 = all.iter().map(|it| it.probability).sum();
    for hypothesis in &mut all {
        hypothesis.probability /= sum;
    }
    all
}

impl Hypothesis {
    /// Logarithm of the density of these unknowns, the probability of the hypothesis included; minus infinity outside of what
    /// is considered.
    pub(crate) fn log_density(&self, unknowns: &[f64; UNKNOWNS]) -> f64 {
        let (mass, velocity) = (libm::exp(unknowns[0]), libm::exp(unknowns[1]));
        if mass < LEAST_MASS || !(VELOCITY_RANGE[0]..=VELOCITY_RANGE[1]).contains(&velocity) {
            return f64::NEG_INFINITY;
        }
        let mut density = libm::log(self.probability);
        for ((x, mean), deviation) in unknowns.iter().zip(self.mean).zip(self.deviation) {
            let z = (x - mean) / deviation;
            density -= 0.5 * z * z + libm::log(deviation);
        }
        density
    }

    /// The impact with these unknowns; `None` where they make no vehicle.
    pub(crate) fn impact(&self, unknowns: &[f64; UNKNOWNS]) -> Option<Impact> {
        let [mass, velocity, factor, _] = unknowns.map(libm::exp);
        let vehicle = match &self.front {
            Front::Rigid => {
                return Some(Impact {
                    bumper_height: self.bumper_height,
                    ..Impact::rigid(mass, velocity)
                });
            }
            Front::Elastic => {
                let envelope = CrushCurve::new(&[[1.0, factor]]).ok()?;
                let spring = CrushSpring {
                    envelope,
                    unloading_stiffness: factor,
                    slack: 0.0,
                };
                Vehicle::new(&[mass], &[spring]).ok()?
            }
            Front::Vehicle(vehicle) => {
                let vehicle = vehicle.with_total_mass(mass).ok()?;
                let stronger = |spring: &CrushSpring| {
                    let points = spring.envelope.points().iter();
                    let points: Vec<_> = points
                        .map(|[crush, force]| [*crush, factor * force])
                        .collect();
                    Some(CrushSpring {
                        envelope: CrushCurve::new(&points).ok()?,
                        unloading_stiffness: spring.unloading_stiffness * factor.max(1.0),
                        slack: spring.slack,
                    })
                };
                let springs: Option<Vec<_>> = vehicle.springs().iter().map(stronger).collect();
                Vehicle::new(vehicle.masses(), &springs?).ok()?
            }
        };
        Some(Impact {
            mass: vehicle.total_mass(),
            vehicle: Some(vehicle),
            bumper_height: self.bumper_height,
            ..Impact::rigid(mass, velocity)
        })
    }
}
