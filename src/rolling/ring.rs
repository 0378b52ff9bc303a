//! Ring of five degrees of freedom: the inner ring moves radially and along the axis and tilts against the outer ring.
//!
//! The coordinates x = (v, w, u, Rσ_y, Rσ_z) are the displacements along y, z and the axis, and the slopes dv/dx and dw/dx of
//! the shaft times the radius R below, all in m. At the element with the unit vector e over (y, z), the inner race moves by
//!
//! ```text
//! δ_r = (v, w)·e − g         δ_a = u − (Rσ_y, Rσ_z)·e
//! ```
//!
//! radially, with the radial gap g, and along the axis. A ball touches both races along the line through the centres of the
//! grooves, whose distance is A = (f_i + f_o − 1) d; the contact angle changes with the load (Jones 1946; Harris, Rolling Bearing
//! Analysis, 4th ed., 2001, chapter 7; de Mul, Vree and Maas, J. Tribology 111, 1989):
//!
//! ```text
//! s = |(A cos α + δ_r, A sin α + δ_a)|    δ = s − A    Q = K max(δ, 0)^p along that line
//! ```
//!
//! R = D/2 + (f_i − ½) d cos α is the radius of the centres of the inner groove. An angular contact bearing has a shoulder on one
//! side: beyond the contact angle 0, its groove is a cylinder, along which a ball moves without an axial force.
//!
//! A roller touches along its fixed contact angle α, δ = δ_r cos α + δ_a sin α, with R = D/2; its own tilt between the races is
//! neglected. Forces of inertia and friction are neglected. A ring with an axial preload is mounted with the axial displacement that
//! needs this force.

use std::convert::Infallible;

use super::{Contact, places, turned};
use crate::bearing_force::{BearingForce, Vector};
use crate::numerics::bisect;
use crate::scene::Rolling;

/// Coordinates x of a ring, m, or the forces on them, N.
pub type RingVector = [f64; 5];

/// A ring with its elements.
#[derive(Clone, Debug)]
pub struct Ring {
    /// Unit vectors of the elements at the cage angle zero.
    pub(super) places: Box<[Vector]>,
    pub(super) contact: Contact,
    /// Distance A of the groove centres of a ball, m; none for a roller.
    groove_distance: Option<f64>,
    /// Direction of the contact α without load: radial and axial part.
    direction: Vector,
    /// Radius R, m, over which a slope moves the race along the axis.
    pub radius: f64,
    /// Radial gap g, m; negative for a radial preload.
    pub(super) gap: f64,
    /// Axial displacement with which the ring is mounted, m.
    mounted: f64,
    /// Speed of the cage over the speed of the shaft where the outer ring stands.
    pub cage_ratio: f64,
}

/// Contact of an element.
struct Touch {
    /// Approach δ of the races, m; negative without contact.
    approach: f64,
    /// Direction of the contact force: radial and axial part.
    direction: Vector,
    /// Rotation of this direction per displacement of the race across it, 1/s, in rad/m; zero for a roller.
    turning: f64,
}

/// Sum of a quantity times products of the components of e.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments<const K: usize>([f64; K]);

impl<const K: usize> Default for Moments<K> {
    fn default() -> Self {
        Self([0.0; K])
    }
}

impl<const K: usize> Moments<K> {
    #[inline(always)]
    fn add(&mut self, quantity: f64, products: &[f64; K]) {
        for (sum, product) in self.0.iter_mut().zip(products) {
            *sum += quantity * product;
        }
    }
}

/// Sums over the elements, from which force and stiffness of the ring follow: its coordinates are v, w, u and Rσ with the
/// derivatives e of δ_r and (1, −e) of δ_a.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Radial part of the contact forces times e.
    radial_force: Moments<2>,
    /// Axial part of the contact forces times 1 and e.
    axial_force: Moments<3>,
    /// Derivative of the radial part over δ_r, times e_y², e_y e_z and e_z².
    radial: Moments<3>,
    /// Derivative of the radial part over δ_a, times e and its products.
    coupling: Moments<5>,
    /// Derivative of the axial part over δ_a, times 1, e and its products.
    axial: Moments<6>,
}

impl Sums {
    /// Force and stiffness of the ring.
    #[inline(always)]
    pub(super) fn result(&self) -> BearingForce<5> {
        let (Moments([fy, fz]), Moments([fa, my, mz])) = (self.radial_force, self.axial_force);
        let Moments([r_yy, r_yz, r_zz]) = self.radial;
        let Moments([c_y, c_z, c_yy, c_yz, c_zz]) = self.coupling;
        let Moments([a, a_y, a_z, a_yy, a_yz, a_zz]) = self.axial;
        BearingForce {
            force: [fy, fz, fa, -my, -mz],
            stiffness: [
                [r_yy, r_yz, c_y, -c_yy, -c_yz],
                [r_yz, r_zz, c_z, -c_yz, -c_zz],
                [c_y, c_z, a, -a_y, -a_z],
                [-c_yy, -c_yz, -a_y, a_yy, a_yz],
                [-c_yz, -c_zz, -a_z, a_yz, a_zz],
            ],
            damping: [[0.0; 5]; 5],
        }
    }
}

