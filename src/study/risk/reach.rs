//! Which of the vehicles that leave the road reach the column: how many, and how their speeds, angles and decelerations are
//! distributed.
//!
//! In a car park two vehicles of a thousand reach a column at 3 m, and drawing all the others would be a waste. Given speed,
//! deceleration and distance, a vehicle reaches the column where its angle exceeds `asin(2 a d / v0^2)`, which has a closed
//! probability. It increases with the speed and falls with deceleration and distance, so that in a cell of their quantiles its
//! value at one corner is an upper bound. Drawing the cell in proportion to its bound, a point in it, and accepting the point
//! with the probability at the point over the bound gives exactly the distribution of the vehicles that reach the column, whatever
//! the cells are; and the accepted share, times the sum of the bounds, is an unbiased estimate of how many reach it.

use super::normal;
use super::random::Numbers;
use super::scenario::Scenario;

/// Speed at the column below which an impact is not followed \[m/s\]: the vehicle counts as stopped before it. At this speed
/// an articulated lorry of 40 t has 2 J.
pub const LEAST_SPEED: f64 = 0.01;

/// Points after which a sample has no vehicle that reaches the column. Cells are so small that about every second point is
/// accepted.
const MAX_POINTS: u64 = 10_000;
/// Standard deviations that the cells divide evenly, on either side of the mean.
const TAIL: f64 = 7.5;

/// Cells of the quantiles of speed, deceleration and distance, with an upper bound of the probability of reaching the column.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    /// Bounds of the quantiles, for each of the three.
    edges: [Vec<f64>; 3],
    /// Set where a long search found no vehicle that reaches the column: only the bound is known then.
    pub out_of_reach: bool,
    /// Sums of the probabilities of the cells, each times its bound, distance fastest.
    sums: Vec<f64>,
}

/// Quantiles of the inputs that decide whether a vehicle reaches the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Course {
    pub speed: f64,
    pub deceleration: f64,
    pub distance: f64,
    pub angle: f64,
}

impl Reach {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let scatters = [&scenario.speed, &scenario.deceleration, &scenario.distance]
            .map(|input| !input.distribution.is_fixed());
        // Three that scatter have coarser cells than two.
        let counts = match scatters[2] {
            false => [240, 120, 1],
            true => [120, 60, 60],
        };
        let edges: [Vec<f64>; 3] =
            std::array::from_fn(|input| quantiles(if scatters[input] { counts[input] } else { 1 }));
        let mut sums = Vec::new();
        let mut sum = 0.0;
        for speed in edges[0].windows(2) {
            for deceleration in edges[1].windows(2) {
                for distance in edges[2].windows(2) {
                    let best = probability(scenario, [speed[1], deceleration[0], distance[0]]);
                    let share = (speed[1] - speed[0])
                        * (deceleration[1] - deceleration[0])
                        * (distance[1] - distance[0]);
                    sum += share * best;
                    sums.push(sum);
                }
            }
        }
        Self {
            edges,
            out_of_reach: false,
            sums,
        }
    }

    /// The sum of the bounds: at least the probability of reaching the column.
    pub(super) fn bound(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// A vehicle that reaches the column, `None` after too many points; and how many points it took.
    pub(super) fn course(
        &self,
        scenario: &Scenario,
        numbers: &mut Numbers,
    ) -> (Option<Course>, u64) {
        if self.bound() <= 0.0 || self.out_of_reach {
            return (None, 1);
        }
        for points in 1..=MAX_POINTS {
            let [chosen, speed, deceleration, distance, accepted] = numbers.take();
            let wanted = chosen * self.bound();
            let cell = self
                .sums
                .partition_point(|sum| *sum <= wanted)
                .min(self.sums.len() - 1);
            let [_, decelerations, distances] = self.edges.each_ref().map(|edges| edges.len() - 1);
            let place = [
                cell / (decelerations * distances),
                cell / distances % decelerations,
                cell % distances,
            ];
            let [low, high]: [[f64; 3]; 2] = [0, 1]
                .map(|end| std::array::from_fn(|input| self.edges[input][place[input] + end]));
            let quantiles: [f64; 3] = {
                let within = [speed, deceleration, distance];
                std::array::from_fn(|input| low[input] + within[input] * (high[input] - low[input]))
            };
            let bound = probability(scenario, [high[0], low[1], low[2]]);
            let here = probability(scenario, quantiles);
            if accepted * bound < here {
                let course = Course {
                    speed: quantiles[0],
                    deceleration: quantiles[1],
                    distance: quantiles[2],
                    // Of the angles, one that is large enough.
                    angle: 1.0 - numbers.next() * here,
                };
                return (Some(course), points);
            }
        }
        (None, MAX_POINTS)
    }
}

/// Probability that the angle is large enough, at these quantiles of speed, deceleration and distance.
fn probability(scenario: &Scenario, [speed, deceleration, distance]: [f64; 3]) -> f64 {
    let speed = scenario.speed.distribution.quantile(speed) / 3.6;
    let deceleration = scenario.deceleration.distribution.quantile(deceleration);
    let distance = scenario.distance.distribution.quantile(distance);
    let energy = speed * speed - LEAST_SPEED * LEAST_SPEED;
    // The work of braking over the shortest path, that at a right angle.
    let work = 2.0 * deceleration * distance;
    if energy <= 0.0 || work >= energy {
        return 0.0;
    }
    // An infinite work over an infinite energy, at the ends of both distributions, is bounded by 1.
    let least_angle = if work > 0.0 && energy.is_finite() {
        libm::asin(work / energy)
    } else {
        0.0
    };
    scenario
        .angle
        .distribution
        .exceedance(least_angle.to_degrees())
}

/// Bounds of `count` intervals of a quantile, even in standard deviations of a normal variable.
fn quantiles(count: usize) -> Vec<f64> {
    let mut bounds: Vec<f64> = (0..=count)
        .map(|it| normal::probability(TAIL * (2.0 * it as f64 / count as f64 - 1.0)))
        .collect();
    bounds[0] = 0.0;
    bounds[count] = 1.0;
    bounds
}
