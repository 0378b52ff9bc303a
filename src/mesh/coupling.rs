//! A mesh as the equation of motion sees it: one scalar force that acts on six coordinates.
//!
//! ```text
//! F = k δ + c δ̇,    generalised force on q:  −F ∂δ/∂q,    ∂δ/∂q = (n, −n, σr_a, σr_b) over (u_a, u_b, θ_a, θ_b)
//! ```
//!
//! One law for modes, static equilibrium and motion. Live geometry takes n from the centres as they lie; with
//! constant k the force then derives from ½kδ², and an undamped scene conserves its energy although n moves. Frozen
//! geometry keeps n of the centres at rest, which makes the law linear.

use super::involute::{Centres, Involute, LineOfAction, Overlap};
use crate::scene::{Gear, Mesh};

/// Whether the line of action follows the centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// It follows them at every instant.
    Live,
    /// It stays that of the centres at rest.
    Frozen,
}

/// Where the six coordinates of a mesh stand in a vector of displacements.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// v of driver and driven gear (w follows v); `None` in a scene that has no bending.
    pub translation: Option<[usize; 2]>,
    /// θ of driver and driven gear.
    pub twist: [usize; 2],
}

/// The state of a mesh at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Deflection δ, m.
    pub deflection: f64,
    /// Its rate δ̇, m/s.
    pub rate: f64,
    /// Force F, N.
    pub force: f64,
    /// Line of action n.
    pub normal: [f64; 2],
    /// Unit vector across n.
    pub across: [f64; 2],
    /// C sin α, m.
    pub tangent: f64,
}

/// What a response reports of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshState {
    /// Deflection δ, m.
    pub deflection: f64,
    /// Force F, N.
    pub force: f64,
    /// Stiffness k, N/m.
    pub stiffness: f64,
    /// The moving centres.
    pub centres: Centres,
    /// Tooth pairs between the tip circles.
    pub pairs_in_contact: f64,
}

/// A mesh with its coordinates.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// Geometry of the pair.
    pub involute: Involute,
    /// The six coordinates.
    pub coordinates: Coordinates,
    /// Stiffness k, N/m.
    pub stiffness: f64,
    /// Damping c, N s/m.
    pub damping: f64,
    /// Shaft of the driver, whose spin gives σ.
    pub driver_shaft: usize,
    /// The line of action of the centres at rest, for σ = −1 and +1.
    at_rest: [LineOfAction; 2],
}

/// Displacements, or their rates, of a mesh: u_b − u_a and r_a θ_a + r_b θ_b.
#[derive(Clone, Copy, Debug)]
struct Relative {
    apart: [f64; 2],
    rolled: f64,
}

impl Coupling {
    /// The coupling of `mesh` on `coordinates`.
    pub fn new(mesh: &Mesh, gears: &[Gear], coordinates: Coordinates) -> Self {
        let involute = Involute::new(mesh, gears);
        Self {
            at_rest: [-1.0, 1.0].map(|sigma| involute.line_at_rest(sigma)),
            involute,
            coordinates,
            stiffness: mesh.stiffness,
            damping: mesh.damping,
            driver_shaft: gears[mesh.driver].body.node.shaft,
        }
    }

    #[inline(always)]
    fn relative(&self, q: &[f64]) -> Relative {
        let [ra, rb] = self.involute.base_radius;
        let [a, b] = self.coordinates.twist;
        let apart = match self.coordinates.translation {
            Some([a, b]) => [q[b] - q[a], q[b + 1] - q[a + 1]],
            None => [0.0; 2],
        };
        Relative { apart, rolled: ra * q[a] + rb * q[b] }
    }

