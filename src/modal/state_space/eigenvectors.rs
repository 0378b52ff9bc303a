//! Eigenvectors of the damped modes in undamped modal coordinates η.

use nalgebra::{Complex, DVector};

use super::first_order::FirstOrder;
use crate::linalg::{DecompositionError, eigen};
use crate::modal::undamped::RealModes;

/// Part of a vector outside of another one, relative to its length, below which the two are parallel.
const PARALLEL: f64 = 1e-6;

/// φ = Φη.
pub fn physical(real: &RealModes, coordinates: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let part = |part: fn(&Complex<f64>) -> f64| &real.vectors * coordinates.map(|value| part(&value));
    let (re, im) = (part(|value| value.re), part(|value| value.im));
    DVector::from_fn(re.len(), |i, _| Complex::new(re[i], im[i]))
}

/// Eigenvalues λ with Im λ ≥ 0, rad/s, and modal coordinates η of unit length, one vector per eigenvalue.
pub(in crate::modal) type Eigenvectors = (Vec<Complex<f64>>, Vec<DVector<Complex<f64>>>);

/// Unit vector of modal coordinate `index`.
fn unit_vector(len: usize, index: usize) -> DVector<Complex<f64>> {
    DVector::from_fn(len, |i, _| Complex::new(if i == index { 1.0 } else { 0.0 }, 0.0))
}

/// Eigenpairs of undamped modes.
pub fn undamped(real: &RealModes) -> Eigenvectors {
    let n = real.frequencies.len();
    let eigenvalues = real.frequencies.iter().map(|frequency| Complex::new(0.0, *frequency)).collect();
    (eigenvalues, (0..n).map(|i| unit_vector(n, i)).collect())
}

/// Eigenpairs of the first-order form of damped modes.
///
/// # Errors
/// [`DecompositionError`] if the eigenvalue iteration does not converge.
pub fn damped(real: &RealModes, order: &FirstOrder) -> Result<Eigenvectors, DecompositionError> {
    let n = real.frequencies.len();
    let FirstOrder { elastic, moving, matrix, .. } = order;
    let (e, m) = (elastic.len(), moving.len());
    let eigen = eigen(matrix)?;

    // λ = 0 for the position of each rigid-body mode. Where its velocity is coupled, it is part of `matrix`.
    let mut eigenvalues = vec![Complex::new(0.0, 0.0); n - e];
    let mut coordinates: Vec<_> = (0..n).filter(|i| real.frequencies[*i] == 0.0).map(|i| unit_vector(n, i)).collect();
    let round_off = f64::EPSILON * matrix.amax() * (e + m) as f64;
    for (value, vector) in eigen.values.iter().zip(eigen.vectors.column_iter()) {
        if value.im < 0.0 || (e < n && value.norm() <= round_off) {
            continue;
        }
        let mut eta = DVector::zeros(n);
        for (row, i) in moving.iter().enumerate() {
            eta[*i] = vector[e + row] / value;
        }
        for (row, i) in elastic.iter().enumerate() {
            eta[*i] = vector[row] / real.frequencies[*i];
        }
        if value.im != 0.0 && value.im <= round_off {
            // Two equal real eigenvalues: real and imaginary part of the vector belong to both.
            let norm = eta.norm();
            for part in real_vectors(&eta.unscale(norm)) {
                eigenvalues.push(Complex::from(value.re));
                coordinates.push(part);
            }
            continue;
        }
        let norm = eta.norm();
        eigenvalues.push(*value);
        coordinates.push(eta.unscale(norm));
    }
    Ok((eigenvalues, coordinates))
}

/// Two orthonormal real vectors in the space of the real and the imaginary part of a vector of unit length; twice the same one
/// if these are parallel.
fn real_vectors(vector: &DVector<Complex<f64>>) -> [DVector<Complex<f64>>; 2] {
    let parts = [vector.map(|value| value.re), vector.map(|value| value.im)];
    let order = if parts[0].norm() >= parts[1].norm() { [0, 1] } else { [1, 0] };
    let [larger, smaller] = order.map(|index| &parts[index]);
    let first = larger.normalize();
    let rest = smaller - &first * first.dot(smaller);
    let second = if rest.norm() > PARALLEL * smaller.norm() { rest.normalize() } else { first.clone() };
    [first, second].map(|part| part.map(Complex::from))
}
