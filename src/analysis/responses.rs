//! Synchronous responses at several speeds.

use nalgebra::{Complex, DMatrix};

use super::modes::is_banded;
use super::synchronous::{SourceResponse, synchronous_of};
use super::{AnalysisError, Dense, ExcitationPart, Interrupt, Threads};
use crate::modal::{CachedModel, Highest};
use crate::model::Model;

/// Memory that synchronous responses need.
pub fn memory_of_responses(model: &Model) -> Dense {
    if !model.scene.modal_damping.is_zero() && !is_banded(model) { Dense::Undamped } else { Dense::Bands }
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
    Ok(Responses::new(cached, &[speed]).all(speed, part)?.amplitudes)
}

/// Synchronous response at one speed.
#[derive(Clone, Debug)]
pub struct Response {
    /// Phasors a in m and rad: one column for each source shaft, in the coordinate order of the core.
    pub amplitudes: DMatrix<Complex<f64>>,
    /// Largest relative residual of the equations over the source shafts.
    pub residual: f64,
}

/// Synchronous responses of a model at some speeds. The meshes are linearised at rest.
pub struct Responses<'a> {
    cached: &'a CachedModel,
    /// Highest spin of a shaft at these speeds.
    highest: Highest,
}

impl<'a> Responses<'a> {
    /// The responses of a model at `speeds` of the reference shaft, rad/s; nothing is computed yet.
    pub fn new(cached: &'a CachedModel, speeds: &[f64]) -> Self {
        let fastest = speeds.iter().map(|speed| speed.abs()).fold(0.0, f64::max);
        Self { cached, highest: Highest::Frequency(cached.model.max_speed_ratio() * fastest) }
    }

    /// The response at `speed`, rad/s.
    ///
    /// # Errors
    /// [`AnalysisError`] if a response has no accurate solution.
    pub fn all(&self, speed: f64, part: ExcitationPart) -> Result<Response, AnalysisError> {
        self.all_of(self.cached, speed, part)
    }

    /// The responses at `speeds`, rad/s: `keep` takes each speed, the model at this speed and the response, in the order of the
    /// speeds.
    ///
    /// # Errors
    /// As [`Self::all`], or if `interrupt` requests a stop.
    pub fn each(
        &self,
        speeds: &[f64],
        part: ExcitationPart,
        threads: &Threads,
        interrupt: &Interrupt,
        mut keep: impl FnMut(f64, &Model, &Response),
    ) -> Result<(), AnalysisError> {
        threads.in_order(
            speeds,
            |speed| Ok(self.cached.at_speed(*speed)?),
            |speed, at_speed| {
                interrupt.check()?;
                self.all_of(at_speed, *speed, part)
            },
            |speed, at_speed, response| keep(*speed, &at_speed.model, &response),
        )
    }

    /// The response at `speed`, rad/s, of `cached`: the model, or that at this speed.
    fn all_of(&self, cached: &CachedModel, speed: f64, part: ExcitationPart) -> Result<Response, AnalysisError> {
        let sources = 0..cached.model.shafts.len();
        let one = |source| synchronous_of(cached, speed, speed, source, part, self.highest);
        let found = sources.map(one).collect::<Result<Vec<_>, _>>()?;
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
        let one = |source: &usize| synchronous_of(self.cached, speed, speed, *source, part, self.highest);
        sources.iter().map(one).collect()
    }
}
