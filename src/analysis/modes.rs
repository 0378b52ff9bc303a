//! The lowest modes: from sparse matrices for a few modes of a large model, otherwise from dense matrices.

use super::{AnalysisError, Dense};
use crate::modal::{self, CachedModel, Highest, MAX_DENSE, MIN_BANDED, Mode, ModeSelection, Residual};
use crate::model::Model;

/// Part of all modes up to which they are a few: sparse matrices are then faster, and the gaps between modes are wide.
const MAX_BAND_MODE_FRACTION: f64 = 0.15;

/// Number of modes that are computed beyond the wanted ones, of which some are motions of rigid bodies or overdamped.
pub(super) const FURTHER_MODES: usize = 5;

/// Whether sparse matrices are faster than dense ones for one response.
pub(super) fn is_banded(model: &Model) -> bool {
    model.len() >= MIN_BANDED
}

/// Whether sparse matrices are faster than dense ones for `count` modes.
pub(super) fn uses_bands(model: &Model, count: usize) -> bool {
    is_banded(model) && count as f64 <= MAX_BAND_MODE_FRACTION * model.len() as f64
}

/// The undamped modes that have modal damping if the `count` lowest modes are computed.
pub(super) fn highest_damped(model: &Model, count: usize) -> Highest {
    if uses_bands(model, count) { Highest::Mode(count) } else { Highest::Frequency(f64::INFINITY) }
}

/// Memory that the `count` lowest modes need at first.
pub fn memory_of_modes(model: &Model, count: usize) -> Dense {
    if uses_bands(model, count) { Dense::Bands } else { Dense::Damped }
}

/// The `count` lowest modes of a selection at `speed` of the reference shaft, rad/s, in ascending order of |λ|, of a model whose
/// coefficients do not depend on the frequency. A model with fewer vibrations gives fewer.
///
/// Among very many overdamped modes, as Rayleigh damping causes them, a few cannot be told apart from the others; they come
/// from dense matrices, which take minutes with 2000 degrees of freedom.
///
/// # Errors
/// [`AnalysisError`] if a decomposition fails, a bearing has no coefficients at the speed, dense matrices are needed and
/// are too large, or a mode does not satisfy the equations of motion.
pub(super) fn linear_modes(
    cached: &CachedModel,
    speed: f64,
    count: usize,
    selection: ModeSelection,
) -> Result<Vec<Mode>, AnalysisError> {
    let cached = cached.at_speed(speed)?;
    if uses_bands(&cached.model, count) {
        if let Some(modes) = modal::structured_modes(&cached, speed, count, selection)? {
            return accurate(modes, speed);
        }
        if cached.model.len() > MAX_DENSE {
            return Err(too_large(&cached.model, speed, count));
        }
        Dense::Damped.require(&cached.model)?;
    }
    accurate(modal::modes(&cached, speed, count, selection)?, speed)
}

/// The modes, if all of them satisfy the equations of motion at `speed`, rad/s.
pub(super) fn accurate(modes: Vec<Mode>, speed: f64) -> Result<Vec<Mode>, AnalysisError> {
    for (index, mode) in modes.iter().enumerate() {
        let name = || format!("mode {} with {} Hz at {speed} rad/s", index + 1, mode.frequency_hz());
        require(mode.residual, name)?;
    }
    Ok(modes)
}

/// Refuses a mode called `name` that does not satisfy the equations of motion.
///
/// # Errors
/// [`AnalysisError`] with name, residual and limit.
pub(super) fn require(residual: Residual, name: impl Fn() -> String) -> Result<(), AnalysisError> {
    if residual.is_accurate() {
        return Ok(());
    }
    Err(AnalysisError::Convergence(format!(
        "{} does not satisfy the equations of motion: its residual is {:.3e}, above the limit {:.1e}; look for stiffnesses or masses of very different size, or change the speed",
        name(),
        residual.value,
        residual.limit
    )))
}

/// The error of a model that needs dense matrices for its lowest modes and is too large for them.
fn too_large(model: &Model, speed: f64, count: usize) -> AnalysisError {
    AnalysisError::Convergence(format!(
        "the {count} lowest modes at {speed} rad/s cannot be told apart from overdamped modes without dense matrices, which take too long with {} degrees of freedom; use at most {MAX_DENSE}, reduce the damping, or compute all modes without count",
        model.len()
    ))
}
