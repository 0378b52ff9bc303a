//! The motion within a completed step, and what observers read of it.
//!
//! - `substep`: the state at instants within a step.
//! - `trajectory`: a completed step. `output`: displacements and velocities; accelerations and other `combinations`;
//!   scalars of the motion (`state_map`).

mod combinations;
mod output;
mod state_map;
mod substep;
mod trajectory;

pub use output::{INSTANT_BATCH, MAX_WAITING, OutputMap, Selection};
pub use substep::SubstepSampler;
pub use trajectory::{CompletedStep, StepTrajectory};
