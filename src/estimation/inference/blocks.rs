//! Readings averaged over blocks of time that grow with the time after contact.
//!
//! Vibrations whose phase the model cannot predict for long average out, and the number of blocks grows with the logarithm
//! of the time only.

use crate::sensors::{Quantity, Sensor};

/// Before contact, from which the blocks begin \[s\].
const LEAD: f64 = 2e-3;

/// Shortest block \[s\].
const LEAST: f64 = 1e-3;

/// A block is as long as this share of the time from contact to its beginning, in whole milliseconds.
const SHARE: f64 = 0.2;

/// Strain, relative to the yield strain, beyond which a gauge no longer reads the elastic bar.
const ELASTIC_LIMIT: f64 = 0.9;

/// Strain, relative to the yield strain, beyond which hinges nearby have probably yielded.
const NEAR_YIELD: f64 = 0.5;

/// Samples of a block that have to be the same, bit for bit, if a sensor with noise is stuck.
const STUCK_SAMPLES: u32 = 10;

/// Share of its range at which a sensor is at the end of it: the range as a number of 32 bits may be smaller by round-off.
const CLIPPED: f64 = 1.0 - 1e-6;

/// A span of time after contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    /// Its beginning \[s\]; negative before contact.
    pub start: f64,
    /// \[s\]
    pub length: f64,
}

/// What a sensor has read over a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BlockMean {
    /// Its mean, relative to the column at rest.
    pub mean: f64,
    /// Variance of the mean by noise and by the learned zero.
    pub variance: f64,
    /// Largest magnitude of such means so far; of an acceleration that of the samples.
    pub largest: f64,
    /// Whether hinges have probably yielded.
    pub yielded: bool,
}

/// The readings of all sensors, by block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Blocks {
    contact: f64,
    yield_strain: f64,
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
    /// Block from which on the gauge no longer reads the elastic bar.
    lost_from: usize,
}

impl Blocks {
    /// For a contact at `contact` \[s\], on a column that yields at `yield_strain`, until `horizon` after it \[s\]. `zeros` are
    /// the readings at rest with their standard deviations, sensor by sensor.
    pub fn new(
        contact: f64,
        horizon: f64,
        yield_strain: f64,
        sensors: &[Sensor],
        zeros: &[(f64, f64)],
    ) -> Self {
        let mut layout = Vec::new();
        let mut start = -LEAD;
        while start < horizon {
            let milliseconds = (1e3 * SHARE * start.max(0.0)).floor();
            let length = (1e-3 * milliseconds).max(LEAST);
            layout.push(Block { start, length });
            start += length;
        }
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
                lost_from: usize::MAX,
            })
            .collect();
        Self {
            contact,
            yield_strain,
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
        let only = &mut channel.only[index];
        *only = if channel.counts[index] == 1 {
            Some(value)
        } else {
            only.filter(|only| *only == value)
        };
        if channel.quantity.is_strain() && reading.abs() > ELASTIC_LIMIT * self.yield_strain {
            channel.lost_from = channel.lost_from.min(index);
        }
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
        if index >= channel.lost_from {
            return None;
        }
        let mean = channel.mean(index)?;
        let largest = (0..=index).fold(0.0, |largest: f64, index| {
            largest.max(channel.largest(index))
        });
        let count = f64::from(channel.counts[index]);
        let yielded = self.channels.iter().any(|other| {
            other.quantity.is_strain()
                && (other.lost_from <= index
                    || (0..=index)
                        .filter_map(|index| other.mean(index))
                        .any(|mean| mean.abs() > NEAR_YIELD * self.yield_strain))
        });
        Some(BlockMean {
            mean,
            variance: channel.noise * channel.noise / count + channel.zero_variance,
            largest,
            yielded: yielded && channel.quantity.is_strain(),
        })
    }
}

impl Channel {
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

    /// Whether a sensor that has noise reads one value only. At the end of its range it may.
    fn is_stuck(&self, index: usize) -> bool {
        let is_clipped = |value: f64| self.range > 0.0 && value.abs() >= CLIPPED * self.range;
        self.noise > 0.0
            && self.counts[index] >= STUCK_SAMPLES
            && self.only[index].is_some_and(|value| !is_clipped(value))
    }
}
