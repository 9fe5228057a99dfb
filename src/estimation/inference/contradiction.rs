//! Sensors that contradict each other.

use crate::estimation::inference::member::{Fit, Member};
use crate::estimation::inference::model_error::ModelError;
use crate::estimation::inference::weighing::Observed;
use crate::sensors::Sensor;

/// Means that a sensor needs before it may contradict the others.
const LEAST_MEANS: f64 = 5.0;

/// Logarithm of a ratio of likelihoods beyond which a response is not plausible any more.
const PLAUSIBLE: f64 = 6.0;

/// Mean square of a sensor's errors, in terms of the variances of noise and model, that no plausible response may exceed.
const CONTRADICTION: f64 = 4.0;

/// Whether a response that the data make likely explains what every sensor reads. If so, no sensor contradicts the others, and
/// the closer look of [`contradictions`] is not necessary.
pub(crate) fn explains_all(members: &[Member], observed: &[Observed], sensors: &[Sensor]) -> bool {
    let up_to_date = || members.iter().filter(|it| it.seen == observed.len());
    let best = largest(up_to_date().map(Member::log_posterior));
    let means = counted_means(observed, sensors.len());
    up_to_date()
        .filter(|member| member.log_posterior() >= best - PLAUSIBLE)
        .any(|member| {
            let mut each = sensors.iter().zip(&means).enumerate();
            each.all(|(index, (sensor, means))| {
                let error = ModelError::of(sensor.quantity);
                member.fit(index, error).squares <= CONTRADICTION * means
            })
        })
}

/// The same from which on one of three or more sensors is left out: a wrong model of the vehicle or of the column explains a smaller
/// misfit. Of two, which are all that there is, neither confirms the model, and [`CONTRADICTION`] is enough.
const EXCLUSION: f64 = 25.0;

/// The same where a response explains all other sensors within their errors, each with a mean square of at most [`WELL_EXPLAINED`], and at
/// least [`WITNESSES`] of them have read as long and tell a scale: a wrong model would not explain them so well.
const EXCLUSION_BY_OTHERS: f64 = 8.0;
const WELL_EXPLAINED: f64 = 1.0;
const WITNESSES: usize = 2;

/// Leaving out sensors has to divide the misfit of the others by this number, unless they are explained then.
const RELIEF: f64 = 4.0;

/// Largest standard deviation of the factor between column and model of a quantity that confirms the scale of other sensors.
const TELLING_SCALE: f64 = 0.1;

/// Standard deviations of the factor that a sensor shows, if the others are right, from which on its scale is in doubt: a right one is with a
/// probability of 1 %.
const SCALE_DOUBT: f64 = 2.5;

/// The same of the factor by all sensors together, from which on a closer look is necessary: it is drawn towards that of the sensor.
const SCALE_SUSPICION: f64 = 1.25;

/// Relative error of the scale of a sensor that the others have to notice if they are to confirm it \[A\]: it is about twice
/// what the interval of a peak holds to either side.
const NOTICED_SCALE_ERROR: f64 = 0.3;

/// Relative round-off of a ratio of scales.
const ROUND_OFF: f64 = 1e-9;

/// Standard deviations within which the scale of a sensor has to agree with theirs: their 90 % interval \[A\].
const SCALE_AGREEMENT: f64 = 1.645;

/// What a closer look at the readings has found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contradictions {
    /// Sensors that contradict the others, and those of them that do not count any more.
    pub doubtful: Vec<bool>,
    pub ignored: Vec<bool>,
    /// Sensors that count and whose scale the others contradict: their gain, their height or their fibre is not as declared.
    pub off_scale: Vec<bool>,
    /// Mean square of the errors of the sensor that is explained worst by the response that explains all of them best, in terms
    /// of the variances of noise and model; at least 1. Beyond [`CONTRADICTION`] no response explains the sensors that count.
    pub misfit: f64,
}

