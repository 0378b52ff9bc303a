//! Conversion between the matrices of nalgebra and faer. Both are column-major, so a view needs no copy.

use faer::MatRef;
use nalgebra::{DMatrix, Scalar};

/// View of a matrix for faer.
pub(super) fn view<T>(matrix: &DMatrix<T>) -> MatRef<'_, T> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// Copy of a matrix of faer.
pub(super) fn copy<T: Copy + Scalar>(matrix: MatRef<'_, T>) -> DMatrix<T> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}
