//! The reductions that the variations of a system share: those of the same run of the system itself.
//!
//! They depend on the system and the options alone, so that the runs of variations are the same in any order and with any
//! number of threads. Each variation checks them with its own loads.

use std::sync::PoisonError;

use super::initial::Start;
use super::known_reduction::{KnownReduction, Reduction, ReductionKey, excess, with_components};
use super::pilot::{Pilot, differences};
use super::run_cache::RunCache;
use super::{RecordPlan, Run, initial, motion, of_run, reduction};
use crate::analysis::{AnalysisError, Spectrum};
use crate::integrate::Observer;
use crate::motion::EquationOfMotion;

/// Shares of the permitted errors that the numbers of modes of a system may cause. With other loads the errors differ: a
/// variation whose errors exceed the permitted ones with the first number takes the second one.
const ERROR_SHARES: [f64; 2] = [0.5, 0.25];

/// The reductions of the run of a key of the system of which the model is a variation. None if the model is no variation, or
/// the run of the system fails or is not reduced.
pub(super) fn reductions_of_base(
    run: &Run<'_>,
    key: &ReductionKey,
    observer: &mut impl Observer,
) -> Result<Vec<KnownReduction>, AnalysisError> {
    let ReductionKey { options, plan, .. } = key;
    let Some(Ok(base)) = run.base.map(|base| of_run(base, options)) else {
        return Ok(Vec::new());
    };
    let known = base.run_results::<RunCache>();
    let mut find = || {
        let spectrum = Spectrum::new(&base, options.fastest())?;
        let start = initial::start(&base, options, &spectrum, &mut |_| true)?;
        let motion = motion(&base, options, plan, &start)?;
        let run = Run { cached: &base, base: None, options, spectrum: &spectrum, floor: start.floor, end: run.end };
        let found = reduction::find(&run, &motion, &start, plan, &ERROR_SHARES, observer)?;
        Ok(found.into_iter().map(|(_, reduction)| reduction).collect())
    };
    // One variation finds the reductions, while the others wait. A panic leaves no partial result.
    let shared = known.shared_reductions.lock().unwrap_or_else(PoisonError::into_inner);
    shared.get_or_try(key.clone(), || match find() {
        Err(AnalysisError::Interrupted) => Err(AnalysisError::Interrupted),
        found => Ok(found.unwrap_or_default()),
    })
}

/// The first reduction of the system of a variation that keeps the permitted errors; `None` if none does. The errors are
/// those of the system, or those of a part of this run if they are larger.
pub(super) fn adopt<'m>(
    run: &Run<'m>,
    motion: &EquationOfMotion<'m>,
    start: &Start,
    plan: &RecordPlan,
    of_base: Vec<KnownReduction>,
    observer: &mut impl Observer,
) -> Result<Option<KnownReduction>, AnalysisError> {
    let pilot = Pilot::check(run, start);
    let mut exact = None;
    for known in of_base {
        let (unreduced, setup) = match run.with_reduction(&known, motion.clone(), start, plan)? {
            (unreduced, Some(reduced)) => (unreduced, reduced),
            (_, None) => return Ok(Some(known)),
        };
        // All reductions of a system have the same unreduced motion.
        let signals = match exact.take() {
            Some(signals) => signals,
            None => pilot.signals(run, &unreduced, plan, observer)?,
        };
        let found = differences(&pilot.signals(run, &setup, plan, observer)?, &signals);
        let own = with_components(found, known.components);
        if run.options.reduction.is_none_or(|target| excess(own, known.components, target) <= 1.0) {
            let of_system = known.reduction.map_or([0.0; 2], |reduction| reduction.errors);
            let errors = std::array::from_fn(|kind| own[kind].max(of_system[kind]));
            let reduction = Some(Reduction { modes: setup.linear.modes, errors });
            return Ok(Some(KnownReduction { reduction, ..known }));
        }
        exact = Some(signals);
    }
    Ok(None)
}
