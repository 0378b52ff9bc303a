//! Dense eigenvalue and LU decompositions by faer, for nalgebra matrices.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::traits::ComplexField;
use faer::{Auto, Mat, MatRef, Par, Spec};
use nalgebra::{Complex, DMatrix, DVector, Dyn, Scalar, Storage, Vector};
use thiserror::Error;

use super::inverse_iteration::refine_eigenvectors;
use super::sparse_lu::{Number, Singular};

/// Failure of a dense decomposition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum DecompositionError {
    /// The mass matrix is not positive definite: the pivot of this row, counted from zero, is not positive.
    #[error("the mass matrix is not positive definite at row {0}")]
    Mass(usize),
    /// The eigenvalue iteration did not converge.
    #[error("the eigenvalue iteration did not converge")]
    Eigenvalues,
    /// A matrix of the iteration for a few modes is singular.
    #[error("a linear system of the modes has no accurate solution")]
    Singular,
    /// The iteration for the modes with structural damping found one mode twice or none.
    #[error(
        "the modes with loss factors do not follow from those without; reduce the loss factors, or give a damping instead"
    )]
    Structural,
    /// The matrices depend on the speed, and none was chosen.
    #[error("a bearing depends on the speed: choose one with CachedModel::at_speed before a decomposition")]
    SpeedDependent,
}

impl From<Singular> for DecompositionError {
    fn from(_: Singular) -> Self {
        Self::Singular
    }
}

/// Fraction of ‖A_i‖‖x‖∞ that is added to |A_i||x| of each row i: an entry of x that is zero up to round-off has no
/// relative accuracy.
pub(super) const ENTRY_ROUND_OFF: f64 = 1e-8;

/// Componentwise backward error max |f − A x|/(|A||x| + |f|) of a solution x of A x = f (Oettli and Prager, Numer. Math. 6,
/// 1964).
pub fn backward_error(matrix: &DMatrix<Complex<f64>>, right: &DVector<Complex<f64>>, x: &DVector<Complex<f64>>) -> f64 {
    let floor = ENTRY_ROUND_OFF * x.iter().map(|value| value.l1_norm()).fold(0.0, f64::max);
    let (mut residual, mut sizes) = (right.clone(), right.map(|value| value.l1_norm()));
    for (column, x) in matrix.column_iter().zip(x) {
        for (row, value) in column.iter().enumerate() {
            let term = value * x;
            residual[row] -= term;
            sizes[row] += term.l1_norm() + floor * value.l1_norm();
        }
    }
    let ratios = residual.iter().zip(&sizes).filter(|(_, size)| **size != 0.0);
    // `f64::max` would ignore NaN.
    ratios.map(|(value, size)| value.l1_norm() / size).fold(0.0, |most, one| if one <= most { most } else { one })
}

/// Eigenvalues and right eigenvectors of an n × n matrix, in no particular order.
#[derive(Clone, Debug)]
pub struct Eigen {
    /// Eigenvalues, n entries.
    pub values: DVector<Complex<f64>>,
    /// Right eigenvectors of unit length, one per column.
    pub vectors: DMatrix<Complex<f64>>,
}

/// Eigenvalues in ascending order and orthonormal eigenvectors of a symmetric matrix; only its lower triangle is read.
///
/// The QR algorithm is used for every size. From 128 rows on faer uses divide and conquer by default, which leaves
/// residuals of 1e-6‖A‖ for repeated eigenvalues, such as those of the two bending planes of a shaft.
pub(super) fn symmetric_eigenpairs(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), DecompositionError> {
    self_adjoint_eigen(matrix)
}

/// Eigenvalues in ascending order and orthonormal eigenvectors of a Hermitian matrix; only its lower triangle is read.
///
/// # Errors
/// [`DecompositionError::Eigenvalues`] if the iteration does not converge.
pub fn hermitian_eigen(
    matrix: &DMatrix<Complex<f64>>,
) -> Result<(Vec<f64>, DMatrix<Complex<f64>>), DecompositionError> {
    let (values, vectors) = self_adjoint_eigen(view(matrix))?;
    Ok((values.into_iter().map(|value| value.re).collect(), copy(vectors.as_ref())))
}

