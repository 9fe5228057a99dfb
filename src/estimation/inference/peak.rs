//! What an estimate states of the peak displacement: what the responses predict for it, and what a sensor at the impact point has read.

use std::f64::consts::FRAC_PI_2;

use crate::estimation::inference::blocks::{CLIPPED, Highest, Records};
use crate::estimation::inference::comparison::SensorComparison;
use crate::estimation::inference::estimate::{CredibleInterval, Spread, share_below};
use crate::estimation::inference::estimator::{Estimator, effective};
use crate::estimation::inference::member::Member;
use crate::estimation::inference::model_error::ModelError;
use crate::estimation::inference::statement::{TO_COME, UNLIKE_CATALOGUE};
use crate::sensors::Quantity;

/// A displacement sensor measures the peak of the impact point if it is no further from it than this share of the part of the
/// column on its side: the column moves there as the impact point does, but for some hundredths.
const AT_IMPACT: f64 = 0.05;

/// Standard deviations of a measured peak by which readings rise above it that are not of the impact any more, and by which the peak is
/// smaller at most.
const RISE: f64 = 3.0;

/// Smallest peak whose logarithm is taken \[m\].
const LEAST_PEAK: f64 = 1e-7;

/// Probability that the responses are right where a sensor at the impact point contradicts all others \[A\]: either this sensor or every
/// hypothesis is wrong, and nothing tells which.
const CONTRADICTED: f64 = 0.5;

/// Factor by which hypotheses that are wrong may miss a peak \[A\]. A sensor that is further off is broken.
const MISSED_PEAK: f64 = 2.0;

/// Periods of the column after a light vehicle has left it within which its vibrations by several modes add up to their largest sum: a
/// damping of 2 % has reduced them to a third after ten \[A\].
const VIBRATIONS_OF_LIGHT_FRONTS: f64 = 10.0;

impl Estimator {
    /// What a sensor at the height of the impact point has read of its peak displacement, and the index of the sensor; `None` without such
    /// a sensor that counts. The most exact one tells it.
    fn measured_peak(&self) -> Option<(usize, &Records)> {
        self.peak_by_sensors(false)
    }

    /// The same by the sensors that contradict the others, or by those that do not.
    fn peak_by_sensors(&self, contradicting: bool) -> Option<(usize, &Records)> {
        let properties = self.population.properties();
        let each = self.sensors.iter().enumerate();
        let at_impact = each.filter(|(index, sensor)| {
            let away = sensor.height - properties.length_below;
            let part = match away <= 0.0 {
                true => properties.length_below,
                false => properties.length_above,
            };
            sensor.quantity == Quantity::Displacement
                && away.abs() <= AT_IMPACT * part
                && self.contradicts(*index) == contradicting
        });
        let measured = at_impact.filter_map(|(index, sensor)| {
            let records = self.highest.get(index)?.as_ref()?;
            // A sensor at the end of its range has not seen the peak.
            let is_whole = sensor.range == 0.0 || records.last().value < CLIPPED * sensor.range;
            is_whole.then_some((index, records))
        });
        measured.min_by(|(_, a), (_, b)| a.last().deviation.total_cmp(&b.last().deviation))
    }

    /// When the column has its peak behind it by one response \[s\].
    fn past_peak(&self, member: &Member) -> f64 {
        self.contact[0] + member.delay + self.past_peak_after_contact(member)
    }

    /// The same from contact on: it does not move further once the vehicle has left it, but for a vibration, and for the sum of several
    /// under a light front.
    pub(super) fn past_peak_after_contact(&self, member: &Member) -> f64 {
        let report = &member.prediction.report;
        let left = report.release_time.unwrap_or(report.max_v1_time);
        let vibrations = match member.front.by_light_front() > 0.0 {
            true => VIBRATIONS_OF_LIGHT_FRONTS,
            false => 1.0,
        };
        left.max(report.max_v1_time) + vibrations * self.period
    }

