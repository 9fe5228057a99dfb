//! The layout of the viewer, for a laptop screen: column, panel and log on the left, curves in the middle, yield surfaces on
//! the right. Crush and force-crush diagram are shown if the vehicle crushes. With sensors, what they feel is in the middle, and the
//! curves are in a second tab.
//!
//! Rerun's blueprint API for Rust can set neither the eye nor the bounds of a view nor the range of an axis. This module
//! therefore logs the blueprint archetypes one by one, as the API itself does.

use rerun::blueprint::components::{
    BackgroundKind, ContainerKind, Eye3DKind, IncludedContent, LockRangeDuringZoom, LoopMode,
    PanelState, PlayState, PlaybackSpeed, RootContainer, TimelineName, VisibleTimeRange,
    VisualBounds2D,
};
use rerun::blueprint::datatypes::{TextLogColumn, TextLogColumnKind, TimelineColumn};
use rerun::components::Range1D;
use rerun::datatypes::{
    self, Range2D, TimeInt, TimeRange, TimeRangeBoundary, Utf8, VisibleTimeRange as TimeWindow,
};
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend,
    ScalarAxis, TextLogColumns, TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
    VisibleTimeRanges, VisualBounds2D as VisualBounds,
};
use rerun::{AsComponents, RecordingStream, RecordingStreamBuilder, RecordingStreamResult};

use super::felt_views::{FeltView, MAX_SENSOR_VIEWS};
use super::force_crush;
use super::panel::PANEL;
use super::plots::{self, PLOTS};
use super::rerun_types::color;
use super::scene::Drawing;
use super::static_scene::stress_entity;
use super::timeline::IMPACT_TIME;
use crate::column::{HINGE_NAMES, HINGES};

/// Name of this application in the viewer.
pub const APPLICATION: &str = "column_twin";

/// Playback speed relative to real time: an impact takes about 60 ms.
const PLAYBACK_SPEED: f64 = 0.01;

/// Numbers that identify the containers and views of the blueprint.
const ROOT: u8 = 1;
const LEFT: u8 = 2;
const MIDDLE: u8 = 3;
const RIGHT: u8 = 4;
const BELOW: u8 = 5;
const CURVES: u8 = 6;
const FELT: u8 = 7;
const SCENE: u8 = 10;
const LOG: u8 = 11;
const TEXT: u8 = 12;
const FORCE_CRUSH: u8 = 13;
const FIRST_PLOT: u8 = 20;
const FIRST_HINGE: u8 = 40;
const FIRST_FELT: u8 = 60;

// The numbers of the views of what is felt: forecast, momentum, severity, and sensors.
const _: () = assert!(FIRST_FELT as usize + 3 + MAX_SENSOR_VIEWS <= u8::MAX as usize);

/// Sends the blueprint and activates it.
///
/// # Errors
/// The stream rejects the data.
pub fn send(
    recording: &RecordingStream,
    drawing: &Drawing,
    axes: &[[f64; 2]; PLOTS],
    felt: &[FeltView],
    follows: bool,
) -> RecordingStreamResult<()> {
    activate(recording, messages(drawing, axes, felt, follows)?);
    Ok(())
}

/// Sends the data of a blueprint, which becomes the one that is shown.
pub(super) fn activate(recording: &RecordingStream, messages: Vec<LogMsg>) {
    let store = messages.iter().find_map(|message| match message {
        LogMsg::SetStoreInfo(info) => Some(info.info.store_id.clone()),
        _ => None,
    });
    if let Some(blueprint_id) = store {
        let activation = BlueprintActivationCommand {
            blueprint_id,
            make_active: true,
            make_default: true,
        };
        recording.send_blueprint(messages, activation);
    }
}

