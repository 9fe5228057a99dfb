//! The curves over time: their quantities, units and the ranges of their axes.

use rerun::blueprint::components::Corner2D;

use super::colour::{self, Rgb};
use super::timeline::nanos;
use crate::column::{HINGES, Impact, MAX_MASSES, Phase, Sample, simulate};
use crate::messages::column_twin_msgs::ImpactReport;
use crate::observables::{
    self, CRUSH_ENERGY, DAMPING_WORK, IMPACT_LOSS, KINETIC_ENERGY, MOMENT, NORMAL_FORCE,
    OPEN_OR_CRUSHED, Observable, PLASTIC_WORK, POTENTIAL_ENERGY, SPRING_FORCE, U1, U2, V1, each,
};
use crate::parameters::Parameters;
use crate::shape::round_number;

/// Number of plots.
pub const PLOTS: usize = 7;

/// A plot of quantities with a common unit.
#[derive(Debug)]
pub struct Plot {
    /// Entity of its values.
    pub entity: &'static str,
    /// Title in plain words, without the unit.
    pub title: &'static str,
    /// What it shows in the symbols of the paper, for the legend.
    pub symbols: &'static str,
    /// What it shows.
    pub shown: &'static [Observable],
    /// Colours of its curves.
    pub colours: &'static [Rgb],
    /// Where the names of the curves hide least of the curves.
    pub names: Corner2D,
    /// Width of the last curve \[points\].
    pub last_width: f32,
    /// Whether each curve shows the sum of what is shown so far.
    pub is_stacked: bool,
}

impl Plot {
    /// Whether it is about a vehicle that crushes, and not shown for a rigid mass.
    #[must_use]
    pub fn is_of_vehicle(&self) -> bool {
        each(self.shown, 0).next().is_none()
    }

    /// The unit, and the factor to it from the SI unit.
    fn unit(&self) -> (&'static str, f64) {
        let (_, unit, per_si) = self.shown[0].kind.units();
        (unit, per_si)
    }

    /// Title with the unit.
    #[must_use]
    pub fn title_with_unit(&self) -> String {
        format!("{} [{}]", self.title, self.unit().0)
    }

    /// Names of its curves.
    #[must_use]
    pub fn curve_names(&self) -> Vec<String> {
        let mut names: Vec<_> = each(self.shown, MAX_MASSES)
            .map(|(it, index)| it.in_plots(index))
            .collect();
        if self.is_stacked {
            names
                .iter_mut()
                .skip(1)
                .for_each(|it| it.insert_str(0, "+ "));
            names
                .last_mut()
                .into_iter()
                .for_each(|it| it.push_str(" = total"));
        }
        names
    }

    /// The values of a sample in the unit of the plot, one for each curve; fewer where a vehicle has fewer masses than there are curves.
    ///
    /// As a stack, the last value stays constant as long as the energy balance closes: the potential energy of the load is counted with
    /// the elastic energy of the column, the elastic energy of the vehicle's springs with what they dissipate.
    #[must_use]
    pub fn values(&self, sample: &Sample) -> Vec<f64> {
        let mut sum = 0.0;
        let values = each(self.shown, sample.vehicle.masses).map(|(it, index)| {
            let value = it.value(sample, index);
            sum += value;
            self.unit().1 * if self.is_stacked { sum } else { value }
        });
        values.collect()
    }
}

/// Entity of the forces of the second and the third spring of a vehicle, in the plot of the contact force, which is that of
/// the first.
pub const SPRING_FORCES: &str = "plots/spring_forces";

/// Forces of the second and the third spring of a vehicle in the unit of their plot; none if it has one mass, or none.
pub fn spring_forces(sample: &Sample) -> impl Iterator<Item = f64> {
    let (_, per_si) = ALL[CONTACT_FORCE].unit();
    (1..sample.vehicle.masses).map(move |spring| per_si * SPRING_FORCE.value(sample, spring))
}

/// Entity of the path of the vehicle's front, in the plot of the displacement. Curves are drawn in the order of their entities:
/// this one lies below that of the column, with which it coincides in contact.
pub const VEHICLE_PATH: &str = "plots/displacement_of_vehicle";

/// Position of the vehicle's front in the unit of its plot, where the axis from `low` to `high` holds it: it comes from far and
/// travels without limit, so that an axis that held all of its path would show nothing of the column.
#[must_use]
pub fn vehicle_front(sample: &Sample, [low, high]: [f64; 2]) -> Option<f64> {
    let front = ALL[DISPLACEMENT].unit().1 * sample.impactor_position;
    (sample.phase != Phase::Idle && (low..=high).contains(&front)).then_some(front)
}

