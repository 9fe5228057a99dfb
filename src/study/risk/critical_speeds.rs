//! Critical speeds of a class of vehicles as a function of the other inputs, to predict the severity of most samples.
//!
//! The predictions decide only how often a response has to be computed. They do not bias the result: a random share of them
//! is computed, too, and corrects the estimate and widens its interval (`src/study/risk/estimate.rs`).

use crate::study::cholesky::cholesky;
use rayon::ThreadPoolBuildError;

use super::departure::{Departure, DepartureSampler, LEAST_SPEED};
use super::evaluation::LimitState;
use super::normal;
use super::random::Purpose;
use super::scenario::Scenario;
use super::study::batch;
use super::tally::LEVELS;
use crate::assessment::Severity;
use crate::study::{Batch, BatchEnd, SEVERITIES};

/// Inputs on which a critical speed depends: mass, force factor, yield strength, load.
const COORDINATES: usize = 4;
/// Their first index among the levels of a departure.
const FIRST_COORDINATE: usize = 5;
/// Unknowns of a local regression: a constant and the slopes.
const UNKNOWNS: usize = COORDINATES + 1;
/// Designs of a class.
const DESIGNS: u64 = 300;
/// Designs from which a critical speed is interpolated.
const NEIGHBOURS: usize = 24;
/// Standard deviation of the designs, in standard deviations of the inputs: they cover the tails, too.
const SPREAD: f64 = 1.4;
/// Standard deviations of an input beyond which nothing is predicted.
const FARTHEST: f64 = 4.0;
/// Logarithm of the ratio of the speeds between which a critical speed is known.
const BRACKET: f64 = 0.008;
/// Least standard deviation of the logarithm of an interpolated speed.
const LEAST_DEVIATION: f64 = 0.002;
/// Share of the designs that the predictions from the others have to meet within their doubt.
const TRUSTED_SHARE: f64 = 0.998;
/// How far beyond the speeds that were looked at a critical speed is taken to be, in logarithms.
const BEYOND: f64 = 0.5;
/// Responses that the critical speeds of a class cost, about.
const RESPONSES_PER_CLASS: u64 = DESIGNS * 24;

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
    /// Doubt about a prediction, by severity, as a multiple of the deviation of its regression.
    doubt: [f64; LEVELS - 1],
}

/// The critical speeds of one set of inputs.
#[derive(Debug, Clone)]
struct Design {
    place: [f64; COORDINATES],
    /// Logarithm of the least speed \[m/s\] with each severity; infinite: outside the range.
    critical: [f64; LEVELS - 1],
    /// Whether the severity grew with the speed, as far as it was computed.
    monotonic: bool,
    responses: u64,
}

/// A critical speed from the designs near a place.
#[derive(Debug, Clone, Copy)]
struct Interpolated {
    value: f64,
    deviation: f64,
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
        let repays = |share: f64| share * samples as f64 > 2.0 * RESPONSES_PER_CLASS as f64;
        let chosen: Vec<usize> = (0..scenario.classes.len())
            .filter(|class| repays(scenario.classes[*class].share))
            .collect();
        // Faster ones are computed.
        let top = (1.1 * sampler.greatest_speed()).max(2.0 * LEAST_SPEED);
        let range = [libm::log((0.02 * top).max(LEAST_SPEED)), libm::log(top)];
        let mut designs = Vec::new();
        let end = search.run(
            chosen.len() as u64 * DESIGNS,
            |index| {
                let class = chosen[(index / DESIGNS) as usize];
                let spread = |level: f64| normal::probability(SPREAD * normal::quantile(level));
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
        let pool = batch(search.threads);
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
        let repays = |share: f64| share * samples as f64 > 2.0 * RESPONSES_PER_CLASS as f64;
        DESIGNS
            * scenario
                .classes
                .iter()
                .filter(|class| repays(class.share))
                .count() as u64
    }

    /// Responses that were computed for it.
    #[must_use]
    pub fn responses(&self) -> u64 {
        self.responses
    }

    /// Sets of inputs for which the severity fell somewhere with growing speed.
    #[must_use]
    pub fn not_monotonic(&self) -> u64 {
        let designs = self
            .classes
            .iter()
            .flatten()
            .flat_map(|class| &class.designs);
        designs.filter(|design| !design.monotonic).count() as u64
    }

    /// The severity of an impact, where it is far from every critical speed; `None` where it is in doubt.
    #[must_use]
    pub(super) fn predict(&self, departure: &Departure) -> Option<Severity> {
        let class = self.classes[departure.class].as_ref()?;
        let place = place_of(departure);
        let mut coordinates = place.iter().zip(self.active);
        if coordinates.any(|(z, active)| active && z.abs() > FARTHEST) {
            return None;
        }
        let speed = libm::log(departure.velocity);
        if !(class.range[0]..=class.range[1]).contains(&speed) {
            return None;
        }
        let critical = class.interpolate(&place, &self.active, None)?;
        let mut severity = Severity::None;
        for (index, it) in critical.iter().enumerate() {
            if (speed - it.value).abs() <= class.doubt[index] * it.deviation + 0.5 * BRACKET {
                return None;
            }
            if speed > it.value {
                // A higher severity without a lower one is a sign that the interpolation fails here.
                if severity as usize != index {
                    return None;
                }
                severity = SEVERITIES[index];
            }
        }
        Some(severity)
    }
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
    std::array::from_fn(|index| normal::quantile(departure.levels[FIRST_COORDINATE + index]))
}

impl Design {
    /// Bisects for the critical speed of each severity.
    fn new(departure: &Departure, range: [f64; 2], limit_state: &impl LimitState) -> Self {
        let mut responses = 0;
        let mut determined = true;
        let at_speed = limit_state.at_speeds(departure);
        let mut severity = |logarithm: f64| {
            responses += 1;
            at_speed(libm::exp(logarithm)).unwrap_or_else(|| {
                determined = false;
                Severity::Evacuate
            })
        };
        // More than the ends, to notice a severity that falls with the speed.
        let [low, high] = range;
        let mut known: Vec<(f64, Severity)> = (0..5)
            .map(|it| low + (high - low) * f64::from(it) / 4.0)
            .map(|logarithm| (logarithm, severity(logarithm)))
            .collect();
        let mut critical = [f64::INFINITY; LEVELS - 1];
        for (index, sought) in SEVERITIES.into_iter().enumerate() {
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
                known.insert(first, (middle, severity(middle)));
            }
        }
        Self {
            place: place_of(departure),
            critical,
            monotonic: determined && known.is_sorted_by_key(|(_, severity)| *severity),
            responses,
        }
    }
}

