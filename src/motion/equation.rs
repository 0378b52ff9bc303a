//! M q̈ = f(t) − K q − (C + ΩG) q̇ − Σ_mesh F ∂δ/∂q, node by node.
//!
//! The two bending planes of a shaft are the lanes of one complex chain, its twist is a chain of its own; every chain
//! is multiplied and solved in time proportional to its nodes. What a scene leaves out (spin, damping, bow) is skipped.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::phase;
use crate::integrate::{Halt, System};
use crate::mesh::{Coupling, Geometry, Law, Turning};
use crate::modal::Basis;
use crate::model::{Model, ShaftModel};

/// A force on a coordinate pair that turns with its shaft.
#[derive(Clone, Copy, Debug)]
struct TurningForce {
    index: usize,
    amplitude: Complex64,
}

/// What turns with one shaft.
#[derive(Clone, Debug)]
struct Excited {
    spin: f64,
    at_origin: Complex64,
    forces: Vec<TurningForce>,
}

/// The equation of motion of a model at one speed.
#[derive(Clone, Debug)]
pub struct Motion<'m> {
    pub(super) model: &'m Model,
    pub(super) geometry: Geometry,
    pub(super) sigma: Vec<f64>,
    /// Signed spin of each shaft, rad/s.
    pub(super) spins: Vec<f64>,
    /// e^{iϑ} of each shaft at the origin of the elapsed time.
    pub(super) at_origin: Vec<Complex64>,
    /// arg of that.
    angles: Vec<f64>,
    /// The law of each mesh over the step.
    pub(super) laws: Vec<Law>,
    /// The coordinates of the meshes that change their law.
    switching: Vec<usize>,
    excited: Vec<Excited>,
    pub(super) modal_damping: Option<DMatrix<f64>>,
    equilibrium: DVector<f64>,
    /// Room for one vector of displacements.
    pub(super) scratch: Vec<f64>,
}

impl<'m> Motion<'m> {
    /// The motion at `speed` of the reference shaft, from the time `origin`; tolerances are relative to the deviation
    /// from `equilibrium`.
    pub fn new(
        basis: &'m Basis,
        geometry: Geometry,
        speed: f64,
        origin: f64,
        equilibrium: DVector<f64>,
    ) -> Result<Self, crate::linalg::DecompositionError> {
        let model = &basis.model;
        let spins: Vec<f64> = model.shafts.iter().map(|shaft| shaft.ratio * speed).collect();
        let at_origin: Vec<_> = spins.iter().map(|spin| phase(*spin, origin)).collect();
        let excited = |((shaft, spin), at_origin): ((&ShaftModel, &f64), &Complex64)| Excited {
            spin: *spin,
            at_origin: *at_origin,
            forces: shaft
                .excitations
                .iter()
                .map(|excitation| TurningForce { index: excitation.index, amplitude: excitation.amplitude(*spin) })
                .collect(),
        };
        let excited: Vec<_> = model
            .shafts
            .iter()
            .zip(&spins)
            .zip(&at_origin)
            .map(excited)
            .filter(|excited| !excited.forces.is_empty())
            .collect();
        let modal_damping = basis.modal_damping_matrix(speed)?;
        let angles: Vec<f64> = at_origin.iter().map(|turn| turn.arg()).collect();
        Ok(Self {
            model,
            geometry,
            sigma: (0..model.meshes.len()).map(|mesh| model.sigma(mesh, speed)).collect(),
            spins,
            angles,
            at_origin,
            laws: vec![Law::ALWAYS; model.meshes.len()],
            switching: model.meshes.iter().filter(|mesh| mesh.switches()).flat_map(Coupling::indices).collect(),
            excited,
            modal_damping,
            equilibrium,
            scratch: vec![0.0; model.len()],
        })
    }

    /// qᵀKq, each mesh linearised at rest.
    fn elastic_form(&self, q: &[f64]) -> f64 {
        self.model.elastic_form(q, |mesh| self.sigma[mesh])
    }

    /// e^{iϑ} of a shaft.
    pub fn turn(&self, shaft: usize, elapsed: f64) -> Complex64 {
        self.at_origin[shaft] * Complex64::from_polar(1.0, self.spins[shaft] * elapsed)
    }

