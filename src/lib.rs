//! gearbow: dynamics of geared shaft trains with residual bow.
//!
//! Flexible Timoshenko shafts on bearings are coupled by spur or helical gears and by couplings. Bearings have constant or
//! speed-dependent coefficients, oil films or rolling elements, and can stand on housings. The mesh geometry follows the
//! moving gear centres, or is frozen. Shafts can have bow and unbalance, and carry forces, torques and weight.
//!
//! Data flow, each folder using only those before it:
//!
//! [`scene`] (validated description) → [`model`] (assembled matrices) → [`modal`] (modes, state-space models) →
//! [`integrate`] (Runge–Kutta methods for any system) → [`motion`] (equation of motion) → [`exponential`] (exponential
//! method) → [`analysis`] (simulation, Campbell diagram, equilibrium and others) → results.
//!
//! [`element`], [`mesh`], [`film`], [`rolling`] and [`connection`] are the parts of a model; [`linalg`] and [`numerics`] are
//! their tools.
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
