//! Writes items to a Rerun stream: static data once, states in batches with one column of data per entity.

use std::sync::Arc;
use std::time::Duration;

use rerun::{RecordingStream, RecordingStreamResult, TextDocument, TextLog};

use super::beam::{self, ShownBeam};
use super::blueprint::{self, ColumnLayout};
use super::branch::Branch;
use super::curve_styles;
use super::curves::Curves;
use super::detected::DetectedUpdate;
use super::detected_views::DetectedCurves;
use super::events::{Event, EventDetector, summary};
use super::force_crush;
use super::frame_budget::FrameBudget;
use super::frames::{self, ShownTop};
use super::item::{Announcement, ViewerItem};
use super::panel::{self, PANEL, Told};
use super::plots::{self, Ranges};
use super::rerun_types::{log_level, time_columns};
use super::scene::{Drawing, Scene};
use super::static_scene;
use super::timeline::{Moment, Placed, Timeline, nanos};
use crate::column::{Impact, Sample};
use crate::messages::words::estimate_line;
use crate::parameters::Parameters;
use crate::shape::Lengths;
use crate::study::VehicleLimits;
use crate::twin::{NoticeLevel, StateOutput, TwinPhase};

/// Maximum number of states in a batch.
const MAX_BATCH: usize = 512;

/// Maximum distance of the last state of an impact, which still vibrates, from the column at rest \[m\].
const MAX_VIBRATION: f64 = 0.02;

/// Maximum wait until the static data have been sent.
const STATICS_TIMEOUT: Duration = Duration::from_millis(500);

/// Options of a [`ViewerStream`].
#[derive(Debug, Clone)]
pub struct StreamOptions {
    /// Minimum time between two frames of the scene, in the time of the impact \[ns\]; curves contain every state.
    pub frame_period: i64,
    /// Limits the mean rate of frames; `None`: no limit.
    pub budget: Option<FrameBudget>,
    /// How long states are collected before their curves are sent, so that there are fewer and longer pieces \[ns\]; 0: not
    /// at all.
    pub curves_period: i64,
    /// Whether the viewer follows the latest data, or starts at the beginning.
    pub follows: bool,
    /// Initial ranges of the axes.
    pub ranges: Ranges,
}

/// What later batches need of the states of the current impact.
#[derive(Debug, Clone, Default)]
struct ImpactProgress {
    /// The first state.
    first: Option<Sample>,
    /// The last state of which a frame was made or skipped.
    last: Option<Sample>,
    /// The last state that the curves contain.
    plotted: Option<Sample>,
    /// Time of the last frame of the scene \[s\].
    last_frame: Option<f64>,
    events: EventDetector,
    /// The forecast.
    forecast: Option<Announcement>,
    event_id: Option<Arc<str>>,
    /// Stamp of the impact event \[ns\].
    stamp: i64,
    /// When its result was shown.
    ended: Option<Moment>,
    /// Name, number of masses and direction of what strikes, as it is drawn.
    vehicle: Option<(Arc<str>, usize, f64)>,
}

/// A Rerun stream to which items are written.
pub struct ViewerStream {
    branch: Branch,
    /// The stream shows no other column, so that its layout is that of this one.
    is_alone: bool,
    /// Another layout is wanted, which the caller sends.
    has_new_layout: bool,
    options: StreamOptions,
    parameters: Arc<Parameters>,
    drawing: Drawing,
    timeline: Timeline,
    /// The curves of the sensors, if there are any.
    detected: Option<DetectedCurves>,
    ranges: Ranges,
    /// Mass and velocity of the vehicle for which the ranges of the axes were last predicted.
    predicted: Option<[f64; 2]>,
    progress: ImpactProgress,
    /// The panel that was written last, without the critical velocities.
    told: String,
    /// The critical velocities that were added to it.
    critical_velocities: Option<Arc<[VehicleLimits]>>,
    /// The displacements of the column at rest that were shown last.
    at_rest: Option<[f64; 2]>,
    shown_top: ShownTop,
    /// The fibre beam that is shown, or waits for the states or the result of its impact.
    beam: ShownBeam,
    /// Whether the scene has been drawn at least once.
    drawn: bool,
    /// A forecast whose states have not arrived yet.
    forecast: Option<Announcement>,
    /// States that are collected for the curves.
    batch: Vec<(Moment, StateOutput)>,
    /// Number of states of the batch whose frames have been made.
    framed: usize,
}

