//! Quadratic forms of energy and dissipation, summed over elements, bodies, bearings and meshes.
//!
//! q, m and rad, and v, m/s and rad/s, have n entries in the order of the core.

use nalgebra::DVector;
use num_complex::Complex64;

use super::{Model, Support};

impl Model {
    /// vᵀMv, twice the kinetic energy, J.
    pub fn kinetic_form(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                sum += chain.mass.quadratic_form::<2>(&v[chain.start..]);
            }
            for chain in shaft.rods() {
                sum += chain.mass.quadratic_form::<1>(&v[chain.start..]);
            }
        }
        if self.housings.inertia.is_empty() { sum } else { sum + self.housings.kinetic_form(v) }
    }

    /// φᴴMφ of a complex vector.
    pub fn complex_kinetic_form(&self, shape: &DVector<Complex64>) -> f64 {
        let part = |part: fn(&Complex64) -> f64| self.kinetic_form(shape.map(|value| part(&value)).as_slice());
        part(|value| value.re) + part(|value| value.im)
    }

    /// vᵀCv, the dissipated power of shafts and bearings without modal damping, W.
    pub fn damping_form(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for shaft in &self.shafts {
            if let Some((chain, damping)) =
                shaft.bending.as_ref().and_then(|chain| Some((chain, chain.damping.as_ref()?)))
            {
                sum += damping.quadratic_form::<2>(&v[chain.start..]);
            }
            for (chain, damping) in shaft.rods().filter_map(|chain| Some((chain, chain.damping.as_ref()?))) {
                sum += damping.quadratic_form::<1>(&v[chain.start..]);
            }
        }
        sum + self.sum_over_supports(v, |support| &support.damping)
    }

    /// qᵀKq of shafts, meshes at rest and the symmetric part of the stiffness of bearings with constant
    /// coefficients, J; `sigma` gives the loaded flank of each mesh.
    pub fn elastic_form(&self, q: &[f64], sigma: impl Fn(usize) -> f64) -> f64 {
        let meshes = self.meshes.iter().enumerate();
        let mesh_forms = meshes.map(|(index, mesh)| mesh.stiffness * mesh.deflection_at_rest(sigma(index), q).powi(2));
        self.elastic_form_without_meshes(q) + mesh_forms.sum::<f64>()
    }

    /// qᵀKq of shafts and the symmetric part of the bearing stiffness, J.
    pub fn elastic_form_without_meshes(&self, q: &[f64]) -> f64 {
        self.shaft_form(q) + self.sum_over_supports(q, |support| &support.symmetric_part)
    }

    /// qᵀKq of the shafts, J.
    pub fn shaft_form(&self, q: &[f64]) -> f64 {
        let mut sum = 0.0;
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                sum += chain.elastic_form::<2>(&q[chain.start..]);
            }
            for chain in shaft.rods() {
                sum += chain.elastic_form::<1>(&q[chain.start..]);
            }
        }
        sum
    }

    /// qᵀKq of bearings and links, J.
    pub fn support_form(&self, q: &[f64]) -> f64 {
        self.sum_over_supports(q, |support| &support.stiffness)
    }

    fn sum_over_supports(&self, q: &[f64], coefficient: impl Fn(&Support) -> &[[f64; 2]; 2]) -> f64 {
        let supports = self.supports.iter();
        let sum = supports.map(|support| form(coefficient(support), [q[support.index], q[support.index + 1]])).sum();
        self.links.iter().fold(sum, |sum, link| sum + form(coefficient(&link.local), link.scalars(q)))
    }
}

/// uᵀku.
pub(super) fn form(k: &[[f64; 2]; 2], u: [f64; 2]) -> f64 {
    k[0][0] * u[0] * u[0] + (k[0][1] + k[1][0]) * u[0] * u[1] + k[1][1] * u[1] * u[1]
}
