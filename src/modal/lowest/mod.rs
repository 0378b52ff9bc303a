//! A few modes of a large model, in time proportional to the number of coordinates.
//!
//! - `selection`: the order of modes, and which of them are vibrations.
//! - `arnoldi`: the lowest modes. `shift_invert`: the eigenvalue problem inverted at a shift. `contour` counts the eigenvalues
//!   within a contour.
//! - `modal_space`: the modes with modal damping, of one model or at all speeds.
//! - `critical`: the lowest critical speeds. `intersection`: one mode at a speed or on a line of the Campbell diagram.
//!   `mode_space`: a space in which modes at many speeds are found.

mod arnoldi;
mod contour;
mod critical;
mod intersection;
mod modal_space;
mod mode_space;
mod selection;
mod shift_invert;

pub use arnoldi::lowest;
pub use critical::{FORWARD, lowest_critical};
pub use intersection::{FullEquations, ModeAtSpeed, Unknown, mode_near};
pub use modal_space::{Highest, MAX_DENSE, ModalSpace, UndampedSearch, lowest_undamped};
pub use mode_space::ModeSpace;
pub use selection::{ModeSelection, ascending, vibrates};
pub use shift_invert::{Eigenpair, Problem};
