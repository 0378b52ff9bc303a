//! The force of a mesh: one scalar that acts on six coordinates, and on six more with helical teeth (`helix.rs`).
//!
//! ```text
//! F = ∂U/∂δ + c δ̇,    generalised force on q:  −F ∂δ/∂q,    ∂δ/∂q = (n, −n, σr_a, σr_b) for q = (u_a, u_b, θ_a, θ_b)
//! ```
//!
//! U is ½kδ² for a mean stiffness k, otherwise the sum over the tooth pairs. Modes, static equilibrium and motion use the
//! same force. With a carrier that turns, θ_a and θ_b are relative to its twist. Live geometry takes n from the moving centres; with constant k the force then derives from ½kδ², and an
//! undamped scene conserves its energy. Frozen geometry keeps n of the centres at rest, so that the force is linear. A
//! stiffness that depends on the displacements adds its own −∂U/∂q.
//!
//! With backlash, F acts on the drive flank while this flank is pressed, and on the back flank (σ → −σ, deflection
//! minus backlash) while the back flank is pressed. Otherwise F is zero, so that F is never tensile, or with
//! `damping_in_separation` it is c δ̇ of the drive flank. `flank.rs` computes the force of one flank.

use num_complex::Complex64;

use super::contact::{Contact, ContactMode, Flank, HelixForces, MeshState, ShaftPhase};
use super::error::ErrorCurve;
use super::friction::Friction;
use super::helix::Helix;
use super::involute::{CentreGeometry, Centres, Involute, LineOfAction, Overlap};
use super::pose::{Directions, Geometry, MeshCoordinates, MeshPose, RelativeMotion, dot};
use super::stiffness::{self, Stiffness};
use crate::numerics::ROUND_OFF;
use crate::scene::{Damping, Gear, Mesh, Phase};

/// A mesh with its coordinates.
#[derive(Clone, Debug)]
pub struct GearMesh {
    /// Geometry of the pair.
    pub involute: Involute,
    /// The coordinates.
    pub coordinates: MeshCoordinates,
    /// Axial displacements and tilts; none for spur gears, and without axial motion.
    pub helix: Option<Helix>,
    /// Cosine of the base helix angle β_b; 1 for spur gears.
    pub base_helix_cosine: f64,
    /// Stiffness of the teeth.
    pub teeth: Stiffness,
    /// Angle that moves the teeth along the path of contact: the prescribed angle, with or without the twist.
    pub phase: Phase,
    /// Mean stiffness in the transverse section, N/m, used by modes, equilibrium and all linear analyses.
    pub stiffness: f64,
    /// Upper bound of the stiffness, N/m.
    pub largest_stiffness: f64,
    /// Damping c, N s/m.
    pub damping: f64,
    /// Whether the damping acts in separation too. The deflection alone then decides on contact.
    pub damping_in_separation: bool,
    /// Loss factor η of the stiffness, which analyses in the frequency domain contain.
    pub loss_factor: f64,
    /// Backlash along the line of action in the transverse section, m; none for a mesh whose flanks never separate.
    pub backlash: Option<f64>,
    /// Shafts of driver and driven gear; the spin of the first, relative to the carrier, gives σ.
    pub shafts: [usize; 2],
    /// Shaft of the carrier, to which angles and spins are relative; none for gears on fixed axes.
    pub carrier: Option<usize>,
    /// Change of the vector between the centres per twist of the carrier, m/rad; zero if planets do not move laterally.
    arc: [f64; 2],
    /// Friction between the flanks.
    pub friction: Option<Box<Friction>>,
    pub(super) error: Option<ErrorCurve>,
    /// Run-out of driver and driven gear: amplitude, m, and angle in the shaft, rad; none if neither gear has run-out.
    runout: Option<[(f64, f64); 2]>,
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
        let (base_helix, base_helix_cosine) = (a.base_helix_angle(), a.base_helix_angle().cos());
        let damping = match mesh.damping {
            Damping::Constant(c) => c * base_helix_cosine * base_helix_cosine,
            Damping::Ratio(ratio) => {
                let compliance = |gear: &Gear| gear.base_radius * gear.base_radius / gear.body.polar_inertia;
                2.0 * ratio * (mean / (compliance(a) + compliance(b))).sqrt()
            }
        };
        // Both flanks are in contact if the centre distance shrinks by more than the backlash allows.
        let flanks = if mesh.teeth.backlash.is_some() { 2.0 } else { 1.0 };
        let helix = |axial: [usize; 2], v: [usize; 2]| Helix::new(&involute, base_helix.tan(), axial, v);
        let helical = if base_helix == 0.0 { None } else { coordinates.axial.zip(coordinates.translation) };
        let friction = mesh.teeth.friction.as_ref();
        let friction = friction.map(|given| Box::new(Friction::new(given, [a, b], &involute, &teeth)));
        let out = [a, b].map(|gear| (gear.runout.norm(), gear.runout.arg()));
        let is_carried = coordinates.carrier.is_some() && coordinates.translation.is_some();
        let [y, z] = involute.centres_at_rest();
        Self {
            arc: if is_carried { [-z, y] } else { [0.0; 2] },
            at_rest: [-1.0, 1.0].map(|sigma| involute.line_at_rest(sigma)),
            coordinates,
            helix: helical.map(|(axial, translation)| helix(axial, translation)),
            base_helix_cosine,
            stiffness: mean,
            largest_stiffness: flanks * teeth.largest(&at_rest).max(mean),
            involute,
            teeth,
            phase: mesh.teeth.phase,
            damping,
            damping_in_separation: mesh.damping_in_separation,
            loss_factor: mesh.loss_factor,
            backlash: mesh.teeth.backlash.map(|backlash| backlash / base_helix_cosine),
            shafts: [a.body.node.shaft, b.body.node.shaft],
            carrier: mesh.carrier.map(|node| node.shaft),
            friction,
            error: mesh.teeth.error.as_ref().map(|error| ErrorCurve::new(error, a.teeth)),
            runout: out.iter().any(|(size, _)| *size > 0.0).then_some(out),
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
        let friction_varies = self.friction.as_ref().is_some_and(|friction| friction.follows_pairs());
        !self.teeth.is_piecewise_constant() || self.error.is_some() || friction_varies
    }

