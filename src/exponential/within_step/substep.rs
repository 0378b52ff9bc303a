//! The motion within a step under the polynomials of its loads.

use super::load_polynomials::LoadPolynomials;
use super::substep_modes::SubstepModes;
use crate::exponential::step::Stepper;

/// Samples states within the last step.
#[derive(Clone, Debug)]
pub struct SubstepSampler {
    /// Number of the step that was sampled last.
    step: u64,
    polynomials: LoadPolynomials,
    modes: SubstepModes,
}

impl SubstepSampler {
    /// Allocates the sampler of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        Self {
            step: 0,
            polynomials: LoadPolynomials::new(stepper),
            modes: SubstepModes::new(&stepper.context.cache, stepper.loads().load_count()),
        }
    }

    /// The state `within` seconds after the beginning of the last step, which had the step level `level` and began at the
    /// state `z`.
    pub fn state_at<'a>(&'a mut self, stepper: &Stepper<'_>, level: usize, z: &'a [f64], within: f64) -> &'a [f64] {
        if self.step != stepper.steps {
            self.step = stepper.steps;
            self.polynomials.set(stepper);
            self.modes.begin(stepper, stepper.step_length(level), &self.polynomials);
        }
        self.modes.state_at(stepper.context.arch, stepper.step_length(level), z, within)
    }
}
