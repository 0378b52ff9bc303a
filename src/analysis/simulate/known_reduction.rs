//! Reductions of earlier runs, so that the same run measures its error once.

use std::sync::Arc;

use super::{Initial, Method, Options, RecordPlan};
use crate::mesh::Geometry;
use crate::modal::{ModalStateSpace, Projected};
use crate::motion::Speed;

/// A reduction of the linear motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Number of modes that the run keeps.
    pub modes: usize,
    /// Estimated error of displacements and of mesh forces: RMS of the difference to all modes over RMS of the
    /// variation, at least 2 % of the mean, for the worst recorded signal.
    pub errors: [f64; 2],
}

/// What the reduction of a run depends on beside its system.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReductionKey {
    speed: Speed,
    geometry: Geometry,
    method: Method,
    initial: Initial,
    /// Step and tolerance.
    steps: [Option<f64>; 2],
    stages: Option<usize>,
    modes: Option<usize>,
    reduction: Option<[f64; 2]>,
    /// Time at the start, and duration, s.
    span: [f64; 2],
    plan: RecordPlan,
}

impl ReductionKey {
    /// The key of a run; `None` for a run that continues another one, whose state decides on the modes too.
    pub fn new(options: &Options, plan: &RecordPlan) -> Option<Self> {
        if options.checkpoint.is_some() || matches!(options.initial, Initial::Continue(_)) {
            return None;
        }
        Some(Self {
            speed: options.speed.clone(),
            geometry: options.geometry,
            method: options.method,
            initial: options.initial.clone(),
            steps: [options.step, options.rtol],
            stages: options.stages,
            modes: options.modes,
            reduction: options.reduction,
            span: [options.start, options.duration],
            plan: plan.clone(),
        })
    }
}

/// A reduction that a run with the same key found.
#[derive(Clone, Debug)]
pub(super) struct KnownReduction {
    /// The linear motion of the complete model, or of the modes of its components.
    pub projected: Arc<Projected>,
    /// The reduced motion.
    pub linear: Arc<ModalStateSpace>,
    /// Errors of displacements and mesh forces from the modes of the components; `None` for the complete model.
    pub components: Option<[f64; 2]>,
    pub reduction: Option<Reduction>,
}

/// Errors of displacements and mesh forces of a reduction that differs by `found` from the motion in the modes of the
/// components. This difference and the error of these modes are independent, so that their squares add up.
pub(super) fn with_components(found: [f64; 2], components: Option<[f64; 2]>) -> [f64; 2] {
    let components = components.unwrap_or_default();
    std::array::from_fn(|kind| found[kind].hypot(components[kind]))
}

/// Largest ratio of the errors, with those from the modes of the components, to their target.
pub(super) fn excess(errors: [f64; 2], components: Option<[f64; 2]>, target: [f64; 2]) -> f64 {
    let components = components.unwrap_or_default();
    let ratio = |kind: usize| errors[kind].max(components[kind]) / target[kind];
    ratio(0).max(ratio(1))
}
