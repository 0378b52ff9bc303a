//! A spring and damper on one scalar, with a cubic term: F = k u + k₃ u³ + c u̇, u = Σ w_i q_i.
//!
//! This is the simplest connection that answers every question. A scene cannot contain it. The tests build models with
//! it to check that no analysis ignores a connection, and `docs/adding_a_connection.md` uses it as the example.

use super::{Bounds, Coefficients, Row};
use crate::mesh::Contact;

/// A spring and damper on one scalar.
#[derive(Clone, Debug)]
pub struct Spring {
    /// The scalar u as entries (index of a coordinate, coefficient w_i).
    pub row: Row,
    /// Stiffness k, N/m for a scalar in m.
    pub stiffness: f64,
    /// Cubic stiffness k₃, N/m³.
    pub cubic: f64,
    /// Damping c, N s/m.
    pub damping: f64,
}

impl Spring {
    /// The scalar of the spring.
    pub fn rows(&self) -> Vec<Row> {
        vec![self.row.clone()]
    }

    /// Stiffness and damping about u = 0.
    pub fn linear(&self) -> Coefficients {
        Coefficients::over_one(self.stiffness, self.damping)
    }

    /// Bounds of the damping and of the stiffness above k. The cubic term has no bound. For a large cubic term, use a
    /// Runge–Kutta method with error control.
    pub fn bounds(&self) -> Bounds {
        Bounds { excess_stiffness: 0.0, damping: self.damping }
    }

    /// Scalar u for displacements, or u̇ for velocities.
    #[inline]
    pub fn scalar(&self, q: &[f64]) -> f64 {
        self.row.iter().map(|(index, coefficient)| coefficient * q[*index]).sum()
    }

    /// Force, stiffness, energy and power at u and u̇.
    #[inline]
    pub fn contact(&self, u: f64, rate: f64) -> Contact {
        let cube = self.cubic * u * u;
        Contact {
            deflection: u,
            rate,
            force: (self.stiffness + cube) * u + self.damping * rate,
            stiffness: self.stiffness + 3.0 * cube,
            energy: (self.stiffness / 2.0 + cube / 4.0) * u * u,
            damping_power: self.damping * rate * rate,
            back_flank_deflection: f64::NEG_INFINITY,
            ..Contact::default()
        }
    }

    /// Subtracts the force from the generalised forces of its coordinates.
    #[inline]
    pub fn apply(&self, force: f64, out: &mut [f64]) {
        for (index, coefficient) in &self.row {
            out[*index] -= coefficient * force;
        }
    }

    /// ∂F/∂u and F at the displacements q, without damping.
    pub fn tangent(&self, q: &[f64]) -> (f64, f64) {
        let contact = self.contact(self.scalar(q), 0.0);
        (contact.stiffness, contact.force)
    }
}
