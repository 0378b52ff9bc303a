//! State-space models in modal coordinates.
//!
//! - `first_order`: the first-order matrix. `eigenpairs`: its eigenvalues with real eigenvectors. `eigenvectors`: the
//!   eigenvectors of damped modes.
//! - `rigid_body`: positions of undamped rigid-body motions. `pairs`: decoupled pairs of real coordinates.
//! - `model`: the state-space model at one speed, and which modes grow.
//! - `projected`: the model in a subspace of the displacements.

mod eigenpairs;
mod eigenvectors;
mod first_order;
mod model;
mod pairs;
mod projected;
mod rigid_body;

pub(in crate::modal) use eigenvectors::Eigenvectors;
pub use eigenvectors::{damped, physical, undamped};
pub use first_order::FirstOrder;
pub use model::{MAX_CONDITION, ModalStateSpace, StateMatrix, is_growing};
pub use pairs::ModePair;
pub use projected::Projected;
