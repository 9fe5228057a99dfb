//! Long histories, thinned to what the pixels of a figure can show without losing an extreme value.

use crate::column::Sample;

/// Keeps of a history the samples that a figure needs: in each of many equal parts of its time the first, the
/// last, and those with the lowest and the highest value of every quantity that is drawn.
///
/// Samples are pushed one by one; memory is bounded by the number of parts, not by the length of the history.
#[derive(Debug, Clone)]
pub struct Thinning {
    part: f64,
    /// End of the part that is being filled \[s\]; infinitely early before the first sample.
    part_end: f64,
    /// Samples of that part.
    pending: Vec<Sample>,
    kept: Vec<Sample>,
}

/// Parts of a history: a few per pixel of the widest figure.
const PARTS: f64 = 2000.0;

/// Histories up to this many samples are kept as they are.
const KEPT_WHOLE: u64 = 20_000;

/// Bounds the memory of one part; a part with more samples counts as several.
const PENDING: usize = 4096;

impl Thinning {
    /// For a history of so many samples that lasts so long \[s\].
    pub fn new(samples: u64, duration: f64) -> Self {
        Self {
            part: if samples <= KEPT_WHOLE {
                0.0
            } else {
                duration / PARTS
            },
            part_end: f64::NEG_INFINITY,
            pending: Vec::new(),
            kept: Vec::new(),
        }
    }

    /// Takes the next sample; time does not run backwards.
    pub fn push(&mut self, sample: &Sample) {
        if self.part <= 0.0 {
            self.kept.push(*sample);
            return;
        }
        if sample.time >= self.part_end || self.pending.len() >= PENDING {
            self.close_part();
            self.part_end = ((sample.time / self.part).floor() + 1.0) * self.part;
        }
        self.pending.push(*sample);
    }

    /// The samples kept, in the order of time.
    pub fn finish(mut self) -> Vec<Sample> {
        self.close_part();
        self.kept
    }

    fn close_part(&mut self) {
        let Some(last) = self.pending.len().checked_sub(1) else {
            return;
        };
        let mut chosen = vec![0, last];
        for quantity in 0..QUANTITIES {
            let (mut lowest, mut highest) = (0, 0);
            for (place, sample) in self.pending.iter().enumerate() {
                let value = drawn(sample)[quantity];
                if value < drawn(&self.pending[lowest])[quantity] {
                    lowest = place;
                }
                if value > drawn(&self.pending[highest])[quantity] {
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

const QUANTITIES: usize = 18;

/// What the figures draw of a sample.
fn drawn(sample: &Sample) -> [f64; QUANTITIES] {
    let [hinge_1a, hinge_1b, hinge_2, hinge_3] = &sample.hinges;
    [
        sample.v1,
        sample.impactor_position,
        sample.u1,
        sample.u2,
        sample.contact_force,
        sample.percussion,
        sample.kinetic_energy,
        sample.elastic_energy,
        sample.plastic_work,
        sample.impact_loss,
        sample.damping_work,
        sample.load_work,
        hinge_1a.normal_force,
        hinge_1b.normal_force,
        hinge_1a.moment,
        hinge_1b.moment,
        hinge_2.moment,
        hinge_3.moment,
    ]
}

/// First, lowest, highest and last point in each of `columns` equal parts of the range of x, in the order given.
///
/// x does not decrease; points that are not finite are left out.
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

/// Of one column: first, lowest, highest, last, each once and in order.
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
                    sample.percussion = 880.0;
                }
                sample
            })
            .collect()
    }

    fn thinned(samples: &[Sample]) -> Vec<Sample> {
        let mut thinning = Thinning::new(samples.len() as u64, samples.last().unwrap().time);
        samples.iter().for_each(|sample| thinning.push(sample));
        thinning.finish()
    }

    #[test]
    fn short_histories_stay_whole() {
        let samples = vibration(5000);
        assert_eq!(thinned(&samples), samples);
        assert!(Thinning::new(0, 0.0).finish().is_empty());
    }

    #[test]
    fn long_histories_lose_no_extreme() {
        let samples = vibration(400_000);
        let few = thinned(&samples);
        assert!(few.len() < 20_000, "{}", few.len());
        assert_eq!((few[0], few.last()), (samples[0], samples.last()));
        assert!(few.is_sorted_by(|left, right| left.time < right.time));
        for quantity in 0..QUANTITIES {
            let range = |samples: &[Sample]| {
                samples
                    .iter()
                    .map(|sample| drawn(sample)[quantity])
                    .fold((f64::MAX, f64::MIN), |(low, high), value| {
                        (low.min(value), high.max(value))
                    })
            };
            assert_eq!(range(&few), range(&samples), "quantity {quantity}");
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
