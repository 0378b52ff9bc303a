//! Vectors and matrices on their way to NumPy.

use nalgebra::{DMatrix, DVector};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use crate::model::Numbering;

/// A matrix over the coordinates, from the inside order to the outside one.
pub fn outside_matrix<'py>(py: Python<'py>, numbering: &Numbering, inside: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    let dofs = numbering.dofs();
    let entry = |(i, j): (usize, usize)| inside[(dofs[i].index, dofs[j].index)] * dofs[i].sign * dofs[j].sign;
    Array2::from_shape_fn((dofs.len(), dofs.len()), entry).into_pyarray(py)
}

/// A vector over the coordinates, from the inside order to the outside one.
pub fn outside_vector<'py>(py: Python<'py>, numbering: &Numbering, inside: &DVector<f64>) -> Bound<'py, PyArray1<f64>> {
    Array1::from(numbering.to_user_order(inside.as_slice())).into_pyarray(py)
}

/// A row-major list as an array of `rows` × `columns`.
pub fn table<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    Array2::from_shape_vec((rows, columns), values).map(|array| array.into_pyarray(py)).map_err(shape_error)
}

/// A row-major list as an array of `blocks` × `rows` × `columns`.
pub fn stack<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    blocks: usize,
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'_, PyArray3<T>>> {
    Array3::from_shape_vec((blocks, rows, columns), values).map(|array| array.into_pyarray(py)).map_err(shape_error)
}

fn shape_error(error: numpy::ndarray::ShapeError) -> PyErr {
    pyo3::exceptions::PyRuntimeError::new_err(error.to_string())
}
