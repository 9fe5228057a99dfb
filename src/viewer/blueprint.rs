//! The layout of the viewer, for a laptop screen: column, panel and log on the left, curves in the middle, yield surfaces on
//! the right. Crush and force-crush diagram are shown if the vehicle crushes. With sensors, what they detect is in the middle, and the
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

use super::beam;
use super::branch::entity;
use super::detected_views::{DetectedView, MAX_SENSOR_VIEWS};
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
/// All views of a column.
pub(super) const COLUMN: u8 = 1;
const LEFT: u8 = 2;
const MIDDLE: u8 = 3;
const RIGHT: u8 = 4;
const BELOW: u8 = 5;
const CURVES: u8 = 6;
const DETECTED: u8 = 7;
const SCENE: u8 = 10;
const LOG: u8 = 11;
const TEXT: u8 = 12;
const FORCE_CRUSH: u8 = 13;
const FIRST_PLOT: u8 = 20;
const FIRST_HINGE: u8 = 40;
const FIRST_DETECTED: u8 = 60;

// The numbers of the views of what is detected: forecast, momentum, action, and sensors.
const _: () = assert!(FIRST_DETECTED as usize + 3 + MAX_SENSOR_VIEWS <= u8::MAX as usize);

/// What the layout of a column depends on.
pub(super) struct ColumnLayout<'a> {
    /// Root of its entities: empty, or with a slash before each part.
    pub root: &'a str,
    /// Its name, if the stream shows several columns.
    pub column_id: Option<&'a str>,
    pub drawing: &'a Drawing,
    pub axes: [[f64; 2]; PLOTS],
    pub detected: Vec<DetectedView>,
}

