//! The plan of a fleet in a Rerun stream: all columns as one batch of points, and over it the few to which something has happened.

use rerun::components::DrawOrder;
use rerun::{LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult};

use super::item::{ColumnMark, ShownFleet};
use super::panel::{short, word, worst_first};
use super::place_labels::{Wanted, place_labels};
use crate::assessment::Action;
use crate::shape::{action_colour, round_number};
use crate::viewer::colour::Rgb;
use crate::viewer::rerun_types::{color, time_columns};
use crate::viewer::timeline::Moment;

/// The entities of the plan. No column can have this name, which ROS does not admit.
pub(super) const PLAN: &str = "overview/plan";
const COLUMNS: &str = "overview/plan/columns";
const OUTLINES: &str = "overview/plan/outlines";
const RINGS: &str = "overview/plan/rings";
const MARKS: &str = "overview/plan/marks";
const LABELS: &str = "overview/plan/labels";
const LEADERS: &str = "overview/plan/leaders";
const NEWEST: &str = "overview/plan/newest";
const SCALE: &str = "overview/plan/scale";
/// The entity of the legend.
pub(super) const LEGEND: &str = "overview/legend";

/// Paper: light, so that columns without damage recede and the darkest is the worst.
pub(super) const PAPER: Rgb = [250, 249, 245];
/// A column of which nothing is known yet.
const UNKNOWN: Rgb = [190, 190, 190];
/// The outline of a column that was hit.
const HIT: Rgb = [70, 70, 70];
/// The outline of any other column.
const OUTLINE: Rgb = [165, 175, 170];
/// A column that responds.
const RESPONDING: Rgb = [200, 30, 180];
/// A column that is out of service.
const OUT_OF_SERVICE: Rgb = [0, 0, 0];
/// The cross through the column that was hit last.
const CROSS: Rgb = [40, 90, 200];
/// Texts and lines.
const INK: Rgb = [60, 60, 60];

/// The size of the view of the plan in a window of 1600 times 1000 points, for which labels are placed \[points\].
const VIEW: [f64; 2] = [690.0, 540.0];

/// Margin around the columns \[points\].
const MARGIN: f64 = 42.0;

/// Room for the scale below them \[points\].
const BELOW: f64 = 34.0;

/// Radius of a mark as a part of the distance between columns, and its limits \[points\].
const RADIUS_PER_SPACING: f64 = 0.28;
const RADII: [f64; 2] = [2.5, 13.0];

/// The same for a column that somebody has to look at: it is seen among 2000.
const NOTABLE_RADIUS: f64 = 5.0;

/// Most columns whose names are shown although nothing has happened to them.
const MAX_NAMED: usize = 60;

/// Most labels of columns to which something has happened.
const MAX_LABELS: usize = 40;

/// Distance between two items of the legend \[units of its view\].
const LEGEND_STEP: f64 = 1.0;

/// Positions of metres and of points of the screen in the view of the plan.
#[derive(Debug, Clone)]
pub(super) struct Geometry {
    /// Left and upper edge of the view \[m\], `y` downwards.
    corner: [f64; 2],
    metres_per_point: f64,
    /// Radius of a mark \[points\].
    radius: f64,
}

impl Geometry {
    /// The view that has all columns in it.
    #[must_use]
    pub fn of(fleet: &ShownFleet) -> Self {
        let [left, right, bottom, top] = fleet.plan.extent();
        let inner = [VIEW[0] - 2.0 * MARGIN, VIEW[1] - 2.0 * MARGIN - BELOW];
        let least = fleet.plan.spacing / VIEW[1];
        let metres_per_point = ((right - left) / inner[0])
            .max((top - bottom) / inner[1])
            .max(least);
        let corner = [
            0.5 * (left + right) - 0.5 * VIEW[0] * metres_per_point,
            -0.5 * (top + bottom) - 0.5 * (VIEW[1] - BELOW) * metres_per_point,
        ];
        let spacing = fleet.plan.spacing / metres_per_point;
        Self {
            corner,
            metres_per_point,
            radius: (RADIUS_PER_SPACING * spacing).clamp(RADII[0], RADII[1]),
        }
    }

