//! Coefficients of a bearing, as a user describes them: constant, or a table over the speed.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Stiffness or damping of a bearing.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum BearingCoefficient {
    /// The same at every speed.
    Constant(Coefficient),
    /// A table over the speed.
    Table(SpeedTable),
}

/// What a table does outside its speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outside {
    /// It refuses them.
    #[default]
    Error,
    /// It holds its first or its last value.
    Hold,
}

/// Coefficients over the magnitude of the speed of a shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedTable {
    /// Speeds, rad/s, ascending from zero or above.
    pub speeds: Vec<f64>,
    /// One coefficient for each speed, all in the same form.
    pub values: Vec<Coefficient>,
    /// What holds outside the speeds; an error by default.
    #[serde(default, skip_serializing_if = "is_error")]
    pub outside: Outside,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn is_error(outside: &Outside) -> bool {
    *outside == Outside::Error
}

impl From<Coefficient> for BearingCoefficient {
    fn from(coefficient: Coefficient) -> Self {
        Self::Constant(coefficient)
    }
}

/// Not derived: an error inside a table names the field; an untagged enum only says that no variant fits.
impl<'de> Deserialize<'de> for BearingCoefficient {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Reader;

        impl<'de> Visitor<'de> for Reader {
            type Value = BearingCoefficient;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number, a pair [yy, zz], rows [[yy, yz], [zy, zz]] or a speed table")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<BearingCoefficient, E> {
                Ok(Coefficient::Isotropic(value).into())
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<BearingCoefficient, E> {
                self.visit_f64(value as f64)
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<BearingCoefficient, E> {
                self.visit_f64(value as f64)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<BearingCoefficient, A::Error> {
                Coefficient::deserialize(SeqAccessDeserializer::new(sequence)).map(BearingCoefficient::Constant)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<BearingCoefficient, A::Error> {
                SpeedTable::deserialize(MapAccessDeserializer::new(map)).map(BearingCoefficient::Table)
            }
        }

        source.deserialize_any(Reader)
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
