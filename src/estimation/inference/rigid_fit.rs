//! The rigid vehicle that explains the readings by the fibre beam, if one does.
//!
//! The bars have the mass of the column at points. They take a light rigid vehicle for a heavier one, and of a push that leaves the
//! column elastic they know neither shape nor period of the vibrations. The beam does, and all that it does not know of the column and its
//! sensors has a prior: an adjustment by least squares (Levenberg and Marquardt), whose residuals are whitened by the errors of model and
//! sensors, over a time after contact that grows, because late vibrations have many minima.

use std::sync::Arc;

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::column::Impact;
use crate::estimation::inference::beam_error::{Channel, Read, channel, first_lost};
use crate::estimation::inference::beam_readings::{BeamReadings, Factors, PERIOD};
use crate::estimation::inference::event_evidence::EventEvidence;
use crate::estimation::inference::hypothesis::Hypothesis;
use crate::estimation::inference::rigid_vehicle::{ByBeam, RigidVehicle};
use crate::estimation::inference::short_means::SHORT;
use crate::numerics::LevenbergMarquardt;
use crate::sensors::Quantity;

/// What is adjusted: the logarithms of mass and speed, those of the factors of yield strength, Young's modulus, density and load, and
/// the time of contact after the detected one \[s\].
const UNKNOWNS: usize = 7;

/// Standard deviations of the logarithms of the factors \[A\].
const FACTORS: [f64; 4] = [0.05, 0.03, 0.05, 0.1];

/// Least standard deviation of the time of contact \[s\] \[A\]: its samples are 0.1 ms apart, or more.
const LEAST_CONTACT_DEVIATION: f64 = 0.2e-3;

/// Steps by which derivatives are taken.
const STEPS: [f64; UNKNOWNS] = [0.02, 0.02, 0.01, 0.01, 0.01, 0.01, 5e-5];

/// Means that are used, one time after another.
const HORIZONS: [usize; 4] = [14, 30, 60, 90];

/// The number of the horizon from which on only the best adjustment continues.
const COMPARED: usize = 2;

/// Of the factors, only this part of their deviations is free before the third horizon: they would take the place of mass and speed.
const HELD: f64 = 0.2;

/// Least number of means.
const LEAST_MEANS: usize = 40;

/// Masses that are tried first \[kg\]: the least one, how many, and the factor between two.
const FIRST_MASS: f64 = 50.0;
const MASSES: u32 = 18;
const NEXT_MASS: f64 = 1.35;

/// Speed with which each of them begins \[m/s\]: the column remains elastic.
const FIRST_SPEED: f64 = 0.5;

/// Times of contact that are tried with each of them \[s\].
const SHIFTS: [f64; 7] = [-0.6e-3, -0.4e-3, -0.2e-3, 0.0, 0.2e-3, 0.4e-3, 0.6e-3];

/// How often the speed is adjusted for each of them: the readings are proportional to it as long as the column is elastic.
const ADJUSTMENTS: u32 = 3;

/// Adjustments that are begun, where their masses differ by more than this factor.
const BEGUN: usize = 3;
const DIFFERENT_MASS: f64 = 1.5;

/// Most steps over one horizon, most attempts of one step, and the decrease of the squares that is worth another step.
const MOST_STEPS: u32 = 6;
const MOST_ATTEMPTS: u32 = 5;
const DECREASE: f64 = 1.0;

/// Longest step of the logarithms of mass and speed.
const LONGEST_STEP: f64 = 0.7;

/// Standard deviations of the scale of a sensor up to which the vehicle explains its readings.
const MOST_OFF_SCALE: f64 = 3.0;

/// Mean square of the residuals up to which the vehicle explains the readings: twice what it is by the assumed errors, each of which is
/// alike in four means and counts once.
const EXPLAINED: f64 = 0.5;

/// The same once a gauge is lost, and the standard deviations of a scale: fewer readings are left that could contradict \[A\].
const EXPLAINED_WITH_FEWER: f64 = 0.25;
const MOST_OFF_SCALE_WITH_FEWER: f64 = 2.5;

/// The same beyond which an adjustment is given up.
const HOPELESS: f64 = 2.0;

