//! The equation of motion as a first-order system: the forces on all coordinates, the accelerations and the contact modes.
//!
//! The stiffness, damping and mass of a chain act node by node, in a time proportional to its number of nodes. Terms that a
//! scene does not have (spin, damping, bow) are skipped.

use super::equation::EquationOfMotion;
use crate::connection::Connection;
use crate::integrate::{FirstOrderSystem, Halt};
use crate::mesh::ContactMode;
use crate::model::ShaftModel;

impl EquationOfMotion<'_> {
    /// Writes the external forces and the forces of all connections into `force`.
    #[inline(always)]
    fn loads(&self, elapsed: f64, q: &[f64], v: &[f64], force: &mut [f64]) -> Result<(), Halt> {
        force.copy_from_slice(self.constant_load.as_slice());
        let reference = self.reference_shaft(elapsed);
        for load in &self.rotating_loads {
            load.apply(load.phasor(elapsed, reference.as_ref()), force);
        }
        for support in &self.model.supports {
            for (row, value) in support.force(q, v).into_iter().enumerate() {
                force[support.index + row] -= value;
            }
        }
        for link in &self.model.links {
            link.subtract(link.force(q, v), force);
        }
        self.connections().try_for_each(|connection| {
            match connection {
                Connection::Mesh(index, mesh, _) => {
                    let contact = mesh
                        .contact(&self.pose(index, &self.phases(index, elapsed), q, v), &self.contact_modes[index])
                        .map_err(|overlap| Halt::Overlap { mesh: index, overlap })?;
                    mesh.apply(&contact, force);
                }
                Connection::Bearing(bearing) => {
                    let values = bearing.force(self.reference_speed(elapsed).0, q, v);
                    for (row, value) in bearing.rows.iter().zip(values) {
                        row.iter().for_each(|(index, coefficient)| force[*index] -= coefficient * value);
                    }
                }
                Connection::Nonlinear(bearing) => {
                    bearing.apply(&self.phase(bearing.turning, elapsed), q, v, force).map_err(Halt::Touch)?;
                }
                Connection::Load(load) => load.apply(&self.instant(None, Some(load.shaft), elapsed), v, force),
                Connection::Bow(bow) => bow.apply(self.phase(bow.turning, elapsed).angle, q, force),
            }
            Ok(())
        })?;
        if let Some(frame) = &self.frame_forces {
            frame.stiffness.multiply_add(-1.0, q, force);
            frame.rate.multiply_add(-1.0, v, force);
        }
        if let Some(damping) = &self.modal_damping {
            // Columns as slices, because iterators over matrix views do not vectorise.
            for (column, rate) in damping.as_slice().chunks_exact(force.len()).zip(v) {
                for (force, entry) in force.iter_mut().zip(column) {
                    *force -= entry * rate;
                }
            }
        }
        Ok(())
    }
}

