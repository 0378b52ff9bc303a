//! Step length: fixed, or from a PI controller (Gustafsson 1991; Hairer and Wanner 1996, IV.2).

/// How a method chooses its step length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepControl {
    /// Constant step length h, s. Step i begins at i·h, so that time does not drift.
    Fixed(f64),
    /// The longest step that meets the tolerance.
    Adaptive(Adaptive),
}

/// PI control of the error of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Error of a step, relative to the energy norm of the deviation from equilibrium.
    pub rtol: f64,
    /// Smallest energy norm that the tolerance is relative to.
    pub floor: f64,
    /// Longest step, s. Error control alone does not keep a method stable on undamped stiffness.
    pub longest: f64,
}

/// Safety factor on the step that would just meet the tolerance.
const STEP_SAFETY: f64 = 0.9;
/// Largest ratio of two successive steps.
const MAX_GROWTH: f64 = 5.0;
/// Smallest ratio of two successive steps.
const MIN_SHRINKAGE: f64 = 0.2;
/// A step below this fraction of the longest one means that the motion diverges.
pub(super) const MIN_STEP_FRACTION: f64 = 1e-9;

impl Adaptive {
    /// Factor on the step length after an accepted step; `error` and `previous` are the errors of this step and of the
    /// accepted one before it, in multiples of the tolerance.
    pub fn grow(&self, order: u32, error: f64, previous: f64) -> f64 {
        let order = f64::from(order);
        let factor = STEP_SAFETY * error.max(1e-10).powf(-0.7 / order) * previous.max(1e-4).powf(0.4 / order);
        factor.clamp(MIN_SHRINKAGE, MAX_GROWTH)
    }

    /// Factor on the step length after a rejected step of this error, in multiples of the tolerance.
    pub fn shrink(&self, order: u32, error: f64) -> f64 {
        (STEP_SAFETY * error.powf(-1.0 / f64::from(order))).clamp(MIN_SHRINKAGE, STEP_SAFETY)
    }
}
