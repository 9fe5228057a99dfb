//! How the curves look.

use rerun::{LineStrips2D, Points2D, Radius, RecordingStreamResult, SeriesLines, SeriesPoints};

use super::branch::Branch;
use super::colour;
use super::plots;
use super::rerun_types::color;
use super::static_scene;
use crate::column::{HINGES, MAX_MASSES};
use crate::observables::{IMPACT_IMPULSE, IMPACTOR, SPRING_FORCE};

/// Width of the path of the vehicle \[points\]: it shows on both sides of that of the column, which lies on it in contact.
const VEHICLE_WIDTH: f32 = 5.0;

/// Writes names, colours and widths of the curves.
pub(super) fn send(stream: &Branch) -> RecordingStreamResult<()> {
    for plot in &plots::ALL {
        let last = plot.colours.len() - 1;
        let widths = (0..=last).map(|index| if index == last { plot.last_width } else { 1.5 });
        let lines = SeriesLines::new()
            .with_names(plot.curve_names())
            .with_colors(plot.colours.iter().map(|rgb| color(*rgb)))
            .with_widths(widths);
        stream.log_static(plot.entity, &lines)?;
    }
    let vehicle = SeriesLines::new()
        .with_names([IMPACTOR.in_plots(0)])
        .with_colors([color(colour::IMPACTOR)])
        .with_widths([VEHICLE_WIDTH]);
    stream.log_static(plots::VEHICLE_PATH, &vehicle)?;
    let springs_behind = 1..MAX_MASSES;
    let lines = SeriesLines::new()
        .with_names(springs_behind.clone().map(|it| SPRING_FORCE.in_plots(it)))
        .with_colors(springs_behind.map(|it| color(colour::SPRING[it])))
        .with_widths([1.5]);
    stream.log_static(plots::SPRING_FORCES, &lines)?;
    let marks = SeriesPoints::new()
        .with_names([IMPACT_IMPULSE.in_plots(0)])
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
