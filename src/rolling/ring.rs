//! Quasi-static ring of five degrees of freedom: the inner ring moves radially, along the axis and tilts against the outer ring.
//!
//! At the element j with the angle φ_j the displacements (u, v, w) and the rotations (B, Γ) about y and z move the inner race by
//!
//! ```text
//! δ_a = u + R (B sin φ − Γ cos φ)         δ_r = v cos φ + w sin φ − g
//! ```
//!
//! along the axis and radially, with the radial gap g. A ball touches both races along the line through the centres of the
//! grooves, whose distance is A = (f_i + f_o − 1) d; the contact angle changes with the load (Jones 1946; Harris, Rolling Bearing
//! Analysis, 4th ed., 2001, chapter 7):
//!
//! ```text
//! s = |(A sin α + δ_a, A cos α + δ_r)|    δ = s − A    Q = K max(δ, 0)^p along that line
//! ```
//!
//! R = D/2 + (f_i − ½) d cos α is the radius of the centres of the inner groove. A roller touches along its fixed contact angle
//! α, δ = δ_a sin α + δ_r cos α, with R = D/2; its own tilt between the races is neglected. Forces of inertia and friction are
//! neglected.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

use crate::bearing_force::{BalanceSearch, LoadedForce, Uncarried};
use crate::scene::{LINE_CONTACT, POINT_CONTACT, Rolling};

/// Displacements (u, v, w, B, Γ) in m and rad, or the forces and moments on them, N and N m.
pub type RingVector = SVector<f64, 5>;
/// Derivatives of the forces of a ring over its displacements.
pub type RingMatrix = SMatrix<f64, 5, 5>;

/// Largest residual force of an equilibrium, relative to the load.
const MAX_RESIDUAL: f64 = 1e-9;
/// Stiffness that is added to the diagonal of the tangent, relative to the secant stiffness, at a residual of the whole load.
const ADDED_FRACTION: f64 = 1e-2;
/// Smallest residual, relative to the load, for which the addition falls with it.
const MIN_ADDED_RESIDUAL: f64 = 1e-6;

/// A ring with its elements at the cage angle zero.
#[derive(Clone, Debug)]
pub struct Ring {
    /// Angles of the elements, rad.
    angles: Vec<f64>,
    /// Stiffness K of one element, N/m^p, and its exponent p.
    stiffness: f64,
    exponent: f64,
    /// Distance A of the groove centres of a ball, m; none for a roller.
    groove_distance: Option<f64>,
    /// Contact angle α without load: sine and cosine.
    contact: [f64; 2],
    /// Radius R, m, over which a tilt moves the race along the axis.
    radius: f64,
    /// Radial gap g, m.
    gap: f64,
}

/// Force and stiffness of a ring, with contact force, N, and contact angle, rad, of each element.
#[derive(Clone, Debug)]
pub struct RingForce {
    /// Force on the ring over (u, v, w, B, Γ), N and N m.
    pub force: RingVector,
    /// Its derivative.
    pub stiffness: RingMatrix,
    /// Contact force and contact angle of each element.
    pub contacts: Vec<[f64; 2]>,
}

impl LoadedForce<3> for RingForce {
    fn force(&self) -> [f64; 3] {
        self.force.fixed_rows::<3>(0).into()
    }

    fn step(&self, missing: [f64; 3], added: f64) -> Option<[f64; 3]> {
        let tangent: Matrix3<f64> = self.stiffness.fixed_view::<3, 3>(0, 0) + Matrix3::identity() * added;
        tangent.lu().solve(&Vector3::from(missing)).map(Into::into)
    }
}

impl Ring {
    /// The ring of a checked bearing.
    pub fn new(rolling: &Rolling) -> Self {
        let count = f64::from(rolling.elements);
        let (sine, cosine) = rolling.contact_angle.sin_cos();
        let [inner, outer] = rolling.groove;
        let diameter = rolling.diameter_ratio * rolling.pitch_diameter;
        let half = rolling.pitch_diameter / 2.0;
        let (groove_distance, radius) = if rolling.line_contact {
            (None, half)
        } else {
            (Some((inner + outer - 1.0) * diameter), half + (inner - 0.5) * diameter * cosine)
        };
        Self {
            angles: (0..rolling.elements).map(|j| rolling.phase + TAU * f64::from(j) / count).collect(),
            stiffness: rolling.hertz_stiffness,
            exponent: if rolling.line_contact { LINE_CONTACT } else { POINT_CONTACT },
            groove_distance,
            contact: [sine, cosine],
            radius,
            gap: rolling.clearance / 2.0,
        }
    }

