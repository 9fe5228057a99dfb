//! What an estimate states: the weighted responses as quantities with their intervals.

use crate::assessment::Action;
use crate::column::{Outcome, Report};
use crate::estimation::inference::before_impact::{BeforeImpact, prior};
use crate::estimation::inference::comparison::SensorComparison;
use crate::estimation::inference::estimate::{
    CredibleInterval, ImpactEstimate, MASS_OPEN_BEYOND, Spread, share_below,
};
use crate::estimation::inference::estimator::{Estimator, UNKNOWN_VEHICLE, effective};
use crate::estimation::inference::hypothesis::{FRONT_SHARE, Front};
use crate::estimation::inference::member::Member;
use crate::estimation::inference::rigid_vehicle::{ByBeam, RIGID_BY_BEAM};
use crate::sensors::Quantity;

/// The same of a residual displacement, also relative to the peak \[A\].
pub(super) const RESIDUAL_ERROR: f64 = 0.04;

/// The same of mass, speed and momentum, relative to them \[A\].
const IMPACT_ERROR: f64 = 0.03;

/// Standard deviations of what is predicted for the readings of a sensor from which on they stray: by chance one of 16 000 does.
const STRAY: f64 = 4.0;

/// The same of a rigid vehicle, in addition: for mass and speed, and for momentum, times the power 1.5 of the mass that the model has at
/// the impact point over that of the vehicle \[A\]. A light vehicle is stopped by the inertia of the column, which the bars have at one
/// point: a rigid hit of 250 kg is taken for one of 1.7 to 2 times the mass and 1.2 times the momentum. With their largest values.
const LIGHT_ERROR: [[f64; 2]; 2] = [[4.5, 1.0], [1.6, 0.35]];

/// Logarithm of the impulse of a light vehicle by bars that move as far as a beam, over the one by the beam, at most \[A\].
const OVERSTATED: f64 = 0.3;

/// Mass that the model has at the impact point over that of a hard front, from which on the front begins to be light, and is \[A\].
const LIGHT_RATIO: [f64; 2] = [0.1, 0.2];

/// Share of its kinetic energy that a vehicle has to lose in its front for the front to count as crushed.
const CRUSHED: f64 = 0.05;

/// Least share of the mass of a response that a light vehicle is taken to have by the mass of the column that moves with it \[A\].
const LEAST_SHARE_OF_MASS: f64 = 0.25;

/// Probability that a vehicle whose front acts as one of the catalogue is another one \[A\].
pub(super) const UNLIKE_CATALOGUE: f64 = 0.5;

/// Standard deviation of the logarithm of the mass behind a soft front of which no data tell anything yet \[A\].
pub(super) const TO_COME: f64 = 1.0;

/// Parts of the range of the momentum of a crushed front, each with the same probability \[A\].
const RANGE_PARTS: u32 = 5;

/// Logarithm of the most by which a momentum can be smaller than that of the response \[A\].
const LONGEST_RANGE: f64 = 3.0;

impl Estimator {
    /// Standard deviation of the logarithm of a member's momentum, or of its mass and speed, by the model.
    pub(super) fn impact_error(&self, member: &Member, of_momentum: bool) -> f64 {
        let hypothesis = &self.population.hypotheses[member.hypothesis];
        let Some(striking) = hypothesis.hard_mass(&member.unknowns) else {
            return IMPACT_ERROR;
        };
        let ratio = self.population.impact_point.mass / striking;
        let [size, most] = LIGHT_ERROR[usize::from(of_momentum)];
        libm::hypot(IMPACT_ERROR, (size * ratio * ratio.sqrt()).min(most))
    }

    /// Mass of the column that the model does not have at the impact point, over that of a vehicle with a hard front; 0 for a soft one.
    fn column_beside(&self, member: &Member) -> f64 {
        if !self.is_hard(member) {
            return 0.0;
        }
        let properties = self.population.properties();
        let length = properties.length_below + properties.length_above;
        let beside = properties.mass_per_length * length - self.population.impact_point.mass;
        beside.max(0.0) / libm::exp(member.unknowns[0])
    }

