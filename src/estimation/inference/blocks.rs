//! Readings averaged over blocks of time after contact.

use crate::estimation::inference::block_layout::{Block, layout};
use crate::estimation::inference::extremes::{Extremes, NO_EXTREMES, STUCK_SAMPLES};
use crate::estimation::inference::short_means::ShortSums;
use crate::sensors::{Quantity, Sensor};

/// Strain, relative to the yield strain, beyond which a gauge no longer reads the elastic bar.
pub(crate) const ELASTIC_LIMIT: f64 = 0.9;

/// Strain, relative to the yield strain, beyond which hinges nearby have probably yielded.
const NEAR_YIELD: f64 = 0.5;

/// Share of its largest reading by which a level has to come back before its motion is a vibration, and the same in standard
/// deviations of the noise.
const TURNED: f64 = 0.03;
const TURNED_NOISE: f64 = 4.0;

/// Share of its range at which a sensor is at the end of it: the range as a number of 32 bits may be smaller by round-off.
pub(crate) const CLIPPED: f64 = 1.0 - 1e-6;

/// Share of the largest reading to either side from which on a value may be such an end. A coarse sensor repeats the values next to its zero.
const CUT_OFF_FROM: f64 = 0.5;

/// A sensor has stopped after so long without a reading that differs from the one before \[s\]: two batches of the usual length.
const STOPPED: f64 = 20e-3;

/// The same in periods of its samples, if that is longer.
const STOPPED_SAMPLES: f64 = 2.0;

/// Means over this time tell the peak of a displacement \[s\].
const PEAK_CELL: f64 = 0.5e-3;

/// Range of the readings in the first block, in terms of the declared noise, beyond which a sensor is noisier than declared: of ten samples
/// of that noise, it is larger once in 10 million times.
const NOISY: f64 = 9.0;

/// Mean range of ten samples of normal noise, over its standard deviation.
const RANGE_OF_NOISE: f64 = 3.08;

/// Standard deviation of a measured peak, relative to it, beside noise and gain \[A\].
const PEAK_DEVIATION: f64 = 0.02;

/// A gauge is lost by its mean over this time \[s\]: the waves of the first milliseconds take it beyond the limit for shorter ones
/// while the column remains elastic. Blocks consist of whole ones.
const GAUGE_CELL: f64 = 1e-3;

/// What a sensor has read over a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BlockMean {
    /// Its mean, relative to the column at rest.
    pub mean: f64,
    /// Variance of the mean by noise and by the learned zero.
    pub variance: f64,
    /// Largest magnitude of such means so far; of an acceleration that of the samples.
    pub largest: f64,
    /// The same before this block.
    pub largest_before: f64,
    /// Half of the range of such means over the last period of the column, once the level has come back from its first peak:
    /// what then moves is a vibration, of whose phase the model knows nothing.
    pub swing: f64,
    /// Whether it is of a motion within the first period of the column after contact: over this time the waves cross the column that a
    /// light vehicle makes and the model does not have.
    pub in_waves: bool,
    /// Whether hinges had probably yielded before this block.
    pub yielded: bool,
}

impl Cell {
    /// The mean of what is a sum.
    fn mean(&self) -> f64 {
        self.value / f64::from(self.count.max(1))
    }
}

/// A displacement that a sensor has read, larger than all before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Highest {
    /// It \[m\], relative to the zero, with its standard deviation.
    pub value: f64,
    pub deviation: f64,
    /// When it was complete \[s\].
    until: f64,
}

/// What tells the peak displacement that a sensor has read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Records {
    /// One after another, at least one.
    records: Vec<Highest>,
    /// Until when the sensor has read something \[s\]: one that died before has not seen a peak that came later.
    pub seen_until: f64,
}

impl Records {
    /// The peak displacement by an instant \[s\]; the first one if that is earlier.
    pub fn by(&self, instant: f64) -> Highest {
        let known = self.records.partition_point(|it| it.until <= instant);
        self.records[known.saturating_sub(1)]
    }

    /// The largest of all.
    pub fn last(&self) -> Highest {
        self.by(f64::INFINITY)
    }
}

/// The readings of all sensors, by block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Blocks {
    contact: f64,
    yield_strain: f64,
    /// Of the column \[s\].
    period: f64,
    layout: Vec<Block>,
    /// For each sensor its declared noise, its zero, the variance of that, and the sums.
    channels: Vec<Channel>,
}

