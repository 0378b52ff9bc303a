//! gearbow: dynamics of geared shaft trains with residual bow.
//!
//! Flexible Timoshenko shafts on bearings are coupled by spur gears. The mesh geometry follows the moving gear centres.
//! Shafts can have bow and unbalance, and carry torques and weight.
//!
//! Data flow, each folder using only those before it:
//!
//! [`scene`] (validated description) → [`model`] (assembled matrices) → [`modal`] (modes, state-space models) →
//! [`motion`] (equation of motion) → [`integrate`] and [`exponential`] (time integration) → [`analysis`] (simulation,
//! Campbell diagram, equilibrium and others) → results.
//!
//! All quantities are in SI units and radians: m, kg, s, N, rad.

pub mod analysis;
pub mod bearing_force;
pub mod connection;
pub mod element;
pub mod exponential;
pub mod film;
pub mod integrate;
pub mod linalg;
pub mod mesh;
pub mod modal;
pub mod model;
pub mod motion;
pub mod numerics;
#[cfg(feature = "python")]
mod python;
pub mod rolling;
pub mod scene;
