//! The modes of lowest frequency: from band matrices for a few modes of a large model, otherwise from dense matrices.

use super::own_frequency::{self, Outside};
use super::{AnalysisError, Dense};
use crate::modal::{self, CachedModel, Highest, MAX_DENSE, Mode, Residual};
use crate::model::Model;

/// Smallest number of degrees of freedom for which band matrices are faster than dense ones.
const MIN_BAND_COORDINATES: usize = 100;
/// Part of all modes up to which they are a few: band matrices are then faster, and the gaps between modes are wide.
const MAX_BAND_MODE_FRACTION: f64 = 0.15;

/// Number of modes that are computed beyond the wanted ones, of which some are motions of rigid bodies or overdamped.
pub(super) const FURTHER_MODES: usize = 5;

/// Whether band matrices are faster than dense ones for one response.
pub(super) fn is_banded(model: &Model) -> bool {
    model.len() >= MIN_BAND_COORDINATES
}

/// Whether band matrices are faster than dense ones for `count` modes.
pub(super) fn uses_bands(model: &Model, count: usize) -> bool {
    is_banded(model) && count as f64 <= MAX_BAND_MODE_FRACTION * model.len() as f64
}

/// The undamped modes that have modal damping if the `count` lowest modes are computed.
pub(super) fn highest_damped(model: &Model, count: usize) -> Highest {
    if uses_bands(model, count) { Highest::Mode(count) } else { Highest::Frequency(f64::INFINITY) }
}

/// Memory that [`lowest_modes`] needs at first.
pub fn memory_of_modes(model: &Model, count: usize) -> Dense {
    if uses_bands(model, count) { Dense::Bands } else { Dense::Damped }
}

/// The `count` modes of lowest frequency at `speed` of the reference shaft, rad/s, in ascending order.
///
/// Among very many overdamped modes, as Rayleigh damping causes them, a few cannot be told apart from the others; they come
/// from dense matrices, which take minutes with 2000 degrees of freedom. Up to this size, overdamped modes with a large |λ| have
/// the modal damping of all undamped modes, which changes them.
///
/// # Errors
/// [`AnalysisError`] if a decomposition fails, a bearing has no coefficients at the speed, dense matrices are needed and
/// are too large, or a mode does not satisfy the equations of motion.
pub fn lowest_modes(cached: &CachedModel, speed: f64, count: usize) -> Result<Vec<Mode>, AnalysisError> {
    if cached.model.depends_on_frequency() {
        return accurate(own_frequency::modes(cached, speed, count, Outside::Refuse)?, speed);
    }
    let modes = lowest_oscillating_modes(cached, speed, count)?;
    let cached = cached.at_speed(speed)?;
    if !uses_bands(&cached.model, count) || cached.model.len() > MAX_DENSE {
        return Ok(modes);
    }
    let reach = cached.modal_damping(speed, Highest::Mode(count))?.map_or(f64::INFINITY, |modal| modal.reach);
    if modes.iter().all(|mode| mode.eigenvalue.norm() <= reach) {
        return Ok(modes);
    }
    // Among overdamped modes alone, the damping of all modes could exchange one with the next.
    if modes.iter().any(|mode| mode.eigenvalue.im != 0.0) {
        Dense::Undamped.require(&cached.model)?;
        if let Some(modes) = modal::with_all_modal_damping(&cached, speed, modes, reach)? {
            return accurate(modes, speed);
        }
    }
    Dense::Damped.require(&cached.model)?;
    accurate(modal::modes(&cached, speed, count)?, speed)
}

