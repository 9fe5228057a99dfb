//! Faults as Python exceptions, with the texts that the command line prints.

use std::ffi::CString;

use column_twin::column::{CapacityError, SimulationError};
use column_twin::parameters::ParameterFaults;
use column_twin::study::StudyError;
use pyo3::prelude::*;

use crate::batch::CALLER;

mod exceptions {
    //! The exceptions, which Python defines.
    pyo3::import_exception!(column_twin._errors, ParameterError);
    pyo3::import_exception!(column_twin._errors, SimulationError);
    pyo3::import_exception!(column_twin._errors, ParameterWarning);
}

/// Parameters that are not accepted, all faults together.
pub fn parameters(faults: &ParameterFaults) -> PyErr {
    exceptions::ParameterError::new_err(faults.to_string())
}

/// Input that is not accepted.
pub fn input(message: String) -> PyErr {
    exceptions::ParameterError::new_err(message)
}

/// What could not be computed.
pub fn simulation(message: String) -> PyErr {
    exceptions::SimulationError::new_err(message)
}

pub fn study(fault: &StudyError) -> PyErr {
    match fault {
        StudyError::Simulation(fault) => of_simulation(fault),
        other => input(other.to_string()),
    }
}

pub fn of_simulation(fault: &SimulationError) -> PyErr {
    let text = format!("the impact cannot be simulated: {fault}");
    match fault {
        SimulationError::Step(_) => simulation(text),
        SimulationError::Model(_) | SimulationError::Impact(_) => input(text),
    }
}

pub fn of_capacity(fault: &CapacityError) -> PyErr {
    input(fault.to_string())
}

pub fn no_threads(reason: &rayon::ThreadPoolBuildError) -> PyErr {
    simulation(format!("the system gives no threads: {reason}"))
}

/// Warns the caller of the method in Python.
pub fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let category = py.get_type::<exceptions::ParameterWarning>();
    PyErr::warn(py, &category, &CString::new(text)?, CALLER)
}
