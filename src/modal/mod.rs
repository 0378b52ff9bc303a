//! Modal analysis: undamped modes, damped modes at a given speed, and modal state-space models.
//!
//! Data flow, each file using only those before it: undamped modes (`real`) → first-order matrix in modal coordinates
//! (`first_order`) → its eigenpairs (`eigenpairs`), with the positions of undamped rigid-body motions (`rigid_body`) →
//! decoupled pairs of real coordinates (`pairs`) → state-space model (`state_space`) → cache of all of these per model
//! (`cached`, `recent`), which a system with other loads shares → damped modes (`damped`, `eigenvectors`) with their whirl
//! direction (`whirl`), and the eigenvalue problem as a function of frequency and speed (`quadratic`).
//!
//! - Reduced models: `components` (modes of the parts of a large model), `kept_modes` (which modes a run keeps),
//!   `projected` (the model in them); `gyroscopic` decomposes the gyroscopic matrix for runs at changing speed.
//! - A few modes of a large model: Krylov spaces (`lowest`, `shift_invert`); with strong damping a Galerkin projection
//!   (`lowest_damped`, `galerkin`). `modal_damping` is the damping of undamped modes. `contour` counts the eigenvalues, `bound` bounds them,
//!   `spectral_range` gives the lowest and highest undamped frequency, `load_modes` the modes that given loads excite.
//! - `critical` finds critical speeds, `intersection` a mode at a speed or on a line of the Campbell diagram.
//! - `residual` is the residual of a mode; `growth` decides whether a mode grows.
//! - `equilibrium` is the static equilibrium, with `pins` for null motions and `clearance` for nonlinear bearings;
//!   `dynamic_solver` is the response to harmonic forces.

mod bound;
mod cached;
mod clearance;
mod components;
mod contour;
mod critical;
mod damped;
mod dynamic_solver;
mod eigenpairs;
mod eigenvectors;
mod equilibrium;
mod first_order;
mod galerkin;
mod growth;
mod gyroscopic;
mod intersection;
mod kept_modes;
mod load_modes;
mod lowest;
mod lowest_damped;
mod modal_damping;
mod pairs;
mod pins;
mod projected;
mod quadratic;
mod real;
mod recent;
mod residual;
mod rigid_body;
mod shift_invert;
mod spectral_range;
mod state_space;
mod whirl;

pub use cached::{AtSpeed, CachedModel};
pub use components::ComponentModes;
pub use critical::lowest_critical;
pub use damped::{Mode, modes, structured_modes, whirl};
pub use dynamic_solver::{DynamicKey, DynamicStiffnessSolver, Solved};
pub use equilibrium::{EquilibriumError, EquilibriumSpeeds, equilibrium, equilibrium_residuals};
pub use growth::is_growing;
pub use gyroscopic::{GyroscopicPair, gyroscopic_pairs};
pub use intersection::{ModeAtSpeed, intersection, mode_near};
pub use kept_modes::{Extent, SubspaceKey};
pub use modal_damping::{Highest, ModalDamping};
pub use pairs::ModePair;
pub use pins::Pins;
pub use projected::Projected;
pub use quadratic::Quadratic;
pub use real::{RealModes, null_motions};
pub use recent::Recent;
pub use residual::{Forces, Residual, Residuals, residual};
pub use spectral_range::SpectralRange;
pub use state_space::{LANES, MAX_CONDITION, ModalStateSpace, StateMatrix};
pub use whirl::Whirl;
