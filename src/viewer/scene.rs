//! The visible scene of the column at one instant, as plain numbers without any type of Rerun.
//!
//! [`Drawing::force_per_metre`] scales the arrows of the contact force and the load; a hinge's moment is an arc whose angle
//! is [`FULL_ARC`] at `M^p`.

use std::f64::consts::PI;

use super::camera::{Camera, Outlook};
use super::colour::{self, Rgb};
use super::labels::{self, Label, moved_apart};
use super::point::Point3;
use crate::column::{HINGES, HingeState, MAX_MASSES, Model, Sample, State, Vehicle};
use crate::observables::{HINGE_PLACES, Place, hinges_upwards};
use crate::parameters::{Parameters, SupportKind};
use crate::shape::{
    BentAxis, Heading, Hull, Joints, Lengths, Outline, PlanePoint, Solid, VehicleBody, round_number,
};

/// Angle of a moment's arc at the plastic moment \[rad\].
pub const FULL_ARC: f64 = 1.5 * PI;

/// Number of pieces of an arc.
const ARC_PIECES: usize = 24;

/// What a vehicle without springs is called.
const RIGID_MASS: &str = "rigid mass";

/// Largest length of a vehicle that is in the picture as a whole \[m\]; the rear of a longer one is outside.
pub(super) const SHOWN_LENGTH: f64 = 9.0;

/// Distance of the vehicle from the column at which it is in the picture as a whole \[m\].
const SHOWN_GAP: f64 = 0.5;

/// Number of characters of the longest label of a hinge, for which all of them are placed.
const HINGE_LABEL: usize = 31;

/// Number of lines of the longest label of a vehicle that travels in the direction 0; in another direction it has one more.
const VEHICLE_LINES: usize = 4;

/// Free space between a label and what it belongs to \[m\].
pub(super) const LABEL_GAP: f64 = 0.06;

/// Half the width of a wheel \[m\].
pub const HALF_WHEEL: f64 = 0.12;

/// Distance of hinges 1a and 1b from the impact point along their bars, as a fraction of the depth of the section.
const HINGE_OFFSET: f64 = 0.5;

/// Radius of the arc of a hinge that surrounds that of another one at the same joint, relative to the radius of the others.
const OUTER_ARC: f64 = 1.25;

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
    /// The body of the vehicle that hits the column.
    pub vehicle: VehicleBody,
    /// The name of the vehicle.
    pub vehicle_name: String,
    /// The direction in which it travels.
    pub heading: Heading,
    /// Masses and springs of the vehicle; `None` if it is rigid, or if they are not known.
    pub springs: Option<Vehicle>,
}

/// An arrow with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceArrow {
    /// Tail.
    pub origin: Point3,
    /// From the tail to the head.
    pub vector: Point3,
    /// Value with its unit.
    pub label: Label,
}

/// A hinge.
#[derive(Debug, Clone, PartialEq)]
pub struct HingeMark {
    /// Position.
    pub place: Point3,
    /// Colour of its state.
    pub colour: Rgb,
    /// Utilisation, state and moment.
    pub label: Label,
    /// The moment as an arc, from its tail to its head.
    pub arc: Vec<Point3>,
}

/// A box of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxMark {
    /// Its centre.
    pub centre: Point3,
    /// Half its length, width and height.
    pub half_size: Point3,
    /// Its colour.
    pub colour: Rgb,
}

/// The vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleMark {
    /// The surface of its hull.
    pub hull: Hull,
    /// Colour of each corner of the hull.
    pub colours: Vec<Rgb>,
    /// The outline of its hull on both sides, and what connects them.
    pub edges: Vec<Vec<Point3>>,
    /// Engine, cargo and road.
    pub boxes: Vec<BoxMark>,
    /// Centres of the wheels.
    pub wheels: Vec<Point3>,
    /// Radius of each wheel.
    pub wheel_radii: Vec<f32>,
    /// Name, mass, speed, direction and crush.
    pub label: Label,
    /// The direction \[rad\] into which its boxes and wheels are turned about their centres.
    pub direction: f64,
}

