//! The curves over time: their quantities, units and the ranges of their axes.

use rerun::blueprint::components::Corner2D;

use super::colour::{self, Rgb};
use super::timeline::nanos;
use crate::column::{HINGES, Impact, MAX_MASSES, Sample, simulate};
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
    /// Title, with the unit.
    pub title: &'static str,
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

/// Entity of the impact impulses, which are marked in the plot of the contact force.
pub const IMPACT_IMPULSES: &str = "plots/contact_force/impact_impulses";

/// Index of the plot of the contact force.
pub const CONTACT_FORCE: usize = 4;

/// Index of the plot of the crush.
const CRUSH: usize = 6;

/// The paper's Figures 5 to 8, the contact force and the energy ledger.
pub const ALL: [Plot; PLOTS] = [
    Plot {
        entity: "plots/horizontal_displacement",
        title: "Fig. 5: v1, v_c [mm]",
        per_si: 1e3,
        curves: &[
            ("v_c impactor", colour::IMPACTOR),
            ("v1 impact point", colour::IMPACT_POINT),
        ],
        names: Corner2D::RightBottom,
        last_width: 2.0,
        values: |it| vec![it.impactor_position, it.v1],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/vertical_displacement",
        title: "Fig. 6: u1, u2, down [mm]",
        per_si: 1e3,
        curves: &[
            ("u1 impact point", colour::IMPACT_POINT),
            ("u2 top", colour::TOP),
        ],
        names: Corner2D::RightBottom,
        last_width: 2.0,
        values: |it| vec![it.u1, it.u2],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/normal_force",
        title: "Fig. 7: N, tension + [kN]",
        per_si: 1e-3,
        curves: &[("N_a below", colour::BAR_A), ("N_b above", colour::BAR_B)],
        names: Corner2D::RightTop,
        last_width: 1.5,
        values: |it| vec![it.hinges[0].normal_force, it.hinges[1].normal_force],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/bending_moment",
        title: "Fig. 8: M [kN m]",
        per_si: 1e-3,
        curves: &[
            ("1a", colour::HINGE[0]),
            ("1b", colour::HINGE[1]),
            ("2", colour::HINGE[2]),
            ("3", colour::HINGE[3]),
        ],
        names: Corner2D::LeftBottom,
        last_width: 1.5,
        values: |it| it.hinges.map(|hinge| hinge.moment).to_vec(),
        of_vehicle: false,
    },
    Plot {
        entity: "plots/contact_force/smooth",
        title: "Contact and spring forces [kN]",
        per_si: 1e-3,
        curves: &[("contact force", colour::CONTACT)],
        names: Corner2D::RightTop,
        last_width: 2.0,
        values: |it| vec![it.contact_force],
        of_vehicle: false,
    },
    Plot {
        entity: "plots/energy",
        title: "Energy, stacked [kJ]",
        per_si: 1e-3,
        curves: &[
            ("impact impulses", colour::ENERGIES[0]),
            ("+ vehicle's crush", colour::ENERGIES[1]),
            ("+ damping", colour::ENERGIES[2]),
            ("+ plastic", colour::ENERGIES[3]),
            ("+ elastic - load", colour::ENERGIES[4]),
            ("+ kinetic = level", colour::ENERGIES[5]),
        ],
        names: Corner2D::LeftBottom,
        last_width: 3.0,
        values: |it| ledger(it).to_vec(),
        of_vehicle: false,
    },
    Plot {
        entity: "plots/crush",
        title: "Crush of the vehicle [mm]",
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
            // The column sets the range of the displacements: the impactor travels without limit.
            let first = usize::from(plot.entity == ALL[0].entity);
            for value in values.iter().skip(first).filter(|it| it.is_finite()) {
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
        include(0, report.max_v1);
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
