//! Sensors that contradict each other.

use crate::estimation::inference::member::{Fit, Member};
use crate::estimation::inference::model_error::ModelError;
use crate::estimation::inference::weighing::Observed;
use crate::sensors::Sensor;

/// Blocks that a sensor needs before it may contradict the others.
const LEAST_BLOCKS: usize = 5;

/// Logarithm of a ratio of likelihoods beyond which a response is not plausible any more.
const PLAUSIBLE: f64 = 6.0;

/// Mean square of a sensor's errors, in terms of the variances of noise and model, that no plausible response may exceed.
const CONTRADICTION: f64 = 4.0;

/// Whether a response that the data make likely explains what every sensor reads. If so, no sensor contradicts the others, and
/// the closer look of [`contradictions`] is not necessary.
pub(crate) fn explains_all(members: &[Member], observed: &[Observed], sensors: &[Sensor]) -> bool {
    let up_to_date = || members.iter().filter(|it| it.seen == observed.len());
    let best = largest(up_to_date().map(Member::log_posterior));
    let blocks: Vec<usize> = (0..sensors.len())
        .map(|sensor| {
            let means = observed.iter().map(|(_, means)| means[sensor]);
            means.flatten().count()
        })
        .collect();
    up_to_date()
        .filter(|member| member.log_posterior() >= best - PLAUSIBLE)
        .any(|member| {
            let mut each = sensors.iter().zip(&blocks).enumerate();
            each.all(|(index, (sensor, &blocks))| {
                let error = ModelError::of(sensor.quantity);
                Fit::new(member.sums(index), error).squares <= CONTRADICTION * blocks as f64
            })
        })
}

/// The same from which on one of three or more sensors is left out: a wrong model of the vehicle or of the column explains a smaller
/// misfit. Of two, which are all that there is, neither confirms the model, and [`CONTRADICTION`] is enough.
const EXCLUSION: f64 = 25.0;

/// Leaving out sensors has to divide the misfit of the others by this number, unless they are explained then.
const RELIEF: f64 = 4.0;

/// Largest standard deviation of the factor between column and model of a quantity that confirms the scale of other sensors.
const TELLING_SCALE: f64 = 0.1;

/// Standard deviations of the factor that a sensor shows, if the others are right, from which on its scale is in doubt: a right one is with a
/// probability of 1 %.
const SCALE_DOUBT: f64 = 2.5;

