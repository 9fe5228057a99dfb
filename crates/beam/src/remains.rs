//! What a hit leaves of the column at rest, from where it is in the undamaged column.

use super::damage::{Damage, rotation};
use super::element::Triad;

/// The column at rest after a response.
pub(crate) struct Remains {
    /// Of the impact point, from where it was before.
    pub displacement: [f64; 2],
    /// Distance from the undamaged axis and its height.
    pub bow: [f64; 2],
    pub kink: f64,
    /// Of the web below and above the impact point, from the undamaged column.
    pub shear: [f64; 2],
    pub yielded_beyond_residual_stress: bool,
    pub damage: Damage,
}

/// The largest distance of nodes from where they are in the undamaged column, and the height of that node above the base \[m\].
pub(crate) fn largest_distance(
    moved: &[[f64; 3]],
    undamaged: &[[f64; 3]],
    heights: &[f64],
) -> [f64; 2] {
    let mut largest = [0.0; 2];
    for ((now, before), height) in moved.iter().zip(undamaged).zip(heights) {
        let distance = libm::hypot(now[1] - before[1], now[2] - before[2]);
        if distance > largest[0] {
            largest = [distance, *height];
        }
    }
    largest
}

/// The largest angle between cross-sections at most `zone` \[m\] apart, from where they are in the undamaged column \[rad\].
pub(crate) fn largest_kink(
    triads: &[Triad],
    undamaged: &[Triad],
    heights: &[f64],
    zone: f64,
) -> f64 {
    let turned = |node: usize| {
        let ([_, y, z], [_, of_y, of_z]) = (rotation(&triads[node]), rotation(&undamaged[node]));
        [y - of_y, z - of_z]
    };
    // Of the far end of a zone that begins at `from` and reaches into the element before `node`, or after it.
    let at_end = |from: usize, node: usize, before: usize| {
        let share = (zone - (heights[before] - heights[from]).abs())
            / (heights[node] - heights[before]).abs();
        let (near, far) = (turned(before), turned(node));
        [0, 1].map(|axis| near[axis] + share.min(1.0) * (far[axis] - near[axis]))
    };
    let mut largest = 0.0_f64;
    for from in 0..heights.len() {
        let [y, z] = turned(from);
        let up = from + 1..heights.len();
        let reached = |before: usize| (heights[before] - heights[from]).abs() < zone;
        let above = up.map(|node| (node, node - 1));
        let below = (0..from).rev().map(|node| (node, node + 1));
        for (node, before) in above.chain(below).filter(|(_, before)| reached(*before)) {
            let [of_y, of_z] = at_end(from, node, before);
            largest = largest.max(libm::hypot(of_y - y, of_z - z));
        }
    }
    largest
}
