//! Which sensors contradict the others, and what would explain it.
//!
//! The amplitudes of all sensors in a mode follow from one number, the amplitude of the column, if the sensors are as declared. Each
//! way in which a sensor can be wrong changes this; a way is believed if it improves the fit by more than it costs. The costs are
//! those of the Bayesian information criterion, and the odds against a fault of a sensor.

use super::expected::{Candidate, Candidates, MODES, reading};
use crate::sensors::Sensor;

/// Standard deviation of what the model says of a sensor, relative to it.
const MODEL_ERROR: f64 = 0.02;

/// Standard deviation of the height of a sensor, over the height of the column.
const HEIGHT_ERROR: f64 = 0.002;

/// Standard deviation of all frequencies by stiffness and mass of the column, and of each by the model; relative.
const COMMON_FREQUENCY_ERROR: f64 = 0.015;
const FREQUENCY_ERROR: f64 = 0.01;

/// What a faulty sensor costs: twice the logarithm of the odds against it.
const FAULT_COST: f64 = 10.0;

/// An explanation that is worse by less than this is not ruled out.
const AMBIGUOUS: f64 = 6.0;

/// Heights of a sensor that are tried.
const HEIGHTS: usize = 100;

/// What would explain the readings of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub enum Explanation {
    /// Its sign is the opposite of the declared one.
    WrongSign,
    /// Its gain is this many times the declared one; negative with the opposite sign besides.
    Gain(f64),
    /// It is at this height above the base \[m\].
    Height(f64),
    /// Its readings and those of this sensor are exchanged.
    Swapped(usize),
    /// It does not react to the vibration.
    Dead,
}

impl Explanation {
    /// Numbers that are fitted.
    fn fitted(&self) -> f64 {
        match self {
            Self::Gain(_) | Self::Height(_) => 1.0,
            Self::WrongSign | Self::Swapped(_) | Self::Dead => 0.0,
        }
    }

    /// Whether it is a special case of another one.
    fn is_case_of(&self, other: &Self) -> bool {
        // A sensor at a height where the mode is zero shows nothing, too.
        matches!(
            (self, other),
            (Self::WrongSign | Self::Dead, Self::Gain(_)) | (Self::Dead, Self::Height(_))
        )
    }
}

/// A sensor with what would explain its readings.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Suspicion {
    /// Which one, by its index.
    pub sensor: usize,
    /// What would explain them.
    pub explanation: Explanation,
}

/// Amplitude of a sensor in a mode, over that of the reference, and its standard deviation by noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Amplitude {
    pub found: f64,
    pub noise: f64,
}

/// What was measured of a mode.
pub(super) struct MeasuredMode {
    /// \[Hz\]
    pub frequency: f64,
    /// For each sensor; `None` for those that are left out.
    pub amplitudes: Vec<Option<Amplitude>>,
}

/// What one sensor shows of the modes of one candidate.
struct Shown {
    /// For each mode: at the declared height, its change for the deviation of the height, and at the heights that are tried.
    modes: Vec<([f64; 2], Vec<f64>)>,
}

/// Compares what was measured with all candidates.
pub(super) struct Comparison<'a> {
    candidates: &'a Candidates,
    sensors: &'a [Sensor],
    measured: &'a [Option<MeasuredMode>; MODES],
    /// For each candidate and sensor.
    shown: Vec<Vec<Shown>>,
    numbers: f64,
}

/// The fit of a candidate.
pub(super) struct Fit {
    pub misfit: f64,
    /// For each mode the amplitude of the column, over that of the reference.
    scales: [f64; MODES],
    /// Their covariance; 0 for a mode that no sensor tells.
    spread: Matrix,
    /// What was fitted of each sensor that is suspected, in the order of the suspicions.
    fitted: Vec<f64>,
}

impl<'a> Comparison<'a> {
    pub fn new(
        candidates: &'a Candidates,
        sensors: &'a [Sensor],
        measured: &'a [Option<MeasuredMode>; MODES],
    ) -> Self {
        let length = candidates.length;
        let of_sensor = |candidate: &Candidate, sensor: &Sensor| Shown {
            modes: candidate
                .modes
                .iter()
                .map(|mode| {
                    let here = reading(mode, sensor, sensor.height);
                    let error = HEIGHT_ERROR * length;
                    let beside = reading(mode, sensor, sensor.height + error)
                        - reading(mode, sensor, sensor.height - error);
                    let tried = (0..=HEIGHTS).map(|k| reading(mode, sensor, length * place(k)));
                    ([here, 0.5 * beside], tried.collect())
                })
                .collect(),
        };
        let of_candidate = |candidate| sensors.iter().map(|it| of_sensor(candidate, it)).collect();
        let present = measured.iter().flatten().flat_map(|it| &it.amplitudes);
        Self {
            shown: candidates.all.iter().map(of_candidate).collect(),
            numbers: present.flatten().count() as f64,
            candidates,
            sensors,
            measured,
        }
    }