#[derive(Debug, Clone, PartialEq)]
struct Channel {
    quantity: Quantity,
    noise: f64,
    zero: f64,
    zero_variance: f64,
    range: f64,
    sums: Vec<f64>,
    counts: Vec<u32>,
    /// Largest magnitude of the samples of each block, relative to the zero.
    peaks: Vec<f64>,
    /// The first sample of each block, until one differs from it.
    only: Vec<Option<f64>>,
    /// The largest and the smallest samples of each block, relative to the zero, the latter with the other sign.
    extremes: Vec<[Extremes; 2]>,
    /// Block from which on the gauge no longer reads the elastic bar.
    lost_from: usize,
    /// Gain error of the sensor.
    gain_error: f64,
    /// Without readings for longer, it has stopped \[s\].
    longest_pause: f64,
    /// Means over [`PEAK_CELL`] that were larger than all before them, with their numbers of samples and their times after contact
    /// \[s\].
    highest: Vec<Cell>,
    /// The current one, as a sum.
    cell: Cell,
    /// The same of a gauge, over [`GAUGE_CELL`].
    gauge: Cell,
    /// Number of this cell after contact.
    gauge_time: f64,
    short: ShortSums,
}

/// A mean over a short time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Cell {
    number: usize,
    count: u32,
    /// Mean, or sum of what will be one.
    value: f64,
}

impl Blocks {
    /// For a contact at `contact` \[s\], on a column that yields at `yield_strain` and vibrates with this period \[s\], until
    /// `horizon` after it \[s\]. `zeros` are the readings at rest with their standard deviations, sensor by sensor.
    pub fn new(
        contact: f64,
        horizon: f64,
        yield_strain: f64,
        period: f64,
        sensors: &[Sensor],
        zeros: &[(f64, f64)],
    ) -> Self {
        let layout = layout(horizon, period);
        let channels = sensors
            .iter()
            .zip(zeros)
            .map(|(sensor, &(zero, deviation))| Channel {
                quantity: sensor.quantity,
                noise: sensor.noise,
                zero,
                zero_variance: deviation * deviation,
                sums: vec![0.0; layout.len()],
                counts: vec![0; layout.len()],
                peaks: vec![0.0; layout.len()],
                range: sensor.range,
                only: vec![None; layout.len()],
                extremes: vec![[NO_EXTREMES; 2]; layout.len()],
                lost_from: usize::MAX,
                gain_error: sensor.gain_error,
                longest_pause: STOPPED.max(STOPPED_SAMPLES / sensor.rate),
                highest: Vec::new(),
                cell: Cell::default(),
                gauge: Cell::default(),
                gauge_time: f64::NEG_INFINITY,
                short: ShortSums::default(),
            })
            .collect();
        Self {
            contact,
            yield_strain,
            period,
            layout,
            channels,
        }
    }

    /// The blocks.
    pub fn layout(&self) -> &[Block] {
        &self.layout
    }