/// The `count` vibrations of lowest frequency at `speed` of the reference shaft, rad/s, in ascending order. Motions of rigid
/// bodies, overdamped motions and motions that grow without oscillation are left out. A model with fewer vibrations gives fewer.
///
/// # Errors
/// As [`lowest_modes`].
pub fn lowest_vibrations(cached: &CachedModel, speed: f64, count: usize) -> Result<Vec<Mode>, AnalysisError> {
    // Internal damping makes all motions of high frequency overdamped; they have the lowest frequencies.
    let is_overdamped = cached.model.has_internal_damping();
    if is_overdamped && let Some(modes) = few_vibrations(cached, speed, count)? {
        return Ok(modes);
    }
    let len = cached.model.len();
    let mut wanted = if is_overdamped && len <= MAX_DENSE { usize::MAX } else { count.saturating_add(FURTHER_MODES) };
    let mut is_first = true;
    loop {
        memory_of_modes(&cached.model, wanted).require(&cached.model)?;
        let mut modes = lowest_modes(cached, speed, wanted)?;
        let is_all = modes.len() < wanted || wanted > 2 * len;
        modes.retain(|mode| modal::oscillates(mode.eigenvalue));
        modes.truncate(count);
        if modes.len() == count || is_all {
            return Ok(modes);
        }
        if is_first
            && !is_overdamped
            && let Some(modes) = few_vibrations(cached, speed, count)?
        {
            return Ok(modes);
        }
        is_first = false;
        // Half as many again where the model has far more overdamped motions than vibrations.
        wanted += (count - modes.len()).max(wanted / 2);
    }
}

/// The same from band matrices; `None` if dense matrices are faster, or the vibrations cannot be told apart from other motions.
///
/// # Errors
/// As [`lowest_modes`].
fn few_vibrations(cached: &CachedModel, speed: f64, count: usize) -> Result<Option<Vec<Mode>>, AnalysisError> {
    if cached.model.depends_on_frequency() || !uses_bands(&cached.model, count) {
        return Ok(None);
    }
    let at_speed = cached.at_speed(speed)?;
    let Some(modes) = modal::structured_vibrations(&at_speed, speed, count)? else {
        return Ok(None);
    };
    // As in `lowest_modes`, modes beyond the reach of the modal damping need that of all undamped modes.
    let reach = at_speed.modal_damping(speed, Highest::Mode(count))?.map_or(f64::INFINITY, |modal| modal.reach);
    let is_within = cached.model.len() > MAX_DENSE || modes.iter().all(|mode| mode.eigenvalue.norm() <= reach);
    if is_within && modes.len() == count { accurate(modes, speed).map(Some) } else { Ok(None) }
}

/// The same as [`lowest_modes`], where modal damping may act only on the undamped modes of low frequency also in overdamped modes.
/// Modes whose frequency lies outside the tables of bearings are left out.
///
/// # Errors
/// As [`lowest_modes`].
pub(super) fn lowest_oscillating_modes(
    cached: &CachedModel,
    speed: f64,
    count: usize,
) -> Result<Vec<Mode>, AnalysisError> {
    if cached.model.depends_on_frequency() {
        return accurate(own_frequency::modes(cached, speed, count, Outside::LeaveOut)?, speed);
    }
    linear_modes(cached, speed, count)
}

/// The same of a model whose coefficients do not depend on the frequency.
///
/// # Errors
/// As [`lowest_modes`].
pub(super) fn linear_modes(cached: &CachedModel, speed: f64, count: usize) -> Result<Vec<Mode>, AnalysisError> {
    let cached = cached.at_speed(speed)?;
    if uses_bands(&cached.model, count) {
        if let Some(modes) = modal::structured_modes(&cached, speed, count)? {
            return accurate(modes, speed);
        }
        if cached.model.len() > MAX_DENSE {
            return Err(too_large(&cached.model, speed, count));
        }
        Dense::Damped.require(&cached.model)?;
    }
    accurate(modal::modes(&cached, speed, count)?, speed)
}

/// The modes, if all of them satisfy the equations of motion at `speed`, rad/s.
fn accurate(modes: Vec<Mode>, speed: f64) -> Result<Vec<Mode>, AnalysisError> {
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
