//! Refinement of the eigenvectors of repeated or close eigenvalues by inverse iteration.
//!
//! Back substitution in a real Schur form cannot separate two equal pairs of complex eigenvalues, and is inaccurate for
//! close ones. One eigenvector of such a cluster is correct; the others have errors of up to a few per cent. Inverse
//! iteration computes them again, one after the other, each orthogonal to the correct eigenvectors of the same
//! eigenvalue (Golub and Van Loan, Matrix Computations, 4th ed., section 7.6.1).

use faer::linalg::solvers::Solve;
use nalgebra::{Complex, DMatrix, DVector};

use super::dense::{copy, view};
use crate::numerics::ROUND_OFF;

/// An eigenvector is wrong if its residual exceeds this times ‖A‖√n.
const MAX_RESIDUAL: f64 = 1e-14;
/// Eigenvalues closer than this times ‖A‖ may have wrong eigenvectors.
const CLOSE_EIGENVALUES: f64 = 1e-5;
/// Distance of the shift of inverse iteration to the eigenvalue, times ‖A‖; it keeps the shifted matrix regular.
const SHIFT_DISTANCE: f64 = 1e-15;
/// Two steps reach round-off; a third one makes up for a bad start vector.
const MAX_ITERATIONS: usize = 3;
/// Norm of the perturbation of the start vector of unit length.
const START_PERTURBATION: f64 = 0.1;

type Vector = DVector<Complex<f64>>;

/// Recomputes wrong eigenvectors of `matrix`; all vectors have unit length. A vector whose residual does not decrease
/// stays unchanged.
pub(super) fn refine_eigenvectors(matrix: &DMatrix<f64>, values: &[Complex<f64>], vectors: &mut [Vector]) {
    let size = matrix.norm();
    let tolerance = MAX_RESIDUAL * size * (matrix.nrows() as f64).sqrt();
    let closer = |a: usize, b: usize, fraction: f64| (values[a] - values[b]).norm_sqr() <= (fraction * size).powi(2);
    let isolated =
        |index: usize| !(0..values.len()).any(|other| other != index && closer(index, other, CLOSE_EIGENVALUES));
    let close: Vec<usize> = (0..values.len()).filter(|index| !isolated(*index)).collect();
    let mut correct = vec![true; values.len()];
    for (index, residual) in close.iter().zip(residuals(matrix, values, vectors, &close)) {
        correct[*index] = residual <= tolerance;
    }
    for (index, value) in values.iter().copied().enumerate() {
        if correct[index] || value.im < 0.0 {
            continue;
        }
        let equals: Vec<Vector> = (0..values.len())
            .filter(|other| correct[*other] && closer(index, *other, ROUND_OFF))
            .map(|other| vectors[other].clone())
            .collect();
        let shift = value + Complex::new(SHIFT_DISTANCE * size, SHIFT_DISTANCE * size);
        let vector = inverse_iteration(matrix, shift, &vectors[index], &equals);
        let refined = residual(matrix, value, &vector);
        if refined < residual(matrix, value, &vectors[index]) {
            correct[index] = refined <= tolerance;
            if let Some(other) = values.iter().position(|other| value.im > 0.0 && *other == value.conj()) {
                vectors[other] = vector.conjugate();
            }
            vectors[index] = vector;
        }
    }
}

/// ‖A v − λ v‖.
fn residual(matrix: &DMatrix<f64>, value: Complex<f64>, vector: &Vector) -> f64 {
    let product = |part: fn(&Complex<f64>) -> f64| matrix * vector.map(|entry| part(&entry));
    let image = product(|entry| entry.re).zip_map(&product(|entry| entry.im), Complex::new);
    (image - vector * value).norm()
}

/// ‖A v − λ v‖ of the vectors with these indices. One product with all vectors takes a fraction of the time of single ones.
fn residuals(matrix: &DMatrix<f64>, values: &[Complex<f64>], vectors: &[Vector], indices: &[usize]) -> Vec<f64> {
    let count = indices.len();
    let parts = DMatrix::from_fn(matrix.nrows(), 2 * count, |row, column| {
        let entry = vectors[indices[column % count]][row];
        if column < count { entry.re } else { entry.im }
    });
    let image = matrix * parts;
    let residual = |(column, index): (usize, &usize)| {
        let entries = image.column(column).zip_map(&image.column(count + column), Complex::new);
        (entries - &vectors[*index] * values[*index]).norm()
    };
    indices.iter().enumerate().map(residual).collect()
}

/// Unit vector after [`MAX_ITERATIONS`] of inverse iteration from `start`, orthogonal to the unit vectors `equals`.
fn inverse_iteration(matrix: &DMatrix<f64>, shift: Complex<f64>, start: &Vector, equals: &[Vector]) -> Vector {
    let n = matrix.nrows();
    let shifted =
        DMatrix::from_fn(n, n, |i, j| Complex::from(matrix[(i, j)]) - if i == j { shift } else { Complex::ZERO });
    let factors = view(&shifted).partial_piv_lu();
    // The start vector may have no component in the direction of the eigenvector. A fixed perturbation adds components
    // in all directions.
    let perturbation = |i: usize| Complex::from_polar(START_PERTURBATION / (n as f64).sqrt(), (i * i) as f64);
    let mut vector = DVector::from_fn(n, |i, _| start[i] + perturbation(i));
    for _ in 0..MAX_ITERATIONS {
        let solved = factors.solve(view(&DMatrix::from_column_slice(n, 1, vector.as_slice())));
        vector = copy(solved.as_ref()).column(0).into_owned();
        // Orthogonalization is done twice, because the first time leaves round-off of the removed components.
        for equal in equals.iter().chain(equals) {
            let component = equal.dotc(&vector);
            vector -= equal * component;
        }
        let length = vector.norm();
        vector.unscale_mut(length);
    }
    vector
}
