//! Solution of the stage equations p = P(u), u = homogeneous response + H p.
//!
//! The number of unknowns is stages times loads, whatever the size of the model. Affine loads make the equations linear.
//! Other loads are found by an iteration that contracts like h²Δk/m, and by Newton's method where it contracts slowly.

use super::context::{StepContext, StepSpan};
use super::small_lu::{SmallLu, StageUnknowns};
use super::stages::{Stages, StepPoint};
use super::tangent_solver::TangentSolver;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::{PropagatorCache, panel_kernel};
use crate::integrate::{Halt, Statistics, StepHistory};
use crate::mesh::Contact;

/// Factor on a contraction that was extrapolated from the previous step.
const CONTRACTION_SAFETY: f64 = 2.0;
/// Smallest contraction that is assumed: the contacts are those before the iteration.
const MIN_CONTRACTION: f64 = 1e-3;
/// Iterations before Newton's method takes over, and those of Newton's method before the step is given up.
const MAX_ITERATIONS: usize = 16;
/// Largest contraction for which the iteration continues.
const MAX_CONTRACTION: f64 = 0.4;
/// A change below this fraction of the load is round-off.
const LOAD_ROUND_OFF: f64 = 1e-14;

/// Solver of the stage equations.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct LoadSolver {
    /// Whether every load is an affine function of one deflection.
    affine: bool,
    small_lu: SmallLu,
    /// Solver for the effect of the contact stiffness and damping.
    tangent_solver: TangentSolver,
    /// Factor by which an iteration reduces the residual; infinite if unknown.
    contraction: f64,
    /// Ratio of the last two step lengths for which [`Self::extrapolation_weights`] are known; zero before the first step.
    extrapolation_ratio: f64,
    /// Weights that extrapolate the loads from the previous step.
    extrapolation_weights: Vec<f64>,
    /// Scratch: contacts of an evaluation.
    contacts: Vec<Contact>,
}

impl LoadSolver {
    /// Allocates the solver.
    pub fn new(loads: &Loads<'_>, cache: &PropagatorCache) -> Self {
        let stages = cache.rule.stages();
        Self {
            affine: loads.is_affine(),
            small_lu: SmallLu::new(stages * loads.coupled_load_count()),
            tangent_solver: TangentSolver::new(loads, &cache.maps.tangents, stages),
            contraction: f64::INFINITY,
            extrapolation_ratio: 0.0,
            extrapolation_weights: vec![0.0; stages * (stages + 1)],
            contacts: vec![Contact::default(); loads.connection_count()],
        }
    }

    /// Whether a step starts from a prediction, which uses the previous step.
    fn predicts(&self, context: &StepContext<'_>) -> bool {
        !self.affine && !context.cache.rule.explicit && context.loads.coupled_load_count() > 0
    }

    /// Stores what the prediction of the next step needs.
    pub fn store(&self, context: &StepContext<'_>, level: usize, stages: &Stages, history: &mut StepHistory) {
        if self.predicts(context) {
            let tangent = &self.tangent_solver.residual_tangent;
            let vectors = [&stages.evaluated_loads, &stages.interface_states, tangent];
            history.set(vectors.map(|values| &values[..]), context.step(level), self.contraction);
        }
    }

    /// Predicts the stage loads and interface states of a step: by the polynomials through those of the previous step, or, without
    /// a previous step, by the values at the beginning.
    pub fn guess(
        &mut self,
        context: &StepContext<'_>,
        span: StepSpan,
        begin: &StepPoint,
        history: &StepHistory,
        stages: &mut Stages,
    ) -> Result<(), Halt> {
        if !self.predicts(context) {
            return Ok(());
        }
        let loads = &context.loads;
        let tangent = self.tangent_solver.residual_tangent.len();
        // The history of a run with another number of stages has other lengths.
        if !history.has_lengths([stages.loads.len(), stages.interface_states.len(), tangent]) {
            let (load_count, len) = (loads.load_count(), loads.interface_len());
            stages.loads.chunks_exact_mut(load_count).for_each(|load| load.copy_from_slice(&begin.load));
            let states = stages.interface_states.chunks_exact_mut(len);
            states.for_each(|state| state.copy_from_slice(&begin.interface_state));
            self.contraction = f64::INFINITY;
            // The loads are known: only their tangent is new.
            let load = &mut stages.residual[..load_count];
            let tangent = self.tangent_solver.tangent().split_off(loads.tangent_len());
            loads.load(span.begin, &begin.interface_state, load, &mut self.contacts, Some(tangent))?;
            self.tangent_solver.repeat_first(context.stages());
            return Ok(());
        }
        self.tangent_solver.set_tangent(&history.residual_tangent);
        // The contraction is proportional to h² for stiffness and to h for damping.
        let ratio = context.step(span.level) / history.step;
        self.contraction = history.contraction * ratio.max(ratio * ratio);
        if self.extrapolation_ratio != ratio {
            context.cache.rule.extrapolation(ratio, &mut self.extrapolation_weights);
            self.extrapolation_ratio = ratio;
        }
        let (arch, weights) = (context.arch, &self.extrapolation_weights);
        panel_kernel::extrapolate(arch, &begin.load, &history.loads, weights, &mut stages.loads);
        let states = &history.interface_states;
        panel_kernel::extrapolate(arch, &begin.interface_state, states, weights, &mut stages.interface_states);
        Ok(())
    }

