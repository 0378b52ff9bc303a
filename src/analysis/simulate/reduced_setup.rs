//! The set-up of a run with the reduction that its options ask for: a known one, that of the system of which the model is a
//! variation, or one that the run finds.

use super::initial::Start;
use super::known_reduction::{Reduction, ReductionKey};
use super::modal_setup::ModalSetup;
use super::options::is_large;
use super::reduction::{find, is_short};
use super::run_cache::RunCache;
use super::variation::{adopt, reductions_of_base};
use super::{RecordPlan, Run};
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
    let (known, key) = (run.cached.run_results::<RunCache>(), ReductionKey::new(options, plan));
    if let Some(known) = key.as_ref().and_then(|key| known.reductions.get(key)) {
        let (unreduced, reduced) = run.with_reduction(&known, motion, start, plan)?;
        return Ok((reduced.unwrap_or(unreduced), known.reduction));
    }
    let of_base = match &key {
        Some(key) => reductions_of_base(run, key, plan, observer)?,
        None => Vec::new(),
    };
    let found = match adopt(run, &motion, start, plan, of_base, observer)? {
        Some(adopted) => Some(adopted),
        None => find(run, &motion, start, plan, &[1.0], observer)?.pop(),
    };
    let Some((setup, reduction)) = found else {
        return Ok((run.complete(motion, start, plan, None)?, None));
    };
    let measured = reduction.reduction;
    if let Some(key) = key {
        known.reductions.insert(key, reduction);
    }
    Ok((setup, measured))
}
