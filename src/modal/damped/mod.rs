//! Damped modes at a speed.
//!
//! - `modes`: the modes. `whirl`: their direction. `residual`: the force that they leave in the equations of motion.
//! - `critical_problem`: the undamped critical speeds of a small model.

mod critical_problem;
mod modes;
mod null_vectors;
mod residual;
mod structural;
mod whirl;

pub use critical_problem::CriticalProblem;
pub use modes::{Mode, damping_ratio, modes, modes_of, structured_modes, whirl};
pub use null_vectors::NullVectors;
pub use residual::{Residual, Residuals, residual};
pub use structural::MIN_CORRELATION;
pub use whirl::Whirl;