/// The data of the blueprint.
fn messages(
    drawing: &Drawing,
    axes: &[[f64; 2]; PLOTS],
    felt: &[FeltView],
    follows: bool,
) -> RecordingStreamResult<Vec<LogMsg>> {
    let (stream, storage) = RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .blueprint()
        .memory()?;
    stream.set_time_sequence("blueprint", 0);
    let blueprint = Blueprint { stream };
    let crushes = drawing.vehicle.is_real();
    blueprint.layout(crushes, felt.len())?;
    blueprint.scene(drawing)?;
    blueprint.panel()?;
    blueprint.log()?;
    for (number, axis) in (0..).zip(axes) {
        if shown(number, crushes) {
            blueprint.plot(number, *axis)?;
        }
    }
    for (number, view) in (FIRST_FELT..).zip(felt) {
        blueprint.felt(number, view)?;
    }
    if crushes {
        blueprint.force_crush(drawing)?;
    }
    for hinge in 0..HINGES {
        blueprint.yield_surface(hinge)?;
    }
    blueprint.panels(follows)?;
    Ok(storage.take())
}

/// Whether the plot of this number is shown, for a vehicle that crushes or not.
fn shown(plot: u8, crushes: bool) -> bool {
    crushes || !plots::ALL[usize::from(plot)].of_vehicle
}

/// A blueprint that is being written.
pub(super) struct Blueprint {
    pub stream: RecordingStream,
}

/// The UUID with this number.
fn uuid(number: u8) -> String {
    format!("c01c01c0-0000-4000-8000-0000000000{number:02x}")
}

pub(super) fn uuid_bytes(number: u8) -> [u8; 16] {
    [
        0xc0, 0x1c, 0x01, 0xc0, 0, 0, 0x40, 0, 0x80, 0, 0, 0, 0, 0, 0, number,
    ]
}

pub(super) fn view(number: u8) -> String {
    format!("view/{}", uuid(number))
}

pub(super) fn container(number: u8) -> String {
    format!("container/{}", uuid(number))
}

impl Blueprint {
    pub fn write(&self, path: &str, what: &dyn AsComponents) -> RecordingStreamResult<()> {
        self.stream.log(path, what)
    }

    fn layout(&self, crushes: bool, felt: usize) -> RecordingStreamResult<()> {
        let plots = (0..PLOTS as u8).filter(|number| shown(*number, crushes));
        let plots = plots.map(|number| view(FIRST_PLOT + number));
        let plots = plots.chain(crushes.then(|| view(FORCE_CRUSH)));
        let hinges = (0..HINGES as u8).map(|hinge| view(FIRST_HINGE + hinge));
        let contents = |paths: Vec<String>| {
            let paths = paths.into_iter();
            paths
                .map(|path| IncludedContent(path.as_str().into()))
                .collect::<Vec<_>>()
        };
        let left = ContainerBlueprint::new(ContainerKind::Vertical)
            .with_contents(contents(vec![view(SCENE), container(BELOW)]))
            .with_row_shares([0.62_f32, 0.38]);
        self.write(&container(LEFT), &left)?;
        let below = ContainerBlueprint::new(ContainerKind::Horizontal)
            .with_contents(contents(vec![view(TEXT), view(LOG)]))
            .with_col_shares([0.6_f32, 0.4]);
        self.write(&container(BELOW), &below)?;
        let grid = |paths: Vec<String>| {
            ContainerBlueprint::new(ContainerKind::Grid)
                .with_contents(contents(paths))
                .with_grid_columns(2_u32)
        };
        let curves = grid(plots.collect());
        if felt == 0 {
            self.write(&container(MIDDLE), &curves)?;
        } else {
            let felt = (FIRST_FELT..).take(felt).map(view);
            let felt = grid(felt.collect()).with_display_name("Sensors");
            self.write(&container(FELT), &felt)?;
            let curves = curves.with_display_name("Column");
            self.write(&container(CURVES), &curves)?;
            let middle = ContainerBlueprint::new(ContainerKind::Tabs)
                .with_contents(contents(vec![container(FELT), container(CURVES)]))
                .with_active_tab(container(FELT).as_str());
            self.write(&container(MIDDLE), &middle)?;
        }
        let right = ContainerBlueprint::new(ContainerKind::Vertical)
            .with_contents(contents(hinges.collect()));
        self.write(&container(RIGHT), &right)?;
        let root = ContainerBlueprint::new(ContainerKind::Horizontal)
            .with_contents(contents(vec![
                container(LEFT),
                container(MIDDLE),
                container(RIGHT),
            ]))
            .with_col_shares([0.45_f32, 0.39, 0.16]);
        self.write(&container(ROOT), &root)?;
        let viewport = ViewportBlueprint::new()
            .with_root_container(RootContainer(uuid_bytes(ROOT).into()))
            .with_auto_layout(false)
            .with_auto_views(false);
        self.write("viewport", &viewport)
    }