    /// Takes a sample of a sensor: its time \[s\] and its value. One that is not a number, outside of all blocks, or of no
    /// sensor is ignored.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) {
        let time = time - self.contact;
        let index = self.layout.partition_point(|block| block.start <= time);
        let Some(index) = index.checked_sub(1) else {
            return;
        };
        let block = self.layout[index];
        let Some(channel) = self.channels.get_mut(sensor) else {
            return;
        };
        if !value.is_finite() || time >= block.start + block.length {
            return;
        }
        let reading = value - channel.zero;
        channel.sums[index] += reading;
        channel.counts[index] += 1;
        channel.peaks[index] = channel.peaks[index].max(reading.abs());
        let [largest, smallest] = &mut channel.extremes[index];
        largest.take(reading, 1);
        smallest.take(-reading, 1);
        channel.follow_peak(time, reading);
        channel.short.push(time, reading);
        let only = &mut channel.only[index];
        *only = if channel.counts[index] == 1 {
            Some(value)
        } else {
            only.filter(|only| *only == value)
        };
        if channel.quantity.is_strain() {
            channel.follow_gauge(time, index, reading, ELASTIC_LIMIT * self.yield_strain);
        }
    }

    /// What tells the peak displacement that a sensor has read by `until` \[s\], in the direction of the vehicle. Means over half a
    /// millisecond tell it within some hundredths, unless it has stayed at its largest reading.
    pub fn records(&self, sensor: usize, until: f64) -> Option<Records> {
        let channel = &self.channels[sensor];
        let complete = self.complete(until);
        let has_read = |index: usize| channel.mean(index).is_some();
        let seen_until = self.contact + self.end_of_last(complete, has_read)?;
        if self.has_stayed_at_largest(channel, complete) {
            return None;
        }
        let end = |cell: &Cell| (cell.number + 1) as f64 * PEAK_CELL;
        let until = until - self.contact + 5e-10;
        let known = channel.highest.iter().take_while(|it| end(it) <= until);
        let records = known.map(|cell| {
            let noise = channel.shown_noise();
            let noise = noise * noise / f64::from(cell.count);
            let relative = libm::hypot(PEAK_DEVIATION, channel.gain_error) * cell.value;
            let variance = noise + channel.zero_variance + relative * relative;
            Highest {
                value: cell.value,
                deviation: variance.sqrt(),
                until: self.contact + end(cell),
            }
        });
        let records: Vec<Highest> = records.collect();
        (!records.is_empty()).then_some(Records {
            records,
            seen_until,
        })
    }

    /// For each sensor its means over short times that are complete at `until` \[s\]. See [`ShortSums::means`].
    pub fn short_means(&self, until: f64) -> Vec<Vec<Option<(f64, u32)>>> {
        let each = self.channels.iter();
        each.map(|it| it.short.means(until - self.contact))
            .collect()
    }

    /// End of the last one of so many blocks of which this holds \[s\].
    fn end_of_last(&self, complete: usize, is: impl Fn(usize) -> bool) -> Option<f64> {
        let last = (0..complete).rev().find(|k| is(*k))?;
        Some(self.layout[last].start + self.layout[last].length)
    }

    /// Whether the readings of a sensor differed before contact, so that one that it repeats is a fault. Those of a coarse sensor do not.
    fn varies(&self, channel: &Channel) -> bool {
        let lead = (0..self.layout.len()).take_while(|k| self.layout[*k].start < 0.0);
        let read: Vec<Option<f64>> = lead
            .filter(|k| channel.counts[*k] > 0)
            .map(|k| channel.only[k])
            .collect();
        read.iter().any(|it| it.is_none() || *it != read[0])
    }

    /// Whether a sensor that varies is at the end of a range that is not declared: over one of the first `complete` blocks it reads its largest
    /// value only, or over all of them its largest value comes too often for its noise.
    fn has_stayed_at_largest(&self, channel: &Channel, complete: usize) -> bool {
        let peaks = channel.peaks[..complete].iter().copied();
        let largest = peaks.fold(0.0, f64::max);
        let only = |index: usize| channel.only[index].map_or(0.0, |it| (it - channel.zero).abs());
        let stays = |index: usize| channel.is_stuck(index) && only(index) >= largest;
        largest > 0.0
            && self.varies(channel)
            && ((0..complete).any(stays) || channel.is_cut_off(complete, CUT_OFF_FROM * largest))
    }

    /// For each sensor whether it has failed by `until` \[s\]: it has no readings any more, or repeats one, while another sensor reads on, or
    /// it has repeated its largest reading, beyond which it does not read.
    pub fn failed(&self, until: f64) -> Vec<bool> {
        let complete = self.complete(until);
        let end = |channel: &Channel| {
            let varies = self.varies(channel);
            let reads = |k: usize| channel.counts[k] > 0 && !(varies && channel.is_stuck(k));
            self.end_of_last(complete, reads)
        };
        let ends: Vec<Option<f64>> = self.channels.iter().map(end).collect();
        let newest = ends.iter().flatten().fold(0.0, |a: f64, b| a.max(*b));
        let each = self.channels.iter().zip(ends);
        each.map(|(channel, end)| {
            let has_stopped = newest - end.unwrap_or(0.0) > channel.longest_pause;
            has_stopped || self.has_stayed_at_largest(channel, complete)
        })
        .collect()
    }

    /// For each sensor whether it has shown much more noise before the impact than is declared.
    pub fn noisy(&self) -> Vec<bool> {
        let each = self.channels.iter();
        each.map(|it| it.shown_noise() > it.noise).collect()
    }

    /// How many blocks are complete with data until `until` \[s\].
    pub fn complete(&self, until: f64) -> usize {
        let until = until - self.contact;
        // Half a nanosecond for the round-off of times.
        let is_complete = |block: &Block| block.start + block.length <= until + 5e-10;
        self.layout.partition_point(is_complete)
    }

    /// What a sensor has read over a block; `None` where it has no samples, is stuck, or no longer reads the elastic bar.
    pub fn mean(&self, sensor: usize, index: usize) -> Option<BlockMean> {
        let channel = &self.channels[sensor];
        if self.is_lost(channel, index) {
            return None;
        }
        let mean = channel.mean(index)?;
        let largest_of = |so_far: f64, index| so_far.max(channel.largest(index));
        let largest_before = (0..index).fold(0.0, largest_of);
        let largest = largest_of(largest_before, index);
        let count = f64::from(channel.counts[index]);
        let noise = channel.shown_noise();
        let yielded = self.channels.iter().any(|other| {
            other.quantity.is_strain()
                && (self.is_lost(other, index)
                    || (0..index)
                        .filter_map(|index| other.mean(index))
                        .any(|mean| mean.abs() > NEAR_YIELD * self.yield_strain))
        });
        Some(BlockMean {
            mean,
            variance: noise * noise / count + channel.zero_variance,
            largest,
            largest_before,
            swing: self.swing(channel, index),
            in_waves: channel.quantity.is_motion() && self.layout[index].start < self.period,
            yielded: yielded && channel.quantity.is_strain(),
        })
    }

    /// Whether a gauge no longer reads the elastic bar in a complete block.
    fn is_lost(&self, channel: &Channel, index: usize) -> bool {
        let limit = ELASTIC_LIMIT * self.yield_strain;
        index >= channel.lost_from
            // The last cell of the last block is complete without a sample that follows it.
            || channel.quantity.is_strain()
                && channel.gauge.number <= index
                && channel.gauge.mean().abs() > limit
    }

    /// See [`BlockMean::swing`].
    fn swing(&self, channel: &Channel, index: usize) -> f64 {
        if matches!(
            channel.quantity,
            Quantity::Acceleration | Quantity::ContactForce
        ) {
            return 0.0;
        }
        let end = self.layout[index].start + self.layout[index].length;
        let (mut largest, mut peak_at, mut has_turned) = (0.0_f64, 0, false);
        for (at, mean) in (0..=index).filter_map(|at| Some((at, channel.mean(at)?))) {
            if mean.abs() > largest {
                (largest, peak_at) = (mean.abs(), at);
            }
            let noise = channel.shown_noise() / f64::from(channel.counts[at]).sqrt();
            has_turned |= largest - mean.abs() > (TURNED * largest).max(TURNED_NOISE * noise);
        }
        if !has_turned {
            return 0.0;
        }
        let recent = (0..=index).filter(|&at| {
            let block = self.layout[at];
            block.start + block.length > end - self.period && at >= peak_at
        });
        let [low, high] = recent
            .filter_map(|at| channel.mean(at))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], mean| {
                [low.min(mean), high.max(mean)]
            });
        0.5 * (high - low).max(0.0)
    }
}

