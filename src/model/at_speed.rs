//! Connections of the model, and the model at a constant speed.

use nalgebra::DVector;

use super::link::links;
use super::{Model, Numbering, Support, bearing_rows};
use crate::connection::{AppliedLoad, Connection, SpeedDependentBearing};
use crate::scene::{BearingCoefficient, LoadLaw, Node, Scene, SceneError};

/// Bearings with constant coefficients on the ground, and bearings that depend on the speed.
pub(super) fn bearings(scene: &Scene, numbering: &Numbering) -> (Vec<Support>, Vec<SpeedDependentBearing>) {
    let (mut supports, mut bearings) = (Vec::new(), Vec::new());
    for (number, bearing) in scene.bearings.iter().enumerate() {
        let (Some(index), Some(rows)) = (numbering.translation(bearing.node), bearing_rows(scene, numbering, bearing))
        else {
            continue;
        };
        match (bearing.stiffness.constant(), bearing.damping.constant()) {
            // A bearing on a housing is a link.
            (Some(_), Some(_)) if bearing.attachment.is_some() => {}
            (Some(stiffness), Some(damping)) => supports.push(Support::new(index, stiffness, damping)),
            _ => {
                let ratio = scene.speed_ratios[bearing.node.shaft];
                bearings.push(SpeedDependentBearing { number, bearing: bearing.clone(), rows, ratio });
            }
        }
    }
    (supports, bearings)
}

impl Model {
    /// All connections, meshes first, with the flanks that carry at a speed of the reference shaft, rad/s.
    pub fn connections(&self, speed: f64) -> impl Iterator<Item = Connection<'_>> {
        self.connections_with(move |mesh| self.sigma(mesh, speed))
    }

    /// All connections, meshes first, with the σ of each mesh.
    #[inline(always)]
    pub fn connections_with<'a>(
        &'a self,
        sigma: impl Fn(usize) -> f64 + 'a,
    ) -> impl Iterator<Item = Connection<'a>> + 'a {
        let meshes = self.meshes.iter().enumerate();
        let meshes = meshes.map(move |(index, mesh)| Connection::Mesh(index, mesh, sigma(index)));
        let others = self.bearings.iter().map(Connection::Bearing).chain(self.springs.iter().map(Connection::Spring));
        meshes.chain(others).chain(self.loads.iter().map(Connection::Load))
    }

    /// Refuses a speed of the reference shaft [rad/s] at which a bearing has no coefficients or a torque no value.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed of the shaft and the range of the table.
    pub fn check_speed(&self, speed: f64) -> Result<(), SceneError> {
        self.loads.iter().try_for_each(|load| load.check(speed))?;
        self.bearings.iter().try_for_each(|bearing| {
            let shaft = &self.scene.shafts[bearing.bearing.node.shaft];
            bearing.check(speed, &shaft.name)
        })
    }

    /// The model at a constant speed of the reference shaft [rad/s]: every bearing has constant coefficients and belongs
    /// to the matrices.
    ///
    /// # Errors
    /// [`SceneError`] where [`Self::check_speed`] refuses the speed.
    pub fn at_speed(&self, speed: f64) -> Result<Self, SceneError> {
        self.check_speed(speed)?;
        let mut model = self.clone();
        for bearing in &self.bearings {
            let given = &mut model.scene.bearings[bearing.number];
            let [stiffness, damping] = bearing.at(speed);
            given.stiffness = BearingCoefficient::Constant(stiffness);
            given.damping = BearingCoefficient::Constant(damping);
        }
        (model.supports, model.bearings) = bearings(&model.scene, &model.numbering);
        model.links = links(&model.scene, &model.numbering);
        Ok(model)
    }

    /// Whether stiffness or damping depend on the speed: those of bearings, or the slope of a torque over the speed.
    pub fn depends_on_speed(&self) -> bool {
        let is_over_speed = |load: &AppliedLoad| matches!(load.law, LoadLaw::SpeedTorque { .. });
        !self.bearings.is_empty() || self.loads.iter().any(is_over_speed)
    }

    /// Torques over the speed at a speed of the reference shaft, rad/s, n entries, N m.
    pub fn speed_torques(&self, speed: f64) -> DVector<f64> {
        let mut torques = DVector::zeros(self.len());
        for load in &self.loads {
            load.rows[0].iter().for_each(|(index, factor)| torques[*index] += factor * load.constant(speed));
        }
        torques
    }

    /// The bearings at a node whose coefficients depend on the speed.
    pub fn bearings_at(&self, node: Node) -> impl Iterator<Item = &SpeedDependentBearing> {
        self.bearings.iter().filter(move |bearing| bearing.bearing.node == node)
    }
}
