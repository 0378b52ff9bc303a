//! Accurate shaft angles in long runs, by products in double-double precision.

use num_complex::Complex64;

/// A double-double number: the unevaluated sum of two numbers (Dekker 1971).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    /// The number, rounded.
    pub high: f64,
    /// The rounding error.
    pub low: f64,
}

impl DoubleDouble {
    /// Exact product a·b.
    pub fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
        let low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low;
        Self { high, low }
    }

    /// Exact sum a + b (Knuth).
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self { high, low: (a - (high - of_b)) + (b - of_b) }
    }

    /// Quotient a/n.
    pub fn quotient(a: f64, n: f64) -> Self {
        let high = a / n;
        let product = Self::product(high, n);
        Self { high, low: ((a - product.high) - product.low) / n }
    }

    /// Sum of both numbers.
    pub fn plus(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        Self::sum(sum.high, sum.low + (self.low + other.low))
    }

    /// Product of both numbers.
    pub fn times(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        Self::sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }

    /// Phasor e^{iϑ} of this angle ϑ, rad.
    pub fn phasor(self) -> Complex64 {
        Complex64::from_polar(1.0, self.high) * Complex64::from_polar(1.0, self.low)
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

/// Phasor e^{iΩt}. The product Ωt includes its rounding error. Without it, the angle error at Ωt = 1e8 rad would be
/// 1e-8 rad.
pub fn phasor(spin: f64, time: f64) -> Complex64 {
    if !(spin * time).is_finite() {
        return Complex64::new(f64::NAN, f64::NAN);
    }
    DoubleDouble::product(spin, time).phasor()
}

/// The upper and the lower half of the digits of a number (Veltkamp).
fn split(value: f64) -> (f64, f64) {
    let shifted = value * 134_217_729.0;
    let high = shifted - (shifted - value);
    (high, value - high)
}
