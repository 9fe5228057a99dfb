//! The page of every figure: canvas, font, colours, heading and legend.

use std::io;

use plotters::coord::Shift;
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::prelude::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontStyle, IntoFont, RGBColor, ShapeStyle, TextStyle, WHITE, register_font,
};

/// Size of the canvas. Plotters places everything at integer coordinates, so the canvas is finer than the pixels shown.
pub(super) const CANVAS: (u32, u32) = (4800, 3000);
/// Width and height of the displayed SVG.
const SHOWN: (u32, u32) = (960, 600);
/// Distance from the left edge to the axis.
pub(super) const LEFT: i32 = 460;
/// Distance from the end of the axis to the right edge.
pub(super) const RIGHT: i32 = 140;
/// Room for the marks and the name of the horizontal axis.
pub(super) const BOTTOM: i32 = 300;

/// Text sizes as plotters measures them: 1.24 times those of the SVG.
pub(super) const TITLE: u32 = 116;
pub(super) const TEXT: u32 = 84;
pub(super) const SMALL: u32 = 76;

/// The embedded font under the name that viewers know; Verdana has nearly the same widths.
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn<T> = Result<T, DrawingAreaErrorKind<io::Error>>;

/// Colours that the colour-blind can distinguish (Okabe and Ito), one per quantity throughout the figures.
pub(super) mod colour {
    use plotters::style::RGBColor;

    use crate::column::HINGES;

    pub const INK: RGBColor = RGBColor(30, 30, 30);
    pub const FAINT: RGBColor = RGBColor(120, 120, 120);
    pub const GRID: RGBColor = RGBColor(225, 225, 225);
    pub const SURFACE: RGBColor = RGBColor(240, 240, 240);

    pub const IMPACT_POINT: RGBColor = RGBColor(0, 114, 178);
    pub const IMPACTOR: RGBColor = RGBColor(213, 94, 0);
    pub const TOP: RGBColor = RGBColor(0, 158, 115);
    /// Colours of the bars, the lower one first.
    pub const BARS: [RGBColor; 2] = [RGBColor(0, 114, 178), RGBColor(230, 159, 0)];
    pub const CONTACT: RGBColor = RGBColor(0, 114, 178);
    pub const IMPACT_IMPULSE: RGBColor = RGBColor(213, 94, 0);

    /// Colours of the hinges, in the order of [`HINGE_PLACES`](crate::observables::HINGE_PLACES).
    pub const HINGE: [RGBColor; HINGES] = *[
        RGBColor(230, 159, 0),
        RGBColor(0, 80, 140),
        RGBColor(0, 158, 115),
        RGBColor(213, 94, 0),
        RGBColor(204, 121, 167),
        RGBColor(86, 180, 233),
    ]
    .first_chunk()
    .expect("a colour for each hinge");

    /// Colours of the springs of a vehicle, front first.
    pub const SPRINGS: [RGBColor; 3] = [
        RGBColor(213, 94, 0),
        RGBColor(0, 114, 178),
        RGBColor(0, 158, 115),
    ];

    pub const IMPACT_LOSS: RGBColor = RGBColor(204, 121, 167);
    pub const PLASTIC: RGBColor = RGBColor(230, 159, 0);
    pub const CRUSH: RGBColor = RGBColor(213, 94, 0);
    pub const VEHICLE_ELASTIC: RGBColor = RGBColor(240, 228, 66);
    pub const DAMPING: RGBColor = RGBColor(150, 150, 150);
    pub const ELASTIC: RGBColor = RGBColor(0, 158, 115);
    pub const KINETIC: RGBColor = RGBColor(86, 180, 233);
}

/// The style of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub colour: RGBColor,
    pub width: u32,
    /// Length of the dashes and of the spaces between them; `None`: solid.
    pub dashes: Option<(i32, i32)>,
}

