//! Undamped critical speeds from an eigenvalue problem in the speed.

mod map;
mod speed_dependent;

use super::modes::{require, uses_bands};
use super::{AnalysisError, Dense, Interrupt};
use crate::modal::{
    self, CachedModel, CriticalProblem, EquationForces, ModeAtSpeed, Residual, Residuals, SpectralRange, Whirl,
};
use crate::model::Model;
use crate::scene::EntryPath;
pub use map::{CriticalPoint, critical_speed_map};

/// An undamped critical speed.
#[derive(Clone, Copy, Debug)]
pub struct Critical {
    /// Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Direction of whirl of the mode.
    pub whirl: Whirl,
    /// Residual of the undamped mode with the frequency `order`·Ω.
    pub residual: f64,
}

/// The speeds Ω nearest to zero, in ascending order of |Ω| and at most `count`, at which an undamped mode has the frequency
/// `order`·Ω > 0 (Nelson and McVaugh, J. Eng. Ind. 98, 1976, who use the whirl ratio instead). A negative order asks for negative
/// speeds.
///
/// Where bearings depend on the speed, each critical speed is found with the stiffness at that same speed, or at the frequency
/// `order`·Ω; a table that does not hold its end values has no critical speeds outside its range.
///
/// # Errors
/// [`AnalysisError`] if `order` is zero or not finite, a decomposition fails, or `interrupt` requests a stop.
pub fn critical_speeds(
    cached: &CachedModel,
    order: f64,
    count: usize,
    interrupt: &Interrupt,
) -> Result<Vec<Critical>, AnalysisError> {
    let sense = sense_of(order)?;
    cached
        .model
        .scene
        .refuse_turning_frame("undamped critical speeds; campbell() intersects modes with the lines of unbalance")?;
    if let Some(journal) =
        cached.model.nonlinear_bearings.iter().find(|bearing| bearing.is_journal() || bearing.is_squeeze())
    {
        let message =
            "the damping of an oil film is too large for undamped critical speeds; use campbell() or synchronous()";
        return Err(EntryPath::entry("bearings", journal.number).error(message).into());
    }
    let lowest = cached.model.lowest_speed().unwrap_or(1.0) * sense;
    // Without damping, the internal damping of a shaft has no circulatory forces either.
    let undamped = cached.model.has_internal_damping() && cached.model.bearings.is_empty();
    let at_speed = if undamped { cached.at_speed(0.0)? } else { cached.with_operating_points_of(lowest)? };
    let cached = &*at_speed;
    if !cached.model.bearings.is_empty() {
        let mut found = speed_dependent::critical_speeds(cached, order, interrupt)?;
        found.truncate(count);
        return Ok(found);
    }
    named(&cached.model, cached.spectral_range(sense)?, &modes(cached, order, count)?, interrupt)
}

/// The sense of rotation in which undamped modes have the frequency `order`·Ω > 0.
fn sense_of(order: f64) -> Result<f64, AnalysisError> {
    let place = EntryPath::root("order");
    place.finite(order)?;
    if order == 0.0 {
        return Err(place.error("must not be zero").into());
    }
    Ok(order.signum())
}

/// The `count` lowest critical speeds of a model whose coefficients do not depend on the speed, with their modes.
fn modes(cached: &CachedModel, order: f64, count: usize) -> Result<Vec<ModeAtSpeed>, AnalysisError> {
    let mut found = None;
    if uses_bands(&cached.model, count) {
        found = modal::lowest_critical(&cached.model, order, count)?;
    }
    let mut found = match found {
        Some(found) => found,
        None => {
            Dense::Undamped.require(&cached.model)?;
            CriticalProblem::new(cached, order)?.critical(order)?
        }
    };
    found.truncate(count);
    Ok(found)
}

/// Memory that [`critical_speeds`] needs at first.
pub fn memory_of_critical_speeds(model: &Model, count: usize) -> Dense {
    if model.bearings.is_empty() && uses_bands(model, count) { Dense::Bands } else { Dense::Undamped }
}

/// Critical speeds with whirl and residual of their modes. The range of the undamped frequencies may be that of a similar model.
fn named(
    model: &Model,
    range: &SpectralRange,
    modes: &[ModeAtSpeed],
    interrupt: &Interrupt,
) -> Result<Vec<Critical>, AnalysisError> {
    let Some(first) = modes.first() else { return Ok(Vec::new()) };
    let mut residuals = Residuals::new(model, range, first.speed, EquationForces::Undamped);
    let mut critical = Vec::with_capacity(modes.len());
    for mode in modes {
        interrupt.check()?;
        let (found, residual) = named_with(&mut residuals, model, mode)?;
        require(residual, || format!("the mode at the critical speed {} rad/s", mode.speed))?;
        critical.push(found);
    }
    Ok(critical)
}

/// A critical speed with whirl and residual of its mode.
fn named_with(
    residuals: &mut Residuals<'_>,
    model: &Model,
    mode: &ModeAtSpeed,
) -> Result<(Critical, Residual), AnalysisError> {
    let ModeAtSpeed { speed, eigenvalue, shape } = mode;
    residuals.speed = *speed;
    let residual = residuals.of(*eigenvalue, shape)?;
    let whirl = modal::whirl(model, *speed, *eigenvalue, shape);
    Ok((Critical { speed: *speed, whirl, residual: residual.value }, residual))
}