    /// Whether the tooth engagement depends on the motion, by the twist or by run-out.
    pub fn engagement_follows_motion(&self) -> bool {
        self.phase == Phase::Twist || self.runout.is_some()
    }

    /// Whether a gear has run-out.
    pub fn has_runout(&self) -> bool {
        self.runout.is_some()
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
        let MeshCoordinates { translation, twist, carrier, .. } = self.coordinates;
        let of_helix = |helix: &Helix| helix.axial.into_iter().chain(helix.tilt.into_iter().flat_map(|v| [v, v + 1]));
        let of_plane = translation.into_iter().flatten().flat_map(|v| [v, v + 1]);
        twist.into_iter().chain(carrier).chain(of_plane).chain(self.helix.iter().flat_map(of_helix)).collect()
    }

    /// Whether the force acts along the line of action and does not depend on the angles of the shafts.
    fn is_autonomous(&self) -> bool {
        self.teeth.is_constant() && self.error.is_none() && self.runout.is_none() && self.friction.is_none()
    }

    /// Vector per twist of the carrier that [`Self::relative`] subtracts from the displacement of the centres, m/rad.
    pub fn arc(&self) -> [f64; 2] {
        self.arc
    }

    /// Relative motion of the gears for displacements or velocities of the whole model, relative to the twist of the carrier. It
    /// is without the product τ·c of helical teeth, which [`Self::pose`] adds.
    #[inline(always)]
    pub fn relative(&self, q: &[f64]) -> RelativeMotion {
        let [ra, rb] = self.involute.base_radius;
        let carrier = self.coordinates.carrier.map_or(0.0, |index| q[index]);
        let twist = self.coordinates.twist.map(|index| q[index] - carrier);
        let relative_displacement = match self.coordinates.translation {
            Some([a, b]) => [0, 1].map(|lane| q[b + lane] - q[a + lane] - carrier * self.arc[lane]),
            None => [0.0; 2],
        };
        let rolling_displacement = ra * twist[0] + rb * twist[1];
        match &self.helix {
            None => RelativeMotion { relative_displacement, rolling_displacement, twist, tilt: [0.0; 2] },
            Some(helix) => {
                let (along, tilt) = helix.relative(q);
                RelativeMotion {
                    relative_displacement,
                    rolling_displacement: rolling_displacement + along,
                    twist,
                    tilt,
                }
            }
        }
    }

    /// As [`Self::relative`] for displacements, with the product τ·c of helical teeth in the rolling displacement.
    pub(super) fn position(&self, geometry: Geometry, q: &[f64]) -> RelativeMotion {
        let mut position = self.relative(q);
        if let Some(helix) = &self.helix {
            helix.add_tilt_product(geometry, &mut position);
        }
        position
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
        self.pose_of(geometry, sigma, phases, self.relative(q), self.relative(v))
    }

