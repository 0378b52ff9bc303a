//! Statistics of a run.

/// What limits the length of most steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepLimit {
    /// A fixed step.
    Step,
    /// The stability limit of the method.
    Stability,
    /// The tolerance.
    Tolerance,
    /// The longest step, which resolves a revolution, a tooth cycle or the slowest mode.
    Cycle,
    /// Contact changes, at which steps end.
    Events,
}

impl StepLimit {
    /// Name in the Python package.
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

/// Numbers of steps and evaluations, and extreme step lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Steps taken.
    pub steps: u64,
    /// Steps tried and rejected.
    pub rejected: u64,
    /// Evaluations of the right-hand side or of the loads.
    pub evaluations: u64,
    /// Contact changes at which a step ended.
    pub events: u64,
    /// Steps of the maximum length.
    pub at_limit: u64,
    /// Shortest step, s.
    pub shortest: f64,
    /// Longest step, s.
    pub longest: f64,
}

impl Statistics {
    /// Statistics before the first step.
    pub fn new() -> Self {
        Self { steps: 0, rejected: 0, evaluations: 0, events: 0, at_limit: 0, shortest: f64::INFINITY, longest: 0.0 }
    }

    /// Counts the evaluations at the beginning of a run, unless the run continues from a checkpoint, which contains them.
    pub fn begin(&mut self, evaluations: u64) {
        self.evaluations = self.evaluations.max(evaluations);
    }

    /// Counts an accepted step of this length, s.
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
