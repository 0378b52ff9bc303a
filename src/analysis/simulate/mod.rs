//! Time integration: options, initial state, methods, recording, events, energy audit, and the reason of an early stop.
//!
//! - What is asked: `options`, `record_plan`; `initial` is the state at the beginning, `checkpoint` that of a stopped run.
//! - The modes of a run: `reduced_setup` → `reduction` (how many, by `pilot` runs) → `modal_setup`; `ramp` at a changing
//!   speed. `run_cache` keeps what the runs of a system share.
//! - Steps: `exponential`, `heartbeat` (when a run asks whether to continue); `period_map` integrates one period with equal
//!   steps, for the steady state.
//! - What is recorded: `record`, `events`, `audit` with `audit_piece`.

mod audit;
mod audit_piece;
mod checkpoint;
mod events;
mod exponential;
mod heartbeat;
mod initial;
mod modal_setup;
mod options;
mod period_map;
mod pilot;
mod ramp;
mod record;
mod record_plan;
mod reduced_setup;
mod reduction;
mod run_cache;

pub use checkpoint::{Checkpoint, Margins, RecorderState};
pub use events::{Event, EventKind};
pub use exponential::{round_below, sample_step};
pub use options::{Final, Initial, Method, Options, StepSetting};
pub use period_map::kept_modes;
pub(in crate::analysis) use period_map::{PeriodMap, with_part_map, with_period_map};
pub use record::{AxialRecord, Record};
pub use record_plan::{Point, RecordPlan, Request};
pub use reduction::Reduction;
pub use run_cache::System;

use super::{AnalysisError, Spectrum};
use crate::connection::Touch;
use crate::exponential::InModes;
use crate::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use crate::integrate::{
    Adaptive, Deferred, FirstOrderSystem, Halt, Halted, Observer, RungeKutta, State, Statistics, StepControl,
    StepLimit, Trajectory, run,
};
use crate::modal::{CachedModel, MAX_CONDITION};
use crate::motion::{EquationOfMotion, Speed};
use crate::scene::SceneError;
use heartbeat::Heartbeat;
use initial::Start;
use modal_setup::{ModalSetup, in_modal_coordinates, in_physical_coordinates};
use record::Recorder;
use run_cache::RunModel;

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Response {
    /// The recorded motion.
    pub record: Record,
    /// The state to continue from.
    pub last: Final,
    /// State of the recorder, with which a run that was stopped continues.
    pub recorder_state: RecorderState,
    /// Numbers of steps and evaluations.
    pub statistics: Statistics,
    /// Bounds of the fastest motion of the model.
    pub spectrum: Spectrum,
    /// What limited the length of most steps.
    pub limited_by: StepLimit,
    /// Condition number of the modes, if the run used modal coordinates.
    pub condition: Option<f64>,
    /// The reduction of the linear motion, if there is one.
    pub reduction: Option<Reduction>,
}

/// A run that stopped early, with its partial result.
#[derive(Clone, Debug)]
pub struct Stopped {
    /// The reason.
    pub error: AnalysisError,
    /// The result up to then, if the run had begun.
    pub response: Option<Box<Response>>,
}

impl<E: Into<AnalysisError>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self { error: error.into(), response: None }
    }
}

