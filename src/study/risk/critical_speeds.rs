//! Critical speeds of a class of vehicles as a function of the other inputs, to predict the action of most samples.
//!
//! The predictions decide only how often a response has to be computed. They do not bias the result: a random share of them
//! is computed, too, the larger the closer a sample is to a critical speed, and corrects the estimate and widens its interval
//! (`src/study/risk/estimate.rs`).
//!
//! The logarithm of a critical speed is a quadratic function of the inputs as standard normal variables, fitted to designs of a
//! class for which it was searched, plus a linear regression of what this leaves over the designs near the place.

use rayon::ThreadPoolBuildError;

use super::departure::{Departure, DepartureSampler};
use super::evaluation::LimitState;
use super::normal;
use super::random::Purpose;
use super::reach::LEAST_SPEED;
use super::scenario::Scenario;
use super::tally::{CONTROL_SHARES, LEVELS, Prediction};
use crate::assessment::Action;
use crate::numerics::{cholesky, solved};
use crate::study::{ACTIONS, Batch, BatchEnd};

/// Inputs on which a critical speed depends: mass, force factor, yield strength, load.
const COORDINATES: usize = 4;
/// Their first index among the quantiles of a departure.
const FIRST_COORDINATE: usize = 5;
/// Unknowns of a local regression: a constant and the slopes.
const UNKNOWNS: usize = COORDINATES + 1;
/// Terms of the quadratic function: a constant, the slopes, squares and products.
const TERMS: usize = UNKNOWNS + COORDINATES * (COORDINATES + 1) / 2;
/// Designs of a class.
const DESIGNS: u64 = 160;
/// Least designs per term from which the quadratic function is fitted.
const DESIGNS_PER_TERM: usize = 3;
/// Designs from which a critical speed is interpolated.
const NEIGHBOURS: usize = 24;
/// Standard deviation of the designs, in standard deviations of the inputs: they cover the tails, too.
const SPREAD: f64 = 1.4;
/// Standard deviations of an input beyond which nothing is predicted.
const FARTHEST: f64 = 4.0;
/// Logarithm of the ratio of the speeds between which a critical speed is known.
const BRACKET: f64 = 0.008;
/// Least standard deviation of the logarithm of an interpolated speed: that of the brackets.
const LEAST_DEVIATION: f64 = 0.0023;
/// Share of the designs whose errors, each predicted from the others, a standard deviation covers.
const WITHIN_ONE_DEVIATION: f64 = 0.683;
/// Fewest errors from which the scale of the deviations is found.
const ENOUGH_ERRORS: usize = 20;
/// Scale of the deviations where fewer errors are known.
const UNKNOWN_SCALE: f64 = 4.0;
/// Bounds of the classes of doubt of a prediction, in standard deviations between the speed and the nearest critical speed.
const DOUBTS: [f64; CONTROL_SHARES.len() - 1] = [0.5, 1.0, 2.0, 4.0];
/// The least certain class of a prediction near a design whose action falls somewhere with growing speed.
const DOUBT_WITHOUT_ORDER: usize = 3;
/// How far beyond the speeds that were looked at a critical speed is taken to be, in logarithms.
const BEYOND: f64 = 0.5;
/// Responses that the critical speeds of a class cost, about.
const RESPONSES_PER_CLASS: u64 = DESIGNS * 24;
/// Samples of a class that repay its designs, over the responses that these cost.
const REPAID: f64 = 1.5;

/// Critical speeds of every class that has enough samples to repay their cost.
#[derive(Debug, Clone)]
pub struct CriticalSpeedSurface {
    classes: Vec<Option<ClassSurface>>,
    /// Which of the coordinates scatter.
    active: [bool; COORDINATES],
    /// Responses that were computed.
    responses: u64,
}

#[derive(Debug, Clone)]
struct ClassSurface {
    designs: Vec<Design>,
    /// Logarithms of the speeds \[m/s\] between which critical speeds were looked for.
    range: [f64; 2],
    /// By action.
    trends: [Option<Trend>; LEVELS - 1],
    /// Errors of the predictions, by action, over the deviations of their regressions.
    scale: [f64; LEVELS - 1],
}

