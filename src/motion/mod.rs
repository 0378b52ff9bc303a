//! The equation of motion as a system to integrate, in physical coordinates.

mod course;
mod energy;
mod equation;
mod interface;
mod phase;
mod speed;

pub use course::{Anchor, Course};
pub use energy::{Energies, SOURCES};
pub use equation::Motion;
pub use interface::{Hold, Interface};
pub use phase::{Twofold, phase};
pub use speed::{Profile, Speed};
