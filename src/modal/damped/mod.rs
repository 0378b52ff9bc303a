//! Damped modes at a speed.
//!
//! - `modes`: the modes. `whirl`: their direction. `residual`: the force that they leave in the equations of motion.
//! - `quadratic`: the eigenvalue problem as a function of frequency and speed.

mod modes;
mod null_vectors;
mod quadratic;
mod residual;
mod structural;
mod whirl;

pub use modes::{Mode, modes, modes_of, structured_modes, whirl};
pub use null_vectors::NullVectors;
pub use quadratic::Quadratic;
pub use residual::{Residual, Residuals, residual};
pub use whirl::Whirl;
