//! Powers that change the energy of the motion.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::EquationOfMotion;
use crate::connection::Connection;
use crate::linalg::product;
use crate::mesh::Overlap;
use crate::model::{Excitation, Model, Support, bow_force, is_bowed};

/// A quantity of each source that changes the energy: its power, W, or its work, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SourceTerms {
    /// Of torques and forces.
    pub torque: f64,
    /// Of weights.
    pub gravity: f64,
    /// Of the drive, which turns bowed shafts, eccentric hubs and the frames of carriers, moves rolling elements and changes the
    /// stiffness of bearings.
    pub drive: f64,
    /// Of unbalance.
    pub unbalance: f64,
    /// Of the prescribed motion of the teeth.
    pub teeth: f64,
    /// Of damping and cross-coupling; negative where they take energy.
    pub damping: f64,
}

impl SourceTerms {
    /// Names of the terms in the order of [`Self::values`].
    pub const NAMES: [&str; 6] = ["torque", "gravity", "drive", "unbalance", "teeth", "damping"];

    /// All terms.
    pub fn values(&self) -> [f64; 6] {
        [self.torque, self.gravity, self.drive, self.unbalance, self.teeth, self.damping]
    }

    /// The terms from values in the order of [`Self::values`].
    pub fn from_values([torque, gravity, drive, unbalance, teeth, damping]: [f64; 6]) -> Self {
        Self { torque, gravity, drive, unbalance, teeth, damping }
    }

    /// The terms plus `factor` times other ones.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let (own, other) = (self.values(), other.values());
        Self::from_values(std::array::from_fn(|i| own[i] + factor * other[i]))
    }

    /// Sum of the magnitudes.
    pub fn magnitude(&self) -> f64 {
        self.values().iter().map(|value| value.abs()).sum()
    }
}

/// The coordinates from which powers follow.
#[derive(Clone, Debug)]
pub struct PowerCoordinates {
    /// Indices of the displacements, ascending.
    pub displacements: Vec<usize>,
    /// Indices of the velocities, ascending.
    pub velocities: Vec<usize>,
    /// Sums of displacements as entries (index, coefficient): for each bowed shaft, real and imaginary part of (K_s b)ᴴu, N m;
    /// the twist of each bow that turns with it, rad; then the [`PowerLoads::constant`] loads times the displacements, J.
    pub combinations: Vec<Vec<(usize, f64)>>,
}

impl PowerCoordinates {
    /// The [`PowerLoads::constant`] loads.
    pub fn constant_loads(&self) -> &[Vec<(usize, f64)>] {
        &self.combinations[self.combinations.len() - CONSTANT_LOAD_SUMS..]
    }

    /// Number of sums behind the displacements: the combinations, and the power of the distributed damping.
    pub fn sums(&self) -> usize {
        self.combinations.len() + 1
    }

    /// The [`PowerLoads::constant`] loads times the displacements, J, from the sums at the end of `q`.
    pub fn potentials(&self, q: &[f64]) -> [f64; CONSTANT_LOAD_SUMS] {
        let end = q.len() - 1;
        std::array::from_fn(|load| q[end - CONSTANT_LOAD_SUMS + load])
    }

    /// The coordinates of a model.
    pub fn new(model: &Model) -> Self {
        let lateral = |index: usize| [index, index + 1];
        let (mut displacements, mut velocities) = (Vec::new(), Vec::new());
        let of_meshes = model.meshes.iter().flat_map(|mesh| mesh.indices());
        displacements.extend(of_meshes);
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
        let frictions = model.meshes.iter().filter_map(|mesh| mesh.friction.as_ref());
        velocities.extend(frictions.flat_map(|friction| friction.rotation.iter().map(|(index, _)| *index)));
        velocities.extend(model.loads.iter().flat_map(|load| load.rows.iter().flatten().map(|(index, _)| *index)));
        let forces = model.scene.forces.iter().filter_map(|force| model.numbering.translation(force.node));
        velocities.extend(forces.flat_map(lateral));
        let excitations = model.shafts.iter().flat_map(|shaft| &shaft.excitations);
        let unbalances = excitations.filter(|excitation| excitation.unbalance != Complex64::ZERO);
        velocities.extend(unbalances.flat_map(|excitation| lateral(excitation.index)));
        let internal = model.shafts.iter().filter(|shaft| shaft.circulatory.is_some());
        for chain in internal.filter_map(|shaft| shaft.bending.as_ref()) {
            displacements.extend(chain.coordinates::<2>());
            velocities.extend(chain.coordinates::<2>());
        }
        if model.scene.has_turning_frame() {
            displacements.extend(0..model.len());
            velocities.extend(0..model.len());
        }
        for list in [&mut displacements, &mut velocities] {
            list.sort_unstable();
            list.dedup();
        }
        let bowed = model.shafts.iter().filter(|shaft| is_bowed(shaft));
        let twists = model.bows.iter().map(|bow| bow.rows[2].clone());
        let combinations = bowed.flat_map(bow_force).chain(twists).chain(PowerLoads::new(model).constant).collect();
        Self { displacements, velocities, combinations }
    }
}

