//! M q̈ = f(t) − K q − (C + ΩG) q̇ − Σ_mesh F ∂δ/∂q, node by node.
//!
//! One complex chain contains both bending planes of a shaft; a separate chain contains its twist. The multiplication
//! and the solution of a chain take time proportional to its number of nodes. Terms that a scene does not have (spin,
//! damping, bow) are skipped.
//!
//! At a variable Ω, each evaluation uses the exact angle, spin and acceleration of every shaft. The torque that
//! accelerates a section is assumed to act on this section along its own axis. Therefore there is no term Ω̇G q, and
//! the twist, which is measured from the prescribed spin, is not excited.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::shaft_rotation::{Changing, ShaftRotation};
use crate::connection::{Connection, Instant};
use crate::integrate::{FirstOrderSystem, Halt};
use crate::linalg::DecompositionError;
use crate::mesh::{ContactMode, GearMesh, Geometry, MeshPose, ShaftPhase};
use crate::modal::CachedModel;
use crate::model::{Model, ShaftModel, Support};
use crate::scene::Node;

/// A force on the coordinates (v, w) of a node that rotates with its shaft.
#[derive(Clone, Copy, Debug)]
struct TurningForce {
    index: usize,
    amplitude: Complex64,
}

/// The rotating forces of one shaft.
#[derive(Clone, Debug)]
struct Excited {
    shaft: usize,
    spin: f64,
    at_origin: Complex64,
    forces: Vec<TurningForce>,
}

/// The equation of motion of a model at a given speed.
#[derive(Clone, Debug)]
pub struct EquationOfMotion<'m> {
    pub(super) model: &'m Model,
    pub(super) geometry: Geometry,
    pub(super) sigma: Vec<f64>,
    /// Signed spin of each shaft, rad/s, if the speed is constant.
    spins: Vec<f64>,
    /// Speed of the reference shaft, rad/s, if it is constant.
    speed: f64,
    /// Speed of the reference shaft, if it is variable.
    changing: Option<Changing>,
    /// Phasor e^{iϑ} of each shaft at elapsed time zero.
    pub(super) at_origin: Vec<Complex64>,
    /// Angle of each shaft at elapsed time zero, rad.
    angles: Vec<f64>,
    /// Contact mode of each mesh in the step.
    pub(super) contact_modes: Vec<ContactMode>,
    /// Indices of the coordinates of meshes with several contact modes.
    switching: Vec<usize>,
    excited: Vec<Excited>,
    /// Matrix of modal damping, N s/m, shape (n, n); none without modal damping. Runs at a constant speed do not use
    /// it, because they use modal coordinates.
    pub(super) modal_damping: Option<DMatrix<f64>>,
    /// Speed-dependent bearings at the largest speed of the run. They define the energy norm of the tolerances, which
    /// must be constant during a run.
    norm_supports: Vec<Support>,
    equilibrium: DVector<f64>,
    /// Scratch memory for one vector of displacements.
    pub(super) scratch: Vec<f64>,
}

impl<'m> EquationOfMotion<'m> {
    /// Creates the motion at a constant `speed` of the reference shaft, from the time `origin`. Tolerances are relative
    /// to the deviation from `equilibrium`.
    pub fn new(
        cached: &'m CachedModel,
        geometry: Geometry,
        speed: f64,
        origin: f64,
        equilibrium: DVector<f64>,
    ) -> Result<Self, DecompositionError> {
        Self::along(cached, geometry, &ShaftRotation::constant(speed, origin), equilibrium)
    }

