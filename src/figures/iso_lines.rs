//! Lines of equal value in a field on a grid, by marching squares.

use std::collections::BTreeMap;

/// A side of a square of the grid: the lower of its two nodes, and whether it runs along the columns.
type Side = (usize, usize, bool);

/// The lines on which a field has a value, as places (row, column) in parts of the grid, from 0 to the number of nodes less 1.
///
/// `field` gives the value at a node; squares with a node without a value have no line. A square in which both diagonals differ
/// is decided by the mean of its nodes.
pub(super) fn iso_lines(
    rows: usize,
    columns: usize,
    level: f64,
    field: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<Vec<(f64, f64)>> {
    let mut neighbours: BTreeMap<Side, Vec<Side>> = BTreeMap::new();
    let mut places: BTreeMap<Side, (f64, f64)> = BTreeMap::new();
    for row in 0..rows.saturating_sub(1) {
        for column in 0..columns.saturating_sub(1) {
            let corners = [
                (row, column),
                (row + 1, column),
                (row + 1, column + 1),
                (row, column + 1),
            ];
            let values = corners.map(|(row, column)| field(row, column));
            let [Some(a), Some(b), Some(c), Some(d)] = values else {
                continue;
            };
            let values = [a, b, c, d];
            let sides: [Side; 4] = [
                (row, column, false),
                (row + 1, column, true),
                (row, column + 1, false),
                (row, column, true),
            ];
            let crossed: Vec<usize> = (0..4)
                .filter(|&side| (values[side] >= level) != (values[(side + 1) % 4] >= level))
                .collect();
            for &side in &crossed {
                let (from, to) = (corners[side], corners[(side + 1) % 4]);
                let part = (level - values[side]) / (values[(side + 1) % 4] - values[side]);
                let between =
                    |from: usize, to: usize| from as f64 + part * (to as f64 - from as f64);
                places.insert(sides[side], (between(from.0, to.0), between(from.1, to.1)));
            }
            let pairs = match crossed[..] {
                [one, other] => vec![(one, other)],
                [..] if crossed.len() == 4 => {
                    let mean = values.iter().sum::<f64>() / 4.0;
                    match (mean >= level) == (a >= level) {
                        true => vec![(0, 1), (2, 3)],
                        false => vec![(3, 0), (1, 2)],
                    }
                }
                [..] => Vec::new(),
            };
            for (one, other) in pairs {
                neighbours.entry(sides[one]).or_default().push(sides[other]);
                neighbours.entry(sides[other]).or_default().push(sides[one]);
            }
        }
    }
    joined(neighbours, &places)
}

/// Joins the pieces of the squares to lines; open ones first, so that each begins at one of its ends.
fn joined(
    mut neighbours: BTreeMap<Side, Vec<Side>>,
    places: &BTreeMap<Side, (f64, f64)>,
) -> Vec<Vec<(f64, f64)>> {
    let mut lines = Vec::new();
    loop {
        let of_degree = |degree| {
            let found = neighbours.iter().find(|(_, others)| others.len() == degree);
            found.map(|(side, _)| *side)
        };
        let Some(start) = of_degree(1).or_else(|| of_degree(2)) else {
            return lines;
        };
        let mut line = vec![places[&start]];
        let mut side = start;
        while let Some(next) = neighbours.get_mut(&side).and_then(Vec::pop) {
            if let Some(back) = neighbours.get_mut(&next) {
                let index = back.iter().position(|it| *it == side);
                index.map(|index| back.swap_remove(index));
            }
            line.push(places[&next]);
            side = next;
        }
        neighbours.retain(|_, others| !others.is_empty());
        lines.push(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The circle is known; a line of a bilinear field is off by the square of the width of a square.
    #[test]
    fn a_cone_has_circles() {
        let radius = |row: f64, column: f64| f64::hypot(row - 20.0, column - 20.0);
        let field = |row: usize, column: usize| Some(radius(row as f64, column as f64));
        let lines = iso_lines(41, 41, 10.3, field);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        for (row, column) in &lines[0] {
            assert!((radius(*row, *column) - 10.3).abs() < 0.02);
        }
        let length: f64 = lines[0]
            .windows(2)
            .map(|pair| f64::hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1))
            .sum();
        assert!((length / (2.0 * std::f64::consts::PI * 10.3) - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_plane_has_one_straight_line_and_a_gap_where_values_are_missing() {
        let lines = iso_lines(5, 9, 2.5, |row, _| Some(row as f64));
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].len(), 9);
        assert!(lines[0].iter().all(|(row, _)| *row == 2.5));
        let with_gap = iso_lines(5, 9, 2.5, |row, column| (column != 4).then_some(row as f64));
        assert_eq!(with_gap.len(), 2);
        assert_eq!(iso_lines(5, 9, 7.0, |row, _| Some(row as f64)).len(), 0);
    }
}
