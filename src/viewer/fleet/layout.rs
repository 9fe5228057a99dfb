//! The layout of a fleet in the viewer: on the left the plan with its legend, the columns that need somebody and the log; on the
//! right, in tabs, the column that was hit last and those that are selected.

use rerun::blueprint::components::{BackgroundKind, VisualBounds2D};
use rerun::datatypes::Range2D;
use rerun::external::re_log_types::LogMsg;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, VisualBounds2D as VisualBounds,
};
use rerun::{RecordingStreamBuilder, RecordingStreamResult};

use super::overview::{Geometry, LEGEND, PAPER, PLAN, legend_bounds};
use super::panel::PANEL;
use crate::viewer::blueprint::{
    APPLICATION, Blueprint, COLUMN, ColumnLayout, horizontal, tabs, vertical,
};
use crate::viewer::rerun_types::color;

/// The entity of the log.
pub(super) const LOG: &str = "overview/log";

/// Numbers that identify the containers and views, beside those of the columns, which are in slots of their own.
const ROOT: u8 = 1;
const LEFT: u8 = 2;
const BELOW: u8 = 3;
const RIGHT: u8 = 4;
const PLAN_VIEW: u8 = 10;
const LEGEND_VIEW: u8 = 11;
const PANEL_VIEW: u8 = 12;
const LOG_VIEW: u8 = 13;

/// The data of the layout with these columns in full, each with the number of its slot; the first one is in front.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn messages(
    title: &str,
    geometry: &Geometry,
    in_full: &[(u8, ColumnLayout<'_>)],
    follows: bool,
) -> RecordingStreamResult<Vec<LogMsg>> {
    let (stream, storage) = RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .blueprint()
        .memory()?;
    stream.set_time_sequence("blueprint", 0);
    let blueprint = Blueprint::new(stream);
    plane(&blueprint, PLAN_VIEW, title, PLAN, geometry.bounds())?;
    plane(&blueprint, LEGEND_VIEW, "Legend", LEGEND, legend_bounds())?;
    let panel = [format!("+ /{PANEL}")];
    blueprint.view(PANEL_VIEW, "TextDocument", "Columns", "/", &panel)?;
    let log = [format!("+ /{LOG}")];
    blueprint.view(
        LOG_VIEW,
        "TextLog",
        "Events by time since impact",
        "/",
        &log,
    )?;
    blueprint.log_columns(LOG_VIEW)?;
    let below = horizontal([PANEL_VIEW, LOG_VIEW].map(|it| blueprint.view_path(it)));
    blueprint.write(&blueprint.container_path(BELOW), &below)?;
    let left = vertical([
        blueprint.view_path(PLAN_VIEW),
        blueprint.view_path(LEGEND_VIEW),
        blueprint.container_path(BELOW),
    ])
    .with_row_shares([0.6_f32, 0.1, 0.3]);
    blueprint.write(&blueprint.container_path(LEFT), &left)?;
    let mut columns = Vec::new();
    for (slot, layout) in in_full {
        let column = blueprint.of_column(*slot, layout.root);
        column.column(layout)?;
        columns.push(column.container_path(COLUMN));
    }
    if columns.is_empty() {
        blueprint.viewport(LEFT)?;
    } else {
        blueprint.write(&blueprint.container_path(RIGHT), &tabs(columns))?;
        let root = horizontal([LEFT, RIGHT].map(|it| blueprint.container_path(it)))
            .with_col_shares([0.46_f32, 0.54]);
        blueprint.write(&blueprint.container_path(ROOT), &root)?;
        blueprint.viewport(ROOT)?;
    }
    blueprint.panels(follows)?;
    Ok(storage.take())
}

/// A view of a plane on paper.
fn plane(
    blueprint: &Blueprint,
    number: u8,
    title: &str,
    entity: &str,
    [left, right, top, bottom]: [f64; 4],
) -> RecordingStreamResult<()> {
    let origin = format!("/{entity}");
    blueprint.view(number, "2D", title, &origin, &["+ $origin/**".to_owned()])?;
    let bounds = VisualBounds::new(VisualBounds2D(Range2D {
        x_range: [left, right].into(),
        y_range: [top, bottom].into(),
    }));
    blueprint.property(number, "VisualBounds2D", &bounds)?;
    let paper = Background::new(BackgroundKind::SolidColor).with_color(color(PAPER));
    blueprint.property(number, "Background", &paper)
}
