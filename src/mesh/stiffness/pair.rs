//! Stiffness of one tooth pair along the path of contact.

use super::UniformCurve;
use crate::mesh::ContactPath;

/// Stiffness of a pair as a function of its position s.
#[derive(Clone, Debug)]
pub enum ToothPair {
    /// Constant along the path, N/m: the mesh stiffness is a square wave.
    Uniform(f64),
    /// Parabolic along the path, with the maximum in the middle.
    Parabolic {
        /// Stiffness in the middle of the path, N/m.
        middle: f64,
        /// Ratio of the stiffness at the ends to the stiffness in the middle.
        end_ratio: f64,
        /// Position of the middle of the path of contact at rest, m.
        centre: f64,
        /// Half length of the path of contact at rest, m.
        half_length: f64,
    },
    /// Contact and both teeth in series; the compliance of the teeth depends on the contact point.
    Teeth {
        /// Compliance of the contact, m/N.
        contact: f64,
        /// Compliance of the driver's tooth as a function of s, and of the driven tooth as a function of C sin α − s,
        /// m/N.
        teeth: Box<[UniformCurve; 2]>,
    },
}

impl ToothPair {
    /// Stiffness at the position `s`, N/m, and its derivatives with respect to s and to `tangent`, the length of the
    /// line of action between the base circles, m.
    #[inline]
    pub fn at(&self, s: f64, tangent: f64) -> [f64; 3] {
        match self {
            Self::Uniform(k) => [*k, 0.0, 0.0],
            Self::Parabolic { middle, end_ratio, centre, half_length } => {
                let x = (s - centre) / half_length;
                let drop = middle * (1.0 - end_ratio);
                let k = middle - drop * x * x;
                if k > 0.0 { [k, -2.0 * drop * x / half_length, 0.0] } else { [0.0; 3] }
            }
            Self::Teeth { contact, teeth } => {
                let ((driver, by_s), (driven, by_rest)) = (teeth[0].at(s), teeth[1].at(tangent - s));
                let k = 1.0 / (contact + driver + driven);
                [k, -k * k * (by_s - by_rest), -k * k * by_rest]
            }
        }
    }

    /// The pair with its stiffness multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Uniform(k) => Self::Uniform(k * factor),
            Self::Parabolic { middle, end_ratio, centre, half_length } => {
                Self::Parabolic { middle: middle * factor, end_ratio, centre, half_length }
            }
            Self::Teeth { contact, teeth } => {
                let teeth = Box::new(teeth.map(|curve| curve.scaled(1.0 / factor)));
                Self::Teeth { contact: contact / factor, teeth }
            }
        }
    }

    /// The largest of 65 samples of the stiffness on the path of contact, N/m.
    pub fn largest(&self, path: &ContactPath) -> f64 {
        let place = |i: i32| path.low + (path.high - path.low) * f64::from(i) / 64.0;
        (0..=64).map(|i| self.at(place(i), path.tangent)[0]).fold(0.0, f64::max)
    }
}
