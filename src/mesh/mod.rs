//! A pair of gears in mesh: involute geometry that follows the centres, and the force between the flanks.

mod coupling;
mod involute;

pub use coupling::{Contact, Coordinates, Coupling, Geometry, MeshState};
pub use involute::{Centres, Involute, LineOfAction, Overlap};
