//! Errors of an analysis.

use thiserror::Error;

use crate::linalg::DecompositionError;
use crate::mesh::Overlap;
use crate::scene::SceneError;

/// The reason why an analysis has no result.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AnalysisError {
    /// The scene or an option is invalid for the analysis.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The step exceeds the stability limit, or the run diverged.
    #[error("{0}")]
    Stability(String),
    /// The base circles of a mesh overlap.
    #[error("{0}")]
    Contact(String),
    /// An iteration did not converge.
    #[error("{0}")]
    Convergence(String),
    /// The caller requested the analysis to stop.
    #[error("interrupted")]
    Interrupted,
}

impl AnalysisError {
    /// Creates the error for overlapping base circles of the mesh `driver`–`driven`; `when` describes the state.
    pub fn overlap(driver: &str, driven: &str, when: &str, overlap: Overlap) -> Self {
        let Overlap { distance, base_circles } = overlap;
        Self::Contact(format!(
            "mesh \"{driver}\"-\"{driven}\": the base circles overlap {when}: the centres are {distance:.9} m apart, the base radii add up to {base_circles:.9} m"
        ))
    }
}

impl From<DecompositionError> for AnalysisError {
    fn from(error: DecompositionError) -> Self {
        Self::Convergence(error.to_string())
    }
}