/// Loads whose powers are sums over few coordinates, in the order of their addition.
#[derive(Clone, Debug)]
pub struct PowerLoads {
    /// Constant torques and forces of the scene, and weights, N m and N, with the indices of their coordinates.
    pub constant: [Vec<(usize, f64)>; CONSTANT_LOAD_SUMS],
    /// Excitations with unbalance, and their shafts.
    unbalances: Vec<(usize, Excitation)>,
    /// Bowed shafts.
    bowed: Vec<usize>,
}

impl PowerLoads {
    /// The loads of a model.
    pub fn new(model: &Model) -> Self {
        let entries =
            |load: &DVector<f64>| load.iter().copied().enumerate().filter(|(_, force)| *force != 0.0).collect();
        let shafts = || model.shafts.iter().enumerate();
        let unbalances = shafts().flat_map(|(index, shaft)| {
            let unbalanced = shaft.excitations.iter().filter(|excitation| excitation.unbalance != Complex64::ZERO);
            unbalanced.map(move |excitation| (index, *excitation))
        });
        Self {
            constant: [model.given_load(), model.weight()].map(|load| entries(&load)),
            unbalances: unbalances.collect(),
            bowed: shafts().filter(|(_, shaft)| is_bowed(shaft)).map(|(index, _)| index).collect(),
        }
    }

    /// Constant loads times velocities, W, or times displacements, J. Differences of the latter are works.
    pub fn times(&self, values: &[f64]) -> [f64; CONSTANT_LOAD_SUMS] {
        self.constant.each_ref().map(|forces| forces.iter().map(|(index, force)| force * values[*index]).sum())
    }
}

/// Number of sums over constant loads.
pub const CONSTANT_LOAD_SUMS: usize = 2;