    /// The pose for relative displacements and velocities without the product τ·c.
    #[inline(always)]
    pub fn pose_of<'a>(
        &self,
        geometry: Geometry,
        sigma: f64,
        phases: &'a [ShaftPhase; 2],
        mut position: RelativeMotion,
        mut velocity: RelativeMotion,
    ) -> MeshPose<'a> {
        if let Some(helix) = &self.helix {
            helix.add_tilt_rate(geometry, &position, &mut velocity);
            helix.add_tilt_product(geometry, &mut position);
        }
        MeshPose { geometry, sigma, phases, position, velocity }
    }

    /// Run-out vectors of driver and driven gear over (y, z), m.
    pub(super) fn eccentric(&self, phases: &[ShaftPhase; 2], twist: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let out = self.runout?;
        let at = |i: usize| {
            let (size, phase): (f64, f64) = out[i];
            let (sin, cos) = (phases[i].angle + twist[i] + phase).sin_cos();
            [size * cos, size * sin]
        };
        Some([at(0), at(1)])
    }

    /// Phasor of the transmission error that turns once with a shaft, m: run-out of its gear, which the line of action at rest
    /// sees, and the first harmonic of the error of this shaft.
    pub fn turning_error(&self, sigma: f64, shaft: usize) -> Complex64 {
        let [y, z] = self.at_rest[usize::from(sigma > 0.0)].normal;
        let of_gear = |i: usize, sign: f64| {
            let eccentric = self.runout.map_or(Complex64::ZERO, |out| Complex64::from_polar(out[i].0, out[i].1));
            let first = self.error.as_ref().map_or(Complex64::ZERO, |error| error.first_of_shaft(i));
            // The run-out over (y, z) is Re((e, −ie) e^{iϑ}).
            sign * eccentric * Complex64::new(y, -z) + first
        };
        let signs = [-1.0, 1.0];
        (0..2).filter(|i| self.shafts[*i] == shaft).map(|i| of_gear(i, signs[i])).sum()
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
        Ok(self.with_helix(pose, self.transverse_contact(pose, contact_mode)?))
    }

    /// The contact with the axial force and the tilting moments of helical teeth.
    #[inline(always)]
    fn with_helix(&self, pose: &MeshPose<'_>, contact: Contact) -> Contact {
        let Some(helix) = &self.helix else { return contact };
        // The flanks have opposite σ, which the sign of the force contains.
        let forces = helix.forces(pose.geometry, &pose.position, -pose.sigma * contact.force);
        let [y, z] = contact.centre_force;
        let centre_force = [y + forces.centre[0], z + forces.centre[1]];
        Contact { centre_force, helix: forces, ..contact }
    }

    /// The contact as a function of the rolling displacement and of the centres.
    #[inline(always)]
    fn transverse_contact(&self, pose: &MeshPose<'_>, contact_mode: &ContactMode) -> Result<Contact, Overlap> {
        if self.is_autonomous() && contact_mode.flank == Flank::Drive {
            let &MeshPose { geometry, sigma, position, velocity, .. } = pose;
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
                helix: HelixForces::default(),
                resistance: 0.0,
            });
        }
        Ok(self.contact_of(&self.gear_kinematics(pose)?, contact_mode))
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
        if let Some(carrier) = self.coordinates.carrier {
            out[carrier] -= contact.moments[0] + contact.moments[1] + dot(contact.centre_force, self.arc);
        }
        if let Some(helix) = &self.helix {
            helix.apply(&contact.helix, out);
        }
        if let Some(friction) = &self.friction {
            friction.rotation.iter().for_each(|(index, share)| out[*index] -= share * contact.resistance);
        }
    }

    /// Calls `visit(index, ∂δ/∂q)` for each coordinate of the mesh.
    #[inline(always)]
    pub fn gradient(&self, sigma: f64, directions: &Directions, mut visit: impl FnMut(usize, f64)) {
        let Directions { normal, centres } = *directions;
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
        if let Some(carrier) = self.coordinates.carrier {
            let slope = dot(normal, self.arc) - sigma * (ra + rb);
            // A twist of the carrier turns centres at rest with their line of action.
            if slope.abs() > ROUND_OFF * (ra.abs() + rb.abs()) {
                visit(carrier, slope);
            }
        }
        if let Some(helix) = &self.helix {
            helix.gradient(centres, |index, slope| visit(index, sigma * slope));
        }
    }

    /// The state in the direction normal to the teeth, from that of the transverse section.
    pub(super) fn normal_to_teeth(&self, state: MeshState) -> MeshState {
        let cosine = self.base_helix_cosine;
        MeshState {
            deflection: state.deflection * cosine,
            force: state.force / cosine,
            stiffness: state.stiffness / (cosine * cosine),
            ..state
        }
    }

    /// Mean stiffness in the direction normal to the teeth, N/m.
    pub fn normal_stiffness(&self) -> f64 {
        self.stiffness / (self.base_helix_cosine * self.base_helix_cosine)
    }

    /// The quantities that a response reports.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn state(&self, pose: &MeshPose<'_>, contact_mode: &ContactMode) -> Result<MeshState, Overlap> {
        let gears = self.gear_kinematics(pose)?;
        let contact = if self.is_autonomous() {
            self.contact(pose, contact_mode)?
        } else {
            self.with_helix(pose, self.contact_of(&gears, contact_mode))
        };
        let centres = self.reported_centres(pose.geometry, self.relative_displacement(pose.phases, &pose.position))?;
        let (first, last) = self.engagement_of(&gears, contact_mode.flank == Flank::Back).engaged();
        let [friction_force, friction_power] = self.friction_of(&gears, contact_mode);
        let count = if contact_mode.flank == Flank::Separated { 0.0 } else { (last - first + 1).max(0) as f64 };
        Ok(self.normal_to_teeth(MeshState {
            deflection: contact.deflection,
            force: contact.force,
            stiffness: contact.stiffness,
            pairs_in_contact: count,
            thrust: contact.helix.axial,
            friction_force,
            friction_power,
            centres,
        }))
    }
}
