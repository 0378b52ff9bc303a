//! The exponential method: exact where the motion is linear, Gauss collocation where it is not.
//!
//! ż = A z + Σ b p(t, w z): everything but the meshes is linear and is carried exactly, in the modes at speed; the
//! meshes are a few scalar loads p that depend on a few scalars of the motion. Over a step the loads are a polynomial
//! through Gauss nodes (Hochbruck and Ostermann 2005), so the step is set by the meshes, not by the shortest element.
//!
//! Where flanks may part the linear motion is that of the shafts alone, in parts that nothing couples; otherwise it
//! contains the meshes at rest, and the loads are what is left.
//!
//! Time counts in ticks, the shortest step, and a step is a power of two of them that divides the time it begins at.
//! Coefficients are tabulated for each: a step that ends at a tooth event or at a time asked for rebuilds nothing.

mod cache;
mod contact_change;
mod contact_monitor;
mod contact_tangent;
mod dense;
mod driver;
mod estimate;
mod in_modes;
mod jump;
mod kernel;
mod nonlinear_loads;
mod output;
mod packed;
mod phi;
mod propagator;
mod quadrature;
mod small_lu;
mod solve;
mod step;
mod substep;
mod time_grid;

pub use cache::{InterfaceMaps, PropagatorCache};
pub use driver::{LevelControl, run};
pub use in_modes::InModes;
pub use nonlinear_loads::{NonlinearLoads, is_resonant};
pub use output::{OutputMap, Selection};
pub use quadrature::{MOST as MOST_STAGES, QuadratureRule};
pub use step::Stepper;
pub use time_grid::TimeGrid;

/// What became of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Its loads were found.
    Solved,
    /// They were not: it is too long.
    Unsolved,
}