/// A quadratic function of a place.
type Trend = [f64; TERMS];

/// The critical speeds of one set of inputs.
#[derive(Debug, Clone)]
struct Design {
    place: [f64; COORDINATES],
    /// Logarithm of the least speed \[m/s\] with each action; infinite: outside the range.
    critical: [f64; LEVELS - 1],
    /// What the trend of the class leaves of it, both kept within the bounds of [`clamped`].
    left: [f64; LEVELS - 1],
    /// Whether the action grew with the speed, as far as it was computed.
    monotonic: bool,
    responses: u64,
}

/// A critical speed from the designs near a place.
#[derive(Debug, Clone, Copy, Default)]
struct Interpolated {
    value: f64,
    deviation: f64,
}

/// The critical speeds at a place.
struct Interpolation {
    critical: [Interpolated; LEVELS - 1],
    /// Whether the action grows with the speed at every design that entered.
    monotonic: bool,
}

impl CriticalSpeedSurface {
    /// Looks for the critical speeds of the classes of which `samples` samples would contain enough; `None` if it was
    /// interrupted. Whichever threads compute it, the result is the same.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn new<L: LimitState>(
        sampler: &DepartureSampler,
        seed: u64,
        limit_state: &L,
        samples: u64,
        search: &Batch,
    ) -> Result<Option<Self>, ThreadPoolBuildError> {
        let scenario = sampler.scenario();
        let designs_of = sampler.for_purpose(seed, Purpose::Design);
        let chosen: Vec<usize> = (0..scenario.classes.len())
            .filter(|class| repays(scenario.classes[*class].share, samples))
            .collect();
        // Faster ones are computed.
        let top = (1.1 * sampler.greatest_speed()).max(2.0 * LEAST_SPEED);
        let range = [libm::log((0.02 * top).max(LEAST_SPEED)), libm::log(top)];
        let mut designs = Vec::new();
        let end = search.run(
            chosen.len() as u64 * DESIGNS,
            |index| {
                let class = chosen[(index / DESIGNS) as usize];
                let spread =
                    |quantile: f64| normal::probability(SPREAD * normal::quantile(quantile));
                Design::new(
                    &designs_of.of_class(index, class, spread),
                    range,
                    limit_state,
                )
            },
            |found| {
                designs.extend(found);
                Ok::<(), ThreadPoolBuildError>(())
            },
        )?;
        if end != BatchEnd::Complete {
            return Ok(None);
        }
        let active = active_coordinates(scenario);
        let mut surface = Self {
            classes: vec![None; scenario.classes.len()],
            active,
            responses: designs.iter().map(|design| design.responses).sum(),
        };
        let groups: Vec<&[Design]> = designs.chunks(DESIGNS as usize).collect();
        let pool = Batch::of_threads(search.threads);
        let mut calibrated = Vec::new();
        pool.run(
            groups.len() as u64,
            |index| ClassSurface::calibrated(groups[index as usize].to_vec(), range, &active),
            |found| {
                calibrated.extend(found);
                Ok::<(), ThreadPoolBuildError>(())
            },
        )?;
        for (class, found) in chosen.into_iter().zip(calibrated) {
            surface.classes[class] = Some(found);
        }
        Ok(Some(surface))
    }

    /// Number of the designs of a study of this size, for a progress bar.
    #[must_use]
    pub fn designs(scenario: &Scenario, samples: u64) -> u64 {
        let classes = scenario.classes.iter();
        DESIGNS * classes.filter(|class| repays(class.share, samples)).count() as u64
    }

    /// Responses that were computed for it.
    #[must_use]
    pub fn responses(&self) -> u64 {
        self.responses
    }

    /// Sets of inputs for which the action fell somewhere with growing speed.
    #[must_use]
    pub fn not_monotonic(&self) -> u64 {
        let designs = self
            .classes
            .iter()
            .flatten()
            .flat_map(|class| &class.designs);
        designs.filter(|design| !design.monotonic).count() as u64
    }

    /// The action of an impact, and how far it is in doubt; `None` where nothing is known.
    #[must_use]
    pub(super) fn predict(&self, departure: &Departure) -> Option<Prediction> {
        let class = self.classes[departure.class].as_ref()?;
        let place = place_of(departure);
        let mut coordinates = place.iter().zip(self.active);
        if coordinates.any(|(z, active)| active && z.abs() > FARTHEST) {
            return None;
        }
        let speed = libm::log(departure.velocity_in_plane());
        if !(class.range[0]..=class.range[1]).contains(&speed) {
            return None;
        }
        let Interpolation {
            critical,
            monotonic,
        } = class.interpolate(&place, &self.active, None)?;
        let mut action = Action::None;
        let mut nearest = f64::INFINITY;
        for (index, it) in critical.iter().enumerate() {
            let distance = (speed - it.value).abs() / (class.scale[index] * it.deviation);
            nearest = nearest.min(distance);
            if speed > it.value {
                // A higher action without a lower one is a sign that the interpolation fails here.
                if action as usize != index {
                    nearest = 0.0;
                }
                action = ACTIONS[index];
            }
        }
        let doubt = DOUBTS.iter().filter(|bound| nearest >= **bound).count();
        Some(Prediction {
            action,
            doubt: match monotonic {
                true => doubt,
                false => doubt.min(DOUBT_WITHOUT_ORDER),
            },
        })
    }
}

