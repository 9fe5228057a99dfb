//! The figures of a risk study: fragility curves, probabilities in the period, sensitivities.

use std::path::{Path, PathBuf};

use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::axis::PlotAxis;
use super::chart::axes;
use super::measures::comparison;
use super::page::{self, Area, CANVAS, Drawn, LegendKey, SMALL, Stroke, colour};
use super::probability_rows::{
    DecadeScale, ROW_END, ROW_START, line_colour, not_evaluated, percent, plain, row_name,
};
use super::units::significant;
use super::{FigureError, drawn, write_all};
use crate::study::risk::{ActionSensitivity, Estimate, FragilityCurve, MeasureRisk, RiskResult};

/// Fewest samples of an interval of speed for which a point is drawn.
const FEWEST_SAMPLES: u64 = 20;
/// Points of a fitted curve.
const CURVE_POINTS: u32 = 240;
/// Colours of the classes of vehicles, which the colour-blind can distinguish (Okabe and Ito, and lighter tones of them).
const CLASS_COLOURS: [RGBColor; 8] = [
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(240, 228, 66),
    RGBColor(230, 159, 0),
    RGBColor(213, 94, 0),
    RGBColor(136, 34, 85),
    RGBColor(150, 150, 150),
];

/// Draws the figures of a risk study into `folder`, which is created if it does not exist, and returns the files written:
/// SVG and PNG alternately. `title` describes column and scenario; without measures there is no figure that compares them.
///
/// # Errors
/// See [`FigureError`].
pub fn draw_risk(
    folder: &Path,
    title: &str,
    result: &RiskResult,
    measures: &[MeasureRisk],
) -> Result<Vec<PathBuf>, FigureError> {
    write_all(folder, risk_svg(title, result, measures)?)
}

/// The same figures as SVG, by their names.
///
/// # Errors
/// The study has no sample, or the plotting library fails.
pub fn risk_svg(
    title: &str,
    result: &RiskResult,
    measures: &[MeasureRisk],
) -> Result<Vec<(String, String)>, FigureError> {
    if result.counts.impacts == 0 {
        return Err(FigureError::NoSamples);
    }
    let mut figures = vec![
        ("risk_probability", probabilities(title, result)),
        ("risk_fragility", fragility(title, result)),
        ("risk_sensitivity", sensitivity(title, result)),
    ];
    if !measures.is_empty() {
        figures.push(("risk_measures", comparison(title, result, measures)));
    }
    figures
        .into_iter()
        .map(|(name, svg)| drawn(name, svg).map(|svg| (name.to_owned(), svg)))
        .collect()
}

/// Fragility curves of the whole traffic with the bands of their points.
fn fragility(title: &str, result: &RiskResult) -> Drawn<String> {
    // An action that no sample reached has no curve; the figure of the probabilities shows its bound.
    let seen = |curve: &FragilityCurve| {
        let mut shares = curve.points.iter().filter_map(|point| point.probability);
        shares.any(|share| share.value > 0.0)
    };
    let curves: Vec<&FragilityCurve> = result
        .fragility
        .iter()
        .filter(|it| it.vehicle.is_none() && seen(it))
        .collect();
    let ends = curves
        .iter()
        .flat_map(|curve| &curve.points)
        .filter(|it| it.samples >= FEWEST_SAMPLES);
    let fastest = ends.map(|point| point.speed[1]).fold(1e-3, f64::max);
    let x = PlotAxis::between(0.0, fastest, 10);
    let drawn_points = curves.iter().flat_map(|curve| &curve.points);
    let shares = drawn_points
        .filter(|point| point.samples >= FEWEST_SAMPLES)
        .filter_map(|point| point.probability);
    let greatest = shares.map(|share| share.high).fold(0.01, f64::max);
    let highest = if greatest > 0.5 { 1.0 } else { 1.2 * greatest };
    let y = PlotAxis::between(0.0, highest, 5);
    let legend: Vec<_> = curves
        .iter()
        .map(|curve| {
            let stroke = Stroke::solid(line_colour(curve.action), 14);
            (
                LegendKey::Line(stroke),
                format!("{} or worse", curve.action),
            )
        })
        .collect();
    let lines = format!(
        "dots: share of the samples in an interval of speed, with its {} interval as a band; lines: fitted lognormal curves",
        percent(result)
    );
    page::draw(|page| {
        let top = page::heading(
            page,
            "Fragility: probability of an action over the speed at the column",
            [title, &lines],
            &legend,
        )?;
        let (_, below) = page.split_vertically(top + 40);
        let plot = axes(
            &below,
            &x,
            &y,
            ["speed at the column [m/s]", "probability given an impact"],
        )?;
        let place = |speed: f64, p: f64| {
            plot.backend_coord(&(speed.clamp(0.0, x.to), p.clamp(0.0, highest)))
        };
        for curve in &curves {
            let tone = line_colour(curve.action);
            let points: Vec<(f64, Estimate)> = curve
                .points
                .iter()
                .filter(|point| point.samples >= FEWEST_SAMPLES)
                .filter_map(|point| {
                    Some((0.5 * (point.speed[0] + point.speed[1]), point.probability?))
                })
                .collect();
            let lower = points.iter().map(|(speed, p)| place(*speed, p.low));
            let upper = points.iter().rev().map(|(speed, p)| place(*speed, p.high));
            page.draw(&Polygon::new(
                lower.chain(upper).collect::<Vec<_>>(),
                tone.mix(0.18).filled(),
            ))?;
            if let Some(fit) = &curve.fit {
                let line = (0..=CURVE_POINTS)
                    .map(|it| x.to * f64::from(it) / f64::from(CURVE_POINTS))
                    .map(|speed| place(speed, fit.probability(speed)));
                Stroke::solid(tone, 14).draw(page, line.collect())?;
            }
            for (speed, p) in &points {
                let centre = place(*speed, p.value);
                page.draw(&Circle::new(centre, 24, WHITE.filled()))?;
                page.draw(&Circle::new(centre, 17, tone.filled()))?;
            }
        }
        Ok(())
    })
}

