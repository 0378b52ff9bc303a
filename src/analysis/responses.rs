//! Synchronous responses at several speeds, which share what modal damping needs.

use std::cell::OnceCell;

use nalgebra::{Complex, DMatrix};

use super::synchronous::{MAX_DENSE, SourceResponse, rotating_force, synchronous_of};
use super::{AnalysisError, Dense, ExcitationPart};
use crate::linalg::DecompositionError;
use crate::modal::{AtSpeed, CachedModel, RotatingResponse};
use crate::model::Model;

/// Smallest number of degrees of freedom for which band matrices are faster than dense ones with modal damping.
pub(super) const MIN_BANDS: usize = 100;

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
    Ok(Responses::new(cached).all(speed, part)?.amplitudes)
}

/// Synchronous response at one speed.
#[derive(Clone, Debug)]
pub struct Response {
    /// Phasors a in m and rad: one column for each source shaft, in the coordinate order of the core.
    pub amplitudes: DMatrix<Complex<f64>>,
    /// Largest relative residual of the equations over the source shafts.
    pub residual: f64,
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

    /// The response at `speed`, rad/s.
    ///
    /// # Errors
    /// [`AnalysisError`] if a response has no accurate solution.
    pub fn all(&self, speed: f64, part: ExcitationPart) -> Result<Response, AnalysisError> {
        let sources: Vec<usize> = (0..self.cached.model.shafts.len()).collect();
        let found = self.at(speed, &sources, part)?;
        let residual = found.iter().map(|response| response.residual).fold(0.0, f64::max);
        let columns: Vec<_> = found.into_iter().map(|response| response.phasors).collect();
        Ok(Response { amplitudes: DMatrix::from_columns(&columns), residual })
    }

    /// The same for some source shafts.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub fn at(
        &self,
        speed: f64,
        sources: &[usize],
        part: ExcitationPart,
    ) -> Result<Vec<SourceResponse>, AnalysisError> {
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
    fn one(&self, speed: f64, source: usize, part: ExcitationPart) -> Result<SourceResponse, AnalysisError> {
        let model = &self.cached.model;
        let spin = model.shafts[source].ratio * speed;
        // At standstill modal damping has no effect.
        if model.scene.modal_damping == 0.0 || model.len() < MIN_BANDS || spin == 0.0 {
            return synchronous_of(self.cached, speed, speed, source, part);
        }
        let Some(force) = rotating_force(model, spin, source, part) else {
            return Ok(SourceResponse::zero(model));
        };
        let damped = self.damped[model.rotation(speed) as usize]
            .get_or_init(|| RotatingResponse::new(model, speed, self.cached.spectral_range(speed)?));
        match damped.as_ref().map_err(|error| *error)?.solve([speed, spin], &force) {
            Some(found) => {
                let response = SourceResponse { phasors: found.phasors, residual: found.residual };
                response.checked(speed, &model.scene.shafts[source].name)
            }
            None if model.len() <= MAX_DENSE => synchronous_of(self.cached, speed, speed, source, part),
            None => Err(AnalysisError::Convergence(format!(
                "the synchronous response at {speed} rad/s with modal damping has no accurate solution; change the speed or the modal damping, or use at most {MAX_DENSE} degrees of freedom, for which dense matrices are used"
            ))),
        }
    }
}
