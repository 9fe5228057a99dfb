//! The direction of a hit in the viewer: what is written to the stream comes from there.

use std::sync::Arc;

use column_twin::column::{Sample, simulate};
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::parameters::{Parameters, Value};
use column_twin::twin::StrikingVehicle;
use column_twin::viewer::{ViewerItem, from_samples};
use rerun::components::RotationAxisAngle;
use rerun::log::Chunk;
use rerun::{Arrows3D, Boxes3D, ComponentIdentifier, Cylinders3D, Mesh3D};

use super::beam::Shown;

const GAP: f64 = 0.5;

/// Directions of travel from all sides, but not at right angles to the plane of the two bars \[degrees\].
const DIRECTIONS: [f64; 8] = [0.0, 10.0, 45.0, 135.0, 180.0, -10.0, -45.0, -135.0];

/// A lorry that begins half a metre away from an HEB220.
fn parameters(degrees: f64) -> Arc<Parameters> {
    let values = [
        ("vehicle.name", Value::from("lorry_8t")),
        ("impact.mass", Value::from(0.0)),
        ("impact.velocity", Value::from(5.0)),
        ("impact.gap", Value::from(GAP)),
        ("impact.direction", Value::from(degrees.to_radians())),
    ];
    let parameters = Parameters::default().with_changes(values);
    Arc::new(parameters.expect("admissible"))
}

/// The items of the impact by the two bars, whose report states this direction \[degrees\], if any.
fn items(parameters: &Parameters, told: Option<f64>) -> Vec<ViewerItem> {
    let (column, impact) = (parameters.column_properties(), parameters.impact());
    let mut samples: Vec<Sample> = Vec::new();
    let report = simulate(&column, &impact, 2.0, &mut |sample| samples.push(*sample));
    let mut report = ImpactReport::from(&report.expect("simulated"));
    if let Some(degrees) = told {
        let name = &parameters.settings().vehicle.name;
        report = report.of_impact(name, impact.mass, 5.0, degrees.to_radians());
    }
    from_samples(
        &format!("lorry {told:?}"),
        0,
        samples.into_iter().step_by(20),
        &report,
    )
}

/// What the vehicle's entity has of a component, one row after the other.
fn rows<T: Clone>(
    chunks: &[Chunk],
    entity: &str,
    of: impl Fn(&Chunk) -> Vec<Vec<T>>,
) -> Vec<Vec<T>> {
    let chunks = chunks
        .iter()
        .filter(|it| it.entity_path().to_string() == entity);
    chunks.flat_map(of).filter(|row| !row.is_empty()).collect()
}

fn points(chunks: &[Chunk], entity: &str, component: ComponentIdentifier) -> Vec<Vec<[f32; 3]>> {
    rows(chunks, entity, |chunk| {
        let rows = chunk.iter_slices::<[f32; 3]>(component);
        rows.map(<[_]>::to_vec).collect()
    })
}

fn turns(chunks: &[Chunk], component: ComponentIdentifier) -> Vec<Vec<RotationAxisAngle>> {
    rows(chunks, "/vehicle", |chunk| {
        let rows = chunk.iter_component::<RotationAxisAngle>(component);
        rows.into_iter().map(|row| row.to_vec()).collect()
    })
}

/// `vector` turned by a rotation, after Rodrigues.
fn turned(rotation: &RotationAxisAngle, vector: [f64; 3]) -> [f64; 3] {
    let axis = rotation.0.axis.0.map(f64::from);
    let (sin, cos) = f64::from(rotation.0.angle.radians()).sin_cos();
    let dot: f64 = (0..3).map(|k| axis[k] * vector[k]).sum();
    std::array::from_fn(|k| {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        let cross = axis[next] * vector[last] - axis[last] * vector[next];
        cos * vector[k] + sin * cross + (1.0 - cos) * dot * axis[k]
    })
}

fn mean(points: &[[f32; 3]]) -> [f64; 2] {
    [0, 1].map(|k| points.iter().map(|it| f64::from(it[k])).sum::<f64>() / points.len() as f64)
}

