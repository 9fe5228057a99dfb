//! Messages as rows of a table: fixed arrays become columns, sequences a cell.

use super::decode::{Decoded, Shape, not_finite};

/// Most columns of a table; an array that would make more becomes a cell.
const MOST_COLUMNS: usize = 4096;

/// Names of the columns below `shape`, `header.stamp.sec`, `moment[0]`.
pub(super) fn columns(shape: &Shape) -> Vec<String> {
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
        Shape::One(_) | Shape::Array(..) | Shape::Sequence(_) => names.push(name),
    }
}

/// Whether an array of that length is spread over columns. A matrix is; what is longer is no table any more.
fn is_spread(length: usize) -> bool {
    length <= 36
}

/// Whether a table of that shape has few enough columns.
pub(super) fn fits(shape: &Shape) -> bool {
    count(shape) <= MOST_COLUMNS
}

fn count(shape: &Shape) -> usize {
    match shape {
        Shape::Fields(fields) => fields
            .iter()
            .fold(0, |sum, (_, shape)| sum.saturating_add(count(shape))),
        Shape::Array(element, length) if is_spread(*length) => {
            count(element).saturating_mul(*length)
        }
        Shape::One(_) | Shape::Array(..) | Shape::Sequence(_) => 1,
    }
}

/// The cells of a message under [`columns`] of its shape.
pub(super) fn cells(shape: &Shape, value: &Decoded) -> Vec<String> {
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
        (_, value) => cells.push(cell(value)),
    }
}

/// Numbers read back to the last bit.
fn cell(value: &Decoded) -> String {
    match value {
        Decoded::Bool(value) => value.to_string(),
        Decoded::Integer(value) => value.to_string(),
        Decoded::Unsigned(value) => value.to_string(),
        Decoded::Float32(value) if value.is_finite() => format!("{value:?}"),
        Decoded::Float64(value) if value.is_finite() => format!("{value:?}"),
        Decoded::Float32(value) => not_finite(f64::from(*value)).to_owned(),
        Decoded::Float64(value) => not_finite(*value).to_owned(),
        Decoded::Text(text) => text.clone(),
        // Written by serde from plain values, which does not fail.
        list => serde_json::to_string(list).unwrap_or_default(),
    }
}
