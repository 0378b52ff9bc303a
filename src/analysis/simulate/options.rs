//! What a run is asked to do, and the state that it leaves.

use crate::integrate::State;
use crate::mesh::Geometry;
use crate::scene::{Path, SceneError};

/// The integration method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Classical Runge–Kutta with a fixed step.
    Rk4,
    /// Dormand–Prince 5(4) with error control.
    Rk45,
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
            _ => Err(SceneError::new("method", format!("must be \"rk4\" or \"rk45\", got \"{name}\""))),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Rk45 => "rk45",
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
    /// Where another run ended.
    Continue(Final),
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
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
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
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
    /// Method.
    pub method: Method,
    /// Fixed step, s; one that resolves the fastest motion if not given.
    pub step: Option<f64>,
    /// Tolerance of an adaptive method.
    pub rtol: f64,
    /// Where it begins.
    pub initial: Initial,
    /// Times at which to record, ascending, s.
    pub times: Vec<f64>,
    /// Whether the line of action follows the centres.
    pub geometry: Geometry,
    /// Time at which it begins, s.
    pub start: f64,
}

impl Options {
    /// Checks what does not depend on the scene.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let duration = Path::root("duration").non_negative(self.duration)?;
        Path::root("speed").finite(self.speed)?;
        let start = Path::root("start").finite(self.start)?;
        if let Some(step) = self.step {
            Path::root("step").positive(step)?;
            if self.method != Method::Rk4 {
                let message = format!("\"{}\" chooses its own steps; give rtol", self.method.name());
                return Err(SceneError::new("step", message));
            }
        }
        if !(self.rtol > 0.0 && self.rtol < 1.0) {
            return Err(SceneError::new("rtol", format!("must lie between 0 and 1, got {}", self.rtol)));
        }
        let slack = f64::EPSILON * 4.0 * (start.abs() + duration);
        for (index, time) in self.times.iter().enumerate() {
            let at = Path::root("times").index(index);
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

    /// What makes a run of this method the same run.
    fn setting(&self) -> f64 {
        match self.method {
            Method::Rk4 => self.step.unwrap_or(0.0),
            Method::Rk45 => self.rtol,
        }
    }

    /// The state that a run with these options leaves.
    pub(super) fn last(&self, origin: f64, state: State) -> Final {
        Final {
            method: self.method,
            time: self.start + self.duration,
            origin,
            speed: self.speed,
            geometry: self.geometry,
            setting: self.setting(),
            state,
        }
    }

    /// Whether the run goes on exactly as the one that left `last`.
    pub(super) fn resumes(&self, last: &Final) -> bool {
        self.method == last.method && self.setting() == last.setting
    }
}

impl Final {
    fn check(&self, options: &Options) -> Result<(), SceneError> {
        let initial = |message: String| SceneError::new("initial", message);
        if self.speed != options.speed {
            let message = format!("ended at {} rad/s and cannot continue at {} rad/s", self.speed, options.speed);
            return Err(initial(message));
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