/// A place among the unknowns, with its residuals.
#[derive(Debug, Clone)]
struct Point {
    unknowns: [f64; UNKNOWNS],
    /// See [`RigidFit::rows`].
    rows: Arc<[Vec<f64>]>,
    residuals: Vec<f64>,
    /// Sum of all squares, those of the priors included.
    cost: f64,
    /// How far the scale of one sensor is from 1, in its standard deviations.
    off_scale: f64,
}

impl Point {
    /// Whether the mean square of its residuals is at most this.
    fn is_within(&self, mean_square: f64) -> bool {
        let squares = self.residuals.iter().fold(0.0, |sum, it| sum + it * it);
        squares <= mean_square * self.residuals.len() as f64
    }
}

/// An adjustment over one horizon after another.
#[derive(Debug, Clone)]
struct Descent {
    horizon: usize,
    steps: u32,
    point: Point,
    adjustment: LevenbergMarquardt<UNKNOWNS>,
}

impl Descent {
    /// Whether it has come to the bottom over the last horizon.
    fn is_over(&self) -> bool {
        self.horizon == HORIZONS.len()
    }
}

/// How much of an adjustment is computed at once.
#[derive(Clone, Copy)]
enum Slice {
    /// In this thread.
    OneResponse,
    /// On all processors.
    AllDerivatives,
}

/// How far one step of an adjustment is.
enum Progress {
    Under,
    /// It was worth it, or not.
    Over(bool),
}

/// The work on it, in slices.
#[derive(Debug, Clone)]
pub(crate) struct RigidFit {
    beam: BeamReadings,
    channels: Vec<Channel>,
    prior: [[f64; 2]; UNKNOWNS],
    /// Whether a gauge has left the elastic range.
    has_lost_gauge: bool,
    /// Masses that were tried.
    tried: u32,
    started: Vec<Point>,
    descents: Vec<Descent>,
    over: bool,
}

impl RigidFit {
    /// `None` where the readings do not suffice. `rigid` is the hypothesis of a rigid vehicle.
    pub fn begin(beam: &BeamReadings, rigid: &Hypothesis, read: &Read) -> Option<Self> {
        let longest = read.means.iter().map(Vec::len).max()?;
        let lost = first_lost(read);
        let channels = beam.sensors().map(|it| channel(read, lost, it));
        let channels: Vec<Channel> = channels.collect();
        let has_level = channels.iter().any(|it| {
            it.sensor.quantity != Quantity::Acceleration && it.means.iter().any(Option::is_some)
        });
        let contact = read.contact_deviation.max(LEAST_CONTACT_DEVIATION);
        let mut prior = [[0.0, contact]; UNKNOWNS];
        let of_vehicle = rigid.mean.iter().zip(&rigid.deviation).take(2);
        let of_factors = FACTORS.iter().map(|it| (&0.0, it));
        for (prior, (mean, deviation)) in prior.iter_mut().zip(of_vehicle.chain(of_factors)) {
            *prior = [*mean, *deviation];
        }
        (longest >= LEAST_MEANS && has_level).then(|| Self {
            beam: beam.clone(),
            channels,
            prior,
            has_lost_gauge: lost.is_some(),
            tried: 0,
            started: Vec::new(),
            descents: Vec::new(),
            over: false,
        })
    }

    /// Whether there are as many means of a sensor as are used.
    pub fn has_all(means: &[Option<(f64, u32)>]) -> bool {
        means.len() >= HORIZONS[HORIZONS.len() - 1]
    }

    pub fn is_over(&self) -> bool {
        self.over
    }

    /// The next slice, in this thread, unless it is over.
    pub fn step(&mut self) {
        if self.over {
        } else if self.tried < MASSES {
            self.started.extend(self.start(self.tried));
            self.tried += 1;
            if self.tried == MASSES {
                self.choose();
            }
        } else {
            self.descend(Slice::OneResponse);
        }
        self.over |= self.tried == MASSES && self.descents.is_empty();
    }