/// Simulates. `watch` receives the completed fraction of the run, at most every 50 ms, and returns whether to continue.
///
/// # Errors
/// [`Stopped`], with the result up to then.
pub fn simulate(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Response, Stopped> {
    options.check()?;
    for speed in options.speed.magnitudes() {
        system.model.check_speed(speed)?;
    }
    let cached = &of_run(system, options)?;
    let spectrum = Spectrum::new(cached, options.fastest())?;
    let start = initial::start(cached, options, &spectrum, watch)?;
    let origin = start.rotation.origin;
    let motion = motion(cached, options, plan, &start)?;
    if !motion.accepts_contact_modes(&start.state.contact_modes) {
        return Err(foreign_contact_modes(&start).into());
    }
    let end = options.start + options.duration - origin;
    let (start_elapsed, tolerance) = (options.start - origin, tolerance(options, &motion));
    let mut observer = RunObserver {
        recorder: Recorder::new(motion.clone(), plan, &options.times, origin, start_elapsed, tolerance),
        heartbeat: Heartbeat::starting(watch),
        start: start_elapsed,
        end,
    };
    let mut statistics = Statistics::new();
    if let Some(checkpoint) = &options.checkpoint {
        statistics = checkpoint.statistics;
        observer.recorder.resume(&checkpoint.recorder_state, &checkpoint.state.contact_modes);
    }
    let base = system.base.as_deref();
    let run = Run { cached, base, options, spectrum: &spectrum, floor: start.floor, end };
    let Ended { state, condition, reduction, outcome } =
        run.integrate(motion, &start, plan, &mut observer, &mut statistics)?;
    // A run that was stopped continues from the state that it reached.
    let reached = if outcome.is_ok() { options.start + options.duration } else { origin + state.elapsed };
    let (record, recorder_state) = observer.recorder.finish();
    let response = Response {
        record,
        recorder_state,
        last: options.last(&start.rotation, reached, state),
        limited_by: limited_by(options, condition, &statistics),
        statistics,
        spectrum,
        condition,
        reduction,
    };
    let Record { displacement, twist, velocity, twist_rate, .. } = &response.record;
    let is_finite = [displacement, twist, velocity, twist_rate].into_iter().flatten().all(|value| value.is_finite());
    match outcome {
        Ok(()) if !is_finite => {
            let message = "the motion has values that are no numbers: look for stiffnesses, dampers or masses of very different size";
            Err(Stopped { error: AnalysisError::Convergence(message.to_owned()), response: Some(Box::new(response)) })
        }
        Ok(()) => Ok(response),
        Err(halted) => Err(Stopped { error: explain(cached, &halted, origin), response: Some(Box::new(response)) }),
    }
}

/// The model of a run. At a constant speed, bearings that depend on it belong to the matrices.
fn of_run<'a>(system: &'a System, options: &Options) -> Result<RunModel<'a>, AnalysisError> {
    system.model.scene.refuse_loss_factors()?;
    system.model.scene.refuse_reduced_pads()?;
    if matches!(options.speed, Speed::Changing(_)) {
        system.model.scene.refuse_turning_frame("run at a changing speed; give a constant speed")?;
    }
    let at_speed = match options.speed {
        Speed::Constant(_) => system.at_speed(options.fastest())?,
        Speed::Changing(_) => system.with_operating_points_of(options.fastest())?,
    };
    Ok(RunModel { at_speed, known: &system.known })
}

/// The equation of motion of a run.
fn motion<'a>(
    cached: &'a CachedModel,
    options: &Options,
    plan: &RecordPlan,
    start: &Start,
) -> Result<EquationOfMotion<'a>, AnalysisError> {
    let mut motion = EquationOfMotion::along(cached, options.geometry, &start.rotation, start.equilibrium.clone());
    if plan.energy || !options.in_modes(&cached.model) {
        motion = motion.with_modal_damping(cached)?;
    }
    if options.method == Method::Exponential {
        motion.join_smooth_pieces();
    }
    Ok(motion)
}

/// Relative tolerance that the motion of a run follows; zero without connections, where it is exact, and with fixed steps.
fn tolerance(options: &Options, motion: &EquationOfMotion<'_>) -> f64 {
    let is_exact = motion.connections().next().is_none();
    let is_fixed = options.step.is_some() || matches!(options.method, Method::Rk4 | Method::ExactRk4);
    if is_exact || is_fixed { 0.0 } else { options.tolerance() }
}

/// The error of an initial state whose contact modes no run of this system leaves.
fn foreign_contact_modes(start: &Start) -> SceneError {
    let count = start.state.contact_modes.len();
    let message = format!("are {count} numbers that this system cannot have left; give the final state of its own run");
    SceneError::new("initial.contact_modes", message)
}