/// The sensors whose readings no response explains that the other sensors consider plausible, and those of them that
/// do not count any more. The sensor without which the others are explained best is the one in doubt; where that holds for two
/// alike, both are, and both count.
///
/// Where more sensors would have to be left out than a minority, or those that are left are hardly explained better, the sensors
/// are not at fault but the responses: what has struck is none of the hypotheses. All sensors count then.
pub(crate) fn contradictions(
    members: &[Member],
    observed: &[Observed],
    sensors: &[Sensor],
) -> Contradictions {
    let count = sensors.len();
    let means = counted_means(observed, count);
    let mut active: Vec<usize> = (0..count)
        .filter(|&sensor| means[sensor] >= LEAST_MEANS)
        .collect();
    let fits: Vec<Vec<Fit>> = members
        .iter()
        .map(|member| {
            let each = sensors.iter().enumerate();
            each.map(|(index, sensor)| member.fit(index, ModelError::of(sensor.quantity)))
                .collect()
        })
        .collect();
    let (mut doubtful, mut ignored) = (vec![false; count], vec![false; count]);
    let all = active.clone();
    let most = (active.len().saturating_sub(1) / 2).max(1);
    while active.len() >= 2 {
        let excluded: Vec<(usize, f64)> = active
            .iter()
            .filter_map(|&sensor| {
                let others = active.iter().copied().filter(|other| *other != sensor);
                let others: Vec<usize> = others.collect();
                let likelihoods: Vec<f64> = members
                    .iter()
                    .zip(&fits)
                    .map(|(member, fits)| {
                        let each = others.iter().map(|&other| fits[other].log_likelihood);
                        member.log_prior + member.log_events + each.sum::<f64>()
                    })
                    .collect();
                let best = largest(likelihoods.iter().copied());
                let plausible = likelihoods.iter().zip(&fits);
                // No error of a model reverses what a sensor reads.
                let misfit = plausible
                    .filter(|(likelihood, _)| **likelihood >= best - PLAUSIBLE)
                    .filter(|(_, fits)| !fits[sensor].is_reversed)
                    .map(|(_, fits)| fits[sensor].squares / means[sensor])
                    .fold(f64::INFINITY, f64::min);
                let is_noticed = || {
                    let witnesses = others.iter().filter(|&&other| {
                        tells_scale(&sensors[other]) && means[other] >= means[sensor]
                    });
                    witnesses.count() >= WITNESSES
                        && self::misfit(members, &fits, &means, &others) <= WELL_EXPLAINED
                };
                let is_excluded = match all.len() {
                    2 => misfit > CONTRADICTION,
                    _ => misfit > EXCLUSION || (misfit > EXCLUSION_BY_OTHERS && is_noticed()),
                };
                is_excluded.then_some((sensor, best))
            })
            .collect();
        let best = largest(excluded.iter().map(|(_, best)| *best));
        let suspects: Vec<usize> = excluded
            .iter()
            .filter(|(_, without)| *without >= best - PLAUSIBLE)
            .map(|(sensor, _)| *sensor)
            .collect();
        for &sensor in &suspects {
            doubtful[sensor] = true;
        }
        let [culprit] = suspects.as_slice() else {
            break;
        };
        ignored[*culprit] = true;
        active.retain(|sensor| sensor != culprit);
    }
    let misfit = |active: &[usize]| misfit(members, &fits, &means, active);
    let left_out = all.len() - active.len();
    let (together, apart) = (misfit(&all), misfit(&active));
    let is_better = all.len() == 2 || apart <= CONTRADICTION.max(together / RELIEF);
    let worst = match left_out <= most && (left_out == 0 || is_better) {
        true => apart,
        false => {
            doubtful.fill(false);
            ignored.fill(false);
            together
        }
    };
    let counted: Vec<usize> = all.into_iter().filter(|it| !ignored[*it]).collect();
    let mut off_scale = vec![false; count];
    let weights = weights_by(members, &fits, &counted);
    // The ratio of a right scale to a wrong one is wrong, too: only that which is furthest off is in doubt, and of two both are.
    let ratios = counted.iter().filter_map(|&sensor| {
        let ratio = scale_ratio(members, &weights, observed, sensors, &ignored, sensor)?;
        Some((sensor, ratio.deviations()))
    });
    let ratios: Vec<(usize, f64)> = ratios.collect();
    let furthest = largest(ratios.iter().map(|(_, by)| *by));
    for &sensor in &counted {
        let is_furthest = |&(it, by): &(usize, f64)| {
            it == sensor && by > SCALE_DOUBT && by >= (1.0 - ROUND_OFF) * furthest
        };
        off_scale[sensor] = is_off_scale(members, &fits, sensors, &counted, sensor)
            || ratios.iter().any(is_furthest);
    }
    Contradictions {
        doubtful,
        ignored,
        off_scale,
        misfit: match worst > CONTRADICTION {
            true => worst,
            false => 1.0,
        },
    }
}

/// Whether a sensor confirms the scale of others.
fn tells_scale(sensor: &Sensor) -> bool {
    ModelError::of(sensor.quantity).scale <= TELLING_SCALE
}

