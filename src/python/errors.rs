//! Converts errors and warnings of the core to the classes of `gearbow.errors`.

use std::ffi::CString;

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::{PyErr, PyResult, PyTypeInfo, Python};

use crate::analysis::AnalysisError;
use crate::linalg::DecompositionError;
use crate::scene::Scene;

pyo3::import_exception!(gearbow.errors, SceneError);
pyo3::import_exception!(gearbow.errors, StabilityError);
pyo3::import_exception!(gearbow.errors, ContactError);
pyo3::import_exception!(gearbow.errors, ConvergenceError);
pyo3::import_exception!(gearbow.errors, AccuracyWarning);
pyo3::import_exception!(gearbow.errors, SceneWarning);

/// Issues an `AccuracyWarning` at the caller of the Python function that called the core.
pub fn warn(py: Python<'_>, text: String) -> PyResult<()> {
    let text = CString::new(text).unwrap_or_default();
    PyErr::warn(py, &AccuracyWarning::type_object(py), &text, 2)
}

/// Issues a `SceneWarning` if a speed of the reference shaft, rad/s, is implausibly high for the gears.
pub fn warn_of_speed(py: Python<'_>, scene: &Scene, speed: f64) -> PyResult<()> {
    let Some(text) = scene.pitch_line_warning(speed) else { return Ok(()) };
    let text = CString::new(text).unwrap_or_default();
    PyErr::warn(py, &SceneWarning::type_object(py), &text, 2)
}

impl From<crate::scene::SceneError> for PyErr {
    fn from(error: crate::scene::SceneError) -> Self {
        SceneError::new_err(error.to_string())
    }
}

impl From<DecompositionError> for PyErr {
    fn from(error: DecompositionError) -> Self {
        ConvergenceError::new_err(error.to_string())
    }
}

impl From<AnalysisError> for PyErr {
    fn from(error: AnalysisError) -> Self {
        let text = error.to_string();
        match error {
            AnalysisError::Scene(error) => error.into(),
            AnalysisError::Stability(_) => StabilityError::new_err(text),
            AnalysisError::Contact(_) => ContactError::new_err(text),
            AnalysisError::Convergence(_) => ConvergenceError::new_err(text),
            AnalysisError::Interrupted => PyKeyboardInterrupt::new_err(text),
        }
    }
}
