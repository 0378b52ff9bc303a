//! Modes: undamped, the basis of everything linear, and damped at speed, with the names of their whirl.

mod complex;
mod linear;
mod pairs;
mod quadratic;
mod real;
mod whirl;

pub use complex::{Mode, modes, whirl};
pub use linear::{Form, LANES, Linear, WORST};
pub use pairs::Pair;
pub use quadratic::{OnLine, Quadratic};
pub use real::{Basis, RealModes};
pub use whirl::Whirl;
