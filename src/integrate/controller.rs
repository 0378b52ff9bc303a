//! Step size: fixed, or by a PI controller (Gustafsson 1991; Hairer and Wanner II, IV.2).

/// How a method chooses its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepControl {
    /// The same step throughout; step i begins at i·h, so that no time drifts.
    Fixed(f64),
    /// As long as the error allows.
    Adaptive(Adaptive),
}

/// A PI controller of the error of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Error of a step, relative to the size of the deviation from equilibrium.
    pub rtol: f64,
    /// The smallest size that a tolerance is relative to.
    pub floor: f64,
    /// The longest step, s: error control alone does not keep a method stable on undamped stiffness.
    pub longest: f64,
}

/// Margin below the step that would just meet the tolerance.
const SAFETY: f64 = 0.9;
/// A step grows by no more than this.
const GROWTH: f64 = 5.0;
/// A step shrinks by no more than this.
const SHRINKAGE: f64 = 0.2;
/// A step shorter than this part of the longest means that there is nothing to converge to.
pub(super) const SHORTEST: f64 = 1e-9;

impl Adaptive {
    /// Step size factor after an accepted step of scaled error `error`, the accepted one before having `previous`.
    pub fn grow(&self, order: u32, error: f64, previous: f64) -> f64 {
        let order = f64::from(order);
        let factor = SAFETY * error.max(1e-10).powf(-0.7 / order) * previous.max(1e-4).powf(0.4 / order);
        factor.clamp(SHRINKAGE, GROWTH)
    }

    /// Step size factor after a rejected step of scaled error `error`.
    pub fn shrink(&self, order: u32, error: f64) -> f64 {
        (SAFETY * error.powf(-1.0 / f64::from(order))).clamp(SHRINKAGE, SAFETY)
    }
}
