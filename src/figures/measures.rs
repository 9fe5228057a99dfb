//! The figure that compares the measures of a risk study.

use plotters::element::Rectangle;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

use super::page::{self, CANVAS, Drawn, LegendKey, SMALL, Stroke, colour};
use super::probability_rows::{
    DecadeScale, ROW_END, line_colour, not_evaluated, percent, row_name,
};
use super::units::significant;
use crate::study::risk::{Estimate, MeasureRisk, RiskResult};

/// Greatest height of the row of a measure.
const HEIGHT: i32 = 220;
/// Room for the axis below the rows.
const AXIS: i32 = 420;

/// Annual probability of the mildest and of the most severe action, without and with each measure, beside their targets.
pub(super) fn comparison(
    title: &str,
    result: &RiskResult,
    measures: &[MeasureRisk],
) -> Drawn<String> {
    let shown = match result.annual.len() {
        0 => Vec::new(),
        1 => vec![0],
        count => vec![0, count - 1],
    };
    // Annual probabilities of the shown actions, and how many times that without the measure the last one is.
    type Row<'a> = (&'a str, String, Vec<Estimate>, Option<f64>);
    let mut rows: Vec<Row<'_>> = vec![(
        "without",
        String::new(),
        shown.iter().map(|it| result.annual[*it].annual).collect(),
        None,
    )];
    rows.extend(measures.iter().map(|risk| {
        let annual = shown.iter().map(|it| risk.actions[*it].annual);
        let times = risk.actions.last().and_then(|it| it.times);
        (
            &*risk.measure.name,
            risk.assumption(),
            annual.collect(),
            times,
        )
    }));
    let targets = shown.iter().map(|it| result.annual[*it].target.probability);
    let estimates = rows.iter().flat_map(|(_, _, estimates, _)| estimates);
    let values = estimates.flat_map(|it| [it.value, it.low, it.high]);
    let scale = DecadeScale::of(values.chain(targets).collect::<Vec<_>>().into_iter());
    let mut legend = Vec::new();
    for &index in &shown {
        let risk = &result.annual[index];
        let tone = line_colour(risk.action);
        legend.push((LegendKey::Fill(tone), format!("{} or worse", risk.action)));
        legend.push((
            LegendKey::Line(Stroke::dashed(tone, 10)),
            format!("target, beta {}", risk.target.beta),
        ));
    }
    let lines = format!(
        "the same vehicles without and with each measure; dots: estimate, bars: {} interval of the simulation",
        percent(result)
    );
    page::draw(|page| {
        let heading = "What each measure changes: probability in one year";
        let top = page::heading(
            page,
            heading,
            [title, &lines, &not_evaluated(result)],
            &legend,
        )? + 90;
        let height = HEIGHT.min((CANVAS.1 as i32 - AXIS - top) / rows.len() as i32);
        let bottom = top + height * rows.len() as i32;
        scale.draw(page, top - 30, bottom, "probability in one year")?;
        for &index in &shown {
            let risk = &result.annual[index];
            let x = scale.x(risk.target.probability);
            let line = vec![(x, top - 30), (x, bottom)];
            Stroke::dashed(line_colour(risk.action), 10).draw(page, line)?;
        }
        for (row, (name, assumption, estimates, times)) in rows.iter().enumerate() {
            let y = top + height * row as i32 + height / 2 - 15;
            row_name(page, &name.replace('_', " "), y)?;
            for (place, (estimate, &index)) in estimates.iter().zip(&shown).enumerate() {
                let tone = line_colour(result.annual[index].action);
                let y = y + if place == 0 { -38 } else { 38 };
                let ends = [scale.x(estimate.low), scale.x(estimate.high)];
                page.draw(&Rectangle::new(
                    [(ends[0], y - 24), (ends[1].max(ends[0] + 4), y + 24)],
                    tone.mix(0.35).filled(),
                ))?;
                if estimate.value > 0.0 {
                    page::dot(page, (scale.x(estimate.value), y), tone)?;
                }
            }
            let Some(last) = estimates.last() else {
                continue;
            };
            let number = match (last.value > 0.0, times) {
                (true, Some(times)) => {
                    format!("{:.1e}   x {}", last.value, significant(*times, 2))
                }
                (true, None) => format!("{:.1e}", last.value),
                (false, _) => format!("none seen; below {:.0e}", last.high),
            };
            let style = page::text_style(SMALL, colour::INK, HPos::Left, VPos::Center);
            page.draw_text(assumption, &style, (ROW_END + 60, y - 42))?;
            page.draw_text(&number, &style, (ROW_END + 60, y + 38))?;
        }
        Ok(())
    })
}
