//! The sketch of the first page: elevation and plan of column and hit, each to its scale.

use std::f64::consts::FRAC_PI_2;

use maud::{Markup, html};

use super::reported_impact::ReportedImpact;
use super::svg::{
    self, FAINT, INK, ORANGE, RED, STEEL, Spot, area, area_between, arrow, circle, hatched, height,
    line, scale_bar, text, title,
};
use super::words::short;
use crate::assessment::ConnectedBase;
use crate::column::{BasePlate, Support, VehicleSample};
use crate::parameters::{SectionShape, degrees};
use crate::second_opinion::is_out_of_plane;
use crate::shape::{Heading, Outline, VehicleBody};

/// Size of the drawing.
const SIZE: (f64, f64) = (720.0, 350.0);
/// The ground of the elevation and how high the column may be drawn.
const GROUND: f64 = 302.0;
const HIGHEST: f64 = 246.0;
/// Axis of the column in the elevation, and its left edge.
const AXIS: f64 = 262.0;
const LEFT: f64 = 4.0;
/// Centre of the plan, and its largest extent.
const PLAN: Spot = (586.0, 182.0);
const WIDEST: f64 = 196.0;

/// Elevation and plan.
pub(super) fn markup(impact: &ReportedImpact) -> Markup {
    let base = ConnectedBase::of(&impact.parameters).ok();
    let words = "Elevation and plan of the column with supports, section, and the vehicle that hits it, to scale";
    let content = html! {
        (elevation(impact, base.as_ref()))
        (plan(impact, base.as_ref()))
    };
    html! {
        figure.sketch role="img" aria-label=(words) {
            (svg::drawing(SIZE.0, SIZE.1, words, &content))
            figcaption { (caption(impact, base.as_ref())) }
        }
    }
}

fn caption(impact: &ReportedImpact, base: Option<&ConnectedBase>) -> String {
    let section = match impact.parameters.section().name {
        Some(name) => name.to_owned(),
        None => "a user-defined section, drawn as the nearest rolled one".to_owned(),
    };
    let plate = match base {
        Some(base) if base.is_assumed => " The base plate is assumed [A].",
        Some(_) => "",
        None => " The base plate is not known.",
    };
    let travel = travel_in_words(travel(impact));
    format!("Elevation and plan, to scale: {section}; the vehicle travels {travel}.{plate}")
}

/// The direction of travel \[rad\]; a number that is no direction turns nothing.
fn travel(impact: &ReportedImpact) -> f64 {
    Heading::new(impact.direction).direction()
}

/// How the vehicle travels \[rad\] and about which axis it bends the column.
fn travel_in_words(direction: f64) -> String {
    let is_along_the_flanges = !is_out_of_plane(direction - FRAC_PI_2);
    match (is_out_of_plane(direction), is_along_the_flanges) {
        (false, _) => {
            "in the direction of the web and bends the column about its strong axis y-y".to_owned()
        }
        (true, true) => {
            "at right angles to the web and bends the column about its weak axis z-z".to_owned()
        }
        (true, false) => format!(
            "at {} to the web and bends the column about both axes, the strong one y-y and the weak one z-z",
            degrees(direction)
        ),
    }
}

/// How deep the section is as it is seen across the direction of travel \[m\].
pub(super) fn seen_depth(impact: &ReportedImpact) -> f64 {
    let section = Outline::of(&impact.parameters);
    let (sin, cos) = travel(impact).sin_cos();
    section.depth() * cos.abs() + section.width() * sin.abs()
}

