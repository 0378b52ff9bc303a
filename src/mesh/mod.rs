//! A pair of gears in mesh: involute geometry for moving centres, and the force between the flanks.
//!
//! - Geometry: `involute` (deflection of the moving centres, its gradient, contact ratio), `contact_path` (the path of
//!   contact and the tooth pairs on it), `helix` (axial displacements and tilts), `error` (transmission error).
//! - Force: `pose` (coordinates and relative motion of the gears), `flank` (one flank), `gear_mesh` (both flanks),
//!   `contact` (the flank in contact), `friction` (across the line of action), `mean` (mean stiffness, for linear analyses).
//! - [`stiffness`]: one file for each model of the stiffness.

mod contact;
mod contact_path;
mod error;
mod flank;
mod friction;
mod gear_mesh;
mod helix;
mod involute;
mod mean;
mod pose;
pub mod stiffness;

pub use contact::{Contact, ContactMode, Flank, HelixForces, MeshState, ShaftPhase};
pub use contact_path::ContactPath;
pub use friction::{Friction, FrictionForce, FrictionSums};
pub use gear_mesh::GearMesh;
pub use helix::Helix;
pub use involute::{Centres, Involute, LineOfAction, Overlap};
pub use mean::{MeshLoss, TeethAtAngle};
pub use pose::{Directions, Geometry, MeshCoordinates, MeshPose, RelativeMotion};