    /// What is wrong with the sensors: groups of explanations, of which one of each group holds, the best one first.
    pub fn explain(&self) -> Vec<Vec<Suspicion>> {
        let mut believed: Vec<Suspicion> = Vec::new();
        let mut groups = Vec::new();
        let mut score = self.score(&believed);
        let most = self.suspects().count() / 2;
        while believed.len() < most {
            let mut tried: Vec<(f64, Suspicion)> = Vec::new();
            for suspicion in self.suspicions(&believed) {
                let mut with = believed.clone();
                with.push(suspicion);
                let better = self.score(&with);
                if better < score
                    && let Some(suspicion) = with.pop()
                {
                    tried.push((better, self.with_numbers(&believed, suspicion)));
                }
            }
            tried.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some(&(best, _)) = tried.first() else {
                break;
            };
            let mut group: Vec<Suspicion> = tried
                .into_iter()
                .filter(|(score, _)| *score < best + AMBIGUOUS)
                .map(|(_, suspicion)| suspicion)
                .collect();
            let special = group.clone();
            group.retain(|it| {
                let mut others = special.iter().filter(|other| other.sensor == it.sensor);
                !others.any(|other| other.explanation.is_case_of(&it.explanation))
            });
            believed.extend(group.first().cloned());
            groups.push(group);
            score = self.score(&believed);
        }
        groups
    }

    /// The sensors that are compared.
    fn suspects(&self) -> impl Iterator<Item = usize> {
        (0..self.sensors.len()).filter(move |&sensor| {
            let mut modes = self.measured.iter().flatten();
            modes.any(|it| it.amplitudes[sensor].is_some())
        })
    }

    fn suspicions(&self, believed: &[Suspicion]) -> Vec<Suspicion> {
        let is_free = |sensor: usize| {
            !believed
                .iter()
                .any(|it| it.sensor == sensor || it.explanation == Explanation::Swapped(sensor))
        };
        let free: Vec<usize> = self.suspects().filter(|it| is_free(*it)).collect();
        let mut all = Vec::new();
        for (index, &sensor) in free.iter().enumerate() {
            let alone = [
                Explanation::WrongSign,
                Explanation::Gain(0.0),
                Explanation::Height(0.0),
                Explanation::Dead,
            ];
            let swaps = free[index + 1..].iter().copied().map(Explanation::Swapped);
            all.extend(alone.into_iter().chain(swaps).map(|explanation| Suspicion {
                sensor,
                explanation,
            }));
        }
        all
    }

    fn score(&self, suspicions: &[Suspicion]) -> f64 {
        let fits = self.fits(suspicions);
        let best = fits.fold(f64::INFINITY, |best, fit| best.min(fit.misfit));
        let costs = suspicions
            .iter()
            .map(|it| FAULT_COST + it.explanation.fitted() * self.numbers.ln());
        best + costs.sum::<f64>()
    }

    /// The suspicion with the numbers that fit best.
    fn with_numbers(&self, believed: &[Suspicion], mut suspicion: Suspicion) -> Suspicion {
        let mut all = believed.to_vec();
        all.push(suspicion.clone());
        let best = self.fits(&all).min_by(|a, b| a.misfit.total_cmp(&b.misfit));
        let number = best.and_then(|it| it.fitted.last().copied());
        if let (Explanation::Gain(to) | Explanation::Height(to), Some(number)) =
            (&mut suspicion.explanation, number)
        {
            *to = number;
        }
        suspicion
    }

    /// The fit of each candidate.
    pub fn fits(&self, suspicions: &[Suspicion]) -> impl Iterator<Item = Fit> {
        (0..self.shown.len()).map(move |candidate| self.fit(candidate, suspicions))
    }

    /// What the sensors show in a mode by the best fit if they are as declared, over the amplitude of the reference.
    pub fn expected(&self, mode: usize, suspicions: &[Suspicion]) -> Vec<f64> {
        let fits = self.fits(suspicions).enumerate();
        let best = fits.min_by(|a, b| a.1.misfit.total_cmp(&b.1.misfit));
        best.map_or_else(Vec::new, |(candidate, fit)| {
            let shown = self.shown[candidate].iter();
            shown
                .map(|it| fit.scales[mode] * it.modes[mode].0[0])
                .collect()
        })
    }

