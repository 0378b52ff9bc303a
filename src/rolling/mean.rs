//! Force of the rolling elements averaged over the angles of the cage.
//!
//! The average of n discrete elements over the cage angle is an integral over the loaded zone (Sjövall 1933). The force
//! points along the displacement u. With r = |u|, h(ψ) = r cos ψ − g and the end ψ_l of the loaded zone, where h = 0,
//!
//! ```text
//! F = r k_t u/r,    k_r = (nKp/π) ∫₀^{ψ_l} h^{p−1} cos²ψ dψ,    k_t = (nKp/π) ∫₀^{ψ_l} h^{p−1} sin²ψ dψ
//! ```
//!
//! with the stiffness k_r along u and k_t across it. The formula of F follows from ∫ h^p cos ψ dψ by parts; it is
//! accurate at u = 0 as well.

use std::f64::consts::PI;

use super::{GAUSS, RollingElements};
use crate::bearing_force::{BearingForce, Vector};

impl RollingElements {
    /// Force, stiffness and damping of a shaft at rest, averaged over the angles of the cage, at a displacement, m.
    pub fn mean(&self, u: Vector) -> BearingForce {
        let r = u[0].hypot(u[1]);
        let [along, across] = self.mean_stiffness(r);
        let (unit, difference) = (if r > 0.0 { [u[0] / r, u[1] / r] } else { [1.0, 0.0] }, along - across);
        let entry = |i: usize, j: usize| difference * unit[i] * unit[j] + if i == j { across } else { 0.0 };
        BearingForce {
            force: u.map(|u| across * u),
            stiffness: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
            damping: self.damping,
        }
    }

    /// Stiffness along and across a displacement of the size r, m, averaged over the angles of the cage, N/m.
    fn mean_stiffness(&self, r: f64) -> [f64; 2] {
        if r <= self.gap {
            return [0.0; 2];
        }
        let (exponent, is_partial) = (self.contact.exponent, self.gap >= -r);
        let end = if is_partial { (self.gap / r).acos() } else { PI };
        let power = if is_partial { self.contact.grading() } else { 1.0 };
        let (mut along, mut across) = (0.0, 0.0);
        for &(x, weight) in GAUSS.iter() {
            let left = end * (1.0 - x).powf(power);
            let angle = end - left;
            // r (cos ψ − cos ψ_l), without cancellation at the end of the loaded zone.
            let partial = 2.0 * r * (end - left / 2.0).sin() * (left / 2.0).sin();
            let approach = if is_partial { partial } else { r * angle.cos() - self.gap };
            let density = weight * end * power * (1.0 - x).powf(power - 1.0) * approach.powf(exponent - 1.0);
            along += density * angle.cos().powi(2);
            across += density * angle.sin().powi(2);
        }
        let scale = self.count() as f64 * self.contact.stiffness * exponent / PI;
        [scale * along, scale * across]
    }
}
