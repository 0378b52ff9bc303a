//! Shaft elements: matrices, and elastic forces from strains, in bending and torsion.

mod beam;
mod elastic;
mod internal;
mod legendre;

pub use beam::{Beam, deflection, flexural_rigidity, shear_coefficient};
pub use elastic::{Bending, Elastic, Twist, Values};
pub use internal::{BendingFunction, InternalBeam, InternalBlocks, twist_degrees};
pub use legendre::gauss;
