//! What may have struck the column, before anything is measured.

use crate::column::{CrushCurve, CrushSpring, Impact, Model, Vehicle};
use crate::estimation::inference::model_error::{FrontError, light_front, soft_front};
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

/// Standard deviations from its median up to which an unknown is considered: a response to what is farther off takes the more time the
/// stiffer its front is, and never counts.
const FARTHEST: f64 = 6.0;

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

/// Median crush up to which a front has its first stiffness \[m\] and standard deviation of its logarithm \[A\].
const CRUSH_BEFORE_BEND: [f64; 2] = [0.3, 0.8];

/// The same of the stiffness beyond, over the first one \[A\]: mostly a front becomes stiffer when the engine is reached.
const SLOPE_BEYOND: [f64; 2] = [1.5, 1.2];

/// Crush up to which it keeps this force \[m\]: further than any vehicle is crushed.
const LONGEST_PLATEAU: f64 = 20.0;

/// Median of the mass that is ahead of the crushed part, over that of the vehicle, and standard deviation of its logarithm \[A\].
pub(crate) const FRONT_SHARE: [f64; 2] = [0.12, 0.5];

/// Largest share that is considered.
const MOST_FRONT_SHARE: f64 = 0.8;

/// Stiffness between the column and a front mass that is hard, such as an engine \[N/m\] \[A\].
const HARD_FRONT: f64 = 5e8;

/// Median mass of a vehicle of which nothing is known \[kg\] and standard deviation of its logarithm \[A\]: 90 % are between a small car and
/// a loaded lorry.
const ANY_MASS: [f64; 2] = [4000.0, 1.2];

/// The column where it is struck.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImpactPoint {
    /// Mass that the model has there \[kg\].
    pub mass: f64,
    /// Elastic stiffness of the column against a transverse force there \[N/m\].
    pub stiffness: f64,
}

impl ImpactPoint {
    pub fn of(model: &Model) -> Self {
        Self {
            mass: model.impact_point_mass,
            stiffness: model.transverse_stiffness(),
        }
    }

    /// Circular frequency with which it swings in the model \[rad/s\].
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }
}

/// What the front of a vehicle does.
#[derive(Debug, Clone, PartialEq)]
pub enum Front {
    /// It is rigid.
    Rigid,
    /// It is one elastic spring, whose stiffness is the factor of the front \[N/m\].
    Elastic,
    /// Its force rises to a plateau, which is the factor of the front \[N\], over a crush that is unknown, too.
    Plateau,
    /// Its stiffness is the factor of the front \[N/m\] up to an unknown crush, and another one beyond.
    TwoSlopes,
    /// A hard mass, an unknown share of the vehicle, is ahead of such a plateau.
    TwoMasses,
    /// It is that of a given vehicle, with its forces times the factor of the front.
    Vehicle(Box<Vehicle>),
}

impl Front {
    /// Places of force and crush of a plateau among the unknowns.
    pub(crate) const FORCE: usize = 2;
    pub(crate) const CRUSH: usize = 4;
}

