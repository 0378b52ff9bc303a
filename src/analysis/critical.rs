//! Undamped critical speeds from an eigenvalue problem in the speed.

mod speed_dependent;

use super::{AnalysisError, Interrupt};
use crate::modal::{self, CachedModel, Quadratic, Whirl};
use crate::scene::EntryPath;

/// An undamped critical speed.
#[derive(Clone, Copy, Debug)]
pub struct Critical {
    /// Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Direction of whirl of the mode.
    pub whirl: Whirl,
}

/// Speeds Ω, in ascending order, at which an undamped mode has the frequency `excitation`·Ω (Nelson and McVaugh, J. Eng.
/// Ind. 98, 1976, who use the whirl ratio instead).
///
/// Where bearings depend on the speed, each critical speed is found with the stiffness at that same speed; a table that
/// does not hold its end values has no critical speeds outside its range.
///
/// # Errors
/// [`AnalysisError`] if `excitation` is not positive, a decomposition fails, or `interrupt` requests a stop.
pub fn critical_speeds(
    cached: &CachedModel,
    excitation: f64,
    interrupt: &Interrupt,
) -> Result<Vec<Critical>, AnalysisError> {
    EntryPath::root("excitation").positive(excitation)?;
    if let Some(journal) = cached.model.journals.first() {
        let message =
            "the damping of an oil film is too large for undamped critical speeds; use campbell() or synchronous()";
        return Err(EntryPath::entry("bearings", journal.number).error(message).into());
    }
    if !cached.model.bearings.is_empty() {
        return speed_dependent::critical_speeds(cached, excitation, interrupt);
    }
    let found = Quadratic::new(cached, 1.0)?.critical(excitation)?;
    found.into_iter().map(|met| named(cached, met, interrupt)).collect()
}

/// A critical speed with the whirl of its mode.
fn named(
    cached: &CachedModel,
    met: modal::OrderIntersection,
    interrupt: &Interrupt,
) -> Result<Critical, AnalysisError> {
    interrupt.check()?;
    let whirl = modal::whirl(cached, met.speed, met.eigenvalue, &met.coordinates)?;
    Ok(Critical { speed: met.speed, whirl })
}
