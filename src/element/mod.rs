//! Shaft elements: matrices, and elastic forces from strains, in bending, in torsion and along the axis.

mod beam;
mod elastic;
mod internal;

pub use beam::{Beam, RodMatrices, deflection, flexural_rigidity, shear_coefficient};
pub use elastic::{Bending, Elastic, Rod, Values};
pub use internal::{BendingFunction, InternalBeam, InternalBlocks, InternalRod, rod_degrees};
