//! One step of the exponential method: the response of the state alone, the stage loads, and the state at the end.

use std::sync::Arc;

use super::context::{SourcePhasors, StepContext, StepInstant, StepSpan};
use super::estimate::ErrorEstimator;
use super::solve::LoadSolver;
use super::stages::{Stages, StepPoint};
use crate::exponential::loads::Loads;
use crate::exponential::propagator::{MAX_STAGES, PointValues, PropagatorCache, TimeGrid, kernel};
use crate::integrate::{Halt, Statistics};
use crate::mesh::Contact;

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The stage equations are solved.
    Solved,
    /// The stage equations are not solved: the step is too long.
    Unsolved,
}

/// Scratch for the load defect at an instant.
pub struct DefectScratch<'a> {
    pub interface_state: &'a mut [f64],
    pub loads: &'a mut [f64],
    pub interpolated: &'a mut [f64],
}

/// The method and the last step that it took.
#[derive(Clone, Debug)]
pub struct Stepper<'m> {
    pub(in crate::exponential) context: StepContext<'m>,
    /// The interface at the beginning and at the end of the last step.
    pub(in crate::exponential) begin: StepPoint,
    pub(in crate::exponential) end: StepPoint,
    pub(in crate::exponential) stages: Stages,
    pub(in crate::exponential) solver: LoadSolver,
    pub(in crate::exponential) estimator: ErrorEstimator,
    /// State z at the end of the last step.
    pub(in crate::exponential) end_state: Vec<f64>,
    /// Number of steps tried.
    pub(in crate::exponential) steps: u64,
    /// Finest level that met the tolerance within each longest step; recorded if there is a list.
    pub levels: Option<Vec<u8>>,
    /// Whether engagement is sharp: tooth pairs enter and leave contact at an instant.
    pub(in crate::exponential) sharp: bool,
    /// Whether the flanks of a mesh can separate.
    separable: bool,
    /// Scratch: phasors and contacts of an evaluation.
    phasors: SourcePhasors,
    contacts: Vec<Contact>,
}

impl<'m> Stepper<'m> {
    /// Creates the stepper of nonlinear loads with the propagators of a time grid.
    pub fn new(loads: Loads<'m>, cache: Arc<PropagatorCache>) -> Self {
        let motion = &loads.motion;
        Self {
            begin: StepPoint::new(&loads),
            end: StepPoint::new(&loads),
            stages: Stages::new(&loads, cache.rule.stages()),
            solver: LoadSolver::new(&loads, &cache),
            estimator: ErrorEstimator::new(loads.coupled_load_count()),
            end_state: vec![0.0; cache.linear.len()],
            steps: 0,
            levels: None,
            sharp: motion.model().meshes.iter().any(|mesh| mesh.teeth.is_sharp()),
            separable: motion.flanks_can_separate(),
            phasors: SourcePhasors::new(&loads),
            contacts: vec![Contact::default(); loads.connection_count()],
            context: StepContext::new(loads, cache),
        }
    }