impl Stroke {
    pub const fn solid(colour: RGBColor, width: u32) -> Self {
        Self {
            colour,
            width,
            dashes: None,
        }
    }

    pub const fn dashed(colour: RGBColor, width: u32) -> Self {
        Self {
            colour,
            width,
            dashes: Some((52, 40)),
        }
    }

    /// Draws the line through points of the canvas.
    pub fn draw(self, area: &Area<'_>, points: Vec<(i32, i32)>) -> Drawn<()> {
        let style = self.colour.stroke_width(self.width);
        match self.dashes {
            None => area.draw(&PathElement::new(points, style)),
            Some((dash, space)) => area.draw(&DashedPathElement::new(points, dash, space, style)),
        }
    }
}

/// The symbol of an entry of the legend.
#[derive(Debug, Clone, Copy)]
pub(super) enum LegendKey {
    Line(Stroke),
    Fill(RGBColor),
    /// A dot with a white core.
    Ring(RGBColor),
    Arrow(RGBColor),
}

/// Draws a figure on an empty page and returns the SVG.
pub(super) fn draw(draw: impl FnOnce(&Area<'_>) -> Drawn<()>) -> Drawn<String> {
    // The font is part of the program and is parsed in the tests: registering it cannot fail for a user.
    let _ = register_font(FONT, FontStyle::Normal, dejavu::sans::regular());
    let _ = register_font(FONT, FontStyle::Bold, dejavu::sans::bold());
    let mut body = String::new();
    {
        let area = SVGBackend::with_string(&mut body, CANVAS).into_drawing_area();
        area.fill(&WHITE)?;
        draw(&area)?;
        area.present()?;
    }
    // Plotters writes the size of the canvas as the displayed size; the outer element gives the latter.
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" \
         stroke-linejoin=\"round\">\n{body}</svg>\n",
        SHOWN.0, SHOWN.1, CANVAS.0, CANVAS.1
    ))
}

/// A text style with its size, colour and anchor.
pub(super) fn text_style(
    size: u32,
    colour: RGBColor,
    horizontal: HPos,
    vertical: VPos,
) -> TextStyle<'static> {
    TextStyle {
        font: (FONT, size).into_font(),
        color: colour.to_backend_color(),
        pos: Pos::new(horizontal, vertical),
    }
}

/// Width of a text on the canvas.
pub(super) fn width(area: &Area<'_>, text: &str, style: &TextStyle<'_>) -> Drawn<i32> {
    Ok(area.estimate_text_size(text, style)?.0 as i32)
}

/// Draws title, the lines below it and the legend; returns the height used.
pub(super) fn heading<const LINES: usize>(
    area: &Area<'_>,
    title: &str,
    lines: [&str; LINES],
    legend: &[(LegendKey, String)],
) -> Drawn<i32> {
    let start = LEFT / 2;
    let room = CANVAS.0 as i32 - start - RIGHT;
    let bold = TextStyle::from((FONT, TITLE, FontStyle::Bold).into_font())
        .color(&colour::INK)
        .pos(Pos::new(HPos::Left, VPos::Top));
    let plain = text_style(TEXT, colour::FAINT, HPos::Left, VPos::Top);
    area.draw_text(&fitted(area, title, &bold, room)?, &bold, (start, 60))?;
    let mut y = 208;
    for line in lines {
        area.draw_text(&fitted(area, line, &plain, room)?, &plain, (start, y))?;
        y += 108;
    }
    draw_legend(area, legend, y + 48)
}

/// The text, shortened until it fits.
fn fitted(area: &Area<'_>, text: &str, style: &TextStyle<'_>, room: i32) -> Drawn<String> {
    let mut fitting = text.to_owned();
    while width(area, &fitting, style)? > room && !fitting.is_empty() {
        let mut shorter: Vec<char> = fitting.trim_end_matches("...").chars().collect();
        // Long texts lose a tenth at a time, which bounds the number of measurements.
        shorter.truncate(shorter.len().saturating_sub(1 + shorter.len() / 10));
        if shorter.is_empty() {
            break;
        }
        fitting = shorter.into_iter().collect::<String>() + "...";
    }
    Ok(fitting)
}

