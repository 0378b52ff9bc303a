//! Speeds on their way from and to Python: a number, or a dictionary of breaks and coefficients as in SciPy's `PPoly`.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::motion::{Profile, Speed};
use crate::scene::SceneError;

/// The speed that was given.
pub fn speed(given: &Bound<'_, PyAny>) -> PyResult<Speed> {
    if let Ok(speed) = given.extract::<f64>() {
        return Ok(Speed::Constant(speed));
    }
    let item = |key: &str| {
        let lacking = || SceneError::new("speed", format!("must be a number, or have \"{key}\" as a profile has"));
        given.get_item(key).map_err(|_| PyErr::from(lacking()))
    };
    Ok(Speed::Changing(profile(item("breaks")?.extract()?, &item("coefficients")?.extract::<Vec<Vec<f64>>>()?)?))
}

/// The profile whose `rows` hold the coefficients of τ³ to 1, one a piece; upper rows may be missing.
fn profile(breaks: Vec<f64>, rows: &[Vec<f64>]) -> Result<Profile, SceneError> {
    let pieces = breaks.len().saturating_sub(1);
    if rows.is_empty() || rows.len() > 4 || rows.iter().any(|row| row.len() != pieces) {
        let found: Vec<_> = rows.iter().map(Vec::len).collect();
        let message = format!("must have 1 to 4 rows of {pieces} coefficients, got rows of {found:?}");
        return Err(SceneError::new("speed", message));
    }
    let mut coefficients = vec![[0.0; 4]; pieces];
    for (power, row) in rows.iter().rev().enumerate() {
        for (piece, value) in coefficients.iter_mut().zip(row) {
            piece[power] = *value;
        }
    }
    Profile::new(breaks, &coefficients)
}

/// A speed as plain data.
pub fn plain<'py>(py: Python<'py>, speed: &Speed) -> PyResult<Bound<'py, PyAny>> {
    match speed {
        Speed::Constant(speed) => speed.into_bound_py_any(py),
        Speed::Changing(profile) => {
            let (breaks, pieces) = profile.parts();
            let pieces: Vec<_> = pieces.collect();
            let rows: Vec<Vec<f64>> =
                (0..4).rev().map(|power| pieces.iter().map(|piece| piece[power]).collect()).collect();
            let dict = PyDict::new(py);
            dict.set_item("breaks", breaks)?;
            dict.set_item("coefficients", rows)?;
            dict.into_bound_py_any(py)
        }
    }
}

/// Checks a profile.
#[pyfunction]
pub fn check_speed(breaks: Vec<f64>, coefficients: Vec<Vec<f64>>) -> PyResult<()> {
    profile(breaks, &coefficients)?;
    Ok(())
}
