//! The period map: the state at the end of one period of the excitation, as a function of the state at its beginning.
//!
//! The state is z of the modal coordinates in which a run integrates. The time grid divides the period into equal longest
//! steps, so that the period ends with a step. [`PeriodMap::adapt`] chooses the step levels within each of them by the
//! tolerance; [`PeriodMap::apply`] repeats these levels from other states, so that its result is a smooth function of the
//! state as far as the loads are.
//!
//! `set_up` makes the map of a system, `record` records the motion over periods.

mod record;
mod set_up;

use std::sync::Arc;

use nalgebra::Complex;

use super::exponential::propagators;
use super::heartbeat::Waiting;
use super::initial::Start;
use super::modal_setup::{ModalSetup, in_modal_coordinates, in_physical_coordinates};
use super::options::is_large;
use super::reduction::Reduction;
use super::run_cache::RunModel;
use super::{Options, RecordPlan, explain};
use crate::analysis::instability::growing_modes;
use crate::analysis::{AnalysisError, Spectrum};
use crate::exponential::{LevelControl, STAGE_SOLVE_RTOL, Stepper, TimeGrid, run as integrate};
use crate::integrate::{Halted, State, Statistics};
use crate::modal::ModalStateSpace;
pub use set_up::{kept_modes, with_part_map, with_period_map};

/// Relative distance of two eigenvalues of one mode, of the complete model and of the modes of its components.
const SAME_MODE_TOLERANCE: f64 = 1e-2;

/// The period map of a system at a constant speed.
pub struct PeriodMap<'a> {
    cached: &'a RunModel<'a>,
    options: &'a Options,
    plan: &'a RecordPlan,
    /// Period, s.
    period: f64,
    setup: ModalSetup<'a>,
    reduction: Option<Reduction>,
    stepper: Stepper<'a>,
    time_grid: TimeGrid,
    /// Number of longest steps in a period.
    steps: u64,
    start: Start,
    spectrum: Spectrum,
    /// Step levels of [`Self::apply`].
    levels: Arc<[u8]>,
    observer: Waiting<'a>,
    /// Number of periods that have been integrated.
    pub runs: usize,
}

/// Where an integration ends.
struct Target {
    /// Elapsed time, s.
    end: f64,
    /// Number of periods up to there.
    count: u64,
}

