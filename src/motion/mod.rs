//! The equation of motion as a system to integrate, in physical coordinates.

mod energy;
mod equation;
mod first_order;
mod phase;
mod power;
mod rotating_load;
mod shaft_rotation;
mod speed;

pub use energy::{Energies, connected_coordinates};
pub use equation::EquationOfMotion;
pub use phase::{DoubleDouble, phasor};
pub use power::{PowerCoordinates, PowerLoads, SOURCES};
pub use rotating_load::RotatingLoad;
pub use shaft_rotation::{Anchor, RotationState, ShaftRotation};
pub use speed::{Profile, Speed};
