//! The exponential method: exact for the linear motion, Gauss collocation for the loads.
//!
//! The equation is ż = A z + Σ b p(t, w z). The linear part A is propagated exactly in the modes at speed. It contains the
//! shafts, the bearings with constant coefficients and the linear part of the other connections: the mean stiffness of
//! meshes, unless flanks can separate, and the coefficients of bearings at one speed or at their operating point. The
//! remainder of the connections is a few scalar loads p, which depend on a few interface scalars w z. Over a step, the
//! loads are the polynomial through Gauss nodes (Hochbruck and Ostermann 2005), so that the loads set the step length and
//! not the shortest element.
//!
//! If flanks can separate, the linear part contains no mesh and consists of independent parts.
//!
//! Time is an integer count of units. A step is a power of two of units and starts at a multiple of its length or at a
//! contact change, so that the propagators of a few lengths serve all steps.
//!
//! - Loads: `loads`, `prescribed`, `rotating_source`, `changing_speed`, `interface_maps`.
//! - Data of a step length: `quadrature`, `phi`, `time_grid`, `propagator`, `cache`.
//! - One step: `step` with `context`, `step_point`, `stages`, `solve`, `tangent_solver`, `small_lu`, `estimate`.
//! - Loops over modes: `kernel`, `panel_kernel`, with the memory layout of `packed`.
//! - A run: `driver`, `level_control`, `contact_change`, `contact_monitor`.
//! - The motion within a step: `substep` with `substep_modes` and `load_polynomials`; `trajectory`, `output` with
//!   `accelerations` and `state_map`.
//! - `in_modes`: the same equation for Runge–Kutta methods.

mod accelerations;
mod cache;
mod changing_speed;
mod contact_change;
mod contact_monitor;
mod context;
mod driver;
mod estimate;
mod in_modes;
mod interface_maps;
mod kernel;
mod level_control;
mod load_polynomials;
mod loads;
mod output;
mod packed;
mod panel_kernel;
mod phi;
mod prescribed;
mod propagator;
mod quadrature;
mod rotating_source;
mod small_lu;
mod solve;
mod stages;
mod state_map;
mod step;
mod step_point;
mod substep;
mod substep_modes;
mod tangent_solver;
mod time_grid;
mod trajectory;

pub use cache::{PropagatorCache, PropagatorKey};
pub use changing_speed::SpeedChange;
pub use driver::run;
pub use in_modes::InModes;
pub use interface_maps::InterfaceMaps;
pub use level_control::LevelControl;
pub use loads::Loads;
pub use output::{OutputMap, Selection};
pub(crate) use phi::phi;
pub use quadrature::{MAX_STAGES, QuadratureRule};
pub use rotating_source::is_resonant;
pub use step::Stepper;
pub use time_grid::TimeGrid;

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// The stage equations are solved.
    Solved,
    /// The stage equations are not solved: the step is too long.
    Unsolved,
}
