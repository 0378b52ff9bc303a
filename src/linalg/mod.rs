//! Linear algebra: matrices of chains of nodes, band matrices that a few coordinates couple, and dense decompositions by
//! faer, which no other folder imports.
//!
//! - Chains: `block_tridiagonal`, `chain` (with internal unknowns of elements).
//! - Bands: `band_order`, `band`, `blocks`, `couplings`, `coupled_bands`, `determinant`.
//! - Dense: `dense`, `pencil`, `inverse_iteration`, `convert`, `product`.
//! - Krylov spaces and iterations: `krylov` with `columns`, `conjugate_residuals`, `tridiagonal`; `sparse` matrices.

mod band;
mod band_order;
mod block_tridiagonal;
mod blocks;
mod chain;
mod columns;
mod conjugate_residuals;
mod convert;
mod coupled_bands;
mod couplings;
mod dense;
mod determinant;
mod inverse_iteration;
mod krylov;
mod pencil;
mod product;
mod sparse;
mod tridiagonal;

pub use band::{Band, Singular};
pub use band_order::BandOrder;
pub use block_tridiagonal::{BlockTridiagonal, BlockTridiagonalFactor, NotPositiveDefinite, load};
pub use chain::{ChainFactor, ChainMatrix};
pub use columns::{combination, products};
pub use conjugate_residuals::{LeastResidual, conjugate_residuals};
pub use coupled_bands::{BandChain, CoupledBands, CoupledFactors, MAX_BACKWARD_ERROR, Side};
pub use dense::{
    ComplexLu, DecompositionError, Eigen, LuFactors, backward_error, complex_eigen, eigen, hermitian_eigen,
    image_of_parts, matrix_of_columns, semidefinite_root, solve, solve_complex,
};
pub use determinant::Determinant;
pub use krylov::{Krylov, Operator, RitzPair};
pub use pencil::{SymmetricPencil, symmetric_eigen, symmetric_pencil};
pub use product::{LANES, product};
pub use sparse::Sparse;
pub use tridiagonal::{eigenvector, largest_eigenvalue};
