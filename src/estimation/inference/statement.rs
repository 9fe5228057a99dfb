//! What an estimate states: the weighted responses as quantities with their intervals.

use crate::assessment::Action;
use crate::column::{Outcome, Report};
use crate::estimation::inference::blocks::{CLIPPED, Highest};
use crate::estimation::inference::estimate::{CredibleInterval, ImpactEstimate, Spread};
use crate::estimation::inference::estimator::{Estimator, UNKNOWN_VEHICLE, effective};
use crate::estimation::inference::hypothesis::{Front, UNKNOWNS};
use crate::estimation::inference::member::Member;
use crate::sensors::Quantity;

/// A displacement sensor measures the peak of the impact point if it is no further from it than this share of the part of the
/// column on its side: the column moves there as the impact point does, but for some hundredths.
const AT_IMPACT: f64 = 0.05;

/// Error of a peak that the model keeps when its scale is known, relative to the peak \[A\].
const PEAK_ERROR: f64 = 0.03;

/// The same of a residual displacement, also relative to the peak \[A\].
const RESIDUAL_ERROR: f64 = 0.04;

/// The same of mass, speed and momentum, relative to them \[A\].
const IMPACT_ERROR: f64 = 0.03;

/// Smallest peak whose logarithm is taken \[m\].
const LEAST_PEAK: f64 = 1e-7;

/// The same of a rigid vehicle, in addition: for mass and speed, and for momentum, times the power 1.5 of the mass that the model has at
/// the impact point over that of the vehicle \[A\]. A light vehicle is stopped by the inertia of the column, which the bars have at one
/// point: a rigid hit of 250 kg is taken for one of 1.7 to 2 times the mass and 1.2 times the momentum. With their largest values.
const LIGHT_ERROR: [[f64; 2]; 2] = [[4.5, 1.0], [1.6, 0.35]];

/// Share of its kinetic energy that a vehicle has to lose in its front for the front to count as crushed.
const CRUSHED: f64 = 0.05;

/// Parts of the range of the momentum of a crushed front, each with the same probability \[A\].
const RANGE_PARTS: u32 = 5;

impl Estimator {
    /// Standard deviation of the logarithm of a member's momentum, or of its mass and speed, by the model.
    fn impact_error(&self, member: &Member, of_momentum: bool) -> f64 {
        let striking = match self.population.hypotheses[member.hypothesis].front {
            Front::Rigid => libm::exp(member.unknowns[0]),
            Front::TwoMasses => libm::exp(member.unknowns[0] + member.unknowns[UNKNOWNS - 1]),
            Front::Elastic | Front::Plateau | Front::Vehicle(_) => return IMPACT_ERROR,
        };
        let ratio = self.impact_point_mass / striking;
        let [size, most] = LIGHT_ERROR[usize::from(of_momentum)];
        libm::hypot(IMPACT_ERROR, (size * ratio * ratio.sqrt()).min(most))
    }

    /// The peak displacement of the impact point that a sensor at its height has read by `until` \[s\]; `None` without such a sensor that counts. The most exact one tells it.
    fn measured_peak(&self, until: f64) -> Option<Highest> {
        let blocks = self.blocks.as_ref()?;
        let properties = self.population.properties();
        let each = self.sensors.iter().zip(&self.doubtful).enumerate();
        let at_impact = each.filter(|(_, (sensor, doubtful))| {
            let away = sensor.height - properties.length_below;
            let part = match away <= 0.0 {
                true => properties.length_below,
                false => properties.length_above,
            };
            sensor.quantity == Quantity::Displacement
                && away.abs() <= AT_IMPACT * part
                && !**doubtful
        });
        let measured = at_impact.filter_map(|(index, (sensor, _))| {
            let highest = blocks.highest(index, until)?;
            // A sensor at the end of its range has not seen the peak.
            (sensor.range == 0.0 || highest.value < CLIPPED * sensor.range).then_some(highest)
        });
        measured.min_by(|a, b| a.deviation.total_cmp(&b.deviation))
    }

