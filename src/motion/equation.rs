//! M q̈ = f(t) − K q − (C + ΩG) q̇ − Σ_mesh F ∂δ/∂q, node by node.
//!
//! One complex chain contains both bending planes of a shaft; separate chains contain its twist and its axial motion.
//! The file `first_order.rs` evaluates this equation.
//!
//! At a variable Ω, each evaluation uses the exact angle, spin and acceleration of every shaft. The torque that
//! accelerates a section is assumed to act on this section along its own axis. Therefore there is no term Ω̇G q, and
//! the twist, which is measured from the prescribed spin, is not excited.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::frame::{FrameForces, TurningFrame};
use super::rotating_load::RotatingLoad;
use super::shaft_rotation::{RotationState, ShaftRotation, VariableSpeed};
use crate::connection::{AppliedLoad, Connection, Instant};
use crate::linalg::DecompositionError;
use crate::mesh::{ContactMode, GearMesh, Geometry, MeshPose, ShaftPhase};
use crate::modal::CachedModel;
use crate::model::{Link, Model, Turning};
use crate::scene::LoadLaw;

/// Numbers that a run does not change.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunConstants {
    /// Speed of the reference shaft, rad/s, or the largest one of the run if it changes.
    pub speed: f64,
    /// Speed of the reference shaft at which the linear motion contains the connections, rad/s.
    pub linear_speed: f64,
    /// Time at which elapsed time is zero, s.
    pub origin: f64,
    /// Energy norm, √J, below which tolerances are absolute: a share of the response to the loads over time within one
    /// interval of their series. Without it, no step is short enough for a load that sets a body at rest in motion.
    pub smallest_size: f64,
}