    /// Probability that the part of a vehicle that a member has is only its light, hard front, behind which there is more, and the share
    /// of the member's mass that this front is.
    ///
    /// The model stops such a front by a mass at one point instead of by waves, and the swing of the column that follows hides what a
    /// force from behind adds: whether a response with anything behind explains the readings better does not tell whether there is.
    fn hidden(&self, member: &Member) -> (f64, f64) {
        let hypothesis = &self.population.hypotheses[member.hypothesis];
        let hard = hypothesis.hard_mass(&member.unknowns);
        let share = hard.map_or(1.0, |it| it / libm::exp(member.unknowns[0]));
        (self.by_beam.hidden() * self.lightness(member), share)
    }

    /// How far the hard front of a member is light beside the column: 0, not at all and for a soft front, to 1, wholly.
    pub(super) fn lightness(&self, member: &Member) -> f64 {
        let hypothesis = &self.population.hypotheses[member.hypothesis];
        let [from, to] = LIGHT_RATIO;
        hypothesis.hard_mass(&member.unknowns).map_or(0.0, |hard| {
            let ratio = self.population.impact_point.mass / hard;
            ((ratio - from) / (to - from)).clamp(0.0, 1.0)
        })
    }

    /// Whether the front of a member is hard, at least at its face.
    pub(super) fn is_hard(&self, member: &Member) -> bool {
        let hypothesis = &self.population.hypotheses[member.hypothesis];
        hypothesis.hard_mass(&member.unknowns).is_some()
    }

    /// Share of the impulse of a soft front that is still to come, about: by the share of the time of its contact. A hard front delivers most
    /// of its impulse at once.
    pub(super) fn to_come(&self, member: &Member) -> f64 {
        if self.is_hard(member) {
            return 0.0;
        }
        let report = &member.prediction.report;
        let left = report.release_time.unwrap_or(report.end_time);
        (1.0 - (self.seen() - member.delay) / left).clamp(0.0, 1.0)
    }

    /// The hypotheses with their probabilities, and an unknown one where they do not explain everything. A vehicle with a light, hard front
    /// may be either of the two kinds that have one.
    fn vehicles(&self, weights: &[f64], explained: f64) -> Vec<(String, f64)> {
        let hypotheses = &self.population.hypotheses;
        let mut shares = vec![0.0; hypotheses.len()];
        let place = |front: &Front| hypotheses.iter().position(|it| it.front == *front);
        let kinds = [place(&Front::Rigid), place(&Front::TwoMasses)];
        for (member, weight) in self.population.members.iter().zip(weights) {
            let own = member.hypothesis;
            let light = match kinds {
                [Some(rigid), Some(two)] if own == rigid || own == two => {
                    let light = self.lightness(member) * weight;
                    shares[two] += self.by_beam.hidden() * light;
                    shares[rigid] += (1.0 - self.by_beam.hidden()) * light;
                    light
                }
                _ => 0.0,
            };
            shares[own] += weight - light;
        }
        let names = hypotheses.iter().map(|it| it.name.clone());
        let mut vehicles: Vec<(String, f64)> = names.zip(shares).collect();
        // The share of the evidence for the hypotheses that is left where none of them explains the data.
        if explained < 1.0 {
            vehicles.iter_mut().for_each(|it| it.1 *= explained);
            vehicles.push((UNKNOWN_VEHICLE.to_owned(), 1.0 - explained));
        }
        if let (Some(rigid), ByBeam::Rigid(_)) = (kinds[0], self.by_beam) {
            vehicles
                .iter_mut()
                .for_each(|it| it.1 *= 1.0 - RIGID_BY_BEAM);
            vehicles[rigid].1 += RIGID_BY_BEAM;
        }
        vehicles
    }

    /// The mass, and where the readings leave it open also what is probable before anything is measured.
    fn mass(&self, found: CredibleInterval) -> CredibleInterval {
        if !found.is_open(MASS_OPEN_BEYOND) {
            return found;
        }
        let prior = prior(&self.population.hypotheses, [1.0, 0.0]);
        CredibleInterval {
            low: found.low.min(prior.low),
            high: found.high.max(prior.high),
            ..found
        }
    }

