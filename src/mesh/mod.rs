//! A pair of gears in mesh: involute geometry that follows the centres, and the force between the flanks.

mod contact;
mod coupling;
mod error;
mod flank;
mod involute;
mod mean;
pub mod stiffness;

pub use contact::{Contact, Flank, Law, MeshState, Turning};
pub use coupling::{Coordinates, Coupling, Geometry, Pose, Relative};
pub use involute::{Centres, Involute, LineOfAction, Overlap};
