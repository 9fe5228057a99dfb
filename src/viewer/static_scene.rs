//! The parts of the scene that do not move: undeformed column, supports and yield surfaces.

use rerun::{
    Arrows3D, Boxes3D, FillMode, LineStrips2D, LineStrips3D, Points2D, Points3D, Radius,
    RecordingStreamResult, ViewCoordinates,
};

use super::branch::Branch;
use super::colour;
use super::point::Point3;
use super::rerun_types::color;
use super::scene::{Drawing, in_space};
use crate::column::{HINGE_NAMES, YieldExponents};
use crate::parameters::SupportKind;
use crate::shape::{PlanePoint, yield_curve};

/// Number of pieces of a yield surface.
const SURFACE_PIECES: u32 = 180;

/// Half the width of the plate on the top and of the supports \[m\].
const HALF_PLATE: f64 = 0.5;

/// The entity of a part of a hinge's yield surface.
pub fn stress_entity(hinge: usize, what: &str) -> String {
    format!("yield/{}/{what}", HINGE_NAMES[hinge])
}

/// The head of an arc: a short arrow along its end, `[origin, vector]`; zero if the arc is too short.
#[must_use]
pub fn arc_head(arc: &[Point3]) -> (Point3, Point3) {
    let (Some(from), Some(end)) = (arc.get(arc.len().saturating_sub(4)), arc.last()) else {
        return ([0.0; 3], [0.0; 3]);
    };
    let mut vector = [0.0; 3];
    for (axis, value) in vector.iter_mut().enumerate() {
        *value = end[axis] - from[axis];
    }
    (*from, vector)
}