    /// Whether the readings of a sensor stray from what the weighted responses predict for them, by more than noise and the error of the model
    /// explain: two means one after the other, to the same side.
    pub(super) fn strays(comparison: &SensorComparison) -> bool {
        let away = comparison
            .means
            .iter()
            .map(|it| it.predicted.deviations(it.measured));
        let away: Vec<f64> = away.collect();
        comparison.counts
            && away
                .windows(2)
                .any(|pair| pair.iter().all(|it| *it > STRAY) || pair.iter().all(|it| *it < -STRAY))
    }

    /// Names of the sensors of displacement on whose scale the peak rests, and which no other sensor confirms. One that is in doubt is no
    /// longer believed.
    fn unconfirmed_scales(&self, weights: &[f64], doubtful: &[String]) -> Vec<String> {
        let in_doubt = self.in_doubt();
        let each = self.sensors.iter().enumerate();
        let unconfirmed = each.filter(|(index, sensor)| {
            sensor.quantity == Quantity::Displacement
                && !doubtful.contains(&sensor.name)
                && self
                    .population
                    .has_unconfirmed_scale(*index, weights, &in_doubt)
        });
        unconfirmed.map(|(_, sensor)| sensor.name.clone()).collect()
    }

    /// Names of the sensors that contradict the others, wholly or by their scale, that have failed or are noisier than declared, or whose
    /// readings stray or rise on.
    fn sensors_in_doubt(&self, weights: &[f64], compared: &[SensorComparison]) -> Vec<String> {
        let rises_on = self.rises_on(weights);
        let in_doubt = compared.iter().filter(|it| {
            let index = it.sensor;
            self.contradicts(index)
                || self.off_scale[index]
                || self.failed.get(index) == Some(&true)
                || self.noisy.get(index) == Some(&true)
                || rises_on == Some(index)
                || Self::strays(it)
        });
        in_doubt
            .map(|it| self.sensors[it.sensor].name.clone())
            .collect()
    }