/// Entity of the impact impulses, which are marked in the plot of the contact force.
pub const IMPACT_IMPULSES: &str = "plots/contact_force/impact_impulses";

/// Index of the plot of the displacement at the impact.
pub const DISPLACEMENT: usize = 0;

/// Index of the plot of the contact force.
pub const CONTACT_FORCE: usize = 4;

/// Index of the plot of the crush.
const CRUSH: usize = 6;

/// Figures 5 to 8 of the paper, the contact force, the energy ledger and the crush.
pub const ALL: [Plot; PLOTS] = [
    Plot {
        entity: "plots/horizontal_displacement",
        title: "Displacement at the impact",
        symbols: "v1 of the column, v_c of the vehicle's front (Figure 5 of the paper)",
        shown: &[V1],
        colours: &[colour::IMPACT_POINT],
        last_width: 2.0,
        ..PLOT
    },
    Plot {
        entity: "plots/vertical_displacement",
        title: "Shortening",
        symbols: "u1 at the impact, u2 at the top, both downwards (Figure 6)",
        shown: &[U1, U2],
        colours: &[colour::IMPACT_POINT, colour::TOP],
        last_width: 2.0,
        ..PLOT
    },
    Plot {
        entity: "plots/normal_force",
        title: "Axial forces",
        symbols: "N_a below and N_b above the impact, tension positive (Figure 7)",
        shown: &[NORMAL_FORCE],
        colours: &[colour::BAR_A, colour::BAR_B],
        names: Corner2D::RightTop,
        ..PLOT
    },
    Plot {
        entity: "plots/bending_moment",
        title: "Moments",
        symbols: "M of the hinges: 1a below, 1b above the impact, 2 top, 3 base (Figure 8)",
        shown: &[MOMENT],
        colours: &colour::HINGE,
        names: Corner2D::LeftBottom,
        ..PLOT
    },
    Plot {
        entity: "plots/contact_force/smooth",
        title: "Contact force",
        symbols: "of the vehicle on the column; with several masses, the forces of the springs behind it, too",
        shown: &[observables::CONTACT_FORCE],
        colours: &[colour::CONTACT],
        names: Corner2D::RightTop,
        last_width: 2.0,
        ..PLOT
    },
    Plot {
        entity: "plots/energy",
        title: "Energy",
        symbols: "stacked: the topmost line stays level as long as the balance closes",
        shown: &[
            IMPACT_LOSS,
            CRUSH_ENERGY,
            DAMPING_WORK,
            PLASTIC_WORK,
            POTENTIAL_ENERGY,
            KINETIC_ENERGY,
        ],
        colours: &colour::ENERGIES,
        names: Corner2D::LeftBottom,
        last_width: 3.0,
        is_stacked: true,
    },
    Plot {
        entity: "plots/crush",
        title: "Crush of the vehicle",
        symbols: "of each spring, front first",
        shown: &[OPEN_OR_CRUSHED],
        colours: &colour::SPRING,
        ..PLOT
    },
];

/// What plots have in common.
const PLOT: Plot = Plot {
    entity: "",
    title: "",
    symbols: "",
    shown: &[],
    colours: &[],
    names: Corner2D::RightBottom,
    last_width: 1.5,
    is_stacked: false,
};

/// The ranges of the axes, in the unit of each plot. They are known before the curves are drawn, so that no axis jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranges {
    /// Smallest and largest value that the curves reach, by plot.
    reached: [[f64; 2]; PLOTS],
}

impl Default for Ranges {
    fn default() -> Self {
        Self {
            reached: [[0.0; 2]; PLOTS],
        }
    }
}

/// Maximum number of steps that are computed to predict the ranges of the axes.
const MAX_PREDICTED_STEPS: f64 = 20_000.0;

impl Ranges {
    /// The ranges that an impact on the undamaged column of these parameters reaches.
    #[must_use]
    pub fn predicted(parameters: &Parameters, impact: &Impact) -> Self {
        let mut ranges = Self::default();
        let impact = Impact {
            gap: 0.0,
            ..*impact
        };
        let column = parameters.column_properties().before(&impact);
        let longest = MAX_PREDICTED_STEPS * 1e-9 * parameters.step_nanos() as f64;
        let duration = parameters.response_duration().min(longest);
        // If the impact cannot be simulated, the axes follow the states that arrive.
        let _ = simulate(&column, &impact, duration, &mut |sample| {
            ranges.include(sample)
        });
        ranges
    }