impl PeriodMap<'_> {
    /// The linear motion ż = A z.
    pub fn linear(&self) -> &ModalStateSpace {
        &self.setup.linear
    }

    /// Eigenvalues, rad/s, of the modes of the complete linear motion that the run leaves out: those that remain after each
    /// mode of the run is given the closest one. Of a large model, the modes of its components are those of the run, and the
    /// lowest modes of the complete model that grow remain where no mode of the run is close.
    ///
    /// # Errors
    /// [`AnalysisError`] if the modes cannot be computed.
    pub fn omitted_eigenvalues(&self) -> Result<Vec<Complex<f64>>, AnalysisError> {
        let (linear, speed) = (&self.setup.linear, self.options.fastest());
        let at_speed = self.cached.at_speed(speed)?;
        let kept = linear.eigenvalues();
        if linear.modes >= at_speed.model.len() {
            return Ok(Vec::new());
        }
        if !is_large(&at_speed.model) {
            return Ok(without_closest(at_speed.linear(speed)?.eigenvalues(), &kept));
        }
        let pair = |value: Complex<f64>| if value.im == 0.0 { vec![value] } else { vec![value, value.conj()] };
        let growing = growing_modes(self.cached, speed)?;
        let is_known =
            |value: &Complex<f64>| kept.iter().any(|own| (own - value).norm() <= SAME_MODE_TOLERANCE * value.norm());
        Ok(growing.into_iter().filter(|value| !is_known(value)).flat_map(pair).collect())
    }

    /// Period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Relative tolerance of the options.
    pub fn tolerance(&self) -> f64 {
        self.options.tolerance()
    }

    /// The initial state of the options.
    pub fn initial(&self) -> Vec<f64> {
        in_modal_coordinates(self.cached, &self.setup.linear, &self.setup.loads, &self.start).y
    }

    /// The state z of displacements and velocities at the beginning of a period.
    pub fn modal(&self, y: &[f64]) -> Vec<f64> {
        let state = State { y: y.to_vec(), elapsed: self.start.state.elapsed, ..State::new(Vec::new()) };
        let start = Start { state, resumes: false, ..self.start.clone() };
        in_modal_coordinates(self.cached, &self.setup.linear, &self.setup.loads, &start).y
    }

    /// Displacements and velocities of a state z at the beginning of a period.
    pub fn physical(&self, z: Vec<f64>) -> Vec<f64> {
        let state = State { elapsed: self.start.state.elapsed, ..State::new(z) };
        in_physical_coordinates(state, &self.setup.linear, &self.setup.loads).y
    }

    /// Whether the map is affine in z: all loads are, and no flank changes its contact.
    pub fn is_affine(&self) -> bool {
        let loads = &self.setup.loads;
        loads.is_affine() && !loads.motion.flanks_can_separate() && !loads.motion.motion_changes_contact_modes()
    }

    /// Energy norm of the motion of a state z about the equilibrium, at least the level of round-off.
    ///
    /// # Errors
    /// [`AnalysisError`] where the loads are not defined.
    pub fn size(&mut self, z: &[f64]) -> Result<f64, AnalysisError> {
        let begin = self.start.state.elapsed;
        let norm = self.stepper.clone().energy_norm(begin, z);
        let norm = norm.map_err(|halt| self.explained(&Halted { halt, elapsed: begin }))?;
        Ok(norm.max(self.start.floor))
    }

    /// Where a difference of two states is largest: shaft, position and coordinate. Displacements and rotations count by their
    /// velocities' kinetic energy, √Mᵢᵢ |qᵢ|.
    pub fn place_of(&self, difference: &[f64]) -> String {
        let (model, (q, _)) = (&self.cached.model, self.setup.linear.motion(difference));
        let mut unit = vec![0.0; q.len()];
        let mut size = |index: usize| {
            unit[index] = 1.0;
            let size = model.kinetic_form(&unit).sqrt() * q[index].abs();
            unit[index] = 0.0;
            size
        };
        let sizes = model.numbering.dofs().iter().map(|dof| (size(dof.index), dof));
        let Some((_, dof)) = sizes.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            return String::new();
        };
        let (name, position) = model.scene.place(dof.node);
        format!("most at \"{name}\", {position} m, coordinate {}", dof.name())
    }

    /// Announces the completed part of the solution, at which Ctrl-C is checked too.
    pub fn report(&mut self, done: f64) {
        self.observer.done = done;
    }

    /// State after one period, with the step levels of the last [`Self::adapt`].
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn apply(&mut self, z: &[f64]) -> Result<Vec<f64>, AnalysisError> {
        let control = LevelControl::Planned { levels: Arc::clone(&self.levels), solve_rtol: STAGE_SOLVE_RTOL };
        let mut stepper = self.stepper.clone();
        Ok(self.follow_period(&mut stepper, control, z)?.y)
    }

    /// State after one period with steps that meet the tolerance, whose levels are kept.
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn adapt(&mut self, z: &[f64]) -> Result<Vec<f64>, AnalysisError> {
        self.adapt_to(z, self.tolerance())
    }

    /// The same for a relative tolerance `rtol` in place of that of the options.
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn adapt_to(&mut self, z: &[f64], rtol: f64) -> Result<Vec<f64>, AnalysisError> {
        let mut stepper = self.stepper.clone();
        stepper.levels = Some(vec![0; self.steps as usize]);
        let state = self.follow_period(&mut stepper, self.control(rtol), z)?;
        self.levels = stepper.levels.unwrap_or_default().into();
        Ok(state.y)
    }

    /// Step levels of [`Self::apply`].
    pub fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// Sets the step levels of [`Self::apply`]. The period is divided into one longest step for each.
    pub fn plan(&mut self, levels: &[u8]) {
        if levels.len() != self.levels.len() {
            self.steps = levels.len() as u64;
            self.time_grid.longest = self.period / self.steps as f64;
            self.stepper = stepper(self.cached, self.options, &self.setup, self.time_grid);
        }
        self.levels = levels.into();
    }

    /// Makes the step levels of [`Self::apply`] fine enough for the motion from another state too.
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn refine(&mut self, z: &[f64]) -> Result<(), AnalysisError> {
        let before = Arc::clone(&self.levels);
        self.adapt(z)?;
        self.levels = self.levels.iter().zip(before.iter()).map(|(new, before)| *new.max(before)).collect();
        Ok(())
    }

    /// State after `count` periods from the begin of the period of number `first` on, where it is z, with steps that meet the
    /// relative tolerance `rtol`. Without a common period, the map depends on the number.
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn periods_from(&mut self, first: i64, count: u64, z: &[f64], rtol: f64) -> Result<Vec<f64>, AnalysisError> {
        let mut stepper = self.stepper.clone();
        let elapsed =
            self.start.state.elapsed + first as f64 * self.time_grid.time(self.steps * self.time_grid.units(0));
        let state = State { elapsed, ..State::new(z.to_vec()) };
        let (control, end) = (self.control(rtol), self.end(elapsed, count));
        Ok(self.follow(&mut stepper, control, state, Target { end, count })?.y)
    }

    /// Integrates over one period.
    fn follow_period(
        &mut self,
        stepper: &mut Stepper<'_>,
        control: LevelControl,
        z: &[f64],
    ) -> Result<State, AnalysisError> {
        let state = self.state(z);
        let end = self.end(state.elapsed, 1);
        self.follow(stepper, control, state, Target { end, count: 1 })
    }

    /// Integrates up to a target.
    fn follow(
        &mut self,
        stepper: &mut Stepper<'_>,
        control: LevelControl,
        mut state: State,
        Target { end, count }: Target,
    ) -> Result<State, AnalysisError> {
        let mut output = self.setup.output.clone();
        let outcome =
            integrate(stepper, &mut output, control, &mut state, end, &mut self.observer, &mut Statistics::new());
        outcome.map_err(|halted| self.explained(&halted))?;
        self.runs += count as usize;
        Ok(state)
    }

    fn explained(&self, halted: &Halted) -> AnalysisError {
        explain(self.cached, halted, self.start.rotation.origin)
    }

    /// The state of an integration from z on.
    fn state(&self, z: &[f64]) -> State {
        State { elapsed: self.start.state.elapsed, ..State::new(z.to_vec()) }
    }

    /// Elapsed time up to which a number of periods is integrated, s. A quarter of a unit after the last step, so that
    /// round-off does not exclude this step.
    fn end(&self, begin: f64, count: u64) -> f64 {
        begin + self.time_grid.time(count * self.steps * self.time_grid.units(0)) + 0.25 * self.time_grid.unit()
    }

    /// Steps that meet the tolerance, or fixed ones if the options ask for them.
    fn control(&self, rtol: f64) -> LevelControl {
        match self.options.step {
            Some(_) => LevelControl::Fixed,
            None => LevelControl::Adaptive { rtol, floor: self.start.floor, force_error: None },
        }
    }
}

/// The stepper of a set-up on a time grid.
fn stepper<'a>(cached: &RunModel<'_>, options: &Options, setup: &ModalSetup<'a>, time_grid: TimeGrid) -> Stepper<'a> {
    let ModalSetup { linear, loads, maps, .. } = setup;
    Stepper::new(loads.clone(), propagators(cached, options, linear, maps.clone(), time_grid, loads.spins()))
}

/// The eigenvalues of `all` that remain after each one of `kept` has taken the closest one; closest pairs come first.
fn without_closest(all: Vec<Complex<f64>>, kept: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::with_capacity(all.len() * kept.len());
    for (i, value) in all.iter().enumerate() {
        pairs.extend(kept.iter().enumerate().map(|(j, own)| ((own - value).norm(), i, j)));
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut taken, mut placed) = (vec![false; all.len()], vec![false; kept.len()]);
    for (_, i, j) in pairs {
        if !taken[i] && !placed[j] {
            (taken[i], placed[j]) = (true, true);
        }
    }
    all.into_iter().zip(taken).filter(|(_, taken)| !taken).map(|(value, _)| value).collect()
}