fn elevation(impact: &ReportedImpact, base: Option<&ConnectedBase>) -> Markup {
    let properties = &impact.model.properties;
    let (below, total) = (properties.length_below, impact.height());
    let scale = HIGHEST / total;
    let half = (0.5 * scale * seen_depth(impact)).max(1.5);
    let (top, hit) = (GROUND - scale * total, GROUND - scale * below);
    let load = properties.top_load;
    let bar = if total > 12.0 { 5.0 } else { 1.0 };
    html! {
        (title((LEFT, 14.0), "Elevation"))
        (line(&[(LEFT, GROUND), (AXIS + 130.0, GROUND)], FAINT, 1.0, ""))
        (vehicle(impact, scale, hit, AXIS - half))
        (area(&[(AXIS - half, GROUND), (AXIS + half, GROUND), (AXIS + half, top), (AXIS - half, top)], STEEL, INK, 1.0))
        (bottom_support(&properties.base, base, scale, half))
        (top_support(&properties.top, top, half))
        @if load > 0.0 {
            (arrow((AXIS, top - 42.0), (AXIS, top - 13.0), INK, 2.0))
            (text((AXIS + 8.0, top - 30.0), "start", INK, "axial load"))
        }
        (arrow((AXIS - half - 34.0, hit), (AXIS - half, hit), RED, 2.5))
        (line(&[(AXIS + half + 2.0, hit), (AXIS + 66.0, hit)], FAINT, 0.6, "3 2"))
        (height(AXIS + 36.0, GROUND, hit, &format!("{} m", short(below))))
        (height(AXIS + 36.0, hit, top, &format!("{} m", short(total - below))))
        (line(&[(AXIS + half + 2.0, top), (AXIS + 104.0, top)], FAINT, 0.6, "3 2"))
        (height(AXIS + 96.0, GROUND, top, &format!("{} m", short(total))))
        (text((AXIS + half + 16.0, GROUND + 16.0), "start", INK, &format!("base {}", in_words(&properties.base))))
        (text((AXIS + half + 16.0, top - 9.0), "start", INK, &format!("top {}", in_words(&properties.top))))
        (scale_bar((LEFT, SIZE.1 - 8.0), scale * bar, &format!("{} m", short(bar))))
        (text((LEFT, 34.0), "start", RED, &speed(impact)))
        (text((LEFT, 48.0), "start", INK, &mass(impact)))
    }
}

fn speed(impact: &ReportedImpact) -> String {
    let velocity = impact.velocity;
    format!("{} km/h ({} m/s)", short(3.6 * velocity), short(velocity))
}

/// The mass and, where the elevation does not show the plane of the web, how it is turned.
fn mass(impact: &ReportedImpact) -> String {
    let mass = short(impact.impact.mass);
    match impact.is_oblique() {
        true => format!("{mass} kg, {} to the web", degrees(impact.direction)),
        false => format!("{mass} kg"),
    }
}

/// A support in one or two words.
pub(super) fn in_words(support: &Support) -> String {
    match support {
        Support::BuiltIn => "built in".to_owned(),
        Support::Pinned => "pinned".to_owned(),
        Support::Free => "free".to_owned(),
        Support::SemiRigid { .. } => "semi-rigid".to_owned(),
    }
}

fn bottom_support(
    support: &Support,
    base: Option<&ConnectedBase>,
    scale: f64,
    half: f64,
) -> Markup {
    let wide = base.map_or(half + 6.0, |it| {
        (0.5 * scale * it.plate.length).max(half + 3.0)
    });
    let thick = base.map_or(2.0, |it| (scale * it.plate.thickness).max(2.0));
    let dashes = if base.is_some_and(|it| !it.is_assumed) {
        ""
    } else {
        "3 2"
    };
    html! {
        @match support {
            Support::Pinned => {
                (area(&[(AXIS, GROUND), (AXIS - 8.0, GROUND + 12.0), (AXIS + 8.0, GROUND + 12.0)], "#fff", INK, 1.0))
                (hatched((AXIS - 14.0, GROUND + 12.0), (AXIS + 14.0, GROUND + 20.0)))
            }
            _ => {
                (hatched((AXIS - wide - 6.0, GROUND + thick), (AXIS + wide + 6.0, GROUND + thick + 12.0)))
                (line(&[(AXIS - wide, GROUND), (AXIS + wide, GROUND), (AXIS + wide, GROUND + thick),
                    (AXIS - wide, GROUND + thick), (AXIS - wide, GROUND)], INK, 1.0, dashes))
            }
        }
        @if matches!(support, Support::SemiRigid { .. }) {
            (circle((AXIS, GROUND), 4.0, "#fff", INK))
        }
    }
}

