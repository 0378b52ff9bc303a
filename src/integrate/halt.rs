//! The reasons to stop an integration.

use crate::connection::{OutOfRange, Touch};
use crate::mesh::Overlap;

/// Why an integration stopped before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Halt {
    /// The base circles of a mesh overlap, so that its geometry is not defined.
    Overlap {
        /// Index of the mesh.
        mesh: usize,
        /// Radii and distance.
        overlap: Overlap,
    },
    /// A journal touches its bearing.
    Touch(Touch),
    /// The state is not finite, or no step is short enough.
    Diverged,
    /// The observer stopped the run.
    Interrupted,
}

impl Halt {
    /// The reason where a connection has no force; `mesh` is its index, if it is a mesh. Only meshes have base circles.
    pub fn out_of_range(mesh: Option<usize>, reason: OutOfRange) -> Self {
        match reason {
            OutOfRange::Overlap(overlap) => Self::Overlap { mesh: mesh.unwrap_or_default(), overlap },
            OutOfRange::Touch(touch) => Self::Touch(touch),
        }
    }
}
