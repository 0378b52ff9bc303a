//! One flank of a mesh: how far it is pressed in, what its tooth pairs store, and the law that follows from both flanks.

use super::contact::{Contact, Flank, Law};
use super::coupling::{Coupling, Geometry, Pose, Relative, dot};
use super::involute::{Lie, LineOfAction, Overlap};
use super::stiffness::{Path, Stored};
use crate::scene::Phase;

/// How the gears approach each other: what both flanks have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach<'a> {
    pose: Pose<'a>,
    pub position: Relative,
    velocity: Relative,
    /// Where the base circles stand off their shafts, m, and the velocity that the spins give them, m/s.
    eccentric: Option<[[f64; 2]; 2]>,
    carried: [f64; 2],
    pub lie: Option<Lie>,
}

/// How the teeth of one flank meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    back: bool,
    sigma: f64,
    line: LineOfAction,
    /// δ, m, and its rate, m/s; at or below zero the flank is clear.
    deflection: f64,
    rate: f64,
    error_rate: f64,
}

impl Coupling {
    /// How the gears approach each other.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub(super) fn approach<'a>(&self, pose: &Pose<'a>) -> Result<Approach<'a>, Overlap> {
        let &Pose { geometry, turning, mut position, mut velocity, .. } = pose;
        let eccentric = self.eccentric(turning, position.twist);
        let mut carried = [0.0; 2];
        if let Some([ea, eb]) = eccentric {
            let [a, b] = velocity.twist;
            let (rate_a, rate_b) = (turning[0].spin + a, turning[1].spin + b);
            position.apart = [position.apart[0] + eb[0] - ea[0], position.apart[1] + eb[1] - ea[1]];
            velocity.apart[0] += rate_a * ea[1] - rate_b * eb[1];
            velocity.apart[1] += rate_b * eb[0] - rate_a * ea[0];
            let (spin_a, spin_b) = (turning[0].spin, turning[1].spin);
            carried = [spin_a * ea[1] - spin_b * eb[1], spin_b * eb[0] - spin_a * ea[0]];
        }
        let lie = self.lie(geometry, position.apart)?;
        Ok(Approach { pose: *pose, position, velocity, eccentric, carried, lie })
    }

    /// How the teeth of the drive flank meet, or those of the back flank.
    #[inline(always)]
    pub(super) fn meet(&self, approach: &Approach<'_>, back: bool) -> Meeting {
        let Approach { pose, position, velocity, lie, .. } = approach;
        let sigma = if back { -pose.sigma } else { pose.sigma };
        let line = self.line(sigma, lie, position.apart);
        let (error, error_rate) = match &self.error {
            Some(error) if !back => error.at(pose.turning),
            _ => (0.0, 0.0),
        };
        let clearance = if back { self.backlash.unwrap_or(0.0) } else { error };
        let deflection = sigma * position.rolled + line.deflection - clearance;
        let rate = sigma * velocity.rolled - dot(line.normal, velocity.apart) - error_rate;
        Meeting { back, sigma, line, deflection, rate, error_rate }
    }

    /// Deflection of the back flank, m; −∞ where flanks never part.
    #[inline(always)]
    pub(super) fn behind(&self, sigma: f64, lie: &Option<Lie>, position: &Relative) -> f64 {
        let clear =
            |backlash: f64| -sigma * position.rolled + self.line(-sigma, lie, position.apart).deflection - backlash;
        self.backlash.map_or(f64::NEG_INFINITY, clear)
    }

    /// The contact of one flank: tooth pairs, error and run-out.
    pub(super) fn press(&self, approach: &Approach<'_>, meeting: &Meeting, law: &Law) -> Contact {
        let Approach { pose: Pose { geometry, turning, .. }, velocity, eccentric, carried, .. } = approach;
        let Meeting { back, sigma, line, deflection, rate, error_rate } = *meeting;
        let path = || self.path_of(&approach.pose, meeting);
        let Stored { energy, force: elastic, stiffness, travel, shortening } =
            self.teeth.stored(path, law.engaged[usize::from(back)], deflection);
        let force = elastic + self.damping * rate;
        let [ra, rb] = self.involute.base_radius;
        let mut push = line.normal.map(|n| force * n);
        let mut moments = [-force * sigma * ra, -force * sigma * rb];
        // Power of what is prescribed: the error, and the spin that carries teeth along the path and eccentric gears.
        let mut drive_power = -force * error_rate + travel * ra * sigma * turning[0].spin;
        let steeper = self.involute.base_circles() / line.tangent;
        match self.phase {
            Phase::Twist => {
                moments[0] -= travel * ra * sigma;
                if *geometry == Geometry::Live {
                    for ((push, normal), across) in push.iter_mut().zip(line.normal).zip(line.across) {
                        *push -= travel * ra * across / line.tangent + shortening * (normal + across * steeper);
                    }
                }
            }
            Phase::Prescribed if *geometry == Geometry::Live => {
                let (along, across) = (dot(line.normal, velocity.apart), dot(line.across, velocity.apart));
                drive_power += travel * ra * across / line.tangent + shortening * (along + across * steeper);
            }
            Phase::Prescribed => {}
        }
        if let Some([ea, eb]) = eccentric {
            moments[0] += push[0] * ea[1] - push[1] * ea[0];
            moments[1] += push[1] * eb[0] - push[0] * eb[1];
            drive_power -= dot(push, *carried);
        }
        let damping_power = self.damping * rate * rate;
        let behind = f64::NEG_INFINITY;
        Contact { deflection, rate, force, stiffness, energy, push, moments, drive_power, damping_power, behind }
    }

    /// Where the tooth pairs of a flank are on the path of contact.
    pub(super) fn path(&self, sigma: f64, back: bool, line: &LineOfAction, angle: f64, twist: f64) -> Path {
        let turned = match self.phase {
            Phase::Twist => angle + twist,
            Phase::Prescribed => angle,
        };
        let pressure_angle = self.involute.pressure_angle_at_rest() + line.steeper;
        let centres = self.involute.angle_at_rest() + line.turned;
        let pitch = self.involute.base_pitch;
        // What thinner teeth leave for the backlash is a hundredth of the pitch, and not known of either gear alone.
        let behind = if back { self.involute.base_thickness } else { 0.0 };
        let [low, high] = self.involute.path(line.tangent);
        let position = self.involute.position(sigma, turned, centres, pressure_angle) + behind;
        Path { position, low, high, pitch }
    }

    /// The same of teeth that meet so.
    fn path_of(&self, pose: &Pose<'_>, meeting: &Meeting) -> Path {
        self.path(meeting.sigma, meeting.back, &meeting.line, pose.turning[0].angle, pose.position.twist[0])
    }

    /// Where the tooth pairs of the drive flank are on the path of contact, or those of the back flank.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn engagement(&self, pose: &Pose<'_>, back: bool) -> Result<Path, Overlap> {
        let approach = self.approach(pose)?;
        Ok(self.path_of(pose, &self.meet(&approach, back)))
    }

    /// The law that holds: which flank presses, and which pairs are between the tip circles.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn law(&self, pose: &Pose<'_>) -> Result<Law, Overlap> {
        let approach = self.approach(pose)?;
        let engaged = |meeting: &Meeting| {
            if self.teeth.is_sharp() { self.path_of(pose, meeting).engaged() } else { (0, 0) }
        };
        let drive = self.meet(&approach, false);
        if self.backlash.is_none() {
            return Ok(Law { flank: Flank::Drive, engaged: [engaged(&drive), (0, 0)] });
        }
        let back = self.meet(&approach, true);
        let law = Law { flank: Flank::Both, engaged: [engaged(&drive), engaged(&back)] };
        let presses = |meeting: &Meeting| meeting.deflection > 0.0 && self.press(&approach, meeting, &law).force > 0.0;
        let flank = match (presses(&drive), presses(&back)) {
            (true, true) => Flank::Both,
            (true, false) => Flank::Drive,
            (false, true) => Flank::Back,
            (false, false) => Flank::Apart,
        };
        Ok(Law { flank, ..law })
    }
}