/// Whether a class of this share has enough of the samples.
fn repays(share: f64, samples: u64) -> bool {
    share * samples as f64 > REPAID * RESPONSES_PER_CLASS as f64
}

fn active_coordinates(scenario: &Scenario) -> [bool; COORDINATES] {
    let scatters = |fixed: bool| !fixed;
    let classes = &scenario.classes;
    [
        scatters(
            classes
                .iter()
                .all(|class| class.mass.distribution.is_fixed()),
        ),
        scatters(
            classes
                .iter()
                .all(|class| class.force_factor.distribution.is_fixed()),
        ),
        scatters(scenario.yield_strength_factor.distribution.is_fixed()),
        scatters(scenario.top_load_factor.distribution.is_fixed()),
    ]
}

/// Inputs as standard normal variables.
fn place_of(departure: &Departure) -> [f64; COORDINATES] {
    std::array::from_fn(|index| normal::quantile(departure.quantiles[FIRST_COORDINATE + index]))
}

impl Design {
    /// Bisects for the critical speed of each action.
    fn new(departure: &Departure, range: [f64; 2], limit_state: &impl LimitState) -> Self {
        let mut responses = 0;
        let mut determined = true;
        let at_speed = limit_state.at_speeds(departure);
        let mut action = |logarithm: f64| {
            responses += 1;
            at_speed(libm::exp(logarithm)).unwrap_or_else(|| {
                determined = false;
                Action::Evacuate
            })
        };
        // More than the ends, to notice an action that falls with the speed.
        let [low, high] = range;
        let mut known: Vec<(f64, Action)> = (0..5)
            .map(|it| low + (high - low) * f64::from(it) / 4.0)
            .map(|logarithm| (logarithm, action(logarithm)))
            .collect();
        let mut critical = [f64::INFINITY; LEVELS - 1];
        for (index, sought) in ACTIONS.into_iter().enumerate() {
            loop {
                let first = known.iter().position(|(_, found)| *found >= sought);
                let Some(first) = first else { break };
                let Some(before) = first.checked_sub(1) else {
                    critical[index] = f64::NEG_INFINITY;
                    break;
                };
                let (below, above) = (known[before].0, known[first].0);
                let middle = 0.5 * (below + above);
                if above - below <= BRACKET {
                    critical[index] = middle;
                    break;
                }
                known.insert(first, (middle, action(middle)));
            }
        }
        Self {
            place: place_of(departure),
            critical,
            left: [0.0; LEVELS - 1],
            monotonic: determined && known.is_sorted_by_key(|(_, action)| *action),
            responses,
        }
    }
}