    /// What a member with this weight says of these powers of mass and speed, multiplied: logarithms. Their distributions are skew, and
    /// the mean is that of the logarithm. A front that is crushed leaves the momentum open, and the speed with it, up to the largest
    /// momentum that is probable before anything is measured. So does any soft front whose contact lasts, of whose impulse the share
    /// `to_come` is still to come, and a light, hard one down to half of its impulse.
    pub(super) fn spread_of_vehicle(
        &self,
        member: &Member,
        weight: f64,
        [of_mass, of_velocity]: [f64; 2],
        before: &BeforeImpact,
        to_come: f64,
    ) -> impl Iterator<Item = Spread> {
        let known = of_mass * member.unknowns[0] + of_velocity * member.unknowns[1];
        let largest = before.largest_momentum;
        let report = &member.prediction.report;
        let (mut open, is_moving) = open_momentum(report, member, largest);
        let momentum = member.unknowns[0] + member.unknowns[1];
        // A vehicle that returns all that it has delivered so far.
        let least = libm::log(0.5 * delivered(member, to_come)) - momentum;
        let least = least.clamp(-LONGEST_RANGE, 0.0);
        // A vehicle that has not stopped is heavier; one that has stopped was faster or slower.
        let shows = if is_moving { of_mass } else { of_velocity };
        let [mut low, high] = if shows > 0.0 { open } else { [0.0; 2] };
        // Of what is hard and light beside the column, the model tells the impulse, but not what the first blow loses: the less it loses,
        // the lighter the vehicle is. The square, because the model is right about a front that is hardly light.
        let lightness = self.lightness(member);
        let lightness = lightness * lightness;
        let returned = lightness * (least - OVERSTATED);
        open[0] = open[0].min(returned);
        if of_mass > 0.0 {
            low = low.min(returned);
        }
        // A light vehicle is lighter and faster than one that moves the column of the model alike: at most the whole column moves with it.
        let with_it = self.column_beside(member);
        let lighter = move |share: f64| {
            (of_mass - of_velocity) * libm::log1p(-(share * with_it).min(1.0 - LEAST_SHARE_OF_MASS))
        };
        // The readings tell about the momentum, and leave open how it is shared by mass and speed.
        let is_share = of_mass == 0.0 || of_velocity == 0.0;
        let mut model = self.impact_error(member, !is_share);
        if is_share {
            model = libm::hypot(model, of_mass * TO_COME * to_come);
        }
        let (hidden, hard) = self.hidden(member);
        let hidden = if of_mass > 0.0 { hidden } else { 0.0 };
        let front = &self.population.hypotheses[member.hypothesis].front;
        let unlike = match front {
            _ if !is_share => 0.0,
            Front::Vehicle(_) => UNLIKE_CATALOGUE,
            _ => UNLIKE_CATALOGUE * lightness,
        };
        let goes_on = match !is_share && to_come > 0.0 {
            true => UNLIKE_CATALOGUE,
            false => 0.0,
        };
        let parts = match low < high || with_it > 0.0 {
            true => RANGE_PARTS,
            false => 1,
        };
        let own = range([low, high], parts).map(move |(share, place, scatter)| Spread {
            mean: known + place + lighter(share),
            deviation: libm::hypot(model, scatter),
            weight: weight * (1.0 - hidden) * (1.0 - unlike) * (1.0 - goes_on) / f64::from(parts),
        });
        // The force of a front, or the impulse of a light one, leaves open how heavy and how fast the vehicle is whose momentum it shows.
        let other = (unlike > 0.0).then(|| {
            let scatter = libm::hypot(IMPACT_ERROR, (open[1] - open[0]) / 12.0_f64.sqrt());
            let scatter = libm::hypot(scatter, TO_COME * to_come);
            let momentum = momentum + 0.5 * (open[0] + open[1]);
            Spread {
                weight: weight * (1.0 - hidden) * unlike,
                ..before.with_momentum([of_mass, of_velocity], [momentum, scatter])
            }
        });
        // As long as it presses, it may press on otherwise. One that has stopped goes back soon; of one that has not, nothing tells yet how
        // heavy and how fast it is.
        let has_stopped = libm::log(delivered(member, to_come)) >= momentum;
        let share = if has_stopped { to_come } else { 1.0 };
        let ends = [least, (share * (largest - momentum)).max(0.0)];
        let later = range(ends, RANGE_PARTS).map(move |(_, place, scatter)| Spread {
            mean: momentum + place,
            deviation: libm::hypot(model, scatter),
            weight: weight * goes_on / f64::from(RANGE_PARTS),
        });
        // What may be behind a light front is as heavy as before anything is measured.
        let [front_share, scatter] = FRONT_SHARE;
        let behind = Spread {
            mean: known + libm::log(hard / front_share),
            deviation: libm::hypot(model, scatter),
            weight: weight * hidden,
        };
        own.chain([behind]).chain(other).chain(later)
    }

    /// What is known of the vehicle before anything is measured.
    pub(super) fn before_impact(&self) -> BeforeImpact {
        BeforeImpact::of(&self.population.hypotheses)
    }

