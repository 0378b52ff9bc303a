//! What a run is asked to do, and the state that it leaves.

use super::Checkpoint;
use crate::exponential::MAX_STAGES;
use crate::integrate::State;
use crate::mesh::Geometry;
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
                let message = format!("must be \"exponential\", \"rk4\" or \"rk45\", got \"{name}\"");
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
    /// Tolerance of an adaptive method.
    pub rtol: f64,
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
    /// Checks what does not depend on the scene.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let duration = EntryPath::root("duration").non_negative(self.duration)?;
        let start = EntryPath::root("start").finite(self.start)?;
        self.speed.check(start, start + duration)?;
        if let Some(step) = self.step {
            EntryPath::root("step").positive(step)?;
            if self.method == Method::Rk45 {
                let message = format!("\"{}\" chooses its own steps; give rtol", self.method.name());
                return Err(SceneError::new("step", message));
            }
        }
        let exponential = matches!(self.method, Method::Exponential | Method::ExactRk4);
        for (name, given, most) in [("stages", self.stages, MAX_STAGES), ("modes", self.modes, usize::MAX)] {
            let Some(count) = given else { continue };
            if !exponential {
                return Err(SceneError::new(name, format!("\"{}\" has none; see \"exponential\"", self.method.name())));
            }
            if count == 0 || count > most {
                let range = if most < usize::MAX { format!("1 to {most}") } else { "at least 1".to_owned() };
                return Err(SceneError::new(name, format!("must be {range}, got {count}")));
            }
        }
        if !(self.rtol > 0.0 && self.rtol < 1.0) {
            return Err(SceneError::new("rtol", format!("must lie between 0 and 1, got {}", self.rtol)));
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

    /// Whether loads are found one after the other, not together.
    pub(super) fn is_explicit(&self) -> bool {
        self.method == Method::ExactRk4
    }

    /// What makes a run of this method the same run.
    fn setting(&self) -> f64 {
        match self.method {
            Method::Rk4 | Method::ExactRk4 => self.step.unwrap_or(0.0),
            Method::Rk45 => self.rtol,
            Method::Exponential => self.step.unwrap_or(-self.rtol),
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
