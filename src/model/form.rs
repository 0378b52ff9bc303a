//! Energies as quadratic forms, summed over elements, bodies, bearings and meshes.

use super::{Model, Support};

impl Model {
    /// vᵀMv.
    pub fn kinetic_form(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                sum += chain.mass.quadratic::<2>(&v[chain.start..]);
            }
            if let Some(chain) = &shaft.twist {
                sum += chain.mass.quadratic::<1>(&v[chain.start..]);
            }
        }
        sum
    }

    /// vᵀCv of shafts and bearings.
    pub fn damping_form(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for shaft in &self.shafts {
            if let Some((chain, damping)) =
                shaft.bending.as_ref().and_then(|chain| Some((chain, chain.damping.as_ref()?)))
            {
                sum += damping.quadratic::<2>(&v[chain.start..]);
            }
            if let Some((chain, damping)) =
                shaft.twist.as_ref().and_then(|chain| Some((chain, chain.damping.as_ref()?)))
            {
                sum += damping.quadratic::<1>(&v[chain.start..]);
            }
        }
        sum + self.form_of_supports(v, |support| &support.damping)
    }

    /// qᵀKq of shafts, bearings with constant coefficients, springs, and meshes at rest with the given σ; of bearings the
    /// restoring part.
    pub fn elastic_form(&self, q: &[f64], sigma: impl Fn(usize) -> f64) -> f64 {
        let meshes = self.meshes.iter().enumerate();
        let strained = meshes.map(|(index, mesh)| mesh.stiffness * mesh.deflection_at_rest(sigma(index), q).powi(2));
        let springs = self.springs.iter().map(|spring| spring.stiffness * spring.scalar(q).powi(2));
        self.unmeshed_elastic_form(q) + strained.sum::<f64>() + springs.sum::<f64>()
    }

    /// qᵀKq of shafts and bearings; of bearings the restoring part.
    pub fn unmeshed_elastic_form(&self, q: &[f64]) -> f64 {
        self.shaft_form(q) + self.form_of_supports(q, |support| &support.symmetric_part)
    }

    /// qᵀKq of the shafts alone.
    pub fn shaft_form(&self, q: &[f64]) -> f64 {
        let mut sum = 0.0;
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                sum += chain.elastic_form::<2>(&q[chain.start..]);
            }
            if let Some(chain) = &shaft.twist {
                sum += chain.elastic_form::<1>(&q[chain.start..]);
            }
        }
        sum
    }

    /// qᵀKq of the bearings alone.
    pub fn support_form(&self, q: &[f64]) -> f64 {
        self.form_of_supports(q, |support| &support.stiffness)
    }

    fn form_of_supports(&self, q: &[f64], of: impl Fn(&Support) -> &[[f64; 2]; 2]) -> f64 {
        self.supports.iter().map(|support| form(of(support), [q[support.index], q[support.index + 1]])).sum()
    }
}

/// uᵀku.
pub(super) fn form(k: &[[f64; 2]; 2], u: [f64; 2]) -> f64 {
    k[0][0] * u[0] * u[0] + (k[0][1] + k[1][0]) * u[0] * u[1] + k[1][1] * u[1] * u[1]
}
