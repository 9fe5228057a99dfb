//! The visible scene of the column at one instant, as plain numbers without any type of Rerun.
//!
//! [`Drawing::force_per_metre`] scales the arrows of the contact force and the load; a hinge's moment is an arc whose angle
//! is [`FULL_ARC`] at `M^p`.

use std::f64::consts::PI;

use super::colour::{self, Rgb};
use crate::column::{HINGE_NAMES, HINGES, HingeState, Model, Phase, Sample, State};
use crate::parameters::{Parameters, SupportKind};
use crate::shape::{
    BentAxis, Joints, Lengths, Outline, PlanePoint, Solid, drawn_section, round_number,
};

/// A point or a vector in space \[m\].
pub type Point3 = [f32; 3];

/// Angle of a moment's arc at the plastic moment \[rad\].
pub const FULL_ARC: f64 = 1.5 * PI;

/// Number of pieces of an arc.
const ARC_PIECES: usize = 24;

/// Length, width and height of the vehicle's box \[m\].
pub const VEHICLE: [f64; 3] = [1.6, 1.4, 0.7];

/// Distance of hinges 1a and 1b from the impact point along their bars, as a fraction of the depth of the section.
const HINGE_OFFSET: f64 = 0.5;

/// Turns of the top spring.
const SPRING_TURNS: usize = 6;

/// Distance of the top spring from the axis of the column \[m\].
const SPRING_OFFSET: f64 = 0.32;

/// What does not change while one column is drawn.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Lengths of the bars.
    pub lengths: Lengths,
    /// The section.
    pub outline: Outline,
    /// Name of the section.
    pub section: String,
    /// Support of the base.
    pub base: SupportKind,
    /// Support of the top.
    pub top: SupportKind,
    /// `M^p` \[N m\].
    pub resistance_moment: f64,
    /// `N^p` \[N\].
    pub resistance_axial: f64,
    /// `P` \[N\].
    pub load: f64,
    /// `k_s` \[N/m\].
    pub spring_stiffness: f64,
    /// Force that corresponds to an arrow of 1 m \[N\].
    pub force_per_metre: f64,
    /// Magnification of the displacements.
    pub magnification: f64,
    /// The undamaged column at rest.
    pub at_rest: Sample,
    /// `m_1`: mass at the impact point \[kg\].
    pub struck_mass: f64,
}

/// An arrow with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceArrow {
    /// Tail.
    pub origin: Point3,
    /// From the tail to the head.
    pub vector: Point3,
    /// Value with its unit.
    pub label: String,
}

/// A hinge.
#[derive(Debug, Clone, PartialEq)]
pub struct HingeMark {
    /// Position.
    pub place: Point3,
    /// Colour of its state.
    pub colour: Rgb,
    /// Position of the label.
    pub label_place: Point3,
    /// Utilisation, state and moment.
    pub label: String,
    /// The moment as an arc, from its tail to its head.
    pub arc: Vec<Point3>,
}

/// The vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleMark {
    /// Centre of its box.
    pub centre: Point3,
    /// Mass and speed.
    pub label: String,
    /// Position of the label.
    pub label_place: Point3,
}

/// The column at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The deformed column.
    pub solid: Solid,
    /// Colour of each corner of the solid, by utilisation.
    pub colours: Vec<Rgb>,
    /// The hinges 1a, 1b, 2, 3.
    pub hinges: [HingeMark; HINGES],
    /// Position of the top of the column.
    pub top: Point3,
    /// The top spring, relative to the top of the column; empty if there is none.
    pub spring: Vec<Point3>,
    /// The vehicle, if there is one.
    pub vehicle: Option<VehicleMark>,
    /// The contact force on the column, if there is one.
    pub contact: Option<ForceArrow>,
}