    fn fit(&self, candidate: usize, suspicions: &[Suspicion]) -> Fit {
        let column = &self.candidates.all[candidate];
        let count = self.sensors.len();
        let mut read_by: Vec<usize> = (0..count).collect();
        let mut signs = vec![1.0; count];
        let mut counts = vec![true; count];
        for Suspicion {
            sensor,
            explanation,
        } in suspicions
        {
            match explanation {
                Explanation::WrongSign => signs[*sensor] = -1.0,
                Explanation::Swapped(other) => read_by.swap(*sensor, *other),
                _ => counts[*sensor] = false,
            }
        }
        let terms: Vec<_> = (0..count)
            .filter(|sensor| counts[*sensor])
            .map(|sensor| {
                let modes = &self.shown[candidate][sensor].modes;
                let here = BOTH.map(|mode| signs[sensor] * modes[mode].0[0]);
                let beside = BOTH.map(|mode| modes[mode].0[1]);
                (sensor, self.seen(read_by[sensor]), here, beside)
            })
            .collect();
        let (mut scales, mut spread, mut misfit) = ([0.0; MODES], [[0.0; MODES]; MODES], 0.0_f64);
        for _ in 0..3 {
            let weights: Vec<Matrix> = terms
                .iter()
                .map(|(sensor, seen, here, beside)| {
                    let gain_error = self.sensors[*sensor].gain_error;
                    let [expected, beside] = [here, beside].map(|it| times(scales, *it));
                    inverse(seen.covariance(gain_error, expected, beside), seen.counts)
                })
                .collect();
            let normal = BOTH.map(|row| {
                BOTH.map(|column| {
                    let each = terms.iter().zip(&weights);
                    each.map(|((_, _, here, _), it)| here[row] * it[row][column] * here[column])
                        .sum::<f64>()
                })
            });
            let known = BOTH.map(|mode| normal[mode][mode] > 0.0);
            spread = inverse(normal, known);
            let sums = BOTH.map(|row| {
                let each = terms.iter().zip(&weights);
                each.map(|((_, seen, here, _), it)| here[row] * dot(it[row], seen.found))
                    .sum::<f64>()
            });
            scales = BOTH.map(|mode| dot(spread[mode], sums));
            let each = terms.iter().zip(&weights);
            misfit = each
                .map(|((_, seen, here, _), it)| {
                    let off = minus(seen.found, times(scales, *here));
                    between(off, it, off)
                })
                .sum();
        }
        let mut fit = Fit {
            misfit: column.prior + self.frequency_misfit(column) + misfit,
            scales,
            spread,
            fitted: Vec::with_capacity(suspicions.len()),
        };
        for suspicion in suspicions {
            let (misfit, fitted) = self.alone(candidate, suspicion, &fit);
            fit.misfit += misfit;
            fit.fitted.push(fitted);
        }
        fit
    }

    /// The misfit of a sensor on which the scale of the modes does not rest, and what was fitted.
    fn alone(&self, candidate: usize, suspicion: &Suspicion, fit: &Fit) -> (f64, f64) {
        let Suspicion {
            sensor,
            explanation,
        } = suspicion;
        let Fit { scales, spread, .. } = fit;
        let shown = &self.shown[candidate][*sensor].modes;
        let seen = self.seen(*sensor);
        let known = BOTH.map(|mode| seen.counts[mode] && spread[mode][mode] > 0.0);
        // The amplitude of the column has an uncertainty of its own.
        let weight = |own: &Matrix, shown: [f64; MODES]| {
            let each = |row: usize, column: usize| {
                own[row][column] + shown[row] * shown[column] * spread[row][column]
            };
            inverse(BOTH.map(|row| BOTH.map(|column| each(row, column))), known)
        };
        match explanation {
            Explanation::WrongSign | Explanation::Swapped(_) => (0.0, 0.0),
            Explanation::Dead => {
                let modes = BOTH.into_iter().filter(|mode| seen.counts[*mode]);
                let each = modes.map(|mode| (seen.found[mode] / seen.noise[mode]).powi(2));
                (each.sum(), 0.0)
            }
            Explanation::Gain(_) => {
                let here = BOTH.map(|mode| shown[mode].0[0]);
                let beside = times(*scales, BOTH.map(|mode| shown[mode].0[1]));
                let expected = times(*scales, here);
                let own = seen.covariance(0.0, [0.0; MODES], beside);
                let (mut gain, mut misfit) = (1.0_f64, 0.0_f64);
                for _ in 0..4 {
                    let weight = weight(&own, here.map(|it| gain * it));
                    let square = between(expected, &weight, expected);
                    gain = match square > 0.0 {
                        true => between(expected, &weight, seen.found) / square,
                        false => 1.0,
                    };
                    let off = minus(seen.found, expected.map(|it| gain * it));
                    misfit = between(off, &weight, off);
                }
                (misfit, gain)
            }
            Explanation::Height(_) => {
                let gain_error = self.sensors[*sensor].gain_error;
                let misfit = |k: usize| -> f64 {
                    let at = |k: usize| BOTH.map(|mode| shown[mode].1[k]);
                    let [expected, next, last] =
                        [k, (k + 1).min(HEIGHTS), k.max(1) - 1].map(|it| times(*scales, at(it)));
                    let beside = minus(next, last).map(|it| 0.25 * it);
                    let own = seen.covariance(gain_error, expected, beside);
                    let off = minus(seen.found, expected);
                    between(off, &weight(&own, at(k)), off)
                };
                let all = (0..=HEIGHTS).map(|k| (misfit(k), k));
                let best = all.min_by(|a, b| a.0.total_cmp(&b.0));
                best.map_or((0.0, 0.0), |(misfit, k)| {
                    (misfit, self.candidates.length * place(k))
                })
            }
        }
    }