    /// Peak displacement of the impact point by one response, relative to the column before the impact \[m\]: its logarithm with its
    /// standard deviation. What a sensor has measured counts, and once the response is past its peak while it reads, it is the peak.
    fn peak_by(&self, member: &Member, measured: Option<Highest>) -> [f64; 2] {
        let [scale, scatter] = member.scale;
        let report = &member.prediction.report;
        let added = report.max_v1 - self.rest_v1;
        let mut peak = (scale * added).max(LEAST_PEAK);
        let error = libm::hypot(PEAK_ERROR, self.impact_error(member, true));
        let mut deviation = libm::hypot(scatter * added, error * added);
        if let Some(Highest {
            value: highest,
            deviation: noise,
            seen_until,
        }) = measured
        {
            let since = seen_until - (self.contact[0] + member.delay);
            if since > report.max_v1_time {
                // Prediction and measurement, each by its precision.
                let [own, other] = [1.0 / (deviation * deviation), 1.0 / (noise * noise)];
                peak = (own * peak + other * highest) / (own + other);
                deviation = (1.0 / (own + other)).sqrt();
            } else if highest > peak {
                (peak, deviation) = (highest, deviation.max(noise));
            }
        }
        let peak = peak.max(LEAST_PEAK);
        [libm::log(peak), (deviation / peak).min(1.0)]
    }

    /// The same with action and residual capacity of so many responses, which are chosen by their weights.
    pub(crate) fn estimate_with(&mut self, data_until: f64, count: usize) -> ImpactEstimate {
        let weights = self.weights();
        let assessed = self.assess(&weights, count);
        let members = || {
            let all = self.population.members.iter().zip(weights.iter().copied());
            all.filter(|(_, weight)| *weight > 0.0)
        };
        let effective = effective(&weights);
        // Their distributions are skew: the mean is that of the logarithm. A front that is crushed leaves the momentum open, and
        // the speed with it.
        let positive = |of_mass: f64, of_velocity: f64| {
            let each = members().flat_map(|(member, weight)| {
                let known = of_mass * member.unknowns[0] + of_velocity * member.unknowns[1];
                let (open, parts) = match of_velocity > 0.0 {
                    true => open_momentum(&member.prediction.report, member),
                    false => ([0.0; 2], 1),
                };
                let width = (open[1] - open[0]) / f64::from(parts);
                let model = self.impact_error(member, of_mass > 0.0 && of_velocity > 0.0);
                // Each part is a normal distribution of the variance of a uniform one.
                let deviation = libm::hypot(model, width / 12.0_f64.sqrt());
                (0..parts).map(move |part| Spread {
                    mean: known + open[0] + (f64::from(part) + 0.5) * width,
                    deviation,
                    weight: weight / f64::from(parts),
                })
            });
            CredibleInterval::of_spread(each.collect(), effective).map(libm::exp)
        };
        // The factor of the response belongs to what the impact adds.
        let before = self.rest_v1;
        let residual = |member: &Member| {
            let rest = member.prediction.rest.as_ref();
            rest.map_or(f64::NAN, |rest| rest.displacement.v1)
        };
        let residuals = members().map(|(member, weight)| {
            let [scale, deviation] = member.scale;
            let added = residual(member) - before;
            let peak = member.prediction.report.max_v1 - before;
            Spread {
                mean: scale * added + before,
                deviation: libm::hypot(deviation * added, RESIDUAL_ERROR * peak),
                weight,
            }
        });
        let residual_v1 = CredibleInterval::of_spread(residuals.collect(), effective);
        let share = |is: &dyn Fn(&Member) -> bool| -> f64 {
            members()
                .filter(|(member, _)| is(member))
                .fold(0.0, |sum, (_, weight)| sum + weight)
        };
        let mut vehicles: Vec<(String, f64)> = self
            .population
            .hypotheses
            .iter()
            .enumerate()
            .map(|(k, it)| (it.name.clone(), share(&|member| member.hypothesis == k)))
            .collect();
        // The share of the evidence for the hypotheses that is left where none of them explains the data.
        let explained = 1.0 / self.population.temperature();
        if explained < 1.0 {
            vehicles.iter_mut().for_each(|it| it.1 *= explained);
            vehicles.push((UNKNOWN_VEHICLE.to_owned(), 1.0 - explained));
        }
        vehicles.sort_by(|a, b| b.1.total_cmp(&a.1));
        let collapses = |outcome| matches!(outcome, Outcome::Collapsed | Outcome::Fractured);
        let [contact, deviation] = self.contact;
        let with_action = |action| {
            let count = assessed.iter().filter(|(it, _)| *it == action).count();
            (action, count as f64 / assessed.len().max(1) as f64)
        };
        ImpactEstimate {
            data_until,
            contact_time: CredibleInterval::normal(contact, deviation),
            mass: positive(1.0, 0.0),
            velocity: positive(0.0, 1.0),
            momentum: positive(1.0, 1.0),
            mass_velocity_correlation: correlation(
                members()
                    .map(|(member, weight)| ([member.unknowns[0], member.unknowns[1]], weight)),
            ),
            peak_v1: {
                let measured = self.measured_peak(data_until);
                let each = members().map(|(member, weight)| {
                    let [mean, deviation] = self.peak_by(member, measured);
                    Spread {
                        mean,
                        deviation,
                        weight,
                    }
                });
                let log = CredibleInterval::of_spread(each.collect(), effective);
                log.map(|log| libm::exp(log) + before)
            },
            residual_v1,
            yielded: share(&|member| member.prediction.report.outcome != Outcome::Elastic),
            collapsed: share(&|member| collapses(member.prediction.report.outcome)),
            capacity_ratio: CredibleInterval::of(assessed.iter().map(|(_, ratio)| (*ratio, 1.0))),
            action: Action::ALL.map(with_action).to_vec(),
            vehicle_probabilities: vehicles,
            effective_sample_size: effective,
            doubtful_sensors: self.doubtful_names().map(str::to_owned).collect(),
        }
    }
}

