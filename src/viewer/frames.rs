//! Frames of the scene in a Rerun stream: the column, its hinges, its top and the vehicle.

use rerun::components::Translation3D;
use rerun::{
    Arrows3D, Boxes3D, FillMode, LineStrip3D, LineStrips3D, Mesh3D, Points3D, Radius,
    RecordingStream, RecordingStreamResult, Transform3D,
};

use super::colour;
use super::rerun_types::{color, time_columns};
use super::scene::{Drawing, Point3, Scene, VEHICLE};
use super::static_scene;
use super::timeline::Moment;
use crate::column::HINGES;
use crate::shape::Solid;

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
    stream: &RecordingStream,
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
            marks.chain(labels.map(|it| (it.label_place, it.colour, it.label.as_str())))
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

    let there: Vec<_> = scenes()
        .map(|it| usize::from(it.vehicle.is_some()))
        .collect();
    let bodies = || scenes().filter_map(|it| it.vehicle.as_ref());
    let vehicle = Boxes3D::update_fields()
        .with_centers(bodies().map(|it| it.centre))
        .with_half_sizes(bodies().map(|_| VEHICLE.map(|it| 0.5 * it as f32)));
    let label = Points3D::update_fields()
        .with_positions(bodies().map(|it| it.label_place))
        .with_labels(bodies().map(|it| it.label.as_str()));
    let touching = scenes()
        .map(|it| usize::from(it.contact.is_some()))
        .collect::<Vec<_>>();
    let forces = || scenes().filter_map(|it| it.contact.as_ref());
    let contact = Arrows3D::update_fields()
        .with_origins(forces().map(|it| it.origin))
        .with_vectors(forces().map(|it| it.vector))
        .with_labels(forces().map(|it| it.label.as_str()));
    let vehicle = vehicle
        .columns(there.clone())?
        .chain(label.columns(there)?)
        .chain(contact.columns(touching)?);
    send("vehicle", vehicle.collect())
}

/// Sends what all frames of one column share: colours, sizes and the triangles of the steel.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send_statics(
    stream: &RecordingStream,
    drawing: &Drawing,
) -> RecordingStreamResult<()> {
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
    let vehicle = Boxes3D::update_fields()
        .with_colors([color(colour::IMPACTOR)])
        .with_fill_mode(FillMode::TransparentFillMajorWireframe);
    stream.log_static("vehicle", &vehicle)?;
    let label = Points3D::update_fields()
        .with_colors([color(colour::IMPACTOR)])
        .with_radii([radius(0.0)])
        .with_show_labels(true);
    stream.log_static("vehicle", &label)?;
    let contact = Arrows3D::update_fields()
        .with_colors([color(colour::CONTACT)])
        .with_radii([radius(0.006 * drawing.lengths.total())])
        .with_show_labels(true);
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