    /// Extends the ranges to the values of a sample.
    pub fn include(&mut self, sample: &Sample) {
        for (plot, reached) in ALL.iter().zip(&mut self.reached) {
            for value in plot.values(sample).into_iter().filter(|it| it.is_finite()) {
                reached[0] = reached[0].min(value);
                reached[1] = reached[1].max(value);
            }
        }
        for force in spring_forces(sample).filter(|it| it.is_finite()) {
            let [_, largest] = &mut self.reached[CONTACT_FORCE];
            *largest = largest.max(force);
        }
    }

    /// Extends the ranges to the values of a report.
    pub fn include_report(&mut self, report: &ImpactReport) {
        let mut include = |plot: usize, value: f64| {
            if value.is_finite() {
                let value = ALL[plot].unit().1 * value;
                self.reached[plot][0] = self.reached[plot][0].min(value);
                self.reached[plot][1] = self.reached[plot][1].max(value);
            }
        };
        include(DISPLACEMENT, report.max_v1);
        include(1, report.max_u2);
        include(CONTACT_FORCE, report.peak_contact_force);
        for crush in report.max_crush.iter() {
            include(CRUSH, *crush);
        }
    }

    /// Extends the ranges to those of `other`; whether an axis has changed.
    pub fn cover(&mut self, other: &Self) -> bool {
        let before = self.axes();
        for (own, [low, high]) in self.reached.iter_mut().zip(other.reached) {
            own[0] = own[0].min(low);
            own[1] = own[1].max(high);
        }
        self.axes() != before
    }

    /// The ends of every axis: round numbers beyond the values.
    #[must_use]
    pub fn axes(&self) -> [[f64; 2]; PLOTS] {
        self.reached.map(|[low, high]| {
            let span = high - low;
            if span <= 0.0 {
                return [-1.0, 1.0];
            }
            let step = round_number(0.1 * span);
            let margin = 0.05 * span;
            let below = ((low - margin) / step).floor() * step;
            let above = ((high + margin) / step).ceil() * step;
            [below, above]
        })
    }

    /// The value at which impact impulses are marked in the plot of the contact force: near its upper end.
    #[must_use]
    pub fn impact_impulse_mark(&self) -> f64 {
        let [low, high] = self.axes()[CONTACT_FORCE];
        low + 0.93 * (high - low)
    }
}

/// The mass of the vehicle, deduced from samples of its impact \[kg\].
///
/// If the column was at rest before the first sample, the vehicle has the kinetic energy that is not the column's; a
/// impact impulse has given the column half the impulse times the velocity of the impact point, whose mass is `struck` \[kg\].
/// Otherwise the mass follows from the impulse that the vehicle has lost since the first sample.
#[must_use]
pub fn mass_of(first: &Sample, sample: &Sample, struck: f64) -> Option<f64> {
    let by_impact_impulse = first.impulse / struck;
    let moved = (first.v1_rate - by_impact_impulse).abs() > 1e-6 * by_impact_impulse.max(1e-6);
    let still = !moved && first.u1_rate.abs() + first.u2_rate.abs() < 1e-9;
    let square = first.impactor_velocity * first.impactor_velocity;
    let lost = first.impactor_velocity - sample.impactor_velocity;
    let given = sample.impulse - first.impulse;
    let mass = if still && square > 0.0 {
        (2.0 * first.kinetic_energy - first.impulse * first.v1_rate) / square
    } else if given > 0.0 && lost > 0.0 {
        given / lost
    } else {
        return None;
    };
    (mass.is_finite() && mass > 0.0).then_some(mass)
}

/// Whether two samples are so far apart in time that the scene shows both.
#[must_use]
pub fn apart(last: Option<f64>, next: f64, period_nanos: i64) -> bool {
    last.is_none_or(|last| next < last || nanos(next) - nanos(last) >= period_nanos)
}