impl Channel {
    /// Takes a reading of a strain gauge, relative to its zero, at a time after contact \[s\] in a block. The number of its cell is
    /// that of the block.
    fn follow_gauge(&mut self, time: f64, index: usize, reading: f64, limit: f64) {
        let cell = (time / GAUGE_CELL).floor();
        if cell != self.gauge_time {
            if self.gauge.mean().abs() > limit {
                self.lost_from = self.lost_from.min(self.gauge.number);
            }
            self.gauge_time = cell;
            self.gauge = Cell {
                number: index,
                ..Cell::default()
            };
        }
        self.gauge.count += 1;
        self.gauge.value += reading;
    }

    /// Takes a reading of a displacement, relative to its zero, at a time after contact \[s\].
    fn follow_peak(&mut self, time: f64, reading: f64) {
        if self.quantity != Quantity::Displacement || time < 0.0 {
            return;
        }
        let number = (time / PEAK_CELL) as usize;
        if number != self.cell.number {
            let mean = self.cell.mean();
            let highest = self.highest.last().map_or(0.0, |cell| cell.value);
            if mean > highest {
                self.highest.push(Cell {
                    value: mean,
                    ..self.cell
                });
            }
            self.cell = Cell {
                number,
                ..Cell::default()
            };
        }
        self.cell.count += 1;
        self.cell.value += reading;
    }

