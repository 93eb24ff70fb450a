//! Columns as NumPy arrays: the memory in which the rows were made becomes the array's.

use numpy::{PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayreel_columns::{Batch, Column, Head, Words};

/// The columns of a batch by name: an array, or for words a pair of an array of codes and the list of words.
pub fn to_dict<'py>(py: Python<'py>, head: &Head, batch: Batch) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for ((info, _), column) in head.columns().zip(batch.columns) {
        dict.set_item(info.name, array(py, column)?)?;
    }
    Ok(dict)
}

fn array(py: Python<'_>, column: Column) -> PyResult<Bound<'_, PyAny>> {
    Ok(match column {
        Column::U8(values) => PyArray1::from_vec(py, values).into_any(),
        Column::I8(values) => PyArray1::from_vec(py, values).into_any(),
        Column::U16(values) => PyArray1::from_vec(py, values).into_any(),
        Column::U32(values) => PyArray1::from_vec(py, values).into_any(),
        Column::I32(values) => PyArray1::from_vec(py, values).into_any(),
        Column::U64(values) => PyArray1::from_vec(py, values).into_any(),
        Column::I64(values) => PyArray1::from_vec(py, values).into_any(),
        Column::F32(values) => PyArray1::from_vec(py, values).into_any(),
        Column::Bool(values) => PyArray1::from_vec(py, values).into_any(),
        Column::Word(Words { codes, names }) => {
            let words = PyList::new(py, names.iter())?;
            (PyArray1::from_vec(py, codes), words).into_pyobject(py)?.into_any()
        }
    })
}

/// A picture of three values a pixel: rows, columns, channels.
pub fn picture(py: Python<'_>, (width, height): (u32, u32), values: Vec<f32>) -> PyResult<Bound<'_, PyAny>> {
    let array = PyArray1::from_vec(py, values);
    Ok(array.reshape([height as usize, width as usize, 3])?.into_any())
}

/// One value a pixel or sample: rows, columns.
pub fn plane<T: numpy::Element>(
    py: Python<'_>,
    (width, height): (u32, u32),
    values: Vec<T>,
) -> PyResult<Bound<'_, PyAny>> {
    Ok(PyArray1::from_vec(py, values).reshape([height as usize, width as usize])?.into_any())
}