impl ClassSurface {
    /// Fits the trends, and scales the deviations so that of the designs, each predicted from the others, as many are within
    /// one as of a normal distribution.
    fn calibrated(mut designs: Vec<Design>, range: [f64; 2], active: &[bool; COORDINATES]) -> Self {
        let trends = std::array::from_fn(|action| trend(&designs, action, active));
        for design in &mut designs {
            let terms = terms(&design.place, active);
            design.left = std::array::from_fn(|action| {
                clamped(design.critical[action], range) - trend_at(&trends[action], &terms, range)
            });
        }
        let mut surface = Self {
            designs,
            range,
            trends,
            scale: [UNKNOWN_SCALE; LEVELS - 1],
        };
        let mut errors: [Vec<f64>; LEVELS - 1] = Default::default();
        for (index, design) in surface.designs.iter().enumerate() {
            let Some(found) = surface.interpolate(&design.place, active, Some(index)) else {
                continue;
            };
            let pairs = design.critical.iter().zip(found.critical);
            for (errors, (truth, found)) in errors.iter_mut().zip(pairs) {
                if truth.is_finite() || found.value.is_finite() {
                    let [truth, value] = [*truth, found.value].map(|it| clamped(it, range));
                    errors.push((truth - value).abs() / found.deviation.max(LEAST_DEVIATION));
                }
            }
        }
        for (scale, errors) in surface.scale.iter_mut().zip(&mut errors) {
            if errors.len() >= ENOUGH_ERRORS {
                errors.sort_by(f64::total_cmp);
                *scale = errors[(errors.len() as f64 * WITHIN_ONE_DEVIATION) as usize].max(1.0);
            }
        }
        surface
    }

