//! Rolling elements between two raceways: the force of the shaft on the bearing, and its derivatives.
//!
//! Element j stands at the angle φ_j = ψ + 2πj/n from y towards z; all turn with the angle ψ of the cage. With the
//! displacement u of the shaft, the unit vector e_j and the radial gap g (half the clearance), the races approach each other
//! along element j by δ_j = u·e_j − g. An element carries only while δ_j is positive:
//!
//! ```text
//! Q_j = K max(δ_j, 0)^p          p = 3/2 for balls (point contact), 10/9 for rollers (line contact)
//! F = Σ Q_j e_j + C u̇            U = Σ K max(δ_j, 0)^{p + 1}/(p + 1)
//! ```
//!
//! With a contact angle α, the contact deflects by δ cos α and the radial part of its force is Q cos α: K contains
//! cos^{p + 1} α. The cage turns at (1 − γ)/2 times the speed of the inner ring plus (1 + γ)/2 times that of the outer ring,
//! γ = (d/D) cos α (Harris, Rolling Bearing Analysis, 4th ed., 2001, chapters 7 and 8). Centrifugal forces and slip are neglected.
//!
//! `mean.rs` is the force averaged over the angles of the cage, `equilibrium.rs` the displacement under a load, and `ring.rs` a
//! ring that also moves along the axis and tilts, with `ring_mean.rs`. K is given, or that of
//! `src/scene/hertz.rs`.

mod equilibrium;
mod mean;
mod ring;
mod ring_mean;

use std::f64::consts::TAU;
use std::sync::LazyLock;

pub use self::ring::{Ring, RingVector};
use crate::bearing_force::{BearingForce, Matrix, Vector};
use crate::numerics::gauss;
use crate::scene::{LINE_CONTACT, POINT_CONTACT, Rolling};

/// Points of the Gauss rule over a loaded zone. The substitution that [`Contact::grading`] describes makes the integrands smooth,
/// so that the error is round-off.
const GAUSS_POINTS: usize = 48;
/// Abscissae and weights of the rule.
static GAUSS: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss(GAUSS_POINTS));

/// The contact of an element with both races, Q = K δ^p.
#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Stiffness K, N/m^p.
    stiffness: f64,
    /// Exponent p.
    exponent: f64,
}

impl Contact {
    /// The contact of a stiffness K.
    fn new(rolling: &Rolling, stiffness: f64) -> Self {
        Self { stiffness, exponent: if rolling.line_contact { LINE_CONTACT } else { POINT_CONTACT } }
    }

    /// Contact force K δ^p over K and its derivative p δ^{p − 1} for δ > 0.
    #[inline]
    fn force(&self, approach: f64) -> [f64; 2] {
        let root = if self.exponent == POINT_CONTACT { approach.sqrt() } else { approach.powf(self.exponent - 1.0) };
        [approach * root, self.exponent * root]
    }

    /// Number of loaded elements and the largest contact force, N, from the approaches of the races, m.
    fn loaded(&self, approaches: impl Iterator<Item = f64>) -> [f64; 2] {
        let loaded = approaches.filter(|approach| *approach > 0.0);
        let [count, largest] =
            loaded.fold([0.0; 2], |[count, largest], approach| [count + 1.0, f64::max(largest, approach)]);
        [count, self.stiffness * self.force(largest)[0]]
    }

    /// Power m of the substitution 1 − ψ/ψ_l = (1 − x)^m, which turns δ^{p − 1} ∝ (1 − ψ/ψ_l)^{p − 1} next to the end ψ_l of a loaded
    /// zone into 1 − x.
    fn grading(&self) -> f64 {
        1.0 / (self.exponent - 1.0)
    }

    /// Approximate stiffness of n elements with a radial gap, m, under a load, N, in N/m: the load over gap and deflection.
    fn secant_stiffness(&self, count: usize, gap: f64, load: f64) -> f64 {
        // Stribeck: the most loaded of n balls carries about 4.37/n of the load; 4 is accurate enough here.
        let deflection = (4.0 * load / (count as f64 * self.stiffness)).powf(1.0 / self.exponent);
        load / (gap.max(0.0) + deflection)
    }
}

/// Unit vectors of the elements at the cage angle zero.
fn places(rolling: &Rolling) -> Box<[Vector]> {
    let place = |j: u32| {
        let (sine, cosine) = (rolling.phase + TAU * f64::from(j) / f64::from(rolling.elements)).sin_cos();
        [cosine, sine]
    };
    (0..rolling.elements).map(place).collect()
}

