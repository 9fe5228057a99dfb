//! Many impacts at once, in rows of bytes that numpy reads as a structured array.

use std::ffi::CString;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use column_twin::column::Impact;
use column_twin::parameters::CRITERION_NAMES;
use column_twin::study::{Batch, Evaluation, Threads};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

/// Numbers of a row.
pub const NUMBERS: usize = 9;

/// Bytes of a row: its numbers, and three codes in 2, 2 and 4 bytes, so that no byte is left over whose value would be undefined.
pub const ROW_BYTES: usize = NUMBERS * 8 + 8;

/// Bytes of a row without mass and velocity.
pub const CELL_BYTES: usize = ROW_BYTES - 2 * 8;

/// Time between two looks at the signals of Python.
const SIGNALS: Duration = Duration::from_millis(20);

/// How far the caller of a method in Python is from here: above the method and the check of its keywords (`_keyword_check.py`).
pub const CALLER: i32 = 3;

/// One impact and what it leads to, as numbers. The order is that of `_evaluation.py`.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Mass, velocity, peak v1, residual v1, peak contact force, residual capacity, its ratio, its reserve, and the largest
    /// plastic rotation; NaN where there is none.
    pub numbers: [f64; NUMBERS],
    /// Its verdict.
    pub codes: Codes,
}

/// Action, outcome, and the place of the deciding criterion among the names.
#[derive(Debug, Clone, Copy)]
pub struct Codes(pub [u8; 3]);

impl Codes {
    /// Of what could not be computed: larger than every action, so that a comparison does not take it for harmless.
    pub const UNKNOWN: Self = Self([u8::MAX; 3]);
}

impl Row {
    pub fn new(impact: &Impact, evaluation: &Evaluation) -> Self {
        Self::of([impact.mass, impact.velocity], evaluation)
    }

    pub fn of([mass, velocity]: [f64; 2], evaluation: &Evaluation) -> Self {
        let criterion = CRITERION_NAMES
            .iter()
            .position(|name| *name == evaluation.deciding_criterion)
            .expect("every criterion has a name");
        Self {
            numbers: [
                mass,
                velocity,
                evaluation.max_v1,
                evaluation.residual_v1.unwrap_or(f64::NAN),
                evaluation.peak_contact_force,
                evaluation.residual_capacity,
                evaluation.capacity_ratio,
                evaluation.reserve.unwrap_or(f64::NAN),
                evaluation.max_plastic_rotation,
            ],
            codes: Codes([
                evaluation.action as u8,
                evaluation.outcome as u8,
                criterion as u8,
            ]),
        }
    }

    pub fn bytes(&self) -> [u8; ROW_BYTES] {
        let mut bytes = [0; ROW_BYTES];
        let (numbers, codes) = bytes.split_at_mut(NUMBERS * 8);
        let (chunks, _) = numbers.as_chunks_mut::<8>();
        for (chunk, number) in chunks.iter_mut().zip(self.numbers) {
            *chunk = number.to_ne_bytes();
        }
        let [action, outcome, criterion] = self.codes.0;
        codes[..2].copy_from_slice(&u16::from(action).to_ne_bytes());
        codes[2..4].copy_from_slice(&u16::from(outcome).to_ne_bytes());
        codes[4..].copy_from_slice(&u32::from(criterion).to_ne_bytes());
        bytes
    }

    /// Without mass and velocity, which the axes of a map tell.
    pub fn bytes_of_cell(&self) -> [u8; CELL_BYTES] {
        let bytes = self.bytes();
        let (_, cell) = bytes.split_last_chunk().expect("a part of a row");
        *cell
    }
}

/// A batch for so many computations on as many threads as were asked for; fewer, with a warning, if they would be too many.
pub fn batch(
    py: Python<'_>,
    asked: Option<NonZeroUsize>,
    computations: u64,
) -> PyResult<Arc<Batch>> {
    if let Some(reduction) = Threads::new(asked, computations).reduction() {
        let category = py.get_type::<PyUserWarning>();
        PyErr::warn(py, &category, &CString::new(reduction)?, CALLER)?;
    }
    Ok(Arc::new(
        asked.map_or_else(Batch::default, Batch::on_threads),
    ))
}

/// Does the work of a batch in another thread without the GIL. Ctrl-C interrupts the batch and ends the call; the responses that have
/// begun, of which one by the fibre beam takes tenths of a second, end by themselves, later.
pub fn interruptible<R: Send + 'static>(
    py: Python<'_>,
    batch: &Arc<Batch>,
    work: impl FnOnce(&Batch) -> R + Send + 'static,
) -> PyResult<R> {
    let shared = Arc::clone(batch);
    abandonable(py, move || work(&shared)).inspect_err(|_| batch.interrupt())
}

/// Does work that cannot be interrupted in another thread without the GIL. Ctrl-C ends the call; the thread ends by itself, later.
pub fn abandonable<R: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> R + Send + 'static,
) -> PyResult<R> {
    py.detach(|| {
        let (running, ended) = sync_channel::<()>(0);
        let named = thread::Builder::new().name("column_twin call".to_owned());
        let worker = named.spawn(move || {
            let _running = running;
            work()
        })?;
        if let Some(raised) = signalled(&ended) {
            return Err(raised);
        }
        match worker.join() {
            Ok(result) => Ok(result),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Waits until the other end is dropped, or until a signal raises an exception.
fn signalled(ended: &Receiver<()>) -> Option<PyErr> {
    while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(SIGNALS) {
        let raised = Python::attach(|py| py.check_signals()).err();
        if raised.is_some() {
            return raised;
        }
    }
    None
}
