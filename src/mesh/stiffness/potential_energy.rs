//! Stiffness of a tooth pair by the potential energy method: each tooth is a cantilever on an elastic gear body.
//!
//! Bending, shear and axial compression follow Yang and Lin (1987) and Tian (2004). The tooth profile is an involute
//! down to the base circle and straight from the base circle to the root circle. Fillet and gear body follow Sainsot, Velex
//! and Duverger (2004). The contact follows Yang and Sun (1985). Stiffness is per face width; compliance is times face
//! width.

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::numerics::gauss;
use crate::scene::{Gear, STEEL, STEEL_POISSON_RATIO};

/// Compliance of the contact of two flanks of steel times face width, m²/N.
pub const CONTACT_COMPLIANCE: f64 =
    4.0 * (1.0 - STEEL_POISSON_RATIO * STEEL_POISSON_RATIO) / (PI * STEEL.youngs_modulus);
/// Shear correction of a rectangular section.
const SHEAR_CORRECTION: f64 = 1.2;

/// Polynomials of the fillet-foundation deflection: A/θ² + B h² + C h/θ + D/θ + E h + F for L*, M*, P*, Q*.
const FOUNDATION_POLYNOMIALS: [[f64; 6]; 4] = [
    [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
    [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
    [-50.952e-5, 185.50e-3, 0.0538e-4, 53.3e-3, 0.2895, 0.9236],
    [-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904],
];

/// Number of pieces of the profile of a tooth.
const PROFILE_PIECES: usize = 8;
/// Points of the Gauss rule on each piece of the profile.
const GAUSS_POINTS: usize = 8;

/// One tooth of a gear.
#[derive(Clone, Copy, Debug)]
pub struct Tooth {
    base_radius: f64,
    root_radius: f64,
    bore_radius: f64,
    /// Half the angle of the tooth at the base circle, rad.
    half_angle: f64,
}

impl Tooth {
    /// A tooth of `gear`, whose body is clamped at `bore_radius`.
    pub fn new(gear: &Gear, bore_radius: f64) -> Self {
        Self {
            base_radius: gear.base_radius,
            root_radius: gear.root_radius(),
            bore_radius,
            half_angle: gear.half_angle(),
        }
    }

    /// Height above the centre and half thickness of the flank at the roll angle `roll`.
    fn flank(&self, roll: f64) -> (f64, f64) {
        let (sin, cos) = (roll - self.half_angle).sin_cos();
        (self.base_radius * (cos + roll * sin), self.base_radius * (roll * cos - sin))
    }

    /// Compliance along the line of action times face width, m²/N. The contact point has the distance
    /// `rolling_displacement` (m) along the line of action from the base circle.
    ///
    /// A smooth engagement begins slightly below the larger one of base circle and root circle. The formulas continue
    /// smoothly there.
    pub fn compliance(&self, rolling_displacement: f64) -> f64 {
        self.flexure(rolling_displacement) + self.foundation(rolling_displacement)
    }

    /// Compliance of the tooth alone by bending, shear and compression, times face width, m²/N.
    pub fn flexure(&self, rolling_displacement: f64) -> f64 {
        let roll = rolling_displacement / self.base_radius;
        let (sin, cos) = (roll - self.half_angle).sin_cos();
        let (contact, lever) = self.flank(roll);
        let shear_modulus = STEEL.youngs_modulus / (2.0 * (1.0 + STEEL_POISSON_RATIO));
        // Energy of a unit force in a slice at the height x with the half thickness h.
        let slice = |x: f64, h: f64| {
            let moment = cos * (contact - x) - sin * lever;
            let inertia = 2.0 / 3.0 * h.powi(3);
            moment * moment / (STEEL.youngs_modulus * inertia)
                + SHEAR_CORRECTION * cos * cos / (2.0 * shear_modulus * h)
                + sin * sin / (2.0 * STEEL.youngs_modulus * h)
        };
        // Along the involute from the larger one of base circle and root circle; x' = r_b·roll·cos(roll − half_angle).
        let lowest = ((self.root_radius / self.base_radius).powi(2) - 1.0).max(0.0).sqrt();
        let involute = integral(lowest, roll, |angle| {
            let (x, h) = self.flank(angle);
            slice(x, h) * self.base_radius * angle * (angle - self.half_angle).cos()
        });
        let (foot, width) = self.flank(0.0);
        let straight =
            if self.root_radius < foot { integral(self.root_radius, foot, |x| slice(x, width)) } else { 0.0 };
        involute + straight
    }

    /// Compliance of the fillet and the gear body times face width, m²/N.
    pub fn foundation(&self, rolling_displacement: f64) -> f64 {
        let roll = rolling_displacement / self.base_radius;
        let (sin, cos) = (roll - self.half_angle).sin_cos();
        let (contact, lever) = self.flank(roll);
        let (theta, h) = (self.root_angle(), self.root_radius / self.bore_radius);
        let [l, m, p, q] = FOUNDATION_POLYNOMIALS
            .map(|[a, b, c, d, e, f]| a / (theta * theta) + b * h * h + c * h / theta + d / theta + e * h + f);
        let arc = 2.0 * theta * self.root_radius;
        // Height above the root circle at which the line of action intersects the axis of the tooth.
        let reach = (contact - lever * sin / cos - self.root_radius) / arc;
        let tangent = sin / cos;
        cos * cos / STEEL.youngs_modulus * (l * reach * reach + m * reach + p * (1.0 + q * tangent * tangent))
    }

    /// Half the angle of the tooth at the root circle.
    fn root_angle(&self) -> f64 {
        if self.root_radius > self.base_radius {
            let roll = ((self.root_radius / self.base_radius).powi(2) - 1.0).sqrt();
            let (x, h) = self.flank(roll);
            h.atan2(x)
        } else {
            self.half_angle
        }
    }
}

/// Integral by a Gauss rule on each of [`PROFILE_PIECES`].
fn integral(from: f64, to: f64, integrand: impl Fn(f64) -> f64) -> f64 {
    static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss(GAUSS_POINTS));
    let length = (to - from) / PROFILE_PIECES as f64;
    let piece = |begin: f64| RULE.iter().map(|(at, weight)| weight * integrand(begin + at * length)).sum::<f64>();
    (0..PROFILE_PIECES).map(|index| piece(from + index as f64 * length)).sum::<f64>() * length
}
