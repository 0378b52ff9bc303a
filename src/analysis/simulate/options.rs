//! Options of a run, and the final state that it leaves.

use std::sync::Arc;

use super::Checkpoint;
use crate::analysis::Dense;
use crate::exponential::MAX_STAGES;
use crate::integrate::State;
use crate::mesh::Geometry;
use crate::modal::RealModes;
use crate::model::Model;
use crate::motion::{Anchor, ShaftRotation, Speed};
use crate::scene::{EntryPath, SceneError};

/// The integration method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Classical Runge–Kutta with a fixed step.
    Rk4,
    /// Dormand–Prince 5(4) with error control.
    Rk45,
    /// ETDRK4: exact for the linear motion, explicit Runge–Kutta for the mesh forces.
    ExactRk4,
    /// Exact for the linear motion, Gauss collocation for the mesh forces.
    Exponential,
}

impl Method {
    /// The method of this name.
    ///
    /// # Errors
    /// [`SceneError`] for an unknown name.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        let all = [Self::Rk4, Self::Rk45, Self::ExactRk4, Self::Exponential];
        all.into_iter().find(|method| method.name() == name).ok_or_else(|| {
            let message = format!("must be \"exponential\", \"rk45\", \"rk4\" or \"etdrk4\", got \"{name}\"");
            SceneError::new("method", message)
        })
    }

    /// Name in the Python package.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Rk45 => "rk45",
            Self::Exponential => "exponential",
            Self::ExactRk4 => "etdrk4",
        }
    }
}

/// Smallest number of coordinates of a model that a reduction builds from the modes of its components.
const LARGE_MODEL: usize = 250;
/// Default relative tolerance.
const DEFAULT_RTOL: f64 = 1e-6;
/// Smallest relative tolerance: the round-off of a step.
const SMALLEST_RTOL: f64 = 1e-13;

/// The initial state of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Initial {
    /// Static equilibrium plus the linear synchronous response, which gives the shortest transient.
    Synchronous,
    /// Static equilibrium, no velocity.
    Static,
    /// q = q̇ = 0.
    Rest,
    /// The final state of another run, at its speed or at another one.
    Continue(Box<Final>),
}

/// The final state of a run, from which another run can continue.
#[derive(Clone, Debug, PartialEq)]
pub struct Final {
    /// The method that left it.
    pub method: Method,
    /// Time at which the run ended, s.
    pub time: f64,
    /// Time at which the run began, or the first of the runs that it continued, s.
    pub origin: f64,
    /// Speed of the reference shaft.
    pub speed: Speed,
    /// A known angle of the reference shaft.
    pub anchor: Anchor,
    /// Whether the line of action followed the centres.
    pub geometry: Geometry,
    /// How the method chose its steps.
    pub setting: StepSetting,
    /// State of the integration at the last step before `time`.
    pub state: State,
}

/// How a method chooses its steps. A run continues bit by bit only with the same setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepSetting {
    /// The default fixed step of the method.
    DefaultStep,
    /// A fixed step, s.
    Step(f64),
    /// Error control with this relative tolerance.
    Tolerance(f64),
}

impl StepSetting {
    /// The setting as one number, as a final state stores it: the step, zero for the default step, or the tolerance with a
    /// minus sign. `"rk45"`, which has no fixed step, stores its tolerance without the sign.
    pub fn number(self, method: Method) -> f64 {
        match self {
            Self::DefaultStep => 0.0,
            Self::Step(step) => step,
            Self::Tolerance(rtol) if method == Method::Rk45 => rtol,
            Self::Tolerance(rtol) => -rtol,
        }
    }

    /// Reads a stored number.
    pub fn from_number(number: f64, method: Method) -> Self {
        match method {
            Method::Rk45 => Self::Tolerance(number),
            _ if number < 0.0 => Self::Tolerance(-number),
            _ if number > 0.0 => Self::Step(number),
            _ => Self::DefaultStep,
        }
    }
}