    /// Left, right, upper and lower edge of the view \[m\].
    #[must_use]
    pub fn bounds(&self) -> [f64; 4] {
        let [left, top] = self.corner;
        let [width, height] = VIEW.map(|it| it * self.metres_per_point);
        [left, left + width, top, top + height]
    }

    /// Radius of the mark of a column that somebody has to look at \[points\].
    fn notable_radius(&self) -> f64 {
        self.radius.max(NOTABLE_RADIUS)
    }

    /// A place of the plan in points of the view.
    fn points(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x - self.corner[0]) / self.metres_per_point,
            (-y - self.corner[1]) / self.metres_per_point,
        ]
    }

    /// A place in points of the view, where the viewer draws it.
    fn drawn(&self, [x, y]: [f64; 2]) -> [f32; 2] {
        [
            (self.corner[0] + x * self.metres_per_point) as f32,
            (self.corner[1] + y * self.metres_per_point) as f32,
        ]
    }
}

/// The colour of an action; of none that is known, grey.
fn colour_of(action: Option<Action>) -> Rgb {
    action.map_or(UNKNOWN, action_colour)
}

fn points(radius: f64) -> Radius {
    Radius::new_ui_points(radius as f32)
}

fn order(of: f32) -> DrawOrder {
    DrawOrder::from(of)
}

/// Sends what does not change: the places of all columns, their names for whoever points at one, the scale and the legend.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send_statics(
    stream: &RecordingStream,
    fleet: &ShownFleet,
    geometry: &Geometry,
) -> RecordingStreamResult<()> {
    let places = || {
        let positions = fleet.plan.positions.iter();
        positions.map(|it| geometry.drawn(geometry.points(*it)))
    };
    let names = fleet.ids.iter().map(|it| short(it));
    let columns = Points2D::update_fields()
        .with_positions(places())
        .with_radii([points(geometry.radius)])
        .with_labels(names)
        .with_show_labels(false)
        .with_draw_order(order(30.0));
    stream.log_static(COLUMNS, &columns)?;
    let outlines = Points2D::new(places())
        .with_radii([points(geometry.radius + 0.7)])
        .with_colors([color(OUTLINE)])
        .with_draw_order(order(15.0));
    stream.log_static(OUTLINES, &outlines)?;
    let rings = Points2D::update_fields().with_draw_order(order(32.0));
    stream.log_static(RINGS, &rings)?;
    let marks = Points2D::update_fields()
        .with_show_labels(false)
        .with_draw_order(order(35.0));
    stream.log_static(MARKS, &marks)?;
    let labels = Points2D::update_fields()
        .with_radii([points(0.0)])
        .with_show_labels(true)
        .with_draw_order(order(50.0));
    stream.log_static(LABELS, &labels)?;
    let line = |rgb: Rgb, radius: f64, draw_order: f32| {
        LineStrips2D::update_fields()
            .with_colors([color(rgb)])
            .with_radii([points(radius)])
            .with_draw_order(order(draw_order))
    };
    stream.log_static(LEADERS, &line(INK, 0.5, 40.0))?;
    stream.log_static(NEWEST, &line(CROSS, 0.6, 10.0))?;
    scale(stream, geometry)?;
    legend(stream)
}

/// A bar with a round number of metres in the lower left corner.
fn scale(stream: &RecordingStream, geometry: &Geometry) -> RecordingStreamResult<()> {
    let metres = round_number(100.0 * geometry.metres_per_point);
    let length = metres / geometry.metres_per_point;
    let [left, y] = [14.0, VIEW[1] - 26.0];
    let at = |x: f64, dy: f64| geometry.drawn([left + x, y + dy]);
    let bar = LineStrips2D::new([
        vec![at(0.0, 0.0), at(length, 0.0)],
        vec![at(0.0, -4.0), at(0.0, 4.0)],
        vec![at(length, -4.0), at(length, 4.0)],
    ])
    .with_colors([color(INK)])
    .with_radii([points(0.8)]);
    stream.log_static(SCALE, &bar)?;
    let text = format!("{} m", crate::parameters::readable(metres));
    let text = Points2D::new([at(0.5 * length, 0.0)])
        .with_labels([text])
        .with_colors([color(INK)])
        .with_radii([points(0.0)])
        .with_show_labels(true);
    stream.log_static(SCALE, &text)
}

