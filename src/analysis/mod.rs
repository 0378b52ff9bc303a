//! Analyses of a model: Campbell diagram, critical speeds, equilibrium, synchronous response and simulation.
//!
//! - Before a model: `discretisation` chooses number and degree of the shaft elements.
//! - Linear analyses: `modes`, `campbell` with `assignment` (which modes continue which), `critical`, `equilibrium`,
//!   `frequency_response` to the harmonic `sources`, of which `synchronous` has those of rotating shafts, with
//!   `harmonic_terms` for its derivatives, `own_frequency` (modes where bearings depend on the frequency), `peaks`,
//!   `instability` (speeds at which the motion is unstable), `stability` (step limits of explicit methods); `mass` (mass
//!   properties), `efficiency` (losses of the meshes).
//! - Nonlinear analyses: [`simulate`] integrates in time, [`steady`] finds motions that repeat.
//! - For all of them: `error`, `diagnostics` (warnings about accuracy), `interrupt` (the request to stop), `memory`
//!   (refuses matrices and results that do not fit), `threads` (independent speeds and frequencies on several threads).

mod assignment;
mod campbell;
mod critical;
mod diagnostics;
mod discretisation;
mod efficiency;
mod equilibrium;
mod error;
mod frequency_response;
mod harmonic_terms;
mod instability;
mod interrupt;
mod mass;
mod memory;
mod modes;
mod own_frequency;
mod peaks;
pub mod simulate;
mod sources;
mod stability;
pub mod steady;
mod synchronous;
mod threads;

pub use campbell::{Campbell, ExcitationLine, ExcitationSource, Intersection, Threshold, campbell, lines};
pub use critical::{Critical, CriticalPoint, critical_speed_map, critical_speeds, memory_of_critical_speeds};
pub use diagnostics::{contact_ratio_check, ill_conditioning, parallel_modes_check, small_displacement_check};
pub use discretisation::{Choice, ElementErrors, Resolved, resolve, resolve_variation};
pub use efficiency::{Losses, losses};
pub use equilibrium::{equilibrium, equilibrium_residuals, with_axial_forces};
pub use error::AnalysisError;
pub use frequency_response::{FrequencyResponses, ResponsePoint};
pub use harmonic_terms::{HarmonicOutputs, HarmonicSystem, MotionPoint, SparseEntry, TERMS, harmonic_terms};
pub use instability::unstable_ranges;
pub use interrupt::Interrupt;
pub use mass::{ShaftMass, mass_properties};
pub use memory::{Dense, Kept, product};
pub use modes::memory_of_modes;
pub use own_frequency::lowest_modes;
pub use peaks::{Peak, Probe, peaks};
pub use sources::{Harmonic, HarmonicForces, HarmonicSource, normal_gradient};
pub use stability::Spectrum;
pub use synchronous::{ExcitationPart, SourceResponse, bow, highest_spin, memory_of_responses, synchronous};
pub use threads::{STACK, Threads};
