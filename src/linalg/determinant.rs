//! Determinants whose magnitude neither overflows nor underflows.

use std::ops::Range;

use num_complex::Complex64;

/// Magnitudes of partial products of a determinant.
const PARTIAL_PRODUCT_RANGE: Range<f64> = 1e-140..1e140;

/// A determinant as a phase factor and the logarithm of its magnitude, which neither overflow nor underflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Determinant {
    /// Number of magnitude one.
    pub phase: Complex64,
    /// Natural logarithm of the magnitude.
    pub logarithm: f64,
}

impl Determinant {
    /// Product of numbers.
    pub fn product(factors: impl Iterator<Item = Complex64>) -> Self {
        let (mut product, mut logarithm) = (Complex64::ONE, 0.0);
        for factor in factors {
            let next = product * factor;
            // Few products need their magnitude, which takes longer than a multiplication.
            if PARTIAL_PRODUCT_RANGE.contains(&next.l1_norm()) {
                product = next;
                continue;
            }
            let sizes = [product.norm(), factor.norm()];
            logarithm += sizes[0].ln() + sizes[1].ln();
            product = (product / sizes[0]) * (factor / sizes[1]);
        }
        let size = product.norm();
        Self { phase: product / size, logarithm: logarithm + size.ln() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_determinant_neither_overflows_nor_underflows() {
        for size in [1e-200, 1e200, 1.0] {
            let factors = std::iter::repeat_n(Complex64::new(0.0, -size), 1001);
            let found = Determinant::product(factors);
            assert!((found.phase - Complex64::new(0.0, -1.0)).norm() < 1e-12);
            assert!((found.logarithm - 1001.0 * size.ln()).abs() <= 1e-12 * found.logarithm.abs());
        }
    }
}
