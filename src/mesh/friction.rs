//! Sliding friction between the flanks, across the line of action.
//!
//! The flanks of pair j slide at v_j = (|Ω_a| + |Ω_b|)(s_j − s_C), where s_C = r_a C sin α/S is the pitch point of the moving
//! centres. With the share φ_j of the pair in the mesh force F, the friction on the driven gear along m (perpendicular to
//! the line of action, from the centre of the driver to its tangent point) and its moments about both centres are
//!
//! ```text
//! f = μ|F|/cos β_b · d Σ φ_j g_j,    M_a = σ μ|F|/cos β_b · d Σ φ_j g_j s_j,    M_b = σ μ|F|/cos β_b · d Σ φ_j g_j (C sin α − s_j)
//! ```
//!
//! The driver is subject to −f. d = −σ sgn Ω_a is −1 on the drive flank, and 1 if the driver is internal and so slides the other
//! way; lengths have the signs of `involute.rs`. g_j is the sign of s_j − s_C, which changes within a
//! given length of the path of contact about the pitch point by a twice differentiable polynomial.
//!
//! The prescribed rotation decides on the direction of sliding: the velocity of a vibration shifts the change of sign by
//! tan α times this velocity over |Ω_a| + |Ω_b|, which is neglected (Vaishya and Singh 2001). The dissipated power contains all
//! velocities. A stiffness without tooth pairs has the mean of the sums over the mesh cycle, with the centres at rest and all
//! touching pairs loaded equally.

use super::contact::ShaftPhase;
use super::contact_path::ContactPath;
use super::involute::{Involute, LineOfAction};
use super::stiffness::{Stiffness, smooth_step};
use crate::numerics::gauss;
use crate::scene::{self, FrictionLaw, Gear};

/// Sums over the tooth pairs per unit of μF.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionSums {
    /// Σ φ g.
    pub force: f64,
    /// Σ φ g s, m: arm about the centre of the driver.
    pub driver: f64,
    /// Σ φ g (C sin α − s), m: arm about the centre of the driven gear.
    pub driven: f64,
}

impl FrictionSums {
    fn plus(&self, factor: f64, other: &Self) -> Self {
        Self {
            force: self.force + factor * other.force,
            driver: self.driver + factor * other.driver,
            driven: self.driven + factor * other.driven,
        }
    }
}

/// Friction of a flank at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionForce {
    /// Force on the driven gear along m, N.
    pub force: f64,
    /// Moments about the centres of driver and driven gear, N m.
    pub moments: [f64; 2],
}

/// The friction of a mesh.
#[derive(Clone, Debug)]
pub struct Friction {
    law: FrictionLaw,
    /// Half of the length of the path of contact over which the friction changes its sign, m.
    half_width: f64,
    /// Base radius of the driver over the sum of the base radii.
    pitch_point: f64,
    /// Direction of sliding against that of external gears: −1 if the driver is internal.
    direction: f64,
    /// Cosine of the base helix angle β_b.
    cosine: f64,
    /// Mean sums of a stiffness without tooth pairs.
    mean: Option<FrictionSums>,
    /// What turns with the driver if nothing holds its rotation: the coordinates with their shares Mφ/(φᵀMφ) of a torque that
    /// acts on all inertias, for the rigid-body rotation φ with the value 1 at the driver. Otherwise empty.
    pub rotation: Vec<(usize, f64)>,
}

impl Friction {
    /// The friction of a pair of gears with the stiffness `teeth`.
    pub(super) fn new(given: &scene::Friction, pair: [&Gear; 2], involute: &Involute, teeth: &Stiffness) -> Self {
        let mut friction = Self {
            law: given.law,
            half_width: given.transition * involute.base_pitch / 2.0,
            pitch_point: involute.base_radius[0] / involute.base_circles(),
            direction: (involute.base_circles() * involute.base_radius[1]).signum(),
            cosine: pair[0].base_helix_angle().cos(),
            mean: None,
            rotation: Vec::new(),
        };
        if !teeth.has_pairs() {
            let path = involute.path_at_rest();
            let even = Stiffness::even(&path);
            friction.mean = Some(friction.cycle_mean(&path, |path| friction.sums_of(&even, path, path.engaged(), 1.0)));
        }
        friction
    }

    /// Whether the friction follows the tooth pairs.
    pub fn follows_pairs(&self) -> bool {
        self.mean.is_none()
    }

    /// The sums over the pairs of a flank, or their mean.
    pub(super) fn sums(
        &self,
        teeth: &Stiffness,
        path: impl FnOnce() -> ContactPath,
        engaged: (i64, i64),
        deflection: f64,
    ) -> FrictionSums {
        self.mean.unwrap_or_else(|| self.sums_of(teeth, &path(), engaged, deflection))
    }

    fn sums_of(&self, teeth: &Stiffness, path: &ContactPath, engaged: (i64, i64), deflection: f64) -> FrictionSums {
        let (pitch_point, half) = (self.pitch_point * path.tangent, self.half_width);
        let (mut total, mut sums) = (0.0, FrictionSums::default());
        teeth.visit_loads(path, engaged, deflection, [pitch_point - half, pitch_point + half], |s, load| {
            total += load;
            let own = load * sign((s - pitch_point) / half);
            sums = sums.plus(own, &FrictionSums { force: 1.0, driver: s, driven: path.tangent - s });
        });
        if total > 0.0 { FrictionSums::default().plus(1.0 / total, &sums) } else { FrictionSums::default() }
    }

