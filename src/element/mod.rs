//! Shaft elements: matrices, and elastic forces from strains, in bending and torsion.

mod beam;
mod elastic;

pub use beam::{Beam, shear_coefficient};
pub use elastic::{Bending, Elastic, Twist, Values};
