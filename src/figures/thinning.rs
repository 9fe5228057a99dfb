//! Thins long histories to what the pixels of a figure can show, without losing an extreme value.

use crate::column::{MAX_MASSES, Sample};
use crate::observables::{
    CONTACT_FORCE, CRUSH, DAMPING_WORK, ELASTIC_ENERGY, IMPACT_IMPULSE, IMPACT_LOSS, IMPACTOR,
    KINETIC_ENERGY, LOAD_WORK, MOMENT, NORMAL_FORCE, Observable, PLASTIC_WORK, SPRING_FORCE, U1,
    U2, V1, each,
};

/// Keeps the samples of a history that a figure needs: in each of many equal intervals of time the first, the last, and
/// those with the lowest and the highest value of every quantity drawn.
///
/// Samples are pushed one by one; the memory is bounded by the number of intervals, not by the length of the history.
#[derive(Debug, Clone)]
pub struct HistoryThinning {
    /// Length of an interval \[s\]; 0: every sample is kept.
    interval: f64,
    /// End of the current interval \[s\]; minus infinity before the first sample.
    interval_end: f64,
    /// Samples of the current interval.
    pending: Vec<Sample>,
    kept: Vec<Sample>,
}

/// Number of intervals of a history: a few per pixel of the widest figure.
const INTERVALS: f64 = 2000.0;

/// Histories up to this number of samples are kept completely.
const MAX_COMPLETE: u64 = 20_000;

/// Maximum number of samples of an interval, which bounds the memory; an interval with more samples counts as several.
const MAX_PENDING: usize = 4096;

impl HistoryThinning {
    /// For a history of `samples` samples and this duration \[s\].
    pub fn new(samples: u64, duration: f64) -> Self {
        Self {
            interval: if samples <= MAX_COMPLETE {
                0.0
            } else {
                duration / INTERVALS
            },
            interval_end: f64::NEG_INFINITY,
            pending: Vec::new(),
            kept: Vec::new(),
        }
    }

    /// Takes the next sample; time does not run backwards.
    pub fn push(&mut self, sample: &Sample) {
        if self.interval <= 0.0 {
            self.kept.push(*sample);
            return;
        }
        if sample.time >= self.interval_end || self.pending.len() >= MAX_PENDING {
            self.close_interval();
            self.interval_end = ((sample.time / self.interval).floor() + 1.0) * self.interval;
        }
        self.pending.push(*sample);
    }

    /// Returns the samples kept, in the order of time.
    pub fn finish(mut self) -> Vec<Sample> {
        self.close_interval();
        self.kept
    }

    fn close_interval(&mut self) {
        let Some(last) = self.pending.len().checked_sub(1) else {
            return;
        };
        let mut chosen = vec![0, last];
        for (quantity, index) in each(&DRAWN, MAX_MASSES) {
            let value = |place: usize| quantity.value(&self.pending[place], index);
            let (mut lowest, mut highest) = (0, 0);
            for place in 0..=last {
                if value(place) < value(lowest) {
                    lowest = place;
                }
                if value(place) > value(highest) {
                    highest = place;
                }
            }
            chosen.extend([lowest, highest]);
        }
        chosen.sort_unstable();
        chosen.dedup();
        self.kept
            .extend(chosen.into_iter().map(|place| self.pending[place]));
        self.pending.clear();
    }
}

/// What the figures draw of a sample.
const DRAWN: [Observable; 16] = [
    V1,
    IMPACTOR,
    U1,
    U2,
    CONTACT_FORCE,
    IMPACT_IMPULSE,
    KINETIC_ENERGY,
    ELASTIC_ENERGY,
    PLASTIC_WORK,
    IMPACT_LOSS,
    DAMPING_WORK,
    LOAD_WORK,
    NORMAL_FORCE,
    MOMENT,
    CRUSH,
    SPRING_FORCE,
];

