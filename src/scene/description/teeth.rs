//! Description of the teeth of a mesh: stiffness, engagement, tip relief and transmission error.

use serde::de::MapAccess;
use serde::de::value::MapAccessDeserializer;
use serde::{Deserialize, Deserializer, Serialize};

use super::reading::{NumberOrEntries, number_or_entries};

/// Stiffness of a mesh: a number or a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Stiffness {
    /// Constant stiffness, N/m.
    Mean(f64),
    /// A stiffness model.
    Model(StiffnessModel),
}

impl<'de> Deserialize<'de> for Stiffness {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        number_or_entries(source)
    }
}

impl NumberOrEntries for Stiffness {
    const EXPECTED: &'static str = "a number [N/m] or a stiffness model";

    fn number(value: f64) -> Self {
        Self::Mean(value)
    }

    fn entries<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        StiffnessModel::deserialize(MapAccessDeserializer::new(map)).map(Self::Model)
    }
}

/// Kind of a stiffness model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StiffnessKind {
    /// Constant mesh stiffness.
    Constant,
    /// ISO 6336-1.
    #[default]
    Iso6336,
    /// Tooth pairs of constant stiffness.
    Square,
    /// Tooth pairs whose stiffness is a parabola along the path of contact.
    Parabolic,
    /// Tooth pairs by the potential-energy method.
    PotentialEnergy,
    /// Table over the mesh cycle.
    Table,
    /// Harmonics of the mesh cycle.
    Fourier,
}

/// A stiffness model: its kind and parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StiffnessModel {
    /// Kind of the model.
    pub model: StiffnessKind,
    /// Mean mesh stiffness, N/m.
    pub mean: Option<f64>,
    /// Largest stiffness of one tooth pair, N/m.
    pub pair: Option<f64>,
    /// Stiffness of a parabolic pair at the ends of the path of contact, relative to its largest stiffness.
    pub end_ratio: Option<f64>,
    /// Mesh stiffness at equal intervals of the mesh cycle, N/m.
    pub values: Option<Vec<f64>>,
    /// Amplitudes of the harmonics of the mesh cycle, N/m.
    pub amplitudes: Option<Vec<f64>>,
    /// Phases of the harmonics, rad.
    pub phases: Option<Vec<f64>>,
    /// Radii at which the bodies of driver and driven gear are fixed, m; by default the radii of the shafts.
    pub bore_radii: Option<[f64; 2]>,
    /// Whether simultaneous pairs share the compliance of fillet and gear body.
    pub foundation: Option<Foundation>,
    /// `"sharp"`, or the fraction of the base pitch over which a pair comes into contact.
    pub engagement: Option<Engagement>,
    /// Motions on which the position of the teeth along the path of contact depends.
    pub phase: Option<Phase>,
}

impl StiffnessModel {
    /// Creates a model without parameters.
    pub fn of(model: StiffnessKind) -> Self {
        Self { model, ..Self::default() }
    }
}

/// Compliance of fillet and gear body in the potential-energy model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Foundation {
    /// Each pair has its own compliance.
    Separate,
    /// Simultaneous pairs share one compliance.
    Shared,
}

/// Engagement of a pair of teeth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"sharp\" or a fraction of the base pitch")]
pub enum Engagement {
    /// Fraction of the base pitch over which a pair comes into contact.
    Smooth(f64),
    /// `"sharp"`.
    Named(String),
}

/// Motions on which the position of the teeth along the path of contact depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Rotation of the shafts, twist and motion of the gear centres, with the force ½δ² ∂k/∂q that follows. Energy is
    /// conserved: if the torques balance, damping of the vibration slows the rigid-body rotation.
    Twist,
    /// Rotation of the shafts and motion of the gear centres. The stiffness is prescribed, and the drive that keeps the
    /// speed does work through it.
    Prescribed,
}

/// Tip relief.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipRelief {
    /// Relief at the end of the path of contact, m.
    pub amount: f64,
    /// Length of the relief along the path of contact, from its end, m.
    pub length: f64,
    /// `"linear"` (the default) or `"parabolic"`.
    pub shape: Option<String>,
}

/// Unloaded transmission error. Harmonic k of a list is `[amplitude, phase]` of order k + 1, in m and rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransmissionError {
    /// Harmonics of the mesh frequency.
    pub tooth: Option<Vec<[f64; 2]>>,
    /// Harmonics of the rotation of the driver shaft.
    pub driver: Option<Vec<[f64; 2]>>,
    /// Harmonics of the rotation of the driven shaft.
    pub driven: Option<Vec<[f64; 2]>>,
    /// Values at equal intervals of the mesh cycle, m.
    pub table: Option<Vec<f64>>,
}

/// Friction between the flanks of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a coefficient of friction, or a table with coefficient, or viscosity and roughness"
)]
pub enum MeshFriction {
    /// Coefficient of friction.
    Coefficient(f64),
    /// The complete description.
    Table(FrictionTable),
}

/// Friction between the flanks of a mesh: either a coefficient, or viscosity and roughness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionTable {
    /// Coefficient of friction.
    pub coefficient: Option<f64>,
    /// Dynamic viscosity of the oil, Pa s.
    pub viscosity: Option<f64>,
    /// Arithmetic mean roughness of the flanks, m.
    pub roughness: Option<f64>,
    /// Factor of the lubricant; 1 by default, for mineral oil.
    pub lubricant_factor: Option<f64>,
    /// Fraction of the base pitch about the pitch point on which the friction changes its sign.
    pub transition: Option<f64>,
}