    /// The members with their weights, as far as these count.
    pub(super) fn weighted<'a>(
        &'a self,
        weights: &'a [f64],
    ) -> impl Iterator<Item = (&'a Member, f64)> + Clone {
        let all = self.population.members.iter().zip(weights.iter().copied());
        all.filter(|(_, weight)| *weight > 0.0)
    }

    /// See [`Estimator::spread_of_vehicle`] and [`Estimator::explained`]. A vehicle of an unknown kind has the mass and the speed that are
    /// probable before anything is measured. A rigid vehicle that explains the readings by the beam takes the place of most of them.
    fn spread_of_vehicles(&self, weights: &[f64], explained: f64, powers: [f64; 2]) -> Vec<Spread> {
        let by_beam = match self.by_beam {
            ByBeam::Rigid(vehicle) => Some(vehicle.spread(powers)),
            ByBeam::Nothing | ByBeam::NotRigid => None,
        };
        let others = 1.0 - by_beam.as_ref().map_or(0.0, |it| it.weight);
        let before = self.before_impact();
        let members = self.weighted(weights).flat_map(|(member, weight)| {
            let to_come = self.to_come(member);
            self.spread_of_vehicle(
                member,
                others * explained * weight,
                powers,
                &before,
                to_come,
            )
        });
        let unknown = before.with_momentum_of_at_least(powers, self.least_momentum(weights));
        let unknown = unknown.into_iter().map(|it| Spread {
            weight: others * (1.0 - explained) * it.weight,
            ..it
        });
        members.chain(unknown).chain(by_beam).collect()
    }

    /// Logarithm of the least momentum of any passive vehicle that has delivered the impulse so far: it returns all of it.
    fn least_momentum(&self, weights: &[f64]) -> f64 {
        let impulse = self.weighted(weights).fold(0.0, |sum, (member, weight)| {
            sum + weight * delivered(member, self.to_come(member))
        });
        libm::log((0.5 * impulse).max(f64::MIN_POSITIVE))
    }

    /// Probability that the members explain what has struck.
    fn explained(&self, weights: &[f64]) -> f64 {
        self.right_about_peak(weights) / self.population.temperature()
    }

    /// What they say of the residual displacement. The factor of the response belongs to what the impact adds.
    fn spread_of_residuals(&self, weights: &[f64]) -> Vec<Spread> {
        let before = self.rest_v1;
        let each = self.weighted(weights).map(|(member, weight)| {
            let [scale, deviation] = member.scale;
            let rest = member.prediction.rest.as_ref();
            let added = rest.map_or(f64::NAN, |rest| rest.displacement.v1) - before;
            let peak = member.prediction.report.max_v1 - before;
            Spread {
                mean: scale * added + before,
                deviation: libm::hypot(deviation * added, RESIDUAL_ERROR * peak),
                weight,
            }
        });
        each.collect()
    }

    /// The shares of the distributions of momentum \[N s\], peak and residual `v1` \[m\] by the data so far that are below these values.
    /// Over impacts that the estimator itself may conceive, each is uniformly distributed between 0 and 1 if the inference is exact.
    #[must_use]
    pub fn shares_below(&self, momentum: f64, peak_v1: f64, residual_v1: f64) -> [f64; 3] {
        let weights = self.weights();
        let effective = effective(&weights);
        let vehicles = self.spread_of_vehicles(&weights, self.explained(&weights), [1.0, 1.0]);
        let compared = self.population.compare(&weights);
        [
            share_below(vehicles, effective, libm::log(momentum)),
            self.share_below_peak(&weights, &compared, peak_v1),
            share_below(self.spread_of_residuals(&weights), effective, residual_v1),
        ]
    }

    /// The same with action and residual capacity of so many responses, which are chosen by their weights.
    pub(crate) fn estimate_with(&mut self, data_until: f64, count: usize) -> ImpactEstimate {
        let weights = self.weights();
        let assessed = self.assess(&weights, count);
        let members = || self.weighted(&weights);
        let effective = effective(&weights);
        let explained = self.explained(&weights);
        let positive = |powers: [f64; 2]| {
            let each = self.spread_of_vehicles(&weights, explained, powers);
            CredibleInterval::of_spread(each, effective).map(libm::exp)
        };
        let residuals = self.spread_of_residuals(&weights);
        let share = |is: &dyn Fn(&Member) -> bool| -> f64 {
            members()
                .filter(|(member, _)| is(member))
                .fold(0.0, |sum, (_, weight)| sum + weight)
        };
        let mut vehicles = self.vehicles(&weights, explained);
        vehicles.sort_by(|a, b| b.1.total_cmp(&a.1));
        let [contact, deviation] = self.contact;
        let compared = self.population.compare(&weights);
        let doubtful_sensors = self.sensors_in_doubt(&weights, &compared);
        let with_action = |action| {
            let count = assessed.iter().filter(|(it, _)| *it == action).count();
            (action, count as f64 / assessed.len().max(1) as f64)
        };
        ImpactEstimate {
            data_until,
            contact_time: CredibleInterval::normal(contact, deviation),
            mass: self.mass(positive([1.0, 0.0])),
            velocity: positive([0.0, 1.0]),
            momentum: positive([1.0, 1.0]),
            mass_velocity_correlation: match self.by_beam {
                ByBeam::Rigid(vehicle) => vehicle.correlation(),
                ByBeam::Nothing | ByBeam::NotRigid => correlation(
                    members()
                        .map(|(member, weight)| ([member.unknowns[0], member.unknowns[1]], weight)),
                ),
            },
            peak_v1: self.peak(&weights, &compared),
            residual_v1: CredibleInterval::of_spread(residuals, effective),
            yielded: share(&|member| member.prediction.report.outcome != Outcome::Elastic),
            collapsed: share(&|member| !member.prediction.report.outcome.stands()),
            capacity_ratio: CredibleInterval::of(assessed.iter().map(|(_, ratio)| (*ratio, 1.0))),
            action: Action::ALL.map(with_action).to_vec(),
            vehicle_probabilities: vehicles,
            effective_sample_size: effective,
            scale_not_confirmed: self.unconfirmed_scales(&weights, &doubtful_sensors),
            vehicle_by_beam: matches!(self.by_beam, ByBeam::Rigid(_)),
            doubtful_sensors,
        }
    }
}

