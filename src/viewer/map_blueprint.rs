//! The layout of damage maps in the viewer: the image of each variant with its boundaries and axes, and beside it what they mean.
//!
//! Without a layout the viewer shows the image alone, because an image is the origin of a view of its own.

use rerun::blueprint::components::{ContainerKind, IncludedContent, PanelState, VisualBounds2D};
use rerun::datatypes::Range2D;
use rerun::external::re_log_types::LogMsg;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, TimePanelBlueprint, VisualBounds2D as VisualBounds,
};
use rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamResult};

use super::blueprint::{Blueprint, activate};

/// Most variants that have views: more do not fit a screen.
const MAX_VARIANTS: u8 = 24;

/// Numbers that identify the containers and views.
const ROOT: u8 = 1;
const FIRST_VARIANT: u8 = 10;
const FIRST_MAP: u8 = 40;
const FIRST_LEGEND: u8 = 80;

/// Margins beside an image for the numbers of its axes, relative to its size: left, right, top, bottom.
const MARGINS: [f64; 4] = [0.16, 0.05, 0.06, 0.14];

/// Sends the layout for maps with these labels, `map_0` and so on, whose images have this width and height.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send(
    recording: &RecordingStream,
    application: &'static str,
    labels: &[&str],
    size: [f64; 2],
) -> RecordingStreamResult<()> {
    let messages = messages(application, labels, size)?;
    activate(recording, messages);
    Ok(())
}

fn messages(
    application: &'static str,
    labels: &[&str],
    size: [f64; 2],
) -> RecordingStreamResult<Vec<LogMsg>> {
    let (stream, storage) = RecordingStreamBuilder::new(application)
        .enabled(true)
        .blueprint()
        .memory()?;
    stream.set_time_sequence("blueprint", 0);
    let blueprint = Blueprint::new(stream);
    let included = |path: String| IncludedContent(path.as_str().into());
    let [width, height] = size;
    let [left, right, top, bottom] = MARGINS;
    let bounds = VisualBounds::new(VisualBounds2D(Range2D {
        x_range: [-left * width, (1.0 + right) * width].into(),
        y_range: [-top * height, (1.0 + bottom) * height].into(),
    }));
    let numbered: Vec<_> = (0..MAX_VARIANTS).zip(labels).collect();
    for (variant, label) in &numbered {
        let (map, legend) = (FIRST_MAP + variant, FIRST_LEGEND + variant);
        let origin = format!("/map_{variant}");
        blueprint.view(map, "2D", label, &origin, &["+ $origin/**".to_owned()])?;
        blueprint.property(map, "VisualBounds2D", &bounds)?;
        let contents = [format!("+ /legend_{variant}")];
        blueprint.view(legend, "TextDocument", "Legend", "/", &contents)?;
        let both = ContainerBlueprint::new(ContainerKind::Horizontal)
            .with_contents([
                included(blueprint.view_path(map)),
                included(blueprint.view_path(legend)),
            ])
            .with_col_shares([0.75_f32, 0.25]);
        blueprint.write(&blueprint.container_path(FIRST_VARIANT + variant), &both)?;
    }
    let all = numbered
        .iter()
        .map(|(variant, _)| included(blueprint.container_path(FIRST_VARIANT + variant)));
    let root = ContainerBlueprint::new(ContainerKind::Grid).with_contents(all);
    blueprint.write(&blueprint.container_path(ROOT), &root)?;
    blueprint.viewport(ROOT)?;
    for panel in ["blueprint_panel", "selection_panel"] {
        let hidden = PanelBlueprint::new().with_state(PanelState::Collapsed);
        blueprint.write(panel, &hidden)?;
    }
    // A map has no time.
    let time = TimePanelBlueprint::new().with_state(PanelState::Hidden);
    blueprint.write("time_panel", &time)?;
    Ok(storage.take())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rerun::log::Chunk;

    #[test]
    fn every_variant_has_a_view_of_all_its_parts_and_a_legend() {
        let messages = messages("test", &["a", "b"], [10.0, 20.0]).expect("written");
        let chunks = messages.iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(_, data) => Chunk::from_arrow_msg(data).ok(),
            _ => None,
        });
        let entities: Vec<_> = chunks.map(|it| it.entity_path().to_string()).collect();
        let (stream, _storage) = RecordingStreamBuilder::new("test")
            .enabled(true)
            .blueprint()
            .memory()
            .expect("a stream");
        let names = Blueprint::new(stream);
        let has = |number| entities.contains(&format!("/{}", names.view_path(number)));
        for number in [FIRST_MAP, FIRST_MAP + 1, FIRST_LEGEND, FIRST_LEGEND + 1] {
            assert!(has(number), "{entities:?}");
        }
        assert!(!has(FIRST_MAP + 2));
    }
}
