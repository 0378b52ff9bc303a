//! Reductions of earlier runs, so that the same run measures its error once.

use std::sync::Arc;

use super::{Initial, Options, RecordPlan, Run};
use crate::modal::Projected;

/// A reduction of the linear motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Number of modes that the run keeps.
    pub modes: usize,
    /// Estimated error of displacements and of mesh forces: RMS of the difference to all modes over RMS of the
    /// variation, at least 2 % of the mean, for the worst recorded signal.
    pub errors: [f64; 2],
}

/// What the reduction of a run reads beside its model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReductionKey {
    /// Options of the run, without output times.
    pub options: Options,
    /// The recorded quantities.
    pub plan: RecordPlan,
    /// Whether the run may take the reduction of the system of which its model is a variation.
    pub takes_base: bool,
}

impl ReductionKey {
    /// The key of a run that records `plan`; `None` for a run that continues another one, whose state decides on the modes
    /// too.
    pub fn new(run: &Run<'_>, plan: &RecordPlan) -> Option<Self> {
        let options = run.options;
        if options.checkpoint.is_some() || matches!(options.initial, Initial::Continue(_)) {
            return None;
        }
        let options = Options { times: Vec::new(), ..options.clone() };
        Some(Self { options, plan: plan.clone(), takes_base: run.base.is_some() })
    }
}

/// A reduction that a run with the same key found.
#[derive(Clone, Debug)]
pub(super) struct KnownReduction {
    /// The linear motion in the modes that the run keeps.
    pub projected: Arc<Projected>,
    /// L, whose multiple of the highest frequency that teeth excite limits the modes; none for a given number.
    pub limit: Option<f64>,
    pub reduction: Reduction,
}

/// Largest ratio of the errors to their target.
pub(super) fn excess(errors: [f64; 2], target: [f64; 2]) -> f64 {
    (errors[0] / target[0]).max(errors[1] / target[1])
}
