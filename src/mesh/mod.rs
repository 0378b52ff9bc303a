//! A pair of gears in mesh: involute geometry for moving centres, and the force between the flanks.

mod contact;
mod contact_path;
mod error;
mod flank;
mod gear_mesh;
mod helix;
mod involute;
mod mean;
mod pose;
pub mod stiffness;

pub use contact::{Contact, ContactMode, Flank, HelixForces, MeshState, ShaftPhase};
pub use contact_path::ContactPath;
pub use gear_mesh::GearMesh;
pub use helix::Helix;
pub use involute::{Centres, Involute, LineOfAction, Overlap};
pub use mean::TeethAtAngle;
pub use pose::{Directions, Geometry, MeshCoordinates, MeshPose, RelativeMotion};