    /// The largest reading of a block. Of an acceleration it is a sample: the waves that the model does not have change its sign
    /// within a block, so that its mean shows neither their size nor what a clipped sample has lost.
    fn largest(&self, index: usize) -> f64 {
        match (self.mean(index), self.quantity) {
            (None, _) => 0.0,
            (Some(_), Quantity::Acceleration) => self.peaks[index],
            (Some(mean), _) => mean.abs(),
        }
    }

    fn mean(&self, index: usize) -> Option<f64> {
        let count = self.counts[index];
        (count > 0 && !self.is_stuck(index)).then(|| self.sums[index] / f64::from(count))
    }

    /// Whether readings beyond some value of at least `least` were cut off to it over the first `complete` blocks, elsewhere than at the end of
    /// the range.
    fn is_cut_off(&self, complete: usize, least: f64) -> bool {
        [(0, 1.0), (1, -1.0)].into_iter().any(|(side, sign)| {
            let mut all = NO_EXTREMES;
            for block in &self.extremes[..complete] {
                all.take_all(&block[side]);
            }
            let limit = all.largest();
            limit >= least && all.are_cut_off() && !self.is_clipped(sign * limit + self.zero)
        })
    }

    /// The noise that the readings show before the impact, if it is much larger than the declared one, which holds otherwise. Accelerometers
    /// read ambient vibrations, too.
    fn shown_noise(&self) -> f64 {
        let [largest, smallest] = &self.extremes[0];
        let range = largest.largest() + smallest.largest();
        let is_level = self.quantity != Quantity::Acceleration;
        match is_level && self.counts[0] > 1 && range > NOISY * self.noise {
            true => range / RANGE_OF_NOISE,
            false => self.noise,
        }
    }

    /// Whether a reading is at the end of the range.
    fn is_clipped(&self, value: f64) -> bool {
        self.range > 0.0 && value.abs() >= CLIPPED * self.range
    }

