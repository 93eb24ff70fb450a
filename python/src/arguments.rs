//! Numbers, and yes or no, as Python gives them. What is wrong with one is said by its name.

use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::error::refuse;

/// A whole number, of Python or NumPy. Yes and no are none.
pub struct Whole(pub i64);

impl<'a, 'py> FromPyObject<'a, 'py> for Whole {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if given.is_instance_of::<PyBool>() {
            return Err(PyTypeError::new_err("yes and no are no numbers"));
        }
        given.extract().map(Self)
    }
}

/// An argument: its value; or, where it has none of this kind, how Python writes what it is.
pub struct Given<T>(Result<T, String>);

impl<T> Given<T> {
    /// What is there if nothing is given.
    pub const fn default(value: T) -> Self {
        Self(Ok(value))
    }

    /// The value.
    ///
    /// # Errors
    /// Without one: the argument is said not to be `what`.
    pub fn value(self, argument: &str, what: &str) -> PyResult<T> {
        self.0.map_err(|given| refuse(format!("{argument} is {what}, not {given}")))
    }
}

impl<'a, 'py, T: FromPyObject<'a, 'py>> FromPyObject<'a, 'py> for Given<T> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match or_none(given.extract().map_err(Into::into))? {
            Some(value) => Ok(Self(Ok(value))),
            None => Ok(Self(Err(shown(given)?))),
        }
    }
}

/// As Python writes it.
fn shown(given: Borrowed<'_, '_, PyAny>) -> PyResult<String> {
    match or_none(given.repr())? {
        Some(text) => Ok(text.to_string_lossy().into_owned()),
        // Python writes no number of thousands of digits.
        None => Ok(format!("<unprintable {} object>", given.get_type().name()?)),
    }
}

/// Nothing where a value is of a wrong kind or too large. What else the code of a user raises meanwhile is passed on.
pub fn or_none<T>(read: PyResult<T>) -> PyResult<Option<T>> {
    let error = match read {
        Ok(value) => return Ok(Some(value)),
        Err(error) => error,
    };
    let is_of_value = Python::attach(|py| {
        error.is_instance_of::<PyTypeError>(py)
            || error.is_instance_of::<PyValueError>(py)
            || error.is_instance_of::<PyOverflowError>(py)
    });
    if is_of_value { Ok(None) } else { Err(error) }
}
