//! Static equilibrium of a system at a speed, with the errors of an analysis.

use nalgebra::DVector;

use super::AnalysisError;
use crate::mesh::Geometry;
use crate::modal::{self, CachedModel, EquilibriumError, EquilibriumSpeeds};
use crate::model::Model;
use crate::scene::{Scene, SceneError};

/// Displacements q of the equilibrium under torques, gravity and the forces of meshes and films, at `speed` of the reference
/// shaft, rad/s, which also determines the flanks in contact. Bow and unbalance rotate and are not included.
///
/// # Errors
/// [`AnalysisError`] if the load has no equilibrium, base circles overlap, a journal touches its bearing, or the iteration
/// fails.
pub fn equilibrium(cached: &CachedModel, geometry: Geometry, speed: f64) -> Result<DVector<f64>, AnalysisError> {
    equilibrium_with_flanks(cached, geometry, EquilibriumSpeeds::from(speed))
}

/// Largest unbalanced force, or moment over the length, of every shaft and then of every support and housing over its load,
/// at displacements q of [`equilibrium`] with the same arguments.
///
/// # Errors
/// As [`equilibrium`].
pub fn equilibrium_residuals(
    cached: &CachedModel,
    geometry: Geometry,
    speed: f64,
    q: &DVector<f64>,
) -> Result<Vec<f64>, AnalysisError> {
    Ok(modal::equilibrium_residuals(&cached.at(speed, 0.0)?.model, geometry, speed.into(), q)?)
}

/// The static equilibrium. One speed determines the bearings; a second one determines the flanks in contact and the torques
/// over the speed.
pub(super) fn equilibrium_with_flanks(
    cached: &CachedModel,
    geometry: Geometry,
    speeds: EquilibriumSpeeds,
) -> Result<DVector<f64>, AnalysisError> {
    Ok(cached.at(speeds.film, 0.0)?.equilibrium(geometry, speeds)?)
}

impl From<EquilibriumError> for AnalysisError {
    fn from(error: EquilibriumError) -> Self {
        match error {
            EquilibriumError::Scene(error) => error.into(),
            EquilibriumError::Overlap { gears: [driver, driven], overlap } => {
                Self::overlap(&driver, &driven, "in static equilibrium", overlap)
            }
            EquilibriumError::Convergence(message) => Self::Convergence(message),
            EquilibriumError::Decomposition(error) => error.into(),
        }
    }
}

/// The model of a scene whose elements have, beside their own axial force, that of the static equilibrium at rest. The force in
/// an element is the mean of that at its nodes.
///
/// # Errors
/// [`AnalysisError`] if the load has no equilibrium, or a shaft buckles under its axial force.
pub fn with_axial_forces(scene: Scene) -> Result<Model, AnalysisError> {
    let model = Model::new(scene)?;
    if !model.scene.axial {
        return Ok(model);
    }
    if model.needs_speed() {
        let message = "the axial forces are those of the equilibrium at rest, and a bearing or the internal damping of a shaft depends on the speed; give axial_force of the shaft instead";
        return Err(SceneError::new("geometric_stiffness", message).into());
    }
    let cached = CachedModel::new(model);
    let q = equilibrium(&cached, Geometry::Live, 0.0)?;
    let mut scene = cached.model.scene.clone();
    for (shaft, known) in scene.shafts.iter_mut().zip(&cached.model.shafts) {
        let Some(chain) = &known.axial else { continue };
        let displacements = q.rows(chain.start, chain.nodes);
        for (node, (element, rod)) in shaft.elements.iter_mut().zip(&chain.elements).enumerate() {
            element.axial_force += rod.stiffness * (displacements[node + 1] - displacements[node]);
        }
    }
    Ok(Model::new(scene)?)
}