/// Probability in the period by action with intervals, and the shares of the classes of vehicles in each.
fn probabilities(title: &str, result: &RiskResult) -> Drawn<String> {
    let mut rows: Vec<(String, RGBColor, Estimate)> =
        vec![("impact".to_owned(), colour::FAINT, result.impact_in_period)];
    rows.extend(result.actions.iter().map(|risk| {
        let name = format!("{} or worse", risk.action);
        (name, line_colour(risk.action), risk.in_period)
    }));
    let values = rows.iter().flat_map(|(.., it)| [it.value, it.high, it.low]);
    let scale = DecadeScale::of(values.collect::<Vec<_>>().into_iter());
    let years = plain(result.exposure.years);
    let period = match years.as_str() {
        "1" => "a year".to_owned(),
        years => format!("{years} years"),
    };
    let lines = format!(
        "{} vehicles per day; dots: estimate, bars: {} interval of the simulation; below: which vehicles contribute",
        plain(result.exposure.vehicles_per_day),
        percent(result)
    );
    let legend: Vec<_> = result
        .classes
        .iter()
        .enumerate()
        .map(|(index, class)| {
            (
                LegendKey::Fill(class_colour(index)),
                class.vehicle.to_owned(),
            )
        })
        .collect();
    let heading = format!("Probability of at least one such impact in {period}");
    page::draw(|page| {
        let top = page::heading(
            page,
            &heading,
            [title, &lines, &not_evaluated(result)],
            &legend,
        )? + 90;
        let height = 190;
        let bottom = top + height * rows.len() as i32;
        scale.draw(page, top - 30, bottom, &format!("probability in {period}"))?;
        for (row, (name, tone, estimate)) in rows.iter().enumerate() {
            let y = top + height * row as i32 + height / 2 - 15;
            row_name(page, name, y)?;
            let ends = [scale.x(estimate.low), scale.x(estimate.high)];
            page.draw(&Rectangle::new(
                [(ends[0], y - 26), (ends[1].max(ends[0] + 4), y + 26)],
                tone.mix(0.35).filled(),
            ))?;
            let number = match estimate.value > 0.0 {
                true => {
                    page::dot(page, (scale.x(estimate.value), y), *tone)?;
                    let years = result.exposure.years;
                    let rate = -(1.0 - estimate.value).ln() / years;
                    format!(
                        "{:.2e}   once in {}",
                        estimate.value,
                        years_in_words(1.0 / rate)
                    )
                }
                false => format!("none seen; below {:.1e}", estimate.high),
            };
            let style = page::text_style(SMALL, colour::INK, HPos::Left, VPos::Center);
            page.draw_text(&number, &style, (ROW_END + 60, y))?;
        }
        contributions(page, result, bottom + 330)
    })
}

fn class_colour(index: usize) -> RGBColor {
    CLASS_COLOURS[index % CLASS_COLOURS.len()]
}

fn years_in_words(years: f64) -> String {
    match years {
        years if years < 1e4 => format!("{} years", significant(years, 3)),
        years if years < 1e6 => format!("{} thousand years", significant(years / 1e3, 3)),
        years if years < 1e9 => format!("{} million years", significant(years / 1e6, 3)),
        years => format!("{years:.0e} years"),
    }
}