/// Logs the static scene.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send(
    stream: &Branch,
    drawing: &Drawing,
    exponents: YieldExponents,
) -> RecordingStreamResult<()> {
    stream.log_static("/", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    ghost(stream, drawing)?;
    base(stream, drawing)?;
    top(stream, drawing)?;
    surfaces(stream, exponents)
}

fn metres(value: f64) -> Radius {
    Radius::new_scene_units(value as f32)
}

fn lines(
    stream: &Branch,
    entity: &str,
    strips: Vec<Vec<Point3>>,
    rgb: colour::Rgb,
    radius: f64,
) -> RecordingStreamResult<()> {
    let lines = LineStrips3D::new(strips)
        .with_colors([color(rgb)])
        .with_radii([metres(radius)]);
    stream.log_static(entity, &lines)
}

/// The undeformed column, drawn by the outermost points of its section.
fn ghost(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    let height = drawing.lengths.total() as f32;
    let quarters = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
    let edges = quarters.map(|it| drawing.outline.farthest(it).map(|it| it as f32));
    let mut strips: Vec<Vec<Point3>> = edges
        .iter()
        .map(|[x, y]| vec![[*x, *y, 0.0], [*x, *y, height]])
        .collect();
    for flange in edges.chunks(2) {
        let end = flange.iter().map(|[x, y]| [*x, *y, height]);
        strips.push(end.collect());
    }
    lines(stream, "ghost", strips, colour::GHOST, 0.004)
}

/// The hatching of a fixed line from `from` to `to`, on the side `away`.
fn hatch(from: PlanePoint, to: PlanePoint, away: PlanePoint) -> Vec<Vec<Point3>> {
    const STROKES: i32 = 9;
    let along = to.plus(-1.0, from);
    let mut strips = vec![vec![in_space(from, 0.0), in_space(to, 0.0)]];
    strips.extend((0..STROKES).map(|stroke| {
        let foot = from.plus((f64::from(stroke) + 0.7) / f64::from(STROKES), along);
        let end = foot.plus(-0.7 / f64::from(STROKES), along).plus(1.0, away);
        vec![in_space(foot, 0.0), in_space(end, 0.0)]
    }));
    strips
}

/// A pin of this radius, which ends on both sides of the web.
fn pin(radius: f64) -> [Vec<Point3>; 2] {
    [-0.02, 0.02].map(|y| {
        let points = (0..=24).map(|piece| {
            let angle = std::f64::consts::TAU * f64::from(piece) / 24.0;
            let offset = PlanePoint::new(angle.cos(), angle.sin());
            in_space(PlanePoint::default().plus(radius, offset), y)
        });
        points.collect()
    })
}

/// Draws the base: built in as a block, pinned as a triangle with a pin, semi-rigid as a block with a spiral.
fn base(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    let down = PlanePoint::new(0.0, -0.1);
    let ground = |z: f64| {
        (
            PlanePoint::new(-HALF_PLATE, z),
            PlanePoint::new(HALF_PLATE, z),
        )
    };
    let mut strips = Vec::new();
    let below = if drawing.base == SupportKind::Pinned {
        let apex = in_space(PlanePoint::default(), 0.0);
        let feet = [-0.2, 0.2].map(|x| in_space(PlanePoint::new(x, -0.3), 0.0));
        strips.push(vec![apex, feet[0], feet[1], apex]);
        strips.extend(pin(0.05));
        -0.3
    } else {
        let block = Boxes3D::from_centers_and_half_sizes(
            [[0.0, 0.0, -0.06]],
            [[HALF_PLATE as f32, HALF_PLATE as f32, 0.06]],
        )
        .with_colors([color(colour::AXIS)])
        .with_fill_mode(FillMode::Solid);
        stream.log_static("supports/block", &block)?;
        -0.12
    };
    if drawing.base == SupportKind::SemiRigid {
        strips.extend(spirals(PlanePoint::default(), drawing.half_depth()));
    }
    let (from, to) = ground(below);
    strips.extend(hatch(from, to, down));
    lines(stream, "supports/base", strips, colour::SUPPORT, 0.008)
}

/// The symbol of a rotational spring, on either side of the web.
fn spirals(centre: PlanePoint, half_depth: f64) -> [Vec<Point3>; 2] {
    [-0.02, 0.02].map(|side| {
        let each = (0..=60).map(|piece| {
            let part = f64::from(piece) / 60.0;
            let angle = 2.5 * std::f64::consts::TAU * part;
            let radius = half_depth * (1.2 + part);
            let offset = PlanePoint::new(angle.cos(), angle.sin());
            in_space(centre.plus(radius, offset), side)
        });
        each.collect()
    })
}

/// Draws the plate that slides along two guides, the support of the spring, and the load; nothing at a free top.
fn top(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    if drawing.top == SupportKind::Free {
        return Ok(());
    }
    let height = drawing.lengths.total();
    let plate = Boxes3D::from_centers_and_half_sizes(
        [[0.0, 0.0, 0.02]],
        [[HALF_PLATE as f32 - 0.03, 0.12, 0.02]],
    )
    .with_colors([color(colour::SUPPORT)])
    .with_fill_mode(FillMode::Solid);
    stream.log_static("top/plate", &plate)?;
    let mut moving = Vec::new();
    match drawing.top {
        SupportKind::Pinned => moving.extend(pin(0.06)),
        SupportKind::SemiRigid => {
            moving.extend(spirals(PlanePoint::default(), drawing.half_depth()))
        }
        SupportKind::BuiltIn | SupportKind::Free => {}
    }
    lines(stream, "top/support", moving, colour::SUPPORT, 0.008)?;
    let mut fixed = Vec::new();
    for side in [-HALF_PLATE, HALF_PLATE] {
        let from = PlanePoint::new(side, height - 0.3);
        let to = PlanePoint::new(side, height + 0.15);
        fixed.extend(hatch(from, to, PlanePoint::new(0.2 * side, 0.0)));
    }
    if drawing.spring_stiffness > 0.0 {
        let (end, beside) = (drawing.spring_end(), Drawing::spring_offset());
        let from = PlanePoint::new(beside - 0.2, end);
        let to = PlanePoint::new(beside + 0.2, end);
        fixed.extend(hatch(from, to, PlanePoint::new(0.0, 0.08)));
    }
    lines(stream, "supports/top", fixed, colour::SUPPORT, 0.008)?;
    send_load(stream, drawing)
}

/// Logs the load on the top, whose label is on the side of the vehicle that hits the column last.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send_load(stream: &Branch, drawing: &Drawing) -> RecordingStreamResult<()> {
    let load = drawing.load_arrow();
    let arrows = Arrows3D::from_vectors(load.iter().map(|it| it.vector))
        .with_origins(load.iter().map(|it| it.origin))
        .with_colors([color(colour::TOP)])
        .with_radii([metres(0.006 * drawing.lengths.total())]);
    stream.log_static("top/load", &arrows)?;
    let label = Points3D::new(load.iter().map(|it| it.label.place))
        .with_labels(load.iter().map(|it| it.label.text.as_str()))
        .with_colors([color(colour::TOP)])
        .with_radii([metres(0.0)])
        .with_show_labels(true);
    stream.log_static("top/load", &label)
}

fn surfaces(stream: &Branch, exponents: YieldExponents) -> RecordingStreamResult<()> {
    let surface = LineStrips2D::new([yield_curve(exponents, SURFACE_PIECES)
        .map(|point| point.map(|it| it as f32))
        .collect::<Vec<_>>()])
    .with_colors([color(colour::SURFACE)])
    .with_radii([Radius::new_ui_points(1.0)]);
    let axes = LineStrips2D::new([[[-1.15_f32, 0.0], [1.15, 0.0]], [[0.0, -1.15], [0.0, 1.15]]])
        .with_colors([color(colour::AXIS)])
        .with_radii([Radius::new_ui_points(0.7)]);
    let names = Points2D::new([[1.24_f32, 0.0], [0.0, -1.45]])
        .with_labels(["M/Mp", "-N/Np"])
        .with_colors([color(colour::SURFACE)])
        .with_radii([Radius::new_ui_points(0.0)])
        .with_show_labels(true);
    for hinge in 0..HINGE_NAMES.len() {
        stream.log_static(stress_entity(hinge, "surface"), &surface)?;
        stream.log_static(stress_entity(hinge, "axes"), &axes)?;
        stream.log_static(stress_entity(hinge, "names"), &names)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_lies_along_the_end_of_its_arc() {
        let arc = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 1.0]];
        assert_eq!(arc_head(&arc), ([0.0; 3], [3.0, 0.0, 1.0]));
        assert_eq!(arc_head(&[]), ([0.0; 3], [0.0; 3]));
    }
}