    /// What a sensor showed of the modes.
    fn seen(&self, sensor: usize) -> Seen {
        let each = self
            .measured
            .each_ref()
            .map(|it| it.as_ref().and_then(|it| it.amplitudes[sensor]));
        Seen {
            counts: each.map(|it| it.is_some()),
            found: each.map(|it| it.map_or(0.0, |it| it.found)),
            noise: each.map(|it| it.map_or(0.0, |it| it.noise)),
        }
    }

    fn frequency_misfit(&self, candidate: &Candidate) -> f64 {
        let off: Vec<f64> = self
            .measured
            .iter()
            .zip(&candidate.modes)
            .filter_map(|(it, mode)| Some((it.as_ref()?.frequency / mode.frequency).ln()))
            .collect();
        let [each, common] = [FREQUENCY_ERROR, COMMON_FREQUENCY_ERROR].map(|it| 1.0 / (it * it));
        let shared = each * off.iter().sum::<f64>() / (each * off.len() as f64 + common);
        let own = off.iter().map(|it| each * (it - shared).powi(2));
        own.sum::<f64>() + common * shared * shared
    }
}

/// A height that is tried, over that of the column.
fn place(index: usize) -> f64 {
    index as f64 / HEIGHTS as f64
}

/// The modes by their numbers.
const BOTH: [usize; MODES] = [0, 1];

/// A symmetric matrix over the modes.
type Matrix = [[f64; MODES]; MODES];

/// What a sensor showed of the modes; 0 where it does not count.
struct Seen {
    counts: [bool; MODES],
    found: [f64; MODES],
    noise: [f64; MODES],
}

impl Seen {
    /// The covariance of the amplitudes about the expected ones. The gain of a sensor is wrong by the same share in all modes.
    fn covariance(&self, gain_error: f64, expected: [f64; MODES], beside: [f64; MODES]) -> Matrix {
        let sizes = BOTH.map(|mode| {
            let (found, expected) = (self.found[mode], expected[mode]);
            let sign = if expected == 0.0 { found } else { expected };
            found.abs().max(expected.abs()).copysign(sign)
        });
        BOTH.map(|row| {
            BOTH.map(|column| {
                let own = match row == column {
                    true => {
                        (MODEL_ERROR * sizes[row]).powi(2)
                            + self.noise[row].powi(2)
                            + beside[row].powi(2)
                    }
                    false => 0.0,
                };
                gain_error * gain_error * sizes[row] * sizes[column] + own
            })
        })
    }
}

/// The inverse of a matrix over the modes that count, and 0 for the others.
fn inverse([[a, b], [_, d]]: Matrix, counts: [bool; MODES]) -> Matrix {
    match counts {
        [true, true] => {
            let determinant = a * d - b * b;
            [[d, -b], [-b, a]].map(|row| row.map(|it| it / determinant))
        }
        [true, false] => [[1.0 / a, 0.0], [0.0, 0.0]],
        [false, true] => [[0.0, 0.0], [0.0, 1.0 / d]],
        [false, false] => [[0.0; MODES]; MODES],
    }
}

fn times(a: [f64; MODES], b: [f64; MODES]) -> [f64; MODES] {
    BOTH.map(|mode| a[mode] * b[mode])
}

fn minus(a: [f64; MODES], b: [f64; MODES]) -> [f64; MODES] {
    BOTH.map(|mode| a[mode] - b[mode])
}

fn dot(a: [f64; MODES], b: [f64; MODES]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The product of a vector, a matrix and a vector.
fn between(left: [f64; MODES], matrix: &Matrix, right: [f64; MODES]) -> f64 {
    dot(left, matrix.map(|row| dot(row, right)))
}