    /// All slices that are left, on all processors, with the same result.
    pub fn finish(&mut self) {
        if self.tried < MASSES {
            let masses = (self.tried..MASSES).into_par_iter();
            let started: Vec<_> = masses.map(|number| self.start(number)).collect();
            self.started.extend(started.into_iter().flatten());
            self.tried = MASSES;
            self.choose();
        }
        let descents = std::mem::take(&mut self.descents).into_par_iter();
        let compared = descents.filter_map(|mut descent| {
            while descent.horizon < COMPARED {
                descent = self.followed(descent, Slice::AllDerivatives)?;
            }
            Some(descent)
        });
        self.descents = compared.collect();
        self.keep_best();
        while !self.over && !self.descents.is_empty() {
            self.descend(Slice::AllDerivatives);
        }
        self.over = true;
    }

    /// The vehicle, if one explains the readings, with what events say that do not contradict it.
    pub fn found(&self, events: &[EventEvidence]) -> ByBeam {
        let best = self.descents.first().filter(|_| self.over);
        let (mean_square, off_scale) = match self.has_lost_gauge {
            true => (EXPLAINED_WITH_FEWER, MOST_OFF_SCALE_WITH_FEWER),
            false => (EXPLAINED, MOST_OFF_SCALE),
        };
        let explains =
            |it: &&Descent| it.point.is_within(mean_square) && it.point.off_scale <= off_scale;
        let Some(Descent {
            point, adjustment, ..
        }) = best.filter(explains)
        else {
            return ByBeam::NotRigid;
        };
        let all = adjustment.covariance();
        let covariance = [0, 1].map(|k: usize| [all[k][0], all[k][1]]);
        let [mass, velocity, ..] = point.unknowns;
        let found = RigidVehicle {
            mean: [mass, velocity],
            covariance,
            has_yielded_gauge: self.has_lost_gauge,
        };
        ByBeam::Rigid(events.iter().fold(found, RigidVehicle::with_event))
    }

    /// The speed and the time of contact that suit the mass with this number.
    fn start(&self, number: u32) -> Option<Point> {
        let mass = libm::log(FIRST_MASS) + f64::from(number) * libm::log(NEXT_MASS);
        let mut unknowns = [0.0; UNKNOWNS];
        unknowns[..2].copy_from_slice(&[mass, libm::log(FIRST_SPEED)]);
        let mut best: Option<Point> = None;
        for _ in 0..ADJUSTMENTS {
            let rows = self.rows(&unknowns, HORIZONS[0])?;
            let shifted = SHIFTS.map(|shift| {
                let mut it = unknowns;
                it[UNKNOWNS - 1] = shift;
                it
            });
            let points = shifted.map(|it| self.point_of(it, HORIZONS[0], rows.clone()));
            let scales = shifted.map(|it| self.scale(&it, &rows));
            let squares = |k: usize| {
                let [cross, predicted, read] = scales[k];
                read - cross * cross / predicted
            };
            let k = (0..SHIFTS.len()).min_by(|a, b| squares(*a).total_cmp(&squares(*b)))?;
            let cheapest = points
                .into_iter()
                .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
            if best.as_ref().is_none_or(|it| cheapest.cost < it.cost) {
                best = Some(cheapest);
            }
            let [cross, predicted, _] = scales[k];
            unknowns = shifted[k];
            unknowns[1] += libm::log((cross / predicted).clamp(0.05, 20.0));
        }
        best
    }

    /// Begins with the best of what was tried.
    fn choose(&mut self) {
        self.started.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        for point in std::mem::take(&mut self.started) {
            let apart = |it: &Descent| {
                (it.point.unknowns[0] - point.unknowns[0]).abs() > libm::log(DIFFERENT_MASS)
            };
            if self.descents.len() < BEGUN && self.descents.iter().all(apart) {
                self.descents.push(Descent {
                    horizon: 0,
                    steps: 0,
                    point,
                    adjustment: LevenbergMarquardt::new(UNKNOWNS),
                });
            }
        }
    }

    /// One more slice of the adjustment that is least far.
    fn descend(&mut self, slice: Slice) {
        let next = (0..self.descents.len()).min_by_key(|k| self.descents[*k].horizon);
        let Some(next) = next else { return };
        let before = self.descents.remove(next);
        if let Some(descent) = self.followed(before, slice) {
            self.over = descent.is_over();
            self.descents.insert(next, descent);
        }
        self.keep_best();
    }

