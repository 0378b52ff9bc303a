//! The exponential method: exact for the linear motion, Gauss collocation for the loads.
//!
//! The equation is ż = A z + Σ b p(t, w z). The linear part A is propagated exactly in the modes at speed. It contains the
//! shafts, the bearings with constant coefficients and the linear part of the other connections: the mean stiffness of
//! meshes, unless flanks can separate, and the coefficients of bearings at one speed or at their operating point. The
//! remainder of the connections is a few scalar loads p, which depend on a few interface scalars w z. Over a step, the
//! loads are the polynomial through Gauss nodes (Hochbruck and Ostermann 2005), so that the loads set the step length and
//! not the shortest element.
//!
//! If flanks can separate, the linear part contains no mesh and consists of independent parts.
//!
//! Time is an integer count of units. A step is a power of two of units and starts at a multiple of its length or at a
//! contact change, so that the propagators of a few lengths serve all steps.
//!
//! - `propagator`: the linear motion of a step, and what follows from the step length alone.
//! - `loads`: the loads on this motion.
//! - `step`: one step.
//! - `within_step`: the motion within a step, and what observers read of it.
//! - `run`: the loop over steps.
//!
//! Each folder uses only those before it.

mod loads;
mod propagator;
mod run;
mod step;
mod within_step;

pub use loads::{Loads, SpeedChange, is_resonant};
pub use propagator::{InterfaceMaps, MAX_STAGES, PropagatorCache, PropagatorKey, QuadratureRule, TimeGrid, phi};
pub use run::{InModes, LevelControl, STAGE_SOLVE_RTOL, run};
pub use step::Stepper;
pub use within_step::{INSTANT_BATCH, MAX_WAITING, OutputMap, Selection};
