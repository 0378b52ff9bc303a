//! Anderson acceleration of a fixed-point iteration z ← z + g(z) (Walker and Ni, SIAM J. Numer. Anal. 49, 2011).
//!
//! For an affine g it finds the same iterates as GMRES, and needs no product with the Jacobian: every evaluation of g is
//! an iteration. For a nonlinear g it is a quasi-Newton method with the secants of all iterations.

use nalgebra::{DMatrix, DVector};

use crate::numerics::ROUND_OFF;

/// The secants of an iteration.
#[derive(Debug, Default)]
pub struct Anderson {
    /// Last point and its correction.
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// Differences of points and of corrections, the oldest first.
    secants: Vec<(DVector<f64>, DVector<f64>)>,
}

impl Anderson {
    /// The next point after `z` with the correction `g` = g(z). A change of the corrections below `noise` is that of their
    /// errors, and gives no secant.
    pub fn next(&mut self, z: &[f64], g: &[f64], noise: f64) -> Vec<f64> {
        let (z, g) = (DVector::from_column_slice(z), DVector::from_column_slice(g));
        if let Some((z_before, g_before)) = self.last.take() {
            let change = &g - g_before;
            if change.norm() >= noise {
                self.secants.push((&z - z_before, change));
            }
        }
        let next = self.minimum(&z, &g);
        self.last = Some((z, g));
        next.as_slice().to_vec()
    }

    /// The point z + g − Σ γ (Δz + Δg) with the smallest |g − Σ γ Δg|.
    fn minimum(&self, z: &DVector<f64>, g: &DVector<f64>) -> DVector<f64> {
        let count = self.secants.len();
        if count == 0 {
            return z + g;
        }
        let norms: Vec<f64> = self.secants.iter().map(|(_, change)| change.norm().max(f64::MIN_POSITIVE)).collect();
        let matrix = DMatrix::from_fn(g.len(), count, |row, column| self.secants[column].1[row] / norms[column]);
        let weights = matrix.svd(true, true).solve(g, ROUND_OFF).unwrap_or_else(|_| DVector::zeros(count));
        let mut next = z + g;
        for ((weight, norm), (step, change)) in weights.iter().zip(&norms).zip(&self.secants) {
            let factor = weight / norm;
            next.axpy(-factor, step, 1.0);
            next.axpy(-factor, change, 1.0);
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_affine_map_takes_as_many_steps_as_it_has_dimensions() {
        let a = DMatrix::from_fn(5, 5, |i, j| 0.3 * ((3 * i + 5 * j) as f64).sin());
        let b = DVector::from_fn(5, |i, _| i as f64 + 1.0);
        let (mut iteration, mut z) = (Anderson::default(), vec![0.0; 5]);
        for _ in 0..7 {
            let at = DVector::from_column_slice(&z);
            let g = &a * &at + &b - &at;
            z = iteration.next(&z, g.as_slice(), 0.0);
        }
        let at = DVector::from_column_slice(&z);
        assert!((&a * &at + &b - at).norm() < 1e-10);
    }
}