/// What a run leaves.
struct Ended {
    /// The final state, in displacements and velocities.
    state: State,
    /// Condition number of the modes, if the run used modal coordinates.
    condition: Option<f64>,
    /// The reduction of the linear motion, if there is one.
    reduction: Option<Reduction>,
    /// The reason for an early stop.
    outcome: Result<(), Halted>,
}

/// Constants of a run.
struct Run<'a> {
    cached: &'a RunModel<'a>,
    /// The system of which that of this run is a variation.
    base: Option<&'a System>,
    options: &'a Options,
    spectrum: &'a Spectrum,
    /// Smallest energy norm that a tolerance is relative to.
    floor: f64,
    /// Elapsed time at the end, s.
    end: f64,
}

impl Run<'_> {
    /// Integrates in displacements and velocities, or in modal coordinates.
    fn integrate<'m>(
        &self,
        mut motion: EquationOfMotion<'m>,
        start: &Start,
        plan: &RecordPlan,
        observer: &mut impl Observer,
        statistics: &mut Statistics,
    ) -> Result<Ended, AnalysisError>
    where
        Self: 'm,
    {
        let Self { cached, options, .. } = *self;
        let is_exponential = matches!(options.method, Method::Exponential | Method::ExactRk4);
        if !options.in_modes(&cached.model) {
            let mut state = start.state.clone();
            let outcome = self.runge_kutta(&mut motion, &mut state, observer, statistics)?;
            return Ok(Ended { state, condition: None, reduction: None, outcome });
        }
        let (setup, reduction) = reduced_setup::set_up(self, motion, start, plan, observer)?;
        let condition = Some(setup.linear.condition);
        let is_parallel = setup.linear.is_parallel();
        if is_parallel && options.method == Method::ExactRk4 {
            let message = format!(
                "\"etdrk4\" needs modes that are not parallel, and their condition number is {:.1e}; use \"rk45\"",
                setup.linear.condition
            );
            return Err(SceneError::new("method", message).into());
        }
        if is_exponential && !is_parallel {
            let (state, outcome) = exponential::run(cached, options, setup, start, self.end, observer, statistics)?;
            return Ok(Ended { state, condition, reduction, outcome });
        }
        let ModalSetup { linear, loads, maps, output } = setup;
        let mut state = in_modal_coordinates(cached, &linear, &loads, start);
        let mut system = InModes::new(loads, &linear, maps, output);
        let outcome = self.runge_kutta(&mut system, &mut state, observer, statistics)?;
        Ok(Ended { state: in_physical_coordinates(state, &linear, system.loads()), condition, reduction, outcome })
    }

    /// Integrates with a Runge–Kutta method.
    fn runge_kutta(
        &self,
        system: &mut impl FirstOrderSystem,
        state: &mut State,
        observer: &mut impl Observer,
        statistics: &mut Statistics,
    ) -> Result<Result<(), Halted>, AnalysisError> {
        let Self { cached, options, spectrum, floor, end, .. } = *self;
        let len = system.len();
        if options.method == Method::Rk4 {
            let step = fixed_step(cached, options, spectrum)?;
            let begun = state.count as f64 * step;
            if state.elapsed < begun || state.elapsed >= begun + step {
                let message =
                    format!("stands within no step of {step:e} s: the system has changed; give the step of that run");
                return Err(SceneError::new("initial", message).into());
            }
            let control = StepControl::Fixed(step);
            let mut method = RungeKutta::new(RK4, len);
            return Ok(run(system, &mut method, &control, state, end, observer, statistics));
        }
        let longest = spectrum.longest_step(&DORMAND_PRINCE).min(options.duration.max(f64::MIN_POSITIVE));
        let control = StepControl::Adaptive(Adaptive { rtol: options.tolerance(), floor, longest });
        let mut method = RungeKutta::new(DORMAND_PRINCE, len);
        Ok(run(system, &mut method, &control, state, end, observer, statistics))
    }
}

