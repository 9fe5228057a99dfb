//! What figures with probabilities in rows share: a scale of powers of ten, names of the rows, colours.

use plotters::element::PathElement;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor};

use super::page::{self, Area, CANVAS, Drawn, LEFT, RIGHT, SMALL, TEXT, colour};
use super::units::significant;
use crate::assessment::Action;
use crate::study::risk::RiskResult;

/// Left end of the scale of a chart with rows, behind their names.
pub(super) const ROW_START: i32 = 1080;
/// Right end of the scale, before the numbers of the rows.
pub(super) const ROW_END: i32 = 3520;
/// Lower end of a scale of powers of ten, below its greatest value: probabilities below it are drawn at the edge.
const MOST_DECADES: i32 = 10;

/// The colour of an action in lines and dots.
pub(super) fn line_colour(action: Action) -> RGBColor {
    match action {
        Action::None => colour::FAINT,
        Action::Inspect => RGBColor(66, 160, 216),
        Action::Restrict => RGBColor(222, 150, 10),
        Action::Shore => RGBColor(205, 85, 15),
        Action::Evacuate => RGBColor(122, 28, 40),
    }
}

pub(super) fn percent(result: &RiskResult) -> String {
    format!("{} %", plain(100.0 * result.confidence))
}

/// A number without trailing zeros behind its decimal point.
pub(super) fn plain(value: f64) -> String {
    let text = significant(value, 5);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A horizontal scale of powers of ten.
pub(super) struct DecadeScale {
    from: i32,
    to: i32,
}

impl DecadeScale {
    /// A scale that shows these values, as far as they are positive.
    pub(super) fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let positive = values.filter(|value| value.is_finite() && *value > 0.0);
        let greatest = positive.clone().fold(1e-300, f64::max);
        let least = positive.fold(greatest, f64::min);
        let to = (greatest.log10() + 0.05).ceil() as i32;
        let from = (least.log10() - 0.05).floor() as i32;
        Self {
            from: from.max(to - MOST_DECADES).min(to - 1),
            to,
        }
    }

    pub(super) fn x(&self, value: f64) -> i32 {
        let power = if value > 0.0 {
            value.log10()
        } else {
            f64::NEG_INFINITY
        };
        let part = (power - f64::from(self.from)) / f64::from(self.to - self.from);
        ROW_START + (part.clamp(0.0, 1.0) * f64::from(ROW_END - ROW_START)).round() as i32
    }

    /// Lines and marks from `top` to `bottom`, and the name of the axis below.
    pub(super) fn draw(&self, page: &Area<'_>, top: i32, bottom: i32, name: &str) -> Drawn<()> {
        let style = page::text_style(SMALL, colour::INK, HPos::Center, VPos::Top);
        let every = (self.to - self.from + 7) / 8;
        for power in self.from..=self.to {
            let x = self.x(10_f64.powi(power));
            page.draw(&PathElement::new(
                vec![(x, top), (x, bottom)],
                colour::GRID.stroke_width(4),
            ))?;
            if (power - self.from) % every == 0 {
                page.draw_text(&format!("1e{power}"), &style, (x, bottom + 36))?;
            }
        }
        let ends = vec![(ROW_START, bottom), (ROW_END, bottom)];
        page.draw(&PathElement::new(ends, colour::INK.stroke_width(6)))?;
        let style = page::text_style(TEXT, colour::INK, HPos::Center, VPos::Top);
        page.draw_text(name, &style, ((ROW_START + ROW_END) / 2, bottom + 150))
    }
}

/// What the intervals leave out, in one line.
pub(super) fn not_evaluated(result: &RiskResult) -> String {
    let names: Vec<_> = result.not_evaluated.iter().map(|it| it.what).collect();
    format!("not evaluated: {}", names.join("; "))
}

pub(super) fn row_name(page: &Area<'_>, name: &str, y: i32) -> Drawn<()> {
    let style = page::text_style(TEXT, colour::INK, HPos::Right, VPos::Center);
    page.draw_text(name, &style, (ROW_START - 60, y))
}

/// The rows leave the same margins as the other figures.
const _: () = assert!(ROW_START > LEFT && ROW_END < CANVAS.0 as i32 - RIGHT);
