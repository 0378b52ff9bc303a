//! A few modes of a large model, in time proportional to the number of coordinates.
//!
//! - `selection`: the order of modes, and which of them are vibrations.
//! - `arnoldi`: the search for the lowest modes. `shift_invert`: the eigenvalue problem inverted at a shift. `contour` counts the
//!   eigenvalues in a disk.
//! - `modal_space`: the modes with modal damping, of one model or at all speeds.
//! - `critical`: the lowest critical speeds. `newton`: one mode at a speed or on a line of the Campbell diagram.
//!   `mode_space`: a space in which modes at many speeds are found.

mod arnoldi;
mod contour;
mod critical;
mod modal_space;
mod mode_space;
mod newton;
mod selection;
mod shift_invert;

pub use arnoldi::{UndampedSpace, lowest};
pub use critical::{CriticalInverse, CriticalSpace, ReducedMode, add_stiffness_change, lowest_critical, reduced_modes};
pub use modal_space::{Highest, LowestModes, MAX_DENSE, MIN_BANDED, ModalSpace, UndampedSearch, lowest_undamped};
pub use mode_space::ModeSpace;
pub use newton::{FullEquations, ModeAtSpeed, Unknown, mode_near};
pub use selection::{ModeSelection, ascending, vibrates};
pub use shift_invert::{Eigenpair, Problem};
