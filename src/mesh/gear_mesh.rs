//! The force of a mesh: one scalar that acts on six coordinates.
//!
//! ```text
//! F = ∂U/∂δ + c δ̇,    generalised force on q:  −F ∂δ/∂q,    ∂δ/∂q = (n, −n, σr_a, σr_b) for q = (u_a, u_b, θ_a, θ_b)
//! ```
//!
//! U is ½kδ² for a mean stiffness k, otherwise the sum over the tooth pairs. Modes, static equilibrium and motion use the
//! same force. Live geometry takes n from the moving centres; with constant k the force then derives from ½kδ², and an
//! undamped scene conserves its energy. Frozen geometry keeps n of the centres at rest, so that the force is linear. A
//! stiffness that depends on the displacements adds its own −∂U/∂q.
//!
//! With backlash, F acts on the drive flank while this flank is pressed, and on the back flank (σ → −σ, deflection
//! minus backlash) while the back flank is pressed. Otherwise F is zero. F is never tensile. `flank.rs` computes the
//! force of one flank.

use super::contact::{Contact, ContactMode, Flank, MeshState, ShaftPhase};
use super::error::ErrorCurve;
use super::involute::{CentreGeometry, Centres, Involute, LineOfAction, Overlap};
use super::stiffness::{self, Stiffness};
use crate::scene::{Damping, Gear, Mesh, Phase};

/// Whether the line of action follows the centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// The line of action follows the moving centres.
    Live,
    /// The line of action is that of the centres at rest.
    Frozen,
}

/// Indices of the six coordinates of a mesh in a vector of displacements.
#[derive(Clone, Copy, Debug)]
pub struct MeshCoordinates {
    /// v of driver and driven gear (w follows v); `None` in a scene that has no bending.
    pub translation: Option<[usize; 2]>,
    /// θ of driver and driven gear.
    pub twist: [usize; 2],
}

/// Everything on which the force of a mesh depends except its contact mode.
#[derive(Clone, Copy, Debug)]
pub struct MeshPose<'a> {
    /// Whether its line of action follows the centres.
    pub geometry: Geometry,
    /// σ, the sign of the driver's spin.
    pub sigma: f64,
    /// Angles and spins of the shafts of driver and driven gear.
    pub phases: &'a [ShaftPhase; 2],
    /// Relative displacements.
    pub position: RelativeMotion,
    /// Relative velocities.
    pub velocity: RelativeMotion,
}

/// Relative motion of the gears of a mesh: displacements, or velocities (then per second).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelativeMotion {
    /// u_b − u_a over (y, z), m.
    pub relative_displacement: [f64; 2],
    /// r_a θ_a + r_b θ_b, m.
    pub rolling_displacement: f64,
    /// θ_a and θ_b, rad: used where the tooth engagement follows the twist, and for run-out.
    pub twist: [f64; 2],
}

/// A mesh with its coordinates.
#[derive(Clone, Debug)]
pub struct GearMesh {
    /// Geometry of the pair.
    pub involute: Involute,
    /// The six coordinates.
    pub coordinates: MeshCoordinates,
    /// Stiffness of the teeth.
    pub teeth: Stiffness,
    /// Angle that moves the teeth along the path of contact: the prescribed angle, with or without the twist.
    pub phase: Phase,
    /// Mean stiffness, N/m, used by modes, equilibrium and all linear analyses.
    pub stiffness: f64,
    /// Upper bound of the stiffness, N/m.
    pub largest_stiffness: f64,
    /// Damping c, N s/m.
    pub damping: f64,
    /// Backlash along the line of action, m; none for a mesh whose flanks never separate.
    pub backlash: Option<f64>,
    /// Shafts of driver and driven gear; the spin of the first gives σ.
    pub shafts: [usize; 2],
    pub(super) error: Option<ErrorCurve>,
    /// Run-out of driver and driven gear: amplitude, m, and angle in the shaft, rad; none if neither gear has run-out.
    run_out: Option<[(f64, f64); 2]>,
    /// Line of action of the centres at rest, for σ = −1 and σ = +1.
    pub(super) at_rest: [LineOfAction; 2],
}

impl GearMesh {
    /// Creates the mesh of two gears that acts on these coordinates.
    pub fn new(mesh: &Mesh, gears: &[Gear], coordinates: MeshCoordinates) -> Self {
        let (a, b) = (&gears[mesh.driver], &gears[mesh.driven]);
        let involute = Involute::new(mesh, gears);
        let teeth = stiffness::build(&mesh.teeth, [a, b], &involute);
        let at_rest = involute.path_at_rest();
        let mean = teeth.mean(&at_rest);
        let damping = match mesh.damping {
            Damping::Constant(c) => c,
            Damping::Ratio(ratio) => {
                let compliance = |gear: &Gear| gear.base_radius * gear.base_radius / gear.body.polar_inertia;
                2.0 * ratio * (mean / (compliance(a) + compliance(b))).sqrt()
            }
        };
        // Both flanks are in contact if the centre distance shrinks by more than the backlash allows.
        let flanks = if mesh.teeth.backlash.is_some() { 2.0 } else { 1.0 };
        let out = [a, b].map(|gear| (gear.run_out.norm(), gear.run_out.arg()));
        Self {
            at_rest: [-1.0, 1.0].map(|sigma| involute.line_at_rest(sigma)),
            coordinates,
            stiffness: mean,
            largest_stiffness: flanks * teeth.largest(&at_rest).max(mean),
            involute,
            teeth,
            phase: mesh.teeth.phase,
            damping,
            backlash: mesh.teeth.backlash,
            shafts: [a.body.node.shaft, b.body.node.shaft],
            error: mesh.teeth.error.as_ref().map(|error| ErrorCurve::new(error, a.teeth)),
            run_out: out.iter().any(|(size, _)| *size > 0.0).then_some(out),
        }
    }