    pub fn view(
        &self,
        number: u8,
        class: &str,
        title: &str,
        origin: &str,
        contents: &[String],
    ) -> RecordingStreamResult<()> {
        let path = view(number);
        let query = ViewContents::new(contents.iter().map(String::as_str));
        self.write(&format!("{path}/ViewContents"), &query)?;
        let it = ViewBlueprint::new(class)
            .with_display_name(title)
            .with_space_origin(origin);
        self.write(&path, &it)
    }

    pub fn property(
        &self,
        number: u8,
        name: &str,
        what: &dyn AsComponents,
    ) -> RecordingStreamResult<()> {
        self.write(&format!("{}/{name}", view(number)), what)
    }

    /// The column and the vehicle, from where all of it is in the picture.
    fn scene(&self, drawing: &Drawing) -> RecordingStreamResult<()> {
        let title = if drawing.magnification == 1.0 {
            format!("{}, to scale", drawing.section)
        } else {
            format!(
                "{}, displacements x {}",
                drawing.section, drawing.magnification
            )
        };
        let contents = ["column", "top", "supports", "ghost", "vehicle"]
            .iter()
            .map(|it| format!("+ /{it}/**"))
            .collect::<Vec<_>>();
        self.view(SCENE, "3D", &title, "/", &contents)?;
        let camera = drawing.camera();
        let eye = EyeControls3D::new()
            .with_kind(Eye3DKind::Orbital)
            .with_position(camera.eye.map(|it| it as f32))
            .with_look_target(camera.target.map(|it| it as f32))
            .with_eye_up([0.0, 0.0, 1.0]);
        self.property(SCENE, "EyeControls3D", &eye)?;
        let background =
            Background::new(BackgroundKind::SolidColor).with_color(color([22, 24, 28]));
        self.property(SCENE, "Background", &background)?;
        let grid = LineGrid3D::new().with_visible(false);
        self.property(SCENE, "LineGrid3D", &grid)
    }

    fn panel(&self) -> RecordingStreamResult<()> {
        let contents = [format!("+ /{PANEL}")];
        self.view(
            TEXT,
            "TextDocument",
            "Assessment and legend",
            "/",
            &contents,
        )
    }

    /// Force over crush of the vehicle's springs: the paths up to the present time.
    fn force_crush(&self, drawing: &Drawing) -> RecordingStreamResult<()> {
        let title = "Force over crush of each spring";
        let contents = ["+ /force_crush/**".to_owned()];
        self.view(FORCE_CRUSH, "2D", title, "/force_crush", &contents)?;
        let [crush, force] = force_crush::extent(drawing.springs.as_ref());
        let bounds = VisualBounds::new(VisualBounds2D(Range2D {
            x_range: [-0.3 * crush, 1.15 * crush].into(),
            y_range: [-1.15 * force, 0.2 * force].into(),
        }));
        self.property(FORCE_CRUSH, "VisualBounds2D", &bounds)?;
        self.until_now(FORCE_CRUSH, force_crush::PATH)
    }

