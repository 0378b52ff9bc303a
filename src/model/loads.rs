//! Loads of the scene: torques, forces, gravity, misaligned couplings.

use nalgebra::DVector;
use num_complex::Complex64;

use super::{DofKind, Excitation, Model};
use crate::connection::AppliedLoad;
use crate::scene::{Force, Node, Scene, SceneError, VaryingLoad};

impl Model {
    /// Adds the forces and torques of the scene.
    pub(super) fn add_loads(&mut self) {
        self.loads = self.varying_loads();
        self.bows = self.turning_bows();
        self.set_resisted_rotations();
        self.add_turning_forces();
        self.constant_load = self.assemble_constant_load();
        self.sigma_standing = self.sigma_at_rest();
    }

    /// The model of a scene that differs from that of this model in loads only; `None` if the loads change the coordinates.
    ///
    /// # Errors
    /// [`SceneError`] if the bearings do not define the sag of a bow.
    pub fn with_loads(&self, scene: Scene) -> Result<Option<Self>, SceneError> {
        if !has_same_coordinates(&self.scene, &scene) {
            return Ok(None);
        }
        let mut model = Self { scene, ..self.clone() };
        for (index, shaft) in model.shafts.iter_mut().enumerate() {
            shaft.set_bow_and_unbalance(&model.scene, index)?;
        }
        model.add_loads();
        Ok(Some(model))
    }

    /// Forces and torques that depend on time, angle or speed, on the coordinates that the scene has.
    fn varying_loads(&self) -> Vec<AppliedLoad> {
        let load = |given: &VaryingLoad| {
            let rows = if given.law.is_torque() {
                vec![vec![(self.numbering.twist(given.node)?, 1.0)]]
            } else {
                let index = self.numbering.translation(given.node)?;
                vec![vec![(index, 1.0)], vec![(index + 1, 1.0)]]
            };
            let (path, shaft, law) = (given.path.clone(), given.node.shaft, given.law.clone());
            Some(AppliedLoad { path, rows, shaft, ratio: self.scene.speed_ratios[shaft], law })
        };
        self.scene.varying_loads.iter().filter_map(load).collect()
    }

    /// Adds the forces that turn with a shaft, and those of eccentric hubs of couplings, to the excitations of the shafts.
    fn add_turning_forces(&mut self) {
        let none = Complex64::ZERO;
        let force = |index: usize, force: Complex64| Excitation { index, bow: none, force, unbalance: none };
        for given in self.scene.forces.iter().filter(|force| force.turns) {
            if let Some(index) = self.numbering.translation(given.node) {
                self.shafts[given.node.shaft].excitations.push(force(index, given.value));
            }
        }
        for (link, rest) in self.links.iter().filter_map(|link| Some((link, link.rest?))) {
            // The entries of each hub are a pair (v, w).
            let [along_v, along_w] = [&link.rows[0], &link.rows[1]];
            let amplitude = rest.turning * link.local.stiffness[0][0];
            for ((index, coefficient), _) in along_v.iter().zip(along_w).filter(|_| amplitude != Complex64::ZERO) {
                self.shafts[rest.shaft].excitations.push(force(*index, amplitude * *coefficient));
            }
        }
    }

    /// Power of a force y + iz, N, on a node that moves with the velocities v, m/s.
    pub fn power(&self, node: Node, force: Complex64, v: &[f64]) -> f64 {
        self.numbering.translation(node).map_or(0.0, |index| force.re * v[index] + force.im * v[index + 1])
    }

    /// Axial forces, N, with the index of their coordinate.
    fn thrusts(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let thrust = |force: &Force| Some((self.numbering.displacement_along(force.node)?, force.axial));
        self.scene.forces.iter().filter(|force| force.axial != 0.0).filter_map(thrust)
    }

