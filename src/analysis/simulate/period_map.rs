//! The period map: the state at the end of one period of the excitation, as a function of the state at its beginning.
//!
//! The state is z of the modal coordinates in which a run integrates. The time grid divides the period into equal longest
//! steps, so that the period ends with a step. [`PeriodMap::adapt`] chooses the step levels within each of them by the
//! tolerance; [`PeriodMap::apply`] repeats these levels from other states, so that its result is a smooth function of the
//! state as far as the loads are.

use std::sync::Arc;

use nalgebra::Complex;

use super::exponential::{countable_grid, propagators};
use super::initial::{Start, start};
use super::modal_setup::{ModalSetup, in_modal_coordinates, in_physical_coordinates};
use super::options::is_large;
use super::record::Recorder;
use super::reduction::Reduction;
use super::run_cache::RunModel;
use super::{
    Heartbeat, Options, RecordPlan, Response, Run, RunObserver, System, explain, foreign_contact_modes, limited_by,
    motion, of_run, reduced_setup, tolerance,
};
use crate::analysis::instability::growing_modes;
use crate::analysis::{AnalysisError, Spectrum};
use crate::exponential::{LevelControl, STAGE_SOLVE_RTOL, Stepper, TimeGrid, run as integrate};
use crate::integrate::{Halt, Halted, Observer, State, Statistics, Trajectory};
use crate::modal::{ModalStateSpace, RealModes};

/// Duration of the run that a reduction to fewer modes is chosen for, in periods: about as many as a solution takes.
const EXPECTED_PERIODS: f64 = 10.0;

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
    observer: PeriodObserver<'a>,
    /// Number of periods that have been integrated.
    pub runs: usize,
}

/// Calls `solve` with the period map of a system; `options.duration` is the period, s.
///
/// # Errors
/// [`AnalysisError`] of the set-up, or of `solve`.
pub fn with_period_map<T>(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
    solve: impl for<'a> FnOnce(&mut PeriodMap<'a>) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    let several = several_periods(options);
    let run = MapRun { options: &several, period: options.duration };
    with_map_of(system, options, plan, run, watch, solve)
}

/// The modes that the runs of a period map keep, for runs at other speeds and of other systems with the same coordinates, and
/// the reduction to them; none if they keep all modes.
///
/// # Errors
/// [`AnalysisError`] of the set-up.
pub fn kept_modes(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<(Arc<RealModes>, Reduction)>, AnalysisError> {
    let several = several_periods(options);
    options.check()?;
    system.model.check_speed(options.fastest())?;
    let cached = &of_run(system, options)?;
    let spectrum = Spectrum::new(cached, options.fastest())?;
    let start = start(cached, &several, &spectrum, watch)?;
    let end = start.state.elapsed + several.duration;
    let run = Run { cached, base: None, options: &several, spectrum: &spectrum, floor: start.floor, end };
    let mut observer = PeriodObserver { heartbeat: Heartbeat::waiting(watch), done: 0.0 };
    let known = reduced_setup::kept_modes(&run, &start, plan, &mut observer)?;
    Ok(known.map(|known| (Arc::new(known.projected.modes.clone()), known.reduction)))
}

/// The options of the run that a reduction to fewer modes is chosen for.
fn several_periods(options: &Options) -> Options {
    Options { duration: EXPECTED_PERIODS * options.duration, ..options.clone() }
}

/// Calls `solve` with the map over parts of the length `part`, s, of a motion of `options.duration`, s.
///
/// # Errors
/// [`AnalysisError`] of the set-up, or of `solve`.
pub fn with_part_map<T>(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    part: f64,
    watch: &mut dyn FnMut(f64) -> bool,
    solve: impl for<'a> FnOnce(&mut PeriodMap<'a>) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    with_map_of(system, options, plan, MapRun { options, period: part }, watch, solve)
}

/// The run whose modes the map has.
struct MapRun<'a> {
    options: &'a Options,
    /// Period of the map, s.
    period: f64,
}

/// Where an integration ends.
struct Target {
    /// Elapsed time, s.
    end: f64,
    /// Number of periods up to there.
    count: u64,
}

