//! What a run cost.

/// What set the length of most steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepLimit {
    /// The step that was asked for.
    Step,
    /// The stability limit of the method.
    Stability,
    /// The tolerance.
    Tolerance,
    /// The longest step that resolves the cycle of what is prescribed.
    Cycle,
    /// Changes of law, which steps end at.
    Events,
}

impl StepLimit {
    /// The name that users read.
    pub fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Stability => "stability",
            Self::Tolerance => "tolerance",
            Self::Cycle => "cycle",
            Self::Events => "events",
        }
    }
}

/// Counts and extremes of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Steps taken.
    pub steps: u64,
    /// Steps tried and rejected.
    pub rejected: u64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
    /// Changes of law that a step was made to end at.
    pub events: u64,
    /// Steps whose length the stability limit set.
    pub at_limit: u64,
    /// Shortest step, s.
    pub shortest: f64,
    /// Longest step, s.
    pub longest: f64,
}

impl Statistics {
    /// Nothing done yet.
    pub fn new() -> Self {
        Self { steps: 0, rejected: 0, evaluations: 0, events: 0, at_limit: 0, shortest: f64::INFINITY, longest: 0.0 }
    }

    /// Counts the evaluations that a run begins with; one that was paused has counted them already.
    pub fn begin(&mut self, evaluations: u64) {
        self.evaluations = self.evaluations.max(evaluations);
    }

    /// Counts a step.
    pub fn accept(&mut self, step: f64, at_limit: bool) {
        self.steps += 1;
        self.at_limit += u64::from(at_limit);
        self.shortest = self.shortest.min(step);
        self.longest = self.longest.max(step);
    }
}

impl Default for Statistics {
    fn default() -> Self {
        Self::new()
    }
}
