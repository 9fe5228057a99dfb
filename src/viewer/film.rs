//! Writes what is shown into a Rerun stream: statics once, states in batches, one column of data for each entity.

use std::sync::Arc;
use std::time::Duration;

use rerun::{
    Color, LineStrip2D, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult,
    Scalars, SeriesLines, SeriesPoints, TextLog, TextLogLevel, TimeColumn,
};

use super::blueprint;
use super::colour::{self, Rgb};
use super::events::{Event, Events, summary};
use super::fixtures;
use super::item::{Announcement, Item};
use super::pictures::{self, ShownTop};
use super::plots::{self, Ranges};
use super::scene::{Drawing, Scene};
use super::timeline::{IMPACT_TIME, Moment, Placed, STEP, Timeline, WALL_CLOCK};
use crate::column::{HINGES, Sample};
use crate::parameters::Parameters;
use crate::shape::Lengths;
use crate::twin::{Severity, StateOutput};

/// Most states that are written at once.
pub const LARGEST_BATCH: usize = 512;

/// How far the last state of an impact may be from the column at rest \[m\]: it still vibrates.
const VIBRATION: f64 = 0.02;

/// How long what stands still may take to leave.
const STATICS_WITHIN: Duration = Duration::from_millis(500);

/// How many pictures of the scene may be made in the long run: what is not spent is saved, up to a limit, so that a whole
/// impact is seen millisecond by millisecond, and a column that never rests costs no more than the rate.
#[derive(Debug, Clone)]
pub struct Budget {
    per_second: f64,
    most: f64,
    left: f64,
    /// When it was looked at last \[ns\].
    at: Option<i64>,
}

impl Budget {
    /// Pictures per second, and how many can be saved.
    #[must_use]
    pub fn new(per_second: f64, most: f64) -> Self {
        Self {
            per_second,
            most,
            left: most,
            at: None,
        }
    }

    /// Whether there is one more picture at this time \[ns\]; a time that goes back earns nothing.
    pub fn take(&mut self, now: i64) -> bool {
        let passed = now.saturating_sub(self.at.unwrap_or(now)).max(0);
        self.at = Some(now);
        self.left = (self.left + 1e-9 * passed as f64 * self.per_second).min(self.most);
        if self.left < 1.0 {
            return false;
        }
        self.left -= 1.0;
        true
    }
}

/// How a film is made.
#[derive(Debug, Clone)]
pub struct FilmOptions {
    /// Shortest time between two pictures of the scene, in the time of the impact \[ns\]; curves have every state.
    pub picture_period: i64,
    /// How many pictures there may be in the long run; `None`: any number.
    pub budget: Option<Budget>,
    /// How long curves may wait for more of them, so that fewer and longer pieces leave \[ns\]; 0: for nothing.
    pub curves_period: i64,
    /// Whether the viewer follows what comes, or stands at the beginning.
    pub follows: bool,
    /// How far the axes reach from the start.
    pub ranges: Ranges,
}

/// Where states were that go on in the next batch.
#[derive(Debug, Clone, Default)]
struct Going {
    /// First state of the present impact.
    first: Option<Sample>,
    /// The last state of which a picture was made or left out.
    last: Option<Sample>,
    /// The last state up to which the curves go.
    traced: Option<Sample>,
    /// Time of the last picture of the scene \[s\].
    pictured: Option<f64>,
    events: Events,
    /// The event, for what a report tells.
    event_id: Option<Arc<str>>,
    stamp: i64,
}

/// A stream into which everything is written that there is to see.
pub struct Film {
    stream: RecordingStream,
    options: FilmOptions,
    parameters: Arc<Parameters>,
    drawing: Drawing,
    timeline: Timeline,
    ranges: Ranges,
    /// Mass and velocity of the vehicle whose impact the axes were last made for.
    foreseen: Option<[f64; 2]>,
    going: Going,
    /// The last displacements that were shown at rest.
    at_rest: Option<[f64; 2]>,
    shown_top: ShownTop,
    /// Whether the scene has ever been drawn.
    drawn: bool,
    /// A forecast whose states have not come yet.
    forecast: Option<Announcement>,
    /// States whose curves wait.
    batch: Vec<(Moment, StateOutput)>,
    /// How many of them have had their pictures.
    seen: usize,
}

