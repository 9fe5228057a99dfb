//! Markers for RViz and Foxglove: the deformed column, its hinges, the vehicle, and the contact force.
//!
//! The frame has its origin at the base, `z` up, `x` along the web and `y` along the flanges. The two bars bend along `x`; the
//! vehicle comes from where it comes from.

use crate::column::{HingeState, Phase, Sample};
use crate::messages::geometry_msgs::{Point, Pose, Quaternion, Vector3};
use crate::messages::std_msgs::{ColorRGBA, Header};
use crate::messages::visualization_msgs::{Marker, MarkerArray};
use crate::shape::{Heading, Joints, PlanePoint, VehicleBody};
use crate::twin::Lengths;

/// Width of the column's line \[m\].
const COLUMN_WIDTH: f64 = 0.2;

/// Diameter of a hinge \[m\].
const HINGE_DIAMETER: f64 = 0.25;

/// Displayed distance of hinges 1a and 1b below and above the impact point \[m\].
const HINGE_OFFSET: f64 = 0.1;

/// Colours of the boxes of the vehicle: nose, hull, what is above it, engine, second and third mass.
const VEHICLE_BOXES: [ColorRGBA; 6] = [CAR, CAR, CAR, ENGINE, CARGO, CARGO];

/// Contact force per length of its arrow \[N/m\].
const FORCE_PER_METRE: f64 = 1e6;

/// Diameters of the arrow of the contact force: shaft and head \[m\].
const ARROW: [f64; 2] = [0.06, 0.12];

const STEEL: ColorRGBA = color(0.45, 0.5, 0.55);
const ELASTIC: ColorRGBA = color(0.2, 0.7, 0.3);
const PLASTIC: ColorRGBA = color(0.9, 0.15, 0.1);
const UNLOADED: ColorRGBA = color(0.95, 0.6, 0.1);
const CAR: ColorRGBA = color(0.2, 0.4, 0.8);
/// The nose when all of it is crushed.
const CRUSHED: ColorRGBA = color(0.95, 0.5, 0.15);
const ENGINE: ColorRGBA = color(0.75, 0.77, 0.8);
const CARGO: ColorRGBA = color(0.8, 0.6, 0.35);
const FORCE: ColorRGBA = color(0.8, 0.1, 0.6);

const fn color(r: f32, g: f32, b: f32) -> ColorRGBA {
    ColorRGBA { r, g, b, a: 1.0 }
}

/// All markers of a sample. The markers of an absent vehicle or force are deleted.
pub(super) fn markers(
    header: &Header,
    lengths: Lengths,
    body: &VehicleBody,
    heading: Heading,
    sample: &Sample,
) -> MarkerArray {
    let joints = Joints::new(lengths, sample, 1.0);
    let in_space = |place| in_space(place, heading);
    let mut column = marker(header, "column", 0, Marker::LINE_STRIP, STEEL);
    column.scale.x = COLUMN_WIDTH;
    column.points = [joints.base, joints.impact, joints.top]
        .map(in_space)
        .to_vec();
    let mut markers = vec![column];
    let hinges = joints.hinges(HINGE_OFFSET).map(in_space);
    for ((id, position), hinge) in (0..).zip(hinges).zip(&sample.hinges) {
        let mut sphere = marker(
            header,
            "hinges",
            id,
            Marker::SPHERE,
            hinge_color(hinge.state),
        );
        sphere.pose.position = position;
        sphere.scale = vector([HINGE_DIAMETER; 3]);
        markers.push(sphere);
    }
    let road = body.road(lengths.below);
    markers.extend(vehicle(header, body, heading, road, sample, &joints));
    markers.push(force(header, sample, joints.impact, heading));
    MarkerArray { markers }
}

/// The vehicle as boxes of its real size; its nose is as long as its crush leaves it. A box that it does not have is deleted.
fn vehicle(
    header: &Header,
    body: &VehicleBody,
    heading: Heading,
    road: f64,
    sample: &Sample,
    joints: &Joints,
) -> Vec<Marker> {
    // Its front touches the face of the column, half a width before its axis.
    let front = heading.front(joints, sample, 0.5 * COLUMN_WIDTH);
    let orientation = turned(heading);
    let crushed = body.crushed(&sample.vehicle);
    let half_width = 0.5 * body.width();
    let mut boxes = crushed
        .hull_boxes()
        .map(|(extent, heights)| Some((extent, heights, half_width)))
        .to_vec();
    let mut others = crushed.boxes();
    boxes.push(body.engine.and_then(|_| others.next()));
    boxes.extend([others.next(), others.next()]);
    let slots = (0..).zip(VEHICLE_BOXES).zip(boxes);
    slots
        .map(|((id, color), it)| {
            let mut cube = marker(header, "vehicle", id, Marker::CUBE, color);
            if id == 0 {
                cube.color = between(CAR, CRUSHED, crushed.crushed_share());
            }
            let is_there = |it: &([f64; 2], [f64; 2], f64)| it.0[1] > it.0[0];
            let it = it.filter(is_there).filter(|_| sample.phase != Phase::Idle);
            let Some((extent, heights, half_width)) = it else {
                cube.action = Marker::DELETE;
                return cube;
            };
            let [x, y, z] = heading.in_space([
                front - 0.5 * (extent[0] + extent[1]),
                0.0,
                road + 0.5 * (heights[0] + heights[1]),
            ]);
            cube.pose.position = Point { x, y, z };
            cube.pose.orientation = orientation;
            cube.scale = vector([
                extent[1] - extent[0],
                2.0 * half_width,
                heights[1] - heights[0],
            ]);
            cube
        })
        .collect()
}

