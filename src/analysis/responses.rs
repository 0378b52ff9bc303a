//! Synchronous responses at several speeds, which share what modal damping needs.

use std::cell::OnceCell;

use nalgebra::{Complex, DMatrix, DVector};

use super::synchronous::{MAX_DENSE, rotating_force, synchronous_of};
use super::{AnalysisError, Dense, ExcitationPart};
use crate::linalg::DecompositionError;
use crate::modal::{AtSpeed, CachedModel, RotatingResponse};
use crate::model::Model;

/// Smallest number of degrees of freedom for which band matrices are faster than dense ones with modal damping.
const MIN_BANDS: usize = 100;

/// Memory that synchronous responses need.
pub fn memory_of_responses(model: &Model) -> Dense {
    if model.scene.modal_damping == 0.0 {
        Dense::Bands
    } else if model.len() < MIN_BANDS {
        Dense::Undamped
    } else {
        Dense::SquareRoot
    }
}

/// Phasors of the synchronous response at one speed, as [`Responses::all`].
///
/// # Errors
/// As [`Responses::all`].
pub fn synchronous(
    cached: &CachedModel,
    speed: f64,
    part: ExcitationPart,
) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    Responses::new(cached).all(speed, part)
}

/// Synchronous responses of a model. The meshes are linearised at rest.
pub struct Responses<'a> {
    cached: &'a CachedModel,
    /// The model with modal damping for each [`crate::model::Rotation`].
    damped: [OnceCell<Result<RotatingResponse<'a>, DecompositionError>>; 3],
}

impl<'a> Responses<'a> {
    /// The responses of a model; nothing is computed yet.
    pub fn new(cached: &'a CachedModel) -> Self {
        Self { cached, damped: Default::default() }
    }

    /// Phasors a at `speed`, rad/s, in m and rad: one column for each source shaft, in the coordinate order of the core.
    ///
    /// # Errors
    /// [`AnalysisError`] if a response has no accurate solution.
    pub fn all(&self, speed: f64, part: ExcitationPart) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
        let sources: Vec<usize> = (0..self.cached.model.shafts.len()).collect();
        Ok(DMatrix::from_columns(&self.at(speed, &sources, part)?))
    }

    /// The same for some source shafts: n entries for each.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub fn at(
        &self,
        speed: f64,
        sources: &[usize],
        part: ExcitationPart,
    ) -> Result<Vec<DVector<Complex<f64>>>, AnalysisError> {
        match self.cached.at_speed(speed)? {
            AtSpeed::Same(_) => sources.iter().map(|source| self.one(speed, *source, part)).collect(),
            // Bearings that depend on the speed change the undamped modes.
            AtSpeed::Specialised(model) => {
                let own = Responses::new(&model);
                sources.iter().map(|source| own.one(speed, *source, part)).collect()
            }
        }
    }

    /// The response to one source shaft of a model with the coefficients of `speed`, rad/s.
    fn one(&self, speed: f64, source: usize, part: ExcitationPart) -> Result<DVector<Complex<f64>>, AnalysisError> {
        let model = &self.cached.model;
        let spin = model.shafts[source].ratio * speed;
        // At standstill modal damping has no effect.
        if model.scene.modal_damping == 0.0 || model.len() < MIN_BANDS || spin == 0.0 {
            return synchronous_of(self.cached, speed, speed, source, part);
        }
        let Some(force) = rotating_force(model, spin, source, part) else {
            return Ok(DVector::zeros(model.len()));
        };
        let damped = self.damped[model.rotation(speed) as usize]
            .get_or_init(|| RotatingResponse::new(model, speed, self.cached.spectral_range(speed)?));
        match damped.as_ref().map_err(|error| *error)?.solve([speed, spin], &force) {
            Some((found, _)) => Ok(found),
            None if model.len() <= MAX_DENSE => synchronous_of(self.cached, speed, speed, source, part),
            None => Err(AnalysisError::Convergence(format!(
                "the synchronous response at {speed} rad/s with modal damping has no accurate solution; change the speed or the modal damping, or use at most {MAX_DENSE} degrees of freedom, for which dense matrices are used"
            ))),
        }
    }
}
