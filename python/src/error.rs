//! Errors of the crates as the one exception of the package.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pyo3::create_exception!(rayreel, Error, PyValueError, "What was asked for cannot be had, or a file cannot be read.");

/// The exception that says what went wrong, and why, in one line.
pub fn raise(error: &dyn std::error::Error) -> PyErr {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    Error::new_err(text)
}

/// The exception with this text.
pub fn refuse(text: impl Into<String>) -> PyErr {
    Error::new_err(text.into())
}
