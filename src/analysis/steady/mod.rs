//! Steady-state response: the motion that repeats after the common period of the excitation.
//!
//! It is the fixed point of the period map P, which integrates one period. The correction (I − e^{AT})⁻¹(P(z) − z) of
//! the linear motion is accelerated by the secants of the iteration, for affine maps the same as GMRES with this
//! preconditioner. The rigid-body rotation is no unknown.
//!
//! `period` is the common period, `solver` the iteration with `preconditioner`, `anderson`; `multipliers` the
//! stability. Where the sources have no common period, or a long one, the motion runs in (`run_in`).

mod anderson;
mod multipliers;
mod period;
mod preconditioner;
mod run_in;
mod solver;

use nalgebra::Complex;

use super::AnalysisError;
pub use super::simulate::kept_modes;
use super::simulate::{Initial, Options, RecordPlan, Response, System, with_part_map, with_period_map};
pub use multipliers::Wanted;
pub use period::{common_period, has_constant_coefficients, slowest_period};
use preconditioner::Preconditioner;
use run_in::PARTS;
use solver::Solver;

/// Length of a period, in periods of the slowest source, from which on running in within it takes less than iterations over
/// whole periods, which take 3 to 14 of them.
const LONG_PERIOD: f64 = 10.0;

/// A steady state.
#[derive(Clone, Debug)]
pub struct SteadyState {
    /// One period of the motion.
    pub response: Response,
    /// Period, s.
    pub period: f64,
    /// Energy norm of the difference after one more period relative to that of the motion; without a period, that of its
    /// transient part.
    pub residual: f64,
    /// Number of integrated periods, with the recorded one; without a period, of those of the slowest source.
    pub periods: usize,
    /// Whether the period map is affine.
    pub is_affine: bool,
    /// What limits the accuracy, if something does.
    pub warning: Option<String>,
}

/// Finds the steady state with the period `options.duration`, s, and records `samples` of it.
///
/// # Errors
/// [`AnalysisError`] if there is none, or if the iteration does not converge.
pub fn steady_state(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    samples: usize,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<SteadyState, AnalysisError> {
    let begin = begin_of_long_period(system, options, plan, watch)?;
    with_period_map(system, options, plan, watch, |map| {
        let begin = begin.map(|(state, runs)| {
            map.runs += runs;
            map.modal(&state)
        });
        Solver::new(map, samples)?.solve(begin)
    })
}

/// The state at the begin of a long period, displacements then velocities, where the motion runs in within it; and this work
/// in periods.
///
/// # Errors
/// [`AnalysisError::Interrupted`].
fn begin_of_long_period(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<(Vec<f64>, usize)>, AnalysisError> {
    let slowest = match (slowest_period(&system.model, options.fastest()), &options.initial) {
        // Another motion may be near to the wanted one.
        (None, _) | (_, Initial::Continue(_)) => return Ok(None),
        (Some(slowest), _) => slowest,
    };
    if options.duration < LONG_PERIOD * slowest {
        return Ok(None);
    }
    let (part, longest) = (slowest / PARTS, (PARTS * options.duration / slowest) as u64);
    let begin = with_part_map(system, options, plan, part, watch, |map| {
        let begin = run_in::settled(map, map.tolerance(), longest)?;
        Ok((map.physical(begin.state), (map.runs as f64 * part / options.duration).ceil() as usize))
    });
    match begin {
        Ok(found) => Ok(Some(found)),
        Err(AnalysisError::Interrupted) => Err(AnalysisError::Interrupted),
        // The whole period says what is wrong.
        Err(_) => Ok(None),
    }
}

/// Finds the steady motion without a common period by running in, and records `samples` instants of `options.duration`, s;
/// `slowest` is the longest period of a source, s.
///
/// # Errors
/// [`AnalysisError`] if the motion does not settle.
pub fn settled_state(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    slowest: f64,
    samples: usize,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<SteadyState, AnalysisError> {
    let count = (PARTS * options.duration / slowest).ceil().max(1.0);
    with_part_map(system, options, plan, options.duration / count, watch, |map| {
        run_in::solve(map, count as u64, samples)
    })
}

/// States after one step of the fixed-point iteration.
#[derive(Clone, Debug)]
pub struct Corrected {
    /// z + (I − e^{AT})⁻¹ (P(z) − z) for each given state z, as displacements then velocities.
    pub states: Vec<Vec<f64>>,
    /// Step levels of the period.
    pub levels: Vec<u8>,
}

/// Corrects given states at the beginning of a period, displacements then velocities, by one step of the fixed-point
/// iteration. All periods have the same steps: those of `levels`, or, without them, such that they meet the tolerance for the
/// first state.
///
/// # Errors
/// [`AnalysisError`] if a run ends early.
pub fn corrected_states(
    system: &System,
    options: &Options,
    states: &[Vec<f64>],
    levels: Option<&[u8]>,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Corrected, AnalysisError> {
    with_period_map(system, options, &RecordPlan::default(), watch, |map| {
        let preconditioner = Preconditioner::new(map.linear(), map.period());
        match (levels, states.first()) {
            (Some(levels), _) => map.plan(levels),
            (None, Some(first)) => {
                let z = map.modal(first);
                map.adapt(&z)?;
            }
            (None, None) => {}
        }
        let mut corrected = Vec::with_capacity(states.len());
        for state in states {
            let mut z = map.modal(state);
            let image = map.apply(&z)?;
            let defect: Vec<f64> = image.iter().zip(&z).map(|(image, z)| image - z).collect();
            z.iter_mut().zip(preconditioner.correct(&defect)).for_each(|(z, correction)| *z += correction);
            corrected.push(map.physical(z));
        }
        Ok(Corrected { states: corrected, levels: map.levels().to_vec() })
    })
}

/// The initial state of `options`, displacements then velocities.
///
/// # Errors
/// [`AnalysisError`] of the set-up.
pub fn initial_state(
    system: &System,
    options: &Options,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<f64>, AnalysisError> {
    with_period_map(system, options, &RecordPlan::default(), watch, |map| Ok(map.physical(map.initial())))
}

/// Records `samples` instants of the period that begins in a state, displacements then velocities.
///
/// # Errors
/// [`AnalysisError`] if the run ends early.
pub fn recorded_period(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    state: &[f64],
    samples: usize,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Response, AnalysisError> {
    with_period_map(system, options, plan, watch, |map| {
        let z = map.modal(state);
        Ok(map.record(1, &z, samples)?.0)
    })
}

/// Finds the multipliers of the steady state from which `options` continue.
///
/// # Errors
/// [`AnalysisError`] of the runs.
pub fn multipliers(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    wanted: Wanted,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<Complex<f64>>, AnalysisError> {
    with_period_map(system, options, plan, watch, |map| {
        let is_constant = has_constant_coefficients(&system.model, options.geometry);
        multipliers::multipliers(map, wanted, is_constant)
    })
}

/// Euclidean norm: the energy norm of a state z, as far as the modes are orthogonal.
fn norm(z: &[f64]) -> f64 {
    z.iter().map(|value| value * value).sum::<f64>().sqrt()
}