/// Whether everything that is drawn of the vehicle travels in this direction \[degrees\] until it touches the column, and bends the bars
/// there.
fn check(chunks: &[Chunk], degrees: f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let near = |found: f64, expected: f64| {
        assert!(
            (found - expected).abs() < 1e-5,
            "{degrees}: {found} {expected}"
        );
    };
    let hull = Mesh3D::descriptor_vertex_positions().component;
    let boxes = Boxes3D::descriptor_centers().component;
    let wheels = Cylinders3D::descriptor_centers().component;
    let hulls = points(chunks, "/vehicle", hull);
    // A vehicle that is not there has a hull of no size.
    let is_there = |row: &&Vec<[f32; 3]>| row.iter().any(|it| *it != row[0]);
    let hulls: Vec<_> = hulls.iter().filter(is_there).collect();
    let along = |it: [f64; 2]| it[0] * cos + it[1] * sin;
    // The last frame before the crush, in which all parts have come equally far.
    let first = mean(hulls[0]);
    let moved: Vec<_> = hulls
        .iter()
        .map(|it| along(mean(it)) - along(first))
        .collect();
    let touch = moved
        .iter()
        .position(|it| *it > 0.9 * GAP)
        .expect("it comes near");
    let way = moved[touch];
    assert!(way < GAP + 1e-3, "{degrees}: {way}");
    let [boxes, wheels] = [boxes, wheels].map(|it| points(chunks, "/vehicle", it));
    for (what, rows) in [
        ("hull", points(chunks, "/vehicle", hull)),
        ("boxes", boxes),
        ("wheels", wheels),
    ] {
        let rows: Vec<_> = rows
            .iter()
            .filter(|it| what != "hull" || is_there(it))
            .collect();
        for (before, after) in rows[0].iter().zip(rows[touch]) {
            let [x, y] = [0, 1].map(|k| f64::from(after[k] - before[k]));
            // The road under the vehicle stays.
            if what == "boxes" && x == 0.0 && y == 0.0 {
                continue;
            }
            near(x, way * cos);
            near(y, way * sin);
        }
    }
    // It comes straight towards the axis of the column.
    near(first[0] * sin - first[1] * cos, 0.0);
    assert!(along(first) < -GAP, "{degrees}: {first:?}");
    for row in turns(chunks, Boxes3D::descriptor_rotation_axis_angles().component) {
        let [x, y, z] = turned(&row[0], [1.0, 0.0, 0.0]);
        near(x, cos);
        near(y, sin);
        near(z, 0.0);
    }
    // An axle is horizontal and at right angles to the direction of travel.
    for row in turns(
        chunks,
        Cylinders3D::descriptor_rotation_axis_angles().component,
    ) {
        let [x, y, z] = turned(&row[0], [0.0, 0.0, 1.0]);
        near(x * cos + y * sin, 0.0);
        near(z, 0.0);
    }
    let steel = points(chunks, "/column/steel", hull);
    let bent = steel
        .iter()
        .map(|it| (mean(it)[0] - mean(&steel[0])[0]) * cos.signum());
    let most = bent.fold(f64::NEG_INFINITY, f64::max);
    assert!(most > 1e-3, "{degrees}: the bars have moved by {most} m");
    let arrows = points(chunks, "/vehicle", Arrows3D::descriptor_vectors().component);
    assert!(!arrows.is_empty());
    for arrow in arrows {
        assert!(f64::from(arrow[0][0]) * cos > 0.0 && arrow[0][1] == 0.0);
    }
}

#[test]
fn the_vehicle_travels_in_its_direction() {
    for degrees in DIRECTIONS {
        let parameters = parameters(degrees);
        let chunks = Shown::new(&parameters).show(items(&parameters, None));
        check(&chunks, degrees);
    }
}

/// A recording has the direction in its reports, a running twin in its states; the next impact may come from elsewhere.
#[test]
fn each_impact_comes_from_its_own_direction() {
    let ahead = parameters(0.0);
    let oblique = parameters(60.0);
    let mut shown = Shown::new(&ahead);
    for (column, degrees) in [(&oblique, 60.0), (&oblique, -60.0), (&ahead, 0.0)] {
        check(&shown.show(items(column, Some(degrees))), degrees);
    }
    let mut items = items(&oblique, Some(0.0));
    for item in &mut items {
        if let ViewerItem::State(state) = item {
            state.event_id = "other".into();
            state.vehicle = Some(StrikingVehicle {
                name: "lorry_8t".into(),
                mass: 8_000.0,
                direction: 120.0_f64.to_radians(),
            });
        }
    }
    check(&shown.show(items), 120.0);
}

/// At right angles to their plane, the two bars see nothing of a vehicle: it stands at the column, where it comes from.
#[test]
fn a_vehicle_across_the_plane_is_at_the_column() {
    for degrees in [90.0, -90.0] {
        let parameters = parameters(degrees);
        let chunks = Shown::new(&parameters).show(items(&parameters, None));
        let hulls = points(
            &chunks,
            "/vehicle",
            Mesh3D::descriptor_vertex_positions().component,
        );
        let is_there = |row: &&Vec<[f32; 3]>| row.iter().any(|it| *it != row[0]);
        let mut shown = 0;
        for hull in hulls.iter().filter(is_there) {
            shown += 1;
            let sense = degrees.signum();
            let ends = hull.iter().map(|it| sense * f64::from(it[1]));
            let front = ends.fold(f64::NEG_INFINITY, f64::max);
            // Half the width of the flanges.
            assert!((front + 0.11).abs() < 1e-4, "{degrees}: {front}");
            let middle = mean(hull)[0];
            assert!(middle.abs() < 1e-5, "{degrees}: {middle}");
        }
        assert!(shown > 0);
    }
}
