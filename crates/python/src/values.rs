//! Values from Python to Rust and back.

use column_twin::parameters::Value;
use pyo3::IntoPyObjectExt as _;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyFloat, PyInt, PyString};

/// Bytes of a `f64`.
const BYTES: usize = size_of::<f64>();

/// The value of a parameter: `bool`, `int`, `float`, `str`, or a list of numbers or of strings.
pub fn value(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    if given.is_instance_of::<PyBool>() {
        return Ok(Value::Bool(given.extract()?));
    }
    if given.is_instance_of::<PyInt>() {
        // Beyond 64 bits it is a number that no range contains.
        let whole = given.extract().map(Value::Integer);
        return whole.or_else(|_| given.extract().map(Value::Double));
    }
    if given.is_instance_of::<PyFloat>() {
        return Ok(Value::Double(given.extract()?));
    }
    if given.is_instance_of::<PyString>() {
        return Ok(Value::String(given.extract()?));
    }
    if let Ok(numbers) = given.extract::<Vec<f64>>() {
        return Ok(Value::DoubleArray(numbers));
    }
    given.extract().map(Value::StringArray).map_err(|_| {
        let found = given.get_type();
        PyTypeError::new_err(format!(
            "{name}: expected bool, int, float, str, or a list of numbers or of strings; found {found}"
        ))
    })
}

/// A value for Python.
pub fn object<'py>(py: Python<'py>, value: Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Bool(it) => it.into_bound_py_any(py),
        Value::Integer(it) => it.into_bound_py_any(py),
        Value::Double(it) => it.into_bound_py_any(py),
        Value::String(it) => it.into_bound_py_any(py),
        Value::DoubleArray(it) => it.into_bound_py_any(py),
        Value::StringArray(it) => it.into_bound_py_any(py),
    }
}

/// An array of doubles of this machine, which is read where it is.
#[derive(Clone, Copy)]
pub struct Doubles<'a>(&'a [[u8; BYTES]]);

impl<'a> Doubles<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes.as_chunks().0)
    }

    pub fn len(self) -> usize {
        self.0.len()
    }

    pub fn get(self, index: usize) -> f64 {
        f64::from_ne_bytes(self.0[index])
    }
}

/// Numbers as an array of doubles of this machine, to which numpy gives a shape without a copy.
pub fn doubles<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, BYTES * values.len(), |bytes| {
        let (chunks, _) = bytes.as_chunks_mut::<BYTES>();
        for (chunk, value) in chunks.iter_mut().zip(values) {
            *chunk = value.to_ne_bytes();
        }
        Ok(())
    })
}
