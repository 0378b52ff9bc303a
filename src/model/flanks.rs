//! Loaded flank σ = ±1 of every mesh, for modes, equilibrium, synchronous response and motion.
//!
//! σ is the sign of the spin of the driver. At speed zero it is the sign of the torque that the driver transmits; if it
//! transmits none, it is the sign for a positive speed of the reference shaft.

use nalgebra::{DMatrix, DVector};

use super::Model;
use crate::linalg::LuFactors;
use crate::mesh::GearMesh;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::Coupling;

/// Directions of rotation with different σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// The reference shaft has a positive speed, or speed zero with the same σ.
    Forward,
    /// The reference shaft has a negative speed.
    Backward,
    /// The reference shaft is at rest, and its σ differs from that of a positive speed.
    Standing,
}

impl Rotation {
    /// A speed of the reference shaft with this direction, rad/s: what follows from the direction alone is computed at it.
    pub fn speed(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Standing => 0.0,
        }
    }
}

impl Model {
    /// σ of a mesh at a speed of the reference shaft, rad/s.
    pub fn sigma(&self, mesh: usize, speed: f64) -> f64 {
        if speed == 0.0 { self.sigma_standing[mesh] } else { self.sigma_forward(mesh) * speed.signum() }
    }

    /// Direction of rotation that determines σ at a speed of the reference shaft, rad/s.
    pub fn rotation(&self, speed: f64) -> Rotation {
        let rest_equals_forward =
            || (0..self.meshes.len()).all(|mesh| self.sigma(mesh, 0.0) == self.sigma_forward(mesh));
        match speed {
            _ if speed < 0.0 => Rotation::Backward,
            _ if speed == 0.0 && !rest_equals_forward() => Rotation::Standing,
            _ => Rotation::Forward,
        }
    }

    /// σ of a mesh at a positive speed of the reference shaft.
    fn sigma_forward(&self, mesh: usize) -> f64 {
        self.scene.mesh_speed_ratios(&self.scene.meshes[mesh])[0].signum()
    }

    /// σ of every mesh at speed zero.
    pub(super) fn sigma_at_rest(&self) -> Vec<f64> {
        let forces = self.tooth_forces();
        let largest = self.scene.torques.iter().map(|torque| torque.value.abs()).fold(0.0, f64::max);
        let sigma = |(mesh, force): (usize, &f64)| {
            let moment = force * self.meshes[mesh].involute.base_radius[0];
            // A moment of zero beside the largest torque, or NaN, the result of a singular system, counts as unloaded.
            if moment.abs() > EQUALITY_TOLERANCE * largest { force.signum() } else { self.sigma_forward(mesh) }
        };
        forces.iter().enumerate().map(sigma).collect()
    }

    /// Tooth force of every mesh with rigid shafts, N; positive if the driver transmits a counter-clockwise torque.
    ///
    /// In a train without loops the torque balance determines these forces. Unbalanced torques accelerate the train;
    /// the inertia forces of the shafts are then part of the balance.
    fn tooth_forces(&self) -> Vec<f64> {
        let shafts = self.shafts.len();
        let varying = || self.loads.iter().filter(|load| load.law.is_torque());
        if self.scene.torques.iter().all(|torque| torque.value == 0.0) && varying().next().is_none() {
            return vec![0.0; self.meshes.len()];
        }
        let mut torque = DVector::zeros(shafts);
        for load in varying() {
            torque[load.shaft] += load.law.first_torque();
        }
        for given in &self.scene.torques {
            torque[given.node.shaft] += given.value;
        }
        // The rigid-body rotation follows the base radii. Ratios of tooth numbers may differ from them by rounding of
        // the given data, and would deflect the teeth.
        let rotation = self.rigid_body_rotation();
        let inertia = DVector::from_fn(shafts, |shaft, _| self.polar_inertia(shaft));
        let momentum = inertia.component_mul(&rotation);
        let held = self.scene.drives.iter().any(|drive| drive.stiffness > 0.0 && rotation[drive.node.shaft] != 0.0);
        if !held {
            torque.axpy(-torque.dot(&rotation) / momentum.dot(&rotation), &momentum, 1.0);
        }

        let mut stiffness = DMatrix::zeros(shafts, shafts);
        for mesh in &self.meshes {
            let levers = levers(mesh);
            for (row, left) in &levers {
                for (column, right) in &levers {
                    stiffness[(*row, *column)] += mesh.stiffness * left * right;
                }
            }
        }
        for Coupling { hubs: [a, b], torsional, .. } in &self.scene.couplings {
            for (row, column, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                stiffness[(row.shaft, column.shaft)] += sign * torsional.stiffness;
            }
        }
        for drive in &self.scene.drives {
            stiffness[(drive.node.shaft, drive.node.shaft)] += drive.stiffness;
        }
        // A stiffness against the rigid-body rotation makes the matrix regular. The balanced torques do not excite it.
        if !held {
            let size = stiffness.trace() / rotation.norm_squared();
            stiffness.ger(size, &rotation, &rotation, 1.0);
        }
        let angle = LuFactors::new(&stiffness).solve(&DMatrix::from_column_slice(shafts, 1, torque.as_slice()));
        let force = |mesh: &GearMesh| {
            mesh.stiffness * levers(mesh).into_iter().map(|(shaft, lever)| lever * angle[(shaft, 0)]).sum::<f64>()
        };
        self.meshes.iter().map(force).collect()
    }

    /// Rotation of every shaft in the motion of the train that deflects no teeth, relative to the first shaft that turns.
    fn rigid_body_rotation(&self) -> DVector<f64> {
        let turns = |ratio: &f64| *ratio != 0.0;
        let first = self.scene.speed_ratios.iter().position(turns).unwrap_or_default();
        DVector::from_vec(self.scene.rotations_with(first))
    }

    /// Polar moment of inertia of a shaft and its bodies, kg m².
    fn polar_inertia(&self, shaft: usize) -> f64 {
        let mut rotation = vec![0.0; self.len()];
        for dof in
            self.numbering.dofs().iter().filter(|dof| dof.node.shaft == shaft && dof.kind == super::DofKind::Twist)
        {
            rotation[dof.index] = 1.0;
        }
        self.kinetic_form(&rotation)
    }
}

/// Levers ∂(r_a θ_a + r_b θ_b)/∂θ of the rolling displacement of a mesh on its shafts and its carrier, m.
fn levers(mesh: &GearMesh) -> Vec<(usize, f64)> {
    let carrier = mesh.carrier.map(|shaft| (shaft, -mesh.involute.base_circles()));
    mesh.shafts.into_iter().zip(mesh.involute.base_radius).chain(carrier).collect()
}
