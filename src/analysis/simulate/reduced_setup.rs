//! The set-up of a run with the modes that its options ask for: known ones, or those that the run finds.

use std::sync::PoisonError;

use super::initial::Start;
use super::modal_setup::ModalSetup;
use super::reduction::{KnownReduction, Reducer, Reduction, ReductionKey, keeps_all};
use super::{RecordPlan, Run, initial, motion, of_run};
use crate::analysis::{AnalysisError, Spectrum};
use crate::integrate::Observer;
use crate::motion::EquationOfMotion;

/// Sets up a run with the modes that the options ask for.
pub(super) fn set_up<'m>(
    run: &Run<'m>,
    motion: EquationOfMotion<'m>,
    start: &Start,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<(ModalSetup<'m>, Option<Reduction>), AnalysisError> {
    if let Some(modes) = &run.options.kept_modes {
        let fastest = run.options.fastest();
        let projected = run.cached.at_speed(fastest)?.in_modes(modes, fastest)?;
        return Ok((run.complete(motion, start, plan, Some(&projected))?, None));
    }
    if keeps_all(run, plan, start) {
        return Ok((run.complete(motion, start, plan, None)?, None));
    }
    // A run that continues another one keeps the modes of that run.
    let Some(key) = ReductionKey::new(run, plan) else {
        return match (Reducer { run, motion: &motion, start, plan }).find(None, observer)? {
            Some((setup, known)) => Ok((setup, Some(known.reduction))),
            None => Ok((run.complete(motion, start, plan, None)?, None)),
        };
    };
    let known = reduction_of(run, key, observer)?;
    let subspace = known.as_ref().map(|known| &*known.projected);
    Ok((run.complete(motion, start, plan, subspace)?, known.map(|known| known.reduction)))
}

/// The modes that the options of a run ask for, with their errors; none if it keeps all modes.
pub(super) fn kept_modes(
    run: &Run<'_>,
    start: &Start,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    match ReductionKey::new(run, plan) {
        Some(key) if !keeps_all(run, plan, start) => reduction_of(run, key, observer),
        _ => Ok(None),
    }
}

/// The reduction of a key: a known one, or one that is found; none if the run keeps all modes.
fn reduction_of(
    run: &Run<'_>,
    key: ReductionKey,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    let known = run.cached.known;
    if let Some(known) = known.reductions.get(&key) {
        return Ok(known);
    }
    let base = if key.takes_base { reduction_of_base(run, &key, observer)? } else { None };
    let found = find(run, &key, base.as_ref(), observer)?;
    known.reductions.insert(key, found.clone());
    Ok(found)
}

/// Finds the reduction of a key.
fn find(
    run: &Run<'_>,
    key: &ReductionKey,
    base: Option<&KnownReduction>,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    let ReductionKey { options, plan, .. } = key;
    let start = initial::start(run.cached, options, run.spectrum, &mut |_| true)?;
    let motion = motion(run.cached, options, plan, &start)?;
    let run = Run { options, floor: start.floor, ..*run };
    let found = Reducer { run: &run, motion: &motion, start: &start, plan }.find(base, observer)?;
    Ok(found.map(|(_, known)| known))
}

/// The reduction of the same run of the system of which the model is a variation: it says with which modes the comparison of
/// the variation begins. It depends on the system and the options alone, so that the runs of variations are the same in any
/// order and with any number of threads. None if the model is no variation, or the run of the system fails or keeps all modes.
fn reduction_of_base(
    run: &Run<'_>,
    key: &ReductionKey,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    let Some(Ok(base)) = run.base.map(|base| of_run(base, &key.options)) else {
        return Ok(None);
    };
    // One variation finds the reduction, while the others wait. A panic leaves no partial result.
    let shared = base.known.shared_reductions.lock().unwrap_or_else(PoisonError::into_inner);
    let mut of_system = || {
        let spectrum = Spectrum::new(&base, key.options.fastest())?;
        find(&Run { cached: &base, base: None, spectrum: &spectrum, ..*run }, key, None, observer)
    };
    shared.get_or_try(key.clone(), || match of_system() {
        Err(AnalysisError::Interrupted) => Err(AnalysisError::Interrupted),
        found => Ok(found.unwrap_or_default()),
    })
}
