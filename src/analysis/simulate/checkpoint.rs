//! Data with which a run that was stopped continues with identical results: the state, the statistics and the state of
//! the recorder. Everything else follows from the options.

use crate::integrate::{State, Statistics};
use crate::motion::SourceTerms;

/// Margins of the geometry of a mesh at an instant; negative ones are violated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Elapsed time of the evaluation, s.
    pub elapsed: f64,
    /// Contact ratio minus one.
    pub contact_ratio: f64,
    /// Distance between the tips and the opposite roots, m.
    pub tip_clearance: f64,
    /// Distance of the tips from the ends of the involutes, m.
    pub involute_clearance: f64,
}

/// The state of a recorder.
#[derive(Clone, Debug, PartialEq)]
pub struct RecorderState {
    /// Number of events so far.
    pub events: usize,
    /// Last margins of every mesh.
    pub margins: Vec<Option<Margins>>,
    /// Work of every source since the start, J; zero where energy is not recorded.
    pub works: SourceTerms,
    /// Elapsed time up to which the works are integrated, s.
    pub until: f64,
}

/// The point at which a run was stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The state of the integration.
    pub state: State,
    /// The statistics up to then.
    pub statistics: Statistics,
    /// The state of the recorder.
    pub recorder_state: RecorderState,
}