/// All options of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Duration, s.
    pub duration: f64,
    /// Speed of the reference shaft.
    pub speed: Speed,
    /// Integration method.
    pub method: Method,
    /// Fixed step, s; if none, the method chooses.
    pub step: Option<f64>,
    /// Relative tolerance of a method with error control; 1e-6 if none.
    pub rtol: Option<f64>,
    /// Number of stages of the exponential method; 3 if none.
    pub stages: Option<usize>,
    /// Number of modes that the exponential method keeps; if none, `reduction` decides.
    pub modes: Option<usize>,
    /// Largest errors of displacements and of mesh forces that a reduction to fewer modes may cause, as RMS of the
    /// difference over RMS of the variation, at least 2 % of the mean; the run keeps all modes if none.
    pub reduction: Option<[f64; 2]>,
    /// Modes that the run keeps, found by another run of a system with the same coordinates; none where `modes` or `reduction`
    /// decide.
    pub kept_modes: Option<Arc<RealModes>>,
    /// Largest error of mesh forces that a step may cause, in the same unit; none where only `rtol` counts.
    pub force_error: Option<f64>,
    /// Initial state.
    pub initial: Initial,
    /// Output times, ascending, s.
    pub times: Vec<f64>,
    /// Whether the line of action follows the centres.
    pub geometry: Geometry,
    /// Time at which the run begins, s.
    pub start: f64,
    /// Point at which the same run was stopped, to continue from there; `times` are then the remaining output times.
    pub checkpoint: Option<Box<Checkpoint>>,
}

/// Whether a reduction builds a model from the modes of its components.
pub(super) fn is_large(model: &Model) -> bool {
    model.len() >= LARGE_MODEL
}

impl Options {
    /// Whether the run integrates modal coordinates. At a variable speed the modes vary, and modal damping is a matrix
    /// over all displacements.
    pub(super) fn in_modes(&self, model: &Model) -> bool {
        let modal = !model.scene.modal_damping.is_zero() && matches!(self.speed, Speed::Constant(_));
        modal || matches!(self.method, Method::Exponential | Method::ExactRk4)
    }

    /// Whether the run may use a model that is built from the modes of its components.
    pub(super) fn uses_components(&self, model: &Model) -> bool {
        is_large(model) && (self.modes.is_some() || self.reduction.is_some())
    }

    /// The dense matrices that the run needs.
    pub fn dense(&self, model: &Model) -> Dense {
        if self.in_modes(model) { Dense::Damped } else { Dense::Undamped }
    }