    /// δ, δ̇ and F for displacements `q` and velocities `v`.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub fn contact(&self, geometry: Geometry, sigma: f64, q: &[f64], v: &[f64]) -> Result<Contact, Overlap> {
        let (position, velocity) = (self.relative(q), self.relative(v));
        let dot = |n: [f64; 2], u: [f64; 2]| n[0] * u[0] + n[1] * u[1];
        let (line, centres) = match geometry {
            Geometry::Live => {
                let line = self.involute.line_of_action(sigma, position.apart)?;
                (line, line.deflection)
            }
            Geometry::Frozen => {
                let line = self.at_rest[usize::from(sigma > 0.0)];
                (line, -dot(line.normal, position.apart))
            }
        };
        let deflection = sigma * position.rolled + centres;
        let rate = sigma * velocity.rolled - dot(line.normal, velocity.apart);
        Ok(Contact {
            deflection,
            rate,
            force: self.stiffness * deflection + self.damping * rate,
            normal: line.normal,
            across: line.across,
            tangent: line.tangent,
        })
    }

    /// δ of small displacements `q`, along the line of action at rest.
    pub fn deflection_at_rest(&self, sigma: f64, q: &[f64]) -> f64 {
        let relative = self.relative(q);
        let normal = self.at_rest[usize::from(sigma > 0.0)].normal;
        sigma * relative.rolled - normal[0] * relative.apart[0] - normal[1] * relative.apart[1]
    }

    /// The contact of unmoved centres, for what is linearised there.
    pub fn contact_at_rest(&self, sigma: f64) -> Contact {
        let LineOfAction { normal, across, tangent, .. } = self.at_rest[usize::from(sigma > 0.0)];
        Contact { deflection: 0.0, rate: 0.0, force: 0.0, normal, across, tangent }
    }

    /// Subtracts `force`·∂δ/∂q from the generalised forces `out`.
    #[inline(always)]
    pub fn apply(&self, sigma: f64, force: f64, normal: [f64; 2], out: &mut [f64]) {
        self.gradient(sigma, normal, |index, slope| out[index] -= force * slope);
    }

    /// Calls `visit(index, ∂δ/∂q)` for the coordinates of the mesh.
    #[inline(always)]
    pub fn gradient(&self, sigma: f64, normal: [f64; 2], mut visit: impl FnMut(usize, f64)) {
        if let Some([a, b]) = self.coordinates.translation {
            visit(a, normal[0]);
            visit(a + 1, normal[1]);
            visit(b, -normal[0]);
            visit(b + 1, -normal[1]);
        }
        let [ra, rb] = self.involute.base_radius;
        let [a, b] = self.coordinates.twist;
        visit(a, sigma * ra);
        visit(b, sigma * rb);
    }

    /// Calls `visit(row, column, ∂(F ∂δ/∂q)/∂q)` at a contact: `stiffness`·ggᵀ, and in live geometry F ∂²δ/∂q².
    pub fn tangent(
        &self,
        geometry: Geometry,
        sigma: f64,
        stiffness: f64,
        contact: &Contact,
        mut visit: impl FnMut(usize, usize, f64),
    ) {
        self.gradient(sigma, contact.normal, |row, left| {
            self.gradient(sigma, contact.normal, |column, right| visit(row, column, stiffness * left * right));
        });
        if let (Geometry::Live, Some([a, b])) = (geometry, self.coordinates.translation) {
            // ∂²δ/∂(u_b − u_a)² = −m mᵀ/(C sin α): the line of action turns as the centres move across it.
            let curvature = -contact.force / contact.tangent;
            for (row, sign) in [(a, -1.0), (b, 1.0)] {
                for (column, other) in [(a, -1.0), (b, 1.0)] {
                    for i in 0..2 {
                        for j in 0..2 {
                            let value = curvature * contact.across[i] * contact.across[j] * sign * other;
                            visit(row + i, column + j, value);
                        }
                    }
                }
            }
        }
    }

    /// What a response reports, for displacements `q` and velocities `v`, the driver's shaft standing at `angle`.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn state(
        &self,
        geometry: Geometry,
        sigma: f64,
        angle: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<MeshState, Overlap> {
        let contact = self.contact(geometry, sigma, q, v)?;
        let centres = self.involute.centres(self.relative(q).apart)?;
        let turned = angle + q[self.coordinates.twist[0]];
        Ok(MeshState {
            deflection: contact.deflection,
            force: contact.force,
            stiffness: self.stiffness,
            pairs_in_contact: self.involute.pairs_in_contact(&centres, sigma, turned),
            centres,
        })
    }
}
