//! The native part of the Python package `rayreel`: traces, columns, replays and simulations. What Python programs see of it is
//! written in `rayreel/`, in Python.

mod arguments;
mod batches;
mod columns;
mod error;
mod policy;
mod replay;
mod trace;
mod view;
mod wait;
mod wanted;

use numpy::PyArray1;
use pyo3::prelude::*;

/// The native part of the package `rayreel`.
#[pymodule(gil_used = true)]
mod _native {
    use super::*;
    #[pymodule_export]
    use crate::batches::Batches;
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::replay::Frame;
    #[pymodule_export]
    use crate::trace::{Trace, preset, presets, tables};
    #[pymodule_export]
    use crate::view::TileView;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let hook = wrap_pyfunction!(crate::policy::end_policies, module)?;
        // NumPy's API is looked up with the first array, in NumPy's Python code: a signal that waits there would end in a panic.
        PyArray1::<u8>::from_vec(module.py(), Vec::new());
        module.py().import("atexit")?.call_method1("register", (hook,))?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("MODEL_VERSION", rayreel_study::point::version::MODEL_VERSION)
    }
}
