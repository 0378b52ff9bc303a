//! ModalStateSpace algebra: what a shaft's chain of nodes needs, and the dense decompositions.

mod block_tridiagonal;
mod dense;
mod pencil;
mod repair;

pub use block_tridiagonal::{BlockTridiagonal, BlockTridiagonalFactor, NotPositiveDefinite, load};
pub use dense::{DecompositionError, Eigen, Factors, eigen, hermitian_eigen, solve, solve_complex};
pub use pencil::{SymmetricPencil, symmetric_pencil};