/// The top moves along the column only, unless it is free.
fn top_support(support: &Support, top: f64, half: f64) -> Markup {
    let roller = |side: f64| {
        let x = AXIS + side * (half + 4.0);
        let wall = AXIS + side * (half + 8.0);
        html! {
            (circle((x, top - 6.0), 3.5, "#fff", INK))
            (line(&[(wall, top - 12.0), (wall, top + 2.0)], INK, 1.2, ""))
        }
    };
    html! {
        @match support {
            Support::Free => {}
            Support::Pinned => {
                (circle((AXIS, top), 3.5, "#fff", INK))
                (roller(-1.0)) (roller(1.0))
            }
            _ => {
                (area(&[(AXIS - half - 1.0, top - 12.0), (AXIS + half + 1.0, top - 12.0), (AXIS + half + 1.0, top), (AXIS - half - 1.0, top)],
                    "#eeeeee", INK, 1.0))
                (roller(-1.0)) (roller(1.0))
            }
        }
    }
}

/// The side view of the vehicle, cut off at the edge of the drawing.
fn vehicle(impact: &ReportedImpact, scale: f64, hit: f64, face: f64) -> Markup {
    let slack: Vec<f64> = impact.impact.vehicle.map_or(Vec::new(), |vehicle| {
        vehicle
            .springs()
            .iter()
            .map(|spring| spring.slack)
            .collect()
    });
    let body = VehicleBody::named(&impact.vehicle, impact.impact.mass, &slack);
    let below = (GROUND - hit) / scale;
    let road = body.road(below);
    let crushed = body.crushed(&VehicleSample::default());
    // The inner drawing cuts off what is longer than the room.
    let room = face - LEFT;
    let place = |x: f64, z: f64| (room + scale * x, GROUND - scale * z);
    let hull: Vec<Spot> = crushed
        .outline(0.0, road, 0.0)
        .iter()
        .map(|[x, _, z]| place(*x, *z))
        .collect();
    let boxes = crushed.boxes().map(|([front, rear], [bottom, top], _)| {
        let [bottom, top] = [bottom, top].map(|z| road + z);
        [
            (-front, bottom),
            (-rear, bottom),
            (-rear, top),
            (-front, top),
        ]
        .map(|(x, z)| place(x, z))
    });
    let boxes: Vec<_> = boxes.collect();
    html! {
        svg x=(LEFT) y="52" width=(format!("{room:.1}")) height=(format!("{:.1}", GROUND - 50.0))
            viewBox=(format!("0 52 {room:.1} {:.1}", GROUND - 50.0)) {
            @for corners in &boxes { (area(corners, "#f4e3d7", ORANGE, 1.0)) }
            (area(&hull, "#f4e3d7", ORANGE, 1.0))
            @if body.is_real() {
                @for wheel in crushed.wheels() {
                    @let (x, y) = place(-wheel.behind, road + wheel.radius);
                    (circle((x, y), scale * wheel.radius, "#ffffff", ORANGE))
                }
            }
        }
    }
}