    /// An adjustment after one more slice; `None` where it is given up.
    fn followed(&self, mut descent: Descent, slice: Slice) -> Option<Descent> {
        let is_at_bottom = match self.improve(&mut descent, slice) {
            Progress::Over(was_worth_it) => !was_worth_it || descent.steps >= MOST_STEPS,
            Progress::Under => false,
        };
        if !is_at_bottom {
            return Some(descent);
        }
        descent.horizon += 1;
        descent.steps = 0;
        if descent.is_over() {
            return Some(descent);
        }
        if !descent.point.is_within(HOPELESS) {
            return None;
        }
        descent.point = self.point(descent.point.unknowns, HORIZONS[descent.horizon])?;
        Some(descent)
    }

    /// Keeps only the best adjustment, once all have come so far that they are compared.
    fn keep_best(&mut self) {
        if self.descents.iter().all(|it| it.horizon == COMPARED) {
            self.descents
                .sort_by(|a, b| a.point.cost.total_cmp(&b.point.cost));
            self.descents.truncate(1);
        }
    }

    /// Continues a step of the Levenberg-Marquardt method. It needs responses for all derivatives, and then one response for each attempt.
    fn improve(&self, descent: &mut Descent, slice: Slice) -> Progress {
        let means = HORIZONS[descent.horizon];
        let Descent {
            adjustment, point, ..
        } = descent;
        if let Some(first) = adjustment.wanted_slope() {
            let moved = |unknown| self.moved(point, unknown, means);
            let all: Vec<_> = match slice {
                Slice::OneResponse => vec![moved(first)],
                Slice::AllDerivatives => (first..UNKNOWNS).into_par_iter().map(moved).collect(),
            };
            let prior = |unknown| self.prior_of(unknown, means);
            for (step, moved) in STEPS[first..].iter().zip(all) {
                let Some(moved) = moved else {
                    adjustment.begin_step();
                    return Progress::Over(false);
                };
                let moved = (moved.residuals.as_slice(), *step);
                adjustment.take_slope(moved, &point.residuals, &point.unknowns, prior);
            }
            return Progress::Under;
        }
        let mut unknowns = point.unknowns;
        for (k, (unknown, step)) in unknowns.iter_mut().zip(adjustment.step()).enumerate() {
            *unknown -= match k < 2 {
                true => step.clamp(-LONGEST_STEP, LONGEST_STEP),
                false => step,
            };
        }
        let before = point.cost;
        let found = self.point(unknowns, means).filter(|it| it.cost < before);
        let decrease = found.as_ref().map_or(0.0, |it| before - it.cost);
        match found {
            Some(found) => {
                *point = found;
                adjustment.accept();
            }
            None if adjustment.decline() < MOST_ATTEMPTS => return Progress::Under,
            None => adjustment.begin_step(),
        }
        descent.steps += 1;
        Progress::Over(decrease > DECREASE)
    }

    /// The place that one unknown is moved to by the step for its derivative.
    fn moved(&self, point: &Point, unknown: usize, means: usize) -> Option<Point> {
        let mut unknowns = point.unknowns;
        unknowns[unknown] += STEPS[unknown];
        // The time of contact does not change what the beam does.
        match unknown == UNKNOWNS - 1 {
            true => Some(self.point_of(unknowns, means, point.rows.clone())),
            false => self.point(unknowns, means),
        }
    }

    fn prior_of(&self, unknown: usize, means: usize) -> [f64; 2] {
        let [mean, deviation] = self.prior[unknown];
        let is_held = means < HORIZONS[2] && (2..UNKNOWNS - 1).contains(&unknown);
        [mean, if is_held { HELD * deviation } else { deviation }]
    }

    fn point(&self, unknowns: [f64; UNKNOWNS], means: usize) -> Option<Point> {
        let rows = self.rows(&unknowns, means)?;
        Some(self.point_of(unknowns, means, rows))
    }

