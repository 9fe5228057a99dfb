//! The kinds of columns of a fleet: columns that differ by their names only are computed once.

use std::collections::HashMap;
use std::ops::Range;

use crate::parameters::FleetColumn;

/// The kinds of the columns of a fleet, numbered in the order of their first columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FleetKinds {
    /// The kind of each column.
    of_columns: Vec<usize>,
    /// The first column of each kind.
    first: Vec<usize>,
}

impl FleetKinds {
    /// The kinds of these columns.
    #[must_use]
    pub fn of(columns: &[FleetColumn]) -> Self {
        let mut known = HashMap::new();
        let mut first = Vec::new();
        let of_columns = columns.iter().enumerate().map(|(index, column)| {
            *known
                .entry(column.parameters.without_names())
                .or_insert_with(|| {
                    first.push(index);
                    first.len() - 1
                })
        });
        let of_columns = of_columns.collect();
        Self { of_columns, first }
    }

    /// Number of kinds.
    #[must_use]
    pub fn count(&self) -> usize {
        self.first.len()
    }

    /// The first column of a kind.
    ///
    /// # Panics
    /// There is no kind with this number.
    #[must_use]
    pub fn first_of(&self, kind: usize) -> usize {
        self.first[kind]
    }

    /// The kind of a column.
    ///
    /// # Panics
    /// There is no column with this index.
    #[must_use]
    pub fn of_column(&self, column: usize) -> usize {
        self.of_columns[column]
    }
}

/// Part `number` of `parts` contiguous parts of `count` columns, numbered from 1; their lengths differ by one at most, and together
/// they are all columns.
#[must_use]
pub fn part_of(count: usize, number: usize, parts: usize) -> Range<usize> {
    let parts = parts.max(1);
    let at = |part: usize| (count as u128 * part.min(parts) as u128 / parts as u128) as usize;
    at(number.saturating_sub(1))..at(number)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::parameters::{Parameters, Value};

    #[test]
    fn columns_that_differ_by_their_names_are_of_one_kind() {
        let column = |name: &str, load: f64| FleetColumn {
            name: format!("/{name}"),
            parameters: Arc::new(
                Parameters::from_values([
                    ("column_id", Value::from(name)),
                    ("top.load", Value::from(load)),
                ])
                .expect("admissible"),
            ),
        };
        let columns = [
            column("a", 1e5),
            column("b", 2e5),
            column("c", 1e5),
            column("d", 2e5),
        ];
        let kinds = FleetKinds::of(&columns);
        assert_eq!(kinds.count(), 2);
        let of_columns: Vec<_> = (0..4).map(|it| kinds.of_column(it)).collect();
        assert_eq!(of_columns, [0, 1, 0, 1]);
        assert_eq!([kinds.first_of(0), kinds.first_of(1)], [0, 1]);
    }

    #[test]
    fn parts_are_all_columns_once() {
        for (count, parts) in [(1000, 16), (3, 16), (0, 2), (7, 7)] {
            let all: Vec<_> = (1..=parts)
                .flat_map(|it| part_of(count, it, parts))
                .collect();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
        }
    }
}
