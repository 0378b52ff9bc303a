//! Power that meshes transmit, and their losses by friction, at the static equilibrium of a speed.

use super::{AnalysisError, equilibrium};
use crate::mesh::{Geometry, MeshLoss};
use crate::modal::CachedModel;
use crate::model::Model;

/// Powers of a train at a speed.
#[derive(Clone, Debug)]
pub struct Losses {
    /// Power that torques and drives supply, W.
    pub input: f64,
    /// Each mesh.
    pub meshes: Vec<MeshLoss>,
}

/// Powers and losses at `speed` of the reference shaft, rad/s. The loss of a mesh is the mean over its cycle with the force of the
/// equilibrium without friction.
///
/// # Errors
/// As [`equilibrium()`].
pub fn losses(cached: &CachedModel, geometry: Geometry, speed: f64) -> Result<Losses, AnalysisError> {
    let q = equilibrium(cached, geometry, speed)?;
    let at_speed = cached.at_speed(speed)?;
    let model = &at_speed.model;
    let of_mesh = |index: usize| {
        let mesh = &model.meshes[index];
        let spins = model.scene.mesh_speed_ratios(&model.scene.meshes[index]).map(|ratio| ratio * speed);
        mesh.loss_at_rest(geometry, model.sigma(index, speed), spins, q.as_slice()).map_err(|overlap| {
            let [driver, driven] = model.gear_names(index);
            AnalysisError::overlap(driver, driven, "in static equilibrium", overlap)
        })
    };
    let meshes = (0..model.meshes.len()).map(of_mesh).collect::<Result<_, _>>()?;
    Ok(Losses { input: input_power(model, speed, q.as_slice()), meshes })
}

/// Sum of the positive powers of torques and drives at the prescribed rotation, W.
fn input_power(model: &Model, speed: f64, q: &[f64]) -> f64 {
    let mut spins = vec![0.0; model.len()];
    for shaft in &model.shafts {
        if let Some(chain) = &shaft.twist {
            spins[chain.start..chain.start + chain.nodes].fill(shaft.ratio * speed);
        }
    }
    let given = model.given_load();
    let constant = given.iter().zip(&spins).map(|(load, spin)| load * spin);
    let varying = model.loads.iter().map(|load| load.constant(speed) * load.rate(&spins));
    let rest = vec![0.0; model.len()];
    // A coupling has the same torque at both ends, so that its power is zero; that of a drive is not.
    let links = model.links.iter().map(|link| {
        let (force, rates) = (link.force(q, &rest), link.scalars(&spins));
        -(force[0] * rates[0] + force[1] * rates[1])
    });
    constant.chain(varying).chain(links).map(|power| power.max(0.0)).sum()
}
