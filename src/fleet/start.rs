//! The twins of a fleet at its start. Columns that differ by their names only are computed once.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use crate::column::ModelError;
use crate::parameters::FleetColumn;
use crate::time::Nanos;
use crate::twin::{SavedState, Twin};

/// Most columns that an error lists.
const MAX_LISTED: usize = 20;

/// Columns that cannot stand.
#[derive(Debug)]
pub struct FleetStartError(Vec<(String, ModelError)>);

impl fmt::Display for FleetStartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} columns of the fleet cannot start", self.0.len())?;
        for (name, error) in self.0.iter().take(MAX_LISTED) {
            write!(f, "\n  {name}: {error}")?;
        }
        match self.0.len().saturating_sub(MAX_LISTED) {
            0 => Ok(()),
            more => write!(f, "\n  and {more} more"),
        }
    }
}

impl std::error::Error for FleetStartError {}

/// One twin for each column, with the damage in `saved`, if there is any. `stopwatch` gives monotonic nanoseconds.
///
/// # Errors
/// All columns that are impossible.
pub fn make_twins(
    columns: &[FleetColumn],
    saved: &[Option<Box<SavedState>>],
    stopwatch: fn() -> u64,
    now: Nanos,
) -> Result<Vec<Twin>, FleetStartError> {
    let mut twins: Vec<Twin> = Vec::with_capacity(columns.len());
    // The first undamaged column of each kind.
    let mut first: HashMap<String, usize> = HashMap::new();
    let mut impossible = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let parameters = Arc::clone(&column.parameters);
        let saved = saved.get(index).and_then(Option::as_deref);
        let kind = saved.is_none().then(|| parameters.without_names());
        let equal = kind.as_ref().and_then(|kind| twins.get(*first.get(kind)?));
        let sibling =
            equal.and_then(|it| it.sibling(Arc::clone(&parameters), Box::new(stopwatch), now));
        let made = match sibling {
            Some(twin) => Ok(twin),
            None => Twin::new(parameters, saved, Box::new(stopwatch), now),
        };
        match made {
            Ok(twin) => {
                if let Some(kind) = kind {
                    first.entry(kind).or_insert(twins.len());
                }
                twins.push(twin);
            }
            Err(error) => impossible.push((column.name.clone(), error)),
        }
    }
    match impossible.is_empty() {
        true => Ok(twins),
        false => Err(FleetStartError(impossible)),
    }
}