/// Whether the factor between the column's readings and the model's that a sensor shows is improbable, if what the other sensors say of the
/// responses is right.
fn is_off_scale(
    members: &[Member],
    fits: &[Vec<Fit>],
    sensors: &[Sensor],
    counted: &[usize],
    sensor: usize,
) -> bool {
    let others = || counted.iter().copied().filter(|other| *other != sensor);
    if !tells_scale(&sensors[sensor]) || !others().any(|other| tells_scale(&sensors[other])) {
        return false;
    }
    let others: Vec<usize> = others().collect();
    let weights = weights_by(members, fits, &others);
    // Sums of the weights and of their squares, and of the factor, its square and its variance by noise.
    let [mut total, mut squares, mut mean, mut spread, mut noise] = [0.0; 5];
    for (member, weight) in members.iter().zip(weights) {
        let [_, cross, predicted] = member.sums(sensor);
        if weight > 0.0 && predicted > 0.0 {
            let off = cross / predicted;
            total += weight;
            squares += weight * weight;
            mean += weight * off;
            spread += weight * off * off;
            noise += weight / predicted;
        }
    }
    let effective = total * total / squares;
    let mean = mean / total;
    let between = (spread / total - mean * mean).max(0.0);
    let scale = ModelError::of(sensors[sensor].quantity).scale;
    let variance = scale * scale + noise / total + widened(between, effective);
    mean.abs() > SCALE_DOUBT * variance.sqrt()
}

/// Weights of the members by these sensors.
fn weights_by(members: &[Member], fits: &[Vec<Fit>], counted: &[usize]) -> Vec<f64> {
    let logs = members.iter().zip(fits).map(|(member, fits)| {
        let each = counted.iter().map(|&sensor| fits[sensor].log_likelihood);
        member.log_prior + member.log_events - member.log_drawn + each.sum::<f64>()
    });
    let logs: Vec<f64> = logs.collect();
    let best = largest(logs.iter().copied());
    logs.iter().map(|log| libm::exp(log - best)).collect()
}

/// Logarithm of the ratio of the scale of a sensor to that of others, with the standard deviation: of two sensors, each is as far off as the
/// other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScaleRatio {
    off: f64,
    deviation: f64,
}

impl ScaleRatio {
    /// By how many standard deviations it differs.
    fn deviations(&self) -> f64 {
        self.off.abs() / self.deviation
    }

    /// Whether the others confirm the scale: it agrees with theirs, and they would have put one in doubt that is off by
    /// [`NOTICED_SCALE_ERROR`].
    pub fn confirms(&self) -> bool {
        self.deviations() <= SCALE_AGREEMENT && SCALE_DOUBT * self.deviation <= NOTICED_SCALE_ERROR
    }
}

/// Compares the scale of a sensor with that of all others that tell theirs, by members with these weights; `None` if no other one does.
///
/// As long as the column is elastic, a harder hit makes all readings larger alike. What the data leave open of the size of the hit, and with it
/// how far apart the responses are, does not count therefore, other than in [`is_off_scale`].
pub(crate) fn scale_ratio(
    members: &[Member],
    weights: &[f64],
    observed: &[Observed],
    sensors: &[Sensor],
    ignored: &[bool],
    sensor: usize,
) -> Option<ScaleRatio> {
    let others = telling(sensor, observed, sensors, ignored);
    if others.is_empty() || !tells_now(sensor, observed, sensors) {
        return None;
    }
    // Factor of a sensor's readings by a member, and its variance by noise and model.
    let factor = |member: &Member, sensor: usize| {
        let [_, cross, predicted] = member.sums(sensor);
        let scale = ModelError::of(sensors[sensor].quantity).scale;
        (predicted > 0.0).then(|| (1.0 + cross / predicted, scale * scale + 1.0 / predicted))
    };
    let [mut total, mut squares, mut mean, mut spread, mut variance] = [0.0; 5];
    for (member, &weight) in members.iter().zip(weights) {
        if weight <= 0.0 {
            continue;
        }
        let Some((own, own_variance)) = factor(member, sensor) else {
            continue;
        };
        let each = others.iter().filter_map(|other| factor(member, *other));
        let [precision, sum] = each.fold([0.0; 2], |[precision, sum], (factor, variance)| {
            [precision + 1.0 / variance, sum + factor / variance]
        });
        let by_others = sum / precision;
        if precision > 0.0 && by_others > 0.0 && own > 0.0 {
            let off = libm::log(own / by_others);
            total += weight;
            squares += weight * weight;
            mean += weight * off;
            spread += weight * off * off;
            variance += weight * (own_variance + 1.0 / precision);
        }
    }
    let effective = total * total / squares;
    let mean = mean / total;
    let between = (spread / total - mean * mean).max(0.0);
    let deviation = (variance / total + widened(between, effective)).sqrt();
    deviation.is_finite().then_some(ScaleRatio {
        off: mean,
        deviation,
    })
}

