//! Speeds at which the damping of a tracked mode changes its sign.

use nalgebra::Complex;

use super::super::AnalysisError;
use super::super::modes::require;
use super::Tracker;
use super::state::State;
use crate::modal::{Whirl, is_growing};
use crate::numerics::{Sample, root};

/// A speed at which a mode becomes unstable or stable.
#[derive(Clone, Copy, Debug)]
pub struct Threshold {
    /// Index of the mode.
    pub mode: usize,
    /// Speed Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Eigenvalue λ of the mode, rad/s.
    pub eigenvalue: Complex<f64>,
    /// Direction of whirl of the mode.
    pub whirl: Whirl,
    /// Whether the mode is unstable at higher speeds; otherwise at lower speeds.
    pub is_unstable_above: bool,
    /// The larger one of |Re λ|/|λ| and the residual of the mode.
    pub residual: f64,
}

impl Tracker<'_> {
    /// Stores the speed between two speeds at which a mode begins or ceases to grow. Growth that round-off may cause does
    /// not count: where the mode at the end that does not grow is undamped up to round-off, this end is the threshold.
    pub(super) fn add_threshold(&mut self, mode: usize, ends: [(f64, &State); 2]) -> Result<(), AnalysisError> {
        let grows = ends.map(|(speed, state)| is_growing(state.eigenvalue, speed));
        if grows[0] == grows[1] {
            return Ok(());
        }
        let growth = ends.map(|(_, state)| state.eigenvalue.re);
        let (speed, state) = if (growth[0] > 0.0) == (growth[1] > 0.0) {
            let (speed, state) = ends[usize::from(grows[0])];
            (speed, state.clone())
        } else {
            self.root_of(ends, |_, state| state.eigenvalue.re)?
        };
        let (eigenvalue, whirl) = (state.eigenvalue, state.whirl);
        let residual = state.residual.with(eigenvalue.re.abs() / eigenvalue.norm());
        require(residual, || format!("the stability threshold of mode {} at {speed} rad/s", mode + 1))?;
        let residual = residual.value;
        self.thresholds.push(Threshold { mode, speed, eigenvalue, whirl, is_unstable_above: grows[1], residual });
        Ok(())
    }

    /// The speed between two speeds at which a `value` (speed, mode) of a tracked mode is zero, and the mode there, by the
    /// method of Illinois.
    pub(super) fn root_of(
        &self,
        ends: [(f64, &State); 2],
        value: impl Fn(f64, &State) -> f64,
    ) -> Result<(f64, State), AnalysisError> {
        let values = ends.map(|(speed, state)| Sample { at: speed, value: value(speed, state) });
        let mode = |speed: f64| self.between(ends, speed);
        let speed = root(values, |speed| mode(speed).map(|state| value(speed, &state)))?;
        Ok((speed, mode(speed)?))
    }
}
