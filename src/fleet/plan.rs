//! Where the columns of a fleet stand in plan, for pictures.

use std::collections::HashMap;

/// Columns that are nearer to one another would be drawn at the same place \[m\].
const SAME_PLACE: f64 = 0.01;

/// Distance of columns in rows of which no position is known, if none is known at all \[m\].
const SPACING: f64 = 6.0;

/// Width over height of the rows in which columns of unknown position stand.
const SHAPE: f64 = 1.6;

/// Of the distances from each column to its nearest neighbour, the part that is smaller than the spacing of the plan: a few columns
/// that stand in pairs do not make the marks of all others small.
const SPACING_QUANTILE: f64 = 0.1;

/// The plan of a fleet: positions in metres, `x` to the right and `y` upwards in the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The positions of the columns, by their indices.
    pub positions: Vec<[f64; 2]>,
    /// Number of columns whose position is not known. They stand in rows below the others.
    pub unplaced: usize,
    /// Typical distance to the nearest neighbour \[m\].
    pub spacing: f64,
}

impl Plan {
    /// The plan of columns with these positions, as `site.x` and `site.y` give them. Positions that several columns share are those
    /// of none: the default is such a one.
    #[must_use]
    pub fn new(given: &[[f64; 2]]) -> Self {
        let key = |place: &[f64; 2]| place.map(|it| (it / SAME_PLACE).round() as i64);
        let mut sharing: HashMap<[i64; 2], usize> = HashMap::new();
        for place in given {
            *sharing.entry(key(place)).or_default() += 1;
        }
        let is_placed = |place: &[f64; 2]| sharing.get(&key(place)) == Some(&1);
        // A fleet of one column stands wherever it stands.
        let placed: Vec<[f64; 2]> = given.iter().copied().filter(is_placed).collect();
        let spacing = match placed.len() {
            0 | 1 => SPACING,
            _ => spacing(&placed),
        };
        let unplaced = given.len() - placed.len();
        let corner = corner_of_rows(&placed, spacing);
        let in_row = ((unplaced as f64 * SHAPE).sqrt().ceil() as usize).max(1);
        let mut next = 0;
        let positions = given.iter().map(|place| {
            if is_placed(place) {
                return *place;
            }
            let (row, number) = (next / in_row, next % in_row);
            next += 1;
            [
                corner[0] + number as f64 * spacing,
                corner[1] - row as f64 * spacing,
            ]
        });
        Self {
            positions: positions.collect(),
            unplaced,
            spacing,
        }
    }

    /// What people have to be told of positions that are not known; `None` if all are.
    #[must_use]
    pub fn about_unplaced(&self) -> Option<String> {
        let columns = self.positions.len();
        match self.unplaced {
            0 => None,
            all if all == columns => Some(format!(
                "the {columns} columns have no positions, so the plan shows them in rows in the order of their names; give site.x \
                 and site.y [m] for each"
            )),
            some => Some(format!(
                "{some} of {columns} columns have no position or share one with another column, so the plan shows them in rows \
                 below the others; give site.x and site.y [m] for each"
            )),
        }
    }

    /// The rectangle of all positions: left, right, bottom, top \[m\].
    #[must_use]
    pub fn extent(&self) -> [f64; 4] {
        extent(&self.positions)
    }
}

fn extent(positions: &[[f64; 2]]) -> [f64; 4] {
    let [first_x, first_y] = positions.first().copied().unwrap_or_default();
    let grown = |[left, right, bottom, top]: [f64; 4], [x, y]: &[f64; 2]| {
        [left.min(*x), right.max(*x), bottom.min(*y), top.max(*y)]
    };
    positions
        .iter()
        .fold([first_x, first_x, first_y, first_y], grown)
}

/// Where the rows of columns without a position begin.
fn corner_of_rows(placed: &[[f64; 2]], spacing: f64) -> [f64; 2] {
    if placed.is_empty() {
        return [0.0, 0.0];
    }
    let [left, _, bottom, _] = extent(placed);
    [left, bottom - 2.0 * spacing]
}

/// Typical distance of each place to its nearest neighbour, of at least two. A grid of cells finds the neighbours, so that 2000
/// columns take no longer than their number.
fn spacing(places: &[[f64; 2]]) -> f64 {
    let [left, right, bottom, top] = extent(places);
    let (width, height) = (right - left, top - bottom);
    // About one place in each cell; a row has no area.
    let cell = (width * height / places.len() as f64)
        .sqrt()
        .max(width.max(height) / places.len() as f64)
        .max(SAME_PLACE);
    let cell_of = |[x, y]: [f64; 2]| {
        [
            ((x - left) / cell).floor() as i64,
            ((y - bottom) / cell).floor() as i64,
        ]
    };
    let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for (index, place) in places.iter().enumerate() {
        cells.entry(cell_of(*place)).or_default().push(index);
    }
    let farthest = (width / cell).max(height / cell) as i64 + 1;
    let nearest = |index: usize| {
        let [x, y] = places[index];
        let [column, row] = cell_of(places[index]);
        let mut least = f64::INFINITY;
        for ring in 0..=farthest {
            // Every place in a ring is at least this far away.
            if (ring - 1) as f64 * cell > least {
                break;
            }
            for (dx, dy) in cells_of_ring(ring) {
                for &other in cells.get(&[column + dx, row + dy]).into_iter().flatten() {
                    let [other_x, other_y] = places[other];
                    if other != index {
                        least = least.min((other_x - x).hypot(other_y - y));
                    }
                }
            }
        }
        least
    };
    let mut distances: Vec<f64> = (0..places.len()).map(nearest).collect();
    distances.sort_by(f64::total_cmp);
    distances[(SPACING_QUANTILE * (distances.len() - 1) as f64) as usize]
}

