//! A run: the loop over steps.
//!
//! - `driver`: the loop. `level_control`: the choice of the step length.
//! - `contact_monitor`, `contact_change`: candidates for contact changes within a step, and their location.
//! - `in_modes`: the same equation for Runge–Kutta methods.

mod contact_change;
mod contact_monitor;
mod driver;
mod in_modes;
mod level_control;

pub use driver::run;
pub use in_modes::InModes;
pub use level_control::{LevelControl, STAGE_SOLVE_RTOL};