    /// The motion with the rotation `course` of the reference shaft.
    pub fn along(
        cached: &'m CachedModel,
        geometry: Geometry,
        course: &ShaftRotation,
        equilibrium: DVector<f64>,
    ) -> Result<Self, DecompositionError> {
        let (model, speed) = (&cached.model, course.fastest);
        let spins: Vec<f64> = model.shafts.iter().map(|shaft| shaft.ratio * speed).collect();
        let at_origin: Vec<_> = model.shafts.iter().map(|shaft| course.phasor_at_origin(shaft.ratio)).collect();
        let excited = |(index, shaft): (usize, &ShaftModel)| Excited {
            shaft: index,
            spin: spins[index],
            at_origin: at_origin[index],
            forces: shaft
                .excitations
                .iter()
                .map(|excitation| TurningForce {
                    index: excitation.index,
                    amplitude: excitation.amplitude(spins[index], 0.0),
                })
                .collect(),
        };
        let excited = model.shafts.iter().enumerate().map(excited);
        let excited: Vec<_> = excited.filter(|excited| course.is_constant() && !excited.forces.is_empty()).collect();
        let modal_damping = match model.scene.modal_damping {
            0.0 => None,
            _ => {
                let cached = cached.at_speed(speed).map_err(|_| DecompositionError::SpeedDependent)?;
                cached.modal_damping_matrix(speed)?
            }
        };
        let norm_supports = model.bearings.iter().map(|bearing| {
            let [stiffness, damping] = bearing.at(speed);
            Support::new(bearing.index, stiffness, damping)
        });
        let angles: Vec<f64> = at_origin.iter().map(|turn| turn.arg()).collect();
        Ok(Self {
            model,
            geometry,
            sigma: (0..model.meshes.len()).map(|mesh| model.sigma(mesh, speed)).collect(),
            spins,
            speed,
            changing: course.changing(),
            angles,
            at_origin,
            contact_modes: vec![ContactMode::ALWAYS; model.meshes.len()],
            switching: model.meshes.iter().filter(|mesh| mesh.switches()).flat_map(GearMesh::indices).collect(),
            excited,
            modal_damping,
            norm_supports: norm_supports.collect(),
            equilibrium,
            scratch: vec![0.0; model.len()],
        })
    }

    /// Quadratic form qᵀKq, with each mesh linearised at rest.
    fn elastic_form(&self, q: &[f64]) -> f64 {
        let constant = self.model.elastic_form(q, |mesh| self.sigma[mesh]);
        self.norm_supports.iter().fold(constant, |sum, support| sum + support.elastic_form(q))
    }

