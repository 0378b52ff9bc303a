//! One step: the loads at its stages, the state at its end, and its error.
//!
//! - `stepper`: the sequence of a step. `context`: the data that all steps share.
//! - `stages`: the interface at the ends and at the stages of a step.
//! - `solve`: the stage equations, with the correction of `tangent_solver` and the factorisations of `small_lu`.
//! - `estimate`: the error.

mod context;
mod estimate;
mod small_lu;
mod solve;
mod stages;
mod stepper;
mod tangent_solver;

pub use context::{StepInstant, StepSpan};
pub use stepper::{DefectScratch, Outcome, Stepper};
