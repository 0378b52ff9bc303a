//! What a run is asked to do, and the state that it leaves.

use super::Checkpoint;
use crate::analysis::Dense;
use crate::exponential::MOST_STAGES;
use crate::integrate::State;
use crate::mesh::Geometry;
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
    /// Exact where the motion is linear, the classical Runge–Kutta method where it is not: ETDRK4.
    ExactRk4,
    /// Exact where the motion is linear, Gauss collocation of the mesh forces.
    Exponential,
}

impl Method {
    /// The method of this name.
    ///
    /// # Errors
    /// [`SceneError`] for a name that is none.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        match name {
            "rk4" => Ok(Self::Rk4),
            "rk45" => Ok(Self::Rk45),
            "exponential" => Ok(Self::Exponential),
            "etdrk4" => Ok(Self::ExactRk4),
            _ => {
                let message = format!("must be \"exponential\", \"rk45\", \"rk4\" or \"etdrk4\", got \"{name}\"");
                Err(SceneError::new("method", message))
            }
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Rk45 => "rk45",
            Self::Exponential => "exponential",
            Self::ExactRk4 => "etdrk4",
        }
    }
}

/// The tolerance where none is given.
const DEFAULT_RTOL: f64 = 1e-6;
/// The smallest tolerance that round-off leaves to a step.
const SMALLEST_RTOL: f64 = 1e-13;

/// Where a run begins.
#[derive(Clone, Debug, PartialEq)]
pub enum Initial {
    /// Static equilibrium plus the linear synchronous response: the shortest transient.
    Synchronous,
    /// Static equilibrium, no velocity.
    Static,
    /// q = q̇ = 0.
    Rest,
    /// Where another run ended, at its speed or at another one.
    Continue(Box<Final>),
}

/// The state a run leaves, to continue from.
#[derive(Clone, Debug, PartialEq)]
pub struct Final {
    /// The method that left it.
    pub method: Method,
    /// Time at which the run ended, s.
    pub time: f64,
    /// Time at which the run began, or the run that it continued, s.
    pub origin: f64,
    /// Speed of the reference shaft.
    pub speed: Speed,
    /// A known angle of the reference shaft.
    pub anchor: Anchor,
    /// Whether the line of action followed the centres.
    pub geometry: Geometry,
    /// The fixed step, or the tolerance.
    pub setting: f64,
    /// State of the integration, at the last step before `time`.
    pub state: State,
}

/// All options of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// How long, s.
    pub duration: f64,
    /// Speed of the reference shaft.
    pub speed: Speed,
    /// Method.
    pub method: Method,
    /// Fixed step, s; one that resolves the fastest motion if not given.
    pub step: Option<f64>,
    /// Tolerance of a method that chooses its steps; 1e-6 if not given.
    pub rtol: Option<f64>,
    /// Gauss nodes of the exponential method; 3 if not given.
    pub stages: Option<usize>,
    /// Modes that the exponential method keeps; all if not given.
    pub modes: Option<usize>,
    /// Where it begins.
    pub initial: Initial,
    /// Times at which to record, ascending, s.
    pub times: Vec<f64>,
    /// Whether the line of action follows the centres.
    pub geometry: Geometry,
    /// Time at which it begins, s.
    pub start: f64,
    /// Where the same run was stopped, to go on from there; `times` are then those that it had still to record.
    pub checkpoint: Option<Box<Checkpoint>>,
}

impl Options {
    /// Whether the damped modes carry the linear motion. Where the speed changes, the modes do too, and modal damping is
    /// a matrix over all displacements.
    pub(super) fn in_modes(&self, model: &Model) -> bool {
        let modal = model.scene.modal_damping > 0.0 && matches!(self.speed, Speed::Constant(_));
        modal || matches!(self.method, Method::Exponential | Method::ExactRk4)
    }

    /// The dense matrices that the run needs.
    pub fn dense(&self, model: &Model) -> Dense {
        if self.in_modes(model) { Dense::Damped } else { Dense::Undamped }
    }

    /// Checks what does not depend on the scene.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let duration = EntryPath::root("duration").non_negative(self.duration)?;
        let start = EntryPath::root("start").finite(self.start)?;
        self.speed.check(start, start + duration)?;
        self.check_method()?;
        if let Some(step) = self.step {
            EntryPath::root("step").positive(step)?;
        }
        for (name, given, most) in [("stages", self.stages, MOST_STAGES), ("modes", self.modes, usize::MAX)] {
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
            let at = EntryPath::root("times").index(index);
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

    /// Every option that is given must be one of the method.
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

    /// The tolerance of the run: that of the options, the default, or the smallest that round-off leaves to a step.
    pub fn tolerance(&self) -> f64 {
        self.rtol.unwrap_or(DEFAULT_RTOL).max(SMALLEST_RTOL)
    }

    /// What to warn of where the tolerance that was asked for cannot be met.
    pub fn unattainable(&self) -> Option<String> {
        let rtol = self.rtol.filter(|rtol| *rtol > 0.0 && *rtol < SMALLEST_RTOL)?;
        Some(format!("rtol: {rtol:e} is below what round-off leaves to a step; taken as {SMALLEST_RTOL:e}"))
    }

    /// Whether loads are found one after the other, not together.
    pub(super) fn is_explicit(&self) -> bool {
        self.method == Method::ExactRk4
    }

    /// What makes a run of this method the same run.
    fn setting(&self) -> f64 {
        match self.method {
            Method::Rk4 | Method::ExactRk4 => self.step.unwrap_or(0.0),
            Method::Rk45 => self.tolerance(),
            Method::Exponential => self.step.unwrap_or(-self.tolerance()),
        }
    }

    /// The largest speed, with the sign that it has in the run: see [`Speed::fastest`].
    pub fn fastest(&self) -> f64 {
        self.speed.fastest(self.start, self.start + self.duration)
    }

    /// The state that a run with these options leaves at `time`.
    pub(super) fn last(&self, course: &ShaftRotation, time: f64, state: State) -> Final {
        Final {
            method: self.method,
            time,
            origin: course.origin,
            speed: self.speed.clone(),
            anchor: course.anchor,
            geometry: self.geometry,
            setting: self.setting(),
            state,
        }
    }

    /// Whether the run, at the same speed, goes on exactly as the one that left `last`.
    pub(super) fn resumes(&self, last: &Final) -> bool {
        self.method == last.method && self.setting() == last.setting
    }
}

impl Final {
    /// How the reference shaft turned, from the time `origin` on.
    pub(super) fn course(&self, origin: f64) -> ShaftRotation {
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