    /// Solves the stage equations of a step. Returns whether that succeeded.
    pub fn solve(
        &mut self,
        context: &StepContext<'_>,
        stages: &mut Stages,
        span: StepSpan,
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        if context.cache.rule.explicit {
            stages.evaluate_in_sequence(context, span, statistics)?;
            return Ok(true);
        }
        if self.affine {
            return self.solve_affine(context, stages, span, statistics);
        }
        self.iterate(context, stages, span, tolerance, statistics)
    }

    /// Solves linear stage equations: p = P(homogeneous response) + P′ H p. Returns whether the matrix is regular.
    fn solve_affine(
        &mut self,
        context: &StepContext<'_>,
        stages: &mut Stages,
        span: StepSpan,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let loads = &context.loads;
        let (coupled, load_count) = (loads.coupled_load_count(), loads.load_count());
        stages.interface_states.copy_from_slice(&stages.homogeneous_response);
        stages.evaluate_all(context, span, Some(self.tangent_solver.tangent()), statistics)?;
        let (stage_response, count) = (context.cache.stage_response(span.level), context.stages());
        let unknowns = StageUnknowns { coupled, load_count };
        // An affine load has one scalar, so that its tangent has one entry at each stage.
        stages.loads.copy_from_slice(&stages.residual);
        self.small_lu.begin();
        for (stage, residual) in stages.residual.chunks_exact(load_count).enumerate() {
            for (k, own) in residual[..coupled].iter().enumerate() {
                let row = stage * coupled + k;
                let slope = -self.tangent_solver.next_tangent()[row];
                let response = stage_response.response_of(stage, k);
                self.small_lu.subtract(row, slope, unknowns, &response);
                // Prescribed loads also move the scalars.
                let prescribed = (0..count).flat_map(|stage| stage * load_count + coupled..(stage + 1) * load_count);
                let others = prescribed.map(|column| response(column) * stages.residual[column]);
                self.small_lu.right[row] = own + slope * others.sum::<f64>();
            }
        }
        if !self.small_lu.solve() {
            return Ok(false);
        }
        let solved = self.small_lu.right.chunks_exact(coupled.max(1));
        for (loads, solved) in stages.loads.chunks_exact_mut(load_count).zip(solved) {
            loads[..coupled].copy_from_slice(solved);
        }
        stages.mark_stale();
        Ok(true)
    }

    /// Iterates from the predicted loads. Returns whether the iteration or Newton's method converged.
    fn iterate(
        &mut self,
        context: &StepContext<'_>,
        stages: &mut Stages,
        span: StepSpan,
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let step = context.step(span.level);
        let mut previous = f64::INFINITY;
        if !self.tangent_solver.predict(context, span.level, stages) {
            return Ok(false);
        }
        for iteration in 0..MAX_ITERATIONS {
            let solvable = self.improve(context, stages, span, statistics)?;
            let change = residual_norm(context, stages, step);
            if !solvable || !change.is_finite() {
                return Ok(false);
            }
            // With the contraction ρ, the remaining error is the change times ρ/(1 − ρ). The first iteration has no
            // measured contraction and uses that of the previous step.
            let contraction = if iteration > 0 { change / previous } else { CONTRACTION_SAFETY * self.contraction };
            if iteration > 0 {
                self.contraction = contraction;
            }
            let assumed = contraction.max(MIN_CONTRACTION);
            let remaining = if assumed < 1.0 { change * assumed / (1.0 - assumed) } else { change };
            if remaining <= tolerance || change <= LOAD_ROUND_OFF * load_norm(context, stages, step) {
                stages.mark_stale();
                return Ok(true);
            }
            if iteration > 1 && contraction > MAX_CONTRACTION {
                break;
            }
            previous = change;
        }
        self.newton(context, stages, span, tolerance, statistics)
    }

    /// One iteration: adds the residual to the loads, and the correction that follows from it. Returns whether the
    /// correction exists.
    fn improve(
        &mut self,
        context: &StepContext<'_>,
        stages: &mut Stages,
        span: StepSpan,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        stages.respond_all(context, span.level);
        stages.evaluate_all(context, span, Some(self.tangent_solver.tangent()), statistics)?;
        stages.evaluated_loads.copy_from_slice(&stages.residual);
        for (load, residual) in stages.loads.iter_mut().zip(&mut stages.residual) {
            (*load, *residual) = (*residual, *residual - *load);
        }
        Ok(self.tangent_solver.correct(context, span.level, stages))
    }

