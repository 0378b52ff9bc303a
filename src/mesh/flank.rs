//! Deflection and force of one flank of a mesh, and the contact mode that follows from both flanks.

use super::contact::{Contact, ContactMode, Flank};
use super::gear_mesh::{GearMesh, Geometry, MeshPose, RelativeMotion, dot};
use super::involute::{CentreGeometry, LineOfAction, Overlap};
use super::stiffness::{ContactPath, ElasticState};
use crate::scene::Phase;

/// Kinematics of the gears, shared by both flanks.
#[derive(Clone, Copy, Debug)]
pub(super) struct GearKinematics<'a> {
    pose: MeshPose<'a>,
    pub position: RelativeMotion,
    velocity: RelativeMotion,
    /// Run-out vectors of both gears, m, and the relative velocity of the centres that the spins cause, m/s.
    eccentric: Option<[[f64; 2]; 2]>,
    carried: [f64; 2],
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
    pub(super) fn approach<'a>(&self, pose: &MeshPose<'a>) -> Result<GearKinematics<'a>, Overlap> {
        let &MeshPose { geometry, turning, mut position, mut velocity, .. } = pose;
        let eccentric = self.eccentric(turning, position.twist);
        let mut carried = [0.0; 2];
        if let Some([ea, eb]) = eccentric {
            let [a, b] = velocity.twist;
            let (rate_a, rate_b) = (turning[0].spin + a, turning[1].spin + b);
            position.relative_displacement =
                [position.relative_displacement[0] + eb[0] - ea[0], position.relative_displacement[1] + eb[1] - ea[1]];
            velocity.relative_displacement[0] += rate_a * ea[1] - rate_b * eb[1];
            velocity.relative_displacement[1] += rate_b * eb[0] - rate_a * ea[0];
            let (spin_a, spin_b) = (turning[0].spin, turning[1].spin);
            carried = [spin_a * ea[1] - spin_b * eb[1], spin_b * eb[0] - spin_a * ea[0]];
        }
        let centre_geometry = self.centre_geometry(geometry, position.relative_displacement)?;
        Ok(GearKinematics { pose: *pose, position, velocity, eccentric, carried, centre_geometry })
    }

    /// Kinematics of the drive flank or of the back flank.
    #[inline(always)]
    pub(super) fn meet(&self, approach: &GearKinematics<'_>, back: bool) -> FlankKinematics {
        let GearKinematics { pose, position, velocity, centre_geometry, .. } = approach;
        let sigma = if back { -pose.sigma } else { pose.sigma };
        let line = self.line(sigma, centre_geometry, position.relative_displacement);
        let (error, error_rate) = match &self.error {
            Some(error) if !back => error.at(pose.turning),
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

    /// Evaluates the contact of one flank with tooth pairs, transmission error and run-out.
    pub(super) fn press(
        &self,
        approach: &GearKinematics<'_>,
        meeting: &FlankKinematics,
        contact_mode: &ContactMode,
    ) -> Contact {
        let GearKinematics { pose: MeshPose { geometry, turning, .. }, velocity, eccentric, carried, .. } = approach;
        let FlankKinematics { back, sigma, line, deflection, rate, error_rate } = *meeting;
        let path = || self.path_of(&approach.pose, meeting);
        let ElasticState { energy, force: elastic, stiffness, by_position, by_tangent } =
            self.teeth.elastic_state(path, contact_mode.engaged[usize::from(back)], deflection);
        let force = elastic + self.damping * rate;
        let [ra, rb] = self.involute.base_radius;
        let mut push = line.normal.map(|n| force * n);
        let mut moments = [-force * sigma * ra, -force * sigma * rb];
        // Power of the prescribed motion: transmission error, teeth moving along the path, and run-out turning with the
        // shafts.
        let mut drive_power = -force * error_rate + by_position * ra * sigma * turning[0].spin;
        let steeper = self.involute.base_circles() / line.tangent;
        match self.phase {
            Phase::Twist => {
                moments[0] -= by_position * ra * sigma;
                if *geometry == Geometry::Live {
                    for ((push, normal), tangent_direction) in
                        push.iter_mut().zip(line.normal).zip(line.tangent_direction)
                    {
                        *push -= by_position * ra * tangent_direction / line.tangent
                            + by_tangent * (normal + tangent_direction * steeper);
                    }
                }
            }
            Phase::Prescribed if *geometry == Geometry::Live => {
                let (along, tangent_direction) = (
                    dot(line.normal, velocity.relative_displacement),
                    dot(line.tangent_direction, velocity.relative_displacement),
                );
                drive_power += by_position * ra * tangent_direction / line.tangent
                    + by_tangent * (along + tangent_direction * steeper);
            }
            Phase::Prescribed => {}
        }
        if let Some([ea, eb]) = eccentric {
            moments[0] += push[0] * ea[1] - push[1] * ea[0];
            moments[1] += push[1] * eb[0] - push[0] * eb[1];
            drive_power -= dot(push, *carried);
        }
        let damping_power = self.damping * rate * rate;
        let back_flank_deflection = f64::NEG_INFINITY;
        Contact {
            deflection,
            rate,
            force,
            stiffness,
            energy,
            push,
            moments,
            drive_power,
            damping_power,
            back_flank_deflection,
        }
    }

    /// Position of the tooth pairs of a flank on the path of contact.
    pub(super) fn path(&self, sigma: f64, back: bool, line: &LineOfAction, angle: f64, twist: f64) -> ContactPath {
        let turned = match self.phase {
            Phase::Twist => angle + twist,
            Phase::Prescribed => angle,
        };
        let pressure_angle = self.involute.pressure_angle_at_rest() + line.steeper;
        let centres = self.involute.angle_at_rest() + line.turned;
        // Backlash makes the teeth thinner by about a hundredth of the pitch; how it divides between the gears is unknown,
        // so it is neglected here.
        let back_flank_deflection = if back { self.involute.base_thickness } else { 0.0 };
        let position = self.involute.position(sigma, turned, centres, pressure_angle) + back_flank_deflection;
        ContactPath { position, ..self.involute.path(line.tangent) }
    }

    /// Position of the tooth pairs of a flank with known kinematics.
    fn path_of(&self, pose: &MeshPose<'_>, meeting: &FlankKinematics) -> ContactPath {
        self.path(meeting.sigma, meeting.back, &meeting.line, pose.turning[0].angle, pose.position.twist[0])
    }

    /// Position of the tooth pairs of the drive flank or of the back flank on the path of contact.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn engagement(&self, pose: &MeshPose<'_>, back: bool) -> Result<ContactPath, Overlap> {
        let approach = self.approach(pose)?;
        Ok(self.path_of(pose, &self.meet(&approach, back)))
    }

    /// The contact mode: the pressed flanks, and the tooth pairs on the path of contact.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn contact_mode(&self, pose: &MeshPose<'_>) -> Result<ContactMode, Overlap> {
        let approach = self.approach(pose)?;
        let engaged = |meeting: &FlankKinematics| {
            if self.teeth.is_sharp() { self.path_of(pose, meeting).engaged() } else { (0, 0) }
        };
        let drive = self.meet(&approach, false);
        if self.backlash.is_none() {
            return Ok(ContactMode { flank: Flank::Drive, engaged: [engaged(&drive), (0, 0)] });
        }
        let back = self.meet(&approach, true);
        let contact_mode = ContactMode { flank: Flank::Both, engaged: [engaged(&drive), engaged(&back)] };
        let presses = |meeting: &FlankKinematics| {
            meeting.deflection > 0.0 && self.press(&approach, meeting, &contact_mode).force > 0.0
        };
        Ok(ContactMode { flank: Flank::of(presses(&drive), presses(&back)), ..contact_mode })
    }
}
