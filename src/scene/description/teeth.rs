//! The teeth of a mesh, as a user describes them.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Stiffness of a mesh: a mean, or a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Stiffness {
    /// Mean, N/m.
    Mean(f64),
    /// A model.
    Model(StiffnessModel),
}

/// Not derived: an error inside a model names the field, which trying one variant after the other does not.
impl<'de> Deserialize<'de> for Stiffness {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Reader;

        impl<'de> Visitor<'de> for Reader {
            type Value = Stiffness;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number [N/m] or a stiffness model")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Stiffness, E> {
                Ok(Stiffness::Mean(value))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Stiffness, E> {
                Ok(Stiffness::Mean(value as f64))
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Stiffness, E> {
                Ok(Stiffness::Mean(value as f64))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Stiffness, A::Error> {
                StiffnessModel::deserialize(MapAccessDeserializer::new(map)).map(Stiffness::Model)
            }
        }

        source.deserialize_any(Reader)
    }
}

/// The family of a stiffness model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StiffnessKind {
    /// The same always.
    Constant,
    /// ISO 6336-1.
    Iso6336,
    /// Pairs of the same stiffness along the path.
    Square,
    /// Pairs whose stiffness falls towards the ends of the path.
    Parabolic,
    /// Pairs from their teeth.
    PotentialEnergy,
    /// Values over the mesh cycle.
    Table,
    /// Harmonics of the mesh cycle.
    Fourier,
}

/// A stiffness model: the family, and the parameters that it has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StiffnessModel {
    /// The family.
    pub model: StiffnessKind,
    /// Mean of the mesh, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// One pair where it is stiffest, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair: Option<f64>,
    /// Stiffness of a parabolic pair at the ends of the path, as a part of that in the middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_ratio: Option<f64>,
    /// Values at equal parts of the mesh cycle, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// Amplitudes of the harmonics of the mesh cycle, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitudes: Option<Vec<f64>>,
    /// Their phases, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phases: Option<Vec<f64>>,
    /// Radii at which the blanks of driver and driven gear are held, m; those of their shafts by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bore_radii: Option<[f64; 2]>,
    /// Whether pairs in contact at once share the compliance of fillet and blank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foundation: Option<Foundation>,
    /// `"sharp"`, or the part of the base pitch over which a pair comes into contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engagement: Option<Engagement>,
    /// What moves the teeth along the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<Phase>,
}

impl StiffnessModel {
    /// A model without parameters.
    pub fn of(model: StiffnessKind) -> Self {
        Self {
            model,
            mean: None,
            pair: None,
            end_ratio: None,
            values: None,
            amplitudes: None,
            phases: None,
            bore_radii: None,
            foundation: None,
            engagement: None,
            phase: None,
        }
    }
}

/// Fillet and blank of teeth by potential energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Foundation {
    /// Every pair has its own.
    Separate,
    /// All pairs in contact have one.
    Shared,
}

/// Engagement of a pair of teeth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"sharp\" or a part of the base pitch")]
pub enum Engagement {
    /// Over this part of the base pitch.
    Smooth(f64),
    /// `"sharp"`.
    Named(String),
}

/// What moves the teeth along the path of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Spin, twist and centres.
    Twist,
    /// Spin alone.
    Prescribed,
}

/// Tip relief.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipRelief {
    /// At the end of the path, m.
    pub amount: f64,
    /// Along the path from its end, m.
    pub length: f64,
    /// `"linear"` (the default) or `"parabolic"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
}

/// Unloaded transmission error: harmonics as `[amplitude m, phase rad]` of the orders 1, 2, …, and a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransmissionError {
    /// Of the mesh frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tooth: Option<Vec<[f64; 2]>>,
    /// Of the driver's shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driver: Option<Vec<[f64; 2]>>,
    /// Of the driven shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driven: Option<Vec<[f64; 2]>>,
    /// Values at equal parts of the mesh cycle, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<Vec<f64>>,
}
