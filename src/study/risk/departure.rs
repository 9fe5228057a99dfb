//! A vehicle that leaves the road, and what of it reaches the column.

use std::f64::consts::PI;
use std::sync::Arc;

use super::random::{Purpose, Streams};
use super::reach::{Course, LEAST_SPEED, Reach};
use super::scenario::Scenario;
use crate::column::share_in_plane;

/// The inputs that scatter, in the order of the random numbers of a sample; the orientation only where the scenario has one.
pub const INPUT_NAMES: [&str; 10] = [
    "vehicle_class",
    "speed",
    "angle",
    "deceleration",
    "distance",
    "mass",
    "force_factor",
    "yield_strength",
    "top_load",
    "orientation",
];

/// Number of the inputs that scatter.
pub const INPUTS: usize = INPUT_NAMES.len();

/// The quantile of an orientation that is not drawn.
const NO_ORIENTATION: f64 = 0.5;

/// Samples of which one has to reach the column.
const FIRST_SAMPLES: u64 = 10;
/// Samples for a first look at the speeds at the column.
const PILOT_SAMPLES: u64 = 2000;

/// One vehicle that leaves the road and reaches the column.
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
    /// Direction of travel to the plane of the web \[rad\]; `None`: that of the parameters.
    pub direction: Option<f64>,
    /// The uniform random numbers of the inputs: the share of vehicles with a smaller value of each.
    pub quantiles: [f64; INPUTS],
    /// A random number that belongs to no input, for choices of the estimator.
    pub(super) choice: f64,
    /// Points that were drawn until a vehicle reached the column.
    pub(super) points: u64,
}

/// Draws vehicles that leave the road and reach the column: sample `i` depends on the seed and on `i` only.
#[derive(Debug, Clone)]
pub struct DepartureSampler {
    scenario: Scenario,
    streams: Streams,
    reach: Arc<Reach>,
    greatest_speed: f64,
}