    /// Whether the mesh changes its contact mode. An integration step must end at each change.
    pub fn switches(&self) -> bool {
        self.backlash.is_some() || self.teeth.is_sharp()
    }

    /// Whether the stiffness varies with time or the contact mode changes. The centres are then observed at every step.
    pub fn is_time_varying(&self) -> bool {
        self.switches() || !self.teeth.is_constant()
    }

    /// Whether the force depends on the position of the teeth on the path of contact at a constant contact mode.
    pub fn depends_on_tooth_position(&self) -> bool {
        !self.teeth.is_piecewise_constant() || self.error.is_some()
    }

    /// Whether the tooth engagement depends on the motion, by the twist or by run-out.
    pub fn engagement_follows_motion(&self) -> bool {
        self.phase == Phase::Twist || self.run_out.is_some()
    }

    /// Whether a gear has run-out.
    pub fn has_run_out(&self) -> bool {
        self.run_out.is_some()
    }

    /// Position of the centres of the base circles.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn centres(&self, phases: &[ShaftPhase; 2], position: &RelativeMotion) -> Result<Centres, Overlap> {
        self.involute.centres(self.relative_displacement(phases, position))
    }

    /// Position of the moving centres for the response. In frozen geometry the force does not depend on it, so
    /// overlapping base circles do not stop the run.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles in live geometry.
    pub(super) fn reported_centres(
        &self,
        geometry: Geometry,
        relative_displacement: [f64; 2],
    ) -> Result<Centres, Overlap> {
        match (geometry, self.involute.centres(relative_displacement)) {
            (Geometry::Frozen, Err(overlap)) => Ok(self.involute.overlapping_centres(relative_displacement, &overlap)),
            (_, centres) => centres,
        }
    }

    /// Indices of the coordinates on which the mesh acts.
    pub fn indices(&self) -> Vec<usize> {
        let MeshCoordinates { translation, twist } = self.coordinates;
        twist.into_iter().chain(translation.into_iter().flatten().flat_map(|v| [v, v + 1])).collect()
    }

    /// Whether the force does not depend on the angles of the shafts.
    fn is_autonomous(&self) -> bool {
        self.teeth.is_constant() && self.error.is_none() && self.run_out.is_none()
    }

    /// Relative motion of the gears for displacements or velocities of the whole model.
    #[inline(always)]
    pub fn relative(&self, q: &[f64]) -> RelativeMotion {
        let [ra, rb] = self.involute.base_radius;
        let twist = self.coordinates.twist.map(|index| q[index]);
        let relative_displacement = match self.coordinates.translation {
            Some([a, b]) => [q[b] - q[a], q[b + 1] - q[a + 1]],
            None => [0.0; 2],
        };
        RelativeMotion { relative_displacement, rolling_displacement: ra * twist[0] + rb * twist[1], twist }
    }

    /// The pose for displacements `q` and velocities `v` of the whole model.
    #[inline(always)]
    pub fn pose<'a>(
        &self,
        geometry: Geometry,
        sigma: f64,
        phases: &'a [ShaftPhase; 2],
        q: &[f64],
        v: &[f64],
    ) -> MeshPose<'a> {
        MeshPose { geometry, sigma, phases, position: self.relative(q), velocity: self.relative(v) }
    }

    /// Run-out vectors of driver and driven gear over (y, z), m.
    pub(super) fn eccentric(&self, phases: &[ShaftPhase; 2], twist: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let out = self.run_out?;
        let at = |i: usize| {
            let (size, phase): (f64, f64) = out[i];
            let (sin, cos) = (phases[i].angle + twist[i] + phase).sin_cos();
            [size * cos, size * sin]
        };
        Some([at(0), at(1)])
    }

    /// Geometry of the moving centres; none in frozen geometry, which uses the centres at rest.
    #[inline(always)]
    pub(super) fn centre_geometry(
        &self,
        geometry: Geometry,
        relative_displacement: [f64; 2],
    ) -> Result<Option<CentreGeometry>, Overlap> {
        match geometry {
            Geometry::Live => self.involute.centre_geometry(relative_displacement).map(Some),
            Geometry::Frozen => Ok(None),
        }
    }

    /// The line of action. In frozen geometry it is the line at rest, with the deflection linear in the displacements.
    #[inline(always)]
    pub(super) fn line(
        &self,
        sigma: f64,
        centre_geometry: &Option<CentreGeometry>,
        relative_displacement: [f64; 2],
    ) -> LineOfAction {
        match centre_geometry {
            Some(centre_geometry) => self.involute.line(sigma, centre_geometry),
            None => {
                let line = self.at_rest[usize::from(sigma > 0.0)];
                LineOfAction { deflection: -dot(line.normal, relative_displacement), ..line }
            }
        }
    }

    /// The contact on the flanks of the contact mode.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub fn contact(&self, pose: &MeshPose<'_>, contact_mode: &ContactMode) -> Result<Contact, Overlap> {
        let &MeshPose { geometry, sigma, position, velocity, .. } = pose;
        if self.is_autonomous() && contact_mode.flank == Flank::Drive {
            let centre_geometry = self.centre_geometry(geometry, position.relative_displacement)?;
            let line = self.line(sigma, &centre_geometry, position.relative_displacement);
            let deflection = sigma * position.rolling_displacement + line.deflection;
            let rate = sigma * velocity.rolling_displacement - dot(line.normal, velocity.relative_displacement);
            let elastic = self.stiffness * deflection;
            let force = elastic + self.damping * rate;
            let [ra, rb] = self.involute.base_radius;
            return Ok(Contact {
                deflection,
                rate,
                force,
                stiffness: self.stiffness,
                energy: elastic * deflection / 2.0,
                centre_force: line.normal.map(|n| force * n),
                moments: [-force * sigma * ra, -force * sigma * rb],
                drive_power: 0.0,
                damping_power: self.damping * rate * rate,
                back_flank_deflection: self.back_flank_deflection(sigma, &centre_geometry, &position),
            });
        }
        let gears = self.gear_kinematics(pose)?;
        let drive = self.flank_contact(&gears, &self.flank_kinematics(&gears, false), contact_mode);
        let back_flank_deflection = || self.back_flank_deflection(sigma, &gears.centre_geometry, &gears.position);
        match contact_mode.flank {
            Flank::Drive => Ok(Contact { back_flank_deflection: back_flank_deflection(), ..drive }),
            Flank::Separated => Ok(Contact { back_flank_deflection: back_flank_deflection(), ..drive.separated() }),
            Flank::Back | Flank::Both => {
                let back = self.flank_contact(&gears, &self.flank_kinematics(&gears, true), contact_mode);
                let drive = if contact_mode.flank.drives() { drive } else { drive.separated() };
                Ok(drive.and_back(&back))
            }
        }
    }

    /// Relative displacement u_b − u_a of the centres of the base circles, m.
    fn relative_displacement(&self, phases: &[ShaftPhase; 2], position: &RelativeMotion) -> [f64; 2] {
        let relative_displacement = position.relative_displacement;
        match self.eccentric(phases, position.twist) {
            Some([ea, eb]) => [relative_displacement[0] + eb[0] - ea[0], relative_displacement[1] + eb[1] - ea[1]],
            None => relative_displacement,
        }
    }

    /// Adds the generalised forces of a contact to `out`.
    #[inline(always)]
    pub fn apply(&self, contact: &Contact, out: &mut [f64]) {
        if let Some([a, b]) = self.coordinates.translation {
            for i in 0..2 {
                out[a + i] -= contact.centre_force[i];
                out[b + i] += contact.centre_force[i];
            }
        }
        let [a, b] = self.coordinates.twist;
        out[a] += contact.moments[0];
        out[b] += contact.moments[1];
    }

    /// Calls `visit(index, ∂δ/∂q)` for each coordinate of the mesh; `normal` is the unit vector of the line of action.
    #[inline(always)]
    pub fn gradient(&self, sigma: f64, normal: [f64; 2], mut visit: impl FnMut(usize, f64)) {
        if let Some([a, b]) = self.coordinates.translation {
            visit(a, normal[0]);
            visit(a + 1, normal[1]);
            visit(b, -normal[0]);
            visit(b + 1, -normal[1]);
        }
        let [ra, rb] = self.involute.base_radius;
        let [a, b] = self.coordinates.twist;
        visit(a, sigma * ra);
        visit(b, sigma * rb);
    }

    /// The quantities that a response reports.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn state(&self, pose: &MeshPose<'_>, contact_mode: &ContactMode) -> Result<MeshState, Overlap> {
        let contact = self.contact(pose, contact_mode)?;
        let centres = self.reported_centres(pose.geometry, self.relative_displacement(pose.phases, &pose.position))?;
        let (first, last) =
            self.engagement(pose, !contact_mode.flank.drives() && contact_mode.flank.holds_back())?.engaged();
        let count = if contact_mode.flank == Flank::Separated { 0.0 } else { (last - first + 1).max(0) as f64 };
        Ok(MeshState {
            deflection: contact.deflection,
            force: contact.force,
            stiffness: contact.stiffness,
            pairs_in_contact: count,
            centres,
        })
    }
}

#[inline(always)]
pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
