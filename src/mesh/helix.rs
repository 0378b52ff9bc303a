//! Helical teeth: the axial displacements and the tilts of the gears as a part of the rolling displacement.
//!
//! An involute helicoid is invariant under a screw motion, so that an axial displacement u of a gear acts as the rotation
//! −u tan β_b/r of its transverse section. The point of contact lies at the pitch point, between the centres in the ratio
//! of the base radii, where the tilt of a gear adds φ·r_w along the axis. With the signed base helix angle β_b of the driver,
//! the vector c between the centres, the tilts φ = (Γ, −B) and S = r_a + r_b:
//!
//! ```text
//! ρ = r_a θ_a + r_b θ_b − tan β_b (u_a − u_b) + tan β_b τ·c,        τ = (r_a φ_a + r_b φ_b)/S
//! ```
//!
//! ρ replaces the rolling displacement of spur gears in the deflection δ of the transverse section (`involute.rs`). The
//! force follows from the gradient of δ: with the unit normal n of the teeth, a gear is subject to the force F n at the pitch
//! point, and to the moments r × n F about all three axes. Live geometry takes c from the moving centres.
//!
//! δ and its force F are those of the transverse section. In the direction normal to the teeth they are δ cos β_b and
//! F/cos β_b, and a stiffness is k/cos²β_b. Scenes, runs and linear analyses give these values.

use super::contact::HelixForces;
use super::involute::Involute;
use super::pose::{Geometry, RelativeMotion, dot};

/// Axial displacements and tilts of a helical mesh.
#[derive(Clone, Debug)]
pub struct Helix {
    /// tan β_b of the driver; positive for a right-hand helix.
    pub slope: f64,
    /// Base radius of driver and driven gear over their sum, with the signs of `involute.rs`.
    pub shares: [f64; 2],
    /// Indices of u of driver and driven gear.
    pub axial: [usize; 2],
    /// Index of the first tilt Γ of driver and driven gear; −B has the next index.
    pub tilt: [usize; 2],
    /// Vector between the centres at rest, m.
    centres: [f64; 2],
}

impl Helix {
    /// Helical teeth with tan β_b = `slope` and the indices of u and v of driver and driven gear.
    pub(super) fn new(involute: &Involute, slope: f64, axial: [usize; 2], translation: [usize; 2]) -> Self {
        let shares = involute.base_radius.map(|radius| radius / involute.base_circles());
        Self { slope, shares, axial, tilt: translation.map(|v| v + 2), centres: involute.centres_at_rest() }
    }

    /// Vector c between the centres, m.
    #[inline]
    pub fn centres(&self, geometry: Geometry, relative_displacement: [f64; 2]) -> [f64; 2] {
        let [y, z] = self.centres;
        match geometry {
            Geometry::Live => [y + relative_displacement[0], z + relative_displacement[1]],
            Geometry::Frozen => [y, z],
        }
    }

    /// Axial part −tan β_b (u_a − u_b) of the rolling displacement, m, and the tilt τ, rad, or their rates.
    #[inline]
    pub(super) fn relative(&self, q: &[f64]) -> (f64, [f64; 2]) {
        let ([a, b], [first, second]) = (self.axial, self.tilt);
        let tilt = |lane: usize| self.shares[0] * q[first + lane] + self.shares[1] * q[second + lane];
        (-self.slope * (q[a] - q[b]), [tilt(0), tilt(1)])
    }

    /// The axial part of the rolling displacement, and the tilt τ over (y, z), as entries (index, coefficient).
    pub fn rows(&self) -> [Vec<(usize, f64)>; 3] {
        let ([a, b], [first, second]) = (self.axial, self.tilt);
        let tilt = |lane: usize| vec![(first + lane, self.shares[0]), (second + lane, self.shares[1])];
        [vec![(a, -self.slope), (b, self.slope)], tilt(0), tilt(1)]
    }

    /// Adds tan β_b τ·c to the rolling displacement.
    #[inline]
    pub(super) fn add_tilt_product(&self, geometry: Geometry, position: &mut RelativeMotion) {
        let centres = self.centres(geometry, position.relative_displacement);
        position.rolling_displacement += self.slope * dot(position.tilt, centres);
    }

    /// Adds the rate of tan β_b τ·c to the rate of the rolling displacement.
    #[inline]
    pub(super) fn add_tilt_rate(&self, geometry: Geometry, position: &RelativeMotion, velocity: &mut RelativeMotion) {
        let centres = self.centres(geometry, position.relative_displacement);
        let moving = match geometry {
            Geometry::Live => dot(position.tilt, velocity.relative_displacement),
            Geometry::Frozen => 0.0,
        };
        velocity.rolling_displacement += self.slope * (dot(velocity.tilt, centres) + moving);
    }

    /// Generalised forces of a force `rolling` on the rolling displacement, N.
    #[inline]
    pub(super) fn forces(&self, geometry: Geometry, position: &RelativeMotion, rolling: f64) -> HelixForces {
        let axial = self.slope * rolling;
        let centre = match geometry {
            Geometry::Live => position.tilt.map(|tilt| axial * tilt),
            Geometry::Frozen => [0.0; 2],
        };
        let tilt = self.centres(geometry, position.relative_displacement).map(|c| axial * c);
        HelixForces { axial, tilt, centre }
    }

    /// Adds generalised forces on u and on the tilts to `out`.
    #[inline]
    pub(super) fn apply(&self, forces: &HelixForces, out: &mut [f64]) {
        let [a, b] = self.axial;
        out[a] -= forces.axial;
        out[b] += forces.axial;
        for (first, share) in self.tilt.into_iter().zip(self.shares) {
            for lane in 0..2 {
                out[first + lane] += share * forces.tilt[lane];
            }
        }
    }

    /// Calls `visit(index, ∂ρ/∂q)` for u and the tilts, with the vector c between the centres, m.
    #[inline]
    pub(super) fn gradient(&self, centres: [f64; 2], mut visit: impl FnMut(usize, f64)) {
        let [a, b] = self.axial;
        visit(a, -self.slope);
        visit(b, self.slope);
        for (first, share) in self.tilt.into_iter().zip(self.shares) {
            for (lane, centre) in centres.into_iter().enumerate() {
                visit(first + lane, self.slope * share * centre);
            }
        }
    }

    /// Calls `visit(row, column, ∂²ρ/∂q²)` for tilts and centres, whose v have the indices `translation`.
    pub(super) fn curvature(&self, translation: [usize; 2], mut visit: impl FnMut(usize, usize, f64)) {
        for (first, share) in self.tilt.into_iter().zip(self.shares) {
            for (v, sign) in translation.into_iter().zip([-1.0, 1.0]) {
                for lane in 0..2 {
                    let value = self.slope * share * sign;
                    visit(first + lane, v + lane, value);
                    visit(v + lane, first + lane, value);
                }
            }
        }
    }
}
