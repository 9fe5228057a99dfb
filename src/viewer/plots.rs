//! The curves over time: their quantities, units and the ranges of their axes.

use rerun::blueprint::components::Corner2D;

use super::colour::{self, Rgb};
use super::timeline::nanos;
use crate::column::{HINGES, Impact, MAX_MASSES, Phase, Sample, simulate};
use crate::messages::column_twin_msgs::ImpactReport;
use crate::parameters::Parameters;
use crate::shape::round_number;

/// Number of plots.
pub const PLOTS: usize = 7;

/// A plot of quantities with a common unit.
#[derive(Debug)]
pub struct Plot {
    /// Entity of its values.
    pub entity: &'static str,
    /// Title in plain words, with the unit.
    pub title: &'static str,
    /// What it shows in the symbols of the paper, for the legend.
    pub symbols: &'static str,
    /// Factor from the SI unit to the unit of the plot.
    pub per_si: f64,
    /// Names and colours of its curves.
    pub curves: &'static [(&'static str, Rgb)],
    /// Where the names of the curves hide least of the curves.
    pub names: Corner2D,
    /// Width of the last curve \[points\].
    pub last_width: f32,
    /// The values of a sample in SI units, one for each curve; fewer where a vehicle has fewer masses than there are curves.
    pub values: fn(&Sample) -> Vec<f64>,
    /// Whether it is about a vehicle that crushes, and not shown for a rigid mass.
    pub of_vehicle: bool,
}

/// Entity of the forces of the second and the third spring of a vehicle, in the plot of the contact force, which is that of
/// the first.
pub const SPRING_FORCES: &str = "plots/spring_forces";

/// Names and colours of the curves of [`SPRING_FORCES`].
pub const SPRINGS_BEHIND: [(&str, Rgb); MAX_MASSES - 1] = [
    ("spring 2", colour::SPRING[1]),
    ("spring 3", colour::SPRING[2]),
];

/// Forces of the second and the third spring of a vehicle \[N\]; empty if it has one mass, or none.
#[must_use]
pub fn spring_forces(sample: &Sample) -> &[f64] {
    let vehicle = &sample.vehicle;
    vehicle.force.get(1..vehicle.masses).unwrap_or_default()
}

/// Entity of the path of the vehicle's front, in the plot of the displacement. Curves are drawn in the order of their entities:
/// this one lies below that of the column, with which it coincides in contact.
pub const VEHICLE_PATH: &str = "plots/displacement_of_vehicle";

/// Name and colour of the curve of [`VEHICLE_PATH`].
pub const VEHICLE: (&str, Rgb) = ("vehicle", colour::IMPACTOR);

