//! The loads on the linear motion.
//!
//! - `combined`: all loads of a run: those of the connections and those of the other files.
//! - `changing_speed`: what a changing speed adds. `rotating_source`: the synchronous motion under rotating loads.
//! - `prescribed`: loads that do not depend on the motion.

mod changing_speed;
mod combined;
mod prescribed;
mod rotating_source;

pub use changing_speed::SpeedChange;
pub use combined::Loads;
pub use rotating_source::is_resonant;
