//! Frames of the scene in a Rerun stream: the column, its hinges, its top and the vehicle.

use rerun::components::Translation3D;
use rerun::{
    Angle, Arrows3D, Boxes3D, Cylinders3D, FillMode, LineStrip3D, LineStrips3D, Mesh3D, Points3D,
    Radius, RecordingStreamResult, RotationAxisAngle, TimeColumn, Transform3D,
};

use super::branch::Branch;
use super::colour;
use super::point::Point3;
use super::rerun_types::{color, time_columns};
use super::scene::{Drawing, HALF_WHEEL, Scene, VehicleMark};
use super::static_scene;
use super::timeline::Moment;
use crate::column::HINGES;
use crate::shape::{Hull, Solid, hull_triangles};

/// The hull lets what is behind it and in it shine through: red, green, blue, opacity.
const HULL_TINT: [u8; 4] = [255, 255, 255, 130];

/// A movement of the top of the column that is too small to see \[m\].
const INVISIBLE_MOVEMENT: f32 = 1e-4;

/// Where the top of the column was drawn last; most of the time it does not move.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ShownTop(Option<Point3>);

impl ShownTop {
    /// Whether the top has to be drawn at its new place.
    fn update(&mut self, top: Point3) -> bool {
        let visible = |shown: Point3| (shown[2] - top[2]).abs() >= INVISIBLE_MOVEMENT;
        let moved = self.0.is_none_or(visible);
        if moved {
            self.0 = Some(top);
        }
        moved
    }
}

/// Sends frames, one row of each entity per frame. There are few entities with shapes of several kinds in each, because an
/// entity costs about the same whatever it contains.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send(
    stream: &Branch,
    frames: &[(Moment, Scene)],
    shown_top: &mut ShownTop,
) -> RecordingStreamResult<()> {
    if frames.is_empty() {
        return Ok(());
    }
    let times = time_columns(frames.iter().map(|(moment, _)| *moment));
    let scenes = || frames.iter().map(|(_, scene)| scene);
    let send =
        |entity: &str, columns_of_data| stream.send_columns(entity, times.clone(), columns_of_data);

    let corners: Vec<_> = scenes().map(|it| it.solid.positions.len()).collect();
    let positions = scenes().flat_map(|it| it.solid.positions.iter().copied());
    let normals = scenes().flat_map(|it| it.solid.normals.iter().copied());
    let colours = scenes().flat_map(|it| it.colours.iter().map(|it| color(*it)));
    let mesh = Mesh3D::update_fields()
        .with_vertex_positions(positions)
        .with_vertex_normals(normals)
        .with_vertex_colors(colours);
    send("column/steel", mesh.columns(corners)?.collect::<Vec<_>>())?;

    let hinges = || scenes().flat_map(|it| it.hinges.iter());
    let four = || vec![HINGES; frames.len()];
    let marks_and_labels = || {
        scenes().flat_map(|it| {
            let marks = it.hinges.iter().map(|it| (it.place, it.colour, ""));
            let labels = it.hinges.iter();
            marks.chain(labels.map(|it| (it.label.place, it.colour, it.label.text.as_str())))
        })
    };
    let marks = Points3D::update_fields()
        .with_positions(marks_and_labels().map(|(place, _, _)| place))
        .with_colors(marks_and_labels().map(|(_, colour, _)| color(colour)))
        .with_labels(marks_and_labels().map(|(_, _, label)| label));
    let arcs = LineStrips3D::update_fields()
        .with_strips(hinges().map(|it| LineStrip3D::from_iter(it.arc.iter().copied())));
    let heads = || hinges().map(|it| static_scene::arc_head(&it.arc));
    let heads = Arrows3D::update_fields()
        .with_origins(heads().map(|(origin, _)| origin))
        .with_vectors(heads().map(|(_, vector)| vector));
    let hinges = marks
        .columns(vec![2 * HINGES; frames.len()])?
        .chain(arcs.columns(four())?)
        .chain(heads.columns(four())?);
    send("column/hinges", hinges.collect())?;

    let moved: Vec<_> = frames
        .iter()
        .filter(|(_, scene)| shown_top.update(scene.top))
        .collect();
    if !moved.is_empty() {
        let tops = moved.iter().map(|(_, it)| Translation3D::from(it.top));
        let top = Transform3D::update_fields().with_many_translation(tops);
        let springs = moved
            .iter()
            .map(|(_, it)| LineStrip3D::from_iter(it.spring.iter().copied()));
        let spring = LineStrips3D::update_fields().with_strips(springs);
        let ones = || vec![1; moved.len()];
        let top = top.columns(ones())?.chain(spring.columns(ones())?);
        let times = time_columns(moved.iter().map(|(moment, _)| *moment));
        stream.send_columns("top", times, top.collect::<Vec<_>>())?;
    }

    send_vehicles(stream, frames, times)
}

