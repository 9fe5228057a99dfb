//! Labels that do not cover one another.
//!
//! The viewer draws a label at a size of its own, centred below its point, however far the point is away. Here the labels
//! of one column are moved apart vertically by as much as they need in the camera's picture.

use super::point::Point3;

/// Width of a character and of both margins of a label \[points\].
const CHARACTER: f64 = 6.3;
/// Margins on both sides together \[points\].
const MARGINS: f64 = 14.0;
/// Height of a label of one line, with its distance from the next label \[points\].
const FIRST_LINE: f64 = 27.0;
/// Height of each further line \[points\].
const NEXT_LINE: f64 = 17.0;

/// A text at a point in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The middle of the upper edge.
    pub place: Point3,
    /// The text; lines are separated by line feeds.
    pub text: String,
}

impl Label {
    /// Width and height \[points\].
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        size(&self.text)
    }
}

/// Width and height of a text as a label \[points\].
#[must_use]
pub fn size(text: &str) -> [f64; 2] {
    let lines = text.lines();
    let longest = lines.clone().map(|line| line.chars().count()).max();
    [width(longest.unwrap_or(0)), height(lines.count())]
}

/// Width of a label whose longest line has this number of characters \[points\].
#[must_use]
pub fn width(characters: usize) -> f64 {
    CHARACTER * characters as f64 + MARGINS
}

/// Height of a label with this number of lines \[points\].
#[must_use]
pub fn height(lines: usize) -> f64 {
    FIRST_LINE + NEXT_LINE * lines.saturating_sub(1) as f64
}

/// Moves intervals apart that overlap, as little as possible: `wanted` are their upper ends, from the lowest interval to the
/// highest, with the length of each; the upper ends where none overlaps are returned.
#[must_use]
pub fn moved_apart(wanted: &[(f64, f64)]) -> Vec<f64> {
    // Groups of touching intervals: lower end, length, number, and the sum of the lower ends that each would give the group.
    let mut groups: Vec<(f64, f64, usize, f64)> = Vec::new();
    for &(upper, length) in wanted {
        let mut group = (upper - length, length, 1, upper - length);
        while let Some(&(lower, below, count, sum)) = groups.last() {
            if lower + below <= group.0 {
                break;
            }
            groups.pop();
            // The members of the upper group start higher by the length of the lower one.
            let sum = sum + group.3 - below * group.2 as f64;
            let count = count + group.2;
            group = (sum / count as f64, below + group.1, count, sum);
        }
        groups.push(group);
    }
    let mut lengths = wanted.iter().map(|(_, length)| *length);
    let mut ends = Vec::with_capacity(wanted.len());
    for (lower, _, count, _) in groups {
        let mut end = lower;
        for length in lengths.by_ref().take(count) {
            end += length;
            ends.push(end);
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_do_not_overlap_stay() {
        let wanted = [(1.0, 0.5), (2.0, 1.0), (5.0, 2.0)];
        assert_eq!(moved_apart(&wanted), [1.0, 2.0, 5.0]);
    }

    #[test]
    fn intervals_that_overlap_touch_afterwards_and_move_as_little_as_possible() {
        assert_eq!(moved_apart(&[(1.0, 1.0), (1.0, 1.0)]), [0.5, 1.5]);
        let wanted = [(1.0, 1.0), (1.2, 1.0), (1.3, 1.0), (9.0, 1.0), (9.9, 1.0)];
        let moved = moved_apart(&wanted);
        for (pair, (_, length)) in moved.windows(2).zip(&wanted[1..]) {
            assert!(pair[1] - length >= pair[0] - 1e-12, "{moved:?}");
        }
        let shift = |range: std::ops::Range<usize>| -> f64 {
            range.map(|index| moved[index] - wanted[index].0).sum()
        };
        assert!(shift(0..3).abs() < 1e-12 && shift(3..5).abs() < 1e-12);
    }

    #[test]
    fn the_size_of_a_label_follows_from_its_longest_line() {
        let one = size("0123456789");
        let two = size("0123\n0123456789");
        assert_eq!(one[0], two[0]);
        assert!(two[1] > one[1] && size("")[1] == one[1]);
    }
}