/// Calls `solve` with the map over the period of a run.
fn with_map_of<T>(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    MapRun { options: several, period }: MapRun<'_>,
    watch: &mut dyn FnMut(f64) -> bool,
    solve: impl for<'a> FnOnce(&mut PeriodMap<'a>) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    options.check()?;
    for speed in options.speed.magnitudes() {
        system.model.check_speed(speed)?;
    }
    let cached = &of_run(system, options)?;
    let spectrum = Spectrum::new(cached, options.fastest())?;
    let start = start(cached, several, &spectrum, watch)?;
    let motion = motion(cached, options, plan, &start)?;
    if !motion.accepts_contact_modes(&start.state.contact_modes) {
        return Err(foreign_contact_modes(&start).into());
    }
    let end = start.state.elapsed + several.duration;
    let run = Run { cached, base: None, options: several, spectrum: &spectrum, floor: start.floor, end };
    let mut observer = PeriodObserver { heartbeat: Heartbeat::waiting(watch), done: 0.0 };
    let (setup, reduction) = reduced_setup::set_up(&run, motion.clone(), &start, plan, &mut observer)?;
    let setup = if setup.linear.includes_meshes {
        setup
    } else {
        // Without the meshes every shaft rotates freely, and the modes say little about the period map.
        let complete = cached.at_speed(options.fastest())?.projected(options.fastest())?;
        run.complete(motion, &start, plan, Some(&complete))?
    };
    if setup.linear.is_parallel() {
        let message = format!(
            "the modes are nearly parallel (condition number {:.1e}), as at critical damping; change the damping slightly, or run in with simulate()",
            setup.linear.condition
        );
        return Err(AnalysisError::Convergence(message));
    }
    let grid = countable_grid(cached, several, &setup.linear, &setup.loads, end)?;
    let steps = (period / grid.longest).ceil().max(1.0);
    let time_grid = TimeGrid { longest: period / steps, ..grid };
    let spins = setup.loads.spins();
    let cache = propagators(cached, options, &setup.linear, setup.maps.clone(), time_grid, spins);
    let stepper = Stepper::new(setup.loads.clone(), cache);
    let levels = vec![0; steps as usize].into();
    let mut map = PeriodMap {
        cached,
        options,
        plan,
        period,
        setup,
        reduction,
        stepper,
        time_grid,
        steps: steps as u64,
        start,
        spectrum,
        levels,
        observer,
        runs: 0,
    };
    solve(&mut map)
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
            let (linear, maps, loads) = (&self.setup.linear, self.setup.maps.clone(), &self.setup.loads);
            let cache = propagators(self.cached, self.options, linear, maps, self.time_grid, loads.spins());
            self.stepper = Stepper::new(loads.clone(), cache);
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

    /// The recorded motion of `count` periods from a state z, with steps that meet the tolerance, whose levels are kept.
    /// Returns the state at the end too.
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn record(&mut self, count: u64, z: &[f64], samples: usize) -> Result<(Response, Vec<f64>), AnalysisError> {
        let (origin, begin) = (self.start.rotation.origin, self.start.state.elapsed);
        let (end, duration) = (self.end(begin, count), self.period * count as f64);
        let times: Vec<f64> =
            (0..samples).map(|sample| origin + begin + duration * sample as f64 / samples as f64).collect();
        let motion = self.setup.loads.motion.clone();
        let tolerance = tolerance(self.options, &motion);
        let mut stepper = self.stepper.clone();
        stepper.levels = Some(vec![0; self.steps as usize]);
        let mut output = self.setup.output.clone();
        let (mut state, mut statistics) = (self.state(z), Statistics::new());
        let control = self.control(self.tolerance());
        let done = self.observer.done;
        let mut watch = |_| (self.observer.heartbeat.watch)(done);
        let mut observer = RunObserver {
            recorder: Recorder::new(motion, self.plan, &times, origin, begin, tolerance),
            heartbeat: Heartbeat::waiting(&mut watch),
            start: begin,
            end,
        };
        let outcome = integrate(&mut stepper, &mut output, control, &mut state, end, &mut observer, &mut statistics);
        let (record, recorder_state) = observer.recorder.finish();
        outcome.map_err(|halted| explain(self.cached, &halted, origin))?;
        self.runs += count as usize;
        self.levels = stepper.levels.take().unwrap_or_default().into();
        let last = state.y.clone();
        let state = in_physical_coordinates(state, &self.setup.linear, &self.setup.loads);
        let response = Response {
            record,
            recorder_state,
            last: self.options.last(&self.start.rotation, origin + begin + duration, state),
            limited_by: limited_by(self.options, None, &statistics),
            statistics,
            spectrum: self.spectrum,
            condition: Some(self.setup.linear.condition),
            reduction: self.reduction,
        };
        Ok((response, last))
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

/// An observer that only asks whether to continue.
struct PeriodObserver<'a> {
    heartbeat: Heartbeat<'a>,
    /// Completed part of the solution.
    done: f64,
}

impl Observer for PeriodObserver<'_> {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _motion: &mut impl Trajectory, _end: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn continues(&mut self, _elapsed: f64) -> bool {
        let done = self.done;
        self.heartbeat.continues(|| done)
    }
}
