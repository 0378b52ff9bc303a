//! Error estimate of a step, from the defect of the polynomial of its loads.

use super::context::StepContext;
use super::stages::{Stages, StepPoint};

/// Fraction of an unresolved load that counts as error: the mean of |π| is below it.
const UNRESOLVED_FRACTION: f64 = 0.5;

/// The defect of the last step.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct ErrorEstimator {
    /// Defect d of the loads that depend on the motion, N.
    defect: Vec<f64>,
    /// Change d′ of the defect over the step, N.
    defect_change: Vec<f64>,
    /// ‖b d′‖/‖b d‖.
    defect_ratio: f64,
    /// Energy norm that an unresolved load adds to a state per second.
    unresolved_error: f64,
}

impl ErrorEstimator {
    /// Allocates the estimator of a number of loads that depend on the motion.
    pub fn new(coupled_loads: usize) -> Self {
        Self {
            defect: vec![0.0; coupled_loads],
            defect_change: vec![0.0; coupled_loads],
            defect_ratio: 0.0,
            unresolved_error: 0.0,
        }
    }

    /// Energy norm of the error of the last step, which led from the first point to the second. The defects at both
    /// points give the size of the defect within the step, and their difference tells how fast it changes.
    pub fn estimate(
        &mut self,
        context: &StepContext<'_>,
        level: usize,
        begin_point: &StepPoint,
        end_point: &StepPoint,
        stages: &Stages,
    ) -> f64 {
        if self.defect.is_empty() {
            return 0.0;
        }
        let (load_count, rule) = (context.loads.load_count(), &context.cache.rule);
        // π is odd or even about the middle of the step.
        let parity = if rule.stages() % 2 == 0 { 1.0 } else { -1.0 };
        let (begin, end) = (&mut self.defect, &mut self.defect_change);
        let coupled = begin.len();
        begin.copy_from_slice(&begin_point.load[..coupled]);
        end.copy_from_slice(&end_point.load[..coupled]);
        let [at_begin, at_end] = &rule.at_ends;
        for (load, (at_begin, at_end)) in stages.loads.chunks_exact(load_count).zip(at_begin.iter().zip(at_end)) {
            for ((begin, end), load) in begin.iter_mut().zip(end.iter_mut()).zip(load) {
                *begin -= at_begin * load;
                *end -= at_end * load;
            }
        }
        for (begin, end) in begin.iter_mut().zip(end) {
            (*begin, *end) = ((*end + parity * *begin) / 2.0, *end - parity * *begin);
        }
        let (size, change) = (context.load_norm(&self.defect), context.load_norm(&self.defect_change));
        self.defect_ratio = if change > 0.0 { change / size } else { 0.0 };
        self.unresolved_error = UNRESOLVED_FRACTION * size.max(change / 2.0);
        self.predicted_error(context, level, 1.0)
    }

    /// Predicted error of a step of twice the length of the last one, which has this level.
    pub fn error_of_doubled_step(&self, context: &StepContext<'_>, level: usize) -> f64 {
        self.predicted_error(context, level - 1, 2.0)
    }

    /// Predicted error of a step of this level, which is `ratio` times as long as the last one.
    ///
    /// Slow modes hardly respond to the defect of a resolved load, because π is orthogonal to all polynomials of degree
    /// below s. A load that changes within the step, as at a kink, contributes with its full size.
    fn predicted_error(&self, context: &StepContext<'_>, level: usize, ratio: f64) -> f64 {
        let (step, stages) = (context.step(level), context.stages() as i32);
        let unresolved = (ratio * self.defect_ratio).min(1.0).powi(stages);
        let resolved_error = context.cache.propagator(level).error(context.arch, &self.defect);
        (resolved_error + step * unresolved * self.unresolved_error) * ratio.powi(stages)
    }

    /// Energy norm that the difference between loads and interpolated loads adds to a state per second.
    pub fn defect_of(&mut self, context: &StepContext<'_>, loads: &[f64], interpolated: &[f64]) -> f64 {
        for ((defect, load), polynomial) in self.defect_change.iter_mut().zip(loads).zip(interpolated) {
            *defect = *load - *polynomial;
        }
        UNRESOLVED_FRACTION * context.load_norm(&self.defect_change)
    }
}
