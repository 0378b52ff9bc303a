//! Checks the material of a shaft.

use super::{EntryPath, SceneError, description};

/// A checked isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E, Pa.
    pub youngs_modulus: f64,
    /// Shear modulus G, Pa.
    pub shear_modulus: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Density ρ, kg/m³.
    pub density: f64,
}

impl Material {
    pub(super) fn new(given: &description::Material, at: &EntryPath) -> Result<Self, SceneError> {
        let youngs_modulus = at.field("youngs_modulus").positive(given.youngs_modulus)?;
        let density = at.field("density").positive(given.density)?;
        let (shear_modulus, poisson_ratio) = match (given.shear_modulus, given.poisson_ratio) {
            (None, Some(nu)) => (youngs_modulus / (2.0 * (1.0 + nu)), nu),
            (Some(g), None) => {
                let g = at.field("shear_modulus").positive(g)?;
                (g, youngs_modulus / (2.0 * g) - 1.0)
            }
            _ => return Err(at.error("needs one of poisson_ratio and shear_modulus")),
        };
        if !(-1.0 < poisson_ratio && poisson_ratio <= 0.5) {
            return Err(at
                .field("poisson_ratio")
                .error(format!("must lie above -1 and up to 0.5, got {poisson_ratio}")));
        }
        Ok(Self { youngs_modulus, shear_modulus, poisson_ratio, density })
    }
}