impl Ring {
    /// The ring of a checked bearing.
    pub fn new(rolling: &Rolling) -> Self {
        let (sine, cosine) = rolling.contact_angle.sin_cos();
        let [inner, outer] = rolling.groove;
        let diameter = rolling.diameter_ratio * rolling.pitch_diameter;
        let half = rolling.pitch_diameter / 2.0;
        let (groove_distance, radius) = if rolling.line_contact {
            (None, half)
        } else {
            (Some((inner + outer - 1.0) * diameter), half + (inner - 0.5) * diameter * cosine)
        };
        let ring = Self {
            places: places(rolling),
            contact: Contact::new(rolling, rolling.hertz_stiffness),
            groove_distance,
            direction: [cosine, sine],
            radius,
            gap: rolling.clearance / 2.0,
            mounted: 0.0,
            cage_ratio: rolling.cage_ratio(),
        };
        let mounted = ring.displacement_along(rolling.axial_preload.unwrap_or(0.0));
        Self { mounted, ..ring }
    }

    /// Number n of elements.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// Axial displacement, m, of a ring that moves along the axis only, under a force in the direction in which it carries, N, or
    /// along the axis for a radial contact; zero without a force.
    fn displacement_along(&self, force: f64) -> f64 {
        if force == 0.0 {
            return 0.0;
        }
        let sense = if self.direction[1] < 0.0 || force < 0.0 { -1.0 } else { 1.0 };
        let force = force.abs();
        let carried = |u: f64| sense * self.at::<false>([0.0, 0.0, sense * u, 0.0, 0.0], 0.0).force[2];
        // The force rises with the displacement, without bound for a contact that is not radial.
        let mut end = self.radius * f64::EPSILON;
        while (carried(end) < force || carried(-end) >= force) && end < self.radius {
            end *= 2.0;
        }
        let Ok([_, found]) = bisect(-end, end, 0.0, |u| Ok::<_, Infallible>(carried(u) >= force));
        sense * found
    }

    /// The contact of an element with the unit vector e.
    #[inline]
    fn touch(&self, x: &RingVector, e: Vector) -> Touch {
        let radial = x[0] * e[0] + x[1] * e[1] - self.gap;
        let axial = x[2] + self.mounted - x[3] * e[0] - x[4] * e[1];
        let [cosine, sine] = self.direction;
        match self.groove_distance {
            Some(distance) => {
                let line = [distance * cosine + radial, distance * sine + axial];
                if line[1] * sine < 0.0 {
                    return Touch {
                        approach: line[0].abs() - distance,
                        direction: [line[0].signum(), 0.0],
                        turning: 0.0,
                    };
                }
                let length = (line[0] * line[0] + line[1] * line[1]).sqrt();
                // s − A without cancellation.
                let moved = 2.0 * distance * (cosine * radial + sine * axial) + radial * radial + axial * axial;
                let approach = moved / (length + distance);
                Touch { approach, direction: line.map(|part| part / length), turning: 1.0 / length }
            }
            None => Touch { approach: cosine * radial + sine * axial, direction: self.direction, turning: 0.0 },
        }
    }

    /// Approach δ of the races at an element with the unit vector e, m.
    pub(super) fn approach(&self, x: &RingVector, e: Vector) -> f64 {
        self.touch(x, e).approach
    }

    /// Adds the force and, with `STIFFNESS`, the stiffness of a number of elements with the unit vector e.
    #[inline(always)]
    pub(super) fn add<const STIFFNESS: bool>(&self, sums: &mut Sums, x: &RingVector, e: Vector, number: f64) {
        let Touch { approach, direction: [radial, axial], turning } = self.touch(x, e);
        if approach <= 0.0 {
            return;
        }
        let [force, slope] = self.contact.force(approach).map(|value| number * self.contact.stiffness * value);
        sums.radial_force.add(force * radial, &[e[0], e[1]]);
        sums.axial_force.add(force * axial, &[1.0, e[0], e[1]]);
        if !STIFFNESS {
            return;
        }
        // A force that turns with the line of contact is stiff across the line.
        let across = force * turning;
        let (square, both, other) = (e[0] * e[0], e[0] * e[1], e[1] * e[1]);
        sums.radial.add(slope * radial * radial + across * axial * axial, &[square, both, other]);
        sums.coupling.add((slope - across) * radial * axial, &[e[0], e[1], square, both, other]);
        sums.axial.add(slope * axial * axial + across * radial * radial, &[1.0, e[0], e[1], square, both, other]);
    }

