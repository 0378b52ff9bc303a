//! Conversion of descriptions to plain Python data, and of vectors, matrices and mesh quantities to NumPy arrays.
//!
//! The core orders coordinates by shaft and motion; Python orders them by node (see `model/numbering.rs`).

use nalgebra::{DMatrix, DVector};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping, PyString};
use pythonize::{PythonizeNamedMappingType, PythonizeTypes, pythonize_custom};
use serde::Serialize;

use crate::analysis::Kept;
use crate::connection::{BEARING_CHANNELS, Channel, MESH_CHANNELS, ROLLING_CHANNELS};
use crate::linalg::Sparse;
use crate::model::{Model, Numbering};
use crate::scene::SceneError;

/// Gives a description as plain data, in which fields that are not given are absent.
pub fn plain<'py>(py: Python<'py>, description: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    Ok(pythonize_custom::<GivenFields, _>(py, description)?)
}

/// Structures are dictionaries without the fields that are none.
struct GivenFields;

impl PythonizeTypes for GivenFields {
    type Map = PyDict;
    type NamedMap = Self;
    type List = PyList;
}

impl PythonizeNamedMappingType for GivenFields {
    type Builder<'py> = Bound<'py, PyDict>;

    fn builder<'py>(py: Python<'py>, _: usize, _: &'static str) -> PyResult<Self::Builder<'py>> {
        Ok(PyDict::new(py))
    }

    fn push_field<'py>(
        fields: &mut Self::Builder<'py>,
        name: Bound<'py, PyString>,
        value: Bound<'py, PyAny>,
    ) -> PyResult<()> {
        if value.is_none() { Ok(()) } else { fields.set_item(name, value) }
    }

    fn finish<'py>(fields: Self::Builder<'py>) -> PyResult<Bound<'py, PyMapping>> {
        Ok(fields.into_mapping())
    }
}

/// Converts an (n, n) matrix from the coordinate order of the core to that of Python.
pub fn outside_matrix(numbering: &Numbering, inside: &DMatrix<f64>) -> Array2<f64> {
    let dofs = numbering.dofs();
    let entry = |(i, j): (usize, usize)| inside[(dofs[i].index, dofs[j].index)] * dofs[i].sign * dofs[j].sign;
    Array2::from_shape_fn((dofs.len(), dofs.len()), entry)
}

/// Entries, columns and row starts (CSR) of a sparse matrix.
pub type Rows<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);

/// Converts a sparse (n, n) matrix from the coordinate order of the core to that of Python.
pub fn outside_sparse<'py>(py: Python<'py>, numbering: &Numbering, inside: &Sparse) -> Rows<'py> {
    let dofs = numbering.dofs();
    let mut places = vec![(0, 1.0); dofs.len()];
    for (place, dof) in dofs.iter().enumerate() {
        places[dof.index] = (place, dof.sign);
    }
    let mut entries = Vec::with_capacity(inside.values.len());
    inside.for_each(|row, column, value| {
        let ((row, left), (column, right)) = (places[row], places[column]);
        entries.push((row, column, left * right * value));
    });
    let outside = Sparse::new(dofs.len(), entries);
    let integers = |values: Vec<usize>| values.into_iter().map(|value| value as i64).collect::<Vec<_>>();
    (
        outside.values.into_pyarray(py),
        integers(outside.columns).into_pyarray(py),
        integers(outside.starts).into_pyarray(py),
    )
}

/// Converts an (n,) vector from the coordinate order of the core to that of Python.
pub fn outside_vector<'py>(py: Python<'py>, numbering: &Numbering, inside: &DVector<f64>) -> Bound<'py, PyArray1<f64>> {
    Array1::from(numbering.to_user_order(inside.as_slice())).into_pyarray(py)
}

/// Converts a row-major list to a (rows, columns) array.
pub fn table<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    Array2::from_shape_vec((rows, columns), values).map(|array| array.into_pyarray(py)).map_err(shape_error)
}

/// Converts a row-major list to a (blocks, rows, columns) array.
pub fn stack<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    blocks: usize,
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'_, PyArray3<T>>> {
    Array3::from_shape_vec((blocks, rows, columns), values).map(|array| array.into_pyarray(py)).map_err(shape_error)
}

/// Gives the names of the driver and the driven gear of meshes.
pub fn mesh_names(model: &Model, meshes: impl Iterator<Item = usize>) -> Vec<(&str, &str)> {
    meshes.map(|mesh| model.gear_names(mesh).into()).collect()
}

/// Units of the quantities that a run can record, by kind of connection ("mesh", "bearing", "rolling") and name.
#[pyfunction]
pub fn connection_channels(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let units = |channels: &[Channel]| {
        let dict = PyDict::new(py);
        channels.iter().try_for_each(|channel| dict.set_item(channel.name, channel.unit))?;
        PyResult::Ok(dict)
    };
    let dict = PyDict::new(py);
    dict.set_item("mesh", units(&MESH_CHANNELS)?)?;
    dict.set_item("bearing", units(&BEARING_CHANNELS)?)?;
    dict.set_item("rolling", units(&ROLLING_CHANNELS)?)?;
    Ok(dict)
}

/// Converts the recorded quantities of meshes to arrays of shape (times, meshes), or (meshes,) if `flat`, by name.
pub fn mesh_fields<'py>(
    py: Python<'py>,
    fields: [Vec<f64>; MESH_CHANNELS.len()],
    times: usize,
    meshes: usize,
    flat: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (Channel { name, .. }, values) in MESH_CHANNELS.iter().zip(fields) {
        if flat {
            dict.set_item(name, values.into_pyarray(py))?;
        } else {
            dict.set_item(name, table(py, values, times, meshes)?)?;
        }
    }
    Ok(dict)
}

/// Refuses work whose results, described in plural, take more memory, in bytes, than is available; the argument determines their
/// amount.
///
/// # Errors
/// [`SceneError`] with the required and the available memory and the remedy.
#[pyfunction]
pub fn require_memory(argument: &str, what: String, needed: f64, remedy: &str) -> Result<(), SceneError> {
    // A conversion of a larger number gives the largest one.
    Kept { argument, what, bytes: needed as u64, remedy }.require()
}

fn shape_error(error: numpy::ndarray::ShapeError) -> PyErr {
    pyo3::exceptions::PyRuntimeError::new_err(error.to_string())
}
