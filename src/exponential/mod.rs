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

mod change;
mod clock;
mod dense;
mod driver;
mod estimate;
mod field;
mod follow;
mod in_modes;
mod kernel;
mod level;
mod newton;
mod output;
mod packed;
mod phi;
mod rule;
mod sample;
mod shift;
mod solve;
mod step;
mod table;
mod watch;

pub use clock::Clock;
pub use driver::{Control, run};
pub use field::{Field, is_resonant};
pub use in_modes::InModes;
pub use output::{Output, Selection};
pub use rule::{MOST as MOST_STAGES, Rule};
pub use step::Stepper;
pub use table::{Ports, Table};

/// What became of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Its loads were found.
    Solved,
    /// They were not: it is too long.
    Unsolved,
}
