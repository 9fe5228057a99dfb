//! Many impacts on one column: all of them are checked, and then computed.

use std::num::NonZeroUsize;
use std::sync::Arc;

use column_twin::column::Impact;
use column_twin::study::{BatchEnd, StudyColumn};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyByteArray;

use crate::batch::{ROW_BYTES, Row, batch, interruptible};
use crate::checks::Checks;
use crate::fault;
use crate::values::Doubles;

/// Impacts of one vehicle as arrays of doubles, which are read where Python has them.
pub struct Arrays {
    /// Total masses \[kg\]; without them the vehicle has its own.
    pub masses: Option<PyBackedBytes>,
    /// Speeds \[m/s\].
    pub velocities: PyBackedBytes,
}

impl Arrays {
    fn count(&self) -> u64 {
        Doubles::new(&self.velocities).len() as u64
    }

    fn mass(&self, index: u64) -> Option<f64> {
        let masses = self.masses.as_deref()?;
        Some(Doubles::new(masses).get(index as usize))
    }

    fn velocity(&self, index: u64) -> f64 {
        Doubles::new(&self.velocities).get(index as usize)
    }

    /// Mass and speed of the first impact; `None` without impacts.
    pub fn first(&self) -> Option<(Option<f64>, f64)> {
        (self.count() > 0).then(|| (self.mass(0), self.velocity(0)))
    }
}

/// The impacts of arrays with their checks.
struct Impacts {
    arrays: Arrays,
    checks: Checks,
}

impl Impacts {
    /// The impact of this index, if it is accepted.
    fn impact(&self, index: u64) -> Result<Impact, ()> {
        let (mass, velocity) = (self.arrays.mass(index), self.arrays.velocity(index));
        self.checks.impact(mass, velocity)
    }
}

/// Why a batch ended early.
enum BatchFault {
    /// The impact of this index is not accepted.
    Input(u64),
    /// An impact cannot be computed; which one and why.
    Response(String),
    Threads(rayon::ThreadPoolBuildError),
}

impl From<rayon::ThreadPoolBuildError> for BatchFault {
    fn from(reason: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(reason)
    }
}

/// What the impacts lead to, as rows of bytes. `fault_of` says why an impact of this mass and speed is not accepted.
pub fn evaluate<'py>(
    py: Python<'py>,
    study: &Arc<StudyColumn>,
    (arrays, checks): (Arrays, Checks),
    fault_of: impl Fn(Option<f64>, f64) -> String,
    threads: Option<NonZeroUsize>,
) -> PyResult<Bound<'py, PyByteArray>> {
    let count = arrays.count();
    let impacts = Arc::new(Impacts { arrays, checks });
    let batch = batch(py, threads, count)?;
    let raised = |reason: BatchFault| match reason {
        BatchFault::Input(index) => {
            let arrays = &impacts.arrays;
            let text = fault_of(arrays.mass(index), arrays.velocity(index));
            fault::input(format!("element {index}: {text}"))
        }
        BatchFault::Response(text) => fault::simulation(text),
        BatchFault::Threads(reason) => fault::no_threads(&reason),
    };
    // All of them first, which takes no time, so that a wrong one is found before hours of computation.
    let all = Arc::clone(&impacts);
    let checked = interruptible(py, &batch, move |batch| {
        let checked = |index: u64| all.impact(index).map(|it| all.checks.implausible(&it));
        let mut light = None;
        let mut index = 0;
        batch.run(count, checked, |results| {
            for result in results {
                match result {
                    Ok(None) => {}
                    Ok(Some(text)) => light = light.take().or(Some((index, text))),
                    Err(()) => return Err(BatchFault::Input(index)),
                }
                index += 1;
            }
            Ok::<_, BatchFault>(())
        })?;
        Ok::<_, BatchFault>(light)
    })?;
    if let Some((index, text)) = checked.map_err(&raised)? {
        fault::warn(
            py,
            &format!("element {index}: impact.mass is the mass of {text}"),
        )?;
    }
    let (all, study) = (Arc::clone(&impacts), Arc::clone(study));
    let computed = interruptible(py, &batch, move |batch| {
        let mut bytes = Vec::with_capacity(ROW_BYTES * count as usize);
        let evaluated = |index: u64| {
            let impact = all.impact(index).map_err(|()| BatchFault::Input(index))?;
            let evaluation = study.evaluate(&impact).map_err(|reason| {
                // The whole speed: of an oblique hit, the impact has the component in the plane of the two bars.
                let (mass, velocity) = (impact.mass, all.arrays.velocity(index));
                let text = format!("element {index} ({mass} kg at {velocity} m/s): {reason}");
                BatchFault::Response(text)
            })?;
            Ok::<_, BatchFault>(Row::new(&impact, &evaluation))
        };
        let end = batch.run(count, evaluated, |results| {
            for result in results {
                bytes.extend_from_slice(&result?.bytes());
            }
            Ok::<_, BatchFault>(())
        })?;
        Ok::<_, BatchFault>((end, bytes))
    })?;
    let (end, bytes) = computed.map_err(raised)?;
    if let BatchEnd::Interrupted(done) = end {
        return Err(fault::simulation(format!(
            "the batch was interrupted after {done} impacts"
        )));
    }
    Ok(PyByteArray::new(py, &bytes))
}
