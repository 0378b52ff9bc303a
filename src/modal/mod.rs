//! Modes: undamped, the basis of everything linear, and damped at speed, with the names of their whirl.

mod damped;
mod pairs;
mod quadratic;
mod real;
mod state_space;
mod whirl;

pub use damped::{Mode, modes, whirl};
pub use pairs::ModePair;
pub use quadratic::{OnLine, Quadratic};
pub use real::{AtSpeed, CachedModel, RealModes};
pub use state_space::{Form, LANES, ModalStateSpace, WORST};
pub use whirl::Whirl;