    /// The loads on the linear motion.
    pub fn loads(&self) -> &Loads<'m> {
        &self.context.loads
    }

    /// Energy norm of the motion about the reference, for the state `z` at an elapsed time, s.
    ///
    /// # Errors
    /// [`Halt`] where the loads are not defined.
    pub fn energy_norm(&mut self, elapsed: f64, z: &[f64]) -> Result<f64, Halt> {
        self.evaluate_begin(elapsed, z, &mut Statistics::new())?;
        Ok(self.size(z, &self.begin))
    }

    /// Records the level of a step from the unit `count` on.
    pub(in crate::exponential) fn record_level(&mut self, time_grid: &TimeGrid, count: u64, level: usize) {
        let Some(levels) = &mut self.levels else {
            return;
        };
        let longest = usize::try_from(count / time_grid.units(0)).unwrap_or(usize::MAX);
        if let Some(finest) = levels.get_mut(longest) {
            *finest = (*finest).max(u8::try_from(level).unwrap_or(u8::MAX));
        }
    }

    /// Length of a step, s.
    pub(in crate::exponential) fn step_length(&self, level: usize) -> f64 {
        self.context.step(level)
    }

    /// Energy norm of the motion about the reference, for the state `z` at the point `at`.
    pub(in crate::exponential) fn size(&self, z: &[f64], at: &StepPoint) -> f64 {
        let mut square = [0.0];
        kernel::scalars(self.context.arch, z, z, &mut square);
        (square[0] + at.mesh_energy + self.context.loads.synchronous_size.powi(2)).sqrt()
    }

    /// Evaluates the interface of the state with which a step begins.
    pub(in crate::exponential) fn evaluate_begin(
        &mut self,
        elapsed: f64,
        z: &[f64],
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        self.begin.evaluate(&self.context, &mut self.phasors, elapsed, z, statistics)
    }

    /// Evaluates the interface of [`Self::end_state`].
    pub(in crate::exponential) fn evaluate_end(
        &mut self,
        elapsed: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        self.end.evaluate(&self.context, &mut self.phasors, elapsed, &self.end_state, statistics)
    }

    /// Takes the end of the last step as the beginning of the next.
    pub(in crate::exponential) fn commit(&mut self, z: &mut Vec<f64>) {
        std::mem::swap(z, &mut self.end_state);
        std::mem::swap(&mut self.begin, &mut self.end);
    }

    /// Takes a step from the state `z`.
    /// [`Self::end_state`] is the new state. `tolerance` limits the energy norm of the remaining load residual.
    ///
    /// # Errors
    /// [`Halt`] where the loads are not defined.
    pub(in crate::exponential) fn step(
        &mut self,
        span: StepSpan,
        z: &[f64],
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<Outcome, Halt> {
        self.steps += 1;
        self.stages.mark_current();
        if self.context.loads.load_count() > 0 {
            self.phasors.update(&self.context.loads, span.begin);
            self.stages.prepare(&self.context, span.level, &self.phasors, z);
            if !self.solver.solve(&self.context, &mut self.stages, span, tolerance, statistics)? {
                return Ok(Outcome::Unsolved);
            }
        }
        let propagator = self.context.cache.propagator(span.level);
        propagator.advance(self.context.arch, &self.stages.loads, z, &mut self.end_state);
        self.evaluate_end(span.end, statistics)?;
        Ok(Outcome::Solved)
    }

    /// Energy norm of the error of the last step.
    pub(in crate::exponential) fn error(&mut self, level: usize) -> f64 {
        self.estimator.estimate(&self.context, level, &self.begin, &self.end, &self.stages)
    }

    /// Longest step at an instant, s; infinite at a constant speed, for which the time grid gives it.
    #[inline]
    pub(in crate::exponential) fn longest_step(&self, elapsed: f64) -> f64 {
        self.context.loads.longest_step(elapsed, self.step_length(0))
    }

    /// Fastest oscillation on the mesh stiffness at the beginning of a step, rad/s; zero if flanks cannot separate.
    pub(in crate::exponential) fn frequency_at_begin(&self) -> f64 {
        if self.separable {
            let intervals = self.context.loads.guaranteed_intervals(&self.begin.contacts);
            intervals.map(|interval| interval.frequency).fold(0.0, f64::max)
        } else {
            0.0
        }
    }

    /// Fastest oscillation on the mesh stiffness at the stages and at the end of the last step, rad/s. Writes for each
    /// connection whether its flank contact is unchanged over the step; writes nothing if flanks cannot separate.
    pub(in crate::exponential) fn check_flanks(&self, level: usize, unchanged: &mut Vec<bool>) -> f64 {
        unchanged.clear();
        if !self.separable {
            return 0.0;
        }
        let loads = &self.context.loads;
        let gap = self.context.cache.rule.gap() * self.step_length(level);
        unchanged.resize(loads.connection_count(), true);
        let mut frequency: f64 = 0.0;
        for contacts in self.stages.contacts.chunks_exact(unchanged.len().max(1)).chain([&self.end.contacts[..]]) {
            for (unchanged, interval) in unchanged.iter_mut().zip(loads.guaranteed_intervals(contacts)) {
                *unchanged &= interval.time >= gap;
                frequency = frequency.max(interval.frequency);
            }
        }
        frequency
    }

    /// Margins of both flanks of a connection to the next contact change at the beginning, at the stages and at the end of the
    /// last step, m.
    pub(in crate::exponential) fn margins(&self, connection: usize) -> [PointValues; 2] {
        let loads = &self.context.loads;
        let contacts = [&self.begin.contacts[..], &self.stages.contacts[..], &self.end.contacts[..]];
        let mut margins = [[0.0; MAX_STAGES + 2]; 2];
        let points = contacts.into_iter().flat_map(|contacts| contacts.chunks_exact(loads.connection_count()));
        for (k, contacts) in points.enumerate() {
            for (margins, margin) in margins.iter_mut().zip(loads.margins(connection, &contacts[connection])) {
                margins[k] = margin;
            }
        }
        margins
    }

    /// Interpolates the interface state at the fraction `part` of the last step, by the polynomial through its
    /// beginning, its stages and its end.
    pub(in crate::exponential) fn interpolate(&self, part: f64, interface_state: &mut [f64]) {
        let len = interface_state.len();
        let weights = self.context.cache.rule.through(part);
        let (first, last) = (weights[0], weights[self.context.stages() + 1]);
        let stages = &self.stages.interface_states;
        for (k, value) in interface_state.iter_mut().enumerate() {
            let inner = weights[1..].iter().zip(stages.chunks_exact(len)).map(|(weight, u)| weight * u[k]);
            *value = first * self.begin.interface_state[k] + inner.sum::<f64>() + last * self.end.interface_state[k];
        }
    }

    /// Difference between the interface state of the motion `z` at an instant of the last step and the interpolated
    /// one, which is left in `interpolated`.
    pub(in crate::exponential) fn interpolation_error(
        &self,
        at: StepInstant,
        z: &[f64],
        interpolated: &mut [f64],
        error: &mut [f64],
    ) {
        self.interpolate(at.part, interpolated);
        self.context.observe_at(at.elapsed, z, error);
        for (error, polynomial) in error.iter_mut().zip(interpolated) {
            *error -= *polynomial;
        }
    }

    /// Interpolates the loads at the fraction `part` of the last step, by the same points.
    pub(in crate::exponential) fn interpolate_loads(&self, part: f64, out: &mut [f64]) {
        let weights = self.context.cache.rule.through(part);
        let (first, last) = (weights[0], weights[self.context.stages() + 1]);
        for ((out, begin), end) in out.iter_mut().zip(&self.begin.load).zip(&self.end.load) {
            *out = first * begin + last * end;
        }
        for (weight, stage) in weights[1..].iter().zip(self.stages.loads.chunks_exact(out.len().max(1))) {
            for (out, load) in out.iter_mut().zip(stage) {
                *out += weight * load;
            }
        }
    }

    /// Evaluates the loads at an interface state.
    pub(in crate::exponential) fn evaluate_at(
        &mut self,
        elapsed: f64,
        interface_state: &[f64],
        out: &mut [f64],
    ) -> Result<(), Halt> {
        self.context.loads.load(elapsed, interface_state, out, &mut self.contacts, None)
    }

    /// Energy norm of the rate of the state under the load defect at an instant of the last step, where its motion is
    /// `z`.
    pub(in crate::exponential) fn defect_at(
        &mut self,
        at: StepInstant,
        z: &[f64],
        scratch: DefectScratch<'_>,
    ) -> Result<f64, Halt> {
        let DefectScratch { interface_state, loads, interpolated } = scratch;
        self.context.observe_at(at.elapsed, z, interface_state);
        self.evaluate_at(at.elapsed, interface_state, loads)?;
        self.interpolate_loads(at.part, interpolated);
        Ok(self.estimator.defect_of(&self.context, loads, interpolated))
    }
}