    /// Checks all options that do not depend on the scene.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let duration = EntryPath::root("duration").non_negative(self.duration)?;
        let start = EntryPath::root("start").finite(self.start)?;
        self.speed.check(start, start + duration)?;
        self.check_method()?;
        if self.is_explicit() && matches!(self.speed, Speed::Changing(_)) {
            let message = "\"etdrk4\" needs a constant speed; use \"exponential\", \"rk45\" or \"rk4\"";
            return Err(SceneError::new("method", message));
        }
        if let Some(step) = self.step {
            EntryPath::root("step").positive(step)?;
        }
        for (name, given, most) in [("stages", self.stages, MAX_STAGES), ("modes", self.modes, usize::MAX)] {
            if let Some(count) = given.filter(|count| *count == 0 || *count > most) {
                let range = if most < usize::MAX { format!("1 to {most}") } else { "at least 1".to_owned() };
                return Err(SceneError::new(name, format!("must be {range}, got {count}")));
            }
        }
        if let Some(rtol) = self.rtol.filter(|rtol| !(*rtol > 0.0 && *rtol < 1.0)) {
            return Err(SceneError::new("rtol", format!("must lie between 0 and 1, got {rtol}")));
        }
        let slack = f64::EPSILON * 4.0 * (start.abs() + duration);
        for (index, time) in self.times.iter().enumerate() {
            let at = EntryPath::entry("times", index);
            at.finite(*time)?;
            if *time < start - slack || *time > start + duration + slack {
                return Err(at.error(format!("{time} s is outside the run from {start} s to {} s", start + duration)));
            }
            if index > 0 && self.times[index - 1] > *time {
                return Err(at.error("times must ascend"));
            }
        }
        if let Initial::Continue(last) = &self.initial {
            last.check(self)?;
        }
        Ok(())
    }

    /// Refuses options that the method cannot use.
    fn check_method(&self) -> Result<(), SceneError> {
        use Method::{ExactRk4, Exponential, Rk4, Rk45};
        let options: [(&str, bool, &[Method]); 4] = [
            ("step", self.step.is_some(), &[Exponential, Rk4, ExactRk4]),
            ("rtol", self.rtol.is_some(), &[Exponential, Rk45]),
            ("stages", self.stages.is_some(), &[Exponential]),
            ("modes", self.modes.is_some(), &[Exponential, ExactRk4]),
        ];
        for (name, given, methods) in options {
            if given && !methods.contains(&self.method) {
                let users: Vec<String> = methods.iter().map(|method| format!("\"{}\"", method.name())).collect();
                let message =
                    format!("\"{}\" cannot use it; it is an option of {}", self.method.name(), users.join(", "));
                return Err(SceneError::new(name, message));
            }
        }
        if self.step.is_some() && self.rtol.is_some() {
            let message = "cannot be used with a fixed step; leave out rtol, or step for steps of this tolerance";
            return Err(SceneError::new("rtol", message));
        }
        Ok(())
    }

    /// Relative tolerance of the run: the given or the default value, at least the level of round-off of a step.
    pub fn tolerance(&self) -> f64 {
        self.rtol.unwrap_or(DEFAULT_RTOL).max(SMALLEST_RTOL)
    }

    /// Warning if the given tolerance is below the round-off of a step.
    pub fn unattainable(&self) -> Option<String> {
        let rtol = self.rtol.filter(|rtol| *rtol > 0.0 && *rtol < SMALLEST_RTOL)?;
        Some(format!("rtol: {rtol:e} is below what round-off leaves to a step; taken as {SMALLEST_RTOL:e}"))
    }

    /// Whether the stages of the exponential method are explicit.
    pub(super) fn is_explicit(&self) -> bool {
        self.method == Method::ExactRk4
    }

    /// How the method chooses its steps.
    fn setting(&self) -> StepSetting {
        match self.method {
            Method::Rk4 | Method::ExactRk4 => self.step.map_or(StepSetting::DefaultStep, StepSetting::Step),
            Method::Rk45 => StepSetting::Tolerance(self.tolerance()),
            Method::Exponential => self.step.map_or(StepSetting::Tolerance(self.tolerance()), StepSetting::Step),
        }
    }

    /// Speed of the largest magnitude in the run, with its sign, rad/s: see [`Speed::fastest`].
    pub fn fastest(&self) -> f64 {
        self.speed.fastest(self.start, self.start + self.duration)
    }

    /// The state that a run with these options leaves at `time`.
    pub(super) fn last(&self, rotation: &ShaftRotation, time: f64, state: State) -> Final {
        Final {
            method: self.method,
            time,
            origin: rotation.origin,
            speed: self.speed.clone(),
            anchor: rotation.anchor,
            geometry: self.geometry,
            setting: self.setting(),
            state,
        }
    }

    /// Whether a run at the same speed continues the run that left `last` bit by bit.
    pub(super) fn resumes(&self, last: &Final) -> bool {
        self.method == last.method && self.setting() == last.setting
    }
}

impl Final {
    /// Rotation of the reference shaft from the time `origin` on, s.
    pub(super) fn rotation(&self, origin: f64) -> ShaftRotation {
        let fastest = self.speed.fastest(origin, self.time);
        ShaftRotation { speed: self.speed.clone(), anchor: self.anchor, origin, fastest }
    }

    fn check(&self, options: &Options) -> Result<(), SceneError> {
        let initial = |message: String| SceneError::new("initial", message);
        let (speed, next) = (self.speed.at(self.time), options.fastest());
        if speed * next < 0.0 {
            let change = "the teeth would change their flanks";
            return Err(initial(format!("ended at {speed} rad/s and cannot continue at {next} rad/s: {change}")));
        }
        if self.geometry != options.geometry {
            return Err(initial("ran with the other geometry, live or frozen".to_owned()));
        }
        if self.time != options.start {
            return Err(initial(format!("ended at {} s and cannot continue at {} s", self.time, options.start)));
        }
        Ok(())
    }
}