impl Drawing {
    /// The drawing of a column with these parameters.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let settings = parameters.settings();
        let lengths = Lengths::from(parameters);
        let resistance_axial = parameters.resistance_axial();
        let section = parameters.section();
        let (at_rest, struck_mass) = at_rest(parameters);
        Self {
            lengths,
            outline: Outline::new(&drawn_section(parameters)),
            section: section.name.map_or_else(
                || "Section given by numbers".to_owned(),
                |name| name.to_owned(),
            ),
            base: settings.support.base,
            top: settings.support.top,
            resistance_moment: parameters.resistance_moment(),
            resistance_axial,
            load: settings.top.load,
            spring_stiffness: settings.top.spring_stiffness,
            force_per_metre: round_number(resistance_axial / lengths.total()),
            magnification: settings.viewer.magnification,
            at_rest,
            struck_mass,
        }
    }

    /// Half the depth of the section \[m\].
    #[must_use]
    pub fn half_depth(&self) -> f64 {
        0.5 * self.outline.section().depth
    }

    /// The axis of the deformed column.
    #[must_use]
    pub fn axis(&self, sample: &Sample) -> (Joints, BentAxis) {
        let joints = Joints::new(self.lengths, sample, self.magnification);
        let fixed = |support| support != SupportKind::Pinned;
        let rotation = self.magnification * sample.beta1;
        let axis = BentAxis::new(&joints, rotation, fixed(self.base), fixed(self.top));
        (joints, axis)
    }

    /// The scene at one instant; `mass` is that of the vehicle \[kg\], if it is known.
    #[must_use]
    pub fn scene(&self, sample: &Sample, mass: Option<f64>) -> Scene {
        let (joints, axis) = self.axis(sample);
        let mut solid = Solid::default();
        solid.move_to(&self.outline, &axis);
        Scene {
            colours: self.colours(sample, solid.positions.len()),
            solid,
            hinges: self.hinges(sample, &joints),
            top: in_space(joints.top, 0.0),
            spring: self.spring(joints.top.z),
            vehicle: self.vehicle(sample, &joints, mass),
            contact: self.contact(sample, &joints),
        }
    }

    /// Each bend has the colour of its hinge's utilisation, which fades along the bend; the rest is steel.
    fn colours(&self, sample: &Sample, corners: usize) -> Vec<Rgb> {
        let last = BentAxis::STATIONS - 1;
        let bend = (last - 2) / 4;
        let [below, above, top, base] = sample.hinges.map(|hinge| hinge.utilisation);
        let per_station = Solid::corners_per_station(&self.outline);
        let mut colours = Vec::with_capacity(corners);
        for station in 0..=last {
            let (utilisation, distance) = if station <= bend {
                (base, station)
            } else if station <= last / 2 {
                (below, last / 2 - station)
            } else if station < last - bend {
                (above, station - last / 2)
            } else {
                (top, last - station)
            };
            let fading = 1.0 - distance as f64 / bend as f64;
            let full = colour::of_utilisation(utilisation);
            let colour = colour::mix(colour::STEEL, full, fading);
            colours.extend(std::iter::repeat_n(colour, per_station));
        }
        colours.resize(corners, colour::STEEL);
        colours
    }

    fn hinges(&self, sample: &Sample, joints: &Joints) -> [HingeMark; HINGES] {
        let apart = 2.0 * HINGE_OFFSET * self.half_depth();
        let places = joints.hinges(apart);
        // Labels are beside the column and clear of the arcs; those of the impact point are below and above it.
        let shift = 0.075 * self.lengths.total();
        let label_shifts = [-0.5 * shift, 1.5 * shift, -0.5 * shift, 0.5 * shift];
        std::array::from_fn(|index| {
            let hinge = &sample.hinges[index];
            let place = places[index];
            let radius = self.arc_radius() * if index == 1 { 1.25 } else { 1.0 };
            let beside = place.plus(
                1.0,
                PlanePoint::new(0.29 * self.lengths.total(), label_shifts[index]),
            );
            HingeMark {
                place: in_space(place, self.front()),
                colour: colour::of_state(hinge.state),
                label_place: in_space(beside, self.front()),
                label: format!(
                    "{}: {} %{}, {}",
                    HINGE_NAMES[index],
                    percent(hinge.utilisation),
                    match hinge.state {
                        HingeState::Elastic => "",
                        HingeState::Plastic => " plastic",
                        HingeState::Unloaded => " unloaded",
                    },
                    moment(hinge.moment),
                ),
                arc: self.arc(place, radius, hinge.moment),
            }
        })
    }

    /// Radius of a moment's arc \[m\].
    #[must_use]
    pub fn arc_radius(&self) -> f64 {
        (0.06 * self.lengths.total()).max(1.5 * self.half_depth())
    }

    /// `y` of what the column must not hide: in front of it \[m\].
    fn front(&self) -> f64 {
        -0.5 * self.outline.section().width - 0.02
    }

    /// The arc is on the side opposite to the vehicle.
    fn arc(&self, centre: PlanePoint, radius: f64, moment: f64) -> Vec<Point3> {
        let part = moment / self.resistance_moment;
        let angle = FULL_ARC
            * if part.is_finite() {
                part.clamp(-1.1, 1.1)
            } else {
                0.0
            };
        (0..=ARC_PIECES)
            .map(|piece| {
                let at = angle * (piece as f64 / ARC_PIECES as f64 - 0.5);
                let along = PlanePoint::new(at.cos(), at.sin());
                in_space(centre.plus(radius, along), self.front())
            })
            .collect()
    }

    /// A zigzag from the top of the column to the support of the spring.
    fn spring(&self, top: f64) -> Vec<Point3> {
        if self.spring_stiffness <= 0.0 {
            return Vec::new();
        }
        let foot = PlanePoint::new(SPRING_OFFSET, 0.0);
        let length = self.spring_end() - top;
        let points = 2 * SPRING_TURNS + 2;
        let mut spring = vec![in_space(foot, 0.0)];
        spring.extend((1..points).map(|point| {
            let aside = match point {
                _ if point == 1 || point == points - 1 => 0.0,
                _ if point % 2 == 0 => 0.09,
                _ => -0.09,
            };
            let up = length * point as f64 / points as f64;
            in_space(foot.plus(1.0, PlanePoint::new(aside, up)), 0.0)
        }));
        spring.push(in_space(PlanePoint::new(SPRING_OFFSET, length), 0.0));
        spring
    }

    /// Height of the support of the top spring \[m\].
    #[must_use]
    pub fn spring_end(&self) -> f64 {
        1.15 * self.lengths.total()
    }

    /// Distance of the top spring from the axis of the column \[m\].
    #[must_use]
    pub const fn spring_offset() -> f64 {
        SPRING_OFFSET
    }

    fn vehicle(&self, sample: &Sample, joints: &Joints, mass: Option<f64>) -> Option<VehicleMark> {
        if sample.phase == Phase::Idle {
            return None;
        }
        let front = joints.impactor_front(sample, self.half_depth());
        let centre = PlanePoint::new(front - 0.5 * VEHICLE[0], self.lengths.below);
        let speed = sample.impactor_velocity;
        let mass = mass.map_or_else(String::new, |mass| format!("{mass:.0} kg, "));
        Some(VehicleMark {
            centre: in_space(centre, 0.0),
            label: format!("{mass}{speed:.2} m/s"),
            label_place: in_space(
                centre.plus(1.0, PlanePoint::new(0.0, -0.5 * VEHICLE[2])),
                0.0,
            ),
        })
    }

    /// The head is at the face of the column; the length is proportional to the force.
    fn contact(&self, sample: &Sample, joints: &Joints) -> Option<ForceArrow> {
        if sample.contact_force <= 0.0 {
            return None;
        }
        let length = sample.contact_force / self.force_per_metre;
        let face = joints.impact.x - self.half_depth();
        Some(ForceArrow {
            origin: in_space(PlanePoint::new(face - length, joints.impact.z), 0.0),
            vector: [length as f32, 0.0, 0.0],
            label: force(sample.contact_force),
        })
    }

    /// The load on the top, relative to the top.
    #[must_use]
    pub fn load_arrow(&self) -> Option<ForceArrow> {
        if self.load <= 0.0 {
            return None;
        }
        let length = self.load / self.force_per_metre;
        Some(ForceArrow {
            origin: [0.0, 0.0, length as f32],
            vector: [0.0, 0.0, -length as f32],
            label: format!("P = {}", force(self.load)),
        })
    }
}