/// What a front that is crushed leaves open of the momentum: logarithms of its bounds over the momentum of the response, and the
/// number of parts in which the range between them counts.
///
/// Of the vehicle, only the contact force acts on the column. Any passive front with the same force, whose impulse is `J` and which
/// does the work
/// `W` on the column, has a momentum from `J / 2 + m W / J`, if it returns all of its energy, to `J`, if it returns none of it. The
/// upper bound holds once the vehicle has stopped.
fn open_momentum(report: &Report, member: &Member) -> ([f64; 2], u32) {
    let lost: f64 = report.vehicle.dissipated.iter().sum();
    let is_crushed = report.vehicle.masses > 0 && lost > CRUSHED * report.input_energy;
    if !is_crushed || report.impactor_velocity > 0.0 || report.impulse <= 0.0 {
        return ([0.0; 2], 1);
    }
    let kept = report.impactor_kinetic_energy + lost + report.vehicle.elastic_energy;
    let work = (report.input_energy - kept).max(0.0);
    let impulse = report.impulse;
    let mass = libm::exp(member.unknowns[0]);
    let least = (0.5 * impulse + mass * work / impulse).min(impulse);
    let momentum = member.unknowns[0] + member.unknowns[1];
    let bounds = [least, impulse].map(|bound| libm::log(bound) - momentum);
    (bounds, RANGE_PARTS)
}

fn correlation(pairs: impl Iterator<Item = ([f64; 2], f64)> + Clone) -> f64 {
    let mean = |k: usize| pairs.clone().map(|(x, weight)| weight * x[k]).sum::<f64>();
    let (a, b) = (mean(0), mean(1));
    let moment = |of: &dyn Fn([f64; 2]) -> f64| pairs.clone().map(|(x, w)| w * of(x)).sum::<f64>();
    let covariance = moment(&|x| (x[0] - a) * (x[1] - b));
    let variances = moment(&|x| (x[0] - a) * (x[0] - a)) * moment(&|x| (x[1] - b) * (x[1] - b));
    covariance / variances.sqrt()
}
