//! Description of the harmonic sources of a frequency response. They are arguments of the analysis, not parts of a scene.
//!
//! Values are phasors: the physical value at the frequency ω is the real part of value·e^{iωt}.

use serde::Deserialize;

use super::{Complex, Place};

/// A harmonic source.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Source {
    /// A force.
    Force {
        /// Place where it acts.
        at: Place,
        /// Force along y and z, N.
        value: [Complex; 2],
        /// Force along x, N.
        axial: Complex,
    },
    /// A torque about x.
    Torque {
        /// Place where it acts.
        at: Place,
        /// Torque, N m.
        value: Complex,
    },
    /// An unloaded transmission error of a mesh.
    MeshError {
        /// Names of the two gears.
        mesh: [String; 2],
        /// Transmission error along the line of action, m.
        error: Complex,
    },
    /// A translation of the ground.
    Ground {
        /// The quantity that is given.
        quantity: GroundQuantity,
        /// Value along y and z, m, m/s or m/s².
        value: [Complex; 2],
        /// Value along x, m, m/s or m/s².
        axial: Complex,
        /// Bearings, supports and housings under which the ground moves; all of them by default.
        under: Option<Vec<Place>>,
    },
    /// Bow, unbalance and forces that turn with a shaft, of the amplitude that they have where the shaft turns with the
    /// frequency.
    Shaft {
        /// Name of the shaft.
        shaft: String,
        /// The part of the excitation.
        excitation: String,
    },
}

/// The quantity by which a motion of the ground is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroundQuantity {
    /// Displacement, m.
    Displacement,
    /// Velocity, m/s.
    Velocity,
    /// Acceleration, m/s².
    Acceleration,
}
