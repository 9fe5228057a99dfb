//! What may have struck the column, before anything is measured.

use crate::column::{CrushCurve, CrushSpring, Impact, Vehicle};
use crate::estimation::inference::model_error::light_front;
use crate::parameters::{Parameters, vehicle_catalogue};

/// Most unknowns of a hypothesis: the logarithms of mass, velocity, factor of the front, factor of the yield strength, and those
/// that a front has beside its factor.
pub(crate) const UNKNOWNS: usize = 6;

/// Unknowns of a front that has a factor only.
pub(crate) const OF_ONE_FACTOR: usize = 4;

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

/// Median force of a front that is crushed \[N\] and standard deviation of its logarithm \[A\]: from a small car to a lorry.
const CRUSH_FORCE: [f64; 2] = [300e3, 0.7];

/// The same of the crush at which it reaches this force \[m\].
const CRUSH_BEFORE_PLATEAU: [f64; 2] = [0.2, 0.8];

/// Crush up to which it keeps this force \[m\]: further than any vehicle is crushed.
const LONGEST_PLATEAU: f64 = 20.0;

/// Median of the mass that is ahead of the crushed part, over that of the vehicle, and standard deviation of its logarithm \[A\].
pub(crate) const FRONT_SHARE: [f64; 2] = [0.12, 0.5];

/// Largest share that is considered.
const MOST_FRONT_SHARE: f64 = 0.8;

/// Stiffness between the column and a front mass that is hard, such as an engine \[N/m\] \[A\].
const HARD_FRONT: f64 = 5e8;

/// Median mass of a vehicle whose front is crushed \[kg\] and standard deviation of its logarithm \[A\].
const CRUSHED_MASS: [f64; 2] = [2500.0, 1.0];

/// What the front of a vehicle does.
#[derive(Debug, Clone, PartialEq)]
pub enum Front {
    /// It is rigid.
    Rigid,
    /// It is one elastic spring, whose stiffness is the factor of the front \[N/m\].
    Elastic,
    /// Its force rises to a plateau, which is the factor of the front \[N\], over a crush that is unknown, too.
    Plateau,
    /// A hard mass, an unknown share of the vehicle, is ahead of such a plateau.
    TwoMasses,
    /// It is that of a given vehicle, with its forces times the factor of the front.
    Vehicle(Box<Vehicle>),
}

/// A kind of vehicle that may have struck.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Its name: of the catalogue, or `rigid`, `elastic` for any elastic front, `plateau` for any front that is crushed,
    /// `two_masses` for one with a hard mass ahead of it, `configured` for the vehicle of the parameters.
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
    /// How many of them there are, from the first on.
    pub(crate) unknowns: usize,
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
            mean: [ln(mass), ln(VELOCITY[0]), ln(factor), 0.0, 0.0, 0.0],
            deviation: [mass_scatter, VELOCITY[1], scatter, YIELD_SCATTER, 1.0, 1.0],
            unknowns: OF_ONE_FACTOR,
        }
    };
    let mut all = vec![
        make("rigid", Front::Rigid, 2.0, [1500.0, 1.0], [1.0, NO_SCATTER]),
        make("elastic", Front::Elastic, 1.0, [3000.0, 1.0], ANY_STIFFNESS),
    ];
    let crushed = |name: &str, front, weight: f64, more: &[[f64; 2]]| {
        let mut it = make(name, front, weight, CRUSHED_MASS, CRUSH_FORCE);
        for [median, deviation] in more {
            it.mean[it.unknowns] = libm::log(*median);
            it.deviation[it.unknowns] = *deviation;
            it.unknowns += 1;
        }
        it
    };
    let before = CRUSH_BEFORE_PLATEAU;
    all.push(crushed("plateau", Front::Plateau, 1.0, &[before]));
    let both = [before, FRONT_SHARE];
    all.push(crushed("two_masses", Front::TwoMasses, 0.3, &both));
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
        let each = unknowns.iter().zip(self.mean).zip(self.deviation);
        for ((x, mean), deviation) in each.take(self.unknowns) {
            let z = (x - mean) / deviation;
            density -= 0.5 * z * z + libm::log(deviation);
        }
        density
    }

    /// Mass of the hard part that strikes the column \[kg\]; `None` where the front is soft.
    pub(crate) fn hard_mass(&self, unknowns: &[f64; UNKNOWNS]) -> Option<f64> {
        match self.front {
            Front::Rigid => Some(libm::exp(unknowns[0])),
            Front::TwoMasses => Some(libm::exp(unknowns[0] + unknowns[UNKNOWNS - 1])),
            Front::Elastic | Front::Plateau | Front::Vehicle(_) => None,
        }
    }

    /// Error of motions under a rigid vehicle that is light beside this mass of the model at the impact point \[kg\], relative to the largest
    /// reading; 0 for others. A hard front with something behind it does not have it: what follows it would explain any hit then.
    pub(crate) fn light_front(&self, unknowns: &[f64; UNKNOWNS], impact_point_mass: f64) -> f64 {
        match self.front {
            Front::Rigid => light_front(impact_point_mass / libm::exp(unknowns[0])),
            _ => 0.0,
        }
    }

    /// The impact with these unknowns; `None` where they make no vehicle.
    pub(crate) fn impact(&self, unknowns: &[f64; UNKNOWNS]) -> Option<Impact> {
        let [mass, velocity, factor, _, crush, share] = unknowns.map(libm::exp);
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
            Front::Plateau => Vehicle::new(&[mass], &[plateau(factor, crush)?]).ok()?,
            Front::TwoMasses => {
                if share > MOST_FRONT_SHARE {
                    return None;
                }
                let hard = CrushSpring {
                    envelope: CrushCurve::new(&[[1.0, HARD_FRONT]]).ok()?,
                    unloading_stiffness: HARD_FRONT,
                    slack: 0.0,
                };
                let masses = [share * mass, (1.0 - share) * mass];
                Vehicle::new(&masses, &[hard, plateau(factor, crush)?]).ok()?
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

/// A spring whose force rises to `force` \[N\] over this crush \[m\], and then stays.
fn plateau(force: f64, crush: f64) -> Option<CrushSpring> {
    let envelope = CrushCurve::new(&[[crush, force], [crush + LONGEST_PLATEAU, force]]).ok()?;
    Some(CrushSpring {
        unloading_stiffness: envelope.steepest_slope(),
        envelope,
        slack: 0.0,
    })
}
