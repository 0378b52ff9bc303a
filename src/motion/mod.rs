//! The equation of motion as a system to integrate, in physical coordinates.

mod energy;
mod equation;
mod phase;

pub use energy::{Energies, SOURCES};
pub use equation::Motion;
pub use phase::phase;