/// Position of the vehicle's front in the unit of its plot, where the axis from `low` to `high` holds it: it comes from far and
/// travels without limit, so that an axis that held all of its path would show nothing of the column.
#[must_use]
pub fn vehicle_front(sample: &Sample, [low, high]: [f64; 2]) -> Option<f64> {
    let front = ALL[DISPLACEMENT].per_si * sample.impactor_position;
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
        title: "Displacement at the impact [mm]",
        symbols: "v1 of the column, v_c of the vehicle's front (Figure 5 of the paper)",
        per_si: 1e3,
        curves: &[("column", colour::IMPACT_POINT)],
        names: Corner2D::RightBottom,
        last_width: 2.0,
        values: |it| vec![it.v1],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/vertical_displacement",
        title: "Shortening [mm]",
        symbols: "u1 at the impact, u2 at the top, both downwards (Figure 6)",
        per_si: 1e3,
        curves: &[
            ("at the impact", colour::IMPACT_POINT),
            ("at the top", colour::TOP),
        ],
        names: Corner2D::RightBottom,
        last_width: 2.0,
        values: |it| vec![it.u1, it.u2],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/normal_force",
        title: "Axial forces [kN]",
        symbols: "N_a below and N_b above the impact, tension positive (Figure 7)",
        per_si: 1e-3,
        curves: &[
            ("below the impact", colour::BAR_A),
            ("above the impact", colour::BAR_B),
        ],
        names: Corner2D::RightTop,
        last_width: 1.5,
        values: |it| it.normal_forces().to_vec(),
        of_vehicle: false,
    },
    Plot {
        entity: "plots/bending_moment",
        title: "Moments [kN m]",
        symbols: "M of the hinges: 1a below, 1b above the impact, 2 top, 3 base (Figure 8)",
        per_si: 1e-3,
        curves: &[
            ("hinge 1a", colour::HINGE[0]),
            ("hinge 1b", colour::HINGE[1]),
            ("hinge 2", colour::HINGE[2]),
            ("hinge 3", colour::HINGE[3]),
        ],
        names: Corner2D::LeftBottom,
        last_width: 1.5,
        values: |it| it.hinges.map(|hinge| hinge.moment).to_vec(),
        of_vehicle: false,
    },
    Plot {
        entity: "plots/contact_force/smooth",
        title: "Contact force [kN]",
        symbols: "of the vehicle on the column; with several masses, the forces of the springs behind it, too",
        per_si: 1e-3,
        curves: &[("contact force", colour::CONTACT)],
        names: Corner2D::RightTop,
        last_width: 2.0,
        values: |it| vec![it.contact_force],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/energy",
        title: "Energy [kJ]",
        symbols: "stacked: the topmost line stays level as long as the balance closes",
        per_si: 1e-3,
        curves: &[
            ("impact impulses", colour::ENERGIES[0]),
            ("+ vehicle's crush", colour::ENERGIES[1]),
            ("+ damping", colour::ENERGIES[2]),
            ("+ plastic work", colour::ENERGIES[3]),
            ("+ elastic - load", colour::ENERGIES[4]),
            ("+ motion = total", colour::ENERGIES[5]),
        ],
        names: Corner2D::LeftBottom,
        last_width: 3.0,
        values: |it| ledger(it).to_vec(),
        of_vehicle: false,
    },
    Plot {
        entity: "plots/crush",
        title: "Crush of the vehicle [mm]",
        symbols: "of each spring, front first",
        per_si: 1e3,
        curves: &[
            ("spring 1, front", colour::SPRING[0]),
            ("spring 2", colour::SPRING[1]),
            ("spring 3", colour::SPRING[2]),
        ],
        names: Corner2D::RightBottom,
        last_width: 1.5,
        // An open spring is not crushed.
        values: |it| {
            let crush = it.vehicle.crush.iter().take(it.vehicle.masses);
            crush.map(|it| it.max(0.0)).collect()
        },
        of_vehicle: true,
    },
];

/// The energy ledger as a stack \[J\]: each value is a cumulative sum, and the last one stays constant as long as the ledger
/// closes. The potential energy of the load is counted with the elastic energy of the column, the elastic energy of the
/// vehicle's springs with what they dissipate.
#[must_use]
pub fn ledger(sample: &Sample) -> [f64; 6] {
    let mut sum = 0.0;
    let vehicle = &sample.vehicle;
    [
        sample.impact_loss,
        vehicle.dissipated.iter().sum::<f64>() + vehicle.elastic_energy,
        sample.damping_work,
        sample.plastic_work,
        sample.elastic_energy - sample.load_work,
        sample.kinetic_energy,
    ]
    .map(|entry| {
        sum += entry;
        sum
    })
}

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
            let values = (plot.values)(sample);
            for value in values.iter().filter(|it| it.is_finite()) {
                reached[0] = reached[0].min(plot.per_si * value);
                reached[1] = reached[1].max(plot.per_si * value);
            }
        }
        for force in spring_forces(sample).iter().filter(|it| it.is_finite()) {
            let [_, largest] = &mut self.reached[CONTACT_FORCE];
            *largest = largest.max(ALL[CONTACT_FORCE].per_si * force);
        }
    }

    /// Extends the ranges to the values of a report.
    pub fn include_report(&mut self, report: &ImpactReport) {
        let mut include = |plot: usize, value: f64| {
            if value.is_finite() {
                let value = ALL[plot].per_si * value;
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
        let supplied = ledger(&samples[0])[5];
        assert!((supplied - 75e3).abs() < 5e3, "{supplied}");
        for sample in &samples {
            let stack = ledger(sample);
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
            let names = plot.curves.iter().map(|(name, _)| *name);
            for text in names.chain([plot.title]) {
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
            assert_eq!(plot.curves.len(), (plot.values)(&sample).len());
            let without = (plot.values)(&Sample::default());
            assert_eq!(without.is_empty(), plot.of_vehicle, "{}", plot.title);
            assert!(plot.title.contains('['), "{}", plot.title);
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
