//! Undamped modes at rest, and what follows from M and K alone.
//!
//! - `real`: all modes, and the motions without deflection. `pins`: springs that constrain these motions.
//! - `components`: modes of a large model from those of its components. `load_modes`: the modes that given loads excite.
//! - `kept_modes`: the modes that a run keeps, with the residual flexibility of the others.
//! - `spectral_range`: the lowest and the highest frequency. `modal_damping`: the damping of modes.
//! - `gyroscopic`: the gyroscopic matrix as a few couplings.

mod components;
mod gyroscopic;
mod kept_modes;
mod load_modes;
mod modal_damping;
mod pins;
mod real;
mod spectral_range;

pub use components::ComponentModes;
pub use gyroscopic::{GyroscopicPair, gyroscopic_pairs};
pub use kept_modes::{Extent, SubspaceKey, kept_modes};
pub use load_modes::modes_of_loads;
pub use modal_damping::ModalDamping;
pub use pins::Pins;
pub use real::{RealModes, null_motions, times};
pub use spectral_range::{ShiftInverse, SpectralRange, mass_times};
