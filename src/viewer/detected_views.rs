//! The curves about an impact that the sensors detect: forecast, momentum and action over the time of the data, and each sensor.

use rerun::blueprint::components::Corner2D;
use rerun::{RecordingStreamResult, Scalars, SeriesLines, SeriesPoints, components::MarkerShape};

use super::branch::Branch;
use super::colour::{self, Rgb};
use super::detected::{DetectedUpdate, SensorCourse};
use super::rerun_types::{color, time_columns};
use super::timeline::Moment;
use crate::assessment::Action;
use crate::messages::column_twin_msgs::{CredibleInterval, ImpactReport};
use crate::parameters::Parameters;
use crate::shape::action_colour;

/// Most sensors that have a view of their own; more would not be readable. The data of all sensors are there.
pub(super) const MAX_SENSOR_VIEWS: usize = 12;

/// Millimetres.
const MM: f64 = 1e3;

/// A view of curves over the time of the impact.
pub(super) struct DetectedView {
    /// Title, with the unit.
    pub title: String,
    /// What it shows.
    pub entities: Vec<String>,
    /// Range of its axis, if it is not that of the curves.
    pub range: Option<[f64; 2]>,
    /// Where the names of the curves hide least of them.
    pub names: Corner2D,
}

const FORECAST: &str = "detected/forecast";
const OUTCOME: &str = "detected/outcome";
const MOMENTUM: &str = "detected/momentum";
const ACTION: &str = "detected/action";

/// Curves of peak and residual displacement: their means, and both ends of their intervals.
const FORECAST_CURVES: [(&str, Rgb, f32); 6] = [
    ("peak", colour::IMPACTOR, 2.5),
    ("peak, 5 %", colour::IMPACTOR, 1.0),
    ("peak, 95 %", colour::IMPACTOR, 1.0),
    ("residual", colour::CONTACT, 2.5),
    ("residual, 5 %", colour::CONTACT, 1.0),
    ("residual, 95 %", colour::CONTACT, 1.0),
];

const OUTCOME_CURVES: [(&str, Rgb, f32); 2] = [
    ("peak of the twin", colour::VEHICLE_EDGE, 1.5),
    ("residual of the twin", colour::MOMENT, 1.5),
];

const MOMENTUM_CURVES: [(&str, Rgb, f32); 3] = [
    ("momentum", colour::BAR_A, 2.5),
    ("5 %", colour::BAR_A, 1.0),
    ("95 %", colour::BAR_A, 1.0),
];

/// What is shown of an impact that the sensors detect, for the sensors of some parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DetectedCurves {
    sensors: Vec<ShownSensor>,
    /// Ranges of the axes of forecast and momentum, if the first, wide intervals would hide the last ones.
    ranges: [Option<[f64; 2]>; 2],
    current: Option<CurrentImpact>,
}

/// The impact that was shown last.
#[derive(Debug, Clone, PartialEq)]
struct CurrentImpact {
    event_id: String,
    stamp: i64,
    /// Data were used up to this time after the stamp \[s\].
    until: f64,
    /// Peak and residual displacement of the twin, once they are known \[m\].
    outcome: Option<[f64; 2]>,
}

#[derive(Debug, Clone, PartialEq)]
struct ShownSensor {
    name: String,
    title: String,
    per_si: f64,
    /// Largest reading of the current impact, in the unit of the view.
    largest: f64,
    /// Range of the axis, if the readings would hide what was predicted.
    range: Option<[f64; 2]>,
}

/// A sensor whose readings exceed the final prediction by this factor is cut off: a strain gauge after yielding, for example, which
/// does not count any more.
const HIDING: f64 = 10.0;

/// Largest value that an axis shows, as a multiple of the upper end of the last interval.
const WIDEST: f64 = 2.5;