fn plan(impact: &ReportedImpact, base: Option<&ConnectedBase>) -> Markup {
    let section = Outline::of(&impact.parameters);
    let [depth, width] = [section.depth(), section.width()];
    let plate = base.map(|it| &it.plate);
    let extent = plate.map_or(1.4 * depth.max(width), |it| it.length.max(it.width));
    let scale = WIDEST / extent;
    let place = |x: f64, y: f64| (PLAN.0 + scale * x, PLAN.1 - scale * y);
    let rings = section.rings().iter();
    let rings: Vec<Vec<Spot>> = rings
        .map(|ring| ring.iter().map(|[x, y]| place(*x, *y)).collect())
        .collect();
    let size = match impact.parameters.settings().section.shape {
        SectionShape::CircularHollow => format!("d = {} mm", short(1e3 * depth)),
        SectionShape::IOrH | SectionShape::RectangularHollow => {
            format!(
                "h = {} mm, b = {} mm",
                short(1e3 * depth),
                short(1e3 * width)
            )
        }
    };
    let reach = 0.5 * WIDEST + 14.0;
    html! {
        (title((432.0, 14.0), "Plan: section and base"))
        @if let Some(plate) = plate { (base_plate(plate, scale, base.is_some_and(|it| it.is_assumed))) }
        (area_between(&rings, STEEL, INK, 1.0))
        (line(&[(PLAN.0, PLAN.1 - reach), (PLAN.0, PLAN.1 + reach)], FAINT, 0.7, "10 3 2 3"))
        (line(&[(PLAN.0 - reach, PLAN.1), (PLAN.0 + reach, PLAN.1)], FAINT, 0.7, "10 3 2 3"))
        (text((PLAN.0 + 4.0, PLAN.1 - reach + 4.0), "start", INK, "y (strong axis)"))
        (text((PLAN.0 + 4.0, PLAN.1 + reach), "start", INK, "y"))
        (text((PLAN.0 + reach + 3.0, PLAN.1 + 4.0), "start", INK, "z"))
        (hit(impact, [0.5 * scale * depth, 0.5 * scale * width]))
        (text((432.0, 34.0), "start", INK, &size))
        (scale_bar((432.0, SIZE.1 - 8.0), 0.1 * scale, "100 mm"))
        @if let Some(plate) = plate {
            (text((556.0, SIZE.1 - 6.0), "start", INK, &anchors(plate)))
        }
    }
}

/// The arrow of the hit in the direction of travel, from the edge of the plan to the section with these halves of its sides.
fn hit(impact: &ReportedImpact, section: [f64; 2]) -> Markup {
    let (sin, cos) = travel(impact).sin_cos();
    // Positive directions turn towards the upper edge.
    let against = |[half_wide, half_high]: [f64; 2]| {
        let far = (half_wide / cos.abs()).min(half_high / sin.abs());
        (PLAN.0 - far * cos, PLAN.1 + far * sin)
    };
    let room = match cos > 0.0 {
        true => PLAN.0 - 438.0,
        false => 120.0,
    };
    let (from, to) = (against([room, 124.0]), against(section));
    let beside = match sin {
        it if it > 0.1 => 12.0,
        _ => -8.0,
    };
    let words = match impact.is_oblique() {
        true => format!("hit, {}", degrees(impact.direction)),
        false => "hit".to_owned(),
    };
    let anchor = match from.0 > PLAN.0 + 1.0 {
        true => "end",
        false => "start",
    };
    html! {
        (arrow(from, to, RED, 3.0))
        (text((from.0, from.1 + beside), anchor, RED, &words))
    }
}

fn anchors(plate: &BasePlate) -> String {
    format!(
        "plate {:.0} x {:.0} x {:.0} mm",
        1e3 * plate.length,
        1e3 * plate.width,
        1e3 * plate.thickness
    )
}

/// The plate with its anchors, half of them on each side of the axis about which the column is bent.
fn base_plate(plate: &BasePlate, scale: f64, is_assumed: bool) -> Markup {
    let [x, y] = [plate.length, plate.width].map(|it| 0.5 * scale * it);
    let dashes = if is_assumed { "5 3" } else { "" };
    let anchors = &plate.anchors;
    let per_side = (anchors.count / 2).max(1);
    let edge = 0.5 * plate.length - anchors.distance;
    let span = (plate.width - 2.0 * edge).max(0.0);
    let spread = |index: u32| match per_side {
        1 => 0.0,
        _ => span * (f64::from(index) / f64::from(per_side - 1) - 0.5),
    };
    let corners =
        [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)].map(|(dx, dy)| (PLAN.0 + dx, PLAN.1 + dy));
    html! {
        (line(&corners, INK, 1.0, dashes))
        @for side in [-1.0, 1.0] {
            @for index in 0..per_side {
                @let at = (PLAN.0 + side * scale * anchors.distance, PLAN.1 + scale * spread(index));
                (circle(at, 0.5 * scale * anchors.diameter, "#fff", INK))
            }
        }
    }
}
