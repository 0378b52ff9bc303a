//! Undamped critical speeds, straight from the eigenproblem.

use super::{AnalysisError, Interrupt};
use crate::modal::{self, CachedModel, Quadratic, Whirl};
use crate::scene::EntryPath;

/// An undamped critical speed.
#[derive(Clone, Copy, Debug)]
pub struct Critical {
    /// Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// How the train whirls there.
    pub whirl: Whirl,
}

/// Speeds Ω, ascending, at which an undamped mode has the frequency `excitation`·Ω (Nelson and McVaugh, J. Eng. Ind. 98,
/// 1976, who write it over the whirl ratio).
///
/// # Errors
/// [`AnalysisError`] if `excitation` is not positive, a decomposition fails, or `interrupt` asks to stop.
pub fn critical_speeds(
    cached: &CachedModel,
    excitation: f64,
    interrupt: &Interrupt,
) -> Result<Vec<Critical>, AnalysisError> {
    EntryPath::root("excitation").positive(excitation)?;
    let found = Quadratic::new(cached, 1.0)?.critical(excitation)?;
    let named = |met: modal::OrderIntersection| {
        interrupt.check()?;
        let whirl = modal::whirl(cached, met.speed, met.eigenvalue, &met.coordinates)?;
        Ok(Critical { speed: met.speed, whirl })
    };
    found.into_iter().map(named).collect()
}