/// The colour at `part` of the way from one to another.
fn between(one: ColorRGBA, other: ColorRGBA, part: f64) -> ColorRGBA {
    let at = |one: f32, other: f32| one + part as f32 * (other - one);
    color(at(one.r, other.r), at(one.g, other.g), at(one.b, other.b))
}

/// The force on the two bars, in their plane.
fn force(header: &Header, sample: &Sample, at: PlanePoint, heading: Heading) -> Marker {
    let mut arrow = marker(header, "contact_force", 0, Marker::ARROW, FORCE);
    if sample.contact_force <= 0.0 {
        arrow.action = Marker::DELETE;
    }
    let tail = PlanePoint::new(at.x - sample.contact_force / FORCE_PER_METRE, at.z);
    arrow.points = [tail, at].map(|it| in_space(it, heading)).to_vec();
    arrow.scale = vector([ARROW[0], ARROW[1], 0.0]);
    arrow
}

fn hinge_color(state: HingeState) -> ColorRGBA {
    match state {
        HingeState::Elastic => ELASTIC,
        HingeState::Plastic => PLASTIC,
        HingeState::Unloaded => UNLOADED,
    }
}

fn marker(header: &Header, ns: &str, id: i32, kind: i32, color: ColorRGBA) -> Marker {
    Marker {
        header: header.clone(),
        ns: ns.to_owned(),
        id,
        kind,
        action: Marker::ADD,
        pose: Pose::default(),
        color,
        ..Marker::default()
    }
}

/// A point of the two bars, which bend where the vehicle travels.
fn in_space(PlanePoint { x, z }: PlanePoint, heading: Heading) -> Point {
    Point {
        x: heading.of_bars() * x,
        y: 0.0,
        z,
    }
}