/// The variance between so many effective responses, and of their mean: the fewer count, the less they show how far apart those are that
/// were not computed.
fn widened(between: f64, effective: f64) -> f64 {
    match effective > 1.0 {
        true => between * (1.0 + 1.0 / (effective - 1.0)),
        false => f64::INFINITY,
    }
}

/// Whether the weighted responses need a factor of one of these sensors that is so far from 1 that its scale may be in doubt.
pub(crate) fn may_be_off_scale(
    members: &[Member],
    weights: &[f64],
    sensors: &[Sensor],
    ignored: &[bool],
) -> bool {
    let each = sensors.iter().zip(ignored).enumerate();
    let mut telling = each.filter(|(_, (sensor, ignored))| !**ignored && tells_scale(sensor));
    telling.any(|(index, (sensor, _))| {
        let scale = ModelError::of(sensor.quantity).scale;
        let expected = |member: &Member| {
            let [_, cross, predicted] = member.sums(index);
            cross / (predicted + 1.0 / (scale * scale))
        };
        let weighted = members.iter().zip(weights).filter(|it| *it.1 > 0.0);
        let mean = weighted.fold(0.0, |sum, (member, weight)| sum + weight * expected(member));
        mean.abs() > SCALE_SUSPICION * scale
    })
}

/// Whether the newest data of a sensor tell a scale. Strains tell none once the column has yielded.
fn tells_now(sensor: usize, observed: &[Observed], sensors: &[Sensor]) -> bool {
    let newest = observed.last().and_then(|(_, means)| means[sensor]);
    newest.is_some_and(|mean| !mean.yielded) && tells_scale(&sensors[sensor])
}

/// The other sensors that count and tell the scale of this one by the newest data.
fn telling(
    sensor: usize,
    observed: &[Observed],
    sensors: &[Sensor],
    ignored: &[bool],
) -> Vec<usize> {
    let others = (0..sensors.len()).filter(|it| *it != sensor && !ignored[*it]);
    others
        .filter(|it| tells_now(*it, observed, sensors))
        .collect()
}

/// Precision with which the other sensors that count tell the scale of this one by the newest data: by the factors between column and model
/// of theirs and of its quantity.
pub(crate) fn scale_precision(
    sensor: usize,
    observed: &[Observed],
    sensors: &[Sensor],
    ignored: &[bool],
) -> f64 {
    let others = telling(sensor, observed, sensors, ignored).into_iter();
    let others = others.fold(0.0, |sum, other| {
        let scale = ModelError::of(sensors[other].quantity).scale;
        sum + 1.0 / (scale * scale)
    });
    let own = ModelError::of(sensors[sensor].quantity).scale;
    if others > 0.0 {
        1.0 / (own * own + 1.0 / others)
    } else {
        0.0
    }
}

/// Of each sensor, how many means with errors of their own there are.
fn counted_means(observed: &[Observed], sensors: usize) -> Vec<f64> {
    let of_sensor = |sensor: usize| {
        let read = observed.iter().filter(|(_, means)| means[sensor].is_some());
        read.fold(0.0, |sum, (block, _)| sum + block.share_of_mean())
    };
    (0..sensors).map(of_sensor).collect()
}

/// Mean square of the errors of the sensor that is explained worst, among these, by the plausible response that explains it best.
fn misfit(members: &[Member], fits: &[Vec<Fit>], means: &[f64], active: &[usize]) -> f64 {
    let likelihoods = members.iter().zip(fits).map(|(member, fits)| {
        let each = active.iter().map(|&sensor| fits[sensor].log_likelihood);
        member.log_prior + member.log_events + each.sum::<f64>()
    });
    let likelihoods: Vec<f64> = likelihoods.collect();
    let best = largest(likelihoods.iter().copied());
    let plausible = likelihoods.iter().zip(fits);
    let worst = plausible
        .filter(|(likelihood, _)| **likelihood >= best - PLAUSIBLE)
        .map(|(_, fits)| {
            let each = active
                .iter()
                .map(|&sensor| fits[sensor].squares / means[sensor]);
            largest(each)
        })
        .fold(f64::INFINITY, f64::min);
    if worst.is_finite() { worst } else { 1.0 }
}

/// The largest; minus infinity without any.
pub(crate) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}
