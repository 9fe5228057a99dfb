//! The figures of an estimate: the forecast as the data improve it, and for each sensor what it has read against what is
//! predicted.

use std::path::{Path, PathBuf};

use plotters::style::RGBColor;

use super::chart::{Band, Curve, Mark, TimeChart};
use super::page::{Drawn, LegendKey, Stroke, colour};
use super::units::{Unit, significant};
use super::{FigureError, drawn, write_all};
use crate::estimation::{
    ComparedMean, CredibleInterval, ImpactEstimate, RecordedImpact, SensorComparison,
};
use crate::sensors::Sensor;

/// The band of the peak displacement.
const PEAK_BAND: RGBColor = RGBColor(190, 218, 238);
/// The band of the displacement that remains.
const RESIDUAL_BAND: RGBColor = RGBColor(248, 212, 184);

/// Name of the figure of the forecast.
const FORECAST: &str = "estimate_forecast";

/// Peak displacement that is drawn, as a multiple of the upper end of the last interval: the first intervals may be so wide
/// that nothing else could be seen. What is beyond is cut off.
const WIDEST: f64 = 3.0;

/// An estimate, and up to when data were used for it.
#[derive(Debug, Clone, Copy)]
pub struct TimedEstimate<'a> {
    /// Data up to this time after the detected instant of contact are used \[s\].
    pub since_contact: f64,
    /// The estimate.
    pub estimate: &'a ImpactEstimate,
}

impl<'a> TimedEstimate<'a> {
    /// All estimates of an impact that was detected at `contact` \[s\], in the order of their data.
    pub fn all(estimates: impl IntoIterator<Item = &'a ImpactEstimate>, contact: f64) -> Vec<Self> {
        let timed = |estimate: &'a ImpactEstimate| Self {
            since_contact: estimate.data_until - contact,
            estimate,
        };
        estimates.into_iter().map(timed).collect()
    }
}

/// An impact that was estimated, and the sensors that detected it.
#[derive(Debug, Clone, Copy)]
pub struct EstimateFigures<'a> {
    /// One line that describes the column and the data.
    pub title: &'a str,
    /// The sensors.
    pub sensors: &'a [Sensor],
    /// The impact.
    pub impact: &'a RecordedImpact,
}

/// Draws the figures of an estimate into `folder`, which is created if it does not exist, and returns the files written: SVG
/// and PNG alternately.
///
/// # Errors
/// See [`FigureError`].
pub fn draw_estimate(
    folder: &Path,
    figures: &EstimateFigures<'_>,
) -> Result<Vec<PathBuf>, FigureError> {
    write_all(folder, estimate_svg(figures)?)
}

/// Every figure of an estimate as SVG, by its name: `estimate_forecast`, and `sensor_NAME` for each sensor that has read
/// something.
///
/// # Errors
/// The plotting library fails.
pub fn estimate_svg(figures: &EstimateFigures<'_>) -> Result<Vec<(String, String)>, FigureError> {
    let contact = figures.impact.detection.contact.time;
    let estimates = TimedEstimate::all(&figures.impact.estimates, contact);
    let mut all = vec![(
        FORECAST.to_owned(),
        forecast_svg(figures.title, &estimates)?,
    )];
    let compared = &figures.impact.comparisons;
    all.extend(comparison_svg(figures.title, figures.sensors, compared)?);
    Ok(all)
}

/// For each sensor that has read something what it has read, and what is predicted for it, as SVG, by its name: `sensor_NAME`.
/// `title` describes the column and the data.
///
/// # Errors
/// The plotting library fails.
pub fn comparison_svg(
    title: &str,
    sensors: &[Sensor],
    comparisons: &[SensorComparison],
) -> Result<Vec<(String, String)>, FigureError> {
    let compared = comparisons.iter().filter(|it| !it.means.is_empty());
    let known = compared.filter_map(|it| Some((sensors.get(it.sensor)?, it)));
    known
        .map(|(sensor, comparison)| {
            let name = format!("sensor_{}", sensor.name);
            let svg = drawn(&name, compared_sensor(title, sensor, comparison))?;
            Ok((name, svg))
        })
        .collect()
}