    /// The sensor that tells the peak, if its readings rise on when by most of the weighted responses the column has its peak behind it.
    pub(super) fn rises_on(&self, weights: &[f64]) -> Option<usize> {
        let (sensor, records) = self.measured_peak()?;
        let last = records.last();
        let rises = self.weighted(weights).filter(|(member, _)| {
            let peak = records.by(self.past_peak(member));
            let stands = member.prediction.report.outcome.stands();
            stands && last.value - peak.value > RISE * peak.deviation
        });
        let share = rises.fold(0.0, |sum, (_, weight)| sum + weight);
        (share > 0.5).then_some(sensor)
    }

    /// Peak displacement of the impact point by one response, relative to the column before the impact \[m\]: its logarithm with its
    /// standard deviation. What a sensor has measured counts, and once the response is past its peak while it reads, it is the peak.
    fn peak_by(&self, member: &Member, measured: Option<&Records>) -> [f64; 2] {
        let [scale, scatter] = member.scale;
        let report = &member.prediction.report;
        let added = report.max_v1 - self.rest_v1;
        let mut peak = (scale * added).max(LEAST_PEAK);
        let shape = ModelError::of(Quantity::Displacement).share(report.max_v1_time);
        let error = libm::hypot(shape, self.impact_error(member, true));
        let error = libm::hypot(error, member.front.by_light_front());
        let mut deviation = libm::hypot(scatter * added, error * added);
        if let Some(records) = measured {
            let past_peak = self.past_peak(member);
            let Highest {
                value: highest,
                deviation: noise,
                ..
            } = records.by(past_peak);
            // What several vibrations add up to is the peak only when they are over.
            let settled = match member.front.by_light_front() > 0.0 {
                true => past_peak,
                false => self.contact[0] + member.delay + report.max_v1_time,
            };
            if records.seen_until > settled {
                // Prediction and measurement, each by its precision.
                let [own, other] = [1.0 / (deviation * deviation), 1.0 / (noise * noise)];
                peak = (own * peak + other * highest) / (own + other);
                deviation = (1.0 / (own + other)).sqrt();
            } else if highest > peak {
                (peak, deviation) = (highest, deviation.max(noise));
            }
        }
        // As long as a vehicle moves the column further, it may press on otherwise: the less of its energy is left, the less probably and the
        // less otherwise.
        let left = self.energy_left(member);
        let otherwise = TO_COME * left * (UNLIKE_CATALOGUE * left).sqrt();
        deviation = libm::hypot(deviation, otherwise * peak);
        logarithm_of_peak(peak, deviation)
    }

    /// Share of the energy of a soft front that it has not yet lost on the way to the peak, about: its speed falls as a cosine does until
    /// the peak. A hard front loses most of it at once.
    fn energy_left(&self, member: &Member) -> f64 {
        if self.is_hard(member) {
            return 0.0;
        }
        let peak_at = member.prediction.report.max_v1_time.max(f64::MIN_POSITIVE);
        let way = ((self.seen() - member.delay) / peak_at).clamp(0.0, 1.0);
        libm::cos(FRAC_PI_2 * way).powi(2)
    }

    /// Standard deviation of the logarithm of the peak by the scale of the sensor that tells it: the less, the better other sensors confirm
    /// this scale, and 0 without such a sensor.
    #[must_use]
    pub fn peak_scale_deviation(&self) -> f64 {
        self.measured_peak()
            .map_or(0.0, |(sensor, _)| self.scale_deviation(sensor))
    }

    /// What a sensor at the impact point that contradicts the others says of the logarithm of the peak; `None` without such a sensor, and where
    /// it is so far from what the members say that it is broken.
    fn contradicting_peak(&self, by_members: &[Spread]) -> Option<Spread> {
        let (sensor, records) = self.peak_by_sensors(true)?;
        let read = self.peak_read_by(sensor, records);
        let [sum, total] = by_members.iter().fold([0.0; 2], |[sum, total], it| {
            [sum + it.weight * it.mean, total + it.weight]
        });
        ((read.mean - sum / total).abs() <= libm::log(MISSED_PEAK)).then_some(read)
    }