    /// Newton's method. Returns whether it converged.
    fn newton(
        &mut self,
        context: &StepContext<'_>,
        stages: &mut Stages,
        span: StepSpan,
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let step = context.step(span.level);
        for _ in 0..MAX_ITERATIONS {
            stages.respond_all(context, span.level);
            stages.evaluate_all(context, span, None, statistics)?;
            self.differentiate(context, stages, span, statistics)?;
            if !self.newton_step(context, stages) {
                return Ok(false);
            }
            let change = residual_norm(context, stages, step);
            if !change.is_finite() {
                return Ok(false);
            }
            if change <= tolerance || change <= LOAD_ROUND_OFF.sqrt() * 1e-3 * load_norm(context, stages, step) {
                stages.respond_all(context, span.level);
                stages.evaluated_loads.copy_from_slice(&stages.loads);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Sets the matrix 1 − P′H of Newton's method, with P′ from difference quotients. `residual` holds P.
    fn differentiate(
        &mut self,
        context: &StepContext<'_>,
        stages: &mut Stages,
        span: StepSpan,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let loads = &context.loads;
        let (coupled, load_count) = (loads.coupled_load_count(), loads.load_count());
        let len = loads.interface_len();
        let (stage_response, step) = (context.cache.stage_response(span.level), context.step(span.level));
        let unknowns = StageUnknowns { coupled, load_count };
        self.small_lu.begin();
        for (i, node) in context.cache.rule.nodes.iter().enumerate() {
            let u = &mut stages.interface_states[i * len..(i + 1) * len];
            let load = &stages.residual[i * load_count..(i + 1) * load_count];
            let time = span.begin + node * step;
            for k in 0..len {
                // A relative increment, but at least a nanometre or a nanoradian.
                let increment = 1e-7 * u[k].abs().max(1e-2);
                let original = u[k];
                u[k] += increment;
                let moved = u[k] - original;
                let slopes = self.small_lu.slopes(load_count);
                let outcome = loads.load(time, u, slopes, &mut self.contacts, None);
                u[k] = original;
                outcome?;
                for (slope, load) in slopes.iter_mut().zip(load) {
                    *slope = (*slope - load) / moved;
                }
                self.small_lu.subtract_slopes(i * coupled, unknowns, stage_response.response_of(i, k));
            }
            statistics.evaluations += len as u64;
        }
        Ok(())
    }

    /// Solves (1 − P′H) Δp = P − p for the loads that depend on the motion and adds Δp, which is left in `residual`. Prescribed loads take
    /// their values. Returns whether the matrix is regular.
    fn newton_step(&mut self, context: &StepContext<'_>, stages: &mut Stages) -> bool {
        let loads = &context.loads;
        let (coupled, load_count) = (loads.coupled_load_count(), loads.load_count());
        let of_stages = stages.loads.chunks_exact_mut(load_count).zip(stages.residual.chunks_exact(load_count));
        for (i, (load, evaluated)) in of_stages.enumerate() {
            for k in 0..coupled {
                self.small_lu.right[i * coupled + k] = evaluated[k] - load[k];
            }
            load[coupled..].copy_from_slice(&evaluated[coupled..]);
        }
        if !self.small_lu.solve() {
            return false;
        }
        let solved = self.small_lu.right.chunks_exact(coupled.max(1));
        let of_stages = stages.loads.chunks_exact_mut(load_count).zip(stages.residual.chunks_exact_mut(load_count));
        for ((load, change), solved) in of_stages.zip(solved) {
            for ((load, change), solved) in load.iter_mut().zip(change).zip(solved) {
                *load += solved;
                *change = *solved;
            }
        }
        true
    }
}

/// Energy norm that the residual adds to a state over a step; infinite if it is not finite.
fn residual_norm(context: &StepContext<'_>, stages: &Stages, step: f64) -> f64 {
    let (coupled, load_count) = (context.loads.coupled_load_count(), context.loads.load_count());
    let mut largest: f64 = 0.0;
    for residual in stages.residual.chunks_exact(load_count) {
        let square = panel_kernel::quadratic_form(context.arch, &context.cache.gram, &residual[..coupled]);
        if !square.is_finite() {
            return f64::INFINITY;
        }
        largest = largest.max(square);
    }
    step * largest.sqrt()
}

/// Energy norm that the stage loads add to a state over a step.
fn load_norm(context: &StepContext<'_>, stages: &Stages, step: f64) -> f64 {
    let (coupled, load_count) = (context.loads.coupled_load_count(), context.loads.load_count());
    let stages = stages.loads.chunks_exact(load_count);
    step * stages
        .map(|loads| panel_kernel::quadratic_form(context.arch, &context.cache.gram, &loads[..coupled]))
        .fold(0.0, f64::max)
        .sqrt()
}
