//! M √(M⁻¹K) x, the force of modal damping but for the factor 2ζ, in time proportional to n.
//!
//! A quadrature of Cauchy's integral is a rational function of K and M (Hale, Higham and Trefethen, SIAM J. Numer. Anal. 46,
//! 2008, section 4, method 3):
//!
//! ```text
//! √A ≈ Σ w_j A (A + s_j)⁻¹,    A = M⁻¹K,    s_j = (ω₁ sc(u_j))²,    w_j = 2 K' ω₁ dn(u_j)/(π N cn²(u_j))
//! ```
//!
//! with the Jacobi functions of the modulus √(1 − (ω₁/ω₂)²), the quarter period K' and u_j = (j − ½) K'/N. For frequencies
//! between ω₁ and ω₂ its relative error is 4 exp(−2π² N/(2 ln(ω₂/ω₁) + 3)).

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::spectral_range::ShiftInverse;
use crate::linalg::DecompositionError;
use crate::model::Model;

/// Relative error of the square root.
const ACCURACY: f64 = 1e-10;
/// Number of steps of the arithmetic-geometric mean, which converges quadratically.
const MEANS: usize = 10;

/// √(M⁻¹K) of the symmetric part of the stiffness.
pub struct SquareRoot<'m> {
    model: &'m Model,
    /// w_j, rad/s, and the factors of K + s_j M.
    terms: Vec<(f64, ShiftInverse<'m>)>,
}

impl<'m> SquareRoot<'m> {
    /// The square root for motions with frequencies between `lowest` and `highest`, rad/s, with the loaded flanks of `speed`
    /// (reference shaft, rad/s).
    pub fn new(model: &'m Model, speed: f64, [lowest, highest]: [f64; 2]) -> Result<Self, DecompositionError> {
        let terms = quadrature([lowest, highest], ACCURACY);
        let term = |(weight, shift)| ShiftInverse::new(model, speed, shift).map(|inverse| (weight, inverse));
        Ok(Self { model, terms: terms.map(term).collect::<Result<_, _>>()? })
    }

    /// M √(M⁻¹K) X, n × m.
    pub fn times(&self, columns: &DMatrix<f64>) -> Result<DMatrix<f64>, DecompositionError> {
        let momenta = self.model.mass_times(columns);
        let mut sum = DMatrix::zeros(columns.nrows(), columns.ncols());
        for (weight, inverse) in &self.terms {
            // A (A + s)⁻¹ x = x − s (K + sM)⁻¹ M x.
            let shift = inverse.shift * inverse.shift;
            sum += (columns - inverse.solve_columns(&momenta)? * shift) * *weight;
        }
        Ok(self.model.mass_times(&sum))
    }

    /// √(M⁻¹K) x, n entries. The solutions are not refined: their round-off is far below the error of the quadrature.
    pub fn apply(&self, x: &DVector<Complex64>) -> DVector<Complex64> {
        let momentum = self.model.product(x, |x, out| self.model.multiply_mass(x, out));
        let momentum = self.model.to_circular(momentum.as_slice());
        let (mut sum, mut total) = (vec![Complex64::ZERO; x.len()], 0.0);
        for (weight, inverse) in &self.terms {
            let factor = weight * inverse.shift * inverse.shift;
            let mut solution = momentum.clone();
            inverse.factors.solve_once(&mut solution);
            sum.iter_mut().zip(&solution).for_each(|(sum, value)| *sum += value * factor);
            total += weight;
        }
        x * Complex64::from(total) - DVector::from_vec(self.model.from_circular(&sum))
    }
}

/// Weights w_j and roots √s_j of the shifts, rad/s, for frequencies between `lowest` and `highest`, rad/s.
fn quadrature([lowest, highest]: [f64; 2], accuracy: f64) -> impl Iterator<Item = (f64, f64)> {
    let modulus = (lowest / highest).min(0.5);
    let size = (4.0 / accuracy).ln() * (3.0 - 2.0 * modulus.ln()) / (2.0 * PI * PI);
    let number = size.ceil().max(1.0);
    let functions = Jacobi::new(modulus);
    (0..number as usize).map(move |index| {
        let [sn, cn, dn] = functions.at((index as f64 + 0.5) / number * functions.period);
        (2.0 * functions.period * lowest * dn / (PI * number * cn * cn), lowest * sn / cn)
    })
}

/// Jacobi's elliptic functions by descending Landen transformations (Abramowitz and Stegun 1964, section 16.4).
struct Jacobi {
    /// Arithmetic means and half differences.
    means: Vec<[f64; 2]>,
    /// Quarter period.
    period: f64,
}

impl Jacobi {
    /// The functions of the modulus √(1 − k²) for k = `complementary`.
    fn new(complementary: f64) -> Self {
        let mut means = vec![[1.0, (1.0 - complementary * complementary).sqrt()]];
        let (mut arithmetic, mut geometric) = (1.0_f64, complementary);
        for _ in 0..MEANS {
            let next = f64::midpoint(arithmetic, geometric);
            let difference = (arithmetic - geometric) / 2.0;
            geometric = (arithmetic * geometric).sqrt();
            arithmetic = next;
            means.push([arithmetic, difference]);
        }
        Self { means, period: PI / (2.0 * arithmetic) }
    }

    /// sn, cn and dn at `u`.
    fn at(&self, u: f64) -> [f64; 3] {
        let last = self.means.len() - 1;
        let mut angle = f64::from(1_u32 << last) * self.means[last][0] * u;
        let mut previous = angle;
        for [mean, difference] in self.means[1..].iter().rev() {
            previous = angle;
            angle = f64::midpoint(angle, (difference / mean * angle.sin()).asin());
        }
        [angle.sin(), angle.cos(), angle.cos() / (previous - angle).cos()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_is_the_square_root_over_the_range() {
        for range in [[1.0, 1.5], [3.0, 30.0], [20.0, 1.6e7]] {
            let terms: Vec<(f64, f64)> = quadrature(range, 1e-10).collect();
            assert!(terms.len() < 45);
            for part in 0..=50 {
                let frequency = range[0] * (range[1] / range[0]).powf(f64::from(part) / 50.0);
                let square = frequency * frequency;
                let root: f64 = terms.iter().map(|(weight, shift)| weight * square / (square + shift * shift)).sum();
                assert!((root / frequency - 1.0).abs() < 2e-10, "{range:?}, {frequency}: {root}");
            }
        }
    }
}
