//! Time between two reports of the progress of a run. A report asks whether the run continues.

use std::time::{Duration, Instant};

use crate::integrate::{Halt, Observer, Trajectory};

/// Interval between two reports.
const INTERVAL: Duration = Duration::from_millis(50);

/// Reports the completed fraction of a run at intervals.
pub(super) struct Heartbeat<'a> {
    /// Takes the completed fraction; returns whether to continue.
    pub watch: &'a mut dyn FnMut(f64) -> bool,
    /// Time of the last report; none before the first.
    last: Option<Instant>,
}

impl<'a> Heartbeat<'a> {
    /// The first report follows at once.
    pub fn starting(watch: &'a mut dyn FnMut(f64) -> bool) -> Self {
        Self { watch, last: None }
    }

    /// The first report follows after an interval.
    pub fn waiting(watch: &'a mut dyn FnMut(f64) -> bool) -> Self {
        Self { watch, last: now() }
    }

    /// Reports the completed fraction if it is time; returns whether to continue.
    pub fn continues(&mut self, done: impl FnOnce() -> f64) -> bool {
        if self.last.is_some_and(|last| last.elapsed() < INTERVAL) {
            return true;
        }
        self.last = now();
        (self.watch)(done())
    }
}

/// The time; none on WebAssembly, which has no clock: a run reports after every step there.
fn now() -> Option<Instant> {
    if cfg!(target_family = "wasm") { None } else { Some(Instant::now()) }
}

/// An observer that only asks whether to continue.
pub(super) struct Waiting<'a> {
    pub heartbeat: Heartbeat<'a>,
    /// Completed part of the work that is reported.
    pub done: f64,
}

impl<'a> Waiting<'a> {
    /// Nothing is completed yet.
    pub fn new(watch: &'a mut dyn FnMut(f64) -> bool) -> Self {
        Self { heartbeat: Heartbeat::waiting(watch), done: 0.0 }
    }
}

impl Observer for Waiting<'_> {
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
