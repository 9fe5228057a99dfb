//! A vehicle that leaves the road, and what of it reaches the column.

use super::random::{Purpose, Streams};
use super::scenario::Scenario;

/// The inputs that scatter, in the order of the random numbers of a sample.
pub const INPUT_NAMES: [&str; 9] = [
    "vehicle_class",
    "speed",
    "angle",
    "deceleration",
    "distance",
    "mass",
    "force_factor",
    "yield_strength",
    "top_load",
];

/// Number of the inputs that scatter.
pub const INPUTS: usize = INPUT_NAMES.len();

/// Speed at the column below which an impact is not followed \[m/s\]: the vehicle counts as stopped before it. At this speed
/// an articulated lorry of 40 t has 2 J.
pub const LEAST_SPEED: f64 = 0.01;

/// One vehicle that leaves the road on a course to the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// Number of the sample.
    pub index: u64,
    /// Its class, an index of [`Scenario::classes`].
    pub class: usize,
    /// Speed when leaving the road \[m/s\].
    pub speed: f64,
    /// Angle between road and course \[rad\].
    pub angle: f64,
    /// Deceleration behind the edge of the road \[m/s²\].
    pub deceleration: f64,
    /// Distance of the column from the edge of the road \[m\].
    pub distance: f64,
    /// Total mass \[kg\].
    pub mass: f64,
    /// Factor of the forces of its front.
    pub force_factor: f64,
    /// Yield strength of the column over the nominal one.
    pub yield_factor: f64,
    /// Load at the top of the column over that of the parameters.
    pub load_factor: f64,
    /// Speed at the column \[m/s\]; 0 if the vehicle stops before it.
    pub velocity: f64,
    /// The uniform random numbers of the inputs: the share of vehicles with a smaller value of each.
    pub levels: [f64; INPUTS],
    /// A random number that belongs to no input, for choices of the estimator.
    pub(super) choice: f64,
}

/// Draws vehicles that leave the road: sample `i` depends on the seed and on `i` only.
#[derive(Debug, Clone)]
pub struct DepartureSampler {
    scenario: Scenario,
    streams: Streams,
}

impl DepartureSampler {
    /// The samples of a study.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64) -> Self {
        Self::with_purpose(scenario, seed, Purpose::Sample)
    }

    pub(super) fn with_purpose(scenario: &Scenario, seed: u64, purpose: Purpose) -> Self {
        Self {
            scenario: scenario.clone(),
            streams: Streams::new(seed, purpose),
        }
    }

    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The sample of this number.
    #[must_use]
    pub fn departure(&self, index: u64) -> Departure {
        let numbers: [f64; INPUTS + 1] = self.streams.uniform(index);
        let mut levels = [0.0; INPUTS];
        levels.copy_from_slice(&numbers[..INPUTS]);
        let class = class_at(&self.scenario, levels[0]);
        self.of_levels(index, class, levels, numbers[INPUTS])
    }

    /// The sample of this number, as if it were of this class.
    pub(super) fn of_class(
        &self,
        index: u64,
        class: usize,
        levels: impl Fn(f64) -> f64,
    ) -> Departure {
        let numbers: [f64; INPUTS + 1] = self.streams.uniform(index);
        let levels = std::array::from_fn(|input| levels(numbers[input]));
        self.of_levels(index, class, levels, numbers[INPUTS])
    }

    fn of_levels(&self, index: u64, class: usize, levels: [f64; INPUTS], choice: f64) -> Departure {
        let [
            _,
            speed,
            angle,
            deceleration,
            distance,
            mass,
            force,
            yielding,
            load,
        ] = levels;
        let scenario = &self.scenario;
        let vehicle = &scenario.classes[class];
        let mut departure = Departure {
            index,
            class,
            speed: scenario.speed.distribution.quantile(speed) / 3.6,
            angle: scenario.angle.distribution.quantile(angle).to_radians(),
            deceleration: scenario.deceleration.distribution.quantile(deceleration),
            distance: scenario.distance.distribution.quantile(distance),
            mass: vehicle.mass.distribution.quantile(mass),
            force_factor: vehicle.force_factor.distribution.quantile(force),
            yield_factor: scenario
                .yield_strength_factor
                .distribution
                .quantile(yielding),
            load_factor: scenario.top_load_factor.distribution.quantile(load),
            velocity: 0.0,
            levels,
            choice,
        };
        departure.velocity = departure.speed_at_column();
        departure
    }
}

fn class_at(scenario: &Scenario, level: f64) -> usize {
    let mut below = 0.0;
    for (index, class) in scenario.classes.iter().enumerate() {
        below += class.share;
        if level < below {
            return index;
        }
    }
    // The shares add up to 1 only within rounding.
    let last = scenario.classes.iter().rposition(|class| class.share > 0.0);
    last.unwrap_or(0)
}

impl Departure {
    /// Whether the vehicle reaches the column.
    #[must_use]
    pub fn reaches_column(&self) -> bool {
        self.velocity > 0.0
    }

    /// `sqrt(v0^2 - 2 a r)` with the path `r = d / sin(angle)` (JCSS Probabilistic Model Code, 2.18); 0 where the vehicle
    /// stops before the column.
    fn speed_at_column(&self) -> f64 {
        let path = self.distance / libm::sin(self.angle);
        let square = self.speed * self.speed - 2.0 * self.deceleration * path;
        // At a distance of 0 and an angle of 0 the path is NaN, and the vehicle at the column.
        let square = if self.distance == 0.0 {
            self.speed * self.speed
        } else {
            square
        };
        match square > LEAST_SPEED * LEAST_SPEED {
            true => square.sqrt(),
            false => 0.0,
        }
    }
}