impl EquationOfMotion<'_> {
    /// vᵀDv of the distributed damping D, Rayleigh and modal damping, W.
    pub fn distributed_damping_power(&self, v: &[f64]) -> f64 {
        let mut power = self.model.shaft_damping_form(v);
        if let Some(modal) = &self.modal_damping {
            for (column, rate) in modal.as_slice().chunks_exact(self.model.len()).zip(v) {
                power += rate * product(column, &v[..self.model.len()]);
            }
        }
        power
    }

    /// The matrix D of [`Self::distributed_damping_power`], N s/m, shape (n, n); none without such damping.
    pub fn distributed_damping(&self) -> Option<DMatrix<f64>> {
        let is_damped = self.model.scene.rayleigh != [0.0; 2] || self.model.has_internal_damping();
        let shafts = is_damped.then(|| self.model.shaft_damping_matrix());
        match (shafts, &self.modal_damping) {
            (Some(shafts), Some(modal)) => Some(shafts + modal),
            (shafts, modal) => shafts.or_else(|| modal.clone()),
        }
    }

    /// Power of each source, W; constant loads have a potential instead. The sources are:
    /// - torques and forces that change over time;
    /// - gravity in frames that turn;
    /// - the drive, which turns bowed shafts and eccentric hubs of couplings, moves rolling elements and changes the stiffness of
    ///   bearings with the speed;
    /// - unbalance;
    /// - the prescribed motion of the teeth: error, run-out and stiffness;
    /// - damping, with the cross-coupling of bearings and with the power `distributed` of the distributed damping.
    ///
    /// q and v need the coordinates of [`PowerCoordinates`]; q is followed by its sums.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named.
    pub fn powers(
        &self,
        loads: &PowerLoads,
        elapsed: f64,
        q: &[f64],
        v: &[f64],
        distributed: f64,
    ) -> Result<SourceTerms, (usize, Overlap)> {
        let model = self.model;
        let [mut drive, circulating] = self.link_powers(elapsed, q, v);
        let (along, twists) = q[model.len()..].split_at(2 * loads.bowed.len());
        // Either all bows turn with the twist of their shafts, or none does.
        let twists = twists.iter().take(model.bows.len()).chain(std::iter::repeat(&0.0));
        for ((shaft, bow), twist) in loads.bowed.iter().zip(along.chunks_exact(2)).zip(twists) {
            // The elastic force of the unbent shape does no work on the bow, which turns with the spin and the twist.
            let phasor = self.phasor(*shaft, elapsed) * Complex64::from_polar(1.0, *twist);
            drive -= self.spin_in_frame(*shaft, elapsed) * (bow[1] * phasor.re - bow[0] * phasor.im);
        }
        let [turned, mut damping] = self.internal_damping_powers(elapsed, q, v);
        drive += turned;
        if let Some(frame) = &self.frame_forces {
            drive += frame.power(&q[..model.len()], v);
        }
        let mut unbalance = 0.0;
        for (shaft, excitation) in &loads.unbalances {
            let (spin, rate) = self.spin_at(*shaft, elapsed);
            let force = excitation.unbalance_amplitude(spin, rate) * self.phasor(*shaft, elapsed);
            unbalance += force.re * v[excitation.index] + force.im * v[excitation.index + 1];
        }
        damping += distributed + model.support_damping_form(v);
        for support in &model.supports {
            let (i, k) = (support.index, &support.stiffness);
            let skew = (k[0][1] - k[1][0]) / 2.0;
            damping += skew * (v[i] * q[i + 1] - v[i + 1] * q[i]);
        }
        damping += circulating;
        let turning = model.scene.forces.iter().filter(|force| force.turns);
        let mut torque: f64 =
            turning.map(|f| model.power(f.node, f.value * self.phasor(f.node.shaft, elapsed), v)).sum();
        let mut teeth = 0.0;
        for connection in self.connections() {
            match connection {
                Connection::Mesh(index, mesh, _) => {
                    let pose = self.phases(index, elapsed);
                    let contact = mesh.contact(&self.pose(index, &pose, q, v), &self.contact_modes[index]);
                    let contact = contact.map_err(|overlap| (index, overlap))?;
                    teeth += contact.drive_power;
                    if let Some(friction) = &mesh.friction {
                        let rate: f64 = friction.rotation.iter().map(|(index, share)| share * v[*index]).sum();
                        teeth -= contact.resistance * rate;
                    }
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
                // The power of the drive on all bowed shafts is that above.
                Connection::Bow(_) => {}
                Connection::Load(load) => torque += load.power(&self.instant(None, Some(load.shaft), elapsed), v),
            }
        }
        let weights = self.rotating_loads.iter().filter(|load| load.is_weight);
        let gravity = weights.map(|load| load.power(load.phasor(elapsed, None), v)).sum();
        Ok(SourceTerms { torque, gravity, drive, unbalance, teeth, damping: -damping })
    }

    /// Powers of the internal damping βK of shafts, W: that of the drive, which turns deflected shafts, and that which is dissipated
    /// beyond vᵀβKv. With the velocity u̇ − iΩu relative to the shaft, (u̇ − iΩu)ᴴβK(u̇ − iΩu) is dissipated, of which the motion loses
    /// u̇ᴴβK(u̇ − iΩu), real parts.
    fn internal_damping_powers(&self, elapsed: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
        let [mut drive, mut dissipated] = [0.0; 2];
        for (index, shaft) in self.model.shafts.iter().enumerate() {
            let (Some(chain), Some(circulatory)) = (&shaft.bending, &shaft.circulatory) else { continue };
            let (q, v) = (&q[chain.start..], &v[chain.start..]);
            let [mut along, mut across] = [0.0; 2];
            let mut add = |unknown: usize, [re, im]: [f64; 2]| {
                along += q[2 * unknown] * re + q[2 * unknown + 1] * im;
                across += v[2 * unknown + 1] * re - v[2 * unknown] * im;
            };
            for node in 0..chain.nodes {
                // Force and moment βKq at the node.
                let [force, moment] = circulatory.nodal.row::<2>(node, q);
                add(2 * node, force);
                add(2 * node + 1, moment);
            }
            circulatory.internal_product::<2>(q, add);
            let spin = self.spin_at(index, elapsed).0;
            drive += spin * (spin * along - across);
            dissipated += spin * (spin * along - 2.0 * across);
        }
        [drive, dissipated]
    }

    /// Powers of links, W: that which turns the eccentric hubs of couplings, and that which the cross-coupling takes.
    fn link_powers(&self, elapsed: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
        let mut powers = [0.0; 2];
        for link in &self.model.links {
            if let Some(rest) = &link.rest {
                let spin = self.spin_in_frame(rest.shaft, elapsed);
                powers[0] += link.rest_power(self.phasor(rest.shaft, elapsed), spin, q);
            }
            let ([[_, a], [b, _]], [y, z], [y_rate, z_rate]) = (link.local.stiffness, link.scalars(q), link.scalars(v));
            powers[1] += (a - b) / 2.0 * (y_rate * z - z_rate * y);
        }
        powers
    }
}
