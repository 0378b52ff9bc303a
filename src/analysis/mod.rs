//! What is asked of a model: equilibrium, synchronous response, motion.

mod caution;
mod equilibrium;
mod error;
pub mod simulate;
mod stability;
mod synchronous;

pub use caution::{beyond, conditioning};
pub use equilibrium::equilibrium;
pub use error::AnalysisError;
pub use stability::Spectrum;
pub use synchronous::synchronous;
