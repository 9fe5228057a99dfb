//! Columns of a fleet that a person names: by their `column_id`, or by their names with the wildcards of parameter files.

use std::fmt;

use super::fleet::FleetColumn;
use super::node_name::NodeName;
use printable::Printable;

/// Columns that cannot be selected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SelectionError {
    /// The fleet has no such column.
    Unknown {
        /// What was given.
        given: Vec<String>,
        /// Number of columns of the fleet.
        columns: usize,
    },
    /// More columns than can be shown.
    TooMany {
        /// How many were selected.
        selected: usize,
        /// How many can be.
        most: usize,
    },
}

impl fmt::Display for SelectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { given, columns } => {
                let given: Vec<_> = given.iter().map(|it| Printable(it).to_string()).collect();
                write!(
                    f,
                    "viewer.select: the fleet of {columns} columns has no {}; expected values of column_id, or names with the \
                     wildcards of parameter files, such as /garage/*",
                    given.join(", ")
                )
            }
            Self::TooMany { selected, most } => write!(
                f,
                "viewer.select selects {selected} columns, but the viewer shows at most {most} in full; select fewer: the overview \
                 has all of them"
            ),
        }
    }
}

impl std::error::Error for SelectionError {}

/// The indices of the columns that are selected, each once, in the order of the fleet. What contains a slash is a name with
/// wildcards, anything else a `column_id`.
///
/// # Errors
/// Something selects no column, or more than `most` columns are selected.
pub fn select_columns(
    columns: &[FleetColumn],
    given: &[String],
    most: usize,
) -> Result<Vec<u32>, SelectionError> {
    let is_of = |column: &FleetColumn, given: &str| match given.contains('/') {
        true => NodeName::new("", &column.name).is_meant_by(given),
        false => column.parameters.settings().column_id == given,
    };
    let unknown = given
        .iter()
        .filter(|it| !columns.iter().any(|column| is_of(column, it)));
    let unknown: Vec<String> = unknown.cloned().collect();
    if !unknown.is_empty() {
        return Err(SelectionError::Unknown {
            given: unknown,
            columns: columns.len(),
        });
    }
    let numbered = (0..).zip(columns);
    let selected = numbered.filter(|(_, column)| given.iter().any(|it| is_of(column, it)));
    let selected: Vec<u32> = selected.map(|(index, _)| index).collect();
    match selected.len() {
        selected if selected > most => Err(SelectionError::TooMany { selected, most }),
        _ => Ok(selected),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Parameters;
    use super::*;
    use std::sync::Arc;

    fn fleet() -> Vec<FleetColumn> {
        let column = |name: &str, id: &str| FleetColumn {
            name: name.to_owned(),
            parameters: Arc::new(
                Parameters::from_values([("column_id", id.into())]).expect("admissible"),
            ),
        };
        vec![
            column("/garage/a3", "a3"),
            column("/garage/a4", "left"),
            column("/hall/b1", "b1"),
        ]
    }

    fn selected(given: &[&str]) -> Result<Vec<u32>, SelectionError> {
        let given: Vec<_> = given.iter().map(|it| (*it).to_owned()).collect();
        select_columns(&fleet(), &given, 2)
    }

    #[test]
    fn columns_are_selected_by_identifier_and_by_name() {
        assert_eq!(selected(&[]), Ok(vec![]));
        assert_eq!(selected(&["b1", "a3", "/garage/a3"]), Ok(vec![0, 2]));
        assert_eq!(selected(&["/garage/*"]), Ok(vec![0, 1]));
        assert_eq!(selected(&["/**/b1"]), Ok(vec![2]));
    }

    #[test]
    fn what_selects_nothing_or_too_much_is_rejected() {
        let error = selected(&["a4", "a3", "/roof/*"]).expect_err("there are none");
        assert_eq!(
            error.to_string(),
            "viewer.select: the fleet of 3 columns has no a4, /roof/*; expected values of column_id, or names with the wildcards of \
             parameter files, such as /garage/*"
        );
        let error = selected(&["/**"]).expect_err("too many");
        assert_eq!(
            error,
            SelectionError::TooMany {
                selected: 3,
                most: 2
            }
        );
    }
}