/// A point of the plane of bending, shifted to `y` \[m\].
#[must_use]
pub fn in_space(point: PlanePoint, y: f64) -> Point3 {
    [point.x as f32, y as f32, point.z as f32]
}

/// A force with its unit, for labels.
#[must_use]
pub fn force(newtons: f64) -> String {
    format!("{:.0} kN", 1e-3 * newtons)
}

/// A moment with its unit, for labels.
#[must_use]
pub fn moment(newton_metres: f64) -> String {
    format!("M {:.0} kN m", 1e-3 * newton_metres)
}

fn percent(part: f64) -> String {
    format!("{:.0}", 100.0 * part)
}

/// The undamaged column at rest under its load, and its mass at the impact point; undeformed if the column is unstable.
fn at_rest(parameters: &Parameters) -> (Sample, f64) {
    let Ok(model) = Model::new(&parameters.column_properties()) else {
        return (Sample::default(), 0.0);
    };
    let sample = State::at_rest(&model).sample(&model);
    (sample, model.impact_point_mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::HingeSample;

    fn hit() -> Sample {
        let mut sample = Sample {
            phase: Phase::Contact,
            v1: 0.0946,
            u1: 0.0047,
            u2: 0.0098,
            beta1: 0.03,
            impactor_position: 0.0946,
            impactor_velocity: 0.5,
            contact_force: 7.5e5,
            ..Sample::default()
        };
        sample.hinges[3] = HingeSample {
            moment: -1.5e5,
            utilisation: 1.0,
            state: HingeState::Plastic,
            ..HingeSample::default()
        };
        sample
    }

    fn length(path: &[Point3]) -> f64 {
        path.windows(2)
            .map(|pair| {
                let square: f32 = (0..3)
                    .map(|axis| (pair[1][axis] - pair[0][axis]).powi(2))
                    .sum();
                f64::from(square.sqrt())
            })
            .sum()
    }

    /// The length and head of an arrow and the length of an arc follow from the state.
    #[test]
    fn arrows_are_as_long_as_their_forces() {
        let drawing = Drawing::new(&Parameters::default());
        assert_eq!(drawing.force_per_metre, 1e6);
        let scene = drawing.scene(&hit(), Some(1500.0));
        let arrow = scene.contact.expect("a contact force");
        assert_eq!(arrow.vector, [0.75, 0.0, 0.0]);
        assert!((arrow.origin[0] + 0.75 - (0.0946 - 0.11)).abs() < 1e-6);
        assert!((arrow.origin[2] - (1.0 - 0.0047)).abs() < 1e-6);
        assert_eq!(arrow.label, "750 kN");
        let arc = length(&scene.hinges[3].arc);
        let angle = FULL_ARC * 1.5e5 / drawing.resistance_moment;
        assert!((arc / (drawing.arc_radius() * angle) - 1.0).abs() < 1e-3);
        // A moment of the opposite sign turns the arc round.
        assert!(scene.hinges[3].arc[0][2] > scene.hinges[3].arc[ARC_PIECES][2]);
        assert_eq!(length(&scene.hinges[2].arc), 0.0);
        let load = drawing.load_arrow().expect("a load");
        let expected = Parameters::default().settings().top.load / 1e6;
        assert!((f64::from(load.vector[2]) + expected).abs() < 1e-6);
    }

    #[test]
    fn hinges_have_the_position_and_the_colour_of_their_state() {
        let drawing = Drawing::new(&Parameters::default());
        let scene = drawing.scene(&hit(), None);
        let [below, above, top, base] = &scene.hinges;
        let near = |mark: &HingeMark, x: f32, z: f32| {
            (mark.place[0] - x).abs() < 1e-6 && (mark.place[2] - z).abs() < 1e-6
        };
        assert!(near(base, 0.0, 0.0));
        assert!(near(top, 0.0, 4.0 - 0.0098));
        // They are half a depth from the impact point along their bars.
        for (mark, end) in [(below, base), (above, top)] {
            let impact = [0.0946, 1.0 - 0.0047];
            let (x, z) = (end.place[0] - impact[0], end.place[2] - impact[1]);
            let part = 0.11 / x.hypot(z);
            assert!(near(mark, impact[0] + part * x, impact[1] + part * z));
        }
        assert_eq!(
            (base.colour, top.colour),
            (colour::PLASTIC, colour::ELASTIC)
        );
        assert_eq!(base.label, "3: 100 % plastic, M -150 kN m");
        assert_eq!(
            scene.vehicle.map(|it| it.label).as_deref(),
            Some("0.50 m/s")
        );
    }

    #[test]
    fn the_steel_has_the_colour_of_its_hinge_at_the_hinge_only() {
        let drawing = Drawing::new(&Parameters::default());
        let scene = drawing.scene(&hit(), None);
        assert_eq!(scene.colours.len(), scene.solid.positions.len());
        let per_station = Solid::corners_per_station(&drawing.outline);
        let at = |station: usize| scene.colours[station * per_station];
        assert_eq!(at(0), colour::of_utilisation(1.0));
        for steel in [4, 5, 9, 13, 14, 18] {
            assert_eq!(at(steel), colour::STEEL, "{steel}");
        }
    }

    #[test]
    fn a_magnified_deformation_keeps_the_vehicle_at_the_column() {
        let mut drawing = Drawing::new(&Parameters::default());
        drawing.magnification = 5.0;
        let scene = drawing.scene(&hit(), None);
        let vehicle = scene.vehicle.expect("there");
        let front = f64::from(vehicle.centre[0]) + 0.5 * VEHICLE[0];
        assert!((front - (5.0 * 0.0946 - 0.11)).abs() < 1e-6);
    }

    #[test]
    fn the_column_at_rest_carries_its_load() {
        let at_rest = Drawing::new(&Parameters::default()).at_rest;
        assert!(at_rest.u2 > at_rest.u1 && at_rest.u1 > 0.0);
        assert!(at_rest.hinges[2].normal_force < 0.0 && at_rest.hinges[2].utilisation > 0.0);
        assert_eq!(at_rest.phase, Phase::Idle);
    }
}