/// Sends the blueprint of a stream that shows one column, and activates it.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send(
    recording: &RecordingStream,
    layout: &ColumnLayout<'_>,
    follows: bool,
) -> RecordingStreamResult<()> {
    activate(recording, messages(layout, follows)?);
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
fn messages(layout: &ColumnLayout<'_>, follows: bool) -> RecordingStreamResult<Vec<LogMsg>> {
    let (stream, storage) = RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .blueprint()
        .memory()?;
    stream.set_time_sequence("blueprint", 0);
    let blueprint = Blueprint::new(stream);
    blueprint.column(layout)?;
    blueprint.viewport(COLUMN)?;
    blueprint.panels(follows)?;
    Ok(storage.take())
}

/// Whether the plot of this number is shown, for a vehicle that crushes or not.
fn shown(plot: u8, crushes: bool) -> bool {
    crushes || !plots::ALL[usize::from(plot)].is_of_vehicle()
}

/// A blueprint that is being written.
pub(super) struct Blueprint {
    stream: RecordingStream,
    /// Number of the column whose views are written; 0 for what is no column of a fleet.
    slot: u8,
    /// Root of the column's entities.
    root: String,
}

/// The UUID of a container or a view with this number of the column in this slot.
fn uuid(slot: u8, number: u8) -> String {
    format!("c01c01c0-0000-4000-8000-00000000{slot:02x}{number:02x}")
}

fn uuid_bytes(slot: u8, number: u8) -> [u8; 16] {
    [
        0xc0, 0x1c, 0x01, 0xc0, 0, 0, 0x40, 0, 0x80, 0, 0, 0, 0, 0, slot, number,
    ]
}

impl Blueprint {
    /// For a stream of blueprints.
    pub fn new(stream: RecordingStream) -> Self {
        Self {
            stream,
            slot: 0,
            root: String::new(),
        }
    }

    /// The same for the views of the column in a slot, 1 or more, whose entities are below a root.
    pub fn of_column(&self, slot: u8, root: &str) -> Self {
        Self {
            stream: self.stream.clone(),
            slot,
            root: root.to_owned(),
        }
    }

    pub fn view_path(&self, number: u8) -> String {
        format!("view/{}", uuid(self.slot, number))
    }

    pub fn container_path(&self, number: u8) -> String {
        format!("container/{}", uuid(self.slot, number))
    }

    /// An expression for an entity of the column, or for all below it.
    fn content(&self, of: &str) -> String {
        format!("+ {}", entity(&self.root, of))
    }

    /// Shows the container with this number, and nothing else.
    pub fn viewport(&self, root: u8) -> RecordingStreamResult<()> {
        let viewport = ViewportBlueprint::new()
            .with_root_container(RootContainer(uuid_bytes(self.slot, root).into()))
            .with_auto_layout(false)
            .with_auto_views(false);
        self.write("viewport", &viewport)
    }

    /// All views of a column in the container [`COLUMN`].
    pub fn column(&self, layout: &ColumnLayout<'_>) -> RecordingStreamResult<()> {
        let drawing = layout.drawing;
        let crushes = drawing.vehicle.is_real();
        match layout.column_id {
            None => self.layout(crushes, layout.detected.len())?,
            Some(id) => self.layout_in_fleet(id, crushes, layout.detected.len())?,
        }
        self.scene(drawing, layout.column_id)?;
        self.panel()?;
        self.log()?;
        for (number, axis) in (0..).zip(layout.axes) {
            if shown(number, crushes) {
                self.plot(number, axis)?;
            }
        }
        for (number, view) in (FIRST_DETECTED..).zip(&layout.detected) {
            self.detected(number, view)?;
        }
        if crushes {
            self.force_crush(drawing)?;
        }
        for hinge in 0..HINGES {
            self.yield_surface(hinge)?;
        }
        Ok(())
    }

    pub fn write(&self, path: &str, what: &dyn AsComponents) -> RecordingStreamResult<()> {
        self.stream.log(path, what)
    }

    /// The views of the curves and of the vehicle's springs.
    fn plots(&self, crushes: bool) -> Vec<String> {
        let plots = (0..PLOTS as u8).filter(|number| shown(*number, crushes));
        let plots = plots.map(|number| self.view_path(FIRST_PLOT + number));
        plots
            .chain(crushes.then(|| self.view_path(FORCE_CRUSH)))
            .collect()
    }

    fn hinges(&self) -> Vec<String> {
        let hinges = 0..HINGES as u8;
        hinges
            .map(|hinge| self.view_path(FIRST_HINGE + hinge))
            .collect()
    }

    fn detected_views(&self, detected: usize) -> Vec<String> {
        let detected = (FIRST_DETECTED..).take(detected);
        detected.map(|number| self.view_path(number)).collect()
    }

    fn layout(&self, crushes: bool, detected: usize) -> RecordingStreamResult<()> {
        let left = vertical([self.view_path(SCENE), self.container_path(BELOW)])
            .with_row_shares([0.62_f32, 0.38]);
        self.write(&self.container_path(LEFT), &left)?;
        let below =
            horizontal([self.view_path(TEXT), self.view_path(LOG)]).with_col_shares([0.6_f32, 0.4]);
        self.write(&self.container_path(BELOW), &below)?;
        let curves = grid(self.plots(crushes), 2);
        if detected == 0 {
            self.write(&self.container_path(MIDDLE), &curves)?;
        } else {
            let detected = grid(self.detected_views(detected), 2).with_display_name("Sensors");
            self.write(&self.container_path(DETECTED), &detected)?;
            let curves = curves.with_display_name("Column");
            self.write(&self.container_path(CURVES), &curves)?;
            let both = [self.container_path(DETECTED), self.container_path(CURVES)];
            self.write(&self.container_path(MIDDLE), &tabs(both))?;
        }
        self.write(&self.container_path(RIGHT), &vertical(self.hinges()))?;
        let root = horizontal([LEFT, MIDDLE, RIGHT].map(|it| self.container_path(it)))
            .with_col_shares([0.45_f32, 0.39, 0.16]);
        self.write(&self.container_path(COLUMN), &root)
    }

    /// The same in the narrower place beside the plan of a fleet: the scene above, and below it the rest in tabs.
    fn layout_in_fleet(
        &self,
        column_id: &str,
        crushes: bool,
        detected: usize,
    ) -> RecordingStreamResult<()> {
        let above = horizontal([self.view_path(SCENE), self.view_path(TEXT)])
            .with_col_shares([0.6_f32, 0.4]);
        self.write(&self.container_path(LEFT), &above)?;
        let curves = grid(self.plots(crushes), 3).with_display_name("Curves");
        self.write(&self.container_path(CURVES), &curves)?;
        let hinges = grid(self.hinges(), 4).with_display_name("Hinges");
        self.write(&self.container_path(RIGHT), &hinges)?;
        let mut others = Vec::new();
        if detected > 0 {
            let detected = grid(self.detected_views(detected), 3).with_display_name("Sensors");
            self.write(&self.container_path(DETECTED), &detected)?;
            others.push(self.container_path(DETECTED));
        }
        others.extend([CURVES, RIGHT].map(|it| self.container_path(it)));
        others.push(self.view_path(LOG));
        self.write(&self.container_path(MIDDLE), &tabs(others))?;
        let root = vertical([LEFT, MIDDLE].map(|it| self.container_path(it)))
            .with_row_shares([0.55_f32, 0.45])
            .with_display_name(column_id);
        self.write(&self.container_path(COLUMN), &root)
    }

    pub fn view(
        &self,
        number: u8,
        class: &str,
        title: &str,
        origin: &str,
        contents: &[String],
    ) -> RecordingStreamResult<()> {
        let path = self.view_path(number);
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
        self.write(&format!("{}/{name}", self.view_path(number)), what)
    }

    /// The column and the vehicle, from where all of it is in the picture.
    fn scene(&self, drawing: &Drawing, column_id: Option<&str>) -> RecordingStreamResult<()> {
        let title = if drawing.magnification == 1.0 {
            format!("{}, to scale", drawing.section)
        } else {
            format!(
                "{}, displacements x {}",
                drawing.section, drawing.magnification
            )
        };
        let title = match column_id {
            None => title,
            Some(id) => format!("{id}: {title}"),
        };
        let contents = [
            "column",
            "top",
            "supports",
            "ghost",
            "vehicle",
            beam::ENTITIES,
        ]
        .iter()
        .map(|it| self.content(&format!("{it}/**")))
        .collect::<Vec<_>>();
        self.view(SCENE, "3D", &title, &entity(&self.root, ""), &contents)?;
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
        let contents = [self.content(PANEL)];
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
        let contents = [self.content("force_crush/**")];
        let origin = entity(&self.root, "force_crush");
        self.view(FORCE_CRUSH, "2D", title, &origin, &contents)?;
        let [crush, force] = force_crush::extent(drawing.springs.as_ref());
        let bounds = VisualBounds::new(VisualBounds2D(Range2D {
            x_range: [-0.3 * crush, 1.15 * crush].into(),
            y_range: [-1.15 * force, 0.2 * force].into(),
        }));
        self.property(FORCE_CRUSH, "VisualBounds2D", &bounds)?;
        self.until_now(FORCE_CRUSH, force_crush::PATH)
    }

    /// Shows all of an entity up to the present time.
    fn until_now(&self, id: u8, of: &str) -> RecordingStreamResult<()> {
        let until_now = VisibleTimeRange(TimeWindow {
            timeline: Utf8::from(IMPACT_TIME),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(TimeInt(0)),
            },
        });
        let entity = entity(&self.root, of);
        let entity = entity.trim_start_matches('/');
        let path = self.view_path(id);
        let path = format!("{path}/ViewContents/overrides/{entity}/visualizers");
        self.write(&path, &VisibleTimeRanges::new([until_now]))
    }

    fn log(&self) -> RecordingStreamResult<()> {
        let title = "Events by time since impact";
        self.view(LOG, "TextLog", title, "/", &[self.content("log")])?;
        self.log_columns(LOG)
    }

    /// Lets a log show the time since the impact and the text.
    pub fn log_columns(&self, id: u8) -> RecordingStreamResult<()> {
        let columns = TextLogColumns::new()
            .with_timeline_columns([TimelineColumn {
                timeline: Utf8::from(IMPACT_TIME),
                visible: true.into(),
            }])
            .with_text_log_columns([TextLogColumn {
                kind: TextLogColumnKind::Body,
                visible: true.into(),
            }]);
        self.property(id, "TextLogColumns", &columns)
    }

    fn plot(&self, number: u8, axis: [f64; 2]) -> RecordingStreamResult<()> {
        let plot = &plots::ALL[usize::from(number)];
        let id = FIRST_PLOT + number;
        let mut contents = vec![self.content(plot.entity)];
        if usize::from(number) == plots::DISPLACEMENT {
            contents.push(self.content(plots::VEHICLE_PATH));
        }
        if usize::from(number) == plots::CONTACT_FORCE {
            contents.push(self.content(plots::IMPACT_IMPULSES));
            contents.push(self.content(plots::SPRING_FORCES));
        }
        let origin = entity(&self.root, "plots");
        self.view(
            id,
            "TimeSeries",
            &plot.title_with_unit(),
            &origin,
            &contents,
        )?;
        let axis = ScalarAxis::new()
            .with_range(Range1D::new(axis[0], axis[1]))
            .with_zoom_lock(LockRangeDuringZoom(false.into()));
        self.property(id, "ScalarAxis", &axis)?;
        let legend = PlotLegend::new().with_corner(plot.names);
        self.property(id, "PlotLegend", &legend)
    }

    /// Curves about an impact that the sensors detect.
    fn detected(&self, id: u8, view: &DetectedView) -> RecordingStreamResult<()> {
        let contents: Vec<_> = view.entities.iter().map(|it| self.content(it)).collect();
        let origin = entity(&self.root, "detected");
        self.view(id, "TimeSeries", &view.title, &origin, &contents)?;
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
        let title = format!("Hinge {}: yield surface", HINGE_NAMES[hinge]);
        let origin = entity(&self.root, &format!("yield/{}", HINGE_NAMES[hinge]));
        self.view(id, "2D", &title, &origin, &["+ $origin/**".to_owned()])?;
        let bounds = VisualBounds::new(VisualBounds2D(Range2D {
            x_range: [-1.6, 1.6].into(),
            y_range: [-1.5, 1.2].into(),
        }));
        self.property(id, "VisualBounds2D", &bounds)?;
        self.until_now(id, &stress_entity(hinge, "path"))
    }

    pub fn panels(&self, follows: bool) -> RecordingStreamResult<()> {
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

fn included(paths: impl IntoIterator<Item = String>) -> Vec<IncludedContent> {
    let paths = paths.into_iter();
    paths
        .map(|path| IncludedContent(path.as_str().into()))
        .collect()
}

/// Views and containers above one another.
pub(super) fn vertical(paths: impl IntoIterator<Item = String>) -> ContainerBlueprint {
    ContainerBlueprint::new(ContainerKind::Vertical).with_contents(included(paths))
}

/// Views and containers beside one another.
pub(super) fn horizontal(paths: impl IntoIterator<Item = String>) -> ContainerBlueprint {
    ContainerBlueprint::new(ContainerKind::Horizontal).with_contents(included(paths))
}

fn grid(paths: Vec<String>, columns: u32) -> ContainerBlueprint {
    ContainerBlueprint::new(ContainerKind::Grid)
        .with_contents(included(paths))
        .with_grid_columns(columns)
}

/// Views and containers behind one another, the first one in front.
pub(super) fn tabs(paths: impl IntoIterator<Item = String>) -> ContainerBlueprint {
    let paths: Vec<_> = paths.into_iter().collect();
    let first = paths.first().cloned().unwrap_or_default();
    ContainerBlueprint::new(ContainerKind::Tabs)
        .with_contents(included(paths))
        .with_active_tab(first.as_str())
}

#[cfg(test)]
mod tests {
    use super::super::detected_views::DetectedCurves;
    use super::*;
    use crate::parameters::{Parameters, Value};
    use crate::shape::VehicleBody;
    use rerun::log::Chunk;

    /// The entities of the blueprint for a vehicle.
    fn entities(vehicle: VehicleBody, detected: Vec<DetectedView>) -> Vec<String> {
        let mut drawing = Drawing::new(&Parameters::default());
        drawing.vehicle = vehicle;
        let layout = ColumnLayout {
            root: "",
            column_id: None,
            drawing: &drawing,
            axes: [[0.0, 1.0]; PLOTS],
            detected,
        };
        let messages = messages(&layout, true).expect("written");
        let chunks = messages.iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(_, data) => Chunk::from_arrow_msg(data).ok(),
            _ => None,
        });
        chunks.map(|it| it.entity_path().to_string()).collect()
    }

    fn has(entities: &[String], number: u8) -> bool {
        entities.contains(&format!("/view/{}", uuid(0, number)))
    }

    /// The panel is always shown; crush and force over crush if the vehicle crushes.
    #[test]
    fn a_vehicle_that_crushes_has_views_of_its_own() {
        let rigid = entities(VehicleBody::rigid_mass(), Vec::new());
        let car = entities(VehicleBody::assumed(1_719.0, &[0.0]), Vec::new());
        let of_vehicle = (0..PLOTS).filter(|plot| plots::ALL[*plot].is_of_vehicle());
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

    /// Views of what is detected exist only where there are sensors.
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
            DetectedCurves::new(&sensors.expect("admissible")).map_or(Vec::new(), |it| it.views())
        };
        for (count, views) in [(0, 0), (3, 6), (40, 3 + MAX_SENSOR_VIEWS)] {
            let found = views_of(count);
            assert_eq!(found.len(), views);
            let entities = entities(VehicleBody::rigid_mass(), found);
            let shown = (FIRST_DETECTED..u8::MAX).filter(|number| has(&entities, *number));
            assert_eq!(shown.count(), views);
            let has_tabs = entities.contains(&format!("/container/{}", uuid(0, DETECTED)));
            assert_eq!(has_tabs, views > 0);
        }
    }

    #[test]
    fn a_uuid_is_the_same_as_text_and_as_bytes() {
        let text: String = uuid_bytes(0x03, 0x2a)
            .iter()
            .map(|it| format!("{it:02x}"))
            .collect();
        assert_eq!(uuid(0x03, 0x2a).replace('-', ""), text);
    }
}
