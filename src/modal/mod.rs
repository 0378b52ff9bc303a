//! Modal analysis: undamped modes, damped modes at a given speed, and modal state-space models.
//!
//! - `undamped`: undamped modes at rest, and what follows from M and K alone.
//! - `equilibrium`: the static equilibrium; `forces` at rest, the `clearance` of nonlinear bearings, and `refusals`.
//! - `state_space`: state-space models in modal coordinates.
//! - `lowest`: a few modes of a large model.
//! - `cache`: a model with all that follows from it, which a system with other loads shares.
//! - `damped`: damped modes at a speed.
//!
//! Each folder uses only those before it.

mod cache;
mod damped;
mod equilibrium;
mod lowest;
mod state_space;
mod undamped;

pub use cache::{AtSpeed, CachedModel, DynamicKey, DynamicStiffnessSolver, EquationForces, Recent, Solved};
pub use damped::{
    CriticalProblem, MIN_CORRELATION, Mode, NullVectors, Residual, Residuals, Whirl, damping_ratio, modes, modes_of,
    residual, structured_modes, whirl,
};
pub use equilibrium::{EquilibriumChange, EquilibriumError, EquilibriumSpeeds, equilibrium, equilibrium_residuals};
pub use lowest::{
    CriticalInverse, CriticalSpace, Eigenpair, FullEquations, Highest, MAX_DENSE, MIN_BANDED, ModeAtSpeed,
    ModeSelection, ModeSpace, ReducedMode, Unknown, add_stiffness_change, ascending, lowest_critical, mode_near,
    reduced_modes, vibrates,
};
pub use state_space::{MAX_CONDITION, ModalStateSpace, ModePair, Projected, StateMatrix, is_growing};
pub use undamped::{
    ComponentModes, CoupledMotion, CouplingChoice, DampedMotions, Extent, ModalDamping, Pins, RealModes, SpectralRange,
    SpeedCoupling, SubspaceKey, null_motions, speed_couplings,
};
