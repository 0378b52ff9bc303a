//! Linear algebra: block-tridiagonal matrices of shafts, band matrices that a few coordinates couple, and dense
//! decompositions by faer.

mod band;
mod block_tridiagonal;
mod convert;
mod coupled_bands;
mod dense;
mod inverse_iteration;
mod krylov;
mod pencil;
mod sparse;

pub use band::Singular;
pub use block_tridiagonal::{BlockTridiagonal, BlockTridiagonalFactor, NotPositiveDefinite, load};
pub use coupled_bands::{ChainMatrix, CoupledBands, CoupledFactors, Determinant};
pub use dense::{DecompositionError, Eigen, LuFactors, eigen, hermitian_eigen, solve, solve_complex};
pub use krylov::{Krylov, Operator, RitzPair};
pub use pencil::{SymmetricPencil, symmetric_pencil};
pub use sparse::Sparse;