    /// Coefficient of friction under the force F of the transverse section, N, at the spin of the driver, rad/s.
    pub fn coefficient(&self, force: f64, spin: f64, tangent: f64) -> f64 {
        let radii = [self.pitch_point, 1.0 - self.pitch_point].map(|share| share * tangent);
        self.law.coefficient(force, spin, radii, self.cosine)
    }

    /// Friction of a flank with the mesh force F of the transverse section, N.
    #[inline]
    pub(super) fn force(
        &self,
        sigma: f64,
        line: &LineOfAction,
        phases: &[ShaftPhase; 2],
        force: f64,
        sums: &FrictionSums,
    ) -> FrictionForce {
        let spin = phases[0].spin;
        if spin == 0.0 {
            return FrictionForce::default();
        }
        let direction = -spin.signum() * self.direction;
        let size = self.coefficient(force, spin, line.tangent) * force.abs() / self.cosine * direction;
        FrictionForce { force: sigma * size * sums.force, moments: [size * sums.driver, size * sums.driven] }
    }

    /// Power that the friction of a flank dissipates, W, with the mean sums of a mesh cycle.
    pub(super) fn mean_loss(&self, force: f64, spins: [f64; 2], tangent: f64, sums: &FrictionSums) -> f64 {
        let size = self.coefficient(force, spins[0], tangent) * force.abs() / self.cosine;
        size * (spins[0] * sums.driver + spins[1] * sums.driven).abs()
    }

    /// Mean over the mesh cycle of sums that depend on the position of the pairs on a path of contact: a Gauss rule on pieces
    /// between the positions at which pairs enter or leave, or the friction begins or ends to change its sign.
    pub(super) fn cycle_mean(&self, path: &ContactPath, at: impl Fn(&ContactPath) -> FrictionSums) -> FrictionSums {
        let (pitch_point, half) = (self.pitch_point * path.tangent, self.half_width);
        let mut marks = vec![0.0, path.pitch];
        for end in [path.low, path.high, pitch_point - half, pitch_point + half] {
            marks.extend([-0.5, 0.5].map(|part| (end + part * path.overlap).rem_euclid(path.pitch)));
        }
        marks.sort_by(f64::total_cmp);
        let rule = gauss(5);
        let mut mean = FrictionSums::default();
        for ends in marks.windows(2) {
            let length = (ends[1] - ends[0]) / MEAN_PIECES as f64;
            for piece in 0..MEAN_PIECES {
                for (part, weight) in &rule {
                    let position = ends[0] + (piece as f64 + part) * length;
                    mean = mean.plus(weight * length / path.pitch, &at(&ContactPath { position, ..*path }));
                }
            }
        }
        mean
    }
}

/// Number of pieces between two marks of a mean over the mesh cycle. The ramps of an engagement end within them: the error of
/// the mean is then below 1e-6.
const MEAN_PIECES: usize = 16;

/// The sign of x, with the ramp of the tooth engagement between −1 and 1.
fn sign(x: f64) -> f64 {
    2.0 * smooth_step((x.clamp(-1.0, 1.0) + 1.0) / 2.0) - 1.0
}

/// Smallest line load of the formula of ISO/TR 14179-2, N/m, and its largest pitch line velocity, m/s.
const MIN_LINE_LOAD: f64 = 150e3;
const MAX_PITCH_LINE_VELOCITY: f64 = 50.0;
/// Largest coefficient: that of steel with boundary lubrication. The formula has no limit towards zero speed.
const MAX_LUBRICATED_COEFFICIENT: f64 = 0.2;

impl FrictionLaw {
    /// Coefficient of friction under the tangential force at the base circle, N, with the radii of curvature of the transverse
    /// flanks at the pitch point, m, that of an internal gear negative.
    fn coefficient(&self, force: f64, spin: f64, [driver, driven]: [f64; 2], cosine: f64) -> f64 {
        match *self {
            Self::Constant(coefficient) => coefficient,
            Self::Lubricated { viscosity, roughness, lubricant_factor, face_width, pitch_radius } => {
                // The units of the formula are N/mm, m/s, mm, mPa s and µm; here, the radius in m multiplies N/m.
                let load = (force.abs() / face_width).max(MIN_LINE_LOAD) * 1e-3;
                let spin = spin.abs().min(MAX_PITCH_LINE_VELOCITY / pitch_radius);
                let curvature = 1e3 * driver * driven / ((driver + driven) * cosine);
                let contact = (load / (2.0 * spin * driver.abs() * curvature)).powf(0.2);
                let oil = (1e3 * viscosity).powf(-0.05) * (1e6 * roughness).powf(0.25) * lubricant_factor;
                (0.048 * contact * oil).min(MAX_LUBRICATED_COEFFICIENT)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::sign;

    #[test]
    fn sign_is_twice_differentiable() {
        assert_eq!([sign(-2.0), sign(0.0), sign(1.0), sign(7.0)], [-1.0, 0.0, 1.0, 1.0]);
        let h: f64 = 1e-3;
        // 1 − sign(1 − h) = 2.5 h³: slope and curvature vanish.
        assert!((1.0 - sign(1.0 - h) - 2.5 * h.powi(3)).abs() < 3.0 * h.powi(4));
    }
}