/// The same of the factor by all sensors together, from which on a closer look is necessary: it is drawn towards that of the sensor.
const SCALE_SUSPICION: f64 = 1.25;

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
    let blocks: Vec<usize> = (0..count)
        .map(|sensor| {
            let means = observed.iter().map(|(_, means)| means[sensor]);
            means.flatten().count()
        })
        .collect();
    let mut active: Vec<usize> = (0..count)
        .filter(|&sensor| blocks[sensor] >= LEAST_BLOCKS)
        .collect();
    let fits: Vec<Vec<Fit>> = members
        .iter()
        .map(|member| {
            let each = sensors.iter().enumerate();
            each.map(|(index, sensor)| {
                Fit::new(member.sums(index), ModelError::of(sensor.quantity))
            })
            .collect()
        })
        .collect();
    let mut found = [vec![false; count], vec![false; count]];
    let all = active.clone();
    let most = (active.len().saturating_sub(1) / 2).max(1);
    while active.len() >= 2 {
        let excluded: Vec<(usize, f64)> = active
            .iter()
            .filter_map(|&sensor| {
                let others = active.iter().copied().filter(|other| *other != sensor);
                let likelihoods: Vec<f64> = members
                    .iter()
                    .zip(&fits)
                    .map(|(member, fits)| {
                        let each = others.clone().map(|other| fits[other].log_likelihood);
                        member.log_prior + member.log_events + each.sum::<f64>()
                    })
                    .collect();
                let best = largest(likelihoods.iter().copied());
                let plausible = likelihoods.iter().zip(&fits);
                let misfit = plausible
                    .filter(|(likelihood, _)| **likelihood >= best - PLAUSIBLE)
                    .map(|(_, fits)| fits[sensor].squares / blocks[sensor] as f64)
                    .fold(f64::INFINITY, f64::min);
                let most = match all.len() {
                    2 => CONTRADICTION,
                    _ => EXCLUSION,
                };
                (misfit > most).then_some((sensor, best))
            })
            .collect();
        let best = largest(excluded.iter().map(|(_, best)| *best));
        let suspects: Vec<usize> = excluded
            .iter()
            .filter(|(_, without)| *without >= best - PLAUSIBLE)
            .map(|(sensor, _)| *sensor)
            .collect();
        for &sensor in &suspects {
            found[0][sensor] = true;
        }
        let [culprit] = suspects.as_slice() else {
            break;
        };
        found[1][*culprit] = true;
        active.retain(|sensor| sensor != culprit);
    }
    let misfit = |active: &[usize]| misfit(members, &fits, &blocks, active);
    let left_out = all.len() - active.len();
    let (together, apart) = (misfit(&all), misfit(&active));
    let is_better = all.len() == 2 || apart <= CONTRADICTION.max(together / RELIEF);
    let worst = match left_out <= most && (left_out == 0 || is_better) {
        true => apart,
        false => {
            found = [vec![false; count], vec![false; count]];
            together
        }
    };
    let [doubtful, ignored] = found;
    let counted: Vec<usize> = all.into_iter().filter(|it| !ignored[*it]).collect();
    let mut off_scale = vec![false; count];
    for &sensor in &counted {
        off_scale[sensor] = is_off_scale(members, &fits, sensors, &counted, sensor);
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
    let logs = members.iter().zip(fits).map(|(member, fits)| {
        let each = others().map(|other| fits[other].log_likelihood);
        member.log_prior + member.log_events - member.log_drawn + each.sum::<f64>()
    });
    let logs: Vec<f64> = logs.collect();
    let best = largest(logs.iter().copied());
    // Sums of the weights and of their squares, and of the factor, its square and its variance by noise.
    let [mut total, mut squares, mut mean, mut spread, mut noise] = [0.0; 5];
    for (member, log) in members.iter().zip(logs) {
        let [_, cross, predicted] = member.sums(sensor);
        let weight = libm::exp(log - best);
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
    // The fewer responses count, the less they show how far apart those are that were not computed.
    let of_few = if effective > 1.0 {
        1.0 / (effective - 1.0)
    } else {
        f64::INFINITY
    };
    let scale = ModelError::of(sensors[sensor].quantity).scale;
    let variance = scale * scale + noise / total + (1.0 + of_few) * between;
    mean.abs() > SCALE_DOUBT * variance.sqrt()
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

/// Precision with which the other sensors that count tell the scale of this one by the newest data: by the factors between column and model
/// of theirs and of its quantity. Strains tell nothing once the column has yielded.
pub(crate) fn scale_precision(
    sensor: usize,
    observed: &[Observed],
    sensors: &[Sensor],
    ignored: &[bool],
) -> f64 {
    let Some((_, newest)) = observed.last() else {
        return 0.0;
    };
    let each = newest.iter().zip(sensors).zip(ignored).enumerate();
    let telling = each.filter(|(index, ((mean, other), ignored))| {
        let tells = mean.is_some_and(|mean| !mean.yielded) && tells_scale(other);
        *index != sensor && !**ignored && tells
    });
    let others = telling.fold(0.0, |sum, (_, ((_, other), _))| {
        let scale = ModelError::of(other.quantity).scale;
        sum + 1.0 / (scale * scale)
    });
    let own = ModelError::of(sensors[sensor].quantity).scale;
    if others > 0.0 {
        1.0 / (own * own + 1.0 / others)
    } else {
        0.0
    }
}

/// Mean square of the errors of the sensor that is explained worst, among these, by the plausible response that explains it best.
fn misfit(members: &[Member], fits: &[Vec<Fit>], blocks: &[usize], active: &[usize]) -> f64 {
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
                .map(|&sensor| fits[sensor].squares / blocks[sensor] as f64);
            largest(each)
        })
        .fold(f64::INFINITY, f64::min);
    if worst.is_finite() { worst } else { 1.0 }
}

/// The largest; minus infinity without any.
pub(crate) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}
