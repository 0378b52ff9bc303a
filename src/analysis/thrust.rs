//! Geometric stiffness of the axial forces in the static equilibrium, such as the thrust of helical gears.

use super::{AnalysisError, equilibrium};
use crate::mesh::Geometry;
use crate::modal::CachedModel;
use crate::model::Model;
use crate::scene::{Scene, SceneError};

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
