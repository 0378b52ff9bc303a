//! A pair of gears in mesh: involute geometry for moving centres, and the force between the flanks.

mod contact;
mod contact_path;
mod error;
mod flank;
mod gear_mesh;
mod helix;
mod involute;
mod mean;
pub mod stiffness;

pub use contact::{Contact, ContactMode, Flank, MeshState, ShaftPhase};
pub use contact_path::ContactPath;
pub use gear_mesh::{Directions, GearMesh, Geometry, MeshCoordinates, MeshPose, RelativeMotion};
pub use helix::{Helix, HelixForces};
pub use involute::{Centres, Involute, LineOfAction, Overlap};