    /// Shows all of an entity up to the present time.
    fn until_now(&self, id: u8, entity: &str) -> RecordingStreamResult<()> {
        let until_now = VisibleTimeRange(TimeWindow {
            timeline: Utf8::from(IMPACT_TIME),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(TimeInt(0)),
            },
        });
        let path = format!("{}/ViewContents/overrides/{entity}/visualizers", view(id));
        self.write(&path, &VisibleTimeRanges::new([until_now]))
    }

    fn log(&self) -> RecordingStreamResult<()> {
        let title = "Events by time since impact";
        self.view(LOG, "TextLog", title, "/", &["+ /log".to_owned()])?;
        let columns = TextLogColumns::new()
            .with_timeline_columns([TimelineColumn {
                timeline: Utf8::from(IMPACT_TIME),
                visible: true.into(),
            }])
            .with_text_log_columns([TextLogColumn {
                kind: TextLogColumnKind::Body,
                visible: true.into(),
            }]);
        self.property(LOG, "TextLogColumns", &columns)
    }

    fn plot(&self, number: u8, axis: [f64; 2]) -> RecordingStreamResult<()> {
        let plot = &plots::ALL[usize::from(number)];
        let id = FIRST_PLOT + number;
        let origin = format!("/{}", plot.entity);
        let mut contents = vec![format!("+ {origin}")];
        if usize::from(number) == plots::CONTACT_FORCE {
            contents.push(format!("+ /{}", plots::PERCUSSIONS));
            contents.push(format!("+ /{}", plots::SPRING_FORCES));
        }
        self.view(id, "TimeSeries", plot.title, "/plots", &contents)?;
        let axis = ScalarAxis::new()
            .with_range(Range1D::new(axis[0], axis[1]))
            .with_zoom_lock(LockRangeDuringZoom(false.into()));
        self.property(id, "ScalarAxis", &axis)?;
        let legend = PlotLegend::new().with_corner(plot.names);
        self.property(id, "PlotLegend", &legend)
    }

    /// Curves about an impact that the sensors feel.
    fn felt(&self, id: u8, view: &FeltView) -> RecordingStreamResult<()> {
        let contents: Vec<_> = view.entities.iter().map(|it| format!("+ /{it}")).collect();
        self.view(id, "TimeSeries", &view.title, "/felt", &contents)?;
        if let Some([low, high]) = view.range {
            let axis = ScalarAxis::new()
                .with_range(Range1D::new(low, high))
                .with_zoom_lock(LockRangeDuringZoom(false.into()));
            self.property(id, "ScalarAxis", &axis)?;
        }
        let legend = PlotLegend::new().with_corner(view.names);
        self.property(id, "PlotLegend", &legend)
    }

    /// Shows the whole path up to the present time; everything else at the present time.
    fn yield_surface(&self, hinge: usize) -> RecordingStreamResult<()> {
        let id = FIRST_HINGE + hinge as u8;
        let title = format!("Hinge {}: M-N [-]", HINGE_NAMES[hinge]);
        let origin = format!("/yield/{}", HINGE_NAMES[hinge]);
        self.view(id, "2D", &title, &origin, &["+ $origin/**".to_owned()])?;
        let bounds = VisualBounds::new(VisualBounds2D(Range2D {
            x_range: [-1.6, 1.6].into(),
            y_range: [-1.5, 1.2].into(),
        }));
        self.property(id, "VisualBounds2D", &bounds)?;
        self.until_now(id, &stress_entity(hinge, "path"))
    }

    fn panels(&self, follows: bool) -> RecordingStreamResult<()> {
        for panel in ["blueprint_panel", "selection_panel"] {
            let hidden = PanelBlueprint::new().with_state(PanelState::Collapsed);
            self.write(panel, &hidden)?;
        }
        let play = if follows {
            PlayState::Following
        } else {
            PlayState::Playing
        };
        let mut time = TimePanelBlueprint::new()
            .with_state(PanelState::Collapsed)
            .with_timeline(TimelineName(Utf8::from(IMPACT_TIME)))
            .with_playback_speed(PlaybackSpeed(datatypes::Float64(PLAYBACK_SPEED)))
            .with_play_state(play);
        // A looping viewer does not follow the latest data.
        if !follows {
            time = time.with_loop_mode(LoopMode::All);
        }
        self.write("time_panel", &time)
    }
}

