//! The height of hinges 1a and 1b, and with that of the impact.

use crate::column::ColumnProperties;

/// Heights that differ by less than this are the same hinges \[m\].
pub const HEIGHT_TOLERANCE: f64 = 1e-3;

/// The same column with hinges 1a and 1b at another height \[m\].
pub(crate) fn with_impact_height(properties: &ColumnProperties, height: f64) -> ColumnProperties {
    let mut moved = *properties;
    if !is_same_height(height, properties.length_below) {
        let whole = properties.length_below + properties.length_above;
        moved.length_below = height;
        moved.length_above = whole - height;
    }
    moved
}

/// Whether two heights mean the same hinges; false where one of them is NaN.
pub(crate) fn is_same_height(a: f64, b: f64) -> bool {
    (a - b).abs() < HEIGHT_TOLERANCE
}
