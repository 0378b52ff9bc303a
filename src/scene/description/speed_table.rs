//! Coefficients of a bearing, as a user describes them: constant, or a table over speed, frequency or both.

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess};
use serde::{Deserialize, Deserializer, Serialize};

use super::reading::{NumberOrEntries, number_or_entries};

/// Stiffness or damping of a bearing.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum BearingCoefficient {
    /// The same at every speed and frequency.
    Constant(Coefficient),
    /// A table over the speed, the frequency or both.
    Table(SpeedTable),
}

/// What a table does outside its speeds and frequencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outside {
    /// It refuses them.
    #[default]
    Error,
    /// It holds its first or its last value.
    Hold,
}

/// Coefficients over the magnitude of the speed of a shaft, of the frequency of a vibration, or of both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedTable {
    /// Speeds, rad/s, ascending from zero or above; without them the speed has no effect.
    pub speeds: Option<Vec<f64>>,
    /// Frequencies, rad/s, ascending from zero or above; without them the frequency has no effect.
    pub frequencies: Option<Vec<f64>>,
    /// One entry for each speed, or for each frequency of a table without speeds; all coefficients have the same form.
    pub values: Vec<TableValue>,
    /// What holds outside the speeds and frequencies; an error by default.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub outside: Outside,
}

/// An entry of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, a pair [yy, zz] or rows [[yy, yz], [zy, zz]], or a list of these over the frequencies"
)]
pub enum TableValue {
    /// One coefficient.
    One(Coefficient),
    /// The coefficients of one speed over the frequencies.
    OverFrequencies(Vec<Coefficient>),
}

impl TableValue {
    /// The coefficients over the frequencies of a table that has speeds too. Over two frequencies, two numbers read as a pair,
    /// and two pairs as rows.
    pub fn over_frequencies(&self) -> Vec<Coefficient> {
        match self {
            Self::OverFrequencies(values) => values.clone(),
            Self::One(Coefficient::Orthotropic(values)) => values.map(Coefficient::Isotropic).to_vec(),
            Self::One(Coefficient::Full(values)) => values.map(Coefficient::Orthotropic).to_vec(),
            Self::One(value) => vec![*value],
        }
    }
}

impl From<Coefficient> for BearingCoefficient {
    fn from(coefficient: Coefficient) -> Self {
        Self::Constant(coefficient)
    }
}

impl<'de> Deserialize<'de> for BearingCoefficient {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        number_or_entries(source)
    }
}

impl NumberOrEntries for BearingCoefficient {
    const EXPECTED: &'static str = "a number, a pair [yy, zz], rows [[yy, yz], [zy, zz]] or a speed table";

    fn number(value: f64) -> Self {
        Coefficient::Isotropic(value).into()
    }

    fn entries<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        SpeedTable::deserialize(MapAccessDeserializer::new(map)).map(Self::Table)
    }

    fn list<'de, A: SeqAccess<'de>>(sequence: A) -> Result<Self, A::Error> {
        Coefficient::deserialize(SeqAccessDeserializer::new(sequence)).map(Self::Constant)
    }
}

/// A 2×2 coefficient of a bearing over (y, z).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, a pair [yy, zz] or rows [[yy, yz], [zy, zz]]")]
pub enum Coefficient {
    /// Isotropic coefficient.
    Isotropic(f64),
    /// Coefficients along y and z.
    Orthotropic([f64; 2]),
    /// The full matrix.
    Full([[f64; 2]; 2]),
}

impl Coefficient {
    /// The matrix by rows, over (y, z).
    pub fn rows(self) -> [[f64; 2]; 2] {
        match self {
            Self::Isotropic(k) => [[k, 0.0], [0.0, k]],
            Self::Orthotropic([yy, zz]) => [[yy, 0.0], [0.0, zz]],
            Self::Full(rows) => rows,
        }
    }
}