    /// The critical speeds at a place: the trend plus a linear regression of what it leaves over the nearest designs, weighted
    /// with their distance; `None` where there are too few. A critical speed that all of them have outside the range is
    /// infinite, and certain. `without` leaves one design out of the regression.
    fn interpolate(
        &self,
        place: &[f64; COORDINATES],
        active: &[bool; COORDINATES],
        without: Option<usize>,
    ) -> Option<Interpolation> {
        let mut nearest: Vec<(f64, usize)> = self
            .designs
            .iter()
            .enumerate()
            .filter(|(index, _)| Some(*index) != without)
            .map(|(index, design)| {
                let mut square = 0.0;
                for coordinate in 0..COORDINATES {
                    if active[coordinate] {
                        square += (design.place[coordinate] - place[coordinate]).powi(2);
                    }
                }
                (square, index)
            })
            .collect();
        if nearest.len() < NEIGHBOURS {
            return None;
        }
        // Equal distances are ordered by the number of the design, so that the result does not depend on the selection.
        nearest.select_nth_unstable_by(NEIGHBOURS - 1, |a, b| {
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        nearest.truncate(NEIGHBOURS);
        nearest.sort_by_key(|(_, index)| *index);
        let farthest = nearest.iter().map(|it| it.0).fold(0.0, f64::max).max(1e-12);
        let rows: Vec<(f64, [f64; UNKNOWNS], &Design)> = nearest
            .iter()
            .map(|(square, index)| {
                let design = &self.designs[*index];
                let ratio = square / (1.05 * farthest);
                let mut row = [1.0; UNKNOWNS];
                for coordinate in 0..COORDINATES {
                    let difference = design.place[coordinate] - place[coordinate];
                    row[1 + coordinate] = if active[coordinate] { difference } else { 0.0 };
                }
                ((1.0 - ratio).powi(2), row, design)
            })
            .collect();
        let terms = terms(place, active);
        let factor = NormalEquations::new(rows.iter().map(|(weight, row, _)| (*weight, *row)));
        let mut critical = [Interpolated::default(); LEVELS - 1];
        for (action, it) in critical.iter_mut().enumerate() {
            let first = rows[0].2.critical[action];
            if first.is_infinite() && rows.iter().all(|row| row.2.critical[action] == first) {
                *it = Interpolated {
                    value: first,
                    // Any: the distance from it is infinite.
                    deviation: 1.0,
                };
                continue;
            }
            let values: [f64; NEIGHBOURS] = std::array::from_fn(|row| rows[row].2.left[action]);
            let observed = || {
                let rows = rows.iter().map(|(weight, row, _)| (*weight, *row));
                rows.zip(values)
            };
            let solution = factor.solve(observed());
            let squares: f64 = observed()
                .map(|((weight, row), value)| {
                    let fitted: f64 = row.iter().zip(solution).map(|(a, b)| a * b).sum();
                    weight * (value - fitted).powi(2)
                })
                .sum();
            // Per degree of freedom.
            let freedom = (NEIGHBOURS - UNKNOWNS) as f64 / NEIGHBOURS as f64;
            let deviation = (squares / (factor.weight * freedom)).sqrt();
            *it = Interpolated {
                value: trend_at(&self.trends[action], &terms, self.range) + solution[0],
                deviation: deviation.max(LEAST_DEVIATION),
            };
        }
        Some(Interpolation {
            critical,
            monotonic: rows.iter().all(|(_, _, design)| design.monotonic),
        })
    }
}

/// The quadratic function through the critical speeds that lie in the range; `None` where they are too few.
fn trend(designs: &[Design], action: usize, active: &[bool; COORDINATES]) -> Option<Trend> {
    let known: Vec<((f64, Trend), f64)> = designs
        .iter()
        .filter(|design| design.critical[action].is_finite())
        .map(|design| ((1.0, terms(&design.place, active)), design.critical[action]))
        .collect();
    (known.len() >= DESIGNS_PER_TERM * TERMS)
        .then(|| NormalEquations::new(known.iter().map(|(row, _)| *row)).solve(known.into_iter()))
}

/// The trend where the function has these terms, 0 without one.
fn trend_at(trend: &Option<Trend>, terms: &Trend, range: [f64; 2]) -> f64 {
    trend.as_ref().map_or(0.0, |trend| {
        clamped(terms.iter().zip(trend).map(|(a, b)| a * b).sum(), range)
    })
}

/// The terms of the quadratic function at a place; 0 for what contains a coordinate that does not scatter.
fn terms(place: &[f64; COORDINATES], active: &[bool; COORDINATES]) -> Trend {
    let z: [f64; COORDINATES] = std::array::from_fn(|it| if active[it] { place[it] } else { 0.0 });
    let mut terms = [1.0; TERMS];
    let mut next = 1;
    for first in 0..COORDINATES {
        terms[next] = z[first];
        next += 1;
        for second in first..COORDINATES {
            terms[next] = z[first] * z[second];
            next += 1;
        }
    }
    terms
}

/// A critical speed outside the range as a number beyond it.
fn clamped(logarithm: f64, range: [f64; 2]) -> f64 {
    logarithm.clamp(range[0] - BEYOND, range[1] + BEYOND)
}

/// The Cholesky factor of a weighted linear regression.
struct NormalEquations<const SIZE: usize> {
    factor: [[f64; SIZE]; SIZE],
    /// Sum of the weights.
    weight: f64,
}

impl<const SIZE: usize> NormalEquations<SIZE> {
    /// Of rows with their weights.
    fn new(rows: impl Iterator<Item = (f64, [f64; SIZE])>) -> Self {
        let mut matrix = [[0.0; SIZE]; SIZE];
        let mut weight = 0.0;
        for (w, row) in rows {
            weight += w;
            for i in 0..SIZE {
                for j in 0..=i {
                    matrix[i][j] += w * row[i] * row[j];
                }
            }
        }
        // Keeps the slope of a coordinate that does not vary at 0, and is negligible beside any other.
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] += 1e-9 * weight;
        }
        let factor = cholesky(&matrix);
        Self { factor, weight }
    }

    /// The unknowns for the values that belong to the same rows.
    fn solve(&self, rows: impl Iterator<Item = ((f64, [f64; SIZE]), f64)>) -> [f64; SIZE] {
        let mut right = [0.0; SIZE];
        for ((w, row), value) in rows {
            for i in 0..SIZE {
                right[i] += w * row[i] * value;
            }
        }
        solved(&self.factor, &right)
    }
}
