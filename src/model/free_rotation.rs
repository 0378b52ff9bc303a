//! Rigid-body rotation of a train that nothing holds: the prescribed speed keeps it, and its drive supplies losses.

use super::{Link, Model};
use crate::connection::{AppliedLoad, Row};
use crate::mesh::GearMesh;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::{LoadLaw, Phase};

impl Model {
    /// The rigid-body rotation of everything that turns with a shaft, with the value 1 there; none if a link holds it.
    pub(super) fn free_rotation(&self, shaft: usize) -> Option<Vec<f64>> {
        let mut rotation = vec![0.0; self.len()];
        for (other, ratio) in self.scene.rotations_with(shaft).into_iter().enumerate() {
            if let Some(chain) = self.shafts[other].twist.as_ref() {
                rotation[chain.start..chain.start + chain.nodes].fill(ratio);
            }
        }
        let holds = |link: &Link| {
            link.local.elastic_form(&link.scalars(&rotation)) > EQUALITY_TOLERANCE * link.local.elastic_form(&[1.0; 2])
        };
        (!self.links.iter().any(holds)).then_some(rotation)
    }

    /// Mφ/(φᵀMφ) of a rigid-body rotation φ.
    pub(super) fn inertia_shares(&self, rotation: &[f64]) -> Vec<f64> {
        let mut momentum = vec![0.0; self.len()];
        self.multiply_mass(rotation, &mut momentum);
        let inertia: f64 = momentum.iter().zip(rotation).map(|(momentum, rotation)| momentum * rotation).sum();
        momentum.into_iter().map(|momentum| momentum / inertia).collect()
    }

    /// Finds for the friction of each mesh the rotation whose drive supplies the loss: one that is free, that neither a damper
    /// nor a torque over the speed balances, with teeth that follow the prescribed rotation.
    pub(super) fn set_resisted_rotations(&mut self) {
        let balances = |load: &AppliedLoad| matches!(load.law, LoadLaw::SpeedTorque { .. });
        let damps = |link: &Link, rotation: &[f64]| {
            let ([y, z], [[a, b], [c, d]]) = (link.scalars(rotation), link.local.damping);
            y * (a * y + b * z) + z * (c * y + d * z) > EQUALITY_TOLERANCE * (a.abs() + d.abs())
        };
        let resisted = |mesh: &GearMesh| {
            mesh.friction.as_ref().filter(|_| mesh.phase == Phase::Prescribed)?;
            let turning = mesh.shafts.into_iter().find(|shaft| self.scene.speed_ratios[*shaft] != 0.0)?;
            let rotation = self.free_rotation(turning)?;
            let is_free = !self.loads.iter().any(balances) && !self.links.iter().any(|link| damps(link, &rotation));
            is_free.then(|| entries(self.inertia_shares(&rotation)))
        };
        let rotations: Vec<_> = self.meshes.iter().map(resisted).collect();
        for (mesh, rotation) in self.meshes.iter_mut().zip(rotations) {
            if let Some(friction) = &mut mesh.friction {
                friction.rotation = rotation.unwrap_or_default();
            }
        }
    }
}

/// The entries of a column that are not zero.
pub(super) fn entries(column: Vec<f64>) -> Row {
    column.into_iter().enumerate().filter(|(_, factor)| *factor != 0.0).collect()
}
