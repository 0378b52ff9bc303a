//! Description of couplings, drives, forces, and of torques that depend on time or speed.

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess};
use serde::{Deserialize, Deserializer, Serialize};

use super::reading::{NumberOrEntries, number_or_entries};
use super::{Complex, Outside, Place};

/// A coupling between two coaxial shafts of one speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Place of the first hub.
    pub a: Place,
    /// Place of the second hub.
    pub b: Place,
    /// Axial stiffness, N/m.
    pub axial_stiffness: Option<f64>,
    /// Lateral stiffness, N/m.
    pub lateral_stiffness: Option<f64>,
    /// Tilting stiffness, N m/rad.
    pub tilting_stiffness: Option<f64>,
    /// Torsional stiffness, N m/rad.
    pub torsional_stiffness: f64,
    /// Axial damping, N s/m.
    pub axial_damping: Option<f64>,
    /// Lateral damping, N s/m.
    pub lateral_damping: Option<f64>,
    /// Tilting damping, N m s/rad.
    pub tilting_damping: Option<f64>,
    /// Torsional damping, N m s/rad.
    pub torsional_damping: Option<f64>,
    /// Parallel misalignment of the axis of b to that of a, y + iz, m.
    pub offset: Option<Complex>,
    /// Angular misalignment of the axis of b to that of a, slopes along y + iz, rad.
    pub angle: Option<Complex>,
    /// Eccentricity of the hub of b, m, with its angle in the rotating shaft.
    pub runout: Option<Complex>,
}

/// A torsional spring and damper that hold the rotation of a shaft at its prescribed angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Place where it acts.
    pub at: Place,
    /// Stiffness, N m/rad.
    pub stiffness: f64,
    /// Damping, N m s/rad.
    pub damping: Option<f64>,
}

/// A force on a shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Place where it acts.
    pub at: Place,
    /// Force y + iz, N.
    pub value: ForceValue,
    /// Angle of the force per angle of the shaft; a force without an order does not turn.
    pub order: Option<f64>,
    /// Constant force along the axis of the shaft, N.
    pub axial: Option<f64>,
}

/// Values over time; between them a cubic, outside the first or the last value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSeries {
    /// Times, s, ascending.
    pub times: Vec<f64>,
    /// Value at each time.
    pub values: Vec<Complex>,
    /// Derivative at each time; that of a monotone cubic by default.
    pub slopes: Option<Vec<Complex>>,
}

/// A torque over the magnitude of the speed of its shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueTable {
    /// Speeds, rad/s, ascending from zero or above.
    pub speeds: Vec<f64>,
    /// Torque at each speed, N m.
    pub values: Vec<f64>,
    /// What holds for a speed of the shaft outside the table; an error by default.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub outside: Outside,
}

/// Value of a force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ForceValue {
    /// Constant, N.
    Constant(Complex),
    /// Over time, N.
    Series(TimeSeries),
}

/// Value of a torque.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum TorqueValue {
    /// Constant, N m.
    Constant(f64),
    /// Over time, N m.
    Series(TimeSeries),
    /// Over the speed of the shaft, N m.
    Table(TorqueTable),
}

impl<'de> Deserialize<'de> for ForceValue {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        number_or_entries(source)
    }
}

impl NumberOrEntries for ForceValue {
    const EXPECTED: &'static str = "a number [N], a pair [y, z] or a time series";

    fn number(value: f64) -> Self {
        Self::Constant(Complex::Real(value))
    }

    fn entries<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        TimeSeries::deserialize(MapAccessDeserializer::new(map)).map(Self::Series)
    }

    fn list<'de, A: SeqAccess<'de>>(sequence: A) -> Result<Self, A::Error> {
        let pair = <[f64; 2]>::deserialize(SeqAccessDeserializer::new(sequence))?;
        Ok(Self::Constant(Complex::Pair(pair)))
    }
}

impl<'de> Deserialize<'de> for TorqueValue {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        number_or_entries(source)
    }
}

/// Both tables, of which the keys of the entry select one.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TorqueEntries {
    times: Option<Vec<f64>>,
    speeds: Option<Vec<f64>>,
    values: Vec<Complex>,
    slopes: Option<Vec<Complex>>,
    #[serde(default)]
    outside: Outside,
}

impl NumberOrEntries for TorqueValue {
    const EXPECTED: &'static str = "a number [N m], a time series or a speed table";

    fn number(value: f64) -> Self {
        Self::Constant(value)
    }

    fn entries<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        let TorqueEntries { times, speeds, values, slopes, outside } =
            TorqueEntries::deserialize(MapAccessDeserializer::new(map))?;
        match (times, speeds) {
            (Some(times), None) => Ok(Self::Series(TimeSeries { times, values, slopes })),
            (None, Some(speeds)) => {
                let real = |value: &Complex| match value {
                    Complex::Real(value) => Ok(*value),
                    Complex::Pair(_) => Err(A::Error::custom("a torque is a real number, got a pair")),
                };
                let values = values.iter().map(real).collect::<Result<_, _>>()?;
                Ok(Self::Table(TorqueTable { speeds, values, outside }))
            }
            _ => Err(A::Error::custom("needs either times or speeds")),
        }
    }
}
