//! Matrices of one element each, in one bending plane or in twist.

mod beam;
mod elastic;

pub use beam::{Beam, shear_coefficient};
pub use elastic::{Bending, Elastic, Twist, Values};