    /// Constant torques, N m, and forces, N, of the scene.
    pub fn given_load(&self) -> DVector<f64> {
        let mut load = DVector::zeros(self.len());
        for torque in &self.scene.torques {
            if let Some(index) = self.numbering.twist(torque.node) {
                load[index] += torque.value;
            }
        }
        for force in self.scene.forces.iter().filter(|force| !force.turns) {
            if let Some(index) = self.numbering.translation(force.node) {
                load[index] += force.value.re;
                load[index + 1] += force.value.im;
            }
        }
        self.thrusts().for_each(|(index, force)| load[index] += force);
        load
    }

    /// The given loads, the forces of misaligned couplings, and the weight.
    fn assemble_constant_load(&self) -> DVector<f64> {
        let mut load = self.given_load();
        for (link, rest) in self.links.iter().filter_map(|link| Some((link, link.rest?))) {
            link.rest_force(rest.fixed).for_each(|(index, force)| load[index] += force);
        }
        self.add_weight(load.as_mut_slice());
        load
    }

    /// Weights along the coordinates, N; without those in frames that turn.
    pub fn weight(&self) -> DVector<f64> {
        let mut load = DVector::zeros(self.len());
        self.add_weight(load.as_mut_slice());
        load
    }

    fn add_weight(&self, load: &mut [f64]) {
        if self.scene.gravity != [0.0; 2] {
            let mut acceleration = DVector::zeros(self.len());
            for dof in self.numbering.nodal_dofs() {
                match dof.kind {
                    DofKind::V => acceleration[dof.index] = self.scene.gravity[0],
                    DofKind::W => acceleration[dof.index] = self.scene.gravity[1],
                    _ => {}
                }
            }
            for node in self.housing_nodes() {
                if let Some(v) = self.numbering.translation(node) {
                    (acceleration[v], acceleration[v + 1]) = self.scene.gravity.into();
                }
            }
            for (start, elastic) in self.elastic_housings() {
                let [y, z] = self.scene.gravity;
                for (mode, acceleration) in
                    acceleration.iter_mut().skip(start).take(elastic.frequencies.len()).enumerate()
                {
                    *acceleration = elastic.translation.as_ref().map_or(0.0, |[_, v, w]| y * v[mode] + z * w[mode]);
                }
            }
            for (index, shaft) in self.shafts.iter().enumerate() {
                if let (Some(_), Some(chain)) = (self.scene.frame_of(index), &shaft.bending) {
                    acceleration.as_mut_slice()[chain.coordinates::<2>()].fill(0.0);
                }
            }
            self.multiply_mass(acceleration.as_slice(), load);
        }
    }

    /// Weights of the shafts in the frame of a carrier that turns, at its angle zero, as entries (index of v, force over y + iz), N.
    pub fn weight_in_frame(&self, carrier: usize) -> Vec<(usize, Complex64)> {
        let gravity = Complex64::new(self.scene.gravity[0], self.scene.gravity[1]);
        if gravity == Complex64::ZERO {
            return Vec::new();
        }
        let (mut along, mut mass) = (vec![0.0; self.len()], vec![0.0; self.len()]);
        for (index, shaft) in self.scene.shafts.iter().enumerate() {
            let nodes = (0..shaft.nodes.len()).filter(|_| self.scene.frame_of(index) == Some(carrier));
            for v in nodes.filter_map(|node| self.numbering.translation(Node { shaft: index, node })) {
                along[v] = 1.0;
            }
        }
        self.multiply_mass(&along, &mut mass);
        let weights = mass.into_iter().enumerate().filter(|(_, mass)| *mass != 0.0);
        weights.map(|(index, mass)| (index, mass * gravity)).collect()
    }
}

/// Whether two scenes have the same nodes and the same kinds of coordinates.
pub(super) fn has_same_coordinates(first: &Scene, second: &Scene) -> bool {
    let kinds = |scene: &Scene| (scene.lateral, scene.torsion, scene.axial);
    let nodes = |scene: &Scene| scene.shafts.iter().map(|shaft| shaft.nodes.clone()).collect::<Vec<_>>();
    kinds(first) == kinds(second) && nodes(first) == nodes(second)
}