/// The column at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The deformed column.
    pub solid: Solid,
    /// Colour of each corner of the solid, by utilisation.
    pub colours: Vec<Rgb>,
    /// The hinges, in the order of [`HINGE_PLACES`].
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
        let vehicle = parameters.impact().vehicle;
        let mut drawing = Self {
            lengths,
            outline: Outline::of(parameters),
            section: section
                .name
                .map_or_else(|| "User-defined section".to_owned(), |name| name.to_owned()),
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
            heading: Heading::new(parameters.direction()),
            springs: None,
            vehicle_name: RIGID_MASS.to_owned(),
            vehicle: VehicleBody::rigid_mass(),
        };
        let masses = vehicle.map_or(0, |it| it.masses().len());
        let mass = parameters.impact().mass;
        drawing.change_vehicle(parameters, "", Some(mass), masses);
        drawing
    }

    /// Draws the vehicle of this name from here on, which has this total mass \[kg\], if it is known, and this number of masses;
    /// an empty name is that of the parameters. Whether it is another one than before.
    pub fn change_vehicle(
        &mut self,
        parameters: &Parameters,
        name: &str,
        mass: Option<f64>,
        masses: usize,
    ) -> bool {
        let name = match name {
            "" => &parameters.settings().vehicle.name,
            name => name,
        };
        // A name and a number of masses that do not belong together are of a vehicle that is not known.
        let known = parameters.vehicle_named(name).ok().flatten();
        let known = known.filter(|it| it.masses().len() == masses);
        let springs = known.map(|it| {
            let loaded = mass.and_then(|mass| it.with_total_mass(mass).ok());
            loaded.unwrap_or(it)
        });
        let slack: Vec<_> = match &springs {
            Some(it) => it.springs().iter().map(|spring| spring.slack).collect(),
            None => vec![0.0; masses.min(MAX_MASSES)],
        };
        let total = mass.or(springs.map(|it| it.total_mass())).unwrap_or(0.0);
        let body = VehicleBody::named(name, total, &slack);
        let name = match (masses, springs, name) {
            (0, ..) => RIGID_MASS,
            (_, None, _) | (.., "") => "vehicle",
            (.., name) => name,
        };
        let changed = body != self.vehicle || name != self.vehicle_name || springs != self.springs;
        self.vehicle = body;
        self.vehicle_name = name.to_owned();
        self.springs = springs;
        changed
    }

    /// Lets the vehicle travel in this direction \[rad\] from here on; whether it is another one than before.
    pub fn travel(&mut self, direction: f64) -> bool {
        let heading = Heading::new(direction);
        let changed = heading != self.heading;
        self.heading = heading;
        changed
    }

    /// The sides of the picture.
    pub(super) fn outlook(&self) -> Outlook {
        Outlook::of(self.heading)
    }

    /// The camera that has the column, the vehicle and the labels in the picture.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let outlook = self.outlook();
        let height = self.lengths.total();
        let road = self.vehicle.road(self.lengths.below);
        let load = self.load.max(0.0) / self.force_per_metre;
        let top = (self.spring_end() + 0.15).max(height + load.min(height) + LABEL_GAP);
        // The rectangle that the vehicle covers, from its rear when it is half a metre away to its front at the column.
        let [along, lean] = outlook.travel();
        let rear = self.reach() + SHOWN_GAP + self.vehicle.length().min(SHOWN_LENGTH);
        let half = 0.5 * self.vehicle.width();
        let left = -(along * rear + half * lean.abs());
        let right_of_front = half * lean.abs() - along * self.reach();
        let near = half * along + rear * lean.max(0.0);
        let beside = self.beside_hinges();
        let bottom = road.min(-0.25) - LABEL_GAP;
        let lines = VEHICLE_LINES + usize::from(self.heading.direction() != 0.0);
        let [label, line] = [labels::width(HINGE_LABEL), labels::height(lines)];
        let mut camera = Camera::around([left, beside.max(right_of_front)], [bottom, top], near);
        // The labels keep their size on the screen: the farther away the camera is, the more metres they take.
        for _ in 0..8 {
            let size = camera.metres_per_point();
            let right = (beside + size * label).max(right_of_front);
            camera = Camera::around([left, right], [bottom - size * line, top], near);
        }
        camera.turned(outlook)
    }

    /// Half the depth of the section \[m\].
    #[must_use]
    pub fn half_depth(&self) -> f64 {
        0.5 * self.outline.depth()
    }

    /// The axis of the deformed column.
    #[must_use]
    pub fn axis(&self, sample: &Sample) -> (Joints, BentAxis) {
        let joints = Joints::new(self.lengths, sample, self.magnification);
        let fixed = |support| !matches!(support, SupportKind::Pinned | SupportKind::Free);
        let rotation = self.magnification * sample.beta1;
        let shear = sample
            .webs
            .map(|web| self.magnification * web.plastic_angle);
        let axis = BentAxis::new(&joints, rotation, shear, fixed(self.base), fixed(self.top));
        (joints, axis)
    }

    /// The scene at one instant; `mass` is that of the vehicle \[kg\], if it is known.
    #[must_use]
    pub fn scene(&self, sample: &Sample, mass: Option<f64>) -> Scene {
        let (joints, axis) = self.axis(sample);
        let mut solid = Solid::default();
        solid.move_to(&self.outline, &axis);
        if self.heading.of_bars() < 0.0 {
            // Half a turn, which the section does not show, bends the bars to the other side.
            let corners = solid.positions.iter_mut().chain(&mut solid.normals);
            corners.for_each(|[x, y, _]| [*x, *y] = [-*x, -*y]);
        }
        let point = self.camera().metres_per_point();
        Scene {
            colours: self.colours(sample, solid.positions.len()),
            solid,
            hinges: self.hinges(sample, &joints, point),
            top: self.outlook().in_space(joints.top, 0.0),
            spring: self.spring(joints.top.z),
            vehicle: self.vehicle_mark(sample, &joints, mass, point),
            contact: self.contact(sample, &joints, point),
        }
    }

    /// Each bend has the colour of its hinge's utilisation, which fades along the bend; the rest is steel.
    fn colours(&self, sample: &Sample, corners: usize) -> Vec<Rgb> {
        let last = BentAxis::STATIONS - 1;
        let bend = (last - 2) / 4;
        let upwards = hinges_upwards().map(|hinge| sample.hinges[hinge].utilisation);
        let per_station = Solid::corners_per_station(&self.outline);
        let mut colours = Vec::with_capacity(corners);
        for station in 0..=last {
            let (hinge, distance) = if station <= bend {
                (0, station)
            } else if station <= last / 2 {
                (1, last / 2 - station)
            } else if station < last - bend {
                (2, station - last / 2)
            } else {
                (3, last - station)
            };
            let fading = 1.0 - distance as f64 / bend as f64;
            let full = colour::of_utilisation(upwards[hinge]);
            let colour = colour::mix(colour::STEEL, full, fading);
            colours.extend(std::iter::repeat_n(colour, per_station));
        }
        colours.resize(corners, colour::STEEL);
        colours
    }

    /// Horizontal distance of the labels of the hinges from their hinges, clear of the arcs \[m\].
    pub(super) fn beside_hinges(&self) -> f64 {
        OUTER_ARC * self.arc_radius() + LABEL_GAP
    }

    /// The hinges, with labels in a column beside them; a point of the screen has the size `point` \[m\].
    fn hinges(&self, sample: &Sample, joints: &Joints, point: f64) -> [HingeMark; HINGES] {
        let apart = 2.0 * HINGE_OFFSET * self.half_depth();
        let places = joints.hinges(apart);
        let beside = self.beside_hinges() + 0.5 * point * labels::width(HINGE_LABEL);
        let height = point * labels::height(1);
        // The label of the top is below its guides.
        let upwards = hinges_upwards();
        let wanted = upwards.map(|index| {
            let below = match HINGE_PLACES[index].joint() {
                2 => 0.1 * self.lengths.total(),
                _ => 0.0,
            };
            (places[index].z + 0.5 * height - below, height)
        });
        let upper_ends = moved_apart(&wanted);
        std::array::from_fn(|index| {
            let hinge = &sample.hinges[index];
            let place = places[index];
            let described = &HINGE_PLACES[index];
            let is_there = |it: &Place| it.joint() == described.joint();
            let is_around = HINGE_PLACES[..index].iter().any(is_there);
            let radius = self.arc_radius() * if is_around { OUTER_ARC } else { 1.0 };
            let row = upwards.iter().position(|it| *it == index).unwrap_or(0);
            let label_place = PlanePoint::new(place.x + beside, upper_ends[row]);
            let text = format!(
                "{}: {} %{}, {}",
                described.name,
                percent(hinge.utilisation),
                match hinge.state {
                    HingeState::Elastic => "",
                    HingeState::Plastic => " plastic",
                    HingeState::Unloaded => " unloaded",
                },
                moment(hinge.moment),
            );
            HingeMark {
                place: self.outlook().in_space(place, self.front()),
                colour: colour::of_state(hinge.state),
                label: Label {
                    place: self.outlook().in_space(label_place, self.front()),
                    text,
                },
                arc: self.arc(place, radius, hinge.moment),
            }
        })
    }

    /// Radius of a moment's arc \[m\].
    #[must_use]
    pub fn arc_radius(&self) -> f64 {
        (0.06 * self.lengths.total()).max(1.5 * self.half_depth())
    }

    /// Distance away from the viewer of what the column must not hide: in front of it \[m\].
    pub(super) fn front(&self) -> f64 {
        -0.5 * self.outline.width() - 0.02
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
                self.outlook()
                    .in_space(centre.plus(radius, along), self.front())
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

    /// The force on the two bars, in their plane. The head is at the face of the column; the length is proportional to the force. The label is above it, and below that
    /// of the load.
    fn contact(&self, sample: &Sample, joints: &Joints, point: f64) -> Option<ForceArrow> {
        if sample.contact_force <= 0.0 {
            return None;
        }
        let length = sample.contact_force / self.force_per_metre;
        let face = joints.impact.x - self.half_depth();
        let text = force(sample.contact_force);
        let [width, height] = labels::size(&text).map(|it| point * it);
        let place = PlanePoint::new(
            face.min(0.0) - LABEL_GAP - 0.5 * width,
            (joints.impact.z + LABEL_GAP + height).min(joints.top.z + LABEL_GAP),
        );
        Some(ForceArrow {
            origin: self
                .outlook()
                .in_space(PlanePoint::new(face - length, joints.impact.z), 0.0),
            vector: self.outlook().in_space(PlanePoint::new(length, 0.0), 0.0),
            label: Label {
                place: self.outlook().in_space(place, 0.0),
                text,
            },
        })
    }

    /// The load on the top, relative to the top, with its label on the side of the vehicle.
    #[must_use]
    pub fn load_arrow(&self) -> Option<ForceArrow> {
        if self.load <= 0.0 {
            return None;
        }
        let length = self.load / self.force_per_metre;
        let text = format!("P = {}", force(self.load));
        let point = self.camera().metres_per_point();
        let [width, height] = labels::size(&text).map(|it| point * it);
        let place = PlanePoint::new(-2.0 * LABEL_GAP - 0.5 * width, 2.0 * LABEL_GAP + height);
        Some(ForceArrow {
            origin: [0.0, 0.0, length as f32],
            vector: [0.0, 0.0, -length as f32],
            label: Label {
                place: self.outlook().in_space(place, 0.0),
                text,
            },
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
    use crate::column::{HingeSample, Phase};
    use crate::parameters::Value;
    use crate::viewer::VIEW;

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
        assert_eq!(arrow.label.text, "750 kN");
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
        assert_eq!(base.label.text, "3: 100 % plastic, M -150 kN m");
        assert_eq!(
            scene.vehicle.map(|it| it.label.text).as_deref(),
            Some("rigid mass (as in the paper)\n0.50 m/s")
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
        let front = vehicle.hull.positions.iter().map(|it| it[0]);
        let front = f64::from(front.fold(f32::NEG_INFINITY, f32::max));
        assert!((front - (5.0 * 0.0946 - 0.11)).abs() < 1e-6);
    }

    /// Upper left and lower right corner of a label in the picture \[points\].
    fn rectangle(drawing: &Drawing, label: &Label) -> [[f64; 2]; 2] {
        let [x, y] = drawing.camera().project(label.place);
        let [width, height] = label.size();
        [[x - 0.5 * width, y], [x + 0.5 * width, y + height]]
    }

    /// All labels of the scene of a sample.
    fn labels_of(drawing: &Drawing, sample: &Sample) -> Vec<Label> {
        let scene = drawing.scene(sample, Some(1500.0));
        let hinges = scene.hinges.into_iter().map(|it| it.label);
        let vehicle = scene.vehicle.map(|it| it.label);
        let contact = scene.contact.map(|it| it.label);
        // The load is drawn relative to the top of the column.
        let load = drawing.load_arrow().map(|it| Label {
            place: std::array::from_fn(|axis| it.label.place[axis] + scene.top[axis]),
            text: it.label.text,
        });
        hinges.chain(vehicle).chain(contact).chain(load).collect()
    }

    /// Samples with the longest labels, from the approach to a column that is bent far, and after the separation.
    fn states(masses: usize) -> Vec<Sample> {
        let mut states = Vec::new();
        for (phase, gap, v1) in [
            (Phase::Approach, 0.5, 0.0),
            (Phase::Contact, 0.0, 0.0),
            (Phase::Contact, 0.0, 0.1),
            (Phase::Contact, 0.0, 0.4),
            (Phase::Free, 0.2, 0.3),
        ] {
            let mut sample = Sample {
                phase,
                gap,
                v1,
                u1: 0.2 * v1,
                u2: 0.3 * v1,
                beta1: 0.2 * v1,
                impactor_velocity: -12.34,
                contact_force: if gap == 0.0 { 1.234e6 } else { 0.0 },
                ..Sample::default()
            };
            sample.vehicle.masses = masses;
            sample.vehicle.crush = [5.0 * v1, v1, v1];
            sample.vehicle.force = [1.2e6; 3];
            for hinge in &mut sample.hinges {
                hinge.moment = -1.5e6;
                hinge.utilisation = 1.0;
                hinge.state = HingeState::Unloaded;
            }
            states.push(sample);
        }
        states
    }

    /// Directions of travel from all sides \[degrees\].
    const DIRECTIONS: [f64; 12] = [
        0.0, 5.0, 10.0, 45.0, 90.0, 135.0, 175.0, 180.0, -10.0, -45.0, -90.0, -135.0,
    ];

    /// Each of these states in each direction.
    fn in_directions(states: &[Sample]) -> Vec<(Sample, f64)> {
        let of = |degrees: f64| states.iter().map(move |sample| (*sample, degrees));
        DIRECTIONS.into_iter().flat_map(of).collect()
    }

    /// From where the column is looked at, no part of a vehicle that travels out of the plane of bending is in front of it.
    #[test]
    fn an_oblique_vehicle_does_not_hide_the_column() {
        let mut drawing = Drawing::new(&Parameters::default());
        for (total, masses) in [(1_719.0, 1), (36_000.0, 3)] {
            drawing.vehicle = VehicleBody::assumed(total, &[0.0; 3][..masses]);
            let is_oblique = |it: &f64| it.to_radians().sin().abs() > 0.1;
            for degrees in DIRECTIONS.into_iter().filter(is_oblique) {
                drawing.travel(degrees.to_radians());
                let [eye_x, eye_y, _] = drawing.camera().eye;
                let sight = [eye_x, eye_y, 0.0];
                let back = Heading::new(-degrees.to_radians());
                let hides = (1..1000).any(|part| {
                    let place = sight.map(|it| it * f64::from(part) / 1000.0);
                    // Along the path of the vehicle, and across it.
                    let [along, across, _] = back.in_space(place);
                    along < -drawing.reach() && across.abs() < 0.5 * drawing.vehicle.width()
                });
                assert!(!hides, "{total} {degrees}");
            }
        }
    }

    /// The front of the vehicle touches the section on its path, and its boxes and wheels stand as its hull does.
    #[test]
    fn the_vehicle_comes_from_its_direction() {
        let mut drawing = Drawing::new(&Parameters::default());
        drawing.vehicle = VehicleBody::assumed(8_000.0, &[0.0, 0.0]);
        for degrees in DIRECTIONS {
            let direction = degrees.to_radians();
            drawing.travel(direction);
            let mut sample = hit();
            (sample.v1, sample.vehicle.masses) = (0.0, 2);
            let scene = drawing.scene(&sample, None);
            let vehicle = scene.vehicle.expect("there");
            let (sin, cos) = direction.sin_cos();
            let along = |[x, y, _]: [f32; 3]| f64::from(x) * cos + f64::from(y) * sin;
            let across = |[x, y, _]: [f32; 3]| f64::from(y) * cos - f64::from(x) * sin;
            let most = |of: &dyn Fn([f32; 3]) -> f64, places: &[[f32; 3]]| {
                let values = places.iter().map(|it| of(*it));
                values.fold(f64::NEG_INFINITY, f64::max)
            };
            // Nothing of the column is beyond the plane of the front, and some of it is on it.
            let front = most(&along, &vehicle.hull.positions);
            let nearest = -most(&|it| -along(it), &scene.solid.positions);
            assert!(
                (front - nearest).abs() < 1e-6,
                "{degrees}: {front} {nearest}"
            );
            let half = 0.5 * drawing.vehicle.width();
            for side in [1.0, -1.0] {
                let reached = most(&|it| side * across(it), &vehicle.hull.positions);
                assert!((reached - half).abs() < 1e-5, "{degrees}: {reached}");
                let wheels = most(&|it| side * across(it), &vehicle.wheels);
                assert!((wheels - (half - HALF_WHEEL)).abs() < 1e-5, "{degrees}");
            }
            for it in &vehicle.boxes {
                assert!(across(it.centre).abs() < 1e-5 && along(it.centre) < front);
            }
            assert_eq!(vehicle.direction, direction);
            let outwards = vehicle.hull.normals.last().expect("corners");
            assert!(
                (along(*outwards) - 1.0).abs() < 1e-6,
                "the front: {outwards:?}"
            );
        }
    }

    /// A vehicle from the other side bends the bars to the other side, as the fibre beam does.
    #[test]
    fn the_bars_bend_away_from_the_vehicle() {
        let mut drawing = Drawing::new(&Parameters::default());
        let ahead = drawing.scene(&hit(), None);
        drawing.travel(PI);
        let back = drawing.scene(&hit(), None);
        let turned = |[x, y, z]: [f32; 3]| [-x, -y, z];
        for (one, other) in ahead.solid.positions.iter().zip(&back.solid.positions) {
            assert_eq!(turned(*one), *other);
        }
        for (one, other) in ahead.hinges.iter().zip(&back.hinges) {
            assert_eq!(
                [-one.place[0], one.place[2]],
                [other.place[0], other.place[2]]
            );
        }
        let [one, other] = [ahead, back].map(|it| it.contact.expect("a contact force"));
        assert_eq!(-one.vector[0], other.vector[0]);
        assert_eq!(-one.origin[0], other.origin[0]);
    }

    /// The speed of an oblique vehicle is that of the two bars, and its label says so.
    #[test]
    fn the_label_names_the_direction() {
        let mut drawing = Drawing::new(&Parameters::default());
        let mut first_lines = |degrees: f64| {
            drawing.travel(degrees.to_radians());
            let vehicle = drawing.scene(&hit(), None).vehicle.expect("there");
            vehicle.label.text
        };
        let plain = "rigid mass (as in the paper)\n0.50 m/s";
        assert_eq!(first_lines(0.0), plain);
        assert_eq!(
            first_lines(-10.0),
            format!("{plain}\nat -10°, speed in the plane")
        );
        assert_eq!(first_lines(180.0), format!("{plain}\nat 180°"));
    }

    #[test]
    fn no_label_covers_another() {
        for (below, above) in [
            (1.0, 3.0),
            (0.5, 1.0),
            (0.3, 7.7),
            (3.5, 0.5),
            (5.0, 5.0),
            (0.4, 0.4),
        ] {
            let parameters = Parameters::from_values([
                ("geometry.length_below", Value::from(below)),
                ("geometry.length_above", Value::from(above)),
            ]);
            let mut drawing = Drawing::new(&parameters.expect("admissible"));
            for (total, slack) in [
                (0.0, &[][..]),
                (1_719.0, &[0.0]),
                (16_000.0, &[0.0]),
                (8_000.0, &[0.0, 0.1]),
                (36_000.0, &[0.0, 0.0, 0.1]),
            ] {
                drawing.vehicle = match slack {
                    [] => VehicleBody::rigid_mass(),
                    slack => VehicleBody::assumed(total, slack),
                };
                drawing.vehicle_name = "articulated_36t".to_owned();
                for (sample, degrees) in in_directions(&states(slack.len())) {
                    drawing.travel(degrees.to_radians());
                    let labels = labels_of(&drawing, &sample);
                    assert!(labels.len() >= 6);
                    let places = labels.iter().map(|it| (it, rectangle(&drawing, it)));
                    let places: Vec<_> = places.collect();
                    for (index, (label, [from, to])) in places.iter().enumerate() {
                        for (other, [other_from, other_to]) in &places[..index] {
                            // Rounding to whole points of the screen.
                            let apart = |axis: usize| {
                                from[axis] >= other_to[axis] - 2.0
                                    || other_from[axis] >= to[axis] - 2.0
                            };
                            assert!(
                                apart(0) || apart(1),
                                "{below} {above} {total} {:?} {degrees}: {label:?} {other:?}",
                                sample.phase
                            );
                        }
                    }
                }
            }
        }
    }

    /// Column, vehicle and labels are in the picture from the moment when the vehicle is half a metre away.
    #[test]
    fn everything_is_in_the_picture() {
        let mut drawing = Drawing::new(&Parameters::default());
        for (total, masses) in [(1_719.0, 1), (8_000.0, 2)] {
            drawing.vehicle = VehicleBody::assumed(total, &[0.0; 3][..masses]);
            for (sample, degrees) in in_directions(&states(masses)) {
                drawing.travel(degrees.to_radians());
                let scene = drawing.scene(&sample, Some(total));
                let vehicle = scene.vehicle.expect("there");
                let column = scene.solid.positions.iter().chain(&scene.spring);
                let boxes = vehicle.boxes.iter().filter(|it| it.colour != colour::ROAD);
                let boxes: Vec<_> = boxes.map(|it| it.centre).collect();
                for place in column.chain(&vehicle.hull.positions).chain(&boxes) {
                    let [x, y] = drawing.camera().project(*place);
                    assert!(
                        (-10.0..VIEW[0] + 10.0).contains(&x),
                        "{total} {degrees}: {place:?} {x}"
                    );
                    assert!(
                        (-10.0..VIEW[1] + 10.0).contains(&y),
                        "{total} {degrees}: {place:?} {y}"
                    );
                }
                for label in labels_of(&drawing, &sample) {
                    let [from, to] = rectangle(&drawing, &label);
                    assert!(
                        from[0] > -10.0 && to[0] < VIEW[0] + 10.0,
                        "{label:?} {to:?}"
                    );
                    assert!(
                        from[1] > -10.0 && to[1] < VIEW[1] + 10.0,
                        "{label:?} {to:?}"
                    );
                }
            }
        }
    }

    /// The label of a vehicle gives its crush; the nose is as long as the crush leaves it, and orange when it is gone.
    #[test]
    fn a_crushed_car_is_shorter() {
        let mut drawing = Drawing::new(&Parameters::default());
        drawing.vehicle = VehicleBody::assumed(1_719.0, &[0.0]);
        drawing.vehicle_name = "mid_car".to_owned();
        let of_crush = |crush: f64| {
            let mut sample = hit();
            sample.vehicle.masses = 1;
            sample.vehicle.crush[0] = crush;
            sample.vehicle.force[0] = 2.5e5;
            drawing.scene(&sample, Some(1719.0)).vehicle.expect("there")
        };
        let length = |mark: &VehicleMark| {
            let along = mark.hull.positions.iter().map(|it| it[0]);
            let rear = along.clone().fold(f32::INFINITY, f32::min);
            along.fold(f32::NEG_INFINITY, f32::max) - rear
        };
        let (whole, crushed) = (of_crush(0.0), of_crush(0.3));
        assert!((length(&whole) - 4.5).abs() < 1e-5);
        assert!((length(&whole) - length(&crushed) - 0.3).abs() < 1e-5);
        assert_eq!(
            crushed.label.text,
            "mid_car: 1719 kg, 0.50 m/s\ncrush 300 mm, 250 kN"
        );
        assert!(whole.colours.iter().all(|it| *it == colour::IMPACTOR));
        assert!(of_crush(9.0).colours.contains(&colour::CRUSHED));
    }

    #[test]
    fn the_column_at_rest_carries_its_load() {
        let at_rest = Drawing::new(&Parameters::default()).at_rest;
        assert!(at_rest.u2 > at_rest.u1 && at_rest.u1 > 0.0);
        assert!(at_rest.hinges[2].normal_force < 0.0 && at_rest.hinges[2].utilisation > 0.0);
        assert_eq!(at_rest.phase, Phase::Idle);
    }
}