    /// Sums of what the beam lets the sensors read, from contact on; a few more than these means need.
    fn rows(&self, unknowns: &[f64; UNKNOWNS], means: usize) -> Option<Arc<[Vec<f64>]>> {
        let [
            mass,
            velocity,
            yield_strength,
            young_modulus,
            density,
            load,
            _,
        ] = unknowns.map(libm::exp);
        let factors = Factors {
            yield_strength,
            young_modulus,
            density,
            load,
        };
        let longest = self.channels.iter().map(|it| it.means.len()).max()?;
        let time = means.min(longest) as f64 * SHORT + 1e-3;
        let count = (time / PERIOD).round() as usize;
        let mut rows = self
            .beam
            .follow(&Impact::rigid(mass, velocity), factors, count)?;
        let mut sums = vec![0.0; self.channels.len()];
        for row in &mut rows {
            for ((sum, value), Channel { sensor, .. }) in
                sums.iter_mut().zip(row.iter_mut()).zip(&self.channels)
            {
                *sum += sensor.clipped(if sensor.reversed { -*value } else { *value });
                *value = *sum;
            }
        }
        Some(rows.into())
    }

    /// What the beam predicts for each mean of a channel that was read, over the error of the mean, and the mean likewise.
    fn pairs<'a>(
        &'a self,
        (index, channel): (usize, &'a Channel),
        shift: f64,
        means: usize,
        rows: &'a [Vec<f64>],
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        // The sum until a time after contact, between two rows.
        let until = move |time: f64| {
            let place = ((time - shift) / PERIOD).clamp(0.0, rows.len() as f64);
            let whole = place as usize;
            let sum =
                |rows_before: usize| rows_before.checked_sub(1).map_or(0.0, |it| rows[it][index]);
            let next = sum((whole + 1).min(rows.len()));
            sum(whole) + (place - whole as f64) * (next - sum(whole))
        };
        let each = channel.means.iter().take(means).enumerate();
        each.filter_map(move |(k, mean)| {
            let (read, precision) = (*mean)?;
            let (from, to) = (k as f64 * SHORT, (k + 1) as f64 * SHORT);
            let predicted = (until(to) - until(from)) * PERIOD / SHORT;
            Some((predicted * precision, read))
        })
    }

    /// Sums over all sensors but accelerometers: of what was read times what is predicted, and the squares of both, of the latter first.
    fn scale(&self, unknowns: &[f64; UNKNOWNS], rows: &[Vec<f64>]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        let levels = self.channels.iter().enumerate();
        let levels = levels.filter(|(_, it)| it.sensor.quantity != Quantity::Acceleration);
        for channel in levels {
            for (predicted, read) in self.pairs(channel, unknowns[UNKNOWNS - 1], HORIZONS[0], rows)
            {
                let products = [predicted * read, predicted * predicted, read * read];
                for (sum, product) in sums.iter_mut().zip(products) {
                    *sum += product;
                }
            }
        }
        sums[1] = sums[1].max(f64::MIN_POSITIVE);
        sums
    }

    fn point_of(&self, unknowns: [f64; UNKNOWNS], means: usize, rows: Arc<[Vec<f64>]>) -> Point {
        let mut residuals = Vec::new();
        let mut off_scale = 0.0_f64;
        for channel in self.channels.iter().enumerate() {
            let pairs = || self.pairs(channel, unknowns[UNKNOWNS - 1], means, &rows);
            // A factor of all readings of a sensor is integrated out: the inverse root of the matrix 1 + scale read read'.
            let (mut along, mut squares) = (0.0, 0.0);
            for (predicted, read) in pairs() {
                along += (read - predicted) * read;
                squares += read * read;
            }
            let share = match squares > 0.0 {
                true => (1.0 - 1.0 / (1.0 + channel.1.scale * squares).sqrt()) / squares,
                false => 0.0,
            };
            let z = along * channel.1.scale.sqrt() / (1.0 + channel.1.scale * squares);
            off_scale = off_scale.max(z.abs());
            residuals
                .extend(pairs().map(|(predicted, read)| read - predicted - share * along * read));
        }
        let of_priors = (0..UNKNOWNS).fold(0.0, |sum, k| {
            let [mean, deviation] = self.prior_of(k, means);
            let z = (unknowns[k] - mean) / deviation;
            sum + z * z
        });
        Point {
            cost: residuals.iter().fold(of_priors, |sum, it| sum + it * it),
            unknowns,
            rows,
            residuals,
            off_scale,
        }
    }
}
