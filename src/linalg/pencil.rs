//! Symmetric generalized eigenproblem K φ = ω² M φ with exact deflation of a known null space of K.
//!
//! With M = LLᵀ the problem becomes A u = ω² u, where A = L⁻¹KL⁻ᵀ and φ = L⁻ᵀu. Householder reflections map the known
//! null vectors to coordinate axes, and the eigensolver works on the orthogonal complement. The null vectors then have
//! ω = 0 exactly, and all other modes are orthogonal to them. Without deflation an eigensolver gives ω² = ±1e-5 and
//! mixes null vectors into the low modes.
//!
//! Coordinates with little mass and much stiffness have ω² so high that its round-off exceeds the lowest ω². The lowest modes
//! are then found again by inverse subspace iteration with K itself, which contains no small mass.

use faer::linalg::solvers::{Llt, Solve};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};
use nalgebra::{DMatrix, DVector};

use super::DecompositionError;
use super::dense::{copy, symmetric_eigenpairs, view};

/// Part of the largest ω² below which modes are found again: its round-off is more than 2e-4 of their ω².
const UNRESOLVED: f64 = 1e-12;

/// Eigenvalues and eigenvectors of a symmetric n × n pencil (K, M).
#[derive(Clone, Debug)]
pub struct SymmetricPencil {
    /// ω², rad²/s²: first the zeros of the null vectors, then ascending.
    pub values: DVector<f64>,
    /// Eigenvectors φ, one per column, with φᵀMφ = 1.
    pub vectors: DMatrix<f64>,
}

/// Solves K φ = ω² M φ. The columns of `null` are the known null vectors of K, orthonormal in M; there may be none.
///
/// # Errors
/// [`DecompositionError`] if M is not positive definite or the iteration fails.
pub fn symmetric_pencil(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    null: &DMatrix<f64>,
) -> Result<SymmetricPencil, DecompositionError> {
    let n = stiffness.nrows();
    let known = null.ncols();
    let llt = view(mass).llt(Side::Lower).map_err(|error| match error {
        faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index } => DecompositionError::Mass(index),
    })?;
    let factor = llt.L();

    // A = L⁻¹ (L⁻¹ K)ᵀ, because K is symmetric.
    let mut half = view(stiffness).to_owned();
    solve_lower_triangular_in_place(factor, half.as_mut(), Par::Seq);
    let mut standard = half.transpose().to_owned();
    solve_lower_triangular_in_place(factor, standard.as_mut(), Par::Seq);
    let mut standard = copy(standard.as_ref());

    let mut axes = copy((factor.transpose() * view(null)).as_ref());
    let mut reflections: Vec<DVector<f64>> = Vec::with_capacity(known);
    for column in 0..known {
        let mut axis = axes.column(column).into_owned();
        axis.rows_mut(0, column).fill(0.0);
        let norm = axis.norm();
        axis[column] += norm.copysign(axis[column]);
        axis.normalize_mut();
        reflect_rows(&axis, &mut axes);
        reflect_rows(&axis, &mut standard);
        standard.transpose_mut();
        reflect_rows(&axis, &mut standard);
        reflections.push(axis);
    }

    let rest = n - known;
    let mut values = DVector::zeros(n);
    let mut vectors = DMatrix::zeros(n, n);
    if rest > 0 {
        let block = standard.view((known, known), (rest, rest));
        let symmetric = Mat::from_fn(rest, rest, |i, j| (block[(i, j)] + block[(j, i)]) / 2.0);
        let (found, unit) = symmetric_eigenpairs(symmetric.as_ref())?;
        for j in 0..rest {
            values[known + j] = found[j];
            for i in 0..rest {
                vectors[(known + i, known + j)] = unit[(i, j)];
            }
        }
    }
    for axis in reflections.iter().rev() {
        reflect_rows(axis, &mut vectors);
    }
    let mut physical = view(&vectors).to_owned();
    solve_upper_triangular_in_place(factor.transpose(), physical.as_mut(), Par::Seq);
    let mut vectors = copy(physical.as_ref());
    for column in 0..known {
        vectors.set_column(column, &null.column(column));
    }
    let limit = UNRESOLVED * values.max();
    let low = values.iter().skip(known).take_while(|value| **value < limit).count();
    if low > 0 {
        let momenta = mass * null;
        let regular = stiffness + (&momenta * limit) * momenta.transpose();
        // Without positive stiffness the modes stay as they are.
        let refined = |inverse: &Llt<f64>| {
            let start = in_subspace(stiffness, mass, vectors.columns(known, low).into_owned())?;
            let mut shapes = copy(inverse.solve(view(&(mass * start.vectors))).as_ref());
            shapes -= null * momenta.tr_mul(&shapes);
            shapes.column_iter_mut().for_each(|mut shape| {
                shape.normalize_mut();
            });
            in_subspace(stiffness, mass, shapes)
        };
        if let Some(Ok(found)) = view(&regular).llt(Side::Lower).ok().as_ref().map(refined) {
            values.rows_mut(known, low).copy_from(&found.values);
            vectors.columns_mut(known, low).copy_from(&found.vectors);
        }
    }
    Ok(SymmetricPencil { values, vectors })
}

/// Approximations in the space of the columns of `shapes` (Rayleigh and Ritz).
fn in_subspace(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    shapes: DMatrix<f64>,
) -> Result<SymmetricPencil, DecompositionError> {
    let projected = |matrix: &DMatrix<f64>| shapes.tr_mul(&(matrix * &shapes));
    let none = DMatrix::zeros(shapes.ncols(), 0);
    let SymmetricPencil { values, vectors } = symmetric_pencil(&projected(stiffness), &projected(mass), &none)?;
    Ok(SymmetricPencil { values, vectors: shapes * vectors })
}

/// Solves K φ = ω² φ: the same with the identity for M.
///
/// # Errors
/// [`DecompositionError`] if the iteration fails.
pub fn symmetric_eigen(stiffness: &DMatrix<f64>) -> Result<SymmetricPencil, DecompositionError> {
    let (values, vectors) = symmetric_eigenpairs(view(stiffness))?;
    Ok(SymmetricPencil { values: DVector::from_vec(values), vectors: copy(vectors.as_ref()) })
}

/// Householder reflection `matrix ← (I − 2aaᵀ)·matrix` with a = `axis`.
fn reflect_rows(axis: &DVector<f64>, matrix: &mut DMatrix<f64>) {
    for mut column in matrix.column_iter_mut() {
        let factor = -2.0 * axis.dot(&column);
        column.axpy(factor, axis, 1.0);
    }
}
