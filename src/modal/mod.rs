//! Modal analysis: undamped modes, damped modes at a given speed, and modal state-space models.
//!
//! - `undamped`: undamped modes at rest, and what follows from M and K alone.
//! - `equilibrium`: the static equilibrium; `forces` at rest, and the `clearance` of nonlinear bearings.
//! - `state_space`: state-space models in modal coordinates, and the cache of all that follows from a model, which a system
//!   with other loads shares.
//! - `lowest`: a few modes of a large model.
//! - `damped`: damped modes at a speed, and responses that need no modes.
//!
//! Each folder uses only those before it.

mod damped;
mod equilibrium;
mod lowest;
mod state_space;
mod undamped;

pub use damped::{
    Forces, Mode, Quadratic, Residual, Residuals, RotatingResponse, Solved, Whirl, modes, residual, structured_modes,
    whirl,
};
pub use equilibrium::{EquilibriumError, EquilibriumSpeeds, equilibrium, equilibrium_residuals};
pub use lowest::{ModeAtSpeed, intersection, lowest_critical, mode_near};
pub use state_space::{
    AtSpeed, CachedModel, DynamicKey, LANES, MAX_CONDITION, ModalStateSpace, ModePair, Projected, Recent, StateMatrix,
    is_growing,
};
pub use undamped::{
    ComponentModes, Extent, GyroscopicPair, Pins, RealModes, SpectralRange, SubspaceKey, gyroscopic_pairs, null_motions,
};