/// The equation of motion of a model at a given speed.
#[derive(Clone, Debug)]
pub struct EquationOfMotion<'m> {
    pub(super) model: &'m Model,
    pub(super) geometry: Geometry,
    pub(super) sigma: Vec<f64>,
    /// Signed speeds in the order of [`Model::turning_ratio`], rad/s, if the speed is constant.
    pub(super) spins: Vec<f64>,
    pub(super) constants: RunConstants,
    /// Speed of the reference shaft, if it is variable.
    pub(super) variable_speed: Option<VariableSpeed>,
    /// Phasor e^{iϑ} of the same at elapsed time zero.
    pub(super) at_origin: Vec<Complex64>,
    /// Angle of the same at elapsed time zero, rad.
    angles: Vec<f64>,
    /// Contact mode of each mesh in the step.
    pub(super) contact_modes: Vec<ContactMode>,
    /// Indices of the coordinates of meshes with several contact modes.
    pub(super) switching: Vec<usize>,
    /// Bow, unbalance and turning forces of the shafts.
    pub(super) rotating_loads: Vec<RotatingLoad>,
    /// Loads that do not depend on time and motion, with centrifugal forces on planets, n entries, N and N m.
    pub(super) constant_load: DVector<f64>,
    /// Forces of frames that turn; none without such frames.
    pub(super) frame_forces: Option<FrameForces>,
    /// Matrix of modal damping, N s/m, shape (n, n); none without modal damping, or if nothing needs it.
    pub(super) modal_damping: Option<DMatrix<f64>>,
    /// Speed-dependent bearings at the largest speed of the run. They define the energy norm of the tolerances, which
    /// must be constant during a run.
    norm_bearings: Vec<Link>,
    pub(super) equilibrium: DVector<f64>,
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
        Self::along(cached, geometry, &ShaftRotation::constant(speed, origin), equilibrium).with_modal_damping(cached)
    }

    /// Adds the matrix of modal damping, which forces and powers in displacements need; modal coordinates do not. It needs
    /// all undamped modes.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes cannot be computed.
    pub fn with_modal_damping(self, cached: &CachedModel) -> Result<Self, DecompositionError> {
        if self.model.scene.modal_damping.is_zero() {
            return Ok(self);
        }
        let cached = cached.at_speed(self.constants.speed).map_err(|_| DecompositionError::SpeedDependent)?;
        Ok(Self { modal_damping: cached.modal_damping_matrix(self.constants.speed)?, ..self })
    }

    /// Creates the motion with the `rotation` of the reference shaft, without modal damping.
    pub fn along(
        cached: &'m CachedModel,
        geometry: Geometry,
        rotation: &ShaftRotation,
        equilibrium: DVector<f64>,
    ) -> Self {
        let (model, speed) = (&cached.model, rotation.fastest);
        let ratios = || (0..model.turning_count()).map(|index| model.turning_ratio(index));
        let spins: Vec<f64> = ratios().map(|ratio| ratio * speed).collect();
        let at_origin: Vec<_> = ratios().map(|ratio| rotation.phasor_at_origin(ratio)).collect();
        let rotating_loads = if rotation.is_constant() {
            RotatingLoad::at_constant_speed(model, rotation, &spins, &at_origin)
        } else {
            RotatingLoad::at_changing_speed(model, &spins, &at_origin)
        };
        let frame_forces = FrameForces::new(model, speed);
        let centrifugal = frame_forces.as_ref().map(|forces| &forces.centrifugal);
        let constant_load = centrifugal.map_or_else(|| model.constant_load.clone(), |load| &model.constant_load + load);
        let angles: Vec<f64> = at_origin.iter().map(|phasor| phasor.arg()).collect();
        Self {
            model,
            geometry,
            sigma: (0..model.meshes.len()).map(|mesh| model.sigma(mesh, speed)).collect(),
            spins,
            constants: RunConstants {
                speed,
                linear_speed: speed,
                origin: rotation.origin,
                smallest_size: smallest_size(model),
            },
            variable_speed: rotation.variable_speed(),
            angles,
            at_origin,
            contact_modes: vec![ContactMode::ALWAYS; model.meshes.len()],
            switching: model.meshes.iter().filter(|mesh| mesh.switches()).flat_map(GearMesh::indices).collect(),
            rotating_loads,
            constant_load,
            frame_forces,
            modal_damping: None,
            norm_bearings: bearings_at(model, speed).collect(),
            equilibrium,
            scratch: vec![0.0; model.len()],
        }
    }

    /// Quadratic form qᵀKq, with each mesh linearised at rest.
    pub(super) fn elastic_form(&self, q: &[f64]) -> f64 {
        let constant = self.model.elastic_form(q, |mesh| self.sigma[mesh]);
        self.norm_bearings.iter().fold(constant, |sum, link| sum + elastic_form_of(link, q))
    }

    /// Energy norm of displacements without velocities, √J, at a largest speed of the reference shaft, rad/s: that of
    /// [`crate::integrate::FirstOrderSystem::norm`].
    pub fn elastic_norm(model: &Model, speed: f64, q: &[f64]) -> f64 {
        let constant = model.elastic_form(q, |mesh| model.sigma(mesh, speed));
        bearings_at(model, speed).fold(constant, |sum, link| sum + elastic_form_of(&link, q)).max(0.0).sqrt()
    }

    /// All connections of the model, meshes first.
    #[inline(always)]
    pub fn connections(&self) -> impl Iterator<Item = Connection<'_>> {
        self.model.connections_with(|mesh| self.sigma[mesh])
    }

    /// Quantities on which a connection depends in addition to its scalars: the shafts and the contact mode of a mesh, the
    /// shaft of a load or what turns a nonlinear bearing, and the time.
    #[inline(always)]
    pub fn instant(&self, mesh: Option<usize>, turning: Option<usize>, elapsed: f64) -> Instant {
        let phases = match (mesh, turning) {
            (Some(mesh), _) => self.phases(mesh, elapsed),
            (None, Some(turning)) => [self.phase(turning, elapsed), ShaftPhase::default()],
            (None, None) => Default::default(),
        };
        Instant { time: self.constants.origin + elapsed, phases, contact_mode: *self.contact_mode(mesh) }
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
        match &self.variable_speed {
            None => (self.constants.speed, 0.0),
            Some(variable_speed) => {
                let now = variable_speed.at(elapsed);
                (now.speed, now.acceleration)
            }
        }
    }

    /// The reference shaft at an instant, if the speed is variable.
    pub fn reference_shaft(&self, elapsed: f64) -> Option<RotationState> {
        self.variable_speed.as_ref().map(|variable_speed| variable_speed.at(elapsed))
    }

    /// Lets steps cross the borders between pieces of a variable speed at which the acceleration is continuous.
    pub fn join_smooth_pieces(&mut self) {
        if let Some(variable_speed) = &mut self.variable_speed {
            variable_speed.join_smooth_pieces();
        }
    }

    /// Index of the piece of a variable speed at an instant; none at a constant speed.
    pub fn piece_at(&self, elapsed: f64) -> Option<i64> {
        self.variable_speed.as_ref().map(|variable_speed| variable_speed.piece_at(elapsed))
    }

    /// Whether a variable speed has another piece at an instant than in the step.
    pub fn leaves_piece(&self, elapsed: f64) -> bool {
        self.variable_speed.as_ref().is_some_and(|variable_speed| variable_speed.leaves_piece(elapsed))
    }

    /// Phasor e^{iϑ} of a shaft in the frame of its lateral motion.
    pub fn phasor(&self, shaft: usize, elapsed: f64) -> Complex64 {
        let turning = self.model.in_frame(shaft);
        self.at_origin[turning] * Complex64::from_polar(1.0, self.angle_and_spin(turning, elapsed).0)
    }

    /// The frame of the lateral motion of a shaft, if it turns.
    pub fn frame(&self, shaft: usize, elapsed: f64) -> Option<TurningFrame> {
        let carrier = self.model.scene.frame_of(shaft)?;
        let ShaftPhase { angle, spin } = self.phase(carrier, elapsed);
        Some(TurningFrame { phasor: Complex64::from_polar(1.0, angle), speed: spin })
    }

    /// Loads that do not depend on time and motion, with centrifugal forces on planets, n entries, N and N m.
    pub fn constant_load(&self) -> &DVector<f64> {
        &self.constant_load
    }

    /// The rotation of a shaft and of its bow, seen from the ground. The bow turns with the twist in the displacements q if the
    /// scene says so.
    pub fn turning(&self, shaft: usize, elapsed: f64, q: &[f64]) -> Turning {
        let twist = self.model.turning_bow(shaft).map_or(0.0, |bow| bow.twist(q));
        let bow = self.phasor(shaft, elapsed) * Complex64::from_polar(1.0, twist);
        let from_ground = self.frame(shaft, elapsed).map_or(bow, |frame| bow * frame.phasor);
        Turning { spin: self.angle_and_spin(shaft, elapsed).1, bow: from_ground }
    }

    /// Whether the speed is constant.
    pub fn has_constant_speed(&self) -> bool {
        self.variable_speed.is_none()
    }

    /// Angle since elapsed time zero, rad, and speed, rad/s, of an index of [`Model::turning_ratio`].
    #[inline(always)]
    fn angle_and_spin(&self, turning: usize, elapsed: f64) -> (f64, f64) {
        match &self.variable_speed {
            None => (self.spins[turning] * elapsed, self.spins[turning]),
            Some(variable_speed) => {
                let (ratio, now) = (self.model.turning_ratio(turning), variable_speed.at(elapsed));
                (ratio * now.angle, ratio * now.speed)
            }
        }
    }

    /// Speed of a shaft relative to the frame of its lateral motion, rad/s.
    pub(super) fn spin_in_frame(&self, shaft: usize, elapsed: f64) -> f64 {
        self.angle_and_spin(self.model.in_frame(shaft), elapsed).1
    }

    /// Spin of a shaft, rad/s, and its acceleration, rad/s².
    pub(super) fn spin_at(&self, shaft: usize, elapsed: f64) -> (f64, f64) {
        match &self.variable_speed {
            None => (self.spins[shaft], 0.0),
            Some(variable_speed) => {
                let (ratio, now) = (self.model.shafts[shaft].ratio, variable_speed.at(elapsed));
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
    pub fn accepts_contact_modes(&self, contact_modes: &[i64]) -> bool {
        let meshes = self.contact_modes.len() * ContactMode::CODE_LENGTH;
        let whole = meshes + usize::from(self.variable_speed.is_some());
        contact_modes.is_empty()
            || contact_modes.len() == whole
                && contact_modes[..meshes].chunks_exact(ContactMode::CODE_LENGTH).all(ContactMode::is_code)
    }

    /// Whether the times of contact mode changes depend on the motion.
    pub fn motion_changes_contact_modes(&self) -> bool {
        let moves = |mesh: &GearMesh| {
            mesh.backlash.is_some() || self.geometry == Geometry::Live || mesh.engagement_follows_motion()
        };
        self.model.meshes.iter().any(|mesh| mesh.switches() && moves(mesh))
    }

    /// Highest angular frequency of two free gears on their mesh stiffness, rad/s.
    pub fn highest_mesh_frequency(&self) -> f64 {
        self.model.highest_mesh_frequency()
    }

    /// Relative acceleration of the teeth of two free gears along the line of action per unit of mesh force, 1/kg.
    pub fn mobility(&self, mesh: usize) -> f64 {
        self.model.mobility(mesh)
    }

    /// Whether the flanks of a mesh may separate.
    pub fn flanks_can_separate(&self) -> bool {
        self.model.meshes.iter().any(|mesh| mesh.backlash.is_some())
    }

    /// Whether the flanks of a mesh with varying stiffness may separate.
    pub fn varying_flanks_can_separate(&self) -> bool {
        self.model.meshes.iter().any(|mesh| mesh.backlash.is_some() && !mesh.teeth.is_constant())
    }

    /// Bow, unbalance and turning forces of the shafts.
    pub fn rotating_loads(&self) -> &[RotatingLoad] {
        &self.rotating_loads
    }

    /// The rotating loads to which there is a synchronous motion: all at a constant speed, none at a changing one.
    pub fn sources(&self) -> &[RotatingLoad] {
        if self.variable_speed.is_none() { &self.rotating_loads } else { &[] }
    }

    /// Angles and spins of the two shafts of a mesh, relative to its carrier.
    #[inline(always)]
    pub fn phases(&self, mesh: usize, elapsed: f64) -> [ShaftPhase; 2] {
        let mesh = &self.model.meshes[mesh];
        let phases = mesh.shafts.map(|shaft| self.phase(shaft, elapsed));
        match mesh.carrier.map(|shaft| self.phase(shaft, elapsed)) {
            None => phases,
            Some(carrier) => {
                phases.map(|phase| ShaftPhase { angle: phase.angle - carrier.angle, spin: phase.spin - carrier.spin })
            }
        }
    }

    /// Angle and speed of an index of [`Model::turning_ratio`].
    #[inline(always)]
    pub(super) fn phase(&self, turning: usize, elapsed: f64) -> ShaftPhase {
        let (angle, spin) = self.angle_and_spin(turning, elapsed);
        ShaftPhase { angle: self.angles[turning] + angle, spin }
    }

    /// Speed of the reference shaft, rad/s, or the largest one of the run if it changes: see [`super::Speed::fastest`].
    pub fn largest_speed(&self) -> f64 {
        self.constants.speed
    }

    /// Speed of the reference shaft at which the linear motion contains the connections, rad/s.
    pub fn linear_speed(&self) -> f64 {
        self.constants.linear_speed
    }

    /// Sets the speed of the reference shaft at which the linear motion contains the connections, rad/s; by default the
    /// largest one of the run.
    pub fn linearise_at(&mut self, speed: f64) {
        self.constants.linear_speed = speed;
    }

    /// What the force of a mesh depends on apart from its contact, at the phases of driver and driven gear, displacements and velocities.
    #[inline(always)]
    pub(super) fn pose<'a>(&self, mesh: usize, phases: &'a [ShaftPhase; 2], q: &[f64], v: &[f64]) -> MeshPose<'a> {
        self.model.meshes[mesh].pose(self.geometry, self.sigma[mesh], phases, q, v)
    }
}

