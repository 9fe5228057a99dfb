//! Places the labels of a plan so that none covers another, or the mark of a column that has a label.

use crate::viewer::labels;

/// How many times the first distance a label may be away from its mark, with a line to it.
const MAX_RINGS: usize = 6;

/// Distance of these places from one another \[points\].
const RING: f64 = 22.0;

/// A label that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wanted {
    /// The middle of its mark \[points\], `y` downwards.
    pub mark: [f64; 2],
    pub text: String,
    /// It may be moved away from its mark.
    pub may_move: bool,
}

/// Where a label is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedLabel {
    /// Index of what was wanted.
    pub index: usize,
    /// The middle of the upper edge \[points\].
    pub place: [f64; 2],
    /// It is away from its mark, to which a line has to lead.
    pub has_line: bool,
}

/// Left, right, top, bottom.
type Rectangle = [f64; 4];

fn overlap(a: &Rectangle, b: &Rectangle) -> bool {
    a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3]
}

/// The middle of the upper edge relative to the mark, for a label of this size, and whether a line is needed; the best first.
fn candidates(
    [width, height]: [f64; 2],
    radius: f64,
    may_move: bool,
) -> impl Iterator<Item = ([f64; 2], bool)> {
    let rings = if may_move { MAX_RINGS } else { 0 };
    (0..=rings).flat_map(move |ring| {
        // The viewer leaves a gap of its own.
        let away = radius + ring as f64 * RING;
        let beside = 0.5 * width + away;
        let has_line = ring > 0;
        [
            [0.0, away],
            [0.0, -away - height],
            [beside, -0.5 * height],
            [-beside, -0.5 * height],
            [beside, away],
            [-beside, away],
            [beside, -away - height],
            [-beside, -away - height],
        ]
        .map(|place| (place, has_line))
    })
}

/// Places as many labels as there is room for in a picture of this width and height, the first ones first; `radius` is that of a
/// mark \[points\].
#[must_use]
pub(super) fn place_labels(
    wanted: &[Wanted],
    radius: f64,
    [width, height]: [f64; 2],
) -> Vec<PlacedLabel> {
    let mut taken: Vec<Rectangle> = wanted
        .iter()
        .map(|it| {
            let [x, y] = it.mark;
            [x - radius, x + radius, y - radius, y + radius]
        })
        .collect();
    let mut placed = Vec::new();
    for (index, it) in wanted.iter().enumerate() {
        let size = labels::size(&it.text);
        let found = candidates(size, radius, it.may_move).find_map(|([dx, dy], has_line)| {
            let place = [it.mark[0] + dx, it.mark[1] + dy];
            let half = 0.5 * size[0];
            let rectangle = [
                place[0] - half,
                place[0] + half,
                place[1],
                place[1] + size[1],
            ];
            let [left, right, top, bottom] = rectangle;
            let is_inside = left >= 0.0 && right <= width && top >= 0.0 && bottom <= height;
            let is_free = is_inside && !taken.iter().any(|other| overlap(other, &rectangle));
            is_free.then_some((place, rectangle, has_line))
        });
        if let Some((place, rectangle, has_line)) = found {
            taken.push(rectangle);
            placed.push(PlacedLabel {
                index,
                place,
                has_line,
            });
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: [f64; 2] = [700.0, 560.0];

    fn rectangles(wanted: &[Wanted], placed: &[PlacedLabel]) -> Vec<Rectangle> {
        let of = |it: &PlacedLabel| {
            let [width, height] = labels::size(&wanted[it.index].text);
            let [x, y] = it.place;
            [x - 0.5 * width, x + 0.5 * width, y, y + height]
        };
        placed.iter().map(of).collect()
    }

    fn in_a_raster(columns: usize, distance: f64, may_move: bool) -> Vec<Wanted> {
        (0..columns)
            .map(|number| Wanted {
                mark: [
                    300.0 + distance * (number % 5) as f64,
                    250.0 + distance * (number / 5) as f64,
                ],
                text: format!("column {number}"),
                may_move,
            })
            .collect()
    }

    #[test]
    fn a_label_alone_is_below_its_mark() {
        let placed = place_labels(&in_a_raster(1, 0.0, true), 5.0, PICTURE);
        assert_eq!(placed.len(), 1);
        assert_eq!(
            (placed[0].place, placed[0].has_line),
            ([300.0, 255.0], false)
        );
    }

    #[test]
    fn no_label_covers_another_one_or_a_mark_or_leaves_the_picture() {
        for (columns, distance) in [(3, 4.0), (10, 12.0), (25, 9.0), (25, 60.0)] {
            let wanted = in_a_raster(columns, distance, true);
            let placed = place_labels(&wanted, 4.0, PICTURE);
            assert_eq!(placed[0].index, 0, "the first one comes first");
            let found = rectangles(&wanted, &placed);
            for (number, one) in found.iter().enumerate() {
                assert!(found[..number].iter().all(|other| !overlap(one, other)));
                assert!(one[0] >= 0.0 && one[1] <= PICTURE[0]);
                assert!(one[2] >= 0.0 && one[3] <= PICTURE[1]);
                for it in &wanted {
                    let [x, y] = it.mark;
                    assert!(!overlap(one, &[x - 4.0, x + 4.0, y - 4.0, y + 4.0]));
                }
            }
            if distance > 50.0 || columns < 11 {
                assert_eq!(placed.len(), columns, "there is room for all");
            }
        }
    }

    #[test]
    fn a_label_that_may_not_move_is_at_its_mark_or_absent() {
        let wanted = in_a_raster(25, 9.0, false);
        let placed = place_labels(&wanted, 4.0, PICTURE);
        assert!(!placed.is_empty() && placed.len() < 25);
        assert!(placed.iter().all(|it| !it.has_line));
    }
}