/// Draws the legend in rows above the plot and returns the height below them.
fn draw_legend(area: &Area<'_>, entries: &[(LegendKey, String)], top: i32) -> Drawn<i32> {
    const ROW: i32 = 116;
    const SPACE: i32 = 112;
    let style = text_style(TEXT, colour::INK, HPos::Left, VPos::Center);
    let start = LEFT / 2;
    let (mut x, mut y) = (start, top);
    for (key, name) in entries {
        let swatch = match key {
            LegendKey::Line(_) | LegendKey::Fill(_) => 192,
            LegendKey::Ring(_) | LegendKey::Arrow(_) => 68,
        };
        let length = swatch + 32 + width(area, name, &style)?;
        if x > start && x + length > CANVAS.0 as i32 - RIGHT {
            (x, y) = (start, y + ROW);
        }
        draw_key(area, *key, x, y, swatch)?;
        area.draw_text(name, &style, (x + swatch + 32, y))?;
        x += length + SPACE;
    }
    Ok(if entries.is_empty() {
        top
    } else {
        y + ROW / 2 + 28
    })
}

fn draw_key(area: &Area<'_>, key: LegendKey, x: i32, y: i32, length: i32) -> Drawn<()> {
    match key {
        LegendKey::Line(stroke) => stroke.draw(area, vec![(x, y), (x + length, y)]),
        LegendKey::Fill(colour) => area.draw(&Rectangle::new(
            [(x, y - 34), (x + length, y + 34)],
            colour.filled(),
        )),
        LegendKey::Ring(colour) => ring(area, (x + length / 2, y), colour),
        LegendKey::Arrow(colour) => arrow(area, x + length / 2, y + 44, y - 44, colour),
    }
}

/// A dot with a white core.
pub(super) fn ring(area: &Area<'_>, centre: (i32, i32), colour: RGBColor) -> Drawn<()> {
    area.draw(&Circle::new(centre, 30, colour.filled()))?;
    area.draw(&Circle::new(centre, 16, WHITE.filled()))
}

/// A filled dot with a white rim.
pub(super) fn dot(area: &Area<'_>, centre: (i32, i32), colour: RGBColor) -> Drawn<()> {
    area.draw(&Circle::new(centre, 34, WHITE.filled()))?;
    area.draw(&Circle::new(centre, 26, colour.filled()))
}

/// An upright arrow.
pub(super) fn arrow(area: &Area<'_>, x: i32, foot: i32, head: i32, colour: RGBColor) -> Drawn<()> {
    let barb = 52.min(foot - head);
    let line: ShapeStyle = colour.stroke_width(12);
    area.draw(&PathElement::new(
        vec![(x, foot), (x, head + barb / 2)],
        line,
    ))?;
    area.draw(&Polygon::new(
        vec![
            (x, head),
            (x - barb / 2, head + barb),
            (x + barb / 2, head + barb),
        ],
        colour.filled(),
    ))
}

/// Text on a background that keeps it readable over lines, with its lower centre at `place`, shifted into the range of x.
pub(super) fn label(
    area: &Area<'_>,
    text: &str,
    place: (i32, i32),
    range: (i32, i32),
    colour: RGBColor,
) -> Drawn<()> {
    let style = text_style(SMALL, colour, HPos::Left, VPos::Center);
    let length = width(area, text, &style)?;
    let left = (place.0 - length / 2)
        .min(range.1 - length - 20)
        .max(range.0 + 20);
    let middle = place.1 - 44;
    area.draw(&Rectangle::new(
        [(left - 12, middle - 44), (left + length + 12, middle + 44)],
        WHITE.mix(0.85).filled(),
    ))?;
    area.draw_text(text, &style, (left, middle))
}
