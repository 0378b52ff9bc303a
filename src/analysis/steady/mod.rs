//! Steady-state response: the motion that repeats after the common period of the excitation.
//!
//! It is the fixed point of the period map P, which integrates one period. The correction (I − e^{AT})⁻¹(P(z) − z) of
//! the linear motion is accelerated by the secants of the iteration, for affine maps the same as GMRES with this
//! preconditioner. The rigid-body rotation is no unknown.
//!
//! `period` is the common period, `solver` the iteration with `preconditioner`, `anderson` and `gmres`, `multipliers` the
//! stability. Where the sources have no common period, or a long one, the unknowns of `quasi_periodic` are the harmonics
//! (`harmonics`, `turning`) of the states at the beginning of shorter sections.

mod anderson;
mod gmres;
mod harmonics;
mod multipliers;
mod period;
mod preconditioner;
mod quasi_periodic;
mod solver;
mod turning;

use nalgebra::Complex;

use super::AnalysisError;
pub use super::simulate::kept_modes;
use super::simulate::{Initial, Options, RecordPlan, Response, with_period_map, with_section_map};
use crate::modal::CachedModel;
pub use period::{Sections, common_period, has_constant_coefficients, sections};
use preconditioner::Preconditioner;
use quasi_periodic::QuasiPeriodic;
use solver::Solver;

/// Number of sections in a period from which on their harmonics take less work than whole periods: for affine and for other
/// maps.
const MANY_SECTIONS: f64 = 40.0;
const MANY_NONLINEAR_SECTIONS: f64 = 300.0;

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
    /// What limits the accuracy, if something does.
    pub warning: Option<String>,
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
    let begin = begin_from_sections(cached, options, plan, watch)?;
    with_period_map(cached, options, plan, watch, |map| {
        let begin = begin.map(|(state, runs)| {
            map.runs += runs;
            map.modal(&state)
        });
        Solver::new(map, samples)?.solve(begin)
    })
}

/// The state at the begin of a period of many sections, displacements then velocities, where it follows from their harmonics
/// with less work than from whole periods; and this work in periods.
///
/// # Errors
/// [`AnalysisError::Interrupted`].
fn begin_from_sections(
    cached: &CachedModel,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<(Vec<f64>, usize)>, AnalysisError> {
    let found = sections(&cached.model, options.fastest(), options.duration);
    let sections = match (found, &options.initial) {
        // Another motion may be near to the wanted one.
        (None, _) | (_, Initial::Continue(_)) => return Ok(None),
        (Some(sections), _) => sections,
    };
    let count = options.duration / sections.length;
    if count < MANY_SECTIONS {
        return Ok(None);
    }
    let begin = with_section_map(cached, options, plan, sections.length, watch, |map| {
        if count < if map.is_affine() { MANY_SECTIONS } else { MANY_NONLINEAR_SECTIONS } {
            return Ok(None);
        }
        let state = QuasiPeriodic::new(map, &sections)?.begin()?.state;
        Ok(Some((map.physical(state), (map.runs as f64 / count).ceil() as usize)))
    });
    match begin {
        Ok(state) => Ok(state),
        Err(AnalysisError::Interrupted) => Err(AnalysisError::Interrupted),
        // The whole period says what is wrong.
        Err(_) => Ok(None),
    }
}

/// Finds the steady motion without a common period from its sections, and records `samples` instants of
/// `options.duration`, s, which is a multiple of their length.
///
/// # Errors
/// [`AnalysisError`] if there is none, or if the iteration does not converge.
pub fn quasi_periodic_state(
    cached: &CachedModel,
    options: &Options,
    plan: &RecordPlan,
    sections: &Sections,
    samples: usize,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<SteadyState, AnalysisError> {
    let count = (options.duration / sections.length).round().max(1.0) as u64;
    with_section_map(cached, options, plan, sections.length, watch, |map| {
        QuasiPeriodic::new(map, sections)?.solve(count, samples)
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
    cached: &CachedModel,
    options: &Options,
    states: &[Vec<f64>],
    levels: Option<&[u8]>,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Corrected, AnalysisError> {
    with_period_map(cached, options, &RecordPlan::default(), watch, |map| {
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
    cached: &CachedModel,
    options: &Options,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<f64>, AnalysisError> {
    with_period_map(cached, options, &RecordPlan::default(), watch, |map| Ok(map.physical(map.initial())))
}

/// Records `samples` instants of the period that begins in a state, displacements then velocities.
///
/// # Errors
/// [`AnalysisError`] if the run ends early.
pub fn recorded_period(
    cached: &CachedModel,
    options: &Options,
    plan: &RecordPlan,
    state: &[f64],
    samples: usize,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Response, AnalysisError> {
    with_period_map(cached, options, plan, watch, |map| {
        let z = map.modal(state);
        Ok(map.record(1, &z, samples)?.0)
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
    with_period_map(cached, options, plan, watch, |map| {
        let is_constant = has_constant_coefficients(&cached.model, options.geometry);
        multipliers::multipliers(map, smallest, is_constant)
    })
}

/// Euclidean norm: the energy norm of a state z, as far as the modes are orthogonal.
fn norm(z: &[f64]) -> f64 {
    z.iter().map(|value| value * value).sum::<f64>().sqrt()
}
