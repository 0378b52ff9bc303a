//! Powers that change the energy of the motion.

use num_complex::Complex64;

use super::EquationOfMotion;
use crate::connection::Connection;
use crate::mesh::Overlap;
use crate::model::{Excitation, Model, ShaftModel, Support};

/// Names of the powers that change the energy, in the order of [`EquationOfMotion::powers`].
pub const SOURCES: [&str; 6] = ["torque", "gravity", "drive", "unbalance", "teeth", "damping"];

/// The coordinates from which powers follow.
#[derive(Clone, Debug)]
pub struct PowerCoordinates {
    /// Indices of the displacements, ascending.
    pub displacements: Vec<usize>,
    /// Indices of the velocities, ascending.
    pub velocities: Vec<usize>,
    /// Sums of displacements as entries (index, coefficient): for each bowed shaft, real and imaginary part of (K_s b)ᴴu, N m.
    pub combinations: Vec<Vec<(usize, f64)>>,
}

impl PowerCoordinates {
    /// The coordinates of a model.
    pub fn new(model: &Model) -> Self {
        let lateral = |index: usize| [index, index + 1];
        let (mut displacements, mut velocities) = (Vec::new(), Vec::new());
        let of_meshes = model.meshes.iter().flat_map(|mesh| mesh.indices());
        let of_springs = model.springs.iter().flat_map(|spring| spring.rows.iter().flatten().map(|(index, _)| *index));
        displacements.extend(of_meshes.chain(of_springs));
        displacements.extend(model.bearings.iter().flat_map(|bearing| bearing.rows.iter().flatten().map(|(i, _)| *i)));
        let nonlinear = model.nonlinear_bearings.iter().flat_map(|bearing| bearing.rows.iter().flatten());
        displacements.extend(nonlinear.map(|(index, _)| *index));
        velocities.extend(&displacements);
        let is_crossed = |support: &Support| support.stiffness[0][1] != support.stiffness[1][0];
        let crossed = model.supports.iter().filter(|support| is_crossed(support));
        displacements.extend(crossed.flat_map(|support| lateral(support.index)));
        velocities.extend(model.supports.iter().flat_map(|support| lateral(support.index)));
        for link in &model.links {
            let of_link = || link.rows.iter().flatten().map(|(index, _)| *index);
            displacements.extend(of_link().filter(|_| link.rest.is_some() || is_crossed(&link.local)));
            velocities.extend(of_link());
        }
        velocities.extend((0..model.len()).filter(|index| model.constant_load[*index] != 0.0));
        velocities.extend(model.loads.iter().flat_map(|load| load.rows.iter().flatten().map(|(index, _)| *index)));
        let forces = model.scene.forces.iter().filter_map(|force| model.numbering.translation(force.node));
        velocities.extend(forces.flat_map(lateral));
        let excitations = model.shafts.iter().flat_map(|shaft| &shaft.excitations);
        let unbalances = excitations.filter(|excitation| excitation.unbalance != Complex64::ZERO);
        velocities.extend(unbalances.flat_map(|excitation| lateral(excitation.index)));
        if model.scene.modal_damping > 0.0 || model.scene.rayleigh != [0.0; 2] {
            velocities = (0..model.len()).collect();
        }
        for list in [&mut displacements, &mut velocities] {
            list.sort_unstable();
            list.dedup();
        }
        let combinations = model.shafts.iter().filter(|shaft| is_bowed(shaft)).flat_map(bow_force).collect();
        Self { displacements, velocities, combinations }
    }
}

/// Whether the bow of a shaft exerts a force.
fn is_bowed(shaft: &ShaftModel) -> bool {
    shaft.excitations.iter().any(|excitation| excitation.bow != Complex64::ZERO)
}

/// Real and imaginary part of (K_s b)ᴴu as entries over the displacements, with the bow b and u = v + iw.
fn bow_force(shaft: &ShaftModel) -> [Vec<(usize, f64)>; 2] {
    let (mut real, mut imaginary) = (Vec::new(), Vec::new());
    for Excitation { index, bow, .. } in &shaft.excitations {
        real.extend([(*index, bow.re), (*index + 1, bow.im)]);
        imaginary.extend([(*index, -bow.im), (*index + 1, bow.re)]);
    }
    [real, imaginary]
}

impl EquationOfMotion<'_> {
    /// Power of the [`SOURCES`], W: torques and forces; gravity; the drive, which turns bowed shafts and eccentric hubs of
    /// couplings, moves rolling elements and changes the stiffness of bearings with the speed; unbalance; the prescribed motion of the teeth (error,
    /// run-out, stiffness); damping, with the cross-coupling of bearings. q and v need the coordinates of `coordinates`; q is followed by the values of its
    /// combinations.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn powers(&self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<[f64; 6], (usize, Overlap)> {
        let model = self.model;
        let [mut torque, constant] = model.constant_powers(v);
        let [loaded, mut drive, circulating] = self.link_powers(elapsed, q, v);
        let weight = constant - torque - loaded;
        let mut unbalance = 0.0;
        let mut bows = q[model.len()..].chunks_exact(2);
        for (index, shaft) in model.shafts.iter().enumerate() {
            let ((spin, rate), phasor) = (self.spin_at(index, elapsed), self.phasor(index, elapsed));
            if let Some(bow) = is_bowed(shaft).then(|| bows.next()).flatten() {
                // The elastic force of the unbent shape does no work on the bow, which turns with the spin.
                drive -= spin * (bow[1] * phasor.re - bow[0] * phasor.im);
            }
            for excitation in &shaft.excitations {
                let force = excitation.unbalance_amplitude(spin, rate) * phasor;
                unbalance += force.re * v[excitation.index] + force.im * v[excitation.index + 1];
            }
        }
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
                Connection::Nonlinear(bearing) => {
                    let [turned, damped] = bearing.powers(&self.phase(bearing.turning, elapsed), q, v);
                    drive += turned;
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
}
