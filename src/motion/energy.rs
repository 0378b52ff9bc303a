//! Energies of the motion, and forces that a response reports.

use num_complex::Complex64;

use super::EquationOfMotion;
use crate::connection::{Connection, Row};
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

/// Indices of the displacements from which the energies of bearings, couplings and meshes follow, ascending.
pub fn connected_coordinates(model: &Model) -> Vec<usize> {
    let of_rows = |rows: &mut dyn Iterator<Item = &Row>| rows.flatten().map(|(index, _)| *index).collect::<Vec<_>>();
    let mut coordinates = of_rows(&mut model.links.iter().flat_map(|link| &link.rows));
    coordinates.extend(of_rows(&mut model.bearings.iter().flat_map(|bearing| &bearing.rows)));
    coordinates.extend(of_rows(&mut model.nonlinear_bearings.iter().flat_map(|bearing| &bearing.rows)));
    coordinates.extend(model.supports.iter().flat_map(|support| [support.index, support.index + 1]));
    coordinates.extend(model.meshes.iter().flat_map(|mesh| mesh.indices()));
    coordinates.sort_unstable();
    coordinates.dedup();
    coordinates
}

impl<'m> EquationOfMotion<'m> {
    /// Energies of shafts, bearings and meshes, J, from the displacements and velocities of all coordinates.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn energies(&mut self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<Energies, (usize, Overlap)> {
        let mut unbent = std::mem::take(&mut self.scratch);
        let [kinetic, shafts] = self.shaft_energies(elapsed, q, v, &mut unbent);
        self.scratch = unbent;
        let [bearings, meshes] = self.connection_energies(elapsed, q, v)?;
        Ok(Energies { kinetic, shafts, bearings, meshes })
    }

    /// Kinetic energy and elastic energy of the shafts, J, from all displacements and velocities. `unbent` is scratch for the
    /// displacements.
    pub fn shaft_energies(&self, elapsed: f64, q: &[f64], v: &[f64], unbent: &mut [f64]) -> [f64; 2] {
        self.subtract_bow(elapsed, q, unbent);
        let mut elastic = self.model.shaft_form(unbent);
        // An axial force acts along the line of the bearings: its energy is that of the complete slope.
        for shaft in self.model.shafts.iter().filter(|shaft| shaft.bow.is_some()) {
            if let (Some(geometric), Some(chain)) = (&shaft.geometric, &shaft.bending) {
                elastic += geometric.quadratic_form::<2>(&q[chain.start..]);
                elastic -= geometric.quadratic_form::<2>(&unbent[chain.start..]);
            }
        }
        [self.model.kinetic_form(v) / 2.0, elastic / 2.0]
    }

    /// Elastic energy of the bearings and of all other connections except meshes, and that of the meshes, J, from the
    /// [`connected_coordinates`] and the velocities of the meshes.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn connection_energies(&self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<[f64; 2], (usize, Overlap)> {
        let meshes = self.mesh_energy(elapsed, q, v)?;
        let links = self.other_connection_energy(elapsed, q) + self.rest_energy(elapsed, q);
        Ok([self.model.support_form(q) / 2.0 + links, meshes])
    }

    /// Elastic energy that the misalignment of couplings adds to that of their displacements, J.
    fn rest_energy(&self, elapsed: f64, q: &[f64]) -> f64 {
        let energy =
            |link: &Link| link.rest.as_ref().map_or(0.0, |rest| link.rest_energy(self.phasor(rest.shaft, elapsed), q));
        self.model.links.iter().map(energy).sum()
    }

    /// Elastic energy of all connections except meshes, J.
    fn other_connection_energy(&self, elapsed: f64, q: &[f64]) -> f64 {
        let energy = |connection: Connection<'_>| match connection {
            // The energy of the shafts contains that of their bows.
            Connection::Mesh(..) | Connection::Load(_) | Connection::Bow(_) => 0.0,
            Connection::Bearing(bearing) => bearing.energy(self.reference_speed(elapsed).0, q),
            Connection::Nonlinear(bearing) => bearing.energy(&self.phase(bearing.turning, elapsed), q),
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
        let mut turning = self.model.bows.iter().peekable();
        for (index, shaft) in self.model.shafts.iter().enumerate() {
            if let (Some(bow), Some(chain)) = (&shaft.bow, &shaft.bending) {
                let twist = turning.next_if(|bow| bow.shaft == index).map_or(0.0, |bow| bow.twist(q));
                let phasor = self.phasor(index, elapsed) * Complex64::from_polar(1.0, twist);
                for (value, pair) in bow.iter().zip(unbent[chain.start..].chunks_exact_mut(2)) {
                    let free = value * phasor;
                    pair[0] -= free.re;
                    pair[1] -= free.im;
                }
            }
        }
    }

    /// Force of the shaft on the bearings of a node along (y, z) and the axis, N.
    pub fn bearing_force(&self, node: Node, elapsed: f64, q: &[f64], v: &[f64]) -> [f64; 3] {
        let speed = self.reference_speed(elapsed).0;
        let over_speed = self.model.bearings_at(node).map(|bearing| {
            let [y, z] = bearing.force(speed, q, v);
            [y, z, 0.0]
        });
        // The integrator reports a journal that touches its bearing.
        let nonlinear = self
            .model
            .nonlinear_bearings_at(node)
            .map(|bearing| bearing.force(&self.phase(bearing.turning, elapsed), q, v).unwrap_or([f64::NAN; 3]));
        let constant = self.model.bearing_force(node, q, v);
        over_speed.chain(nonlinear).fold(constant, |sum, own| [0, 1, 2].map(|axis| sum[axis] + own[axis]))
    }

    /// Number of loaded rolling elements of the bearings at a node, and their largest contact force, N.
    pub fn rolling_contact(&self, node: Node, elapsed: f64, q: &[f64]) -> [f64; 2] {
        self.model.nonlinear_bearings_at(node).fold([0.0, 0.0_f64], |[count, largest], bearing| {
            let [own, force] = bearing.loaded_elements(q, self.phase(bearing.turning, elapsed).angle);
            [count + own, largest.max(force)]
        })
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
