//! Steady-state response: the motion that repeats after the common period of the excitation.
//!
//! It is the fixed point of the [period map](PeriodMap) P. The correction (I − e^{AT})⁻¹(P(z) − z) of the linear motion is
//! accelerated by the secants of the iteration, for affine maps the same as GMRES with this preconditioner. The rigid-body
//! rotation is no unknown.

mod anderson;
mod multipliers;
mod period;
mod preconditioner;

use nalgebra::Complex;

use super::AnalysisError;
use super::simulate::{Options, PeriodMap, RecordPlan, Response, with_period_map};
use crate::modal::CachedModel;
use anderson::Anderson;
pub use period::common_period;
use preconditioner::Preconditioner;

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 60;

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
    with_period_map(cached, options, plan, watch, |map| {
        let mut solver = Solver::new(map)?;
        let z = solver.solve()?;
        solver.recorded(&z, samples)
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

/// The iteration for the fixed point of a period map.
struct Solver<'s, 'a> {
    map: &'s mut PeriodMap<'a>,
    preconditioner: Preconditioner,
    tolerance: f64,
    /// Corrections in multiples of the tolerance.
    history: Vec<f64>,
}

impl<'s, 'a> Solver<'s, 'a> {
    fn new(map: &'s mut PeriodMap<'a>) -> Result<Self, AnalysisError> {
        let preconditioner = Preconditioner::new(map.linear(), map.period())?;
        let tolerance = map.tolerance();
        Ok(Self { map, preconditioner, tolerance, history: Vec::new() })
    }

    /// The state that a period reproduces.
    fn solve(&mut self) -> Result<Vec<f64>, AnalysisError> {
        let mut z = self.map.initial();
        let mut iteration = Anderson::default();
        for count in 0..MAX_ITERATIONS {
            // The first iteration also chooses the step levels; its image has the error of other steps.
            let image = if count == 0 { self.map.adapt(&z)? } else { self.map.apply(&z)? };
            let defect: Vec<f64> = image.iter().zip(&z).map(|(image, z)| image - z).collect();
            let correction = self.preconditioner.correct(&defect);
            let size = self.map.size(&z)?;
            let error = norm(&correction) / (self.tolerance * size);
            self.history.push(error);
            if std::env::var("STEADY_TRACE").is_ok() { eprintln!("{count} {error:e} size {size:e} defect {:e}", norm(&defect)/size); }
            let next = iteration.next(&z, &correction);
            if count == 0 {
                iteration.clear();
            }
            if error <= 1.0 {
                return Ok(next);
            }
            z = next;
        }
        Err(AnalysisError::Convergence("steady state: no".to_owned()))
    }

    /// Records a period from the state z.
    fn recorded(&mut self, z: &[f64], samples: usize) -> Result<SteadyState, AnalysisError> {
        let size = self.map.size(z)?;
        let (response, image) = self.map.record(z, samples)?;
        let rigid = &self.preconditioner.positions;
        let difference = image.iter().zip(z).enumerate().filter(|(entry, _)| !rigid.contains(entry));
        let residual = difference.map(|(_, (image, z))| (image - z).powi(2)).sum::<f64>().sqrt() / size;
        Ok(SteadyState {
            response,
            period: self.map.period(),
            residual,
            periods: self.map.runs,
            is_affine: self.map.is_affine(),
        })
    }
}

/// Euclidean norm: the energy norm of a state z, as far as the modes are orthogonal.
fn norm(z: &[f64]) -> f64 {
    z.iter().map(|value| value * value).sum::<f64>().sqrt()
}
