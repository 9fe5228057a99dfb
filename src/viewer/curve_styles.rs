//! How the curves look.

use rerun::{LineStrips2D, Points2D, Radius, RecordingStreamResult, SeriesLines, SeriesPoints};

use super::branch::Branch;
use super::colour;
use super::plots;
use super::rerun_types::color;
use super::static_scene;
use crate::column::HINGES;

/// Width of the path of the vehicle \[points\]: it shows on both sides of that of the column, which lies on it in contact.
const VEHICLE_WIDTH: f32 = 5.0;

/// Writes names, colours and widths of the curves.
pub(super) fn send(stream: &Branch) -> RecordingStreamResult<()> {
    for plot in &plots::ALL {
        let last = plot.curves.len() - 1;
        let widths = (0..=last).map(|index| if index == last { plot.last_width } else { 1.5 });
        let lines = SeriesLines::new()
            .with_names(plot.curves.iter().map(|(name, _)| *name))
            .with_colors(plot.curves.iter().map(|(_, rgb)| color(*rgb)))
            .with_widths(widths);
        stream.log_static(plot.entity, &lines)?;
    }
    let (name, rgb) = plots::VEHICLE;
    let vehicle = SeriesLines::new()
        .with_names([name])
        .with_colors([color(rgb)])
        .with_widths([VEHICLE_WIDTH]);
    stream.log_static(plots::VEHICLE_PATH, &vehicle)?;
    let springs = plots::SPRINGS_BEHIND;
    let lines = SeriesLines::new()
        .with_names(springs.map(|(name, _)| name))
        .with_colors(springs.map(|(_, rgb)| color(rgb)))
        .with_widths([1.5]);
    stream.log_static(plots::SPRING_FORCES, &lines)?;
    let marks = SeriesPoints::new()
        .with_names(["impact impulse (not to scale)"])
        .with_colors([color(colour::PLASTIC)])
        .with_markers([rerun::components::MarkerShape::Down])
        .with_marker_sizes([6.0]);
    stream.log_static(plots::IMPACT_IMPULSES, &marks)?;
    for hinge in 0..HINGES {
        let path = LineStrips2D::update_fields()
            .with_colors([color(colour::HINGE[hinge])])
            .with_radii([Radius::new_ui_points(1.5)]);
        stream.log_static(static_scene::stress_entity(hinge, "path"), &path)?;
        let now = Points2D::update_fields().with_radii([Radius::new_ui_points(5.0)]);
        stream.log_static(static_scene::stress_entity(hinge, "now"), &now)?;
    }
    Ok(())
}
