//! Shaft angles of long runs without the round-off of a large product.

use num_complex::Complex64;

/// A number of twice the digits, the unevaluated sum of two (Dekker 1971).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    /// The number, rounded.
    pub high: f64,
    /// The rounding error.
    pub low: f64,
}

impl DoubleDouble {
    /// a·b, exact.
    pub fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
        let low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low;
        Self { high, low }
    }

    /// a + b, exact (Knuth).
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self { high, low: (a - (high - of_b)) + (b - of_b) }
    }

    /// a/n.
    pub fn quotient(a: f64, n: f64) -> Self {
        let high = a / n;
        let product = Self::product(high, n);
        Self { high, low: ((a - product.high) - product.low) / n }
    }

    /// The sum with another.
    pub fn plus(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        Self::sum(sum.high, sum.low + (self.low + other.low))
    }

    /// The product with another.
    pub fn times(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        Self::sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }

    /// e^{iϑ} of this angle.
    pub fn turn(self) -> Complex64 {
        Complex64::from_polar(1.0, self.high) * Complex64::from_polar(1.0, self.low)
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

/// e^{iΩt} for any t: the product Ωt is taken with its rounding error, which at Ωt = 1e8 rad would otherwise turn the
/// shaft by 1e-8 rad.
pub fn phase(spin: f64, time: f64) -> Complex64 {
    if !(spin * time).is_finite() {
        return Complex64::new(f64::NAN, f64::NAN);
    }
    DoubleDouble::product(spin, time).turn()
}

/// The upper and the lower half of the digits of a number (Veltkamp).
fn split(value: f64) -> (f64, f64) {
    let shifted = value * 134_217_729.0;
    let high = shifted - (shifted - value);
    (high, value - high)
}