/// The fixed step of `"rk4"`, s: the given one if it is stable, or 1/|λ| of the fastest motion.
fn fixed_step(cached: &CachedModel, options: &Options, spectrum: &Spectrum) -> Result<f64, AnalysisError> {
    let Some(step) = options.step else {
        return Ok(1.0 / spectrum.radius());
    };
    check_step(cached, step, spectrum, &RK4)?;
    Ok(step)
}

/// Refuses a step above the stability limit before the run. Slightly above it, the growth shows only after thousands of
/// steps.
fn check_step<const S: usize>(
    cached: &CachedModel,
    step: f64,
    spectrum: &Spectrum,
    tableau: &Tableau<S>,
) -> Result<(), AnalysisError> {
    let limit = spectrum.longest_step(tableau);
    if step <= limit {
        return Ok(());
    }
    let (shaft, x, length) = cached.model.scene.shortest_element();
    Err(AnalysisError::Stability(format!(
        "step: {step:e} s is above the stability limit of {limit:.4e} s: omega_max is {:.4e} rad/s (damping {:.3e} 1/s); the shortest element is {length:.3e} m long, on shaft \"{shaft}\" at {x} m",
        spectrum.omega_max, spectrum.damping
    )))
}

/// What limited the length of most steps.
fn limited_by(options: &Options, condition: Option<f64>, statistics: &Statistics) -> StepLimit {
    let at_limit = 2 * statistics.at_limit >= statistics.steps;
    let is_parallel = condition.is_some_and(|condition| condition > MAX_CONDITION);
    match options.method {
        Method::Exponential if is_parallel && at_limit => StepLimit::Stability,
        Method::Exponential if is_parallel => StepLimit::Tolerance,
        Method::Rk4 | Method::ExactRk4 => StepLimit::Step,
        Method::Exponential if options.step.is_some() => StepLimit::Step,
        Method::Exponential if at_limit => StepLimit::Cycle,
        Method::Exponential if statistics.events > 0 && 8 * statistics.events >= statistics.steps => StepLimit::Events,
        Method::Rk45 if at_limit => StepLimit::Stability,
        Method::Exponential | Method::Rk45 => StepLimit::Tolerance,
    }
}

/// The error that a stopped run reports.
fn explain(cached: &CachedModel, halted: &Halted, origin: f64) -> AnalysisError {
    let time = origin + halted.elapsed;
    match halted.halt {
        Halt::Overlap { mesh, overlap } => {
            let [driver, driven] = cached.model.gear_names(mesh);
            AnalysisError::overlap(driver, driven, &format!("at {time} s"), overlap)
        }
        Halt::Touch(Touch { bearing, nearness }) => AnalysisError::Contact(format!(
            "bearings[{bearing}]: the journal touches the bearing at {time} s (eccentricity ratio {nearness:.6}); reduce the load or the unbalance, or raise the viscosity, the length or the speed"
        )),
        Halt::Diverged => AnalysisError::Stability(format!("the motion diverged after {time} s")),
        Halt::Interrupted => AnalysisError::Interrupted,
    }
}

/// Records the motion, and asks at intervals whether to continue.
struct RunObserver<'a, 'm> {
    recorder: Recorder<'a, 'm>,
    heartbeat: Heartbeat<'a>,
    /// Elapsed time at the beginning, s.
    start: f64,
    /// Elapsed time at the end, s.
    end: f64,
}

impl Observer for RunObserver<'_, '_> {
    fn next(&self) -> Option<f64> {
        self.recorder.next()
    }

    fn sees_every_step(&self) -> bool {
        self.recorder.sees_every_step()
    }

    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        self.recorder.observe(motion, end)
    }

    fn switched(&mut self, elapsed: f64, read: &mut dyn FnMut(&mut [f64], &mut [f64]), contact_modes: &[i64]) {
        self.recorder.switched(elapsed, read, contact_modes);
    }

    fn deferred(&mut self, quantity: Deferred<'_>) {
        self.recorder.add_deferred(quantity);
    }

    fn continues(&mut self, elapsed: f64) -> bool {
        let Self { start, end, .. } = *self;
        self.heartbeat.continues(|| if end > start { ((elapsed - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 })
    }
}