    /// Force and, with `STIFFNESS`, stiffness at an angle of the cage, rad.
    #[inline]
    pub fn at<const STIFFNESS: bool>(&self, x: RingVector, cage: f64) -> BearingForce<5> {
        let mut sums = Sums::default();
        turned(&self.places, cage).for_each(|e| self.add::<STIFFNESS>(&mut sums, &x, e, 1.0));
        sums.result()
    }

    /// Elastic energy, J.
    pub fn energy(&self, x: RingVector, cage: f64) -> f64 {
        let approaches = turned(&self.places, cage).map(|e| self.approach(&x, e)).filter(|approach| *approach > 0.0);
        let sum: f64 = approaches.map(|approach| approach * self.contact.force(approach)[0]).sum();
        self.contact.stiffness * sum / (self.contact.exponent + 1.0)
    }

    /// Contact force, N, and contact angle, rad, of every element.
    pub fn contacts(&self, x: RingVector, cage: f64) -> impl Iterator<Item = [f64; 2]> + '_ {
        turned(&self.places, cage).map(move |e| {
            let Touch { approach, direction, .. } = self.touch(&x, e);
            let force = if approach > 0.0 { self.contact.stiffness * self.contact.force(approach)[0] } else { 0.0 };
            [force, direction[1].atan2(direction[0])]
        })
    }

    /// Number of loaded elements and the largest contact force, N.
    pub fn loaded(&self, x: RingVector, cage: f64) -> [f64; 2] {
        self.contact.loaded(turned(&self.places, cage).map(|e| self.approach(&x, e)))
    }

    /// Orthonormal combinations of the coordinates on which the force of rollers depends: with the fixed contact angle, the approach is
    /// (cos α v − sin α Rσ_y, cos α w − sin α Rσ_z)·e + sin α u; none for balls.
    pub fn roller_directions(&self) -> Option<Vec<RingVector>> {
        let [cosine, sine] = self.direction;
        let radial = [[cosine, 0.0, 0.0, -sine, 0.0], [0.0, cosine, 0.0, 0.0, -sine]];
        let axial = (sine != 0.0).then_some([0.0, 0.0, 1.0, 0.0, 0.0]);
        self.groove_distance.is_none().then(|| radial.into_iter().chain(axial).collect())
    }

    /// Approximate stiffness under a load, N, in every direction, N/m.
    pub fn secant_stiffness(&self, load: f64) -> f64 {
        self.contact.secant_stiffness(self.count(), self.gap, load)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn ring(line_contact: bool, clearance: f64, axial_preload: f64) -> Ring {
        Ring::new(&Rolling {
            elements: 16,
            diameter_ratio: 22.23 / 125.0,
            pitch_diameter: 0.125,
            groove: [0.5232, 0.5232],
            clearance,
            hertz_stiffness: 1.3e10,
            line_contact,
            contact_angle: 0.7,
            phase: 0.1,
            axial_preload: Some(axial_preload),
        })
    }

    #[test]
    fn force_is_the_derivative_of_the_energy_and_stiffness_that_of_the_force() {
        for line in [false, true] {
            let (ring, x, cage, h) = (ring(line, 1e-6, 0.0), [1e-5, -2e-5, 3e-5, 1e-5, -1e-5], 0.4, 1e-10);
            let found = ring.at::<true>(x, cage);
            let moved = |j: usize, h: f64| {
                let mut x = x;
                x[j] += h;
                x
            };
            for j in 0..5 {
                let slope = (ring.energy(moved(j, h), cage) - ring.energy(moved(j, -h), cage)) / (2.0 * h);
                // Central differences with round-off of 1e-16 U/h, and of 1e-16 F/h below.
                assert!((slope - found.force[j]).abs() < 1e-5 * found.force[2], "{j}: {slope} {}", found.force[j]);
                let [after, before] = [h, -h].map(|h| ring.at::<false>(moved(j, h), cage).force);
                for i in 0..5 {
                    let slope = (after[i] - before[i]) / (2.0 * h);
                    let size = found.stiffness[2][2];
                    assert!((slope - found.stiffness[i][j]).abs() < 1e-4 * size, "{i} {j}");
                    assert!((found.stiffness[i][j] - found.stiffness[j][i]).abs() < 1e-12 * size);
                }
            }
        }
    }

    #[test]
    fn the_axial_force_without_displacement_is_the_preload() {
        for line in [false, true] {
            for clearance in [0.0, 2e-5, -1e-6] {
                let found = ring(line, clearance, 800.0).at::<false>([0.0; 5], 0.3).force[2];
                // The stiffness times the round-off of the displacement.
                assert!((found - 800.0).abs() < 1e-6 * 800.0, "{line} {clearance} {found}");
            }
        }
    }
}