/// The first, lowest, highest and last point in each of `columns` equal intervals of x, in order.
///
/// x must not decrease; points that are not finite are left out.
pub(super) fn thin_curve(points: &[(f64, f64)], columns: usize) -> Vec<(f64, f64)> {
    let finite = || {
        points
            .iter()
            .copied()
            .filter(|(x, y)| x.is_finite() && y.is_finite())
    };
    let (Some(first), Some(last)) = (finite().next(), finite().next_back()) else {
        return Vec::new();
    };
    if points.len() <= 4 * columns || last.0 <= first.0 {
        return finite().collect();
    }
    let column = |x: f64| ((x - first.0) / (last.0 - first.0) * columns as f64) as usize;
    let all: Vec<_> = finite().collect();
    all.chunk_by(|left, right| column(left.0) == column(right.0))
        .flat_map(extremes)
        .collect()
}

/// The first, lowest, highest and last point of one interval, each once and in order.
fn extremes(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let by_height = |left: &usize, right: &usize| points[*left].1.total_cmp(&points[*right].1);
    let mut chosen = vec![0, points.len() - 1];
    chosen.extend((0..points.len()).min_by(by_height));
    chosen.extend((0..points.len()).max_by(by_height));
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|place| points[place])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fast vibration with one spike of one sample.
    fn vibration(count: usize) -> Vec<Sample> {
        (0..count)
            .map(|number| {
                let time = number as f64 * 1e-5;
                let mut sample = Sample {
                    time,
                    v1: (time * 5000.0).sin(),
                    ..Sample::default()
                };
                if number == count / 3 {
                    sample.contact_force = 1e6;
                    sample.hinges[2].moment = -4e5;
                }
                if number == count / 2 {
                    sample.impact_impulse = 880.0;
                }
                sample
            })
            .collect()
    }

    fn thinned(samples: &[Sample]) -> Vec<Sample> {
        let mut thinning = HistoryThinning::new(samples.len() as u64, samples.last().unwrap().time);
        samples.iter().for_each(|sample| thinning.push(sample));
        thinning.finish()
    }

    #[test]
    fn short_histories_are_kept_completely() {
        let samples = vibration(5000);
        assert_eq!(thinned(&samples), samples);
        assert!(HistoryThinning::new(0, 0.0).finish().is_empty());
    }

    #[test]
    fn long_histories_lose_no_extreme() {
        let samples = vibration(400_000);
        let few = thinned(&samples);
        assert!(few.len() < 20_000, "{}", few.len());
        assert_eq!((few[0], few.last()), (samples[0], samples.last()));
        assert!(few.is_sorted_by(|left, right| left.time < right.time));
        for (quantity, index) in each(&DRAWN, MAX_MASSES) {
            let range = |samples: &[Sample]| {
                samples
                    .iter()
                    .map(|sample| quantity.value(sample, index))
                    .fold((f64::MAX, f64::MIN), |(low, high), value| {
                        (low.min(value), high.max(value))
                    })
            };
            assert_eq!(range(&few), range(&samples), "{quantity:?} {index}");
        }
    }

    #[test]
    fn curves_lose_no_extreme_in_any_column() {
        let points: Vec<_> = (0..100_000)
            .map(|number| (f64::from(number), f64::from(number * 7919 % 1009)))
            .collect();
        let thin = thin_curve(&points, 500);
        assert!(thin.len() <= 4 * 501);
        assert!(thin.is_sorted_by(|left, right| left.0 < right.0));
        for part in points.chunks(100_000 / 50) {
            let inside =
                |point: &&(f64, f64)| (part[0].0..=part[part.len() - 1].0).contains(&point.0);
            let highest = |of: &mut dyn Iterator<Item = f64>| of.fold(f64::MIN, f64::max);
            let all = highest(&mut part.iter().map(|point| point.1));
            let kept = highest(&mut thin.iter().filter(inside).map(|point| point.1));
            assert!((all - kept).abs() <= 0.0, "{all} {kept}");
        }
    }

    #[test]
    fn points_that_are_not_finite_are_left_out() {
        assert!(thin_curve(&[], 10).is_empty());
        assert!(thin_curve(&[(f64::NAN, 1.0)], 10).is_empty());
        assert_eq!(
            thin_curve(&[(0.0, 1.0), (1.0, f64::INFINITY)], 10),
            [(0.0, 1.0)]
        );
    }
}
