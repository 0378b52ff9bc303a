//! What a mesh is doing: which flank carries, with what force, and what a response reports of it.

use super::Centres;

/// How a shaft stands and turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turning {
    /// Angle ϑ of its spin, rad.
    pub angle: f64,
    /// Spin Ω, rad/s.
    pub spin: f64,
}

/// The flank that carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flank {
    /// The one that drives.
    Drive,
    /// The other one.
    Back,
    /// Neither: the teeth have parted.
    Apart,
}

/// The law of a mesh over a step: it changes between steps alone, so that a step never sees a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Law {
    /// The flank that carries.
    pub flank: Flank,
    /// First and last pair between the tip circles, where pairs come and go in jumps.
    pub engaged: (i64, i64),
}

impl Law {
    /// The law of a mesh that never changes it.
    pub const ALWAYS: Self = Self { flank: Flank::Drive, engaged: (0, 0) };

    /// As numbers: flank, first pair, last pair.
    pub fn code(&self) -> [i64; 3] {
        [self.flank as i64, self.engaged.0, self.engaged.1]
    }

    /// From its numbers.
    pub fn from_code(code: &[i64]) -> Self {
        let flank = match code[0] {
            0 => Flank::Drive,
            1 => Flank::Back,
            _ => Flank::Apart,
        };
        Self { flank, engaged: (code[1], code[2]) }
    }
}

/// The state of a mesh at an instant, on the flank that carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Deflection δ, m.
    pub deflection: f64,
    /// Its rate δ̇, m/s.
    pub rate: f64,
    /// Force F, N.
    pub force: f64,
    /// Stiffness ∂²U/∂δ², N/m.
    pub stiffness: f64,
    /// Elastic energy U, J.
    pub energy: f64,
    /// Generalised force on u_b, and the opposite on u_a, N.
    pub push: [f64; 2],
    /// Generalised forces on θ_a and θ_b, N m.
    pub moments: [f64; 2],
    /// Power of what is prescribed (error, spin of the teeth, run-out), W.
    pub drive_power: f64,
}

/// What a response reports of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshState {
    /// Deflection δ of the drive flank, m; below zero while the flanks are apart.
    pub deflection: f64,
    /// Force F, N; below zero on the back flank.
    pub force: f64,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// The moving centres.
    pub centres: Centres,
    /// Tooth pairs between the tip circles; none while the flanks are apart.
    pub pairs_in_contact: f64,
}