    /// All connections of the model, meshes first.
    #[inline(always)]
    pub fn connections(&self) -> impl Iterator<Item = Connection<'_>> {
        self.model.connections_with(|mesh| self.sigma[mesh])
    }

    /// Quantities on which a connection depends in addition to its scalars: the shafts and the contact mode of a mesh.
    #[inline(always)]
    pub fn instant(&self, mesh: Option<usize>, elapsed: f64) -> Instant {
        let phases = mesh.map_or_else(Default::default, |mesh| self.turning(mesh, elapsed));
        Instant { phases, contact_mode: *self.contact_mode(mesh) }
    }

    /// The contact mode of a mesh; [`ContactMode::ALWAYS`] for other connections.
    #[inline(always)]
    pub fn contact_mode(&self, mesh: Option<usize>) -> &ContactMode {
        mesh.map_or(&ContactMode::ALWAYS, |mesh| &self.contact_modes[mesh])
    }

    /// Whether the line of action follows the gear centres.
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Speed of the reference shaft, rad/s, and its acceleration, rad/s².
    #[inline]
    pub(super) fn reference_speed(&self, elapsed: f64) -> (f64, f64) {
        match &self.changing {
            None => (self.speed, 0.0),
            Some(changing) => {
                let now = changing.at(elapsed);
                (now.speed, now.acceleration)
            }
        }
    }

    /// Force of the shaft on the bearings of a node, components (y, z), N.
    pub fn bearing_force(&self, node: Node, elapsed: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
        let mut force = self.model.bearing_force(node, q, v);
        for bearing in self.model.bearings_at(node) {
            let own = bearing.force(self.reference_speed(elapsed).0, q, v);
            force = [force[0] + own[0], force[1] + own[1]];
        }
        force
    }

    /// Phasor e^{iϑ} of a shaft.
    pub fn turn(&self, shaft: usize, elapsed: f64) -> Complex64 {
        self.at_origin[shaft] * Complex64::from_polar(1.0, self.turned(shaft, elapsed).0)
    }

    /// Angle of a shaft since elapsed time zero, rad, and its spin, rad/s.
    #[inline(always)]
    fn turned(&self, shaft: usize, elapsed: f64) -> (f64, f64) {
        match &self.changing {
            None => (self.spins[shaft] * elapsed, self.spins[shaft]),
            Some(changing) => {
                let (ratio, now) = (self.model.shafts[shaft].ratio, changing.at(elapsed));
                (ratio * now.angle, ratio * now.speed)
            }
        }
    }

    /// Spin of a shaft, rad/s, and its acceleration, rad/s².
    pub(super) fn spin_at(&self, shaft: usize, elapsed: f64) -> (f64, f64) {
        match &self.changing {
            None => (self.spins[shaft], 0.0),
            Some(changing) => {
                let (ratio, now) = (self.model.shafts[shaft].ratio, changing.at(elapsed));
                (ratio * now.speed, ratio * now.acceleration)
            }
        }
    }

    /// Signed spin of a shaft, rad/s.
    pub fn spin(&self, shaft: usize) -> f64 {
        self.spins[shaft]
    }

    /// Sign σ of the driver's spin of a mesh.
    pub fn sigma_of(&self, mesh: usize) -> f64 {
        self.sigma[mesh]
    }

    /// Whether the contact modes of a final state are valid for this motion: none, or one code for each mesh and the
    /// piece of the speed profile.
    pub fn accepts_laws(&self, contact_modes: &[i64]) -> bool {
        let meshes = self.contact_modes.len() * ContactMode::CODE;
        let whole = meshes + usize::from(self.changing.is_some());
        contact_modes.is_empty()
            || contact_modes.len() == whole
                && contact_modes[..meshes].chunks_exact(ContactMode::CODE).all(ContactMode::is_code)
    }

    /// Whether the times of contact mode changes depend on the motion.
    pub fn motion_changes_contact_modes(&self) -> bool {
        let moves = |mesh: &GearMesh| {
            mesh.backlash.is_some() || self.geometry == Geometry::Live || mesh.engagement_follows_motion()
        };
        self.model.meshes.iter().any(|mesh| mesh.switches() && moves(mesh))
    }

    /// Highest angular frequency of two free gears on their mesh stiffness, rad/s.
    pub fn fastest_swing(&self) -> f64 {
        let square = |(mesh, gear_mesh): (usize, &GearMesh)| gear_mesh.stiffest * self.mobility(mesh);
        self.model.meshes.iter().enumerate().map(square).fold(0.0, f64::max).sqrt()
    }

    /// Relative acceleration of the teeth of two free gears along the line of action per unit of mesh force, 1/kg.
    pub fn mobility(&self, mesh: usize) -> f64 {
        let scene = &self.model.scene;
        let bending = if self.model.meshes[mesh].coordinates.translation.is_some() { 1.0 } else { 0.0 };
        let mobility = |gear: usize| {
            let gear = &scene.gears[gear];
            gear.base_radius.powi(2) / gear.body.polar_inertia + bending / gear.body.mass
        };
        mobility(scene.meshes[mesh].driver) + mobility(scene.meshes[mesh].driven)
    }

    /// Whether the flanks of a mesh may separate.
    pub fn parts(&self) -> bool {
        self.model.meshes.iter().any(|mesh| mesh.backlash.is_some())
    }

    /// Whether the flanks of a mesh with varying stiffness may separate.
    pub fn parts_and_varies(&self) -> bool {
        self.model.meshes.iter().any(|mesh| mesh.backlash.is_some() && !mesh.teeth.is_constant())
    }

    /// Indices of the shafts with rotating forces.
    pub fn sources(&self) -> impl Iterator<Item = usize> + '_ {
        self.excited.iter().map(|excited| excited.shaft)
    }

    /// Rotating force of a shaft at ϑ = 0 and at ϑ = π/2, the factors of cos ϑ and sin ϑ, as entries (index, force).
    pub fn turning_forces(&self, shaft: usize) -> [Vec<(usize, f64)>; 2] {
        let forces = self.excited.iter().filter(|excited| excited.shaft == shaft).flat_map(|excited| &excited.forces);
        let (mut cosine, mut sine) = (Vec::new(), Vec::new());
        for TurningForce { index, amplitude } in forces {
            cosine.extend([(*index, amplitude.re), (*index + 1, amplitude.im)]);
            sine.extend([(*index, -amplitude.im), (*index + 1, amplitude.re)]);
        }
        [cosine, sine]
    }

    /// Angles and spins of the two shafts of a mesh.
    #[inline(always)]
    pub fn turning(&self, mesh: usize, elapsed: f64) -> [ShaftPhase; 2] {
        self.model.meshes[mesh].shafts.map(|shaft| {
            let (turned, spin) = self.turned(shaft, elapsed);
            ShaftPhase { angle: self.angles[shaft] + turned, spin }
        })
    }

    /// Pose of a mesh.
    #[inline(always)]
    pub(super) fn pose<'a>(&self, mesh: usize, turning: &'a [ShaftPhase; 2], q: &[f64], v: &[f64]) -> MeshPose<'a> {
        self.model.meshes[mesh].pose(self.geometry, self.sigma[mesh], turning, q, v)
    }

    /// Adds the rotating forces of shafts with a variable speed.
    fn add_changing(&self, elapsed: f64, force: &mut [f64]) {
        for (index, shaft) in self.model.shafts.iter().enumerate().filter(|(_, shaft)| !shaft.excitations.is_empty()) {
            let ((spin, rate), turn) = (self.spin_at(index, elapsed), self.turn(index, elapsed));
            for excitation in &shaft.excitations {
                let turned = excitation.amplitude(spin, rate) * turn;
                force[excitation.index] += turned.re;
                force[excitation.index + 1] += turned.im;
            }
        }
    }

    /// Writes the external forces and the forces of all connections into `force`.
    #[inline(always)]
    fn loads(&self, elapsed: f64, q: &[f64], v: &[f64], force: &mut [f64]) -> Result<(), Halt> {
        force.copy_from_slice(self.model.constant_load.as_slice());
        if self.changing.is_some() {
            self.add_changing(elapsed, force);
        }
        for excited in &self.excited {
            let turn = excited.at_origin * Complex64::from_polar(1.0, excited.spin * elapsed);
            for TurningForce { index, amplitude } in &excited.forces {
                force[*index] += amplitude.re * turn.re - amplitude.im * turn.im;
                force[*index + 1] += amplitude.re * turn.im + amplitude.im * turn.re;
            }
        }
        for support in &self.model.supports {
            for (row, value) in support.force(q, v).into_iter().enumerate() {
                force[support.index + row] -= value;
            }
        }
        self.connections().try_for_each(|connection| {
            match connection {
                Connection::Mesh(index, mesh, _) => {
                    let contact = mesh
                        .contact(&self.pose(index, &self.turning(index, elapsed), q, v), &self.contact_modes[index])
                        .map_err(|overlap| Halt::Overlap { mesh: index, overlap })?;
                    mesh.apply(&contact, force);
                }
                Connection::Bearing(bearing) => {
                    let [y, z] = bearing.force(self.reference_speed(elapsed).0, q, v);
                    force[bearing.index] -= y;
                    force[bearing.index + 1] -= z;
                }
                Connection::Spring(spring) => {
                    spring.apply(spring.contact(spring.scalar(q), spring.scalar(v)).force, force);
                }
            }
            Ok(())
        })?;
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
        }
        if let Some(damping) = &chain.damping {
            damping.multiply_add::<2>(-1.0, v, force);
        }
        chain.mass_factor.solve::<2>(force);
    }
    if let Some(chain) = &shaft.twist {
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
        let speed = self.changing.as_ref().map(|changing| changing.at(elapsed).speed);
        for (shaft, spin) in self.model.shafts.iter().zip(&self.spins) {
            let spin = speed.map_or(*spin, |speed| shaft.ratio * speed);
            accelerate(shaft, spin, q, v, acceleration);
        }
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        (self.changing.is_some() || !self.switching.is_empty()).then_some(&self.switching)
    }

    fn contact_modes_at(&mut self, elapsed: f64, y: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        let (q, v) = y.split_at(self.model.len());
        contact_modes.clear();
        for (index, mesh) in self.model.meshes.iter().enumerate() {
            let contact_mode = if mesh.switches() {
                mesh.contact_mode(&self.pose(index, &self.turning(index, elapsed), q, v))
                    .map_err(|overlap| Halt::Overlap { mesh: index, overlap })?
            } else {
                ContactMode::ALWAYS
            };
            contact_modes.extend(contact_mode.code());
        }
        contact_modes.extend(self.changing.as_ref().map(|changing| changing.piece_at(elapsed)));
        Ok(())
    }

    fn set_contact_modes(&mut self, contact_modes: &[i64]) {
        for (contact_mode, code) in self.contact_modes.iter_mut().zip(contact_modes.chunks_exact(ContactMode::CODE)) {
            *contact_mode = ContactMode::from_code(code);
        }
        if let (Some(changing), Some(piece)) = (&mut self.changing, contact_modes.last()) {
            changing.hold(*piece);
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
