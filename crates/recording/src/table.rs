//! Messages as rows of a table: the elements of a fixed array become columns, and so do those of a bounded sequence of numbers or
//! texts, with empty cells where it is shorter than its bound; any other sequence becomes one cell.

use crate::definition::Shape;
use crate::value::{Decoded, not_finite};

/// Maximum number of columns of a table; a message with more becomes one cell.
const MAX_COLUMNS: usize = 4096;

/// Maximum number of shapes that are visited to count the columns.
const MAX_SHAPES: usize = 4 * MAX_COLUMNS;

/// Names of the columns below `shape`, `header.stamp.sec`, `moment[0]`.
pub(crate) fn columns(shape: &Shape) -> Vec<String> {
    let mut names = Vec::new();
    add_columns(shape, String::new(), &mut names);
    names
}

fn add_columns(shape: &Shape, name: String, names: &mut Vec<String>) {
    match shape {
        Shape::Fields(fields) => {
            for (field, shape) in fields.iter() {
                let separator = if name.is_empty() { "" } else { "." };
                add_columns(shape, format!("{name}{separator}{field}"), names);
            }
        }
        Shape::Array(element, length) if is_spread(*length) => {
            for index in 0..*length {
                add_columns(element, format!("{name}[{index}]"), names);
            }
        }
        Shape::Sequence(element, bound) if let Some(bound) = spread_bound(element, *bound) => {
            names.extend((0..bound).map(|index| format!("{name}[{index}]")));
        }
        Shape::One(_) | Shape::Array(..) | Shape::Sequence(..) => names.push(name),
    }
}

/// The number of columns of a sequence whose elements become columns.
fn spread_bound(element: &Shape, bound: Option<usize>) -> Option<usize> {
    bound.filter(|bound| matches!(element, Shape::One(_)) && is_spread(*bound))
}

/// Whether the elements of an array with this length become columns: those of a 6 x 6 matrix do, those of a longer array do not.
fn is_spread(length: usize) -> bool {
    length <= 36
}

/// Whether a table of this shape has few enough columns.
pub(crate) fn fits(shape: &Shape) -> bool {
    let mut left = Left {
        columns: MAX_COLUMNS,
        shapes: MAX_SHAPES,
    };
    left.spend(shape).is_some()
}

/// How many columns and shapes may still follow. Nested types are shared in memory: written out, a small definition can
/// become a tree of any size, even one without a single column.
struct Left {
    columns: usize,
    shapes: usize,
}

impl Left {
    /// `None` as soon as there are too many.
    fn spend(&mut self, shape: &Shape) -> Option<()> {
        self.shapes = self.shapes.checked_sub(1)?;
        match shape {
            Shape::Fields(fields) => fields.iter().try_for_each(|(_, shape)| self.spend(shape)),
            Shape::Array(element, length) if is_spread(*length) => {
                (0..*length).try_for_each(|_| self.spend(element))
            }
            Shape::Sequence(element, bound) if let Some(bound) = spread_bound(element, *bound) => {
                self.columns = self.columns.checked_sub(bound)?;
                Some(())
            }
            Shape::One(_) | Shape::Array(..) | Shape::Sequence(..) => {
                self.columns = self.columns.checked_sub(1)?;
                Some(())
            }
        }
    }
}

/// The cells of a message in the order of the [`columns`] of its shape.
pub(crate) fn cells(shape: &Shape, value: &Decoded) -> Vec<String> {
    let mut cells = Vec::new();
    add_cells(shape, value, &mut cells);
    cells
}

fn add_cells(shape: &Shape, value: &Decoded, cells: &mut Vec<String>) {
    match (shape, value) {
        (Shape::Fields(shapes), Decoded::Fields(values)) => {
            for ((_, shape), (_, value)) in shapes.iter().zip(values) {
                add_cells(shape, value, cells);
            }
        }
        (Shape::Array(element, length), Decoded::List(values)) if is_spread(*length) => {
            for value in values {
                add_cells(element, value, cells);
            }
        }
        (Shape::Sequence(element, bound), Decoded::List(values))
            if let Some(bound) = spread_bound(element, *bound) =>
        {
            let cell_at = |index| values.get(index).map_or_else(String::new, cell);
            cells.extend((0..bound).map(cell_at));
        }
        (_, value) => cells.push(cell(value)),
    }
}