/// What the marks mean, in a view of its own.
fn legend(stream: &RecordingStream) -> RecordingStreamResult<()> {
    let none = |action| (OUTLINE, action_colour(action), word(Some(action)));
    let mut items: Vec<(Rgb, Rgb, &str)> = Action::ALL.map(none).to_vec();
    items.push((HIT, action_colour(Action::None), "was hit"));
    items.push((RESPONDING, action_colour(Action::None), "responds"));
    items.push((
        OUT_OF_SERVICE,
        action_colour(Action::Evacuate),
        "out of service",
    ));
    let places = || (0..items.len()).map(|it| [(it as f64 * LEGEND_STEP) as f32, 0.0]);
    let outline = |rgb: Rgb| match rgb {
        OUTLINE => 8.0,
        HIT => 9.5,
        _ => 12.0,
    };
    let rings = Points2D::new(places())
        .with_colors(items.iter().map(|it| color(it.0)))
        .with_radii(items.iter().map(|it| points(outline(it.0))))
        .with_draw_order(order(20.0))
        .with_show_labels(false);
    stream.log_static(format!("{LEGEND}/rings"), &rings)?;
    let marks = Points2D::new(places())
        .with_colors(items.iter().map(|it| color(it.1)))
        .with_radii([points(7.0)])
        .with_draw_order(order(30.0))
        .with_show_labels(false);
    stream.log_static(format!("{LEGEND}/marks"), &marks)?;
    let texts = Points2D::new(places().map(|[x, _]| [x, 0.12]))
        .with_labels(items.iter().map(|it| it.2))
        .with_colors([color(INK)])
        .with_radii([points(0.0)])
        .with_show_labels(true);
    stream.log_static(format!("{LEGEND}/texts"), &texts)
}

/// Left, right, upper and lower edge of the view of the legend.
#[must_use]
pub(super) fn legend_bounds() -> [f64; 4] {
    let items = Action::ALL.len() as f64 + 3.0;
    [-0.6, (items - 1.0) * LEGEND_STEP + 0.6, -0.2, 0.5]
}

