//! Contact of a mesh: the flank in contact, its force, and the quantities that a response reports.

use super::Centres;
use crate::numerics::LARGEST_EXACT_INTEGER;

/// Angle and spin of a shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaftPhase {
    /// Spin angle ϑ, rad.
    pub angle: f64,
    /// Spin Ω, rad/s.
    pub spin: f64,
}

/// The flank in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flank {
    /// The drive flank.
    Drive,
    /// The back flank.
    Back,
    /// Neither: the teeth are separated.
    Separated,
    /// Both: the centre distance is smaller than the backlash allows.
    Both,
}

impl Flank {
    /// The flanks in contact, from whether the drive flank and the back flank are.
    pub fn of(drives: bool, holds_back: bool) -> Self {
        match (drives, holds_back) {
            (true, true) => Self::Both,
            (true, false) => Self::Drive,
            (false, true) => Self::Back,
            (false, false) => Self::Separated,
        }
    }

    /// Whether the drive flank is in contact.
    pub fn drives(self) -> bool {
        matches!(self, Self::Drive | Self::Both)
    }

    /// Whether the back flank is in contact.
    pub fn holds_back(self) -> bool {
        matches!(self, Self::Back | Self::Both)
    }
}

/// The contact mode of a mesh in a step. It changes only between steps, so that the force is smooth within a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactMode {
    /// The flank in contact.
    pub flank: Flank,
    /// First and last pair on the path of contact of the drive flank and of the back flank, where engagement is sharp.
    pub engaged: [(i64, i64); 2],
}

/// Upper bound on the pairs in contact at once; contact ratios are below 10.
const MAX_PAIRS_IN_CONTACT: u64 = 1000;

impl ContactMode {
    /// The contact mode of a mesh without backlash and without sharp engagement.
    pub const ALWAYS: Self = Self { flank: Flank::Drive, engaged: [(0, 0); 2] };

    /// Length of [`Self::code`].
    pub const CODE_LENGTH: usize = 5;

    /// The contact mode as numbers: flank, then first and last pair of each flank.
    pub fn code(&self) -> [i64; Self::CODE_LENGTH] {
        let [(a, b), (c, d)] = self.engaged;
        [self.flank as i64, a, b, c, d]
    }

    /// Whether numbers represent a contact mode: a flank, and ranges of pairs that can be in contact.
    pub fn is_code(code: &[i64]) -> bool {
        let range = |pairs: &[i64]| {
            pairs.iter().all(|pair| pair.unsigned_abs() <= LARGEST_EXACT_INTEGER)
                && pairs[1].abs_diff(pairs[0]) <= MAX_PAIRS_IN_CONTACT
        };
        code.len() == Self::CODE_LENGTH && (0..=3).contains(&code[0]) && range(&code[1..3]) && range(&code[3..5])
    }

    /// The contact mode of numbers that [`Self::is_code`] accepts.
    pub fn from_code(code: &[i64]) -> Self {
        let flank = match code[0] {
            0 => Flank::Drive,
            1 => Flank::Back,
            2 => Flank::Separated,
            _ => Flank::Both,
        };
        Self { flank, engaged: [(code[1], code[2]), (code[3], code[4])] }
    }
}

/// Generalised forces of a helical mesh on the additional coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HelixForces {
    /// Force on u_b, N; the force on u_a is the opposite.
    pub axial: f64,
    /// Moment on τ, N m.
    pub tilt: [f64; 2],
    /// Force on u_b − u_a over (y, z), N.
    pub centre: [f64; 2],
}

/// The state of a mesh at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Deflection δ of the drive flank, m, or of the back flank if only the back flank is evaluated.
    pub deflection: f64,
    /// Rate δ̇ of the deflection, m/s.
    pub rate: f64,
    /// Mesh force F, N: force of the drive flank minus force of the back flank.
    pub force: f64,
    /// Stiffness ∂²U/∂δ², N/m.
    pub stiffness: f64,
    /// Elastic energy U, J.
    pub energy: f64,
    /// Generalised force on u_b, N; the force on u_a is the opposite.
    pub centre_force: [f64; 2],
    /// Generalised forces on θ_a and θ_b, N m.
    pub moments: [f64; 2],
    /// Generalised forces of helical teeth on the other coordinates; zero for spur gears.
    pub helix: HelixForces,
    /// Power of the prescribed motion (transmission error, spin of the teeth, run-out), W.
    pub drive_power: f64,
    /// Power dissipated by damping, cδ̇², W.
    pub damping_power: f64,
    /// Deflection of the back flank, m; −∞ without backlash.
    pub back_flank_deflection: f64,
    /// Moment of the friction about the axis of the driver that the drive of a train with free rotation supplies, N m.
    pub resistance: f64,
}

impl Contact {
    /// The contact with separated flanks: same deflection and rate, no force.
    pub(super) fn separated(&self) -> Self {
        Self { deflection: self.deflection, rate: self.rate, ..Self::default() }
    }

    /// The sum of this contact of the drive flank and the contact of the back flank.
    pub(super) fn and_back(&self, back: &Self) -> Self {
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            deflection: self.deflection,
            rate: self.rate,
            force: self.force - back.force,
            stiffness: self.stiffness + back.stiffness,
            energy: self.energy + back.energy,
            centre_force: sum(self.centre_force, back.centre_force),
            moments: sum(self.moments, back.moments),
            helix: HelixForces::default(),
            drive_power: self.drive_power + back.drive_power,
            damping_power: self.damping_power + back.damping_power,
            back_flank_deflection: back.deflection,
            resistance: self.resistance + back.resistance,
        }
    }
}

/// Quantities of a mesh that a response reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshState {
    /// Deflection of the drive flank normal to the teeth, m; negative while the drive flank is separated.
    pub deflection: f64,
    /// Mesh force normal to the teeth, N; negative on the back flank.
    pub force: f64,
    /// Stiffness normal to the teeth, N/m.
    pub stiffness: f64,
    /// Position of the moving gear centres.
    pub centres: Centres,
    /// Number of tooth pairs between the tip circles; zero while the flanks are separated.
    pub pairs_in_contact: f64,
    /// Axial force of the teeth on the driven gear along x, N; the driver is subject to the opposite.
    pub thrust: f64,
    /// Friction on the driven gear across the line of action, N.
    pub friction_force: f64,
    /// Power that the friction dissipates, W.
    pub friction_power: f64,
}
