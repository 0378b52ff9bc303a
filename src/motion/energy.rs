//! Energies of the motion, and forces that a response reports.

use super::EquationOfMotion;
use crate::connection::Connection;
use crate::mesh::{MeshState, Overlap};
use crate::model::{Link, Model};
use crate::scene::Node;

/// Energies, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy ½vᵀMv.
    pub kinetic: f64,
    /// Elastic energy of the shafts, ½(q − q_b)ᵀK_s(q − q_b), with the stress-free shape q_b.
    pub shafts: f64,
    /// Elastic energy of the bearings, ½qᵀK_bearings q, and of all other connections except meshes.
    pub bearings: f64,
    /// Sum of the elastic energies U of the meshes.
    pub meshes: f64,
}

impl Energies {
    /// Total energy, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.shafts + self.bearings + self.meshes
    }
}

impl<'m> EquationOfMotion<'m> {
    /// Kinetic and elastic energy.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn energies(&mut self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<Energies, (usize, Overlap)> {
        let mut unbent = std::mem::take(&mut self.scratch);
        self.subtract_bow(elapsed, q, &mut unbent);
        let shafts = self.model.shaft_form(&unbent) / 2.0;
        self.scratch = unbent;
        let meshes = self.mesh_energy(elapsed, q, v)?;
        Ok(Energies {
            kinetic: self.model.kinetic_form(v) / 2.0,
            shafts,
            bearings: self.model.support_form(q) / 2.0 + self.bearing_energy(elapsed, q) + self.rest_energy(elapsed, q),
            meshes,
        })
    }

    /// Elastic energy that the misalignment of couplings adds to that of their displacements, J.
    fn rest_energy(&self, elapsed: f64, q: &[f64]) -> f64 {
        let energy =
            |link: &Link| link.rest.as_ref().map_or(0.0, |rest| link.rest_energy(self.phasor(rest.shaft, elapsed), q));
        self.model.links.iter().map(energy).sum()
    }

    /// Elastic energy of all connections except meshes, J.
    fn bearing_energy(&self, elapsed: f64, q: &[f64]) -> f64 {
        let energy = |connection: Connection<'_>| match connection {
            Connection::Mesh(..) | Connection::Load(_) => 0.0,
            Connection::Bearing(bearing) => bearing.energy(self.reference_speed(elapsed).0, q),
            Connection::Nonlinear(bearing) => bearing.energy(&self.phase(bearing.turning, elapsed), q),
            Connection::Spring(spring) => spring.energy(q),
        };
        self.connections().map(energy).sum()
    }

    /// Elastic energy of the meshes, J.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn mesh_energy(&self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<f64, (usize, Overlap)> {
        let mut sum = 0.0;
        for (index, mesh) in self.model.meshes.iter().enumerate() {
            let contact =
                mesh.contact(&self.pose(index, &self.phases(index, elapsed), q, v), &self.contact_modes[index]);
            sum += contact.map_err(|overlap| (index, overlap))?.energy;
        }
        Ok(sum)
    }

    /// Writes q minus the stress-free shape of every bowed shaft into `unbent`.
    fn subtract_bow(&self, elapsed: f64, q: &[f64], unbent: &mut [f64]) {
        unbent.copy_from_slice(q);
        for (index, shaft) in self.model.shafts.iter().enumerate() {
            if let (Some(bow), Some(chain)) = (&shaft.bow, &shaft.bending) {
                let phasor = self.phasor(index, elapsed);
                for (value, pair) in bow.iter().zip(unbent[chain.start..].chunks_exact_mut(2)) {
                    let free = value * phasor;
                    pair[0] -= free.re;
                    pair[1] -= free.im;
                }
            }
        }
    }

    /// Force of the shaft on the bearings of a node, components (y, z), N.
    pub fn bearing_force(&self, node: Node, elapsed: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
        let speed = self.reference_speed(elapsed).0;
        let over_speed = self.model.bearings_at(node).map(|bearing| bearing.force(speed, q, v));
        // The integrator reports a journal that touches its bearing.
        let nonlinear = self
            .model
            .nonlinear_bearings_at(node)
            .map(|bearing| bearing.force(&self.phase(bearing.turning, elapsed), q, v).unwrap_or([f64::NAN; 2]));
        let constant = self.model.bearing_force(node, q, v);
        over_speed.chain(nonlinear).fold(constant, |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }

    /// Number of loaded rolling elements of the bearings at a node, and their largest contact force, N.
    pub fn rolling_contact(&self, node: Node, elapsed: f64, q: &[f64]) -> [f64; 2] {
        let mut contact = [0.0, 0.0_f64];
        for bearing in self.model.nonlinear_bearings_at(node) {
            let angle = self.phase(bearing.turning, elapsed).angle;
            let elements = bearing.rolling().into_iter();
            for force in elements.flat_map(|elements| elements.contact_forces(bearing.scalars(q), angle)) {
                contact = [contact[0] + f64::from(force > 0.0), contact[1].max(force)];
            }
        }
        contact
    }

    /// The quantities of a mesh that a response reports.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn mesh_state(&self, mesh: usize, elapsed: f64, q: &[f64], v: &[f64]) -> Result<MeshState, Overlap> {
        let phases = self.phases(mesh, elapsed);
        self.model.meshes[mesh].state(&self.pose(mesh, &phases, q, v), &self.contact_modes[mesh])
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.model
    }
}
