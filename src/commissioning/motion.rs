//! The vibration in recorded readings: its natural frequencies, and the amplitude of every sensor at each of them.

use std::f64::consts::PI;

use crate::estimation::Readings;

/// Means of the readings are taken so often per period of the highest frequency.
const PER_PERIOD: f64 = 16.0;

/// Periods of the lowest frequency in a segment.
const PERIODS: f64 = 40.0;

/// Most segments that are used: those with the strongest motion.
const MAX_SEGMENTS: usize = 24;

/// Fewest means of a sensor in a segment.
pub(super) const LEAST_MEANS: usize = 32;

/// Frequencies per width of a segment's line, when a frequency is searched, and when it is refined.
const COARSE: f64 = 2.0;
const FINE: f64 = 20.0;

/// Segments overlap by half, and are independent by this share.
const INDEPENDENT: f64 = 0.7;

/// An amplitude counts as a vibration from so many standard deviations of its noise on.
pub(super) const LEAST_OF_NOISE: f64 = 5.0;

/// The readings of one sensor in one segment: means with their times since the begin of the segment \[s\], tapered.
struct Piece {
    times: Vec<f64>,
    values: Vec<f64>,
    weight: f64,
}

/// Readings in segments, for each segment and sensor.
pub(super) struct Motion {
    segments: Vec<Vec<Option<Piece>>>,
    sensors: usize,
    /// Length of a segment \[s\].
    pub secs: f64,
}

/// What one sensor shows at a frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Amplitude in the unit of the sensor, over the segments.
    pub amplitude: f64,
    /// Amplitude over that of the reference, in and out of phase with it.
    pub ratio: [f64; 2],
    /// Standard deviation of the ratio by noise.
    pub ratio_noise: f64,
    /// Standard deviation of the amplitude by noise, in the unit of the sensor.
    pub noise: f64,
}

/// The strongest vibration of a band of frequencies.
#[derive(Debug, Clone)]
pub(super) struct Vibration {
    /// \[Hz\]
    pub frequency: f64,
    /// The sensor whose amplitude exceeds its noise most.
    pub reference: usize,
    /// For each sensor; `None` without readings.
    pub lines: Vec<Option<Line>>,
}

impl Vibration {
    /// Whether it exceeds the noise.
    pub fn is_found(&self) -> bool {
        self.lines[self.reference].is_some_and(|line| line.amplitude >= LEAST_OF_NOISE * line.noise)
    }
}

impl Motion {
    /// For frequencies of this interval \[Hz\]; `usable` says which sensors count. `None` if the readings are shorter than a few
    /// periods of the lowest one.
    pub fn new(readings: &Readings, usable: &[bool], [lowest, highest]: [f64; 2]) -> Option<Self> {
        let (first, last) = (*readings.times.first()?, *readings.times.last()?);
        let secs = (PERIODS / lowest).min(last - first);
        if secs < 4.0 / lowest {
            return None;
        }
        let mean_over = 1.0 / (PER_PERIOD * highest);
        let count = ((last - first - secs) / (0.5 * secs)).floor() as usize + 1;
        let mut strength = Vec::with_capacity(count);
        let mut segments = Vec::with_capacity(count);
        for index in 0..count {
            let begin = first + 0.5 * secs * index as f64;
            let pieces: Vec<_> = (0..readings.sensors)
                .map(|sensor| {
                    let piece = || Piece::new(readings, sensor, [begin, secs], mean_over);
                    usable[sensor].then(piece).flatten()
                })
                .collect();
            strength.push(
                pieces
                    .iter()
                    .map(|it| it.as_ref().map(Piece::power))
                    .collect(),
            );
            segments.push(pieces);
        }
        let chosen = strongest(&strength, readings.sensors);
        let mut index = 0;
        segments.retain(|_| {
            index += 1;
            chosen.contains(&(index - 1))
        });
        Some(Self {
            segments,
            sensors: readings.sensors,
            secs,
        })
    }

