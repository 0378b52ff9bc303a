//! The equation of motion as a system to integrate, in physical coordinates.
//!
//! `equation` is the equation of motion, `first_order` its evaluation for Runge–Kutta methods, `rotating_load` has bow,
//! unbalance and forces that turn with a shaft, `energy` the energies, and `power` the powers of the energy audit. `speed`
//! is the prescribed speed; `shaft_rotation` and `phase` give the shaft angles.

mod energy;
mod equation;
mod first_order;
mod frame;
mod phase;
mod power;
mod rotating_load;
mod shaft_rotation;
mod speed;

pub use energy::{Energies, connected_coordinates};
pub use equation::EquationOfMotion;
pub use phase::{DoubleDouble, phasor};
pub use power::{CONSTANT_LOAD_SUMS, PowerCoordinates, PowerLoads, SourceTerms};
pub use rotating_load::RotatingLoad;
pub use shaft_rotation::{Anchor, RotationState, ShaftRotation};
pub use speed::{Profile, Speed};