#[cfg(test)]
mod tests {
    use super::super::felt_views::FeltCurves;
    use super::*;
    use crate::parameters::{Parameters, Value};
    use crate::shape::VehicleBody;
    use rerun::log::Chunk;

    /// The entities of the blueprint for a vehicle.
    fn entities(vehicle: VehicleBody, felt: &[FeltView]) -> Vec<String> {
        let mut drawing = Drawing::new(&Parameters::default());
        drawing.vehicle = vehicle;
        let messages = messages(&drawing, &[[0.0, 1.0]; PLOTS], felt, true).expect("written");
        let chunks = messages.iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(_, data) => Chunk::from_arrow_msg(data).ok(),
            _ => None,
        });
        chunks.map(|it| it.entity_path().to_string()).collect()
    }

    fn has(entities: &[String], number: u8) -> bool {
        entities.contains(&format!("/{}", view(number)))
    }

    /// The panel is always shown; crush and force over crush if the vehicle crushes.
    #[test]
    fn a_vehicle_that_crushes_has_views_of_its_own() {
        let rigid = entities(VehicleBody::rigid_mass(), &[]);
        let car = entities(VehicleBody::assumed(1_719.0, &[0.0]), &[]);
        let of_vehicle = (0..PLOTS).filter(|plot| plots::ALL[*plot].of_vehicle);
        let of_vehicle = of_vehicle.map(|plot| FIRST_PLOT + plot as u8);
        for number in of_vehicle.chain([FORCE_CRUSH]) {
            assert!(!has(&rigid, number) && has(&car, number), "{number}");
        }
        for number in [SCENE, TEXT, LOG, FIRST_PLOT, FIRST_HINGE] {
            assert!(
                has(&rigid, number) && has(&car, number),
                "{number}: {rigid:?}"
            );
        }
    }

    /// Views of what is felt exist only where there are sensors.
    #[test]
    fn sensors_have_views_of_their_own() {
        let names = |count: usize| (0..count).map(|it| format!("s{it}")).collect::<Vec<_>>();
        let views_of = |count: usize| {
            let each = names(count).into_iter().flat_map(|name| {
                let quantity = (format!("sensors.{name}.quantity"), "displacement".into());
                [quantity, (format!("sensors.{name}.height"), 1.0.into())]
            });
            let names = ("sensors.names".to_owned(), Value::from(names(count)));
            let sensors = Parameters::from_values(each.chain([names]));
            FeltCurves::new(&sensors.expect("admissible")).map_or(Vec::new(), |it| it.views())
        };
        for (count, views) in [(0, 0), (3, 6), (40, 3 + MAX_SENSOR_VIEWS)] {
            let found = views_of(count);
            assert_eq!(found.len(), views);
            let entities = entities(VehicleBody::rigid_mass(), &found);
            let shown = (FIRST_FELT..u8::MAX).filter(|number| has(&entities, *number));
            assert_eq!(shown.count(), views);
            let has_tabs = entities.contains(&format!("/{}", container(FELT)));
            assert_eq!(has_tabs, views > 0);
        }
    }

    #[test]
    fn a_uuid_is_the_same_as_text_and_as_bytes() {
        let text: String = uuid_bytes(0x2a)
            .iter()
            .map(|it| format!("{it:02x}"))
            .collect();
        assert_eq!(uuid(0x2a).replace('-', ""), text);
    }
}