/// `force −= K q + (C − iΩG) v`, then `force ← M⁻¹ force`, for one shaft.
#[inline(always)]
fn accelerate(shaft: &ShaftModel, spin: f64, q: &[f64], v: &[f64], force: &mut [f64]) {
    if let Some(chain) = &shaft.bending {
        let range = chain.coordinates::<2>();
        let (q, v, force) = (&q[range.clone()], &v[range.clone()], &mut force[range]);
        chain.subtract_elastic::<2>(q, force);
        if spin != 0.0 {
            for (node, force) in force.chunks_exact_mut(4).take(chain.nodes).enumerate() {
                let [[u_re, u_im], [phi_re, phi_im]] = shaft.gyroscopic.nodal.row::<2>(node, v);
                force[0] -= spin * u_im;
                force[1] += spin * u_re;
                force[2] -= spin * phi_im;
                force[3] += spin * phi_re;
            }
            shaft.gyroscopic.internal_product::<2>(v, |unknown, [re, im]| {
                force[2 * unknown] -= spin * im;
                force[2 * unknown + 1] += spin * re;
            });
            if let Some(circulatory) = &shaft.circulatory {
                for (node, force) in force.chunks_exact_mut(4).take(chain.nodes).enumerate() {
                    let [[u_re, u_im], [phi_re, phi_im]] = circulatory.nodal.row::<2>(node, q);
                    force[0] -= spin * u_im;
                    force[1] += spin * u_re;
                    force[2] -= spin * phi_im;
                    force[3] += spin * phi_re;
                }
                circulatory.internal_product::<2>(q, |unknown, [re, im]| {
                    force[2 * unknown] -= spin * im;
                    force[2 * unknown + 1] += spin * re;
                });
            }
        }
        if let Some(damping) = &chain.damping {
            damping.multiply_add::<2>(-1.0, v, force);
        }
        chain.mass_factor.solve::<2>(force);
    }
    for chain in shaft.rods() {
        let range = chain.coordinates::<1>();
        let (q, v, force) = (&q[range.clone()], &v[range.clone()], &mut force[range]);
        chain.subtract_elastic::<1>(q, force);
        if let Some(damping) = &chain.damping {
            damping.multiply_add::<1>(-1.0, v, force);
        }
        chain.mass_factor.solve::<1>(force);
    }
}

impl FirstOrderSystem for EquationOfMotion<'_> {
    fn len(&self) -> usize {
        2 * self.model.len()
    }

    fn derivative(&mut self, elapsed: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        let n = self.model.len();
        let (q, v) = y.split_at(n);
        let (rate, acceleration) = derivative.split_at_mut(n);
        rate.copy_from_slice(v);
        self.loads(elapsed, q, v, acceleration)?;
        let speed = self.variable_speed.as_ref().map(|variable_speed| variable_speed.at(elapsed).speed);
        for (shaft, spin) in self.model.shafts.iter().zip(&self.spins) {
            let spin = speed.map_or(*spin, |speed| shaft.ratio * speed);
            accelerate(shaft, spin, q, v, acceleration);
        }
        self.model.housings.solve_mass(acceleration);
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        (self.variable_speed.is_some() || !self.switching.is_empty()).then_some(&self.switching)
    }

    fn contact_modes_at(&mut self, elapsed: f64, y: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        let (q, v) = y.split_at(self.model.len());
        contact_modes.clear();
        for (index, mesh) in self.model.meshes.iter().enumerate() {
            let contact_mode = if mesh.switches() {
                mesh.contact_mode(&self.pose(index, &self.phases(index, elapsed), q, v))
                    .map_err(|overlap| Halt::Overlap { mesh: index, overlap })?
            } else {
                ContactMode::ALWAYS
            };
            contact_modes.extend(contact_mode.code());
        }
        contact_modes.extend(self.variable_speed.as_ref().map(|variable_speed| variable_speed.piece_at(elapsed)));
        Ok(())
    }

    fn set_contact_modes(&mut self, contact_modes: &[i64]) {
        for (contact_mode, code) in
            self.contact_modes.iter_mut().zip(contact_modes.chunks_exact(ContactMode::CODE_LENGTH))
        {
            *contact_mode = ContactMode::from_code(code);
        }
        if let (Some(variable_speed), Some(piece)) = (&mut self.variable_speed, contact_modes.last()) {
            variable_speed.set_piece(*piece);
        }
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        let (q, v) = difference.split_at(self.model.len());
        (self.elastic_form(q) + self.model.kinetic_form(v)).max(0.0).sqrt()
    }

    fn size(&mut self, y: &[f64]) -> f64 {
        let (q, v) = y.split_at(self.model.len());
        let mut deviation = std::mem::take(&mut self.scratch);
        for ((deviation, q), equilibrium) in deviation.iter_mut().zip(q).zip(&self.equilibrium) {
            *deviation = q - equilibrium;
        }
        let square = self.elastic_form(&deviation) + self.model.kinetic_form(v);
        self.scratch = deviation;
        square.max(0.0).sqrt().max(self.constants.smallest_size)
    }
}
