//! The linear motion of a step and what follows from the step length alone.
//!
//! - `interface_maps`: scalars of the interface as linear maps of the modal state.
//! - `phi`: the φ-functions of a mode pair. `quadrature`: the stages of a step and the polynomials through them.
//! - `time_grid`: integer time and the step lengths.
//! - `step_maps`: the linear maps of a step of one length. `cache`: those of all lengths.
//! - `kernel`, `panel_kernel`: the loops over modes and over stages, with the memory layout of `packed`.

mod cache;
mod interface_maps;
pub mod kernel;
mod packed;
pub mod panel_kernel;
pub mod phi;
mod quadrature;
mod step_maps;
mod time_grid;

pub use cache::{PropagatorCache, PropagatorKey};
pub use interface_maps::{InterfaceMaps, LinearizedDirection};
pub use packed::{Aligned, Panel, Rows, WIDTH, aligned};
pub use phi::phi;
pub use quadrature::{MAX_STAGES, PointValues, QuadratureRule};
pub use time_grid::TimeGrid;
