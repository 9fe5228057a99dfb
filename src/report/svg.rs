//! Drawings to scale: lines, areas and texts in a small coordinate system, as SVG.

use maud::{Markup, html};

/// A point of a drawing: to the right and down.
pub(super) type Spot = (f64, f64);

/// Ink, faint ink and the colours of the figures.
pub(super) const INK: &str = "#1e1e1e";
pub(super) const FAINT: &str = "#787878";
pub(super) const STEEL: &str = "#c9d3dc";
pub(super) const RED: &str = "#b3261e";
pub(super) const BLUE: &str = "#0072b2";
pub(super) const ORANGE: &str = "#d55e00";

fn number(value: f64) -> String {
    // Adding zero makes -0 and 0 the same.
    format!("{:.1}", value + 0.0)
}

fn points(spots: &[Spot]) -> String {
    let each = spots
        .iter()
        .map(|(x, y)| format!("{},{}", number(*x), number(*y)));
    each.collect::<Vec<_>>().join(" ")
}

/// A line through points; `dashes` as in SVG, empty for none.
pub(super) fn line(spots: &[Spot], colour: &str, width: f64, dashes: &str) -> Markup {
    html! {
        polyline points=(points(spots)) fill="none" stroke=(colour) stroke-width=(width)
            stroke-dasharray=[(!dashes.is_empty()).then_some(dashes)] {}
    }
}

/// An area with an edge.
pub(super) fn area(spots: &[Spot], fill: &str, colour: &str, width: f64) -> Markup {
    html! { polygon points=(points(spots)) fill=(fill) stroke=(colour) stroke-width=(width) {} }
}

/// An area between closed lines, such as a section with a hole.
pub(super) fn area_between(rings: &[Vec<Spot>], fill: &str, colour: &str, width: f64) -> Markup {
    let lines = rings.iter().map(|ring| format!("M{}Z", points(ring)));
    let path: String = lines.collect();
    html! { path d=(path) fill=(fill) fill-rule="evenodd" stroke=(colour) stroke-width=(width) {} }
}

/// A circle.
pub(super) fn circle((x, y): Spot, radius: f64, fill: &str, colour: &str) -> Markup {
    html! { circle cx=(number(x)) cy=(number(y)) r=(number(radius)) fill=(fill) stroke=(colour) stroke-width="1" {} }
}

/// A text whose `anchor` is `start`, `middle` or `end`.
pub(super) fn text((x, y): Spot, anchor: &str, colour: &str, text: &str) -> Markup {
    html! { text x=(number(x)) y=(number(y)) text-anchor=(anchor) fill=(colour) { (text) } }
}

/// A bold text.
pub(super) fn title((x, y): Spot, text: &str) -> Markup {
    html! { text x=(number(x)) y=(number(y)) font-weight="bold" fill=(INK) { (text) } }
}

/// An arrow with its point at `to`.
pub(super) fn arrow(from: Spot, to: Spot, colour: &str, width: f64) -> Markup {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy).max(1e-9);
    let (ux, uy) = (dx / length, dy / length);
    let barb = 3.0 + 2.5 * width;
    let side = |sign: f64| {
        (
            to.0 - barb * ux - sign * 0.45 * barb * uy,
            to.1 - barb * uy + sign * 0.45 * barb * ux,
        )
    };
    html! {
        (line(&[from, (to.0 - 0.7 * barb * ux, to.1 - 0.7 * barb * uy)], colour, width, ""))
        (area(&[to, side(1.0), side(-1.0)], colour, colour, 0.5))
    }
}

/// A dimension between two heights, with its text beside it.
pub(super) fn height(x: f64, from: f64, to: f64, words: &str) -> Markup {
    let tick = |y: f64| line(&[(x - 4.0, y + 4.0), (x + 4.0, y - 4.0)], INK, 1.0, "");
    html! {
        (line(&[(x, from), (x, to)], INK, 0.7, ""))
        (tick(from)) (tick(to))
        (text((x + 6.0, 0.5 * (from + to) + 4.0), "start", INK, words))
    }
}

/// A scale bar of this length with its text.
pub(super) fn scale_bar((x, y): Spot, length: f64, words: &str) -> Markup {
    let end = x + length;
    html! {
        (area(&[(x, y - 3.0), (x + 0.5 * length, y - 3.0), (x + 0.5 * length, y), (x, y)], INK, INK, 0.7))
        (area(&[(x + 0.5 * length, y - 3.0), (end, y - 3.0), (end, y), (x + 0.5 * length, y)], "#fff", INK, 0.7))
        (text((end + 5.0, y + 2.0), "start", INK, words))
    }
}

/// Hatched ground or wall: a block between two corners.
pub(super) fn hatched(from: Spot, to: Spot) -> Markup {
    let (left, right) = (from.0.min(to.0), from.0.max(to.0));
    let (top, bottom) = (from.1.min(to.1), from.1.max(to.1));
    let depth = bottom - top;
    let count = ((right - left) / 6.0).floor().max(1.0) as usize;
    let step = (right - left) / count as f64;
    html! {
        (area(&[(left, top), (right, top), (right, bottom), (left, bottom)], "#eeeeee", FAINT, 0.5))
        @for index in 0..count {
            @let x = left + step * index as f64;
            (line(&[(x, bottom), ((x + depth).min(right), top)], FAINT, 0.6, ""))
        }
    }
}

/// The drawing of this size; `words` say what it shows.
pub(super) fn drawing(width: f64, height: f64, words: &str, content: &Markup) -> Markup {
    html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}")) role="img" aria-label=(words)
            font-family="DejaVu Sans, Verdana, sans-serif" font-size="11" stroke-linejoin="round" { (content) }
    }
}
