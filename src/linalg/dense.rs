//! Dense decompositions by faer, on nalgebra's matrices. Both are column-major, so nothing is copied on the way in.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::traits::ComplexField;
use faer::{Auto, Mat, MatRef, Par, Spec};
use nalgebra::{Complex, DMatrix, DVector};
use thiserror::Error;

use super::repair::repair;

/// A dense decomposition that did not succeed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum DecompositionError {
    /// The mass matrix is not positive definite at this row.
    #[error("the mass matrix is not positive definite at row {0}")]
    Mass(usize),
    /// The eigenvalue iteration did not converge.
    #[error("the eigenvalue iteration did not converge")]
    Eigenvalues,
    /// The matrices depend on the speed, and none was chosen.
    #[error("a bearing depends on the speed: choose one with CachedModel::at_speed before a decomposition")]
    SpeedDependent,
}

/// Eigenvalues and right eigenvectors, unordered, vectors of unit length.
#[derive(Clone, Debug)]
pub struct Eigen {
    /// Eigenvalues.
    pub values: DVector<Complex<f64>>,
    /// Right eigenvectors, one a column.
    pub vectors: DMatrix<Complex<f64>>,
}

pub(super) fn view<T>(matrix: &DMatrix<T>) -> MatRef<'_, T> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

pub(super) fn copy<T: Copy + nalgebra::Scalar>(matrix: MatRef<'_, T>) -> DMatrix<T> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix, of which the lower half is read.
///
/// By the QR algorithm. faer's default from 128 rows on, divide and conquer, leaves residuals of 1e-6‖A‖ where
/// eigenvalues repeat, as those of the two bending planes of a shaft do.
pub(super) fn symmetric_eigen(matrix: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), DecompositionError> {
    self_adjoint_eigen(matrix.as_ref())
}

/// The same of a Hermitian matrix.
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
/// faer does not balance: scale the matrix first.
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
    // A power of two, so that scaling is exact: squares of what is near overflow are not finite.
    let scale = if size > 0.0 { 2.0_f64.powi(size.log2().floor() as i32) } else { 1.0 };
    let scaled = matrix / scale;
    let n = matrix.nrows();
    let mut values = DVector::zeros(n);
    let mut vectors = DMatrix::zeros(n, n);
    let mut column = 0;
    for part in parts(&scaled) {
        let block = scaled.select_rows(&part).select_columns(&part);
        let eigen = view(&block).eigen().map_err(|_| DecompositionError::Eigenvalues)?;
        let found: Vec<Complex<f64>> = eigen.S().column_vector().iter().copied().collect();
        let mut shapes: Vec<DVector<Complex<f64>>> =
            copy(eigen.U()).column_iter().map(|shape| shape.unscale(shape.norm())).collect();
        repair(&block, &found, &mut shapes);
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

/// The rows and columns of a matrix that couple with each other, to round-off.
///
/// Eigenvalues that repeat, as those of the two bending planes of a shaft do, mostly belong to parts that do not couple.
/// One by one they have no equals, whose vectors would have to be found again (see [`repair`]).
fn parts(matrix: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let n = matrix.nrows();
    let nothing = f64::EPSILON * matrix.amax();
    let mut left: Vec<usize> = (0..n).collect();
    let mut parts = Vec::new();
    while let Some(first) = left.pop() {
        let (mut part, mut next) = (vec![first], 0);
        while next < part.len() {
            let row = part[next];
            let (joined, rest): (Vec<usize>, Vec<usize>) =
                left.iter().partition(|i| matrix[(row, **i)].abs() > nothing || matrix[(**i, row)].abs() > nothing);
            part.extend(joined);
            left = rest;
            next += 1;
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

/// The factors of a square real matrix by LU with partial pivoting.
#[derive(Clone, Debug)]
pub struct Factors(PartialPivLu<f64>);

impl Factors {
    /// Factorises.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        Self(view(matrix).partial_piv_lu())
    }

    /// Solves for the columns of `right`.
    pub fn solve(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        copy(self.0.solve(view(right)).as_ref())
    }
}

/// Solves a square real system by LU with partial pivoting.
pub fn solve(matrix: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    Factors::of(matrix).solve(right)
}

/// Solves a square complex system by LU with partial pivoting.
pub fn solve_complex(matrix: &DMatrix<Complex<f64>>, right: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    copy(view(matrix).partial_piv_lu().solve(view(right)).as_ref())
}
