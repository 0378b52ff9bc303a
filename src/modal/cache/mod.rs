//! A model with all that follows from it, computed at first use, which a system with other loads shares.
//!
//! - `cached`: the model. `recent`: a list of the last results.
//! - `dynamic_solver`: the response to harmonic forces at any frequency and speed.

mod cached;
mod dynamic_solver;
mod recent;

pub use cached::{AtSpeed, CachedModel};
pub use dynamic_solver::{DynamicKey, DynamicStiffnessSolver, EquationForces, Solved, dynamic_force};
pub use recent::Recent;