fn self_adjoint_eigen<T: ComplexField>(matrix: MatRef<'_, T>) -> Result<(Vec<T>, Mat<T>), DecompositionError> {
    let n = matrix.nrows();
    let mut params = <SelfAdjointEvdParams as Auto<T>>::auto();
    params.recursion_threshold = usize::MAX;
    let params = Spec::new(params);
    let (mut values, mut vectors) = (Diag::<T>::zeros(n), Mat::zeros(n, n));
    let mut memory = MemBuffer::new(self_adjoint_evd_scratch::<T>(n, ComputeEigenvectors::Yes, Par::Seq, params));
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(matrix, values.as_mut(), Some(vectors.as_mut()), Par::Seq, stack, params)
        .map_err(|_| DecompositionError::Eigenvalues)?;
    Ok(((0..n).map(|i| values.column_vector()[i].clone()).collect(), vectors))
}

/// Eigenvalues and right eigenvectors of a general real matrix.
///
/// Each block of rows and columns that is not coupled to the others is decomposed separately. faer does not balance
/// matrices, so the caller scales the matrix.
///
/// # Errors
/// [`DecompositionError::Eigenvalues`] if the iteration does not converge.
pub fn eigen(matrix: &DMatrix<f64>) -> Result<Eigen, DecompositionError> {
    if matrix.is_empty() {
        return Ok(Eigen { values: DVector::zeros(0), vectors: DMatrix::zeros(0, 0) });
    }
    let size = matrix.amax();
    if !size.is_finite() {
        return Err(DecompositionError::Eigenvalues);
    }
    // Scaling avoids overflow of squared entries. A power of two makes it exact.
    let scale = if size > 0.0 { 2.0_f64.powi(size.log2().floor() as i32) } else { 1.0 };
    let scaled = matrix / scale;
    let n = matrix.nrows();
    let mut values = DVector::zeros(n);
    let mut vectors = DMatrix::zeros(n, n);
    let mut column = 0;
    for part in uncoupled_blocks(&scaled) {
        let block = scaled.select_rows(&part).select_columns(&part);
        let eigen = view(&block).eigen().map_err(|_| DecompositionError::Eigenvalues)?;
        let found: Vec<Complex<f64>> = eigen.S().column_vector().iter().copied().collect();
        let mut shapes: Vec<DVector<Complex<f64>>> =
            copy(eigen.U()).column_iter().map(|shape| shape.unscale(shape.norm())).collect();
        refine_eigenvectors(&block, &found, &mut shapes);
        for (value, shape) in found.iter().zip(&shapes) {
            values[column] = value * scale;
            for (row, entry) in part.iter().zip(shape.iter()) {
                vectors[(*row, column)] = *entry;
            }
            column += 1;
        }
    }
    Ok(Eigen { values, vectors })
}

/// Eigenvalues and right eigenvectors of a general complex matrix; each block that is not coupled to the others is decomposed
/// separately.
///
/// # Errors
/// [`DecompositionError::Eigenvalues`] if the iteration does not converge.
pub fn complex_eigen(matrix: &DMatrix<Complex<f64>>) -> Result<Eigen, DecompositionError> {
    let n = matrix.nrows();
    let (mut values, mut vectors) = (DVector::zeros(n), DMatrix::zeros(n, n));
    let mut column = 0;
    for part in uncoupled_blocks(&matrix.map(|value| value.norm())) {
        let block = matrix.select_rows(&part).select_columns(&part);
        let eigen = view(&block).eigen().map_err(|_| DecompositionError::Eigenvalues)?;
        for (value, vector) in eigen.S().column_vector().iter().zip(copy(eigen.U()).column_iter()) {
            values[column] = *value;
            let norm = vector.norm();
            part.iter().zip(vector.iter()).for_each(|(row, entry)| vectors[(*row, column)] = entry / norm);
            column += 1;
        }
    }
    Ok(Eigen { values, vectors })
}

