//! Why an analysis has no answer.

use thiserror::Error;

use crate::linalg::DecompositionError;
use crate::mesh::Overlap;
use crate::scene::SceneError;

/// An analysis that has no answer.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AnalysisError {
    /// The scene, or an option, does not allow it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A step above the stability limit, or a run that diverged.
    #[error("{0}")]
    Stability(String),
    /// Base circles overlap.
    #[error("{0}")]
    Contact(String),
    /// An iteration did not converge.
    #[error("{0}")]
    Convergence(String),
    /// The analysis was asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl AnalysisError {
    /// Base circles of the mesh `driver`–`driven` overlap, `when` it was.
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