/// A line of the log.
struct Line {
    moment: Moment,
    severity: Severity,
    text: String,
}

impl Film {
    /// Writes statics and blueprint, and the column at rest.
    ///
    /// # Errors
    /// The stream takes nothing.
    pub fn new(
        stream: RecordingStream,
        parameters: Arc<Parameters>,
        options: FilmOptions,
    ) -> RecordingStreamResult<Self> {
        let timeline = Timeline::new(parameters.column_properties().step_nanos);
        let film = Self {
            drawing: Drawing::new(&parameters),
            ranges: options.ranges,
            stream,
            options,
            parameters,
            timeline,
            foreseen: None,
            going: Going::default(),
            at_rest: None,
            shown_top: ShownTop::default(),
            drawn: false,
            forecast: None,
            batch: Vec::new(),
            seen: 0,
        };
        film.send_blueprint()?;
        film.statics()?;
        // What stands still leaves before the columns of data, which wait for nothing; a stream that is slow may have it later.
        let _ = film.stream.flush_with_timeout(STATICS_WITHIN);
        Ok(film)
    }

    /// Shows some items in their order. Pictures are made at once, curves with the next call in which no state comes, if not
    /// before.
    ///
    /// # Errors
    /// The stream takes nothing.
    pub fn show(&mut self, items: impl IntoIterator<Item = Item>) -> RecordingStreamResult<()> {
        let mut moves = false;
        for item in items {
            match item {
                Item::State(state) => {
                    moves = true;
                    self.state(state)?;
                }
                // They have their own times and wait for no state.
                Item::Forecast(_) | Item::Line { .. } => self.other(item)?,
                Item::Result(_) | Item::Rest { .. } | Item::Parameters(_) => {
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
        &self.stream
    }

    fn other(&mut self, item: Item) -> RecordingStreamResult<()> {
        match item {
            Item::State(_) => Ok(()),
            Item::Forecast(forecast) => {
                self.stand(forecast.stamp)?;
                let line = Line {
                    moment: self.timeline.at_last(forecast.stamp),
                    severity: Severity::Info,
                    text: format!(
                        "forecast of {}: {}",
                        forecast.event_id,
                        summary(&forecast.report)
                    ),
                };
                let mut ranges = Ranges::default();
                ranges.reach_report(&forecast.report);
                // A running twin computes it while the first states come.
                if self.going.event_id.as_deref() == Some(&*forecast.event_id) {
                    self.going.events.announce(&forecast.report);
                } else {
                    self.forecast = Some(forecast);
                }
                self.cover(&ranges)?;
                self.line(line)
            }
            Item::Result(result) => self.result(&result),
            Item::Rest { stamp, v1, u2 } => self.rest(stamp, v1, u2),
            Item::Line {
                stamp,
                severity,
                text,
            } => self.line(Line {
                moment: self.timeline.at_last(stamp),
                severity,
                text,
            }),
            Item::Parameters(parameters) => self.change(parameters),
        }
    }

    fn state(&mut self, state: StateOutput) -> RecordingStreamResult<()> {
        let Placed { moment, begins } = self.timeline.place(&state);
        if begins {
            self.flush()?;
            self.begin(&state)?;
        }
        self.batch.push((moment, state));
        if self.batch.len() >= LARGEST_BATCH {
            self.flush()?;
        }
        Ok(())
    }

    /// Another impact begins.
    fn begin(&mut self, state: &StateOutput) -> RecordingStreamResult<()> {
        let first = state.sample;
        let stamp = state.stamp - super::timeline::nanos(first.time);
        self.stand(stamp)?;
        self.going = Going {
            first: Some(first),
            event_id: Some(Arc::clone(&state.event_id)),
            stamp,
            ..Going::default()
        };
        self.at_rest = None;
        // The wall clock may have gone back, and a viewer that comes late may have missed where it was.
        self.shown_top = ShownTop::default();
        let announced = self.forecast.take();
        if let Some(forecast) = announced.filter(|it| it.event_id == state.event_id) {
            self.going.events.announce(&forecast.report);
        }
        let mass = plots::mass_of(&first, &first, self.drawing.struck_mass);
        let vehicle = mass.map(|mass| [mass, first.impactor_velocity]);
        if let Some([mass, velocity]) = vehicle.filter(|it| self.foreseen != Some(*it)) {
            self.foreseen = vehicle;
            let foreseen = Ranges::foreseen(&self.parameters, Some(mass), Some(velocity));
            self.cover(&foreseen)?;
        }
        Ok(())
    }

    fn cover(&mut self, ranges: &Ranges) -> RecordingStreamResult<()> {
        if self.ranges.cover(ranges) {
            self.send_blueprint()?;
        }
        Ok(())
    }

    fn result(&mut self, result: &Announcement) -> RecordingStreamResult<()> {
        let end = self
            .timeline
            .in_impact(result.report.end_time, result.stamp);
        self.line(Line {
            moment: end,
            severity: Severity::Info,
            text: format!("result of {}: {}", result.event_id, summary(&result.report)),
        })
    }

    /// The column before anything has happened, unless something is drawn already.
    fn stand(&mut self, stamp: i64) -> RecordingStreamResult<()> {
        if self.drawn {
            return Ok(());
        }
        let before = Timeline::before(self.parameters.column_properties().step_nanos, stamp);
        let scene = self.drawing.scene(&self.drawing.at_rest, None);
        self.pictures(&[(before, scene)])
    }

    /// The column at rest, unless it is already shown so.
    fn rest(&mut self, stamp: i64, v1: f64, u2: f64) -> RecordingStreamResult<()> {
        if self.at_rest == Some([v1, u2]) {
            return Ok(());
        }
        let shown = self.going.last.map(|last| [last.v1, last.u2]);
        self.at_rest = Some([v1, u2]);
        // After an impact its last state is better than what the twin says of its rest: it has forces.
        let near = |shown: [f64; 2]| {
            (shown[0] - v1).abs() < VIBRATION && (shown[1] - u2).abs() < VIBRATION
        };
        if shown.is_some_and(near) {
            return Ok(());
        }
        let moment = self.timeline.after_last(stamp);
        let u1 = self.drawing.at_rest.u1 + 0.5 * (u2 - self.drawing.at_rest.u2);
        let sample = Sample {
            v1,
            u1,
            u2,
            ..self.drawing.at_rest
        };
        self.going.last = Some(sample);
        self.going.traced = Some(sample);
        self.pictures(&[(moment, self.drawing.scene(&sample, None))])
    }

    fn change(&mut self, parameters: Arc<Parameters>) -> RecordingStreamResult<()> {
        self.drawing = Drawing::new(&parameters);
        self.timeline
            .change_step(parameters.column_properties().step_nanos);
        self.parameters = parameters;
        self.foreseen = None;
        self.shown_top = ShownTop::default();
        self.at_rest = None;
        self.send_blueprint()?;
        self.statics()
    }

    fn send_blueprint(&self) -> RecordingStreamResult<()> {
        let axes = self.ranges.axes();
        blueprint::send(&self.stream, &self.drawing, &axes, self.options.follows)
    }

    /// Makes pictures of the states that have had none.
    fn draw(&mut self) -> RecordingStreamResult<()> {
        let batch = std::mem::take(&mut self.batch);
        let drawn = self.scenes(&batch[self.seen..]);
        self.seen = batch.len();
        self.batch = batch;
        drawn
    }

    /// Writes everything of the states that wait.
    fn flush(&mut self) -> RecordingStreamResult<()> {
        self.draw()?;
        self.seen = 0;
        let batch = std::mem::take(&mut self.batch);
        if batch.is_empty() {
            return Ok(());
        }
        self.curves(&batch)?;
        self.percussions(&batch)?;
        self.stresses(&batch)?;
        for (moment, state) in &batch {
            for Event { time, text } in self.going.events.until(&state.sample) {
                let moment = if time == state.sample.time {
                    *moment
                } else {
                    self.timeline.in_impact(time, self.going.stamp)
                };
                self.line(Line {
                    moment,
                    severity: Severity::Info,
                    text,
                })?;
            }
        }
        self.going.traced = batch.last().map(|(_, state)| state.sample);
        Ok(())
    }

    fn curves(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let times = columns(batch.iter().map(|(moment, _)| *moment));
        for plot in &plots::ALL {
            let values = batch.iter().flat_map(|(_, state)| {
                let values = (plot.values)(&state.sample);
                values.into_iter().map(|value| plot.per_si * value)
            });
            let scalars = Scalars::new(values);
            let lengths = vec![plot.curves.len(); batch.len()];
            self.stream
                .send_columns(plot.entity, times.clone(), scalars.columns(lengths)?)?;
        }
        Ok(())
    }

    fn percussions(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let struck = batch.iter().filter(|(_, it)| it.sample.percussion > 0.0);
        let times: Vec<_> = struck.map(|(moment, _)| *moment).collect();
        if times.is_empty() {
            return Ok(());
        }
        let marks = Scalars::new(vec![self.ranges.percussion_mark(); times.len()]);
        let columns_of_marks = marks.columns(vec![1; times.len()])?;
        self.stream
            .send_columns(plots::PERCUSSIONS, columns(times), columns_of_marks)
    }

    /// The path of each hinge in its yield surface, piece by piece, and where it is now.
    fn stresses(&self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let times = columns(batch.iter().map(|(moment, _)| *moment));
        let resistances = [
            self.drawing.resistance_moment,
            self.drawing.resistance_axial,
        ];
        for hinge in 0..HINGES {
            let mut last = self.going.traced.unwrap_or(batch[0].1.sample);
            let mut strips = Vec::with_capacity(batch.len());
            let mut points = Vec::with_capacity(batch.len());
            for (_, state) in batch {
                let from = plots::stress(&last, hinge, resistances);
                let to = plots::stress(&state.sample, hinge, resistances);
                strips.push(LineStrip2D::from_iter([from, to]));
                points.push(to);
                last = state.sample;
            }
            let ones = vec![1; batch.len()];
            let path = LineStrips2D::update_fields().with_strips(strips);
            let entity = fixtures::stress_entity(hinge, "path");
            self.stream
                .send_columns(entity, times.clone(), path.columns(ones.clone())?)?;
            let colours = batch
                .iter()
                .map(|(_, state)| color(colour::of_state(state.sample.hinges[hinge].state)));
            let now = Points2D::update_fields()
                .with_positions(points)
                .with_colors(colours);
            let entity = fixtures::stress_entity(hinge, "now");
            self.stream
                .send_columns(entity, times.clone(), now.columns(ones)?)?;
        }
        Ok(())
    }

    /// Pictures of the scene of those states that are far enough apart, and of the last one of an impact.
    fn scenes(&mut self, batch: &[(Moment, StateOutput)]) -> RecordingStreamResult<()> {
        let mut pictures = Vec::new();
        let first = self.going.first.unwrap_or_default();
        let mut before = self.going.last.unwrap_or(first);
        self.going.last = batch
            .last()
            .map(|(_, state)| state.sample)
            .or(self.going.last);
        for (moment, state) in batch {
            let sample = &state.sample;
            let period = self.options.picture_period;
            let goes_on = (state.phase as u8) < crate::twin::TwinPhase::Rest as u8;
            // A percussion, or a hinge that yields or unloads, is seen at its own instant.
            let states = |sample: &Sample| sample.hinges.map(|hinge| hinge.state);
            let notable = sample.percussion > 0.0 || states(&before) != states(sample);
            before = *sample;
            if goes_on && !notable && !plots::apart(self.going.pictured, sample.time, period) {
                continue;
            }
            let budget = self.options.budget.as_mut();
            if goes_on && !budget.is_none_or(|budget| budget.take(moment.wall_clock)) {
                continue;
            }
            self.going.pictured = Some(sample.time);
            // The impact may be at another height than the last one.
            self.drawing.lengths = state
                .lengths
                .unwrap_or_else(|| Lengths::from(&*self.parameters));
            let mass = plots::mass_of(&first, sample, self.drawing.struck_mass);
            pictures.push((*moment, self.drawing.scene(sample, mass)));
        }
        self.pictures(&pictures)
    }

    fn pictures(&mut self, pictures: &[(Moment, Scene)]) -> RecordingStreamResult<()> {
        self.drawn |= !pictures.is_empty();
        pictures::send(&self.stream, pictures, &mut self.shown_top)
    }

    fn line(&self, line: Line) -> RecordingStreamResult<()> {
        let level = match line.severity {
            Severity::Info => TextLogLevel::INFO,
            Severity::Warning => TextLogLevel::WARN,
            Severity::Error => TextLogLevel::ERROR,
        };
        let text = TextLog::new(line.text).with_level(level);
        let data = text.columns_of_unit_batches()?;
        self.stream
            .send_columns("log", columns([line.moment]), data)
    }

    /// What does not change while the column is the same.
    fn statics(&self) -> RecordingStreamResult<()> {
        let exponents = self.parameters.column_properties().yield_surface;
        fixtures::send(&self.stream, &self.drawing, exponents)?;
        pictures::send_statics(&self.stream, &self.drawing)?;
        self.styles()
    }

    /// Names, colours and widths of the curves.
    fn styles(&self) -> RecordingStreamResult<()> {
        let stream = &self.stream;
        for plot in &plots::ALL {
            let last = plot.curves.len() - 1;
            let widths = (0..=last).map(|index| if index == last { plot.last_width } else { 1.5 });
            let lines = SeriesLines::new()
                .with_names(plot.curves.iter().map(|(name, _)| *name))
                .with_colors(plot.curves.iter().map(|(_, rgb)| color(*rgb)))
                .with_widths(widths);
            stream.log_static(plot.entity, &lines)?;
        }
        let marks = SeriesPoints::new()
            .with_names(["percussion, a mark"])
            .with_colors([color(colour::ENERGIES[1])])
            .with_markers([rerun::components::MarkerShape::Down])
            .with_marker_sizes([6.0]);
        stream.log_static(plots::PERCUSSIONS, &marks)?;
        for hinge in 0..HINGES {
            let path = LineStrips2D::update_fields()
                .with_colors([color(colour::HINGE[hinge])])
                .with_radii([Radius::new_ui_points(1.5)]);
            stream.log_static(fixtures::stress_entity(hinge, "path"), &path)?;
            let now = Points2D::update_fields().with_radii([Radius::new_ui_points(5.0)]);
            stream.log_static(fixtures::stress_entity(hinge, "now"), &now)?;
        }
        Ok(())
    }
}

/// A colour as Rerun has it.
pub(super) fn color([red, green, blue]: Rgb) -> Color {
    Color::from_rgb(red, green, blue)
}

/// The times of some rows on all timelines.
pub(super) fn columns(moments: impl IntoIterator<Item = Moment>) -> Vec<TimeColumn> {
    let moments: Vec<_> = moments.into_iter().collect();
    let of = |time: fn(&Moment) -> i64| moments.iter().map(time).collect::<Vec<_>>();
    vec![
        TimeColumn::new_duration_nanos(IMPACT_TIME, of(|it| it.impact_time)),
        TimeColumn::new_sequence(STEP, of(|it| it.step)),
        TimeColumn::new_timestamp_nanos_since_epoch(WALL_CLOCK, of(|it| it.wall_clock)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand states a second: the first impact is seen whole, and then sixty pictures a second.
    #[test]
    fn a_budget_is_spent_and_earned() {
        let mut budget = Budget::new(60.0, 120.0);
        let mut pictures = |from: i64, to: i64| {
            let times = (from..to).map(|millisecond| millisecond * 1_000_000);
            times.filter(|now| budget.take(*now)).count()
        };
        assert_eq!(pictures(0, 100), 100);
        let later = pictures(1_000, 11_000);
        assert!((600..=725).contains(&later), "{later}");
        // Wound back: nothing is earned, and nothing breaks.
        assert!(pictures(0, 50) <= 50);
    }
}
