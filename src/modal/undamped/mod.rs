//! Undamped modes at rest, and what follows from M and K alone.
//!
//! - `real`: all modes, and the motions without deflection. `pins`: springs that constrain these motions.
//! - `components`: modes of a large model from those of its components. `load_modes`: the modes that given loads excite.
//! - `kept_modes`: the modes that a run keeps, with the residual flexibility of the others.
//! - `spectral_range`: the lowest and the highest frequency. `modal_damping`: the damping of modes.
//! - `speed_couplings`: gyroscopic and circulatory forces as a few couplings.

mod components;
mod kept_modes;
mod load_modes;
mod modal_damping;
mod pins;
mod real;
mod spectral_range;
mod speed_couplings;

pub use components::ComponentModes;
pub use kept_modes::{Extent, SubspaceKey, kept_modes};
pub use load_modes::modes_of_loads;
pub use modal_damping::{DampedMotions, ModalDamping};
pub use pins::Pins;
pub use real::{RealModes, null_motions, times};
pub use spectral_range::{ShiftInverse, SpectralRange, UndampedInverse};
pub use speed_couplings::{CoupledMotion, CouplingChoice, SpeedCoupling, speed_couplings};
