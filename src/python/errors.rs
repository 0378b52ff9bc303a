//! Converts errors and warnings of the core to the classes of `gearbow.errors`.

use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::types::PyAnyMethods;
use pyo3::{Bound, PyAny, PyErr, PyResult, PyTypeInfo, Python};

use crate::analysis::AnalysisError;
use crate::linalg::DecompositionError;
use crate::modal::EquilibriumError;
use crate::scene::Scene;

pyo3::import_exception!(gearbow.errors, GearbowError);
pyo3::import_exception!(gearbow.errors, SceneError);
pyo3::import_exception!(gearbow.errors, StabilityError);
pyo3::import_exception!(gearbow.errors, ContactError);
pyo3::import_exception!(gearbow.errors, ConvergenceError);
pyo3::import_exception!(gearbow.errors, AccuracyWarning);
pyo3::import_exception!(gearbow.errors, SceneWarning);

/// Place and message of the last panic, which a panic of a worker thread does not carry to the thread that waits for it.
static LAST_PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Keeps the place and the message of each panic for [`internal`], instead of writing them to the standard error.
pub fn keep_panics() {
    set_hook(Box::new(|panic| *LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner) = Some(panic.to_string())));
}

/// The error of the last panic.
pub fn internal() -> PyErr {
    let panic = LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
    let panic = panic.unwrap_or_default().replace('\n', " ");
    GearbowError::new_err(format!(
        "internal error of gearbow {}: {panic}; please report it with the system and the call that caused it",
        env!("CARGO_PKG_VERSION")
    ))
}

/// The result of `work`; a panic is a `GearbowError`.
pub fn caught<T>(work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| internal())
}

/// Issues an `AccuracyWarning` at the line of the user.
pub fn warn(py: Python<'_>, text: String) -> PyResult<()> {
    warn_as(py, &AccuracyWarning::type_object(py), text)
}

/// Issues a warning of the given class. It points to the line of the user that called the package.
fn warn_as(py: Python<'_>, class: &Bound<'_, PyAny>, text: String) -> PyResult<()> {
    let level = py.import("gearbow.errors")?.getattr("outside")?.call0()?.extract()?;
    PyErr::warn(py, class, &CString::new(text).unwrap_or_default(), level)
}

/// Issues a `SceneWarning` if a speed of the reference shaft, rad/s, is implausibly high for the gears.
pub fn warn_of_speed(py: Python<'_>, scene: &Scene, speed: f64) -> PyResult<()> {
    let Some(text) = scene.pitch_line_warning(speed) else { return Ok(()) };
    warn_as(py, &SceneWarning::type_object(py), text)
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

impl From<EquilibriumError> for PyErr {
    fn from(error: EquilibriumError) -> Self {
        AnalysisError::from(error).into()
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
