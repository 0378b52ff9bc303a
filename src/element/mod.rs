//! Shaft elements: matrices, and elastic forces from strains, in bending, in torsion and along the axis.
//!
//! One complex beam, u = v + iw and φ = Γ − iB, represents both bending planes. `profile` has the section
//! properties and static shape functions of cylinders, cones and layers, `beam` the matrices, `elastic` forces
//! and energies from strains, so that rigid motions cause no round-off, `internal` the internal coordinates of
//! elements of degree 2 and above, with the polynomials of `src/numerics/legendre.rs`, and `cut` the section forces.

mod beam;
mod cut;
mod elastic;
mod internal;
mod profile;

pub use beam::{Beam, RodMatrices, deflection};
pub use cut::{ElementCut, ForceRows, RodCut};
pub use elastic::{Bending, Elastic, Rod, Values};
pub use internal::{
    BendingFunction, BendingShape, InternalBeam, InternalBlocks, InternalRod, PlaceShape, geometric_stiffness,
    rod_degrees,
};
pub use profile::{GAUSS_POINTS, Section, shear_coefficient};