/// Sends the vehicle and the contact force, all in one entity.
fn send_vehicles(
    stream: &Branch,
    frames: &[(Moment, Scene)],
    times: Vec<TimeColumn>,
) -> RecordingStreamResult<()> {
    let scenes = || frames.iter().map(|(_, scene)| scene);
    let vehicles = || scenes().filter_map(|it| it.vehicle.as_ref());
    let lengths = |of: &dyn Fn(&VehicleMark) -> usize| -> Vec<usize> {
        let vehicles = scenes().map(|it| it.vehicle.as_ref());
        vehicles.map(|it| it.map_or(0, of)).collect()
    };

    // The hull keeps its corners where there is no vehicle, because its triangles are static.
    let absent = Hull::absent();
    let hulls = || {
        let hulls = scenes().map(|it| it.vehicle.as_ref().map(|it| &it.hull));
        hulls.map(|it| it.unwrap_or(&absent))
    };
    let corners = vec![absent.positions.len(); frames.len()];
    let mesh = Mesh3D::update_fields()
        .with_vertex_positions(hulls().flat_map(|it| it.positions.iter().copied()))
        .with_vertex_normals(hulls().flat_map(|it| it.normals.iter().copied()));
    let hull_colours = vehicles().flat_map(|it| it.colours.iter().map(|it| color(*it)));
    let hull_colours = Mesh3D::update_fields().with_vertex_colors(hull_colours);
    let edges = vehicles().flat_map(|it| it.edges.iter());
    let edges = LineStrips3D::update_fields()
        .with_strips(edges.map(|it| LineStrip3D::from_iter(it.iter().copied())));
    let boxes = || vehicles().flat_map(|it| it.boxes.iter());
    let boxes = Boxes3D::update_fields()
        .with_centers(boxes().map(|it| it.centre))
        .with_half_sizes(boxes().map(|it| it.half_size))
        .with_colors(boxes().map(|it| color(it.colour)));
    let wheels = Cylinders3D::update_fields()
        .with_centers(vehicles().flat_map(|it| it.wheels.iter().copied()))
        .with_radii(vehicles().flat_map(|it| it.wheel_radii.iter().copied()));
    // One rotation for all boxes of a frame, and one for all wheels.
    let box_turns = vehicles().map(|it| turned_box(it.direction));
    let box_turns = Boxes3D::update_fields().with_rotation_axis_angles(box_turns);
    let wheel_turns = vehicles().map(|it| turned_wheel(it.direction));
    let wheel_turns = Cylinders3D::update_fields().with_rotation_axis_angles(wheel_turns);

    let forces = || scenes().filter_map(|it| it.contact.as_ref());
    let touching = scenes().map(|it| usize::from(it.contact.is_some()));
    let contact = Arrows3D::update_fields()
        .with_origins(forces().map(|it| it.origin))
        .with_vectors(forces().map(|it| it.vector));
    let labels_of = |scene: &Scene| {
        let vehicle = scene
            .vehicle
            .as_ref()
            .map(|it| (&it.label, colour::VEHICLE_EDGE));
        let force = scene
            .contact
            .as_ref()
            .map(|it| (&it.label, colour::CONTACT));
        vehicle
            .into_iter()
            .chain(force)
            .map(|(label, rgb)| (label.clone(), rgb))
            .collect::<Vec<_>>()
    };
    let labels: Vec<_> = scenes().map(labels_of).collect();
    let each = || labels.iter().flatten();
    let texts = Points3D::update_fields()
        .with_positions(each().map(|(label, _)| label.place))
        .with_colors(each().map(|(_, rgb)| color(*rgb)))
        .with_labels(each().map(|(label, _)| label.text.as_str()));

    let columns = mesh
        .columns(corners)?
        .chain(hull_colours.columns(lengths(&|it| it.colours.len()))?)
        .chain(edges.columns(lengths(&|it| it.edges.len()))?)
        .chain(boxes.columns(lengths(&|it| it.boxes.len()))?)
        .chain(wheels.columns(lengths(&|it| it.wheels.len()))?)
        .chain(box_turns.columns(lengths(&|_| 1))?)
        .chain(wheel_turns.columns(lengths(&|_| 1))?)
        .chain(contact.columns(touching.collect::<Vec<_>>())?)
        .chain(texts.columns(labels.iter().map(Vec::len).collect::<Vec<_>>())?);
    stream.send_columns("vehicle", times, columns.collect::<Vec<_>>())
}

