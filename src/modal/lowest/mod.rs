//! A few modes of a large model, in time proportional to the number of coordinates.
//!
//! - `arnoldi`: the damped modes of lowest frequency. `lowest_damped`: the same with strong or modal damping, by the Galerkin
//!   projection of `galerkin`.
//! - `shift_invert`: the eigenvalue problem inverted at a shift.
//! - `contour` counts the eigenvalues within a contour, `bound` bounds them.
//! - `modal_space`: the modes with modal damping, of one model or at all speeds.
//! - `critical`: the lowest critical speeds. `intersection`: one mode at a speed or on a line of the Campbell diagram.

mod arnoldi;
mod bound;
mod contour;
mod critical;
mod galerkin;
mod intersection;
mod lowest_damped;
mod modal_space;
mod shift_invert;

pub use arnoldi::{lowest, lowest_vibrations};
pub use critical::lowest_critical;
pub use intersection::{ModeAtSpeed, intersection, mode_near};
pub use lowest_damped::lowest_damped;
pub use modal_space::{Highest, MAX_DENSE, ModalSpace, UndampedSearch, lowest_undamped};
pub use shift_invert::{Eigenpair, Problem, oscillates};
