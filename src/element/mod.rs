//! Matrices of one element each, in one bending plane or in twist.

mod beam;

pub use beam::{Beam, shear_coefficient};