/// Unit vectors of the elements at an angle of the cage.
#[inline]
fn turned(places: &[Vector], cage: f64) -> impl Iterator<Item = Vector> + '_ {
    let (sine, cosine) = cage.sin_cos();
    places.iter().map(move |place| [cosine * place[0] - sine * place[1], sine * place[0] + cosine * place[1]])
}

/// The rolling elements of a bearing.
#[derive(Clone, Debug)]
pub struct RollingElements {
    /// Unit vectors of the elements at the cage angle zero.
    places: Box<[Vector]>,
    /// Radial contact of one element.
    contact: Contact,
    /// Radial gap g, m; negative for a preload.
    gap: f64,
    /// Radial part of a contact force, cos α.
    radial: f64,
    /// Damping C over (y, z), N s/m.
    damping: Matrix,
    /// Speed of the cage over the speed of the shaft where the outer ring stands.
    pub cage_ratio: f64,
}

impl RollingElements {
    /// The elements of a checked bearing with the damping over (y, z), N s/m.
    pub fn new(rolling: &Rolling, damping: Matrix) -> Self {
        let (contact, cosine) = (Contact::new(rolling, rolling.hertz_stiffness), rolling.contact_angle.cos());
        let stiffness = contact.stiffness * cosine.powf(contact.exponent + 1.0);
        Self {
            places: places(rolling),
            contact: Contact { stiffness, ..contact },
            gap: rolling.clearance / 2.0,
            radial: cosine,
            damping,
            cage_ratio: rolling.cage_ratio(),
        }
    }

