//! Description of bearings.

use serde::{Deserialize, Serialize};

use super::{Base, BearingCoefficient};

/// A bearing under a shaft: linear with `stiffness`, on the ground, a support or a housing; or a journal bearing on the ground
/// with `diameter` and the other entries of its film.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bearing {
    /// Name of the shaft.
    pub shaft: String,
    /// Position on the shaft, m.
    pub position: f64,
    /// Stiffness, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<BearingCoefficient>,
    /// Damping, N s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<BearingCoefficient>,
    /// Stiffness along the axis of the shaft, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial_stiffness: Option<f64>,
    /// Damping along the axis of the shaft, N s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial_damping: Option<f64>,
    /// Stiffness against rotations about y and z, N m/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilting_stiffness: Option<f64>,
    /// Damping of rotations about y and z, N m s/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilting_damping: Option<f64>,
    /// Diameter of a journal, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter: Option<f64>,
    /// Length of a journal bearing, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Radial clearance of a journal bearing, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<f64>,
    /// Dynamic viscosity of the oil, Pa s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// Model of the film; short by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub film: Option<FilmModel>,
    /// Axial grooves of a finite film: angle of the middle from y towards z, and extent, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grooves: Option<Vec<[f64; 2]>>,
    /// What it stands on; the ground by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<Base>,
}

/// Model of the oil film of a journal bearing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FilmModel {
    /// Short film, closed form.
    #[default]
    Short,
    /// Film of finite length, from Reynolds' equation.
    Finite,
}