    /// Force and stiffness at displacements.
    pub fn at(&self, displacement: &RingVector) -> RingForce {
        let mut found = RingForce {
            force: RingVector::zeros(),
            stiffness: RingMatrix::zeros(),
            contacts: Vec::with_capacity(self.angles.len()),
        };
        let [sine, cosine] = self.contact;
        for angle in &self.angles {
            let (sin, cos) = angle.sin_cos();
            // Displacement of the race along the axis and radially over the coordinates of the ring.
            let rows = SMatrix::<f64, 2, 5>::from_row_slice(&[
                1.0,
                0.0,
                0.0,
                self.radius * sin,
                -self.radius * cos,
                0.0,
                cos,
                sin,
                0.0,
                0.0,
            ]);
            let moved = rows * displacement - Vector2::new(0.0, self.gap);
            let (normal, approach, turning) = match self.groove_distance {
                Some(distance) => {
                    let line = Vector2::new(distance * sine, distance * cosine) + moved;
                    let length = line.norm();
                    (line / length, length - distance, length)
                }
                None => {
                    let normal = Vector2::new(sine, cosine);
                    (normal, normal.dot(&moved), f64::INFINITY)
                }
            };
            let contact_angle = normal[0].atan2(normal[1]);
            if approach <= 0.0 {
                found.contacts.push([0.0, contact_angle]);
                continue;
            }
            let force = self.stiffness * approach.powf(self.exponent);
            let slope = self.exponent * force / approach;
            found.contacts.push([force, contact_angle]);
            found.force += rows.transpose() * normal * force;
            // A force that turns with the line of contact is stiff across the line.
            let across = Vector2::new(-normal[1], normal[0]);
            let local = normal * normal.transpose() * slope + across * across.transpose() * (force / turning);
            found.stiffness += rows.transpose() * local * rows;
        }
        found
    }

    /// Displacements (u, v, w) under the forces (axial, y, z), N, with given rotations (B, Γ), rad, and the forces there.
    ///
    /// # Errors
    /// [`Uncarried`] if the bearing does not carry the load.
    pub fn carrying(&self, load: Vector3<f64>, tilt: Vector2<f64>) -> Result<(RingVector, RingForce), Uncarried> {
        let whole = load.norm();
        let state = |[u, v, w]: [f64; 3]| RingVector::from([[u, v, w, tilt[0], tilt[1]]]);
        if whole == 0.0 {
            let rest = state([0.0; 3]);
            return Ok((rest, self.at(&rest)));
        }
        // Deflection of all elements under the load, as a measure of the stiffness.
        let deflection = (whole / (self.angles.len() as f64 * self.stiffness)).powf(1.0 / self.exponent);
        let secant = whole / (deflection + self.gap.max(0.0));
        let search = BalanceSearch {
            load: load.into(),
            force: &|x| self.at(&state(x)),
            added_stiffness: &|residual| secant * ADDED_FRACTION * residual.clamp(MIN_ADDED_RESIDUAL, 1.0),
            is_permitted: &|_, _| true,
        };
        let found = search.from([0.0; 3]);
        if found.residual <= MAX_RESIDUAL {
            Ok((state(found.displacement), found.bearing))
        } else {
            Err(Uncarried::Unbalanced(found.residual))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(line_contact: bool) -> Ring {
        Ring::new(&Rolling {
            elements: 16,
            diameter_ratio: 22.23 / 125.0,
            pitch_diameter: 0.125,
            groove: [0.5232, 0.5232],
            clearance: 0.0,
            hertz_stiffness: 1.3e10,
            line_contact,
            contact_angle: 0.7,
            phase: 0.1,
        })
    }

    #[test]
    fn stiffness_is_the_derivative_of_the_force() {
        for line in [false, true] {
            let ring = ring(line);
            let at = RingVector::from_column_slice(&[3e-5, 1e-5, -2e-5, 1e-4, -2e-4]);
            let found = ring.at(&at);
            let steps = [1e-10, 1e-10, 1e-10, 1e-9, 1e-9];
            for (j, h) in steps.into_iter().enumerate() {
                let moved = |sign: f64| {
                    let mut next = at;
                    next[j] += sign * h;
                    ring.at(&next).force
                };
                let difference = (moved(1.0) - moved(-1.0)) / (2.0 * h);
                for i in 0..5 {
                    let size = (found.stiffness[(i, i)] * found.stiffness[(j, j)]).sqrt();
                    // Central differences with round-off of 1e-16 F/h.
                    assert!((difference[i] - found.stiffness[(i, j)]).abs() < 1e-4 * size, "{i} {j}");
                }
            }
            assert!((found.stiffness - found.stiffness.transpose()).norm() < 1e-12 * found.stiffness.norm());
        }
    }
}
