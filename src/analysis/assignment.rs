//! Which modes of one model continue those of a similar one, by the correlations of their shapes.

use nalgebra::Complex;

/// A step in which the correlation of a mode is smaller is halved.
pub(super) use crate::modal::MIN_CORRELATION;

/// Two modes that exchange their order are treated as crossing if the mixing of their shapes, beyond twice what they have in
/// common before, is below this limit. A veering that takes less than a hundredth of the step is therefore a crossing.
const MAX_MIXING_OF_CROSSING: f64 = 1e-4;
/// Relative difference below which eigenvalues are equal. Their shapes may then be any combination.
const EQUAL_TOLERANCE: f64 = 1e-7;

/// Assignment of the modes at the end of a step to those at its beginning.
pub(super) struct Assignment {
    /// Index of the mode at the end for each mode at the beginning.
    pub states: Vec<usize>,
    /// Correlation of each mode with all modes at the end that have the eigenvalue of the assigned one.
    pub kept: Vec<f64>,
    /// Whether the assignment is reliable.
    pub clear: bool,
}

impl Assignment {
    /// Assigns the modes with the eigenvalues `after`, rad/s, to those with the eigenvalues `before` by the correlations
    /// (before, after) of their shapes; `common` gives the correlation of two modes before, which damping and cross-coupling
    /// cause. The first `deciding` modes decide whether the assignment is clear.
    pub fn new(
        correlations: &[Vec<f64>],
        common: impl Fn(usize, usize) -> f64,
        before: &[Complex<f64>],
        after: &[Complex<f64>],
        deciding: usize,
    ) -> Self {
        // Among equal eigenvalues any mode is correct; the correlation is the sum over all of them.
        let shared = |mode: usize, index: usize| {
            let together = (0..after.len()).filter(|other| equal(after[*other], after[index]));
            together.map(|other| correlations[mode][other]).sum::<f64>()
        };
        let mut pairs: Vec<(f64, usize, usize)> = (0..before.len())
            .flat_map(|mode| (0..after.len()).map(move |index| (mode, index)))
            .filter(|(mode, index)| correlations[*mode][*index] > f64::EPSILON)
            .map(|(mode, index)| {
                (shared(mode, index) + MAX_MIXING_OF_CROSSING * correlations[mode][index], mode, index)
            })
            .collect();
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut taken, mut assigned) = (vec![false; after.len()], vec![None; before.len()]);
        for (_, mode, index) in &pairs {
            if assigned[*mode].is_none() && !taken[*index] {
                (assigned[*mode], taken[*index]) = (Some(*index), true);
            }
        }
        let mut free = (0..after.len()).filter(|index| !taken[*index]);
        let states: Vec<usize> =
            assigned.iter().map(|index| index.or_else(|| free.next()).unwrap_or_default()).collect();
        let kept: Vec<f64> = states.iter().enumerate().map(|(mode, index)| shared(mode, *index)).collect();
        let mixed = |a: usize, b: usize| {
            let mixing = correlations[a][states[b]].max(correlations[b][states[a]]);
            mixing > MAX_MIXING_OF_CROSSING + 2.0 * common(a, b)
        };
        let passed = |a: usize, b: usize| {
            let gap = |a: Complex<f64>, b: Complex<f64>| (a.im - b.im) / (a.im + b.im);
            let (before, after) = (gap(before[a], before[b]), gap(after[states[a]], after[states[b]]));
            before * after < 0.0 && before.abs().min(after.abs()) > EQUAL_TOLERANCE
        };
        let count = before.len().min(deciding);
        let clear = kept[..count].iter().all(|kept| *kept > MIN_CORRELATION)
            && !(0..count).any(|b| (0..b).any(|a| passed(a, b) && mixed(a, b)));
        Self { states, kept, clear }
    }
}

/// Whether two eigenvalues are equal, up to round-off.
pub(super) fn equal(a: Complex<f64>, b: Complex<f64>) -> bool {
    (a - b).norm() <= EQUAL_TOLERANCE * a.norm()
}
