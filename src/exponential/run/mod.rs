//! A run: the loop over steps.
//!
//! - `driver`: the loop. `level_control`: the choice of the step length.
//! - `contact_monitor`, `contact_change`: candidates for contact changes within a step, and their location.

mod contact_change;
mod contact_monitor;
mod driver;
mod level_control;

pub use driver::run;
pub use level_control::{LevelControl, STAGE_SOLVE_RTOL};
