//! Analyses of a model: Campbell diagram, critical speeds, equilibrium, synchronous response and simulation.

mod assignment;
mod campbell;
mod critical;
mod diagnostics;
mod equilibrium;
mod error;
mod instability;
mod interrupt;
mod memory;
mod modes;
mod peaks;
mod resolution;
mod responses;
pub mod simulate;
mod stability;
pub mod steady;
mod synchronous;

pub use campbell::{Campbell, ExcitationLine, ExcitationSource, Intersection, Threshold, campbell, lines};
pub use critical::{Critical, CriticalPoint, critical_speed_map, critical_speeds, memory_of_critical_speeds};
pub use diagnostics::{ill_conditioning, small_displacement_check};
pub use equilibrium::{equilibrium, equilibrium_residuals};
pub use error::AnalysisError;
pub use instability::unstable_ranges;
pub use interrupt::Interrupt;
pub use memory::{Dense, Kept, product};
pub use modes::{lowest_modes, memory_of_modes};
pub use peaks::{Peak, Probe, peaks};
pub use resolution::{Choice, ElementErrors, Resolved, resolve, resolve_variation};
pub use responses::{Response, Responses, memory_of_responses, synchronous};
pub use stability::Spectrum;
pub use synchronous::{ExcitationPart, SourceResponse, bearing_forces, bow};
