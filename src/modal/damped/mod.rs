//! Damped modes at a speed, and responses that need no modes.
//!
//! - `modes`: the modes. `whirl`: their direction. `residual`: the force that they leave in the equations of motion.
//! - `quadratic`: the eigenvalue problem as a function of frequency and speed.
//! - `rotating_response`: the response to a rotating force with modal damping.

mod modes;
mod quadratic;
mod residual;
mod rotating_response;
mod whirl;

pub use modes::{Mode, modes, structured_modes, whirl};
pub use quadratic::Quadratic;
pub use residual::{Forces, Residual, Residuals, residual};
pub use rotating_response::{RotatingResponse, Solved};
pub use whirl::Whirl;
