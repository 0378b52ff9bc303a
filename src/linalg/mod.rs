//! Linear algebra: matrices of chains of nodes, sparse LU factors of coupled chains, and dense decompositions by faer, which
//! no other folder imports.
//!
//! - Chains: `block_tridiagonal`, `chain` (with internal unknowns of elements).
//! - Coupled chains: `band_order`, `band`, `coupled_chains`; `sparse_lu`, `minimum_degree`, `determinant`.
//! - Dense: `dense`, `pencil`, `inverse_iteration`.
//! - Krylov spaces and iterations: `krylov` with `columns`, `conjugate_residuals`, `tridiagonal`; `sparse` matrices.

mod band;
mod band_order;
mod block_tridiagonal;
mod chain;
mod columns;
mod conjugate_residuals;
mod coupled_chains;
mod dense;
mod determinant;
mod inverse_iteration;
mod krylov;
mod minimum_degree;
mod pencil;
mod sparse;
mod sparse_lu;
mod tridiagonal;

pub use band::Band;
pub use band_order::BandOrder;
pub use block_tridiagonal::{BlockTridiagonal, BlockTridiagonalFactor, NotPositiveDefinite, load};
pub use chain::{ChainFactor, ChainMatrix};
pub use columns::{LANES, combination, product, products};
pub use conjugate_residuals::{LeastResidual, conjugate_residuals};
pub use coupled_chains::{BandChain, CoupledChains, CoupledFactors, MAX_BACKWARD_ERROR, Side, Structure};
pub use dense::{
    DecompositionError, Eigen, LuFactors, backward_error, complex_eigen, eigen, hermitian_eigen, image_of_parts,
    matrix_of_columns, semidefinite_root, solve, solve_complex,
};
pub use determinant::Determinant;
pub use krylov::{Krylov, Operator, RitzPair};
pub use pencil::{SymmetricPencil, symmetric_eigen, symmetric_pencil};
pub use sparse::Sparse;
pub use sparse_lu::Singular;
pub use tridiagonal::{eigenvector, largest_eigenvalue};
