//! Which flank of a mesh presses: σ, the one rule for modes, equilibrium, synchronous response and motion.

use nalgebra::{DMatrix, DVector};

use super::Model;
use crate::linalg::Factors;

/// A tooth force below this part of what the largest torque would press with is round-off.
const UNLOADED: f64 = 1e-9;

/// The directions of rotation that σ distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// The reference shaft turns in the positive sense.
    Forward,
    /// It turns in the negative sense.
    Backward,
    /// It stands, and the torques press other flanks than those of a positive speed.
    Standing,
}

impl Model {
    /// σ of every mesh: the sign of its driver's spin. At speed zero the sign of the torque that the driver transmits,
    /// and of its speed ratio where it transmits none.
    pub fn sigma(&self, mesh: usize, speed: f64) -> f64 {
        if speed == 0.0 { self.sigma_standing[mesh] } else { self.sigma_forward(mesh) * speed.signum() }
    }

    /// The rotation that decides on σ at a speed of the reference shaft, rad/s.
    pub fn rotation(&self, speed: f64) -> Rotation {
        let stands_as_forward = || (0..self.meshes.len()).all(|mesh| self.sigma(mesh, 0.0) == self.sigma_forward(mesh));
        match speed {
            _ if speed < 0.0 => Rotation::Backward,
            _ if speed == 0.0 && !stands_as_forward() => Rotation::Standing,
            _ => Rotation::Forward,
        }
    }

    /// σ at a positive speed of the reference shaft.
    fn sigma_forward(&self, mesh: usize) -> f64 {
        self.scene.speed_ratios[self.meshes[mesh].shafts[0]].signum()
    }

    /// σ of every mesh at speed zero.
    pub(super) fn sigma_at_rest(&self) -> Vec<f64> {
        let forces = self.tooth_forces();
        let largest = self.scene.torques.iter().map(|torque| torque.value.abs()).fold(0.0, f64::max);
        let sigma = |(mesh, force): (usize, &f64)| {
            let moment = force * self.meshes[mesh].involute.base_radius[0];
            // A force that could not be found, which is not a number, presses nothing.
            if moment.abs() > UNLOADED * largest { force.signum() } else { self.sigma_forward(mesh) }
        };
        forces.iter().enumerate().map(sigma).collect()
    }

    /// Tooth force of every mesh between rigid shafts, N: positive where the driver presses counter-clockwise.
    ///
    /// In a train without loops these are the forces of the torque balance. Torques out of balance accelerate the train,
    /// and the inertia of its shafts takes its part of them.
    fn tooth_forces(&self) -> Vec<f64> {
        let shafts = self.shafts.len();
        if self.scene.torques.iter().all(|torque| torque.value == 0.0) {
            return vec![0.0; self.meshes.len()];
        }
        let mut torque = DVector::zeros(shafts);
        for given in &self.scene.torques {
            torque[given.node.shaft] += given.value;
        }
        // The rigid-body rotation turns every shaft by its part, by base radii: what published data round differently from
        // the tooth numbers would deflect the teeth.
        let rolling = self.rolling();
        let inertia = DVector::from_fn(shafts, |shaft, _| self.polar_inertia(shaft));
        let momentum = inertia.component_mul(&rolling);
        torque.axpy(-torque.dot(&rolling) / momentum.dot(&rolling), &momentum, 1.0);

        let mut stiffness = DMatrix::zeros(shafts, shafts);
        for mesh in &self.meshes {
            let lever: Vec<(usize, f64)> = mesh.shafts.into_iter().zip(mesh.involute.base_radius).collect();
            for (row, left) in &lever {
                for (column, right) in &lever {
                    stiffness[(*row, *column)] += mesh.stiffness * left * right;
                }
            }
        }
        // The rigid-body rotation gets a stiffness of the size of the others; the balanced torques do not drive it.
        let size = stiffness.trace() / rolling.norm_squared();
        stiffness.ger(size, &rolling, &rolling, 1.0);
        let turned = Factors::of(&stiffness).solve(&DMatrix::from_column_slice(shafts, 1, torque.as_slice()));
        let force = |mesh: &crate::mesh::GearMesh| {
            let [a, b] = mesh.shafts;
            let [ra, rb] = mesh.involute.base_radius;
            mesh.stiffness * (ra * turned[(a, 0)] + rb * turned[(b, 0)])
        };
        self.meshes.iter().map(force).collect()
    }

    /// Rotation of every shaft as the train rolls without deflecting its teeth, that of the first shaft being one.
    fn rolling(&self) -> DVector<f64> {
        let mut rolling = DVector::zeros(self.shafts.len());
        rolling[0] = 1.0;
        // Every pass reaches the next shafts; meshes connect all of them.
        for _ in 0..self.shafts.len() {
            for mesh in &self.meshes {
                let ([a, b], [ra, rb]) = (mesh.shafts, mesh.involute.base_radius);
                if rolling[b] == 0.0 {
                    rolling[b] = -rolling[a] * ra / rb;
                } else if rolling[a] == 0.0 {
                    rolling[a] = -rolling[b] * rb / ra;
                }
            }
        }
        rolling
    }

    /// Moment of inertia of a shaft with all that it carries about its own axis, kg m².
    fn polar_inertia(&self, shaft: usize) -> f64 {
        let mut turned = vec![0.0; self.len()];
        for dof in
            self.numbering.dofs().iter().filter(|dof| dof.node.shaft == shaft && dof.kind == super::DofKind::Twist)
        {
            turned[dof.index] = 1.0;
        }
        self.kinetic_form(&turned)
    }
}
