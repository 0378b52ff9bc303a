//! Speeds at which the damping of a tracked mode changes its sign.

use nalgebra::Complex;

use super::super::AnalysisError;
use super::super::modes::require;
use super::Tracker;
use super::state::State;
use crate::modal::{Whirl, is_growing};
use crate::numerics::{EQUALITY_TOLERANCE, Sample, root};

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
    /// Whether the mode is unstable at speeds farther from zero; otherwise at those nearer to it.
    pub is_unstable_above: bool,
    /// The larger one of |Re λ|/|λ| and the residual of the mode; the latter where Re λ jumps.
    pub residual: f64,
}

impl Tracker<'_> {
    /// The speed between two speeds at which a mode begins or ceases to grow, if there is one. Growth that round-off may cause
    /// does not count: where the mode at the end that does not grow is undamped up to round-off, this end is the threshold.
    pub(super) fn threshold_between(
        &mut self,
        mode: usize,
        ends: [(f64, &State); 2],
    ) -> Result<Option<Threshold>, AnalysisError> {
        let grows = ends.map(|(speed, state)| is_growing(state.eigenvalue, speed));
        if grows[0] == grows[1] {
            return Ok(None);
        }
        let growth = ends.map(|(_, state)| state.eigenvalue.re);
        let mut is_jump = false;
        let (speed, state) = if (growth[0] > 0.0) == (growth[1] > 0.0) {
            let (speed, state) = ends[usize::from(grows[0])];
            (speed, state.clone())
        } else {
            let mut known = ends.map(|(speed, state)| (speed, state.clone())).to_vec();
            if self.cached.model.has_structural_damping_of_shafts() {
                // Structural damping of a shaft drives a motion that is slower than the shaft, and damps a faster one: Re λ may
                // have a jump where the mode is as fast as the shaft.
                known = self.around_sign_change(ends)?.to_vec();
                is_jump = known
                    .iter()
                    .all(|(_, state)| state.eigenvalue.re.abs() > state.residual.limit * state.eigenvalue.norm());
            }
            if is_jump {
                known[usize::from(grows[0])].clone()
            } else {
                self.root_of(&mut known, |_, state| state.eigenvalue.re)?
            }
        };
        let (eigenvalue, whirl) = (state.eigenvalue, state.whirl);
        let growth = eigenvalue.re.abs() / eigenvalue.norm();
        let residual = if is_jump { state.residual } else { state.residual.with(growth) };
        require(residual, || format!("the stability threshold of mode {} at {speed} rad/s", mode + 1))?;
        let residual = residual.value;
        Ok(Some(Threshold { mode, speed, eigenvalue, whirl, is_unstable_above: grows[1], residual }))
    }

    /// Two close speeds between which Re λ of a mode changes its sign, and the modes there.
    fn around_sign_change(&mut self, ends: [(f64, &State); 2]) -> Result<[(f64, State); 2], AnalysisError> {
        let [mut low, mut high] = ends.map(|(speed, state)| (speed, state.clone()));
        let is_positive = |state: &State| state.eigenvalue.re > 0.0;
        while (high.0 - low.0).abs() > EQUALITY_TOLERANCE * high.0.abs() {
            let middle = f64::midpoint(low.0, high.0);
            let state = self.between([(low.0, &low.1), (high.0, &high.1)], middle)?;
            if is_positive(&state) == is_positive(&high.1) {
                high = (middle, state);
            } else {
                low = (middle, state);
            }
        }
        Ok([low, high])
    }

    /// The speed at which a `value` (speed, mode) of a tracked mode is zero, and the mode there, by the method of Illinois. `known`
    /// are modes at speeds of ascending magnitude, with values of different signs at the first and the last one; those that the search
    /// finds are added.
    pub(super) fn root_of(
        &mut self,
        known: &mut Vec<(f64, State)>,
        value: impl Fn(f64, &State) -> f64,
    ) -> Result<(f64, State), AnalysisError> {
        let sign = |(speed, state): &(f64, State)| value(*speed, state) > 0.0;
        let change = known.windows(2).position(|pair| sign(&pair[0]) != sign(&pair[1])).unwrap_or_default();
        let ends = [&known[change], &known[change + 1]].map(|(speed, state)| (*speed, state.clone()));
        let ends = ends.each_ref().map(|(speed, state)| (*speed, state));
        let values = ends.map(|(speed, state)| Sample { at: speed, value: value(speed, state) });
        let mut found = Vec::new();
        let speed = root(values, |speed| -> Result<f64, AnalysisError> {
            let state = self.between(ends, speed)?;
            let value = value(speed, &state);
            found.push((speed, state));
            Ok(value)
        })?;
        let state = match found.iter().chain(known.iter()).find(|(at, _)| *at == speed) {
            Some((_, state)) => state.clone(),
            None => self.between(ends, speed)?,
        };
        known.extend(found);
        known.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        Ok((speed, state))
    }
}