    /// What the sensor that tells the peak says of its logarithm, if its readings stray from what the members predict for it: `None`
    /// otherwise.
    fn straying_peak(&self, compared: &[SensorComparison]) -> Option<Spread> {
        let (sensor, records) = self.measured_peak()?;
        let comparison = compared.iter().find(|it| it.sensor == sensor)?;
        Self::strays(comparison).then(|| self.peak_read_by(sensor, records))
    }

    /// What a sensor says of the logarithm of the peak by what it has read alone, with the probability that the members are wrong.
    fn peak_read_by(&self, sensor: usize, records: &Records) -> Spread {
        let Highest {
            value, deviation, ..
        } = records.last();
        let [mean, deviation] = logarithm_of_peak(value, deviation);
        Spread {
            mean,
            deviation: libm::hypot(deviation, self.scale_deviation(sensor)),
            weight: 1.0 - CONTRADICTED,
        }
    }

    /// Probability that the members are right about the peak.
    pub(super) fn right_about_peak(&self, weights: &[f64]) -> f64 {
        self.contradicting_peak(&self.peaks_by_members(weights))
            .map_or(1.0, |_| CONTRADICTED)
    }

    /// The peak displacement of the impact point \[m\].
    pub(super) fn peak(&self, weights: &[f64], compared: &[SensorComparison]) -> CredibleInterval {
        let (least, before) = (self.least_peak(weights), self.rest_v1);
        CredibleInterval::of_spread(self.spread_of_peaks(weights, compared), effective(weights))
            .map(|log| libm::exp(log.max(least)) + before)
    }

    /// The share of its distribution that is below this one \[m\].
    pub(super) fn share_below_peak(
        &self,
        weights: &[f64],
        compared: &[SensorComparison],
        peak_v1: f64,
    ) -> f64 {
        let log = libm::log((peak_v1 - self.rest_v1).max(LEAST_PEAK));
        share_below(
            self.spread_of_peaks(weights, compared),
            effective(weights),
            log,
        )
    }

    /// What is known of the logarithm of the peak that the impact adds.
    fn spread_of_peaks(&self, weights: &[f64], compared: &[SensorComparison]) -> Vec<Spread> {
        let mut each = self.peaks_by_members(weights);
        let other = self.contradicting_peak(&each);
        if let Some(other) = other.or_else(|| self.straying_peak(compared)) {
            each.iter_mut().for_each(|it| it.weight *= CONTRADICTED);
            each.push(other);
        }
        each
    }

    /// What the members say of it.
    fn peaks_by_members(&self, weights: &[f64]) -> Vec<Spread> {
        let scale = self.peak_scale_deviation();
        let records = self.measured_peak().map(|(_, records)| records);
        let each = self.weighted(weights).map(|(member, weight)| {
            let [mean, deviation] = self.peak_by(member, records);
            Spread {
                mean,
                deviation: libm::hypot(deviation, scale),
                weight,
            }
        });
        each.collect()
    }

    /// The logarithm of the least peak that the readings leave possible, however a vehicle presses on: three standard deviations below the
    /// largest one, which noise makes larger than the peak.
    fn least_peak(&self, weights: &[f64]) -> f64 {
        let of_impact = self
            .measured_peak()
            .filter(|_| self.rises_on(weights).is_none());
        of_impact.map_or(f64::NEG_INFINITY, |(sensor, records)| {
            let read = self.peak_read_by(sensor, records);
            read.mean - RISE * read.deviation
        })
    }
}

/// The logarithm of a peak \[m\] with its standard deviation.
fn logarithm_of_peak(peak: f64, deviation: f64) -> [f64; 2] {
    let peak = peak.max(LEAST_PEAK);
    [libm::log(peak), (deviation / peak).min(1.0)]
}