    /// Whether a sensor that has noise reads one value only. At the end of its range it may.
    fn is_stuck(&self, index: usize) -> bool {
        self.noise > 0.0
            && self.counts[index] >= STUCK_SAMPLES
            && self.only[index].is_some_and(|value| !self.is_clipped(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const YIELD_STRAIN: f64 = 1.7e-3;
    const PERIOD: f64 = 10e-3;
    const STEP: f64 = 1e-4;

    fn sensor(quantity: Quantity) -> Sensor {
        Sensor {
            name: "s".to_owned(),
            quantity,
            height: 1.0,
            range: 0.0,
            noise: 1e-6,
            bias: 0.0,
            gain_error: 0.0,
            rate: 1.0 / STEP,
            bandwidth: 0.5 / STEP,
            reversed: false,
            fibre: 0.1,
        }
    }

    fn blocks(quantity: Quantity) -> Blocks {
        let sensors = [sensor(quantity)];
        Blocks::new(0.0, 0.1, YIELD_STRAIN, PERIOD, &sensors, &[(0.0, 0.0)])
    }

    fn fill(blocks: &mut Blocks, until: f64, reading: impl Fn(f64) -> f64) {
        let samples = (until / STEP).round() as u32;
        for sample in 0..samples {
            let time = (f64::from(sample) + 0.5) * STEP;
            // A sensor with noise that reads one value is stuck.
            let noise = 1e-9 * f64::from(sample % 2);
            blocks.push(0, time, reading(time) + noise);
        }
    }

    /// What swings after the first peak was compared as if the model knew its phase.
    #[test]
    fn a_vibration_after_the_first_peak_is_known_by_its_size_only() {
        let mut blocks = blocks(Quantity::Displacement);
        let turn = |time: f64| std::f64::consts::TAU * time / PERIOD;
        // It rises to 10 mm and swings about 8 mm by 1.5 mm.
        fill(&mut blocks, 0.05, |time| match time < 0.01 {
            true => 1.0 * time,
            false => 8e-3 + 1.5e-3 * turn(time).cos(),
        });
        let swing_at = |time: f64| {
            let index = blocks.complete(time) - 1;
            blocks.mean(0, index).expect("a mean").swing
        };
        assert_eq!(swing_at(0.009), 0.0);
        let swing = swing_at(0.022);
        // Means over 2 and 3 ms of a period of 10 ms take a part of it.
        assert!((swing - 1.5e-3).abs() < 0.4e-3, "{swing}");
    }

    /// Nothing told that a sensor had died or stuck, or that it was at the end of a range that is not declared.
    #[test]
    fn a_sensor_fails_that_ends_repeats_a_reading_or_stays_at_its_largest_one() {
        let sensors = [0, 1, 2, 3].map(|_| sensor(Quantity::Displacement));
        let zeros = [(0.0, 0.0); 4];
        let mut blocks = Blocks::new(0.0, 0.1, YIELD_STRAIN, PERIOD, &sensors, &zeros);
        for sample in -20..1000_i32 {
            let time = (f64::from(sample) + 0.5) * STEP;
            let noise = 1e-9 * f64::from(sample.rem_euclid(2));
            let swing = if time > 0.0 {
                5e-3 * (30.0 * time).sin()
            } else {
                0.0
            };
            blocks.push(0, time, swing + noise);
            if time < 0.02 {
                blocks.push(1, time, swing + noise);
            }
            blocks.push(2, time, if time < 0.02 { swing + noise } else { 1e-3 });
            blocks.push(3, time, (swing + noise).min(4e-3));
        }
        assert_eq!(blocks.failed(0.015), [false; 4]);
        assert_eq!(blocks.failed(0.1), [false, true, true, true]);
        // What it has read before it died counts; a peak beyond the end of the range was not read.
        assert!(blocks.records(1, 0.1).is_some() && blocks.records(3, 0.1).is_none());
    }

    /// The peak of a sensor that was cut off by a sixth was believed, because noise below the limit let no whole block repeat its end.
    #[test]
    fn a_sensor_with_noise_that_is_cut_off_at_its_crest_has_failed() {
        let sensors = [0, 1, 2].map(|_| sensor(Quantity::Displacement));
        let mut blocks = Blocks::new(0.0, 0.1, YIELD_STRAIN, PERIOD, &sensors, &[(0.0, 0.0); 3]);
        for sample in -20..1000_i32 {
            let time = (f64::from(sample) + 0.5) * STEP;
            // Noise of a tenth of the crest that repeats seldom, and the same in steps of a fiftieth.
            let noise = 1e-4 * (f64::from(sample) * 12.9898).sin();
            let swing = match time > 0.0 {
                true => 1e-3 * (60.0 * time).sin(),
                false => 0.0,
            };
            blocks.push(0, time, swing + noise);
            blocks.push(1, time, (swing + noise).min(0.85e-3));
            blocks.push(2, time, 2e-5 * ((swing + noise) / 2e-5).round());
        }
        assert_eq!(blocks.failed(0.1), [false, true, false]);
        assert!(blocks.records(1, 0.1).is_none() && blocks.records(2, 0.1).is_some());
    }

    /// The steps of its readings are larger than its noise.
    #[test]
    fn a_coarse_sensor_that_repeats_its_readings_has_not_failed() {
        let sensors = [0, 1].map(|_| sensor(Quantity::Displacement));
        let mut blocks = Blocks::new(0.0, 0.1, YIELD_STRAIN, PERIOD, &sensors, &[(0.0, 0.0); 2]);
        for sample in -20..1000_i32 {
            let time = (f64::from(sample) + 0.5) * STEP;
            blocks.push(0, time, 1e-9 * f64::from(sample.rem_euclid(2)));
            let step = if (0.0..0.03).contains(&time) {
                1e-3
            } else {
                0.0
            };
            blocks.push(1, time, step);
        }
        assert_eq!(blocks.failed(0.1), [false; 2]);
    }

    /// One sample above the limit was enough, as a flexural wave gives.
    #[test]
    fn a_gauge_is_lost_by_the_mean_of_a_millisecond_and_not_by_one_wave() {
        let limit = ELASTIC_LIMIT * YIELD_STRAIN;
        let mut elastic = blocks(Quantity::BendingStrain);
        fill(&mut elastic, 0.02, |time| {
            let is_wave = (2e-3..2.3e-3).contains(&time);
            if is_wave { 1.5 * limit } else { 0.3 * limit }
        });
        assert!(
            (0..elastic.complete(0.02))
                .skip(2)
                .all(|k| elastic.mean(0, k).is_some())
        );
        let mut yielded = blocks(Quantity::BendingStrain);
        fill(&mut yielded, 0.02, |time| {
            if time < 5e-3 {
                0.5 * limit
            } else {
                1.1 * limit
            }
        });
        let index = yielded.complete(6e-3) - 1;
        assert!(yielded.mean(0, index - 1).is_some());
        assert!((index..yielded.complete(0.02)).all(|k| yielded.mean(0, k).is_none()));
    }
}