    /// The strongest vibration between two frequencies \[Hz\]; `None` without a sensor that has readings.
    pub fn strongest(&self, band: [f64; 2]) -> Option<Vibration> {
        let [low, high] = band;
        let step = 1.0 / (COARSE * self.secs);
        let count = ((high - low) / step).ceil() as usize + 1;
        let powers: Vec<Vec<f64>> = self.spectra(low, step, count);
        let floors: Vec<f64> = (0..self.sensors)
            .map(|sensor| self.floor(powers.iter().map(|of| of[sensor])))
            .collect();
        let shown = |of: &Vec<f64>| -> f64 {
            let each = of.iter().zip(&floors).filter(|(_, floor)| **floor > 0.0);
            each.map(|(power, floor)| (power / floor).ln_1p()).sum()
        };
        let most = |of: &[Vec<f64>]| {
            let all = of.iter().map(shown).enumerate();
            all.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (coarse, _) = most(&powers)?;
        let fine = 1.0 / (FINE * self.secs);
        let begin = (low + step * (coarse as f64 - 1.0)).max(low);
        let near = self.spectra(begin, fine, (2.0 * FINE / COARSE) as usize + 1);
        let (best, _) = most(&near)?;
        let frequency = begin + fine * best as f64;
        self.lines(frequency, &near[best], &floors)
    }

    /// Mean power of each sensor over the segments, for each frequency.
    fn spectra(&self, first: f64, step: f64, count: usize) -> Vec<Vec<f64>> {
        let mut powers = vec![vec![0.0; self.sensors]; count];
        for (sensor, pieces) in self.by_sensor() {
            for piece in &pieces {
                for (at, [re, im]) in powers.iter_mut().zip(piece.waves(first, step, count)) {
                    at[sensor] += (re * re + im * im) / pieces.len() as f64;
                }
            }
        }
        powers
    }

    fn by_sensor(&self) -> impl Iterator<Item = (usize, Vec<&Piece>)> {
        (0..self.sensors).map(move |sensor| {
            let pieces = self.segments.iter().filter_map(|it| it[sensor].as_ref());
            (sensor, pieces.collect())
        })
    }

    /// Mean power of the noise, by the power below which three tenths of the frequencies lie: most hold no vibration.
    fn floor(&self, powers: impl Iterator<Item = f64>) -> f64 {
        let mut powers: Vec<f64> = powers.collect();
        powers.sort_by(f64::total_cmp);
        let count = (INDEPENDENT * self.segments.len() as f64).max(1.0);
        // This quantile of the mean of so many exponential variables, after Wilson and Hilferty.
        let root: f64 = 1.0 - 1.0 / (9.0 * count) - 0.5244 / (3.0 * count.sqrt());
        powers[3 * powers.len() / 10] / root.powi(3)
    }

    fn lines(&self, frequency: f64, powers: &[f64], floors: &[f64]) -> Option<Vibration> {
        let known = (0..self.sensors).filter(|&it| floors[it] > 0.0);
        let above = |&it: &usize| powers[it] / floors[it];
        let reference = known.max_by(|a, b| above(a).total_cmp(&above(b)))?;
        let waves: Vec<Vec<Option<[f64; 2]>>> = self
            .segments
            .iter()
            .map(|of| {
                let wave = |piece: &Piece| piece.waves(frequency, 0.0, 1).next();
                of.iter().map(|it| it.as_ref().and_then(wave)).collect()
            })
            .collect();
        let lines = (0..self.sensors).map(|sensor| {
            // Cross-spectrum with the reference over the power of the reference.
            let (mut cross, mut power, mut count) = ([0.0; 2], 0.0, 0.0);
            for of in &waves {
                if let (Some([x, y]), Some([a, b])) = (of[sensor], of[reference]) {
                    cross[0] += x * a + y * b;
                    cross[1] += y * a - x * b;
                    power += a * a + b * b;
                    count += 1.0;
                }
            }
            if power == 0.0 {
                return None;
            }
            let ratio = cross.map(|it| it / power);
            let size = ratio[0] * ratio[0] + ratio[1] * ratio[1];
            let own = floors[sensor] + size * floors[reference];
            Some(Line {
                amplitude: (size * power / count).sqrt(),
                ratio,
                ratio_noise: (0.5 * own / (INDEPENDENT * power)).sqrt(),
                noise: floors[sensor].sqrt(),
            })
        });
        Some(Vibration {
            frequency,
            reference,
            lines: lines.collect(),
        })
    }
}

/// The segments in which the sensors move most, each sensor by its own measure.
fn strongest(strength: &[Vec<Option<f64>>], sensors: usize) -> Vec<usize> {
    let means: Vec<f64> = (0..sensors)
        .map(|sensor| strength.iter().filter_map(|it| it[sensor]).sum::<f64>())
        .collect();
    let share = |of: &Vec<Option<f64>>| -> f64 {
        let each = of.iter().zip(&means).filter(|(_, mean)| **mean > 0.0);
        each.filter_map(|(power, mean)| power.map(|it| it / mean))
            .sum()
    };
    let mut order: Vec<usize> = (0..strength.len()).collect();
    order.sort_by(|&a, &b| share(&strength[b]).total_cmp(&share(&strength[a])));
    order.truncate(MAX_SEGMENTS);
    order
}

impl Piece {
    fn new(
        readings: &Readings,
        sensor: usize,
        [begin, secs]: [f64; 2],
        mean_over: f64,
    ) -> Option<Self> {
        let from = readings.times.partition_point(|it| *it < begin);
        let to = readings.times.partition_point(|it| *it <= begin + secs);
        let mut means: Vec<([f64; 2], i64)> = Vec::new();
        let mut count = 0.0;
        for row in from..to {
            let value = readings.values[row * readings.sensors + sensor];
            if !value.is_finite() {
                continue;
            }
            let since = readings.times[row] - begin;
            let cell = (since / mean_over) as i64;
            match means.last_mut() {
                Some((mean, last)) if *last == cell => {
                    count += 1.0;
                    mean[0] += (since - mean[0]) / count;
                    mean[1] += (value - mean[1]) / count;
                }
                _ => {
                    count = 1.0;
                    means.push(([since, value], cell));
                }
            }
        }
        if means.len() < LEAST_MEANS {
            return None;
        }
        let taper = |time: f64| 0.5 - 0.5 * (2.0 * PI * time / secs).cos();
        let weight: f64 = means.iter().map(|(it, _)| taper(it[0])).sum();
        let level = means
            .iter()
            .map(|(it, _)| taper(it[0]) * it[1])
            .sum::<f64>()
            / weight;
        let tapered = means.iter().map(|(it, _)| taper(it[0]) * (it[1] - level));
        Some(Self {
            values: tapered.collect(),
            times: means.iter().map(|(it, _)| it[0]).collect(),
            weight,
        })
    }

    fn power(&self) -> f64 {
        self.values.iter().map(|it| it * it).sum()
    }

    /// The complex amplitudes at equidistant frequencies \[Hz\].
    fn waves(&self, first: f64, step: f64, count: usize) -> impl Iterator<Item = [f64; 2]> {
        let turn = |frequency: f64, time: &f64| {
            let (sin, cos) = (2.0 * PI * frequency * time).sin_cos();
            [cos, -sin]
        };
        let mut now: Vec<[f64; 2]> = self.times.iter().map(|it| turn(first, it)).collect();
        let by: Vec<[f64; 2]> = self.times.iter().map(|it| turn(step, it)).collect();
        (0..count).map(move |_| {
            let mut sum = [0.0; 2];
            for ((now, by), value) in now.iter_mut().zip(&by).zip(&self.values) {
                sum[0] += now[0] * value;
                sum[1] += now[1] * value;
                *now = [
                    now[0] * by[0] - now[1] * by[1],
                    now[0] * by[1] + now[1] * by[0],
                ];
            }
            sum.map(|it| 2.0 * it / self.weight)
        })
    }
}