    /// Number n of elements.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// Approach δ of the races along each element, m, and the unit vector of the element, at a displacement and an angle of
    /// the cage.
    #[inline]
    fn approaches(&self, u: Vector, cage: f64) -> impl Iterator<Item = (f64, Vector)> + '_ {
        turned(&self.places, cage).map(move |e| (u[0] * e[0] + u[1] * e[1] - self.gap, e))
    }

    /// Force and, with `DERIVATIVES`, stiffness and damping at a displacement, m, a velocity, m/s, and an angle of the cage, rad.
    #[inline]
    pub fn at<const DERIVATIVES: bool>(&self, u: Vector, velocity: Vector, cage: f64) -> BearingForce {
        let (mut force, [mut yy, mut yz, mut zz]) = ([0.0; 2], [0.0; 3]);
        for (approach, [y, z]) in self.approaches(u, cage).filter(|(approach, _)| *approach > 0.0) {
            let [pressed, slope] = self.contact.force(approach);
            force[0] += pressed * y;
            force[1] += pressed * z;
            if DERIVATIVES {
                yy += slope * y * y;
                yz += slope * y * z;
                zz += slope * z * z;
            }
        }
        let (k, c) = (self.contact.stiffness, &self.damping);
        BearingForce {
            force: [0, 1].map(|i| k * force[i] + c[i][0] * velocity[0] + c[i][1] * velocity[1]),
            stiffness: [[k * yy, k * yz], [k * yz, k * zz]],
            damping: if DERIVATIVES { *c } else { Matrix::default() },
        }
    }

    /// Elastic energy U, J.
    pub fn energy(&self, u: Vector, cage: f64) -> f64 {
        let loaded = self.approaches(u, cage).filter(|(approach, _)| *approach > 0.0);
        let sum: f64 = loaded.map(|(approach, _)| approach * self.contact.force(approach)[0]).sum();
        self.contact.stiffness * sum / (self.contact.exponent + 1.0)
    }

    /// Contact force Q of every element, normal to the races, at a displacement and an angle of the cage, N.
    pub fn contact_forces(&self, u: Vector, cage: f64) -> impl Iterator<Item = f64> + '_ {
        self.approaches(u, cage).map(|(approach, _)| {
            if approach > 0.0 { self.contact.stiffness * self.contact.force(approach)[0] / self.radial } else { 0.0 }
        })
    }

    /// Number of loaded elements and the largest contact force, N.
    pub fn loaded(&self, u: Vector, cage: f64) -> [f64; 2] {
        let [count, largest] = self.contact.loaded(self.approaches(u, cage).map(|(approach, _)| approach));
        [count, largest / self.radial]
    }

    /// Approximate stiffness under a load, N/m, N: the load over gap and deflection.
    pub fn secant_stiffness(&self, load: f64) -> f64 {
        self.contact.secant_stiffness(self.count(), self.gap, load)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rolling_elements(elements: u32, clearance: f64, line_contact: bool) -> RollingElements {
        let rolling = Rolling {
            elements,
            diameter_ratio: 0.2,
            pitch_diameter: 0.1,
            groove: [0.52; 2],
            clearance,
            hertz_stiffness: 1e10,
            line_contact,
            contact_angle: 0.0,
            phase: 0.3,
            axial_preload: None,
        };
        RollingElements::new(&rolling, [[200.0, 10.0], [-5.0, 300.0]])
    }

    #[test]
    fn stiffness_and_energy_are_derivatives() {
        for line in [false, true] {
            for clearance in [2e-5, -1e-5] {
                let (elements, u, rates, h) = (rolling_elements(9, clearance, line), [2e-5, -3e-5], [1e-3, 2e-3], 1e-9);
                let found = elements.at::<true>(u, rates, 0.7);
                let moved = |j: usize, h: f64| {
                    let mut u = u;
                    u[j] += h;
                    u
                };
                for j in 0..2 {
                    let slope = (elements.energy(moved(j, h), 0.7) - elements.energy(moved(j, -h), 0.7)) / (2.0 * h);
                    let elastic = elements.at::<true>(u, [0.0; 2], 0.7).force[j];
                    // Error of differences: second order in h/δ, and round-off.
                    assert!((slope - elastic).abs() < 1e-5 * elastic.abs(), "{slope} {elastic}");
                    for i in 0..2 {
                        let force = |h: f64| elements.at::<true>(moved(j, h), rates, 0.7).force[i];
                        let slope = (force(h) - force(-h)) / (2.0 * h);
                        let size = found.stiffness[0][0].abs() + found.stiffness[1][1].abs();
                        assert!((slope - found.stiffness[i][j]).abs() < 1e-5 * size, "{slope} {found:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_loaded_elements_are_those_with_a_contact_force() {
        let summary = |forces: Vec<f64>| {
            let loaded = forces.iter().filter(|force| **force > 0.0).count();
            [loaded as f64, forces.into_iter().fold(0.0, f64::max)]
        };
        for line in [false, true] {
            let (elements, u) = (rolling_elements(9, 2e-5, line), [2e-5, -3e-5]);
            assert_eq!(elements.loaded(u, 0.7), summary(elements.contact_forces(u, 0.7).collect()));
            let (ring, x) = (ring::tests::ring(line, 1e-5, 0.0), [1e-5, -2e-5, 1e-5, 1e-5, -1e-5]);
            let forces: Vec<f64> = ring.contacts(x, 0.4).map(|[force, _]| force).collect();
            assert!(forces.contains(&0.0) && forces.iter().any(|force| *force > 0.0));
            assert_eq!(ring.loaded(x, 0.4), summary(forces));
        }
        // Unloaded elements.
        assert_eq!(rolling_elements(9, 2e-5, true).loaded([0.0; 2], 0.7), [0.0; 2]);
    }

    #[test]
    fn the_mean_force_is_the_average_over_the_cage_angles() {
        for line in [false, true] {
            for (clearance, u) in [(2e-5, [2e-5, -3e-5]), (0.0, [1e-5, 2e-5]), (-1e-5, [1e-6, 2e-6]), (-1e-5, [0.0; 2])]
            {
                let elements = rolling_elements(7, clearance, line);
                let mean = elements.mean(u);
                let count = 20000;
                let mut sum = BearingForce::<2>::default();
                for i in 0..count {
                    let found = elements.at::<true>(u, [0.0; 2], TAU / 7.0 * f64::from(i) / f64::from(count));
                    for a in 0..2 {
                        sum.force[a] += found.force[a] / f64::from(count);
                        for b in 0..2 {
                            sum.stiffness[a][b] += found.stiffness[a][b] / f64::from(count);
                        }
                    }
                }
                let (size, stiff) = (mean.force[0].hypot(mean.force[1]), mean.stiffness[0][0].abs());
                // The tangent of a line contact has the exponent 1/9: the sum converges slowly.
                let rough = if line { 1e-4 } else { 1e-6 };
                for a in 0..2 {
                    assert!((sum.force[a] - mean.force[a]).abs() <= 1e-8 * size + 1e-9, "{sum:?} {mean:?}");
                    for b in 0..2 {
                        let difference = (sum.stiffness[a][b] - mean.stiffness[a][b]).abs();
                        assert!(difference <= rough * stiff, "{sum:?} {mean:?}");
                    }
                }
            }
        }
    }
}