/// The cells at this distance from a cell, which is that of the larger coordinate.
fn cells_of_ring(ring: i64) -> impl Iterator<Item = (i64, i64)> {
    (-ring..=ring).flat_map(move |dx| {
        let step = if dx.abs() == ring { 1 } else { 2 * ring.max(1) };
        (-ring..=ring)
            .step_by(usize::try_from(step).unwrap_or(1))
            .map(move |dy| (dx, dy))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn least_distance(plan: &Plan) -> f64 {
        let of = |index: usize| {
            let [x, y] = plan.positions[index];
            let others = plan.positions.iter().enumerate();
            let others = others.filter(|(other, _)| *other != index);
            let distances = others.map(|(_, it)| (it[0] - x).hypot(it[1] - y));
            distances.fold(f64::INFINITY, f64::min)
        };
        (0..plan.positions.len())
            .map(of)
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn columns_with_positions_stand_there() {
        let given = [[0.0, 0.0], [5.0, 0.0], [0.0, 7.0], [50.0, 7.0]];
        let plan = Plan::new(&given);
        assert_eq!(plan.positions, given);
        assert_eq!((plan.unplaced, plan.about_unplaced()), (0, None));
        assert_eq!(plan.spacing, 5.0);
        assert_eq!(plan.extent(), [0.0, 50.0, 0.0, 7.0]);
    }

    #[test]
    fn columns_without_positions_stand_in_rows_and_this_is_said() {
        for columns in [2, 12, 200, 2_000] {
            let plan = Plan::new(&vec![[0.0, 0.0]; columns]);
            assert_eq!(plan.unplaced, columns);
            assert!((least_distance(&plan) - SPACING).abs() < 1e-9);
            let text = plan.about_unplaced().expect("said");
            assert!(text.contains(&format!("the {columns} columns")), "{text}");
        }
    }

    #[test]
    fn some_columns_without_positions_stand_below_the_others() {
        let mut given: Vec<_> = (0..20).map(|it| [4.0 * f64::from(it), 10.0]).collect();
        given.extend([[0.0, 0.0]; 3]);
        given.push(given[5]); // the same place twice
        let plan = Plan::new(&given);
        assert_eq!(plan.unplaced, 5);
        assert_eq!(plan.spacing, 4.0);
        let text = plan.about_unplaced().expect("said");
        assert!(text.starts_with("5 of 24 columns"), "{text}");
        for (index, place) in plan.positions.iter().enumerate() {
            let is_placed = index < 20 && index != 5;
            assert_eq!(*place == given[index], is_placed, "{index}");
            assert_eq!(place[1] <= 10.0 - 8.0, !is_placed, "{index}");
        }
        assert!(least_distance(&plan) > 3.99);
    }

    /// The grid of cells finds what a comparison of all pairs finds.
    #[test]
    fn the_spacing_is_that_of_the_nearest_neighbours() {
        // Not on a raster: multiples of irrational numbers modulo one.
        let place = |number: u32| {
            let part = |factor: f64| (f64::from(number) * factor).fract();
            [200.0 * part(2.0_f64.sqrt()), 20.0 * part(3.0_f64.sqrt())]
        };
        for columns in [2, 3, 50, 400] {
            let places: Vec<_> = (1..=columns).map(place).collect();
            let mut distances: Vec<f64> = places
                .iter()
                .map(|one| {
                    let of = |other: &[f64; 2]| (other[0] - one[0]).hypot(other[1] - one[1]);
                    let others = places.iter().filter(|other| *other != one);
                    others.map(of).fold(f64::INFINITY, f64::min)
                })
                .collect();
            distances.sort_by(f64::total_cmp);
            let expected = distances[(0.1 * f64::from(columns - 1)) as usize];
            assert!((spacing(&places) - expected).abs() < 1e-12, "{columns}");
        }
    }

    #[test]
    fn one_column_has_a_plan() {
        let plan = Plan::new(&[[3.0, 4.0]]);
        assert_eq!(
            (plan.positions[0], plan.unplaced, plan.spacing),
            ([3.0, 4.0], 0, SPACING)
        );
    }
}
