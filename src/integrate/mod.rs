//! Explicit Runge–Kutta integration, hand-written for systems whose right-hand side knows its own energy.
//!
//! Tableau (data), step (machinery), controller, interpolation, driver and statistics stand apart. Nothing here knows
//! of shafts or gears: a [`FirstOrderSystem`] gives derivatives and norms. A step allocates nothing.

mod controller;
mod driver;
mod interpolate;
mod statistics;
mod step;
mod system;
pub mod tableau;

pub use controller::{Adaptive, StepControl};
pub use driver::{CHECK_INTERVAL, Halted, State, run};
pub use interpolate::{Span, Trajectory, at_each};
pub use statistics::{Statistics, StepLimit};
pub use step::RungeKutta;
pub use system::{FirstOrderSystem, Halt, Observer};