/// Sends the marks of the columns at one moment. Those to which nothing has happened are sent when one of them becomes known, which
/// `known` remembers; the others are few, so that an impact on one of 2000 columns costs little.
///
/// # Errors
/// The stream rejects the data.
pub(super) fn send(
    stream: &RecordingStream,
    fleet: &ShownFleet,
    geometry: &Geometry,
    marks: &[ColumnMark],
    newest: Option<u32>,
    known: &mut Vec<bool>,
    moment: Moment,
) -> RecordingStreamResult<()> {
    let times = || time_columns([moment]);
    let known_now: Vec<bool> = marks.iter().map(|it| it.action.is_some()).collect();
    if *known != known_now {
        let colours = known_now.iter().map(|it| match it {
            true => action_colour(Action::None),
            false => UNKNOWN,
        });
        let columns = Points2D::update_fields().with_colors(colours.map(color));
        stream.send_columns(COLUMNS, times(), columns.columns([marks.len()])?)?;
        *known = known_now;
    }

    let place = |index: usize| geometry.points(fleet.plan.positions[index]);
    let r = geometry.notable_radius();
    // Colour and radius of the ring, radius of the mark within it.
    let ring = |mark: &ColumnMark| match mark {
        it if it.is_responding() => Some((RESPONDING, 1.75 * r + 2.0, r)),
        it if it.is_out_of_service() => Some((OUT_OF_SERVICE, 1.5 * r + 1.5, r)),
        it if it.is_notable() => Some((HIT, r + 1.8, r)),
        it if it.impacts > 0 => Some((HIT, geometry.radius + 1.8, geometry.radius)),
        _ => None,
    };
    let touched: Vec<_> = marks
        .iter()
        .enumerate()
        .filter_map(|(index, mark)| Some((index, colour_of(mark.worst()), ring(mark)?)))
        .collect();
    let places = || touched.iter().map(|(it, ..)| geometry.drawn(place(*it)));
    let rings = Points2D::update_fields()
        .with_positions(places())
        .with_colors(touched.iter().map(|(_, _, (rgb, ..))| color(*rgb)))
        .with_radii(touched.iter().map(|(_, _, (_, radius, _))| points(*radius)));
    stream.send_columns(RINGS, times(), rings.columns([touched.len()])?)?;
    let shapes = Points2D::update_fields()
        .with_positions(places())
        .with_colors(touched.iter().map(|(_, rgb, _)| color(*rgb)))
        .with_radii(touched.iter().map(|(_, _, (_, _, radius))| points(*radius)))
        .with_labels(touched.iter().map(|(it, ..)| short(&fleet.ids[*it])));
    stream.send_columns(MARKS, times(), shapes.columns([touched.len()])?)?;

    let cross = newest.map(|it| place(it as usize)).map(|[x, y]| {
        let [width, height] = VIEW;
        let gap = 2.4 * r + 6.0;
        [
            [[x - width, y], [x - gap, y]],
            [[x + gap, y], [x + width, y]],
            [[x, y - height], [x, y - gap]],
            [[x, y + gap], [x, y + height]],
        ]
    });
    let strips: Vec<_> = cross.iter().flatten().collect();
    let strips = strips
        .iter()
        .map(|line| line.map(|it| geometry.drawn(it)).to_vec());
    let count = strips.len();
    let cross = LineStrips2D::update_fields().with_strips(strips);
    stream.send_columns(NEWEST, times(), cross.columns([count])?)?;

    send_labels(stream, fleet, geometry, marks, newest, moment)
}

fn send_labels(
    stream: &RecordingStream,
    fleet: &ShownFleet,
    geometry: &Geometry,
    marks: &[ColumnMark],
    newest: Option<u32>,
    moment: Moment,
) -> RecordingStreamResult<()> {
    let indices = labelled(fleet, marks, newest);
    let wanted: Vec<Wanted> = indices
        .iter()
        .map(|&index| Wanted {
            mark: geometry.points(fleet.plan.positions[index]),
            text: label(fleet, &marks[index], index),
            may_move: marks[index].is_notable() || newest == Some(index as u32),
        })
        .collect();
    let placed = place_labels(&wanted, geometry.notable_radius(), VIEW);
    let texts = placed.iter().map(|it| wanted[it.index].text.as_str());
    // The viewer draws a label a little below its point.
    let labels = Points2D::update_fields()
        .with_positions(placed.iter().map(|it| geometry.drawn(it.place)))
        .with_colors(placed.iter().map(|_| color(INK)))
        .with_labels(texts);
    let times = || time_columns([moment]);
    stream.send_columns(LABELS, times(), labels.columns([placed.len()])?)?;
    let leaders: Vec<_> = placed.iter().filter(|it| it.has_line).collect();
    let strips = leaders.iter().map(|it| {
        let [x, y] = it.place;
        vec![
            geometry.drawn(wanted[it.index].mark),
            geometry.drawn([x, y + 12.0]),
        ]
    });
    let lines = LineStrips2D::update_fields().with_strips(strips);
    stream.send_columns(LEADERS, times(), lines.columns([leaders.len()])?)
}