/// The rotation about `z` that turns `x` into the direction of travel.
fn turned(heading: Heading) -> Quaternion {
    let half = 0.5 * heading.direction();
    Quaternion {
        x: 0.0,
        y: 0.0,
        z: libm::sin(half),
        w: libm::cos(half),
    }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, z: f64) -> Point {
        in_space(PlanePoint::new(x, z), Heading::default())
    }

    const LENGTHS: Lengths = Lengths {
        below: 1.0,
        above: 3.0,
        top_is_free: false,
    };

    fn of(sample: &Sample) -> Vec<Marker> {
        of_body(&VehicleBody::rigid_mass(), sample)
    }

    fn of_body(body: &VehicleBody, sample: &Sample) -> Vec<Marker> {
        travelling(body, 0.0, sample)
    }

    fn travelling(body: &VehicleBody, direction: f64, sample: &Sample) -> Vec<Marker> {
        let heading = Heading::new(direction);
        markers(&Header::default(), LENGTHS, body, heading, sample).markers
    }

    fn by_name<'a>(markers: &'a [Marker], ns: &str) -> &'a Marker {
        markers.iter().find(|it| it.ns == ns).expect(ns)
    }

    #[test]
    fn the_column_is_deformed_as_in_the_sample() {
        let sample = Sample {
            v1: 0.25,
            u1: 0.125,
            u2: 0.5,
            ..Sample::default()
        };
        let markers = of(&sample);
        let column = &by_name(&markers, "column").points;
        assert_eq!(column[1], point(0.25, 0.875));
        assert_eq!(column[2], point(0.0, 3.5));
    }

    #[test]
    fn absent_vehicle_and_force_are_deleted() {
        let idle = of(&Sample::default());
        assert_eq!(by_name(&idle, "vehicle").action, Marker::DELETE);
        assert_eq!(by_name(&idle, "contact_force").action, Marker::DELETE);
        let contact = of(&Sample {
            phase: Phase::Contact,
            contact_force: 5e5,
            v1: 0.5,
            impactor_position: 0.5,
            ..Sample::default()
        });
        let arrow = by_name(&contact, "contact_force");
        assert_eq!(arrow.action, Marker::ADD);
        assert_eq!(arrow.points, [point(0.0, 1.0), point(0.5, 1.0)]);
        // A rigid mass has one box; the others are deleted.
        let boxes = boxes(&contact);
        assert_eq!(boxes.len(), 1);
        assert!((front(&boxes) - (0.5 - 0.5 * COLUMN_WIDTH)).abs() < 1e-12);
        let centre = boxes[0].pose.position;
        assert!((centre.z - LENGTHS.below).abs() < 1e-12);
    }

    /// The boxes of the vehicle that are shown.
    fn boxes(markers: &[Marker]) -> Vec<&Marker> {
        let shown = |it: &&Marker| it.ns == "vehicle" && it.action == Marker::ADD;
        markers.iter().filter(shown).collect()
    }

    /// Front end of some boxes \[m\].
    fn front(boxes: &[&Marker]) -> f64 {
        let ends = boxes.iter().map(|it| it.pose.position.x + 0.5 * it.scale.x);
        ends.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Overall length of some boxes \[m\].
    fn length(boxes: &[&Marker]) -> f64 {
        let ends = boxes.iter().map(|it| it.pose.position.x - 0.5 * it.scale.x);
        front(boxes) - ends.fold(f64::INFINITY, f64::min)
    }

    /// A car has its real size, its nose is shorter by its crush, and its front is at the column.
    #[test]
    fn the_nose_of_a_car_shortens() {
        let body = VehicleBody::assumed(1_500.0, &[0.0]);
        let mut sample = Sample {
            phase: Phase::Contact,
            contact_force: 2e5,
            v1: 0.01,
            impactor_position: 0.01,
            ..Sample::default()
        };
        sample.vehicle.masses = 1;
        let whole = of_body(&body, &sample);
        assert!((length(&boxes(&whole)) - body.length()).abs() < 1e-12);
        sample.vehicle.crush[0] = 0.3;
        let crushed = of_body(&body, &sample);
        assert!((length(&boxes(&crushed)) - (body.length() - 0.3)).abs() < 1e-12);
        let nose = |markers: &[Marker]| boxes(markers)[0].scale.x;
        assert!((nose(&whole) - nose(&crushed) - 0.3).abs() < 1e-12);
        for markers in [&whole, &crushed] {
            let expected = 0.01 - 0.5 * COLUMN_WIDTH;
            assert!((front(&boxes(markers)) - expected).abs() < 1e-12);
        }
        assert_ne!(boxes(&whole)[0].color, boxes(&crushed)[0].color);
    }

    /// A lorry with a load shows nose, frame, cab, engine and load.
    #[test]
    fn engine_and_load_of_a_lorry_are_shown() {
        let body = VehicleBody::assumed(8_000.0, &[0.0, 0.0]);
        let mut sample = Sample {
            phase: Phase::Contact,
            ..Sample::default()
        };
        sample.vehicle.masses = 2;
        let markers = of_body(&body, &sample);
        assert_eq!(boxes(&markers).len(), 5);
        assert!((length(&boxes(&markers)) - body.length()).abs() < 1e-9);
    }

    /// The boxes come along their direction of travel and are turned into it; the bars bend away from them.
    #[test]
    fn the_vehicle_comes_from_its_direction() {
        let body = VehicleBody::assumed(8_000.0, &[0.0, 0.0]);
        for degrees in [0.0_f64, 10.0, 45.0, 90.0, 135.0, 180.0, -45.0, -90.0] {
            let direction = degrees.to_radians();
            let (sin, cos) = direction.sin_cos();
            let at = |gap: f64, phase: Phase| {
                let mut sample = Sample {
                    phase,
                    v1: 0.2,
                    gap: gap * cos.abs(),
                    ..Sample::default()
                };
                sample.vehicle.masses = 2;
                travelling(&body, direction, &sample)
            };
            let (far, near) = (at(0.75, Phase::Approach), at(0.0, Phase::Contact));
            let shown = [&far, &near].map(|it| boxes(it));
            assert_eq!((shown[0].len(), shown[1].len()), (5, 5));
            let seen = cos.abs() > 1e-3;
            for (before, after) in shown[0].iter().zip(&shown[1]) {
                let [p, q] = [before, after].map(|it| it.pose.position);
                let way = if seen { 0.75 } else { 0.0 };
                assert!((q.x - p.x - way * cos).abs() < 1e-12, "{degrees}");
                assert!((q.y - p.y - way * sin).abs() < 1e-12, "{degrees}");
                // The middle of each box is behind the column on the path.
                assert!((p.x * sin - p.y * cos).abs() < 1e-12, "{degrees}");
                assert!(p.x * cos + p.y * sin < 0.0, "{degrees}");
                // The rotation of the x axis by the quaternion.
                let Quaternion { x, y, z, w } = after.pose.orientation;
                assert_eq!((x, y), (0.0, 0.0));
                let turned = [w * w - z * z, 2.0 * w * z];
                assert!((turned[0] - cos).abs() < 1e-12, "{degrees}");
                assert!((turned[1] - sin).abs() < 1e-12, "{degrees}");
            }
            let bent = by_name(&near, "column").points[1].x;
            assert!(bent.abs() == 0.2 && (bent * cos > 0.0), "{degrees}: {bent}");
        }
    }

    #[test]
    fn markers_have_unique_identifiers() {
        let markers = of(&Sample::default());
        let mut keys: Vec<_> = markers.iter().map(|it| (it.ns.clone(), it.id)).collect();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), markers.len());
    }
}
