//! The set-up of a run with the reduction that its options ask for: a known one, that of the system of which the model is a
//! variation, or one that the run finds.

use super::initial::Start;
use super::known_reduction::{KnownReduction, Reduction, ReductionKey};
use super::modal_setup::ModalSetup;
use super::options::is_large;
use super::reduction::{find, is_short};
use super::run_cache::RunCache;
use super::variation::{adopt, reductions_of_base};
use super::{RecordPlan, Run, initial, motion};
use crate::analysis::AnalysisError;
use crate::integrate::Observer;
use crate::motion::EquationOfMotion;

/// Sets up a run, and reduces its linear motion as the options ask.
pub(super) fn set_up<'m>(
    run: &Run<'m>,
    motion: EquationOfMotion<'m>,
    start: &Start,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<(ModalSetup<'m>, Option<Reduction>), AnalysisError> {
    let (options, model) = (run.options, &run.cached.model);
    let keeps_all = match (options.modes, options.reduction) {
        (Some(count), _) => count >= model.len(),
        (None, Some(_)) => plan.energy || !is_large(model) && is_short(run, start, &motion),
        (None, None) => true,
    };
    if keeps_all {
        return Ok((run.complete(motion, start, plan, None)?, None));
    }
    // A run that continues another one keeps the modes of that run.
    let Some(key) = ReductionKey::new(run, plan) else {
        return match find(run, &motion, start, plan, &[1.0], observer)?.pop() {
            Some((setup, reduction)) => Ok((setup, reduction.reduction)),
            None => Ok((run.complete(motion, start, plan, None)?, None)),
        };
    };
    let Some(known) = reduction_of(run, key, observer)? else {
        return Ok((run.complete(motion, start, plan, None)?, None));
    };
    let (unreduced, reduced) = run.with_reduction(&known, motion, start, plan)?;
    Ok((reduced.unwrap_or(unreduced), known.reduction))
}

/// The reduction of a key: a known one, one of the system of which the model is a variation, or one that is found; none if the
/// modes are nearly parallel.
fn reduction_of(
    run: &Run<'_>,
    key: ReductionKey,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    let known = run.cached.run_results::<RunCache>();
    if let Some(known) = known.reductions.get(&key) {
        return Ok(Some(known));
    }
    let found = {
        let ReductionKey { options, plan, takes_base } = &key;
        let start = initial::start(run.cached, options, run.spectrum, &mut |_| true)?;
        let motion = motion(run.cached, options, plan, &start)?;
        let of_base = if *takes_base { reductions_of_base(run, &key, observer)? } else { Vec::new() };
        let run = Run { options, floor: start.floor, ..*run };
        match adopt(&run, &motion, &start, plan, of_base, observer)? {
            Some(adopted) => Some(adopted),
            None => find(&run, &motion, &start, plan, &[1.0], observer)?.pop().map(|(_, found)| found),
        }
    };
    if let Some(found) = &found {
        known.reductions.insert(key, found.clone());
    }
    Ok(found)
}
