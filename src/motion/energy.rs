//! Energies of the motion, and the powers that change them.

use super::EquationOfMotion;
use crate::connection::Connection;
use crate::mesh::{MeshState, Overlap};
use crate::model::{Link, Model};

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

/// Names of the powers that change the energy, in the order of [`EquationOfMotion::powers`].
pub const SOURCES: [&str; 6] = ["torque", "gravity", "drive", "unbalance", "teeth", "damping"];

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

    /// Power of the [`SOURCES`], W: torques and forces; gravity; the drive, which turns bowed shafts and eccentric hubs of
    /// couplings and changes the stiffness of bearings with the speed; unbalance; the prescribed motion of the teeth (error, run-out, stiffness); damping, with
    /// the cross-coupling of bearings.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn powers(&mut self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<[f64; 6], (usize, Overlap)> {
        let model = self.model;
        let [mut torque, constant] = model.constant_powers(v);
        let [loaded, mut drive, circulating] = self.link_powers(elapsed, q, v);
        let weight = constant - torque - loaded;
        let mut unbalance = 0.0;
        let mut unbent = std::mem::take(&mut self.scratch);
        self.subtract_bow(elapsed, q, &mut unbent);
        for (index, shaft) in model.shafts.iter().enumerate() {
            let ((spin, rate), phasor) = (self.spin_at(index, elapsed), self.phasor(index, elapsed));
            if let (Some(bow), Some(chain)) = (&shaft.bow, &shaft.bending) {
                let mut force = vec![0.0; chain.coordinates::<2>().len()];
                chain.subtract_elastic::<2>(&unbent[chain.start..], &mut force);
                for (value, pair) in bow.iter().zip(force.chunks_exact(2)) {
                    let free = value * phasor;
                    drive += spin * (pair[1] * free.re - pair[0] * free.im);
                }
            }
            for excitation in &shaft.excitations {
                let force = excitation.unbalance_amplitude(spin, rate) * phasor;
                unbalance += force.re * v[excitation.index] + force.im * v[excitation.index + 1];
            }
        }
        self.scratch = unbent;
        let mut damping = self.model.damping_form(v);
        for support in &model.supports {
            let (i, k) = (support.index, &support.stiffness);
            let skew = (k[0][1] - k[1][0]) / 2.0;
            damping += skew * (v[i] * q[i + 1] - v[i + 1] * q[i]);
        }
        damping += circulating;
        let turning = model.scene.forces.iter().filter(|force| force.turns);
        torque += turning.map(|f| model.power(f.node, f.value * self.phasor(f.node.shaft, elapsed), v)).sum::<f64>();
        if let Some(modal) = &self.modal_damping {
            for (column, rate) in modal.column_iter().zip(v) {
                damping += rate * column.iter().zip(v).map(|(entry, rate)| entry * rate).sum::<f64>();
            }
        }
        let mut teeth = 0.0;
        for connection in self.connections() {
            match connection {
                Connection::Mesh(index, mesh, _) => {
                    let pose = self.phases(index, elapsed);
                    let contact = mesh.contact(&self.pose(index, &pose, q, v), &self.contact_modes[index]);
                    let contact = contact.map_err(|overlap| (index, overlap))?;
                    teeth += contact.drive_power;
                    damping += contact.damping_power;
                }
                Connection::Bearing(bearing) => {
                    let (speed, acceleration) = self.reference_speed(elapsed);
                    let [stiffening, damped] = bearing.powers(speed, acceleration, q, v);
                    drive += stiffening;
                    damping += damped;
                }
                Connection::Spring(spring) => damping += spring.damping_power(v),
                Connection::Load(load) => torque += load.power(&self.instant(None, Some(load.shaft), elapsed), v),
            }
        }
        Ok([torque, weight, drive, unbalance, teeth, -damping])
    }

    /// Powers of links, W: that of the constant forces of misaligned couplings, that which turns their eccentric hubs, and
    /// that which the cross-coupling takes.
    fn link_powers(&self, elapsed: f64, q: &[f64], v: &[f64]) -> [f64; 3] {
        let mut powers = [0.0; 3];
        for link in &self.model.links {
            if let Some(rest) = &link.rest {
                let spin = self.spin_at(rest.shaft, elapsed).0;
                let [loaded, turned] = link.rest_powers(self.phasor(rest.shaft, elapsed), spin, q, v);
                (powers[0], powers[1]) = (powers[0] + loaded, powers[1] + turned);
            }
            let ([[_, a], [b, _]], [y, z], [y_rate, z_rate]) = (link.local.stiffness, link.scalars(q), link.scalars(v));
            powers[2] += (a - b) / 2.0 * (y_rate * z - z_rate * y);
        }
        powers
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