/// A line of the log.
struct LogLine {
    moment: Moment,
    level: NoticeLevel,
    text: String,
}

impl ViewerStream {
    /// Writes blueprint and static data.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn new(
        stream: RecordingStream,
        parameters: Arc<Parameters>,
        options: StreamOptions,
    ) -> RecordingStreamResult<Self> {
        let timeline = Timeline::new(parameters.step_nanos());
        let mut shown = Self::unsent(Branch::whole(stream), parameters, options, timeline);
        shown.send_blueprint()?;
        shown.send_statics()?;
        Ok(shown)
    }

    /// Writes the static data of one of several columns that a stream shows, below its `name`; what it shows begins after
    /// `shown_until` \[ns\] on the timeline of the impacts. The layout is left to the caller: [`layout`](Self::layout).
    ///
    /// # Errors
    /// The stream rejects the data.
    pub(super) fn below(
        stream: RecordingStream,
        name: &str,
        parameters: Arc<Parameters>,
        options: StreamOptions,
        shown_until: i64,
    ) -> RecordingStreamResult<Self> {
        let timeline = Timeline::continued(parameters.step_nanos(), shown_until);
        let branch = Branch::below(stream, name);
        let mut shown = Self::unsent(branch, parameters, options, timeline);
        shown.is_alone = false;
        shown.has_new_layout = true;
        shown.send_statics()?;
        Ok(shown)
    }

    fn unsent(
        branch: Branch,
        parameters: Arc<Parameters>,
        options: StreamOptions,
        timeline: Timeline,
    ) -> Self {
        Self {
            drawing: Drawing::new(&parameters),
            detected: DetectedCurves::new(&parameters),
            ranges: options.ranges,
            branch,
            is_alone: true,
            has_new_layout: false,
            options,
            parameters,
            timeline,
            predicted: None,
            progress: ImpactProgress::default(),
            told: String::new(),
            critical_velocities: None,
            at_rest: None,
            shown_top: ShownTop::default(),
            beam: ShownBeam::default(),
            drawn: false,
            forecast: None,
            batch: Vec::new(),
            framed: 0,
        }
    }

    fn send_statics(&self) -> RecordingStreamResult<()> {
        self.statics()?;
        // Columns of data bypass the batcher and could overtake static data; a slow stream may have these later.
        let _ = self.stream().flush_with_timeout(STATICS_TIMEOUT);
        Ok(())
    }

    /// Shows some items in their order. Frames are sent at once; curves at the latest with the next call without a state.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn show(
        &mut self,
        items: impl IntoIterator<Item = ViewerItem>,
    ) -> RecordingStreamResult<()> {
        let mut moves = false;
        for item in items {
            match item {
                ViewerItem::State(state) => {
                    moves = true;
                    self.state(state)?;
                }
                // These have their own times and need not be in order with the states.
                ViewerItem::Forecast(_)
                | ViewerItem::Detected(_)
                | ViewerItem::Beam { .. }
                | ViewerItem::Line { .. } => {
                    self.other(item)?;
                }
                ViewerItem::Result(_) | ViewerItem::Rest { .. } | ViewerItem::Parameters(_) => {
                    self.flush()?;
                    self.other(item)?;
                }
            }
        }
        let waited = match &self.batch[..] {
            [(first, _), .., (last, _)] => last.wall_clock.saturating_sub(first.wall_clock),
            _ => 0,
        };
        if !moves || waited >= self.options.curves_period {
            self.flush()
        } else {
            self.draw()
        }
    }

    /// The stream.
    #[must_use]
    pub fn stream(&self) -> &RecordingStream {
        self.branch.stream()
    }

    fn other(&mut self, item: ViewerItem) -> RecordingStreamResult<()> {
        match item {
            ViewerItem::State(_) => Ok(()),
            ViewerItem::Forecast(forecast) => {
                self.show_undeformed(forecast.stamp)?;
                let line = LogLine {
                    moment: self.timeline.at_last(forecast.stamp),
                    level: NoticeLevel::Info,
                    text: format!(
                        "forecast of {}: {}",
                        forecast.event_id,
                        summary(&forecast.report)
                    ),
                };
                let mut ranges = Ranges::default();
                ranges.include_report(&forecast.report);
                self.tell(line.moment, Told::Forecast(&forecast))?;
                // A running twin computes it while the first states arrive.
                if self.progress.event_id.as_deref() == Some(&*forecast.event_id) {
                    self.progress.events.use_report(&forecast.report);
                    self.progress.forecast = Some(forecast);
                } else {
                    self.forecast = Some(forecast);
                }
                self.cover(&ranges)?;
                self.line(line)
            }
            ViewerItem::Result(result) => self.result(&result),
            ViewerItem::Detected(update) => self.detect(&update),
            ViewerItem::Beam { event_id, movement } => {
                self.beam.take(event_id, &movement, &self.drawing);
                self.show_beam()
            }
            ViewerItem::Rest {
                stamp,
                v1,
                u2,
                critical_velocities,
            } => {
                self.rest(stamp, v1, u2)?;
                self.critical_velocities(stamp, critical_velocities)
            }
            ViewerItem::Line { stamp, level, text } => self.line(LogLine {
                moment: self.timeline.at_last(stamp),
                level,
                text,
            }),
            ViewerItem::Parameters(parameters) => self.change(parameters),
        }
    }

    fn state(&mut self, state: StateOutput) -> RecordingStreamResult<()> {
        let Placed { moment, begins } = self.timeline.place(&state);
        if begins {
            self.flush()?;
            self.begin(&state, moment)?;
        } else if self.is_other_vehicle(&state) {
            self.flush()?;
            self.follow_vehicle(&state)?;
        }
        self.batch.push((moment, state));
        if self.batch.len() >= MAX_BATCH {
            self.flush()?;
        }
        Ok(())
    }

    /// Whether what strikes is another vehicle than the one that is drawn, where the states tell it.
    fn is_other_vehicle(&self, state: &StateOutput) -> bool {
        let (Some((name, masses, direction)), Some(vehicle)) =
            (&self.progress.vehicle, &state.vehicle)
        else {
            return false;
        };
        *name != vehicle.name
            || *masses != state.sample.vehicle.masses
            || *direction != vehicle.direction
    }

    /// Begins another impact.
    fn begin(&mut self, state: &StateOutput, moment: Moment) -> RecordingStreamResult<()> {
        let first = state.sample;
        let stamp = state.stamp - nanos(first.time);
        self.show_undeformed(stamp)?;
        self.progress = ImpactProgress {
            first: Some(first),
            event_id: Some(Arc::clone(&state.event_id)),
            stamp,
            ..ImpactProgress::default()
        };
        self.at_rest = None;
        // The wall clock may have been set back, and a viewer that connected late may have missed the top's position.
        self.shown_top = ShownTop::default();
        let announced = self.forecast.take();
        if let Some(forecast) = announced.filter(|it| it.event_id == state.event_id) {
            self.progress.events.use_report(&forecast.report);
            self.progress.forecast = Some(forecast);
        }
        self.beam
            .clear(&self.branch, moment, Some(&state.event_id))?;
        self.show_beam()?;
        self.follow_vehicle(state)?;
        let forecast = self.progress.forecast.clone();
        let told = forecast.as_ref().map_or(Told::Begun, Told::Forecast);
        self.tell(moment, told)
    }

    /// Draws the vehicle of a state from now on. A later estimate of an impact may have another one.
    fn follow_vehicle(&mut self, state: &StateOutput) -> RecordingStreamResult<()> {
        let first = state.sample;
        let masses = first.vehicle.masses;
        let vehicle = state.vehicle.as_ref();
        self.progress.vehicle = vehicle.map(|it| (Arc::clone(&it.name), masses, it.direction));
        let mass = plots::mass_of(&first, &first, self.drawing.struck_mass);
        // A running twin tells what hits the column with every state, a recording with the report.
        let report = self.progress.forecast.as_ref().map(|it| &it.report);
        let (name, given, direction) = match (&state.vehicle, report) {
            (Some(it), _) => (&*it.name, Some(it.mass), it.direction),
            (None, Some(it)) if it.mass > 0.0 => (&*it.vehicle, Some(it.mass), it.direction),
            // It does not tell what hits the column.
            (None, Some(it)) => (&*it.vehicle, None, self.parameters.direction()),
            (None, None) => ("", None, self.parameters.direction()),
        };
        let mass = given.filter(|it| *it > 0.0).or(mass);
        let is_turned = self.drawing.travel(direction);
        let is_changed = self
            .drawing
            .change_vehicle(&self.parameters, name, mass, masses);
        if is_turned {
            static_scene::send_load(&self.branch, &self.drawing)?;
        }
        if is_turned || is_changed {
            self.send_blueprint()?;
            force_crush::send_statics(&self.branch, self.drawing.springs.as_ref())?;
        }
        let vehicle = mass.map(|mass| [mass, first.impactor_velocity]);
        if let Some([mass, velocity]) = vehicle.filter(|it| self.predicted != Some(*it)) {
            self.predicted = vehicle;
            let springs = self.drawing.springs.map(|it| it.with_total_mass(mass));
            let impact = Impact {
                mass,
                velocity,
                vehicle: springs.and_then(Result::ok),
                ..self.parameters.impact()
            };
            self.cover(&Ranges::predicted(&self.parameters, &impact))?;
        }
        Ok(())
    }

    fn cover(&mut self, ranges: &Ranges) -> RecordingStreamResult<()> {
        if self.ranges.cover(ranges) {
            self.send_blueprint()?;
        }
        Ok(())
    }

    /// Shows what the sensors say about an impact.
    fn detect(&mut self, update: &DetectedUpdate) -> RecordingStreamResult<()> {
        self.show_undeformed(update.stamp)?;
        self.timeline.detect(update.impact(), update.until);
        let at = |secs: f64| self.timeline.in_detected(secs, update.stamp);
        let line = LogLine {
            moment: at(update.until),
            level: NoticeLevel::Info,
            text: estimate_line(&update.estimate),
        };
        if let Some(detected) = &mut self.detected {
            detected.send(&self.branch, update, at)?;
            if update.estimate.is_final && detected.fit(update) {
                self.send_blueprint()?;
            }
        }
        self.line(line)
    }

    /// Shows of the beam what belongs to the impact so far.
    fn show_beam(&mut self) -> RecordingStreamResult<()> {
        let progress = &self.progress;
        let at = |secs: f64| self.timeline.in_impact(secs, progress.stamp);
        let present = progress.event_id.as_deref();
        self.beam.show(&self.branch, present, at, progress.ended)
    }

    fn result(&mut self, result: &Announcement) -> RecordingStreamResult<()> {
        let end = self
            .timeline
            .in_impact(result.report.end_time, result.stamp);
        self.tell(end, Told::Result(result))?;
        if self.progress.event_id.as_ref() == Some(&result.event_id) {
            self.progress.ended = Some(end);
            self.show_beam()?;
        }
        if let Some(detected) = &mut self.detected
            && self.timeline.has_detected(&result.event_id)
        {
            let at = |secs: f64, stamp: i64| self.timeline.in_detected(secs, stamp);
            detected.send_outcome(&self.branch, &result.report, at)?;
        }
        self.line(LogLine {
            moment: end,
            level: NoticeLevel::Info,
            text: format!("result of {}: {}", result.event_id, summary(&result.report)),
        })
    }

    /// Shows the column before the first impact, unless something is drawn already.
    fn show_undeformed(&mut self, stamp: i64) -> RecordingStreamResult<()> {
        if self.drawn {
            return Ok(());
        }
        let before = self.timeline.before(stamp);
        self.tell(before, Told::Nothing)?;
        let scene = self.drawing.scene(&self.drawing.at_rest, None);
        self.frames(&[(before, scene)])
    }

    /// Shows the column at rest, unless it is shown already.
    fn rest(&mut self, stamp: i64, v1: f64, u2: f64) -> RecordingStreamResult<()> {
        if self.at_rest == Some([v1, u2]) {
            return Ok(());
        }
        let shown = self.progress.last.map(|last| [last.v1, last.u2]);
        self.at_rest = Some([v1, u2]);
        // The last state of an impact is better than the position at rest, because it has forces.
        let near = |shown: [f64; 2]| {
            (shown[0] - v1).abs() < MAX_VIBRATION && (shown[1] - u2).abs() < MAX_VIBRATION
        };
        if shown.is_some_and(near) {
            return Ok(());
        }
        let moment = self.timeline.after_last(stamp);
        // The column has been straightened or corrected.
        self.beam.clear(&self.branch, moment, None)?;
        let u1 = self.drawing.at_rest.u1 + 0.5 * (u2 - self.drawing.at_rest.u2);
        let sample = Sample {
            v1,
            u1,
            u2,
            ..self.drawing.at_rest
        };
        self.progress.last = Some(sample);
        self.progress.plotted = Some(sample);
        if !self.drawn {
            self.tell(moment, Told::Nothing)?;
        }
        self.frames(&[(moment, self.drawing.scene(&sample, None))])
    }

    fn change(&mut self, parameters: Arc<Parameters>) -> RecordingStreamResult<()> {
        let last = self.timeline.at_last(0);
        self.beam.clear(&self.branch, last, None)?;
        self.drawing = Drawing::new(&parameters);
        self.detected = DetectedCurves::new(&parameters);
        self.timeline.change_step(parameters.step_nanos());
        self.parameters = parameters;
        self.predicted = None;
        self.shown_top = ShownTop::default();
        self.at_rest = None;
        self.send_blueprint()?;
        self.statics()
    }

    /// Writes the panel beside the scene.
    fn tell(&mut self, moment: Moment, told: Told<'_>) -> RecordingStreamResult<()> {
        self.told = panel::panel(&self.drawing, told);
        self.critical_velocities = None;
        self.write_panel(moment, self.told.clone())
    }

    /// Adds the critical velocities to the panel, unless they are there already. They come some time after a response.
    fn critical_velocities(
        &mut self,
        stamp: i64,
        known: Option<Arc<[VehicleLimits]>>,
    ) -> RecordingStreamResult<()> {
        let (Some(vehicles), true) = (&known, known != self.critical_velocities) else {
            return Ok(());
        };
        let text = panel::with_critical_velocities(&self.told, vehicles);
        self.critical_velocities = known;
        let moment = self.timeline.after_last(stamp);
        self.write_panel(moment, text)
    }

    fn write_panel(&self, moment: Moment, text: String) -> RecordingStreamResult<()> {
        let text = TextDocument::from_markdown(text);
        let data = text.columns_of_unit_batches()?;
        self.branch
            .send_columns(PANEL, time_columns([moment]), data)
    }

    fn send_blueprint(&mut self) -> RecordingStreamResult<()> {
        match self.is_alone {
            true => blueprint::send(self.stream(), &self.layout(), self.options.follows),
            false => {
                self.has_new_layout = true;
                Ok(())
            }
        }
    }

    /// What the layout of this column depends on.
    pub(super) fn layout(&self) -> ColumnLayout<'_> {
        let views = self.detected.as_ref().map(DetectedCurves::views);
        ColumnLayout {
            root: self.branch.root(),
            column_id: (!self.is_alone).then(|| &*self.parameters.settings().column_id),
            drawing: &self.drawing,
            axes: self.ranges.axes(),
            detected: views.unwrap_or_default(),
        }
    }

    /// Whether another layout has been wanted since the last call.
    pub(super) fn takes_new_layout(&mut self) -> bool {
        std::mem::take(&mut self.has_new_layout)
    }

    /// Lets the next impact begin after everything that other columns have shown until then \[ns on the timeline of the impacts\].
    pub(super) fn continue_after(&mut self, shown_until: i64) {
        self.timeline.continue_after(shown_until);
    }

    /// The latest moment that was shown.
    pub(super) fn last_moment(&self) -> Moment {
        self.timeline.shown_until()
    }

    /// Makes the frames of the states that have none yet.
    fn draw(&mut self) -> RecordingStreamResult<()> {
        let batch = std::mem::take(&mut self.batch);
        let drawn = self.scenes(&batch[self.framed..]);
        self.framed = batch.len();
        self.batch = batch;
        drawn
    }

    /// Writes the collected states.
    fn flush(&mut self) -> RecordingStreamResult<()> {
        self.draw()?;
        self.framed = 0;
        let batch = std::mem::take(&mut self.batch);
        if batch.is_empty() {
            return Ok(());
        }
        let curves = Curves {
            branch: &self.branch,
            drawing: &self.drawing,
            plotted: self.progress.plotted,
            displacement_axis: self.ranges.axes()[plots::DISPLACEMENT],
            impact_impulse_mark: self.ranges.impact_impulse_mark(),
        };
        curves.send(&batch)?;
        for (moment, state) in &batch {
            for Event { time, text } in self.progress.events.until(&state.sample) {
                let moment = if time == state.sample.time {
                    *moment
                } else {
                    self.timeline.in_impact(time, self.progress.stamp)
                };
                self.line(LogLine {
                    moment,
                    level: NoticeLevel::Info,
                    text,
                })?;
            }
        }
        self.progress.plotted = batch.last().map(|(_, state)| state.sample);
        Ok(())
    }

    /// Makes frames of the states that are far enough apart, and of the last one of an impact.
    fn scenes(&mut self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let mut frames = Vec::new();
        let first = self.progress.first.unwrap_or_default();
        let mut before = self.progress.last.unwrap_or(first);
        self.progress.last = batch
            .last()
            .map(|(_, state)| state.sample)
            .or(self.progress.last);
        for (moment, state) in batch {
            let sample = &state.sample;
            let period = self.options.frame_period;
            let goes_on = (state.phase as u8) < TwinPhase::Rest as u8;
            // An impact impulse, or a hinge that yields or unloads, is shown at its own instant.
            let states = |sample: &Sample| sample.hinges.map(|hinge| hinge.state);
            let notable = sample.impact_impulse > 0.0 || states(&before) != states(sample);
            before = *sample;
            if goes_on && !notable && !plots::apart(self.progress.last_frame, sample.time, period) {
                continue;
            }
            let budget = self.options.budget.as_mut();
            if goes_on && !budget.is_none_or(|budget| budget.take(moment.wall_clock)) {
                continue;
            }
            self.progress.last_frame = Some(sample.time);
            // The height of the impact may differ from that of the last one.
            self.drawing.lengths = state
                .lengths
                .unwrap_or_else(|| Lengths::from(&*self.parameters));
            let mass = plots::mass_of(&first, sample, self.drawing.struck_mass);
            frames.push((*moment, self.drawing.scene(sample, mass)));
        }
        self.frames(&frames)
    }

    fn frames(&mut self, frames: &[(Moment, Scene)]) -> RecordingStreamResult<()> {
        self.drawn |= !frames.is_empty();
        frames::send(&self.branch, frames, &mut self.shown_top)
    }

    fn line(&self, line: LogLine) -> RecordingStreamResult<()> {
        let text = TextLog::new(line.text).with_level(log_level(line.level));
        let data = text.columns_of_unit_batches()?;
        self.branch
            .send_columns("log", time_columns([line.moment]), data)
    }

    /// Writes what does not change while the column is the same.
    fn statics(&self) -> RecordingStreamResult<()> {
        let exponents = self.parameters.column_properties().yield_surface;
        static_scene::send(&self.branch, &self.drawing, exponents)?;
        force_crush::send_statics(&self.branch, self.drawing.springs.as_ref())?;
        frames::send_statics(&self.branch, &self.drawing)?;
        beam::send_statics(&self.branch, &self.drawing)?;
        if let Some(detected) = &self.detected {
            detected.send_styles(&self.branch)?;
        }
        curve_styles::send(&self.branch)
    }
}