/// Shares of the classes in the events of each action, as bars of equal length.
fn contributions(page: &Area<'_>, result: &RiskResult, top: i32) -> Drawn<()> {
    let height = 130;
    let style = page::text_style(SMALL, colour::FAINT, HPos::Left, VPos::Center);
    for (row, risk) in result.actions.iter().enumerate() {
        let y = top + height * row as i32 + height / 2;
        row_name(page, &format!("{} or worse", risk.action), y)?;
        let shares: Vec<f64> = result
            .classes
            .iter()
            .map(|class| class.contribution[row].unwrap_or(0.0))
            .collect();
        let total: f64 = shares.iter().sum();
        if total <= 0.0 {
            page.draw_text("none seen", &style, (ROW_START + 20, y))?;
            continue;
        }
        let mut before = 0.0;
        let x = |share: f64| {
            ROW_START + (share / total * f64::from(ROW_END - ROW_START)).round() as i32
        };
        for (index, share) in shares.into_iter().enumerate() {
            let place = [(x(before), y - 44), (x(before + share), y + 44)];
            page.draw(&Rectangle::new(place, class_colour(index).filled()))?;
            before += share;
        }
        page.draw_text("100 %", &style, (ROW_END + 60, y))?;
    }
    Ok(())
}

/// The most severe event that was seen, in the lowest and in the highest tenth of every input.
fn sensitivity(title: &str, result: &RiskResult) -> Drawn<String> {
    let index = result.telling_action().unwrap_or(0);
    let sensitivity: &ActionSensitivity = &result.sensitivity[index];
    let mean = result.actions[index].given_departure.value;
    let ends = sensitivity
        .inputs
        .iter()
        .flat_map(|it| [it.low.value, it.high.value]);
    let scale = DecadeScale::of(ends.chain([mean]).collect::<Vec<_>>().into_iter());
    let (low_tone, high_tone) = (RGBColor(86, 180, 233), RGBColor(213, 94, 0));
    let legend = [
        (
            LegendKey::Ring(low_tone),
            "input in its lowest tenth".to_owned(),
        ),
        (
            LegendKey::Ring(high_tone),
            "input in its highest tenth".to_owned(),
        ),
        (
            LegendKey::Line(Stroke::dashed(colour::INK, 8)),
            "all vehicles".to_owned(),
        ),
    ];
    let lines = "per vehicle on a course to the column, with intervals; of the classes: the least and the most dangerous one";
    let heading = format!(
        "Which input matters: probability of {} or worse",
        sensitivity.action
    );
    page::draw(|page| {
        let top = page::heading(page, &heading, [title, lines], &legend)? + 60;
        let count = sensitivity.inputs.len().max(1) as i32;
        let bottom = CANVAS.1 as i32 - 320;
        let height = ((bottom - top) / count).min(240);
        let bottom = top + height * count;
        scale.draw(
            page,
            top,
            bottom,
            "probability per vehicle that leaves the road",
        )?;
        let x = scale.x(mean);
        Stroke::dashed(colour::INK, 8).draw(page, vec![(x, top), (x, bottom)])?;
        for (row, effect) in sensitivity.inputs.iter().enumerate() {
            let y = top + height * row as i32 + height / 2;
            row_name(page, &effect.input.replace('_', " "), y)?;
            let [low, high] = [effect.low.value, effect.high.value].map(|it| scale.x(it));
            let bar = [(low.min(high), y - 34), (low.max(high), y + 34)];
            page.draw(&Rectangle::new(bar, colour::GRID.filled()))?;
            for (estimate, tone, x) in [(effect.low, low_tone, low), (effect.high, high_tone, high)]
            {
                let whisker = vec![(scale.x(estimate.low), y), (scale.x(estimate.high), y)];
                page.draw(&PathElement::new(whisker, tone.stroke_width(10)))?;
                page::dot(page, (x, y), tone)?;
            }
            let text = match effect.classes {
                Some([low, high]) => format!("{low}, {high}"),
                None if effect.low.value + effect.high.value == 0.0 => {
                    "none seen at either end".to_owned()
                }
                None if effect.low.value > 0.0 && effect.high.value > 0.0 => {
                    format!(
                        "times {}",
                        significant(effect.high.value / effect.low.value, 2)
                    )
                }
                None => String::new(),
            };
            let style = page::text_style(SMALL, colour::INK, HPos::Left, VPos::Center);
            page.draw_text(&text, &style, (ROW_END + 60, y))?;
        }
        Ok(())
    })
}