/// A box that lies along `x` by itself, along the direction of travel \[rad\].
fn turned_box(direction: f64) -> RotationAxisAngle {
    RotationAxisAngle::new([0.0, 0.0, 1.0], Angle::from_radians(direction as f32))
}

/// A cylinder that lies along `z` by itself, as an axle of a vehicle with this direction of travel \[rad\].
fn turned_wheel(direction: f64) -> RotationAxisAngle {
    let (sin, cos) = direction.sin_cos();
    RotationAxisAngle::new([cos as f32, sin as f32, 0.0], Angle::from_degrees(90.0))
}

/// Sends what all frames of one column share: colours, sizes and the triangles of the steel.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send_statics(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    let (_, axis) = drawing.axis(&drawing.at_rest);
    let triangles = Solid::swept(&drawing.outline, &axis).triangles;
    let mesh = Mesh3D::update_fields().with_triangle_indices(triangles);
    stream.log_static("column/steel", &mesh)?;
    let radius = |metres: f64| Radius::new_scene_units(metres as f32);
    let ball = radius(0.5 * drawing.half_depth());
    let radii = std::iter::repeat_n(ball, HINGES).chain([radius(0.0); HINGES]);
    let of_hinges = Points3D::update_fields()
        .with_radii(radii)
        .with_show_labels(true);
    stream.log_static("column/hinges", &of_hinges)?;
    let thin = radius(0.004 * drawing.lengths.total());
    let arcs = LineStrips3D::update_fields()
        .with_colors([color(colour::MOMENT)])
        .with_radii([thin]);
    stream.log_static("column/hinges", &arcs)?;
    let heads = Arrows3D::update_fields()
        .with_colors([color(colour::MOMENT)])
        .with_radii([radius(0.008 * drawing.lengths.total())]);
    stream.log_static("column/hinges", &heads)?;
    let spring = LineStrips3D::update_fields()
        .with_colors([color(colour::SUPPORT)])
        .with_radii([radius(0.003 * drawing.lengths.total())]);
    stream.log_static("top", &spring)?;
    send_vehicle_statics(stream, drawing)
}

fn send_vehicle_statics(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    let radius = |part: f64| Radius::new_scene_units((part * drawing.lengths.total()) as f32);
    let hull = Mesh3D::update_fields()
        .with_triangle_indices(hull_triangles())
        .with_albedo_factor(HULL_TINT);
    stream.log_static("vehicle", &hull)?;
    let edges = LineStrips3D::update_fields()
        .with_colors([color(colour::VEHICLE_EDGE)])
        .with_radii([radius(0.0022)]);
    stream.log_static("vehicle", &edges)?;
    let boxes = Boxes3D::update_fields().with_fill_mode(FillMode::TransparentFillMajorWireframe);
    stream.log_static("vehicle", &boxes)?;
    let wheels = Cylinders3D::update_fields()
        .with_lengths([2.0 * HALF_WHEEL as f32])
        .with_colors([color(colour::WHEEL)])
        .with_fill_mode(FillMode::Solid);
    stream.log_static("vehicle", &wheels)?;
    let labels = Points3D::update_fields()
        .with_radii([radius(0.0)])
        .with_show_labels(true);
    stream.log_static("vehicle", &labels)?;
    let contact = Arrows3D::update_fields()
        .with_colors([color(colour::CONTACT)])
        .with_radii([radius(0.006)]);
    stream.log_static("vehicle", &contact)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_top_that_creeps_is_drawn_again() {
        let mut shown = ShownTop::default();
        let at = |height: f32| [0.0, 0.0, height];
        let heights = [4.0, 4.0, 3.999_96, 3.999_92, 3.999_88, 3.999_84, 4.0];
        let drawn = heights.map(|it| shown.update(at(it)));
        assert_eq!(drawn, [true, false, false, false, true, false, true]);
    }
}
