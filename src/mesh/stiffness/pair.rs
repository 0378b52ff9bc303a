//! Stiffness of one pair of teeth along the path of contact.

use super::UniformCurve;

/// Stiffness of a pair over its position s.
#[derive(Clone, Debug)]
pub enum Pair {
    /// The same along the path, N/m: a square wave once pairs come and go.
    Uniform(f64),
    /// Largest in the middle of the path, falling as a parabola towards its ends.
    Parabolic {
        /// In the middle, N/m.
        middle: f64,
        /// At the ends, as a part of that.
        end_ratio: f64,
        /// Middle and half length of the path of contact at rest, m.
        path: (f64, f64),
    },
    /// Tabulated from the teeth.
    Tabulated(UniformCurve),
}

impl Pair {
    /// Stiffness and its slope at `s`.
    #[inline]
    pub fn at(&self, s: f64) -> (f64, f64) {
        match self {
            Self::Uniform(k) => (*k, 0.0),
            Self::Parabolic { middle, end_ratio, path: (centre, half) } => {
                let x = (s - centre) / half;
                let drop = middle * (1.0 - end_ratio);
                let k = middle - drop * x * x;
                if k > 0.0 { (k, -2.0 * drop * x / half) } else { (0.0, 0.0) }
            }
            Self::Tabulated(curve) => curve.at(s),
        }
    }

    /// The same pair, `factor` times as stiff.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Uniform(k) => Self::Uniform(k * factor),
            Self::Parabolic { middle, end_ratio, path } => Self::Parabolic { middle: middle * factor, end_ratio, path },
            Self::Tabulated(curve) => Self::Tabulated(curve.scaled(factor)),
        }
    }

    /// ∫k ds from `low` to `high`, by Simpson's rule, exact for the polynomials that these are between knots.
    pub fn integral(&self, low: f64, high: f64) -> f64 {
        const PIECES: usize = 512;
        let h = (high - low) / PIECES as f64;
        let at = |i: f64| self.at(low + i * h).0;
        (0..PIECES).map(|i| i as f64).map(|i| (at(i) + 4.0 * at(i + 0.5) + at(i + 1.0)) * h / 6.0).sum()
    }

    /// The largest stiffness between `low` and `high`, to the resolution of a table.
    pub fn largest(&self, low: f64, high: f64) -> f64 {
        (0..=64).map(|i| self.at(low + (high - low) * f64::from(i) / 64.0).0).fold(0.0, f64::max)
    }
}
