//! Steady-state response: the motion that repeats after the common period of the excitation.
//!
//! It is the fixed point of the period map P, which integrates one period. The correction (I − e^{AT})⁻¹(P(z) − z) of
//! the linear motion is accelerated by the secants of the iteration, for affine maps the same as GMRES with this
//! preconditioner. The rigid-body rotation is no unknown.

mod anderson;
mod gmres;
mod multipliers;
mod period;
mod preconditioner;
mod solver;

use nalgebra::Complex;

use super::AnalysisError;
use super::simulate::{Options, RecordPlan, Response, with_period_map};
use crate::modal::CachedModel;
pub use period::common_period;
use solver::Solver;

/// A steady state.
#[derive(Clone, Debug)]
pub struct SteadyState {
    /// One period of the motion.
    pub response: Response,
    /// Period, s.
    pub period: f64,
    /// Energy norm of the difference after one more period relative to that of the motion.
    pub residual: f64,
    /// Number of integrated periods, with the recorded one.
    pub periods: usize,
    /// Whether the period map is affine.
    pub is_affine: bool,
}

/// Finds the steady state with the period `options.duration`, s, and records `samples` of it.
///
/// # Errors
/// [`AnalysisError`] if there is none, or if the iteration does not converge.
pub fn steady_state(
    cached: &CachedModel,
    options: &Options,
    plan: &RecordPlan,
    samples: usize,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<SteadyState, AnalysisError> {
    with_period_map(cached, options, plan, watch, |map| Solver::new(map, samples)?.solve())
}

/// States after one period, displacements then velocities, for given states of this length at its beginning. The steps meet
/// the tolerance for the first state and are the same for all. With `samples`, this number of instants of the period from the
/// first state is recorded.
///
/// # Errors
/// [`AnalysisError`] if a run ends early.
pub fn period_map(
    cached: &CachedModel,
    options: &Options,
    (plan, samples): (&RecordPlan, usize),
    states: &[Vec<f64>],
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<(Vec<Vec<f64>>, Option<Response>), AnalysisError> {
    with_period_map(cached, options, plan, watch, |map| {
        let (mut images, mut response) = (Vec::with_capacity(states.len()), None);
        for (index, state) in states.iter().enumerate() {
            let z = map.modal(state);
            if index == 0 && samples > 0 {
                response = Some(map.record(&z, samples)?.0);
            } else if index == 0 {
                map.adapt(&z)?;
            }
            let image = map.apply(&z)?;
            images.push(map.physical(image));
        }
        Ok((images, response))
    })
}

/// Finds the multipliers of the steady state from which `options` continue.
///
/// # Errors
/// [`AnalysisError`] of the runs.
pub fn multipliers(
    cached: &CachedModel,
    options: &Options,
    plan: &RecordPlan,
    smallest: f64,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<Complex<f64>>, AnalysisError> {
    with_period_map(cached, options, plan, watch, |map| multipliers::multipliers(map, smallest))
}

/// Euclidean norm: the energy norm of a state z, as far as the modes are orthogonal.
fn norm(z: &[f64]) -> f64 {
    z.iter().map(|value| value * value).sum::<f64>().sqrt()
}