    /// How the shafts of a mesh stand.
    #[inline(always)]
    pub fn turning(&self, mesh: usize, elapsed: f64) -> [Turning; 2] {
        self.model.meshes[mesh].shafts.map(|shaft| {
            let spin = self.spins[shaft];
            Turning { angle: self.angles[shaft] + spin * elapsed, spin }
        })
    }

    /// The external forces and the mesh forces, into `force`.
    #[inline(always)]
    fn loads(&self, elapsed: f64, q: &[f64], v: &[f64], force: &mut [f64]) -> Result<(), Halt> {
        force.copy_from_slice(self.model.constant_load.as_slice());
        for excited in &self.excited {
            let turn = excited.at_origin * Complex64::from_polar(1.0, excited.spin * elapsed);
            for TurningForce { index, amplitude } in &excited.forces {
                force[*index] += amplitude.re * turn.re - amplitude.im * turn.im;
                force[*index + 1] += amplitude.re * turn.im + amplitude.im * turn.re;
            }
        }
        for support in &self.model.supports {
            let (i, k, c) = (support.index, &support.stiffness, &support.damping);
            for row in 0..2 {
                force[i + row] -= k[row][0] * q[i] + k[row][1] * q[i + 1] + c[row][0] * v[i] + c[row][1] * v[i + 1];
            }
        }
        for (index, (mesh, sigma)) in self.model.meshes.iter().zip(&self.sigma).enumerate() {
            let contact = mesh
                .contact(self.geometry, *sigma, &self.laws[index], &self.turning(index, elapsed), q, v)
                .map_err(|overlap| Halt::Overlap { mesh: index, overlap })?;
            mesh.apply(&contact, force);
        }
        if let Some(damping) = &self.modal_damping {
            for (column, rate) in damping.column_iter().zip(v) {
                for (force, entry) in force.iter_mut().zip(column.iter()) {
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
        let range = chain.start..chain.start + 4 * chain.nodes;
        let (q, v, force) = (&q[range.clone()], &v[range.clone()], &mut force[range]);
        chain.subtract_elastic::<2>(q, force);
        if spin != 0.0 {
            for (node, force) in force.chunks_exact_mut(4).enumerate() {
                let [[u_re, u_im], [phi_re, phi_im]] = shaft.gyroscopic.row::<2>(node, v);
                force[0] -= spin * u_im;
                force[1] += spin * u_re;
                force[2] -= spin * phi_im;
                force[3] += spin * phi_re;
            }
        }
        if let Some(damping) = &chain.damping {
            damping.multiply_add::<2>(-1.0, v, force);
        }
        chain.mass_factor.solve::<2>(force);
    }
    if let Some(chain) = &shaft.twist {
        let range = chain.start..chain.start + chain.nodes;
        let (q, v, force) = (&q[range.clone()], &v[range.clone()], &mut force[range]);
        chain.subtract_elastic::<1>(q, force);
        if let Some(damping) = &chain.damping {
            damping.multiply_add::<1>(-1.0, v, force);
        }
        chain.mass_factor.solve::<1>(force);
    }
}

impl System for Motion<'_> {
    fn len(&self) -> usize {
        2 * self.model.len()
    }

    fn derivative(&mut self, elapsed: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        let n = self.model.len();
        let (q, v) = y.split_at(n);
        let (rate, acceleration) = derivative.split_at_mut(n);
        rate.copy_from_slice(v);
        self.loads(elapsed, q, v, acceleration)?;
        for (shaft, spin) in self.model.shafts.iter().zip(&self.spins) {
            accelerate(shaft, *spin, q, v, acceleration);
        }
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        (!self.switching.is_empty()).then_some(&self.switching)
    }

    fn laws_at(&self, elapsed: f64, y: &[f64], laws: &mut Vec<i64>) -> Result<(), Halt> {
        let (q, v) = y.split_at(self.model.len());
        laws.clear();
        for (index, (mesh, sigma)) in self.model.meshes.iter().zip(&self.sigma).enumerate() {
            let law = if mesh.switches() {
                mesh.law(self.geometry, *sigma, &self.turning(index, elapsed), q, v)
                    .map_err(|overlap| Halt::Overlap { mesh: index, overlap })?
            } else {
                Law::ALWAYS
            };
            laws.extend(law.code());
        }
        Ok(())
    }

    fn set_laws(&mut self, laws: &[i64]) {
        for (law, code) in self.laws.iter_mut().zip(laws.chunks_exact(Law::CODE)) {
            *law = Law::from_code(code);
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
        square.max(0.0).sqrt()
    }
}
