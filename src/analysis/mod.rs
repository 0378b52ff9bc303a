//! What is asked of a model: modes over the speed, critical speeds, equilibrium, synchronous response, motion.

mod campbell;
mod caution;
mod critical;
mod equilibrium;
mod error;
mod peaks;
pub mod simulate;
mod stability;
mod synchronous;

pub use campbell::{Campbell, Line, Meeting, Source, campbell, lines};
pub use caution::{beyond, conditioning};
pub use critical::{Critical, critical_speeds};
pub use equilibrium::equilibrium;
pub use error::AnalysisError;
pub use peaks::{Peak, Probe, peaks};
pub use stability::Spectrum;
pub use synchronous::{Part, bearing_forces, bow, synchronous};