impl DepartureSampler {
    /// The samples of a study.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64) -> Self {
        let mut sampler = Self {
            scenario: scenario.clone(),
            streams: Streams::new(0, Purpose::Pilot),
            reach: Reach::new(scenario).into(),
            greatest_speed: 0.0,
        };
        if !(0..FIRST_SAMPLES).any(|index| sampler.departure(index).reaches_column()) {
            let mut out_of_reach = Reach::clone(&sampler.reach);
            out_of_reach.out_of_reach = true;
            sampler.reach = out_of_reach.into();
        }
        // The same for every seed, so that results of several seeds have the same intervals of speed.
        let mut speeds: Vec<f64> = (0..PILOT_SAMPLES)
            .map(|index| sampler.departure(index).velocity)
            .collect();
        speeds.sort_by(f64::total_cmp);
        sampler.greatest_speed = speeds.last().copied().unwrap_or(0.0);
        sampler.streams = Streams::new(seed, Purpose::Sample);
        sampler
    }

    /// The same scenario with random numbers for another purpose.
    pub(super) fn for_purpose(&self, seed: u64, purpose: Purpose) -> Self {
        Self {
            streams: Streams::new(seed, purpose),
            ..self.clone()
        }
    }

    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// An upper bound of the probability that a vehicle that leaves the road on a course to the column reaches it; 0 if none
    /// does. The probability itself is this bound times the number of samples over the number of their points.
    #[must_use]
    pub fn reach_bound(&self) -> f64 {
        self.reach.bound()
    }

    /// A speed at the column that about one vehicle in two thousand exceeds \[m/s\]; 0 if none reaches it.
    #[must_use]
    pub fn greatest_speed(&self) -> f64 {
        self.greatest_speed
    }

    /// The sample of this number.
    #[must_use]
    pub fn departure(&self, index: u64) -> Departure {
        let mut numbers = self.streams.numbers(index);
        let (course, points) = self.reach.course(&self.scenario, &mut numbers);
        let [class, mass, force, yielding, load, choice] = numbers.take();
        // Drawn last, so that all other numbers are those of the same scenario without it.
        let orientation = self.scenario.orientation.as_ref().map(|it| {
            let quantile = numbers.next();
            (quantile, it.distribution.quantile(quantile))
        });
        let reached = course.is_some();
        let course = course.unwrap_or(Course {
            speed: 0.5,
            deceleration: 0.5,
            distance: 0.5,
            angle: 0.5,
        });
        let quantiles = [
            class,
            course.speed,
            course.angle,
            course.deceleration,
            course.distance,
            mass,
            force,
            yielding,
            load,
            orientation.map_or(NO_ORIENTATION, |(quantile, _)| quantile),
        ];
        let mut departure =
            self.of_quantiles(index, class_at(&self.scenario, class), quantiles, choice);
        departure.points = points;
        departure.direction =
            orientation.map(|(_, it)| direction(departure.angle, it.to_radians()));
        if reached {
            departure.velocity = departure.speed_at_column();
        }
        departure
    }

    /// A vehicle of this class in the plane of the web, without a speed; `quantiles` changes the quantiles of its inputs.
    pub(super) fn of_class(
        &self,
        index: u64,
        class: usize,
        quantiles: impl Fn(f64) -> f64,
    ) -> Departure {
        let mut numbers = self.streams.numbers(index);
        let quantiles = INPUT_NAMES.map(|name| match name {
            "orientation" => NO_ORIENTATION,
            _ => quantiles(numbers.next()),
        });
        let mut departure = self.of_quantiles(index, class, quantiles, numbers.next());
        // In the plane of the two bars, of which another direction takes the component.
        departure.direction = self.scenario.orientation.as_ref().map(|_| 0.0);
        departure
    }

    fn of_quantiles(
        &self,
        index: u64,
        class: usize,
        quantiles: [f64; INPUTS],
        choice: f64,
    ) -> Departure {
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
            _,
        ] = quantiles;
        let scenario = &self.scenario;
        let vehicle = &scenario.classes[class];
        Departure {
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
            direction: None,
            quantiles,
            choice,
            points: 0,
        }
    }
}

/// The direction of travel to the plane of the web \[rad\], in (-pi, pi\], of a vehicle at this angle to the road, if the plane has that
/// one.
fn direction(of_course: f64, of_web: f64) -> f64 {
    let between = of_course - of_web;
    match between {
        it if it > PI => it - 2.0 * PI,
        it if it <= -PI => it + 2.0 * PI,
        it => it,
    }
}

fn class_at(scenario: &Scenario, quantile: f64) -> usize {
    let mut below = 0.0;
    for (index, class) in scenario.classes.iter().enumerate() {
        below += class.share;
        if quantile < below {
            return index;
        }
    }
    // The shares add up to 1 only within rounding.
    let last = scenario.classes.iter().rposition(|class| class.share > 0.0);
    last.unwrap_or(0)
}

impl Departure {
    /// Whether the vehicle reaches the column. A sample whose vehicle does not has no other meaning than that.
    #[must_use]
    pub fn reaches_column(&self) -> bool {
        self.velocity > 0.0
    }

    /// The component of its speed at the column in the plane of the two bars \[m/s\], as far as its own direction tells.
    pub(super) fn velocity_in_plane(&self) -> f64 {
        let share = self.direction.map_or(1.0, share_in_plane);
        self.velocity * share
    }

    /// `sqrt(v0^2 - 2 a r)` with the path `r = d / sin(angle)` (JCSS Probabilistic Model Code, 2.18), of a vehicle that
    /// reaches the column.
    fn speed_at_column(&self) -> f64 {
        let path = match self.distance {
            0.0 => 0.0,
            distance => distance / libm::sin(self.angle),
        };
        let square = self.speed * self.speed - 2.0 * self.deceleration * path;
        // Rounding may leave a little less than the least speed.
        square.max(LEAST_SPEED * LEAST_SPEED).sqrt()
    }
}
