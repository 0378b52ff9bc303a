//! Deflection and force of one flank of a mesh, and the contact mode that follows from both flanks.

use super::contact::{Contact, ContactMode, Flank, HelixForces};
use super::contact_path::ContactPath;
use super::friction::{FrictionForce, FrictionSums};
use super::gear_mesh::GearMesh;
use super::involute::{CentreGeometry, LineOfAction, Overlap};
use super::pose::{Geometry, MeshPose, RelativeMotion, dot};
use super::stiffness::ElasticState;
use crate::scene::Phase;

/// Kinematics of the gears, shared by both flanks.
#[derive(Clone, Copy, Debug)]
pub(super) struct GearKinematics<'a> {
    pub pose: &'a MeshPose<'a>,
    pub position: RelativeMotion,
    velocity: RelativeMotion,
    /// Run-out vectors of both gears, m, and the relative velocity of the centres that the spins cause, m/s.
    eccentric: Option<[[f64; 2]; 2]>,
    runout_velocity: [f64; 2],
    pub centre_geometry: Option<CentreGeometry>,
}

/// Kinematics of one flank.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlankKinematics {
    back: bool,
    sigma: f64,
    line: LineOfAction,
    /// Deflection δ, m, and its rate, m/s; the flank is separated if δ ≤ 0.
    deflection: f64,
    rate: f64,
    error_rate: f64,
}