/// The columns that have labels: that of the newest impact, the worst, the selected ones, and all if they are few.
fn labelled(fleet: &ShownFleet, marks: &[ColumnMark], newest: Option<u32>) -> Vec<usize> {
    let mut indices: Vec<usize> = newest.map(|it| it as usize).into_iter().collect();
    let mut add = |index: usize| {
        if !indices.contains(&index) {
            indices.push(index);
        }
    };
    worst_first(marks)
        .into_iter()
        .take(MAX_LABELS)
        .for_each(&mut add);
    fleet.selected.iter().for_each(|index| add(*index as usize));
    if marks.len() <= MAX_NAMED {
        (0..marks.len()).for_each(add);
    }
    indices
}

/// The name of a column, and what has to be done about it.
fn label(fleet: &ShownFleet, mark: &ColumnMark, index: usize) -> String {
    let id = short(&fleet.ids[index]);
    match mark.worst() {
        None | Some(Action::None) => id,
        action => format!("{id} {}", word(action)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{FleetColumn, Parameters};

    fn fleet(places: &[[f64; 2]]) -> ShownFleet {
        let column = |(number, [x, y]): (usize, &[f64; 2])| {
            let id = format!("c{number}");
            let values = [
                ("column_id", id.as_str().into()),
                ("site.x", (*x).into()),
                ("site.y", (*y).into()),
            ];
            FleetColumn {
                name: format!("/{id}"),
                parameters: Parameters::from_values(values).expect("admissible").into(),
            }
        };
        let columns: Vec<_> = places.iter().enumerate().map(column).collect();
        ShownFleet::new(&columns, Vec::new())
    }

    /// A hall, a row, a wall and a single column.
    #[test]
    fn all_columns_are_in_the_view_with_room_for_names_and_above_is_above() {
        let hall: Vec<_> = (0..2_000)
            .map(|it| [6.0 * f64::from(it % 50), 8.0 * f64::from(it / 50)])
            .collect();
        let row: Vec<_> = (0..30).map(|it| [5.0 * f64::from(it), 1e4]).collect();
        let wall: Vec<_> = (0..30).map(|it| [-1e5, 5.0 * f64::from(it)]).collect();
        for places in [hall, row, wall, vec![[3.0, 4.0]]] {
            let fleet = fleet(&places);
            let geometry = Geometry::of(&fleet);
            let [left, right, top, bottom] = geometry.bounds();
            for place in &fleet.plan.positions {
                let [x, y] = geometry.points(*place);
                assert!(
                    (MARGIN - 1e-6..=VIEW[0] - MARGIN + 1e-6).contains(&x),
                    "{x}"
                );
                assert!(
                    (MARGIN - 1e-6..=VIEW[1] - MARGIN - BELOW + 1e-6).contains(&y),
                    "{y}"
                );
                let [x, y] = geometry.drawn([x, y]).map(f64::from);
                assert!((left..=right).contains(&x) && (top..=bottom).contains(&y));
            }
            let [_, low] = geometry.points([0.0, 0.0]);
            let [_, high] = geometry.points([0.0, 1.0]);
            assert!(high < low, "y points upwards");
            assert!((RADII[0]..=RADII[1]).contains(&geometry.radius));
        }
    }

    #[test]
    fn names_are_shown_of_few_columns_and_of_those_that_matter() {
        let places = |count: u32| {
            (0..count)
                .map(|it| [f64::from(it), 0.0])
                .collect::<Vec<_>>()
        };
        let shore = ColumnMark {
            action: Some(Action::Shore),
            ..ColumnMark::default()
        };
        for (count, expected) in [(12, 12), (200, 2)] {
            let fleet = fleet(&places(count));
            let mut marks = vec![ColumnMark::default(); count as usize];
            marks[7] = shore;
            let labelled = labelled(&fleet, &marks, Some(5));
            assert_eq!(labelled.len(), expected);
            assert_eq!(labelled[..2], [5, 7]);
            assert_eq!(label(&fleet, &shore, 7), "c7 SHORE");
            assert_eq!(label(&fleet, &ColumnMark::default(), 8), "c8");
        }
        let all = vec![shore; 200];
        assert_eq!(labelled(&fleet(&places(200)), &all, None).len(), MAX_LABELS);
    }
}