/// Indices of the blocks of rows and columns that are coupled to each other by more than round-off.
///
/// Repeated eigenvalues, such as those of the two bending planes of a shaft, mostly belong to different blocks. Within
/// one block they are distinct, so their eigenvectors need no refinement ([`refine_eigenvectors`]).
fn uncoupled_blocks(matrix: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let n = matrix.nrows();
    let round_off = f64::EPSILON * matrix.amax();
    let mut left: Vec<usize> = (0..n).collect();
    let mut blocks = Vec::new();
    while let Some(first) = left.pop() {
        let (mut block, mut next) = (vec![first], 0);
        while next < block.len() {
            let row = block[next];
            let (joined, rest): (Vec<usize>, Vec<usize>) =
                left.iter().partition(|i| matrix[(row, **i)].abs() > round_off || matrix[(**i, row)].abs() > round_off);
            block.extend(joined);
            left = rest;
            next += 1;
        }
        block.sort_unstable();
        blocks.push(block);
    }
    blocks
}

/// LU factors, with partial pivoting, of a square matrix.
#[derive(Clone, Debug)]
pub struct LuFactors<T = f64>(PartialPivLu<T>);

impl<T: ComplexField + Copy + nalgebra::Scalar> LuFactors<T> {
    /// Factorizes a matrix.
    pub fn new(matrix: &DMatrix<T>) -> Self {
        Self(view(matrix).partial_piv_lu())
    }

    /// Solves A X = B for B = `right`.
    pub fn solve(&self, right: &DMatrix<T>) -> DMatrix<T> {
        copy(self.0.solve(view(right)).as_ref())
    }
}

/// Image of a complex vector under a real linear map: that of its real and of its imaginary part.
pub fn image_of_parts(x: &DVector<Complex<f64>>, map: impl Fn(&DVector<f64>) -> DVector<f64>) -> DVector<Complex<f64>> {
    map(&x.map(|value| value.re)).zip_map(&map(&x.map(|value| value.im)), Complex::new)
}

/// Solves the real system A X = B by LU decomposition with partial pivoting.
pub fn solve(matrix: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    LuFactors::new(matrix).solve(right)
}

/// Solves the complex system A X = B by LU decomposition with partial pivoting.
pub fn solve_complex(matrix: &DMatrix<Complex<f64>>, right: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    LuFactors::new(matrix).solve(right)
}
/// Rows r of a root of a positive semidefinite matrix G = Σ rᵀr, by the Cholesky decomposition with pivots. It ends where the
/// remaining diagonal is round-off, so that there are as many rows as the rank of G.
pub fn semidefinite_root(matrix: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut diagonal = matrix.diagonal();
    let round_off = diagonal.len() as f64 * f64::EPSILON * diagonal.amax();
    let mut rows: Vec<DVector<f64>> = Vec::new();
    while rows.len() < diagonal.len() {
        let pivot = diagonal.imax();
        if diagonal[pivot] <= round_off {
            break;
        }
        let mut row = matrix.column(pivot).into_owned();
        rows.iter().for_each(|before| row.axpy(-before[pivot], before, 1.0));
        row /= diagonal[pivot].sqrt();
        diagonal.zip_apply(&row, |left, entry| *left -= entry * entry);
        diagonal[pivot] = 0.0;
        rows.push(row);
    }
    rows
}

/// The matrix of these columns of `rows` entries each; there may be no columns.
pub fn matrix_of_columns<T: Number, S: Storage<T, Dyn>>(rows: usize, columns: &[Vector<T, Dyn, S>]) -> DMatrix<T> {
    if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(columns) }
}

/// View of a matrix for faer.
pub(super) fn view<T>(matrix: &DMatrix<T>) -> MatRef<'_, T> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// Copy of a matrix of faer.
pub(super) fn copy<T: Copy + Scalar>(matrix: MatRef<'_, T>) -> DMatrix<T> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}