/// Moment and normal force of a hinge relative to its resistances, `[M / M^p, N / N^p]`.
#[must_use]
pub fn stress(sample: &Sample, hinge: usize, resistances: [f64; 2]) -> [f32; 2] {
    debug_assert!(hinge < HINGES);
    let it = &sample.hinges[hinge];
    [
        (it.moment / resistances[0]) as f32,
        (it.normal_force / resistances[1]) as f32,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::Model;

    const CAR: Impact = Impact {
        mass: 1500.0,
        velocity: 10.0,
        gap: 0.0,
        restitution: 0.0,
        vehicle: None,
        bumper_height: 0.0,
        transverse_force: 0.0,
    };

    fn samples() -> Vec<Sample> {
        samples_with(0.0)
    }

    fn samples_with(gap: f64) -> Vec<Sample> {
        let column = Parameters::default().column_properties();
        let mut samples = Vec::new();
        simulate(&column, &Impact { gap, ..CAR }, 2.0, &mut |sample| {
            samples.push(*sample)
        })
        .expect("simulated");
        samples
    }

    #[test]
    fn the_stack_of_energies_stays_constant() {
        let samples = samples();
        let stack = |sample: &Sample| ALL[5].values(sample);
        let supplied = stack(&samples[0])[5];
        assert!((supplied - 75.0).abs() < 5.0, "{supplied}");
        for sample in &samples {
            let stack = stack(sample);
            assert!((stack[5] / supplied - 1.0).abs() < 1e-9);
            assert!(stack.windows(2).take(2).all(|pair| pair[1] >= pair[0]));
        }
    }

    #[test]
    fn predicted_axes_hold_the_whole_impact_and_do_not_move() {
        let parameters = Parameters::default();
        let mut ranges = Ranges::predicted(&parameters, &CAR);
        let axes = ranges.axes();
        let mut reached = Ranges::default();
        for sample in samples() {
            reached.include(&sample);
        }
        for (plot, [low, high]) in reached.reached.iter().enumerate() {
            assert!(axes[plot][0] < *low && *high < axes[plot][1], "{plot}");
        }
        assert!(!ranges.cover(&reached));
        reached.include(&Sample {
            v1: 1.0,
            ..Sample::default()
        });
        assert!(ranges.cover(&reached) && ranges.axes()[0][1] > 1e3);
    }

    /// The axis holds the column; the path of the vehicle, which comes from half a metre away, is drawn while it is on the axis.
    #[test]
    fn the_path_of_the_vehicle_does_not_leave_its_axis() {
        let samples = samples_with(0.5);
        let mut ranges = Ranges::default();
        for sample in &samples {
            ranges.include(sample);
        }
        let axis = ranges.axes()[DISPLACEMENT];
        assert!(axis[0] > -100.0 && axis[1] < 500.0, "{axis:?}");
        assert_eq!(vehicle_front(&samples[0], axis), None);
        let touches = |it: &&Sample| it.phase == Phase::Contact;
        let in_contact = samples.iter().filter(touches);
        assert!(in_contact.clone().count() > 0);
        for sample in in_contact {
            let front = vehicle_front(sample, axis).expect("is on the axis");
            assert!((front - 1e3 * sample.v1).abs() < 1e-3, "{front}");
        }
        let away = Sample {
            impactor_position: -0.5,
            ..samples[samples.len() - 1]
        };
        assert_eq!(vehicle_front(&away, axis), None);
        assert_eq!(vehicle_front(&Sample::default(), axis), None);
    }

    /// Symbols and numbers of figures are for the legend.
    #[test]
    fn titles_and_curves_are_in_plain_words() {
        for plot in &ALL {
            for text in plot
                .curve_names()
                .into_iter()
                .chain([plot.title_with_unit()])
            {
                let words = ["Fig", "v1", "u1", "u2", "v_c", "N_a", "N_b", "impactor"];
                assert!(!words.iter().any(|it| text.contains(it)), "{text}");
            }
            assert!(!plot.symbols.is_empty(), "{}", plot.title);
        }
    }

    #[test]
    fn every_plot_has_a_name_for_every_curve_and_a_unit() {
        let mut sample = Sample::default();
        sample.vehicle.masses = MAX_MASSES;
        for plot in &ALL {
            let names = plot.curve_names();
            assert_eq!(names.len(), plot.values(&sample).len());
            assert_eq!(names.len(), plot.colours.len());
            assert!(names.iter().all(|it| !it.is_empty()), "{names:?}");
            assert!(plot.shown.iter().all(|it| it.kind == plot.shown[0].kind));
        }
    }

    #[test]
    fn the_mass_follows_from_energy_or_impulse() {
        let struck = {
            let column = Parameters::default().column_properties();
            Model::new(&column).expect("stands").impact_point_mass
        };
        for gap in [0.0, 0.01] {
            let samples = samples_with(gap);
            let first = &samples[0];
            let mass = mass_of(first, first, struck).expect("known");
            assert!((mass - 1500.0).abs() < 1e-6, "{mass}");
            let moving = Sample {
                v1_rate: first.v1_rate + 1.0,
                ..*first
            };
            assert_eq!(mass_of(&moving, first, struck), None);
            let mass = mass_of(&moving, &samples[600], struck).expect("known");
            assert!((mass - 1500.0).abs() < 1e-3, "{mass}");
        }
    }
}