/// A kind of vehicle that may have struck.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Its name: of the catalogue, or `rigid`, `elastic` for any elastic front, `plateau` for any front that is crushed,
    /// `two_slopes` for one that becomes stiffer or softer, `two_masses` for one with a hard mass ahead of it, `configured` for the vehicle of
    /// the parameters.
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
        make("elastic", Front::Elastic, 1.0, ANY_MASS, ANY_STIFFNESS),
    ];
    let of_more = |name: &str, front, weight: f64, factor, more: &[[f64; 2]]| {
        let mut it = make(name, front, weight, ANY_MASS, factor);
        for [median, deviation] in more {
            it.mean[it.unknowns] = libm::log(*median);
            it.deviation[it.unknowns] = *deviation;
            it.unknowns += 1;
        }
        it
    };
    let plateau = [CRUSH_BEFORE_PLATEAU];
    let slopes = [CRUSH_BEFORE_BEND, SLOPE_BEYOND];
    let masses = [CRUSH_BEFORE_PLATEAU, FRONT_SHARE];
    all.extend([
        of_more("plateau", Front::Plateau, 1.0, CRUSH_FORCE, &plateau),
        of_more("two_slopes", Front::TwoSlopes, 1.0, ANY_STIFFNESS, &slopes),
        of_more("two_masses", Front::TwoMasses, 0.3, CRUSH_FORCE, &masses),
    ]);
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
            if z.abs() > FARTHEST {
                return f64::NEG_INFINITY;
            }
            density -= 0.5 * z * z + libm::log(deviation);
        }
        density
    }

    /// Mass of the hard part that strikes the column \[kg\]; `None` where the front is soft.
    pub(crate) fn hard_mass(&self, unknowns: &[f64; UNKNOWNS]) -> Option<f64> {
        match self.front {
            Front::Rigid => Some(libm::exp(unknowns[0])),
            Front::TwoMasses => Some(libm::exp(unknowns[0] + unknowns[UNKNOWNS - 1])),
            Front::Elastic | Front::Plateau | Front::TwoSlopes | Front::Vehicle(_) => None,
        }
    }

    /// Error of motions under a rigid vehicle that is light beside the mass of the model at the impact point, and under a soft front. A hard
    /// front with something behind it does not have it: what follows it would explain any hit then.
    pub(crate) fn front_error(&self, impact: &Impact, column: &ImpactPoint) -> FrontError {
        let springs = impact.vehicle.iter().flat_map(Vehicle::springs);
        let mut points = springs.map(|it| it.envelope.points()[0]);
        match (&self.front, points.next()) {
            (Front::Rigid, _) => FrontError::Light(light_front(column.mass / impact.mass)),
            (Front::TwoMasses, _) | (_, None) => FrontError::NONE,
            (_, Some([crush, force])) => {
                FrontError::Soft(soft_front(force / crush / column.stiffness))
            }
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
            Front::Elastic => Vehicle::new(&[mass], &[loaded_along(&[[1.0, factor]])?]).ok()?,
            Front::Plateau => Vehicle::new(&[mass], &[plateau(factor, crush)?]).ok()?,
            Front::TwoSlopes => {
                let force = factor * crush;
                let end = [
                    crush + LONGEST_PLATEAU,
                    force + share * factor * LONGEST_PLATEAU,
                ];
                Vehicle::new(&[mass], &[loaded_along(&[[crush, force], end])?]).ok()?
            }
            Front::TwoMasses => {
                if share > MOST_FRONT_SHARE {
                    return None;
                }
                let hard = loaded_along(&[[1.0, HARD_FRONT]])?;
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
    loaded_along(&[[crush, force], [crush + LONGEST_PLATEAU, force]])
}

/// A spring that is loaded along this curve and unloaded by its steepest slope.
pub(crate) fn loaded_along(points: &[[f64; 2]]) -> Option<CrushSpring> {
    let envelope = CrushCurve::new(points).ok()?;
    Some(CrushSpring {
        unloading_stiffness: envelope.steepest_slope(),
        envelope,
        slack: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One response to a front of 10^17 N/m, which was drawn in a refinement, took ten seconds.
    #[test]
    fn a_front_far_stiffer_than_any_is_not_considered() {
        let all = hypotheses(&Parameters::default());
        let it = all.iter().find(|it| it.front == Front::TwoSlopes);
        let it = it.expect("a hypothesis");
        let at = |deviations: f64| {
            let mut unknowns = it.mean;
            unknowns[UNKNOWNS - 1] += deviations * it.deviation[UNKNOWNS - 1];
            it.log_density(&unknowns)
        };
        assert!(at(5.0).is_finite() && at(-5.0).is_finite());
        assert!(at(12.9).is_infinite());
    }
}
