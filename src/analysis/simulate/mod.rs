//! The motion in time: initial state, method, what is recorded, and what stopped a run.

mod audit;
mod events;
mod initial;
mod options;
mod record;
mod request;

use std::time::{Duration, Instant};

pub use events::{Event, Kind};
pub use options::{Final, Initial, Method, Options};
pub use record::{MESH_FIELDS, Record, fields};
pub use request::{Plan, Point, Request};

use super::{AnalysisError, Spectrum};
use crate::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use crate::integrate::{Adaptive, Control, Halt, Halted, Observer, RungeKutta, Span, Statistics, run};
use crate::modal::Basis;
use crate::motion::Motion;
use record::Recorder;

/// How often a run asks whether to go on.
const HEARTBEAT: Duration = Duration::from_millis(50);

/// A response.
#[derive(Clone, Debug)]
pub struct Response {
    /// What was recorded.
    pub record: Record,
    /// The state to continue from.
    pub last: Final,
    /// What it cost.
    pub statistics: Statistics,
    /// The fastest motion of the scene.
    pub spectrum: Spectrum,
    /// What set the length of most steps.
    pub limited_by: crate::integrate::Limit,
}

/// A run that stopped early, with what it had computed.
#[derive(Clone, Debug)]
pub struct Stopped {
    /// Why.
    pub error: AnalysisError,
    /// What there is, if the run had begun.
    pub response: Option<Box<Response>>,
}

impl<E: Into<AnalysisError>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self { error: error.into(), response: None }
    }
}

/// Simulates; `watch` is called with the part done at most every 50 ms and says whether to go on.
///
/// # Errors
/// [`Stopped`], with what was computed until then.
pub fn simulate(
    basis: &Basis,
    options: &Options,
    plan: &Plan,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Response, Stopped> {
    options.check()?;
    let spectrum = Spectrum::new(basis, options.speed)?;
    let start = initial::start(basis, options)?;
    let origin = start.origin;
    let equilibrium = start.equilibrium;
    let mut motion = Motion::new(basis, options.geometry, options.speed, origin, equilibrium)?;
    let mut state = start.state;
    let end = options.start + options.duration - origin;
    let mut observer = Watcher {
        recorder: Recorder::new(motion.clone(), plan, &options.times, origin, options.start - origin),
        watch,
        span: (options.start - origin, end),
        asked: Instant::now() - HEARTBEAT,
    };
    let mut statistics = Statistics::new();
    let outcome = match options.method {
        Method::Rk4 => {
            let control = Control::Fixed(fixed_step(basis, options, &spectrum)?);
            let mut method = RungeKutta::new(RK4, 2 * basis.model.len());
            run(&mut motion, &mut method, &control, &mut state, end, &mut observer, &mut statistics)
        }
        Method::Rk45 => {
            let longest = spectrum.longest_step(&DORMAND_PRINCE).min(options.duration.max(f64::MIN_POSITIVE));
            let control = Control::Adaptive(Adaptive { rtol: options.rtol, floor: start.floor, longest });
            let mut method = RungeKutta::new(DORMAND_PRINCE, 2 * basis.model.len());
            run(&mut motion, &mut method, &control, &mut state, end, &mut observer, &mut statistics)
        }
    };
    let response = Response {
        record: observer.recorder.finish(),
        last: options.last(origin, state),
        limited_by: limited_by(options.method, &statistics),
        statistics,
        spectrum,
    };
    match outcome {
        Ok(()) => Ok(response),
        Err(halted) => Err(Stopped { error: explain(basis, &halted, origin), response: Some(Box::new(response)) }),
    }
}

/// The step of a method with a fixed one: what was asked for, if it is stable, or one that resolves ω_max.
fn fixed_step(basis: &Basis, options: &Options, spectrum: &Spectrum) -> Result<f64, AnalysisError> {
    let Some(step) = options.step else {
        return Ok(1.0 / spectrum.radius());
    };
    check_step(basis, step, spectrum, &RK4)?;
    Ok(step)
}

/// A step above the limit is refused before the run: at hω = 2.83 the growth takes thousands of steps to show.
fn check_step<const S: usize>(
    basis: &Basis,
    step: f64,
    spectrum: &Spectrum,
    tableau: &Tableau<S>,
) -> Result<(), AnalysisError> {
    let limit = spectrum.longest_step(tableau);
    if step <= limit {
        return Ok(());
    }
    let (shaft, x, length) = basis.model.scene.shortest_element();
    Err(AnalysisError::Stability(format!(
        "step: {step:e} s is above the stability limit of {limit:.4e} s: omega_max is {:.4e} rad/s (damping {:.3e} 1/s); the shortest element is {length:.3e} m long, on shaft \"{shaft}\" at {x} m",
        spectrum.omega_max, spectrum.damping
    )))
}

fn limited_by(method: Method, statistics: &Statistics) -> crate::integrate::Limit {
    use crate::integrate::Limit;
    match method {
        Method::Rk4 => Limit::Step,
        Method::Rk45 if 2 * statistics.at_limit >= statistics.steps => Limit::Stability,
        Method::Rk45 => Limit::Tolerance,
    }
}

fn explain(basis: &Basis, halted: &Halted, origin: f64) -> AnalysisError {
    let time = origin + halted.elapsed;
    match halted.halt {
        Halt::Overlap { mesh, overlap } => {
            let [driver, driven] = basis.model.gear_names(mesh);
            AnalysisError::overlap(driver, driven, &format!("at {time} s"), overlap)
        }
        Halt::Diverged => AnalysisError::Stability(format!("the motion diverged after {time} s")),
        Halt::Interrupted => AnalysisError::Interrupted(time),
    }
}

/// Records what the plan asks for, and asks now and then whether to go on.
struct Watcher<'a, 'm> {
    recorder: Recorder<'a, 'm>,
    watch: &'a mut dyn FnMut(f64) -> bool,
    span: (f64, f64),
    asked: Instant,
}

impl Observer for Watcher<'_, '_> {
    fn next(&self) -> Option<f64> {
        self.recorder.next()
    }

    fn sees_every_step(&self) -> bool {
        self.recorder.sees_every_step()
    }

    fn observe(&mut self, span: &Span<'_>, end: f64) -> Result<(), Halt> {
        self.recorder.observe(span, end)
    }

    fn switched(&mut self, elapsed: f64, y: &[f64], laws: &[i64]) {
        self.recorder.switched(elapsed, y, laws);
    }

    fn go_on(&mut self, elapsed: f64) -> bool {
        if self.asked.elapsed() < HEARTBEAT {
            return true;
        }
        self.asked = Instant::now();
        let (start, end) = self.span;
        let done = if end > start { ((elapsed - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        (self.watch)(done)
    }
}
