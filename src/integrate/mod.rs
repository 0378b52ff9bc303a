//! Explicit Runge–Kutta integration of a [`FirstOrderSystem`], which gives its derivative and its error norm.
//!
//! `tableau` holds the coefficients, `step` takes one step, `controller` chooses its length, `driver` is the loop over
//! steps, `event_locator` finds contact changes, `interpolate` gives the motion within a step. A step allocates no memory. `state` is the state between steps of every method, `statistics` counts the
//! steps. An [`Observer`] (`system`) reads each step as a [`Trajectory`].

mod controller;
mod driver;
mod event_locator;
mod interpolate;
mod state;
mod statistics;
mod step;
mod system;
pub mod tableau;

pub use controller::{Adaptive, StepControl};
pub use driver::{CHECK_INTERVAL, Halted, run};
pub use event_locator::MAX_CHANGES_AT_ONE_TIME;
pub use interpolate::{Deferred, Span, StepEnd, Trajectory, at_each};
pub use state::{ExponentialState, ForceVariation, MethodState, State, StepHistory};
pub use statistics::{Statistics, StepLimit};
pub use step::{RungeKutta, StepInterval};
pub use system::{FirstOrderSystem, Halt, Observer};
