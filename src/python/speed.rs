//! A speed as plain Python data: a number, or a mapping with `breaks` and `coefficients` as in SciPy's `PPoly`.

use pyo3::prelude::*;
use pythonize::depythonize;
use serde::{Deserialize, Serialize};

use crate::motion::{Profile, Speed};
use crate::scene::SceneError;

/// A speed of the reference shaft, rad/s.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "must be a number, or a mapping with the lists \"breaks\" and \"coefficients\"")]
pub enum SpeedEntries {
    /// A constant speed, rad/s.
    Constant(f64),
    /// A piecewise cubic polynomial.
    Changing {
        /// Ends of the pieces, s; one more than pieces.
        breaks: Vec<f64>,
        /// Coefficients of τ³ to 1 in rows, one column a piece; leading rows may be missing.
        coefficients: Vec<Vec<f64>>,
    },
}

impl TryFrom<SpeedEntries> for Speed {
    type Error = SceneError;

    fn try_from(entries: SpeedEntries) -> Result<Self, SceneError> {
        match entries {
            SpeedEntries::Constant(speed) => Ok(Self::Constant(speed)),
            SpeedEntries::Changing { breaks, coefficients } => Ok(Self::Changing(profile(breaks, &coefficients)?)),
        }
    }
}

impl From<&Speed> for SpeedEntries {
    fn from(speed: &Speed) -> Self {
        match speed {
            Speed::Constant(speed) => Self::Constant(*speed),
            Speed::Changing(profile) => {
                let (breaks, pieces) = profile.breaks_and_polynomials();
                let pieces: Vec<_> = pieces.collect();
                let row = |power: usize| pieces.iter().map(|piece| piece[power]).collect();
                Self::Changing { breaks: breaks.to_vec(), coefficients: (0..4).rev().map(row).collect() }
            }
        }
    }
}

/// Reads a speed.
pub fn speed(given: &Bound<'_, PyAny>) -> PyResult<Speed> {
    let entries: SpeedEntries = depythonize(given).map_err(|error| SceneError::new("speed", error))?;
    Ok(entries.try_into()?)
}

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

/// Checks a profile.
#[pyfunction]
pub fn check_speed(breaks: Vec<f64>, coefficients: Vec<Vec<f64>>) -> PyResult<()> {
    profile(breaks, &coefficients)?;
    Ok(())
}
