//! The reduction that the variations of a system share: that of the same run of the system itself.
//!
//! It depends on the system and the options alone, so that the runs of variations are the same in any order and with any
//! number of threads. Each variation checks it with its own loads.

use std::sync::PoisonError;

use super::known_reduction::{KnownReduction, ReductionKey};
use super::run_cache::{RunCache, SETTINGS};
use super::{RecordPlan, Run, initial, motion, of_run, reduction};
use crate::analysis::{AnalysisError, Spectrum};
use crate::integrate::Observer;

/// Share of the permitted errors that the number of modes of a system may cause, so that it also suffices for other loads.
const ERROR_SHARE: f64 = 0.25;

/// The reduction of the run of a key of the system of which the model is a variation. `None` if the model is no variation,
/// or the run of the system fails or is not reduced.
pub(super) fn reduction_of_base(
    run: &Run<'_>,
    key: &ReductionKey,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    let Some(Ok(base)) = run.base.map(|base| of_run(base, run.options)) else {
        return Ok(None);
    };
    let known = base.run_results::<RunCache>();
    // One variation finds the reduction, while the others wait. A panic cannot leave the list half-written.
    let mut shared = known.shared_reductions.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, known)) = shared.iter().find(|(known, _)| known == key) {
        return Ok(known.clone());
    }
    let mut find = || {
        let spectrum = Spectrum::new(&base, run.options.fastest())?;
        let start = initial::start(&base, run.options, &spectrum, &mut |_| true)?;
        let motion = motion(&base, run.options, plan, &start)?;
        let floor = start.floor;
        let run = Run { cached: &base, base: None, spectrum: &spectrum, floor, error_share: ERROR_SHARE, ..*run };
        Ok(reduction::find(&run, &motion, &start, plan, observer)?.map(|(_, found)| found))
    };
    let found = match find() {
        Err(AnalysisError::Interrupted) => return Err(AnalysisError::Interrupted),
        found => found.unwrap_or_default(),
    };
    if shared.len() >= SETTINGS {
        shared.remove(0);
    }
    shared.push((key.clone(), found.clone()));
    Ok(found)
}