impl DetectedCurves {
    /// For the sensors of these parameters; `None` if there are none.
    pub fn new(parameters: &Parameters) -> Option<Self> {
        let sensors = parameters.sensors();
        let shown = sensors.into_iter().map(|sensor| {
            let (unit, per_si) = sensor.quantity.shown_unit();
            ShownSensor {
                title: format!("{} [{unit}]", sensor.name),
                per_si,
                largest: 0.0,
                range: None,
                name: sensor.name,
            }
        });
        let sensors: Vec<_> = shown.collect();
        (!sensors.is_empty()).then_some(Self {
            sensors,
            ranges: [None; 2],
            current: None,
        })
    }

    /// The views, in their order.
    pub fn views(&self) -> Vec<DetectedView> {
        let [forecast, momentum] = self.ranges;
        let view = |title: &str, entities: &[&str], range| DetectedView {
            title: title.to_owned(),
            entities: entities.iter().map(|it| (*it).to_owned()).collect(),
            range,
            names: Corner2D::RightTop,
        };
        let mut views = vec![
            view(
                "Forecast of the displacement [mm]",
                &[FORECAST, OUTCOME],
                forecast,
            ),
            view("Momentum [kN s]", &[MOMENTUM], momentum),
            view("Action [% probable]", &[ACTION], Some([-2.0, 102.0])),
        ];
        let sensors = self.sensors.iter().take(MAX_SENSOR_VIEWS);
        views.extend(sensors.map(|sensor| DetectedView {
            title: sensor.title.clone(),
            entities: vec![format!("{}/**", sensor.entity(""))],
            range: sensor.range,
            names: Corner2D::RightBottom,
        }));
        views
    }

    /// Limits the axes to what the last intervals need; whether that has changed something.
    pub fn fit(&mut self, update: &DetectedUpdate) -> bool {
        let estimate = &update.estimate;
        let range = |interval: &CredibleInterval, per_si: f64| {
            let high = WIDEST * per_si * interval.high;
            (high.is_finite() && high > 0.0).then_some([-0.05 * high, high])
        };
        let ranges = [
            range(&estimate.peak_v1, MM),
            range(&estimate.momentum, 1e-3),
        ];
        let mut has_changed = self.ranges != ranges;
        self.ranges = ranges;
        for (sensor, course) in self.sensors.iter_mut().zip(&update.sensors) {
            let largest = sensor.per_si * largest(&course.explained);
            let hides = largest > 0.0 && sensor.largest > HIDING * largest;
            let range = hides.then_some([-WIDEST * largest, WIDEST * largest]);
            has_changed |= sensor.range != range;
            sensor.range = range;
        }
        has_changed
    }

    /// Writes names and colours of the curves.
    pub fn send_styles(&self, stream: &Branch) -> RecordingStreamResult<()> {
        let lines = |curves: &[(&str, Rgb, f32)]| {
            SeriesLines::new()
                .with_names(curves.iter().map(|(name, ..)| *name))
                .with_colors(curves.iter().map(|(_, rgb, _)| color(*rgb)))
                .with_widths(curves.iter().map(|(.., width)| *width))
        };
        stream.log_static(FORECAST, &lines(&FORECAST_CURVES))?;
        stream.log_static(OUTCOME, &lines(&OUTCOME_CURVES))?;
        stream.log_static(MOMENTUM, &lines(&MOMENTUM_CURVES))?;
        let actions = SeriesLines::new()
            .with_names(Action::ALL.map(|it| it.to_string()))
            .with_colors(Action::ALL.map(|it| color(action_colour(it))))
            .with_widths([2.0; Action::ALL.len()]);
        stream.log_static(ACTION, &actions)?;
        for sensor in &self.sensors {
            let points = SeriesPoints::new()
                .with_names(["measured"])
                .with_colors([color(colour::IMPACT_POINT)])
                .with_markers([MarkerShape::Circle])
                .with_marker_sizes([1.5]);
            stream.log_static(sensor.entity("measured"), &points)?;
            for (entity, name, rgb) in [
                ("predicted", "predicted before the data", colour::BAR_B),
                ("explained", "by the final estimate", colour::IMPACTOR),
            ] {
                stream.log_static(sensor.entity(entity), &lines(&[(name, rgb, 1.5)]))?;
            }
        }
        Ok(())
    }