/// The speed-dependent bearings as links with their coefficients at a speed of the reference shaft, rad/s.
fn bearings_at(model: &Model, speed: f64) -> impl Iterator<Item = Link> + '_ {
    model.bearings.iter().map(move |bearing| {
        let [stiffness, damping] = bearing.at(speed);
        Link::new(String::new(), bearing.rows.to_vec(), stiffness, damping)
    })
}

/// Quadratic form qᵀKq of a link.
fn elastic_form_of(link: &Link, q: &[f64]) -> f64 {
    link.local.elastic_form(&link.scalars(q))
}

/// Share of the impulse of a load over time within one interval of its series that counts as a motion.
const IMPULSE_SHARE: f64 = 0.1;

/// Energy norm, √J, of the velocities after an impulse of the loads over time: √(wᵀM⁻¹w)·F·Δt with the largest value F and
/// the mean interval Δt of each; zero without such loads.
fn smallest_size(model: &Model) -> f64 {
    let impulse = |load: &AppliedLoad| {
        let (size, interval) = match &load.law {
            LoadLaw::Force([y, z]) => (y.largest().hypot(z.largest()), y.mean_spacing()),
            LoadLaw::Torque(curve) => (curve.largest(), curve.mean_spacing()),
            LoadLaw::Turning { .. } | LoadLaw::SpeedTorque { .. } => return 0.0,
        };
        let mut column = vec![0.0; model.len()];
        load.rows[0].iter().for_each(|(index, coefficient)| column[*index] += coefficient);
        model.solve_mass(&mut column);
        let mobility: f64 = load.rows[0].iter().map(|(index, coefficient)| coefficient * column[*index]).sum();
        mobility.sqrt() * size * interval
    };
    IMPULSE_SHARE * model.loads.iter().map(impulse).fold(0.0, f64::max)
}