/// The forecast of the displacements as the data improve it, as SVG. `title` describes the column and the data.
///
/// # Errors
/// The plotting library fails.
pub fn forecast_svg(title: &str, estimates: &[TimedEstimate<'_>]) -> Result<String, FigureError> {
    drawn(FORECAST, forecast(title, estimates))
}

/// What one sensor has read, and what is predicted for it.
fn compared_sensor(
    sub_title: &str,
    sensor: &Sensor,
    comparison: &SensorComparison,
) -> Drawn<String> {
    let means = &comparison.means;
    let values = means
        .iter()
        .flat_map(|it| [it.measured, it.predicted.low, it.predicted.high]);
    let largest = values
        .filter(|it| it.is_finite())
        .fold(0.0, |largest: f64, it| largest.max(it.abs()));
    let inside = means.iter().filter(|it| is_inside(it)).count();
    let reservation = match comparison.counts {
        true => "",
        false => "; does not count, because it contradicts the other sensors",
    };
    let key = format!(
        "{} of {} means are within the band{reservation}",
        inside,
        means.len()
    );
    let title = format!("Sensor {}: measured and predicted", sensor.name);
    let points = |of: fn(&ComparedMean) -> f64| means.iter().map(|it| (it.time, of(it))).collect();
    TimeChart {
        title: &title,
        lines: [sub_title, &key],
        quantity: &sensor.quantity.word().replace('_', " "),
        unit: Unit::of_sensor(sensor.quantity, largest),
        span: (
            means.first().map_or(0.0, |it| it.time),
            means.last().map_or(0.0, |it| it.time),
        ),
        bands: vec![Band {
            name: "predicted, 90 % interval".to_owned(),
            points: means
                .iter()
                .map(|it| (it.time, it.predicted.low, it.predicted.high))
                .collect(),
            colour: PEAK_BAND,
        }],
        curves: vec![
            Curve::line(
                "predicted",
                points(|it| it.predicted.mean),
                Stroke::solid(colour::IMPACT_POINT, 14),
            ),
            // It gives the axis its range; what is seen are the rings.
            Curve::line(
                "",
                points(|it| it.measured),
                Stroke::solid(colour::FAINT, 4),
            ),
        ],
        marks: means
            .iter()
            .map(|it| Mark {
                time: it.time,
                value: it.measured,
                colour: colour::IMPACTOR,
                text: None,
            })
            .collect(),
        arrows: Vec::new(),
        keys: vec![(
            LegendKey::Ring(colour::IMPACTOR),
            "measured, means over 1 ms and longer".to_owned(),
        )],
        events: Vec::new(),
    }
    .draw()
}

/// Largest and remaining displacement over the time up to which data were used.
fn forecast(title: &str, estimates: &[TimedEstimate<'_>]) -> Drawn<String> {
    let over_time = |of: fn(&ImpactEstimate) -> CredibleInterval| -> Vec<(f64, CredibleInterval)> {
        let each = estimates
            .iter()
            .map(|it| (it.since_contact, of(it.estimate)));
        each.filter(|(_, it)| it.low.is_finite() && it.high.is_finite() && it.mean.is_finite())
            .collect()
    };
    let peak = over_time(|it| it.peak_v1);
    let residual = over_time(|it| it.residual_v1);
    let last = peak.last().map_or(0.0, |(_, it)| it.high.max(it.mean));
    let (low, high) = (-last.abs(), WIDEST * last.abs());
    let unit = Unit::length(high);
    let in_words = |name: &str, last: Option<&(f64, CredibleInterval)>| match last {
        Some((_, it)) => format!(
            "{name} {} ({} to {})",
            unit.show(it.mean),
            significant(unit.of(it.low), 4),
            unit.show(it.high)
        ),
        None => format!("{name} unknown"),
    };
    let key = format!(
        "with all data: {}, {}",
        in_words("peak", peak.last()),
        in_words("residual", residual.last())
    );
    let until = peak.last().map_or(0.0, |(time, _)| *time);
    let mean = |name: &str, of: &[(f64, CredibleInterval)], stroke| {
        let points = of
            .iter()
            .map(|(time, it)| (*time, it.mean.clamp(low, high)));
        Curve::line(name, points.collect(), stroke)
    };
    let band = |name: &str, of: &[(f64, CredibleInterval)], colour| Band {
        name: name.to_owned(),
        points: of
            .iter()
            .map(|(time, it)| (*time, it.low.clamp(low, high), it.high.clamp(low, high)))
            .collect(),
        colour,
    };
    TimeChart {
        title: "Forecast of the displacement v₁, by the data up to time t after contact",
        lines: [title, &key],
        quantity: "displacement v₁",
        unit,
        span: (0.0, until),
        bands: vec![
            band("peak, 90 % interval", &peak, PEAK_BAND),
            band("residual, 90 % interval", &residual, RESIDUAL_BAND),
        ],
        curves: vec![
            mean("peak", &peak, Stroke::solid(colour::IMPACT_POINT, 14)),
            mean("residual", &residual, Stroke::solid(colour::IMPACTOR, 14)),
        ],
        ..TimeChart::default()
    }
    .draw()
}

fn is_inside(mean: &ComparedMean) -> bool {
    (mean.predicted.low..=mean.predicted.high).contains(&mean.measured)
}
