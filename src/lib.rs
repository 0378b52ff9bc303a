//! gearbow: how a geared train moves when its shafts are bent.
//!
//! Flexible Timoshenko shafts on bearings, coupled by spur gears whose mesh geometry follows the moving centres, bowed,
//! unbalanced and loaded. One way through the house, each folder depending only on those before it:
//!
//! [`scene`] (what a user says, checked once) → [`model`] (assembled) → [`modal`] (modes, the basis) → [`motion`] (the
//! equation) → [`integrate`] and [`exponential`] (the methods) → [`analysis`] → results.
//!
//! SI units and radians throughout: m, kg, s, N, rad.

pub mod analysis;
pub mod connection;
pub mod element;
pub mod exponential;
pub mod integrate;
pub mod linalg;
pub mod mesh;
pub mod modal;
pub mod model;
pub mod motion;
#[cfg(feature = "python")]
mod python;
pub mod scene;
