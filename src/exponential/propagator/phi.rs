//! φ-functions: φ_0(z) = eᶻ, φ_{m+1}(z) = (φ_m(z) − 1/m!)/z, with φ_m(0) = 1/m!.
//!
//! Since ∫₀¹ e^{z(1−τ)} τᵐ dτ = m! φ_{m+1}(z), the response of a linear motion to a polynomial load is a sum of φ-functions
//! (Hochbruck and Ostermann 2010).

use num_complex::Complex64;

use crate::modal::ModePair;
use crate::numerics::INVERSE_FACTORIAL;

/// Number of functions, φ_0 to φ_5: enough for four stages and the defect of their polynomial.
pub const PHI_COUNT: usize = 6;
/// Below this |z| the upward recurrence cancels, and the series converges quickly.
const SERIES_RADIUS: f64 = 2.5;

/// A 2×2 matrix.
pub type Block = [[f64; 2]; 2];

/// m!.
pub fn factorial(m: usize) -> f64 {
    1.0 / INVERSE_FACTORIAL[m]
}

/// φ_0(z) to φ_{N−1}(z).
pub fn phi<const N: usize>(z: Complex64) -> [Complex64; N] {
    let mut values = [z.exp(); N];
    if z.norm() < SERIES_RADIUS {
        // The series gives the last function; the table of factorials suffices for round-off. Downward recurrence follows.
        let last = N - 1;
        let mut sum = Complex64::ZERO;
        for m in (last..INVERSE_FACTORIAL.len()).rev() {
            sum = sum * z + INVERSE_FACTORIAL[m];
        }
        values[last] = sum;
        for m in (1..last).rev() {
            values[m] = z * values[m + 1] + INVERSE_FACTORIAL[m];
        }
    } else {
        for m in 1..N {
            values[m] = (values[m - 1] - INVERSE_FACTORIAL[m - 1]) / z;
        }
    }
    values
}

/// φ_0 to φ_5 of the 2×2 matrix of a mode pair times `step`, s.
pub fn phi_of_pair(pair: &ModePair, step: f64) -> [Block; PHI_COUNT] {
    match pair {
        // The matrix a·1 + b·J with J² = −1 is the complex number a + ib.
        ModePair::Oscillation(value) => phi(value * step).map(|f| [[f.re, f.im], [-f.im, f.re]]),
        ModePair::Real(values) => {
            let [a, d] = values.map(|value| phi::<PHI_COUNT>(Complex64::new(value * step, 0.0)));
            std::array::from_fn(|m| [[a[m].re, 0.0], [0.0, d[m].re]])
        }
        // The off-diagonal entry of a function f of a triangular block is the divided difference (f(λ) − f(0))/λ. For
        // f = φ_m it is φ_{m+1}.
        ModePair::RigidBodyPair(rate) => {
            let f = phi::<{ PHI_COUNT + 1 }>(Complex64::new(rate * step, 0.0));
            std::array::from_fn(|m| [[INVERSE_FACTORIAL[m], step * f[m + 1].re], [0.0, f[m].re]])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_and_the_recurrence_agree() {
        for angle in 0..8 {
            let direction = Complex64::from_polar(1.0, f64::from(angle) * std::f64::consts::FRAC_PI_4);
            let (inside, outside) = (
                phi::<PHI_COUNT>(direction * (SERIES_RADIUS * (1.0 - 1e-15))),
                phi::<PHI_COUNT>(direction * (SERIES_RADIUS * (1.0 + 1e-15))),
            );
            for (a, b) in inside.iter().zip(&outside) {
                // At |z| = 2.5, five upward divisions cancel at most two digits.
                assert!((a - b).norm() < 1e-13 * a.norm().max(1e-2), "{direction}: {a} {b}");
            }
        }
    }

    #[test]
    fn values_match_their_definitions() {
        let z = Complex64::new(-30.0, 4.0);
        let values = phi::<PHI_COUNT>(z);
        assert!((values[1] - (z.exp() - 1.0) / z).norm() < 1e-15);
        assert!((values[2] - (z.exp() - 1.0 - z) / (z * z)).norm() < 1e-15);
        for (m, value) in phi::<PHI_COUNT>(Complex64::ZERO).iter().enumerate() {
            assert_eq!(value.re, 1.0 / factorial(m));
        }
    }
}
