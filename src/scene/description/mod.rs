//! What a user says, as it stands in a TOML file or a Python dictionary.
//!
//! One type for every way in. Nothing here is checked beyond its type: [`Scene::new`](super::Scene::new) does that,
//! once, and names the place of what is wrong. SI units and radians throughout.

mod reading;
mod shaft;
mod teeth;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

pub use shaft::{Bow, BowShape, Material, STEEL, Segment, Shaft};
pub use teeth::{
    Engagement, Foundation, Phase, Stiffness, StiffnessKind, StiffnessModel, TipRelief, TransmissionError,
};

use reading::whole;

use super::SceneError;

/// A whole rotor system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneDescription {
    /// The shaft that a speed speaks of; the first where none is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Damping ratio of every undamped mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modal_damping: Option<f64>,
    /// `[α, β]`: damping αM + βK of the shafts themselves, in 1/s and s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rayleigh: Option<[f64; 2]>,
    /// Gravity in m/s²: a number acts along −z, a pair along y and z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// Which degrees of freedom; what the scene requires where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionKind>,
    /// The shafts.
    pub shafts: Vec<Shaft>,
    /// The gears.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gears: Vec<Gear>,
    /// Rigid disks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disks: Vec<Disk>,
    /// Pairs of gears in mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    /// Bearings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bearings: Vec<Bearing>,
    /// Torques on the shafts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torques: Vec<Torque>,
}

/// Which degrees of freedom a node has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// Bending alone: v, w, B, Γ.
    Lateral,
    /// Twist alone: θ.
    Torsion,
    /// All five.
    Coupled,
}

/// Gravity: along −z, or a vector.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number [m/s²] or a pair [y, z]")]
pub enum Gravity {
    /// Magnitude, acting along −z.
    Down(f64),
    /// Components along y and z.
    Vector([f64; 2]),
}

/// A complex number: a real one, or `[re, im]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number or a pair [re, im]")]
pub enum Complex {
    /// A real number.
    Real(f64),
    /// Real and imaginary part.
    Pair([f64; 2]),
}

impl From<Complex> for Complex64 {
    fn from(value: Complex) -> Self {
        match value {
            Complex::Real(re) => Complex64::new(re, 0.0),
            Complex::Pair([re, im]) => Complex64::new(re, im),
        }
    }
}

/// A rigid disk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disk {
    /// Name, unlike every other name of the system.
    pub name: String,
    /// Its shaft.
    pub shaft: String,
    /// Where on the shaft, m.
    pub position: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about a diameter, kg m².
    pub diametral_inertia: f64,
    /// Moment of inertia about the axis, kg m².
    pub polar_inertia: f64,
    /// Mass times eccentricity, kg m, with its angle in the shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unbalance: Option<Complex>,
}

/// A spur gear: `module` or `base_radius`, and what else is known of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gear {
    /// Name, unlike every other name of the system.
    pub name: String,
    /// Its shaft.
    pub shaft: String,
    /// Where on the shaft, m.
    pub position: f64,
    /// Number of teeth.
    #[serde(deserialize_with = "whole")]
    pub teeth: u32,
    /// Module, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub module: Option<f64>,
    /// Base radius, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_radius: Option<f64>,
    /// Face width, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub face_width: Option<f64>,
    /// Pressure angle of the basic rack, rad; 20° by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_angle: Option<f64>,
    /// Profile shift coefficient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile_shift: Option<f64>,
    /// Tip radius, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_radius: Option<f64>,
    /// Mass, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Moment of inertia about a diameter, kg m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diametral_inertia: Option<f64>,
    /// Moment of inertia about the axis, kg m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polar_inertia: Option<f64>,
    /// Mass times eccentricity, kg m, with its angle in the shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unbalance: Option<Complex>,
    /// Run-out: how far the base circle stands off the shaft's axis, m, with its angle in the shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_out: Option<Complex>,
}

/// A pair of gears in mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// The driving gear.
    pub driver: String,
    /// The driven gear.
    pub driven: String,
    /// Stiffness along the line of action; ISO 6336-1 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Stiffness>,
    /// Damping ratio ζ of c = 2ζ√(k mₑ).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_ratio: Option<f64>,
    /// Damping along the line of action, N s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Angle of the line of centres, driver to driven, from y, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_line_angle: Option<f64>,
    /// Distance of the centres at rest, m; the sum of the reference pitch radii by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_distance: Option<f64>,
    /// Clearance of the flanks along the line of action, m; none for a mesh that never parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<f64>,
    /// Tip relief of both gears.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_relief: Option<TipRelief>,
    /// Unloaded transmission error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<TransmissionError>,
}

/// A 2×2 coefficient over (y, z).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, a pair [yy, zz] or rows [[yy, yz], [zy, zz]]")]
pub enum Coefficient {
    /// The same in every direction.
    Isotropic(f64),
    /// Along y and z.
    Orthotropic([f64; 2]),
    /// The full matrix.
    Full([[f64; 2]; 2]),
}

impl Coefficient {
    /// Rows over (y, z).
    pub fn rows(self) -> [[f64; 2]; 2] {
        match self {
            Self::Isotropic(k) => [[k, 0.0], [0.0, k]],
            Self::Orthotropic([yy, zz]) => [[yy, 0.0], [0.0, zz]],
            Self::Full(rows) => rows,
        }
    }
}

/// A bearing between a shaft and the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bearing {
    /// Its shaft.
    pub shaft: String,
    /// Where on the shaft, m.
    pub position: f64,
    /// Stiffness, N/m.
    pub stiffness: Coefficient,
    /// Damping, N s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<Coefficient>,
}

/// A place: the name of a gear or disk, or a shaft and a position on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a gear, a disk, or a pair [shaft, position]")]
pub enum Place {
    /// A gear or disk.
    Body(String),
    /// A shaft and a position on it, m.
    Shaft(String, f64),
}

/// A torque about +x: a `value`, or what keeps the train in balance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torque {
    /// Where it acts.
    pub at: Place,
    /// Torque, N m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Whether it balances all the others.
    #[serde(default, skip_serializing_if = "is_no")]
    pub balance: bool,
}

impl SceneDescription {
    /// Reads a description from TOML; an entry of the wrong type or name is an error that says where.
    ///
    /// # Errors
    /// [`SceneError`] for text that is not TOML or does not fit the description.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let document =
            toml::Deserializer::parse(text).map_err(|error| SceneError::new("toml", error.to_string().trim_end()))?;
        Self::deserialize(document)
    }

    /// Reads a description from any serde source.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the entry that does not fit.
    pub fn deserialize<'source, D: serde::Deserializer<'source>>(source: D) -> Result<Self, SceneError> {
        reading::located(source)
    }

    /// Reads a description from a source that would convert truth values and texts to numbers, as Python's objects do.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the entry that does not fit.
    pub fn from_objects<'source, D: serde::Deserializer<'source>>(source: D) -> Result<Self, SceneError> {
        // Values keep the kind of every entry.
        Self::deserialize(reading::located::<toml::Value, D>(source)?)
    }

    /// Writes the description as TOML.
    ///
    /// # Errors
    /// [`SceneError`] if a value has no TOML form.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        toml::to_string(self).map_err(|error| SceneError::new("system", error))
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde requires this signature")]
fn is_no(flag: &bool) -> bool {
    !*flag
}
