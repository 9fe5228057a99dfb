//! What undamaged columns bear by the beam, of the last columns that were computed: the next hit on one of them, a variation of its
//! speed, or the next cell of a map does not compute it again. It is the same number, bit for bit.

use std::sync::{Mutex, MutexGuard, PoisonError};

use column_beam::{BeamColumn, BeamError, BeamModel, Undamaged};

/// Most columns that are kept: each height of an impact makes another one.
const MOST: usize = 64;

type Known = Vec<(BeamColumn, Undamaged)>;

/// The one that was computed last is the last one.
static KNOWN: Mutex<Known> = Mutex::new(Vec::new());

fn known() -> MutexGuard<'static, Known> {
    // What another thread has left is complete, even if it has panicked.
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The model of this column.
///
/// # Errors
/// As [`BeamModel::new`].
pub(super) fn model(column: &BeamColumn) -> Result<BeamModel, BeamError> {
    let undamaged = known()
        .iter()
        .find(|(it, _)| it == column)
        .map(|(_, undamaged)| *undamaged);
    match undamaged {
        Some(undamaged) => Ok(BeamModel::known(column, undamaged)),
        None => BeamModel::new(column),
    }
}

/// Keeps what this column bears.
pub(super) fn keep(column: &BeamColumn, undamaged: Undamaged) {
    let mut known = known();
    if known.iter().any(|(it, _)| it == column) {
        return;
    }
    if known.len() == MOST {
        known.remove(0);
    }
    known.push((*column, undamaged));
}