impl ClassSurface {
    /// Sets the doubt so that the designs, each predicted from the others, lie within it.
    fn calibrated(designs: Vec<Design>, range: [f64; 2], active: &[bool; COORDINATES]) -> Self {
        let mut surface = Self {
            designs,
            range,
            doubt: [f64::INFINITY; LEVELS - 1],
        };
        let mut errors: [Vec<f64>; LEVELS - 1] = Default::default();
        for (index, design) in surface.designs.iter().enumerate() {
            if !design.monotonic {
                continue;
            }
            let Some(critical) = surface.interpolate(&design.place, active, Some(index)) else {
                continue;
            };
            for (errors, (truth, found)) in
                errors.iter_mut().zip(design.critical.iter().zip(critical))
            {
                if truth.is_finite() || found.value.is_finite() {
                    let truth = clamped(*truth, range);
                    let found_value = clamped(found.value, range);
                    errors.push((truth - found_value).abs() / found.deviation.max(LEAST_DEVIATION));
                }
            }
        }
        for (doubt, errors) in surface.doubt.iter_mut().zip(&mut errors) {
            errors.sort_by(f64::total_cmp);
            let rank = (errors.len() as f64 * TRUSTED_SHARE) as usize;
            *doubt = errors
                .get(rank.min(errors.len().saturating_sub(1)))
                .copied()
                .unwrap_or(4.0)
                .max(2.0);
        }
        surface
    }

    /// The critical speeds at a place, by a linear regression over the nearest designs, weighted with their distance; `None`
    /// where one of them is not to be trusted. A critical speed that all of them have outside the range is infinite, and
    /// certain. `without` leaves one design out.
    fn interpolate(
        &self,
        place: &[f64; COORDINATES],
        active: &[bool; COORDINATES],
        without: Option<usize>,
    ) -> Option<[Interpolated; LEVELS - 1]> {
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
        if rows.iter().any(|(_, _, design)| !design.monotonic) {
            return None;
        }
        let factor = NormalEquations::new(&rows);
        let mut critical = [Interpolated {
            value: 0.0,
            deviation: 0.0,
        }; LEVELS - 1];
        for (severity, it) in critical.iter_mut().enumerate() {
            let first = rows[0].2.critical[severity];
            if first.is_infinite() && rows.iter().all(|row| row.2.critical[severity] == first) {
                *it = Interpolated {
                    value: first,
                    deviation: 0.0,
                };
                continue;
            }
            let values: [f64; NEIGHBOURS] =
                std::array::from_fn(|row| clamped(rows[row].2.critical[severity], self.range));
            let (value, deviation) = factor.regress(&rows, &values);
            *it = Interpolated {
                value,
                deviation: deviation.max(LEAST_DEVIATION),
            };
        }
        Some(critical)
    }
}

/// A critical speed outside the range as a number beyond it.
fn clamped(logarithm: f64, range: [f64; 2]) -> f64 {
    logarithm.clamp(range[0] - BEYOND, range[1] + BEYOND)
}

/// The Cholesky factor of a weighted linear regression.
struct NormalEquations {
    factor: [[f64; UNKNOWNS]; UNKNOWNS],
    weight: f64,
}

impl NormalEquations {
    fn new(rows: &[(f64, [f64; UNKNOWNS], &Design)]) -> Self {
        let mut matrix = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut weight = 0.0;
        for (w, row, _) in rows {
            weight += w;
            for i in 0..UNKNOWNS {
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

    /// The value at the place itself, and the weighted root mean square of the residuals, per degree of freedom.
    fn regress(&self, rows: &[(f64, [f64; UNKNOWNS], &Design)], values: &[f64]) -> (f64, f64) {
        let mut solution = [0.0; UNKNOWNS];
        for ((w, row, _), value) in rows.iter().zip(values) {
            for i in 0..UNKNOWNS {
                solution[i] += w * row[i] * value;
            }
        }
        let factor = &self.factor;
        for i in 0..UNKNOWNS {
            for k in 0..i {
                solution[i] -= factor[i][k] * solution[k];
            }
            solution[i] /= factor[i][i];
        }
        for i in (0..UNKNOWNS).rev() {
            for k in i + 1..UNKNOWNS {
                solution[i] -= factor[k][i] * solution[k];
            }
            solution[i] /= factor[i][i];
        }
        let squares: f64 = rows
            .iter()
            .zip(values)
            .map(|((w, row, _), value)| {
                let fitted: f64 = row.iter().zip(solution).map(|(a, b)| a * b).sum();
                w * (value - fitted).powi(2)
            })
            .sum();
        let freedom = (rows.len() - UNKNOWNS) as f64 / rows.len() as f64;
        (solution[0], (squares / (self.weight * freedom)).sqrt())
    }
}