impl GearMesh {
    /// Kinematics of the gears.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub(super) fn gear_kinematics<'a>(&self, pose: &'a MeshPose<'a>) -> Result<GearKinematics<'a>, Overlap> {
        let &MeshPose { geometry, phases, mut position, mut velocity, .. } = pose;
        let eccentric = self.eccentric(phases, position.twist);
        let mut runout_velocity = [0.0; 2];
        if let Some([ea, eb]) = eccentric {
            let [a, b] = velocity.twist;
            let (rate_a, rate_b) = (phases[0].spin + a, phases[1].spin + b);
            position.relative_displacement =
                [position.relative_displacement[0] + eb[0] - ea[0], position.relative_displacement[1] + eb[1] - ea[1]];
            velocity.relative_displacement[0] += rate_a * ea[1] - rate_b * eb[1];
            velocity.relative_displacement[1] += rate_b * eb[0] - rate_a * ea[0];
            let (spin_a, spin_b) = (phases[0].spin, phases[1].spin);
            runout_velocity = [spin_a * ea[1] - spin_b * eb[1], spin_b * eb[0] - spin_a * ea[0]];
        }
        let centre_geometry = self.centre_geometry(geometry, position.relative_displacement)?;
        Ok(GearKinematics { pose, position, velocity, eccentric, runout_velocity, centre_geometry })
    }

    /// Kinematics of the drive flank or of the back flank.
    #[inline(always)]
    pub(super) fn flank_kinematics(&self, gears: &GearKinematics<'_>, back: bool) -> FlankKinematics {
        let GearKinematics { pose, position, velocity, centre_geometry, .. } = gears;
        let sigma = if back { -pose.sigma } else { pose.sigma };
        let line = self.line(sigma, centre_geometry, position.relative_displacement);
        let (error, error_rate) = match &self.error {
            Some(error) if !back => error.at(pose.phases),
            _ => (0.0, 0.0),
        };
        let clearance = if back { self.backlash.unwrap_or(0.0) } else { error };
        let deflection = sigma * position.rolling_displacement + line.deflection - clearance;
        let rate =
            sigma * velocity.rolling_displacement - dot(line.normal, velocity.relative_displacement) - error_rate;
        FlankKinematics { back, sigma, line, deflection, rate, error_rate }
    }

    /// Deflection of the back flank, m; −∞ without backlash.
    #[inline(always)]
    pub(super) fn back_flank_deflection(
        &self,
        sigma: f64,
        centre_geometry: &Option<CentreGeometry>,
        position: &RelativeMotion,
    ) -> f64 {
        let clear = |backlash: f64| {
            -sigma * position.rolling_displacement
                + self.line(-sigma, centre_geometry, position.relative_displacement).deflection
                - backlash
        };
        self.backlash.map_or(f64::NEG_INFINITY, clear)
    }

    /// The contact of the pressed flanks.
    #[inline(always)]
    pub(super) fn contact_of(&self, gears: &GearKinematics<'_>, contact_mode: &ContactMode) -> Contact {
        let flank = self.flank_kinematics(gears, false);
        let drive = self.flank_contact(gears, &flank, contact_mode);
        let back_flank_deflection =
            || self.back_flank_deflection(gears.pose.sigma, &gears.centre_geometry, &gears.position);
        match contact_mode.flank {
            Flank::Drive => Contact { back_flank_deflection: back_flank_deflection(), ..drive },
            Flank::Separated => self.separated_contact(gears, &flank, &drive),
            Flank::Back | Flank::Both => {
                let back = self.flank_contact(gears, &self.flank_kinematics(gears, true), contact_mode);
                let drive = if contact_mode.flank.drives() { drive } else { drive.separated() };
                drive.and_back(&back)
            }
        }
    }

    /// Evaluates the contact of one flank with tooth pairs, transmission error and run-out.
    pub(super) fn flank_contact(
        &self,
        gears: &GearKinematics<'_>,
        flank: &FlankKinematics,
        contact_mode: &ContactMode,
    ) -> Contact {
        let path = || self.path_of(gears.pose, flank);
        let engaged = contact_mode.engaged[usize::from(flank.back)];
        let state = self.teeth.elastic_state(path, engaged, flank.deflection);
        let sums = self.friction.as_ref().map(|friction| friction.sums(&self.teeth, path, engaged, flank.deflection));
        self.flank_force(gears, flank, state, sums)
    }

    /// Friction of the flanks in contact on the driven gear, N, and the power that it dissipates, W.
    pub(super) fn friction_of(&self, gears: &GearKinematics<'_>, contact_mode: &ContactMode) -> [f64; 2] {
        let Some(friction) = &self.friction else { return [0.0; 2] };
        let mut sum = [0.0; 2];
        for back in [false, true] {
            let is_loaded = if back { contact_mode.flank.holds_back() } else { contact_mode.flank.drives() };
            if is_loaded {
                let flank = self.flank_kinematics(gears, back);
                let path = || self.path_of(gears.pose, &flank);
                let engaged = contact_mode.engaged[usize::from(back)];
                let state = self.teeth.elastic_state(path, engaged, flank.deflection);
                let sums = friction.sums(&self.teeth, path, engaged, flank.deflection);
                let contact = self.flank_force(gears, &flank, state, Some(sums));
                let own = friction.force(flank.sigma, &flank.line, gears.pose.phases, contact.force, &sums);
                sum[0] += own.force;
                sum[1] += contact.damping_power - self.damping * contact.rate * contact.rate;
            }
        }
        sum
    }

    /// The contact with separated flanks, from that of the drive flank: no force, or that of the damping.
    pub(super) fn separated_contact(
        &self,
        gears: &GearKinematics<'_>,
        flank: &FlankKinematics,
        drive: &Contact,
    ) -> Contact {
        let contact = if self.damping_in_separation {
            self.flank_force(gears, flank, ElasticState::default(), None)
        } else {
            drive.separated()
        };
        let position = &gears.position;
        let back_flank_deflection = self.back_flank_deflection(flank.sigma, &gears.centre_geometry, position);
        Contact { back_flank_deflection, ..contact }
    }

    /// Evaluates the contact of one flank with the elastic `state` of its teeth and the `sums` of its friction.
    #[inline(always)]
    fn flank_force(
        &self,
        gears: &GearKinematics<'_>,
        flank: &FlankKinematics,
        state: ElasticState,
        sums: Option<FrictionSums>,
    ) -> Contact {
        let GearKinematics { pose: MeshPose { geometry, phases, .. }, velocity, eccentric, runout_velocity, .. } =
            gears;
        let FlankKinematics { sigma, line, deflection, rate, error_rate, .. } = *flank;
        let ElasticState { energy, force: elastic, stiffness, by_position, by_tangent } = state;
        let force = elastic + self.damping * rate;
        let [ra, rb] = self.involute.base_radius;
        let mut centre_force = line.normal.map(|n| force * n);
        let mut moments = [-force * sigma * ra, -force * sigma * rb];
        // Power of the prescribed motion: transmission error, teeth moving along the path, and run-out that rotates with the
        // shafts.
        let mut drive_power = -force * error_rate + by_position * ra * sigma * phases[0].spin;
        let mut damping_power = self.damping * rate * rate;
        let mut resistance = 0.0;
        let steeper = self.involute.base_circles() / line.tangent;
        match self.phase {
            Phase::Twist => {
                moments[0] -= by_position * ra * sigma;
                if *geometry == Geometry::Live {
                    for ((centre_force, normal), tangent_direction) in
                        centre_force.iter_mut().zip(line.normal).zip(line.tangent_direction)
                    {
                        *centre_force -= by_position * ra * tangent_direction / line.tangent
                            + by_tangent * (normal + tangent_direction * steeper);
                    }
                }
            }
            Phase::Prescribed if *geometry == Geometry::Live => {
                drive_power += self.centre_power(&line, velocity, &state);
            }
            Phase::Prescribed => {}
        }
        if let (Some(friction), Some(sums)) = (&self.friction, sums) {
            let FrictionForce { force: across, moments: [a, b] } = friction.force(sigma, &line, phases, force, &sums);
            for (centre_force, direction) in centre_force.iter_mut().zip(line.tangent_direction) {
                *centre_force += across * direction;
            }
            moments = [moments[0] + a, moments[1] + b];
            // The drive keeps the prescribed spins against the moments. The sliding velocity contains all velocities.
            let prescribed = -(a * phases[0].spin + b * phases[1].spin);
            drive_power += prescribed;
            damping_power += prescribed
                - a * velocity.twist[0]
                - b * velocity.twist[1]
                - across * dot(line.tangent_direction, velocity.relative_displacement);
            resistance = a - b * ra / rb;
        }
        if let Some([ea, eb]) = eccentric {
            moments[0] += centre_force[0] * ea[1] - centre_force[1] * ea[0];
            moments[1] += centre_force[1] * eb[0] - centre_force[0] * eb[1];
            drive_power -= dot(centre_force, *runout_velocity);
        }
        let back_flank_deflection = f64::NEG_INFINITY;
        Contact {
            deflection,
            rate,
            force,
            stiffness,
            energy,
            centre_force,
            moments,
            helix: HelixForces::default(),
            drive_power,
            damping_power,
            back_flank_deflection,
            resistance,
        }
    }

    /// Power of the prescribed motion, W, where the moving centres shift the tooth pairs along the path of contact and
    /// change the length of the line of action.
    fn centre_power(&self, line: &LineOfAction, velocity: &RelativeMotion, state: &ElasticState) -> f64 {
        let ElasticState { by_position, by_tangent, .. } = state;
        let along = dot(line.normal, velocity.relative_displacement);
        let across = dot(line.tangent_direction, velocity.relative_displacement);
        by_position * self.involute.base_radius[0] * across / line.tangent
            + by_tangent * (along + across * (self.involute.base_circles() / line.tangent))
    }

    /// Position of the tooth pairs of a flank on the path of contact.
    pub(super) fn path(&self, sigma: f64, back: bool, line: &LineOfAction, angle: f64, twist: f64) -> ContactPath {
        let driver_angle = match self.phase {
            Phase::Twist => angle + twist,
            Phase::Prescribed => angle,
        };
        let pressure_angle = self.involute.pressure_angle_at_rest() + line.pressure_angle_change;
        let centres = self.involute.angle_at_rest() + line.rotation;
        // Backlash makes the teeth thinner by about a hundredth of the pitch; how it divides between the gears is unknown,
        // so it is neglected here.
        let tooth_thickness = if back { self.involute.base_thickness } else { 0.0 };
        let position = self.involute.position(sigma, driver_angle, centres, pressure_angle) + tooth_thickness;
        ContactPath { position, ..self.involute.path(line.tangent) }
    }

    /// Position of the tooth pairs of a flank with known kinematics.
    fn path_of(&self, pose: &MeshPose<'_>, flank: &FlankKinematics) -> ContactPath {
        self.path(flank.sigma, flank.back, &flank.line, pose.phases[0].angle, pose.position.twist[0])
    }

    /// Position of the tooth pairs of the drive flank or of the back flank on the path of contact.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn engagement(&self, pose: &MeshPose<'_>, back: bool) -> Result<ContactPath, Overlap> {
        Ok(self.engagement_of(&self.gear_kinematics(pose)?, back))
    }

    /// The same with known kinematics.
    pub(super) fn engagement_of(&self, gears: &GearKinematics<'_>, back: bool) -> ContactPath {
        self.path_of(gears.pose, &self.flank_kinematics(gears, back))
    }

    /// The contact mode: the pressed flanks, and the tooth pairs on the path of contact.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn contact_mode(&self, pose: &MeshPose<'_>) -> Result<ContactMode, Overlap> {
        let gears = self.gear_kinematics(pose)?;
        let engaged = |flank: &FlankKinematics| {
            if self.teeth.is_sharp() { self.path_of(pose, flank).engaged() } else { (0, 0) }
        };
        let drive = self.flank_kinematics(&gears, false);
        if self.backlash.is_none() {
            return Ok(ContactMode { flank: Flank::Drive, engaged: [engaged(&drive), (0, 0)] });
        }
        let back = self.flank_kinematics(&gears, true);
        let contact_mode = ContactMode { flank: Flank::Both, engaged: [engaged(&drive), engaged(&back)] };
        let pushes = |flank: &FlankKinematics| self.flank_contact(&gears, flank, &contact_mode).force > 0.0;
        let presses = |flank: &FlankKinematics| flank.deflection > 0.0 && (self.damping_in_separation || pushes(flank));
        Ok(ContactMode { flank: Flank::of(presses(&drive), presses(&back)), ..contact_mode })
    }
}
