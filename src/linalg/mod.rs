//! Linear algebra: matrices of chains of nodes, and dense decompositions by faer.

mod block_tridiagonal;
mod chain;
mod convert;
mod dense;
mod inverse_iteration;
mod pencil;

pub use block_tridiagonal::{BlockTridiagonal, BlockTridiagonalFactor, NotPositiveDefinite, load};
pub use chain::{ChainFactor, ChainMatrix};
pub use dense::{DecompositionError, Eigen, LuFactors, eigen, hermitian_eigen, solve, solve_complex};
pub use pencil::{SymmetricPencil, symmetric_pencil};