    /// Writes an estimate and what is new of the readings; `at` is the moment of a time after its `stamp` \[s\].
    pub fn send(
        &mut self,
        stream: &Branch,
        update: &DetectedUpdate,
        at: impl Fn(f64) -> Moment,
    ) -> RecordingStreamResult<()> {
        let estimate = &update.estimate;
        let before = self
            .current
            .take()
            .filter(|it| it.event_id == update.impact());
        let outcome = before.as_ref().and_then(|it| it.outcome);
        self.current = Some(CurrentImpact {
            event_id: update.impact().to_owned(),
            stamp: update.stamp,
            until: update.until,
            outcome,
        });
        if !update.is_new {
            return Ok(());
        }
        let row =
            |entity: &str, values: Vec<f64>| rows(stream, entity, &[at(update.until)], values);
        let of = |interval: &CredibleInterval, per_si: f64| {
            [interval.mean, interval.low, interval.high].map(|it| per_si * it)
        };
        let forecast = [of(&estimate.peak_v1, MM), of(&estimate.residual_v1, MM)];
        row(FORECAST, forecast.concat())?;
        row(MOMENTUM, of(&estimate.momentum, 1e-3).to_vec())?;
        let shares = estimate.action_probabilities;
        row(ACTION, shares.map(|share| 100.0 * share).to_vec())?;
        if let Some(outcome) = outcome {
            row(OUTCOME, outcome.map(|it| MM * it).to_vec())?;
        }
        if before.is_none() {
            self.sensors.iter_mut().for_each(|it| it.largest = 0.0);
        }
        for (sensor, course) in self.sensors.iter_mut().zip(&update.sensors) {
            let read = sensor.per_si * largest(&course.measured);
            sensor.largest = sensor.largest.max(read);
            let SensorCourse {
                measured,
                predicted,
                explained,
            } = course;
            for (entity, course) in [
                ("measured", measured),
                ("predicted", predicted),
                ("explained", explained),
            ] {
                let moments: Vec<_> = course.iter().map(|(time, _)| at(*time)).collect();
                let values = course.iter().map(|(_, value)| sensor.per_si * value);
                rows(stream, &sensor.entity(entity), &moments, values.collect())?;
            }
        }
        Ok(())
    }

    /// Writes the outcome of an impact that was detected as a line over the time of its data; `at` is the moment of a time after a
    /// stamp \[s, ns\]. A later estimate may correct the outcome.
    pub fn send_outcome(
        &mut self,
        stream: &Branch,
        report: &ImpactReport,
        at: impl Fn(f64, i64) -> Moment,
    ) -> RecordingStreamResult<()> {
        let current = self.current.as_mut();
        let Some(current) = current.filter(|it| it.event_id == report.event_id) else {
            return Ok(());
        };
        let outcome = [report.max_v1, report.residual_v1];
        let is_first = current.outcome.replace(outcome).is_none();
        let times = is_first.then_some(0.0).into_iter().chain([current.until]);
        let moments: Vec<_> = times.map(|secs| at(secs, current.stamp)).collect();
        let values = vec![outcome.map(|it| MM * it); moments.len()];
        rows(stream, OUTCOME, &moments, values.concat())
    }
}

impl ShownSensor {
    fn entity(&self, of: &str) -> String {
        format!("detected/sensors/{}/{of}", self.name)
            .trim_end_matches('/')
            .to_owned()
    }
}

/// The largest value of a course.
fn largest(course: &[(f64, f64)]) -> f64 {
    let values = course.iter().map(|(_, value)| value.abs());
    values.fold(0.0, f64::max)
}

/// Writes the values of some moments, as many for each.
fn rows(
    stream: &Branch,
    entity: &str,
    moments: &[Moment],
    values: Vec<f64>,
) -> RecordingStreamResult<()> {
    if moments.is_empty() {
        return Ok(());
    }
    let each = values.len() / moments.len();
    let columns = Scalars::new(values).columns(vec![each; moments.len()])?;
    stream.send_columns(entity, time_columns(moments.iter().copied()), columns)
}
