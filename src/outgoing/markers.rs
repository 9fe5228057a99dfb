//! Markers for RViz and Foxglove: the deformed column, its hinges, the vehicle, and the contact force.
//!
//! The frame has its origin at the base, `z` up and `x` in the vehicle's direction of travel.

use crate::column::{HingeState, Phase, Sample};
use crate::messages::geometry_msgs::{Point, Pose, Vector3};
use crate::messages::std_msgs::{ColorRGBA, Header};
use crate::messages::visualization_msgs::{Marker, MarkerArray};
use crate::shape::{Joints, PlanePoint};
use crate::twin::Lengths;

/// Width of the column's line \[m\].
const COLUMN_WIDTH: f64 = 0.2;

/// Diameter of a hinge \[m\].
const HINGE_DIAMETER: f64 = 0.25;

/// Displayed distance of hinges 1a and 1b below and above the impact point \[m\].
const HINGE_OFFSET: f64 = 0.1;

/// Length, width and height of the vehicle \[m\].
const VEHICLE: [f64; 3] = [2.0, 1.6, 1.2];

/// Contact force per length of its arrow \[N/m\].
const FORCE_PER_METRE: f64 = 1e6;

/// Diameters of the arrow of the contact force: shaft and head \[m\].
const ARROW: [f64; 2] = [0.06, 0.12];

const STEEL: ColorRGBA = color(0.45, 0.5, 0.55);
const ELASTIC: ColorRGBA = color(0.2, 0.7, 0.3);
const PLASTIC: ColorRGBA = color(0.9, 0.15, 0.1);
const UNLOADED: ColorRGBA = color(0.95, 0.6, 0.1);
const CAR: ColorRGBA = color(0.2, 0.4, 0.8);
const FORCE: ColorRGBA = color(0.8, 0.1, 0.6);

const fn color(r: f32, g: f32, b: f32) -> ColorRGBA {
    ColorRGBA { r, g, b, a: 1.0 }
}

/// All markers of a sample. The markers of an absent vehicle or force are deleted.
pub(super) fn markers(header: &Header, lengths: Lengths, sample: &Sample) -> MarkerArray {
    let joints = Joints::new(lengths, sample, 1.0);
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
    markers.push(vehicle(header, sample, &joints));
    markers.push(force(header, sample, in_space(joints.impact)));
    MarkerArray { markers }
}

fn vehicle(header: &Header, sample: &Sample, joints: &Joints) -> Marker {
    let mut cube = marker(header, "vehicle", 0, Marker::CUBE, CAR);
    if sample.phase == Phase::Idle {
        cube.action = Marker::DELETE;
    }
    // Its front touches the face of the column, half a width before its axis.
    let front = joints.impactor_front(sample, 0.5 * COLUMN_WIDTH);
    cube.pose.position = in_space(PlanePoint::new(front - 0.5 * VEHICLE[0], joints.impact.z));
    cube.scale = vector(VEHICLE);
    cube
}

fn force(header: &Header, sample: &Sample, at: Point) -> Marker {
    let mut arrow = marker(header, "contact_force", 0, Marker::ARROW, FORCE);
    if sample.contact_force <= 0.0 {
        arrow.action = Marker::DELETE;
    }
    let tail = Point {
        x: at.x - sample.contact_force / FORCE_PER_METRE,
        ..at
    };
    arrow.points = vec![tail, at];
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

fn in_space(PlanePoint { x, z }: PlanePoint) -> Point {
    Point { x, y: 0.0, z }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, z: f64) -> Point {
        in_space(PlanePoint::new(x, z))
    }

    const LENGTHS: Lengths = Lengths {
        below: 1.0,
        above: 3.0,
    };

    fn of(sample: &Sample) -> Vec<Marker> {
        markers(&Header::default(), LENGTHS, sample).markers
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
        let car = by_name(&contact, "vehicle");
        let front = car.pose.position.x + 0.5 * car.scale.x;
        assert!((front - (0.5 - 0.5 * COLUMN_WIDTH)).abs() < 1e-12);
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
