//! Eigenvalues and real eigenvectors of the matrix A of a first-order form.
//!
//! An eigenvalue λ = a ± ib with the eigenvector r ± is gives two real columns, r and s, with
//! A [r s] = [r s] [[a, b], [−b, a]].

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::first_order::FirstOrder;
use crate::linalg::{DecompositionError, eigen, matrix_of_columns, solve};
use crate::modal::undamped::RealModes;

/// Eigenvalues λ, and the real vectors of their invariant subspaces.
pub(in crate::modal) struct Eigenpairs {
    /// Eigenvalues with Im λ > 0, rad/s.
    pub complex: Vec<Complex64>,
    /// Real eigenvalues, rad/s.
    pub real: Vec<f64>,
    /// V: columns r and s of each complex eigenvalue, then one column of unit length for each real eigenvalue.
    pub vectors: DMatrix<f64>,
    /// V⁻¹.
    pub inverse: DMatrix<f64>,
}

impl Eigenpairs {
    /// Eigenpairs of `order.matrix`; `None` if round-off leaves a complex eigenvalue without its conjugate.
    pub fn new(real_modes: &RealModes, order: &FirstOrder) -> Result<Option<Self>, DecompositionError> {
        let size = order.matrix.nrows();
        let (mut complex, mut real): (Vec<Complex64>, Vec<f64>) = (Vec::new(), Vec::new());
        let (mut columns, mut real_columns): (Vec<DVector<f64>>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
        if order.undamped {
            let axis = |i: usize| DVector::from_fn(size, |k, _| if k == i { 1.0 } else { 0.0 });
            for (i, mode) in order.elastic.iter().enumerate() {
                complex.push(Complex64::new(0.0, real_modes.frequencies[*mode]));
                columns.extend([axis(i), axis(order.elastic.len() + i)]);
            }
        } else {
            let eigen = eigen(&order.matrix)?;
            for (value, vector) in eigen.values.iter().zip(eigen.vectors.column_iter()) {
                if value.im > 0.0 {
                    complex.push(*value);
                    columns.extend(orthogonal_parts(vector.iter().copied()));
                } else if value.im == 0.0 {
                    real.push(value.re);
                    real_columns.push(vector.map(|entry| entry.re).normalize());
                }
            }
        }
        columns.extend(real_columns);
        if columns.len() != size {
            return Ok(None);
        }
        let vectors = matrix_of_columns(size, &columns);
        let inverse =
            if order.undamped { vectors.transpose() } else { solve(&vectors, &DMatrix::identity(size, size)) };
        Ok(Some(Self { complex, real, vectors, inverse }))
    }

    /// Column of V of the first real eigenvalue.
    pub fn first_real(&self) -> usize {
        2 * self.complex.len()
    }

    /// Largest entry of the residual A V − V Λ, where Λ holds the blocks [[a, b], [−b, a]] and the real eigenvalues.
    pub fn residual(&self, order: &FirstOrder) -> f64 {
        if order.undamped {
            return 0.0;
        }
        let mut residual = &order.matrix * &self.vectors;
        for (i, value) in self.complex.iter().enumerate() {
            let (r, s) = (self.vectors.column(2 * i), self.vectors.column(2 * i + 1));
            let (first, second) = (r * value.re - s * value.im, r * value.im + s * value.re);
            residual.column_mut(2 * i).zip_apply(&first, |entry, product| *entry -= product);
            residual.column_mut(2 * i + 1).zip_apply(&second, |entry, product| *entry -= product);
        }
        for (column, value) in (self.first_real()..).zip(&self.real) {
            residual.column_mut(column).zip_apply(&self.vectors.column(column), |entry, x| *entry -= value * x);
        }
        residual.amax()
    }

    /// Largest condition number ‖left vectors‖·‖right vectors‖ of an invariant subspace; 1 for orthogonal subspaces.
    pub fn condition(&self) -> f64 {
        if self.inverse.iter().any(|entry| !entry.is_finite()) {
            return f64::INFINITY;
        }
        let mut largest: f64 = 1.0;
        for i in 0..self.complex.len() {
            let [a, b] = [2 * i, 2 * i + 1];
            let right = (self.vectors.column(a).norm_squared() + self.vectors.column(b).norm_squared()) / 2.0;
            let left = (self.inverse.row(a).norm_squared() + self.inverse.row(b).norm_squared()) / 2.0;
            largest = largest.max((left * right).sqrt());
        }
        for i in self.first_real()..self.vectors.ncols() {
            largest = largest.max(self.vectors.column(i).norm() * self.inverse.row(i).norm());
        }
        largest
    }
}

/// Real and imaginary part of a complex vector, scaled to length √2 and multiplied by the phase factor that makes the
/// two parts orthogonal.
fn orthogonal_parts(vector: impl Iterator<Item = Complex64> + Clone) -> [DVector<f64>; 2] {
    // v·v = (|r|² − |s|²) + 2i r·s. Half of its argument is the phase that makes r·s zero.
    let square: Complex64 = vector.clone().map(|value| value * value).sum();
    let norm: f64 = vector.clone().map(|value| value.norm_sqr()).sum::<f64>().sqrt();
    let phase = Complex64::from_polar(std::f64::consts::SQRT_2 / norm, -square.arg() / 2.0);
    let rotated: Vec<Complex64> = vector.map(|value| value * phase).collect();
    let part = |part: fn(&Complex64) -> f64| DVector::from_iterator(rotated.len(), rotated.iter().map(part));
    [part(|value| value.re), part(|value| value.im)]
}
