//! The vehicle in the scene, where it comes from: its parts and its label.

use super::colour;
use super::labels::{self, Label};
use super::point::Point3;
use super::scene::{BoxMark, Drawing, HALF_WHEEL, LABEL_GAP, SHOWN_LENGTH, VehicleMark, force};
use crate::column::{Phase, Sample, share_in_plane};
use crate::parameters::degrees;
use crate::shape::{CrushedVehicle, Joints, PlanePoint};

/// Where the road ends in front of the column, and its width beside the vehicle \[m\].
const ROAD: [f64; 2] = [0.62, 0.25];

impl Drawing {
    /// A point of the vehicle, which is given along its path, to the left of it and upwards, in space.
    fn on_path(&self, place: [f64; 3]) -> Point3 {
        self.heading.in_space(place).map(|it| it as f32)
    }

    /// How far the section reaches from its axis towards the vehicle \[m\].
    pub(super) fn reach(&self) -> f64 {
        let [x, y] = self.heading.travel();
        let [along, across] = self.outline.farthest([-x, -y]);
        -(x * along + y * across)
    }

    /// The vehicle, if there is one, beside the column with these joints; a point of the screen has the size `point` \[m\].
    pub(super) fn vehicle_mark(
        &self,
        sample: &Sample,
        joints: &Joints,
        mass: Option<f64>,
        point: f64,
    ) -> Option<VehicleMark> {
        if sample.phase == Phase::Idle {
            return None;
        }
        let body = &self.vehicle;
        let front = self.heading.front(joints, sample, self.reach());
        let road = body.road(self.lengths.below);
        let crushed = body.crushed(&sample.vehicle);
        let mut hull = crushed.hull(front, road);
        for corner in hull.positions.iter_mut().chain(&mut hull.normals) {
            *corner = self.on_path(corner.map(f64::from));
        }
        let nose = colour::mix(colour::IMPACTOR, colour::CRUSHED, crushed.crushed_share());
        let colours = hull.is_nose.iter();
        let colours = colours
            .map(|is_nose| if *is_nose { nose } else { colour::IMPACTOR })
            .collect();
        let (wheels, wheel_radii) = self.wheels(&crushed, front, road);
        Some(VehicleMark {
            colours,
            hull,
            edges: self.edges(&crushed, front, road),
            boxes: self.boxes(&crushed, front, road),
            wheels,
            wheel_radii,
            label: self.vehicle_label(sample, mass, front, road, point),
            direction: self.heading.direction(),
        })
    }

    /// Engine, cargo and the road on which the vehicle stands.
    fn boxes(&self, crushed: &CrushedVehicle<'_>, front: f64, road: f64) -> Vec<BoxMark> {
        let body = &self.vehicle;
        let rear = body.parts.len() - 1;
        let mut colours = vec![colour::ENGINE; usize::from(body.engine.is_some())];
        colours.extend(&colour::CARGO[..rear.min(colour::CARGO.len())]);
        let mut boxes: Vec<_> = crushed
            .boxes()
            .zip(colours)
            .map(|((extent, heights, half_width), colour)| BoxMark {
                centre: self.on_path([
                    front - 0.5 * (extent[0] + extent[1]),
                    0.0,
                    road + 0.5 * (heights[0] + heights[1]),
                ]),
                half_size: [
                    0.5 * (extent[1] - extent[0]),
                    half_width,
                    0.5 * (heights[1] - heights[0]),
                ]
                .map(|it| it as f32),
                colour,
            })
            .collect();
        if body.is_real() {
            let [end, beside] = ROAD;
            let length = body.length() + 1.0;
            boxes.push(BoxMark {
                centre: self.on_path([-(end + 0.5 * length), 0.0, road - 0.02]),
                half_size: [0.5 * length, 0.5 * body.width() + beside, 0.02].map(|it| it as f32),
                colour: colour::ROAD,
            });
        }
        boxes
    }

    fn wheels(
        &self,
        crushed: &CrushedVehicle<'_>,
        front: f64,
        road: f64,
    ) -> (Vec<Point3>, Vec<f32>) {
        let aside = 0.5 * self.vehicle.width() - HALF_WHEEL;
        let both = crushed.wheels().flat_map(|wheel| {
            [-aside, aside].map(|y| {
                let centre = [front - wheel.behind, y, road + wheel.radius];
                (self.on_path(centre), wheel.radius as f32)
            })
        });
        both.unzip()
    }

    /// The label is below the vehicle and left of the base.
    fn vehicle_label(
        &self,
        sample: &Sample,
        mass: Option<f64>,
        front: f64,
        road: f64,
        point: f64,
    ) -> Label {
        let text = self.vehicle_text(sample, mass);
        let half = 0.5 * point * labels::size(&text)[0];
        let [along, _] = self.outlook().travel();
        let middle = front - 0.5 * self.vehicle.length().min(SHOWN_LENGTH);
        let x = (along * middle).min(-(ROAD[0] + half));
        Label {
            place: self.outlook().in_space(
                PlanePoint::new(x, road - LABEL_GAP),
                -0.5 * along * self.vehicle.width(),
            ),
            text,
        }
    }

    /// Name, mass and speed, the direction, and one line for every spring that is crushed.
    fn vehicle_text(&self, sample: &Sample, mass: Option<f64>) -> String {
        let mass = mass.map_or_else(String::new, |mass| format!("{mass:.0} kg, "));
        let speed = sample.impactor_velocity;
        let name = &self.vehicle_name;
        let direction = self.direction_text();
        if !self.vehicle.is_real() {
            return format!("{name} (as in the paper)\n{mass}{speed:.2} m/s{direction}");
        }
        let vehicle = &sample.vehicle;
        let mut text = format!("{name}: {mass}{speed:.2} m/s{direction}");
        for (spring, name) in self.vehicle.names().take(vehicle.masses).enumerate() {
            let crush = 1e3 * vehicle.crush[spring].max(0.0);
            let force = force(vehicle.force[spring]);
            text.push_str(&match spring {
                0 => format!("\ncrush {crush:.0} mm, {force}"),
                _ => format!("\n{name}: crush {crush:.0} mm, {force}"),
            });
        }
        text
    }

    /// A line on the direction, if it is not 0. The speed is that of the two bars, which see the component in their plane.
    fn direction_text(&self) -> String {
        let direction = self.heading.direction();
        let angle = degrees(direction);
        match share_in_plane(direction) < 1.0 {
            true => format!("\nat {angle}, speed in the plane"),
            false if direction != 0.0 => format!("\nat {angle}"),
            false => String::new(),
        }
    }

    /// The outline of the hull on both sides, connected at the corners of its roof.
    fn edges(&self, crushed: &CrushedVehicle<'_>, front: f64, road: f64) -> Vec<Vec<Point3>> {
        let half = 0.5 * crushed.body().width();
        let [left, right] = [-half, half].map(|y| {
            let outline = crushed.outline(front, road, y).into_iter();
            outline.map(|point| self.on_path(point)).collect::<Vec<_>>()
        });
        let across = left.iter().zip(&right);
        let mut edges: Vec<_> = across.map(|(one, other)| vec![*one, *other]).collect();
        edges.dedup();
        edges.extend([left, right]);
        edges
    }
}