/// Impulse that the vehicle of a member has delivered when this share of it is still to come \[N s\].
fn delivered(member: &Member, to_come: f64) -> f64 {
    (1.0 - to_come) * member.prediction.report.impulse
}

/// Parts of a range: the share of the range up to the middle of each, this place in the range, and the standard deviation of a uniform
/// distribution over the part.
fn range([low, high]: [f64; 2], parts: u32) -> impl Iterator<Item = (f64, f64, f64)> {
    let width = (high - low) / f64::from(parts);
    (0..parts).map(move |part| {
        let middle = f64::from(part) + 0.5;
        (
            middle / f64::from(parts),
            low + middle * width,
            width / 12.0_f64.sqrt(),
        )
    })
}

/// What a response leaves open of the momentum: logarithms of its bounds over the momentum of the response, and whether the vehicle
/// has not stopped. `largest` is the logarithm of the largest momentum that is probable before anything is measured.
///
/// Of the vehicle, only the contact force acts on the column. Any passive front with the same force, whose impulse is `J` and which
/// does the work `W` on the column, has a momentum from `J / 2 + m W / J`, if it returns all of its energy, to `J`, if it returns none
/// of it. The upper bound holds once the vehicle has stopped: a column that collapses takes a small part of the momentum, and nothing
/// tells how much is left.
fn open_momentum(report: &Report, member: &Member, largest: f64) -> ([f64; 2], bool) {
    let lost: f64 = report.vehicle.dissipated.iter().sum();
    let is_crushed = report.vehicle.masses > 0 && lost > CRUSHED * report.input_energy;
    let is_moving = report.impactor_velocity > 0.0;
    if report.impulse <= 0.0 || !(is_crushed || is_moving) {
        return ([0.0; 2], false);
    }
    let momentum = member.unknowns[0] + member.unknowns[1];
    let impulse = report.impulse;
    if is_moving {
        return ([0.0, (largest - momentum).max(0.0)], true);
    }
    let kept = report.impactor_kinetic_energy + lost + report.vehicle.elastic_energy;
    let work = (report.input_energy - kept).max(0.0);
    let mass = libm::exp(member.unknowns[0]);
    let least = (0.5 * impulse + mass * work / impulse).min(impulse);
    let bounds = [least, impulse].map(|bound| libm::log(bound) - momentum);
    (bounds, false)
}

fn correlation(pairs: impl Iterator<Item = ([f64; 2], f64)> + Clone) -> f64 {
    let mean = |k: usize| pairs.clone().map(|(x, weight)| weight * x[k]).sum::<f64>();
    let (a, b) = (mean(0), mean(1));
    let moment = |of: &dyn Fn([f64; 2]) -> f64| pairs.clone().map(|(x, w)| w * of(x)).sum::<f64>();
    let covariance = moment(&|x| (x[0] - a) * (x[1] - b));
    let variances = moment(&|x| (x[0] - a) * (x[0] - a)) * moment(&|x| (x[1] - b) * (x[1] - b));
    covariance / variances.sqrt()
}
