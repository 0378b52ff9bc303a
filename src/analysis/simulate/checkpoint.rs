//! Data with which a run that was stopped continues with identical results: the state, the statistics and the state of
//! the recorder. Everything else follows from the options.

use crate::integrate::{State, Statistics};

/// Elapsed time of an evaluation (s), and the contact ratio of a mesh minus one, its tip clearance (m) and its involute
/// clearance (m) then.
pub type Margins = (f64, [f64; 3]);

/// The state of a recorder.
#[derive(Clone, Debug, PartialEq)]
pub struct RecorderState {
    /// Number of events so far.
    pub events: usize,
    /// Last margins of every mesh.
    pub margins: Vec<Option<Margins>>,
    /// Works of [`SOURCES`](crate::motion::SOURCES) since the start, J; zero where energy is not recorded.
    pub works: [f64; 6],
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
