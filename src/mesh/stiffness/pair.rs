//! Stiffness of one pair of teeth along the path of contact.

use super::{ContactPath, UniformCurve};

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
    /// From the compliance of either tooth over where it is touched.
    Teeth {
        /// Compliance of the contact, m/N.
        contact: f64,
        /// Compliance of the driver's tooth over s, and of the driven one over C sin α − s, m/N.
        teeth: Box<[UniformCurve; 2]>,
    },
}

impl Pair {
    /// Stiffness at `s` where the line of action between the base circles is `tangent` long, and its slopes over both.
    #[inline]
    pub fn at(&self, s: f64, tangent: f64) -> [f64; 3] {
        match self {
            Self::Uniform(k) => [*k, 0.0, 0.0],
            Self::Parabolic { middle, end_ratio, path: (centre, half) } => {
                let x = (s - centre) / half;
                let drop = middle * (1.0 - end_ratio);
                let k = middle - drop * x * x;
                if k > 0.0 { [k, -2.0 * drop * x / half, 0.0] } else { [0.0; 3] }
            }
            Self::Teeth { contact, teeth } => {
                let ((driver, by_s), (driven, by_rest)) = (teeth[0].at(s), teeth[1].at(tangent - s));
                let k = 1.0 / (contact + driver + driven);
                [k, -k * k * (by_s - by_rest), -k * k * by_rest]
            }
        }
    }

    /// The same pair, `factor` times as stiff.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Uniform(k) => Self::Uniform(k * factor),
            Self::Parabolic { middle, end_ratio, path } => Self::Parabolic { middle: middle * factor, end_ratio, path },
            Self::Teeth { contact, teeth } => {
                let teeth = Box::new(teeth.map(|curve| curve.scaled(1.0 / factor)));
                Self::Teeth { contact: contact / factor, teeth }
            }
        }
    }

    /// The largest stiffness on the path of contact, to the resolution of a table.
    pub fn largest(&self, path: &ContactPath) -> f64 {
        let place = |i: i32| path.low + (path.high - path.low) * f64::from(i) / 64.0;
        (0..=64).map(|i| self.at(place(i), path.tangent)[0]).fold(0.0, f64::max)
    }
}
