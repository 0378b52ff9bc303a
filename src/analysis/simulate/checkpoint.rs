//! Where a run was stopped, so that the same run goes on as if it had not been: beside the state that it left, what it
//! has counted and seen. Everything else follows from the options again.

use crate::integrate::{State, Statistics};

/// Contact ratio of a mesh less one, tip clearance and involute clearance in metres, with the elapsed time at which they
/// were seen.
pub type Margins = (f64, [f64; 3]);

/// What a recorder has seen.
#[derive(Clone, Debug, PartialEq)]
pub struct RecorderState {
    /// EventRecorder so far.
    pub events: usize,
    /// What every mesh was last seen with.
    pub margins: Vec<Option<Margins>>,
    /// Works of [`SOURCES`](crate::motion::SOURCES) since the start, J; zero where energy is not recorded.
    pub works: [f64; 6],
    /// Elapsed time up to which they count, s.
    pub until: f64,
}

/// Where a run was stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The state that it left.
    pub state: State,
    /// What it had cost.
    pub statistics: Statistics,
    /// What it had seen.
    pub recorder_state: RecorderState,
}