/// The text of a value; numbers read back bit for bit.
fn cell(value: &Decoded) -> String {
    match value {
        Decoded::Bool(value) => value.to_string(),
        Decoded::Integer(value) => value.to_string(),
        Decoded::Unsigned(value) => value.to_string(),
        Decoded::Float32(value) if value.is_finite() => format!("{value:?}"),
        Decoded::Float64(value) if value.is_finite() => format!("{value:?}"),
        Decoded::Float32(value) => not_finite(f64::from(*value)).to_owned(),
        Decoded::Float64(value) => not_finite(*value).to_owned(),
        Decoded::Text(text) => plain_text(text),
        // Serializing plain values does not fail.
        list => serde_json::to_string(list).unwrap_or_default(),
    }
}

/// A text that a spreadsheet shows as it is: one that it would take for a formula begins with an apostrophe, and control
/// characters, which a terminal would obey, are escaped, except line feeds.
fn plain_text(text: &str) -> String {
    const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];
    let mut plain = String::with_capacity(text.len() + 1);
    if text.starts_with(FORMULA) {
        plain.push('\'');
    }
    for c in text.chars() {
        match c.is_control() && c != '\n' {
            true => plain.extend(c.escape_default()),
            false => plain.push(c),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use re_ros_msg::message_spec::BuiltInType;

    use super::*;

    fn fields(shape: &Shape, count: usize) -> Shape {
        let field = |index| (Arc::from(format!("f{index}")), shape.clone());
        Shape::Fields((0..count).map(field).collect())
    }

    #[test]
    fn as_many_columns_as_are_allowed_fit() {
        let number = Shape::One(BuiltInType::Int32);
        let matrix = Shape::Array(Box::new(number.clone()), 16);
        assert!(fits(&fields(&matrix, MAX_COLUMNS / 16)));
        assert!(!fits(&fields(&matrix, MAX_COLUMNS / 16 + 1)));
        assert_eq!(columns(&fields(&matrix, 2)).len(), 32);
        let long = Shape::Array(Box::new(number), 37);
        assert_eq!(columns(&fields(&long, 2)), ["f0", "f1"]);
    }

    #[test]
    fn a_short_sequence_leaves_cells_empty() {
        let number = || Box::new(Shape::One(BuiltInType::Int32));
        let shape = |bound| {
            let fields = [
                (Arc::from("moment"), Shape::Sequence(number(), bound)),
                (Arc::from("end"), Shape::One(BuiltInType::Int32)),
            ];
            Shape::Fields(fields.into())
        };
        let value = Decoded::Fields(vec![
            (
                Arc::from("moment"),
                Decoded::List(vec![Decoded::Integer(7), Decoded::Integer(8)]),
            ),
            (Arc::from("end"), Decoded::Integer(9)),
        ]);
        let bounded = shape(Some(3));
        assert_eq!(
            columns(&bounded),
            ["moment[0]", "moment[1]", "moment[2]", "end"]
        );
        assert_eq!(cells(&bounded, &value), ["7", "8", "", "9"]);
        for long in [shape(None), shape(Some(37))] {
            assert_eq!(columns(&long), ["moment", "end"]);
            assert_eq!(cells(&long, &value), ["[7,8]", "9"]);
        }
    }

    /// 10^30 columns, or 10^30 empty arrays, in definitions of a kilobyte.
    #[test]
    fn exponentially_nested_types_do_not_fit() {
        let number = Shape::One(BuiltInType::Int32);
        let nothing = Shape::Array(Box::new(number.clone()), 0);
        for innermost in [number, nothing] {
            let nested = (0..30).fold(innermost, |shape, _| fields(&shape, 10));
            assert!(!fits(&nested));
            assert!(!fits(&Shape::Array(Box::new(nested), 3)));
        }
    }
}
