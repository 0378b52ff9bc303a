//! The description of a rotor system, as a TOML file or a Python dictionary contains it.
//!
//! These types check the types of the entries only; [`Scene::new`](super::Scene::new) checks the values. All units are
//! SI units and radians.

mod bearing;
mod damping;
mod housing;
mod loads;
mod reading;
mod shaft;
mod sources;
mod speed_table;
mod teeth;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

pub use bearing::{Bearing, BearingKind, ContactKind, FilmModel, Pad, Profile, Reduction, Rupture};
pub use damping::{ModalDampingGiven, RatioTable};
pub use housing::{Base, ElasticBody, Housing, Interface, Support};
pub use loads::{Coupling, Drive, Force, ForceValue, TimeSeries, TorqueTable, TorqueValue};
pub use shaft::{
    Bow, BowShape, Material, STEEL, STEEL_POISSON_RATIO, Segment, Shaft, Sleeve, SleeveStiffness, SleeveStiffnessWord,
};
pub use sources::{GroundQuantity, Source};
pub use speed_table::{BearingCoefficient, Coefficient, Outside, SpeedTable, TableValue};
pub use teeth::{
    Engagement, Foundation, FrictionTable, MeshFriction, Phase, Stiffness, StiffnessKind, StiffnessModel, TipRelief,
    TransmissionError,
};

use reading::whole;

use super::{Accuracy, SceneError};

/// Description of a rotor system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneDescription {
    /// Name of the reference shaft, to which speeds refer; the first shaft by default.
    pub reference: Option<String>,
    /// Damping ratios of the undamped modes; zero by default.
    pub modal_damping: Option<ModalDampingGiven>,
    /// Rayleigh damping αM + βK of the shafts: `[α, β]`, 1/s and s.
    pub rayleigh: Option<[f64; 2]>,
    /// Whether the axial forces of the static equilibrium change the stiffness of the shafts; false by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub geometric_stiffness: bool,
    /// Whether a bow turns with the twist of its shaft, and so has a moment about it; false by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub bow_torque: bool,
    /// Gravity, m/s².
    pub gravity: Option<Gravity>,
    /// Degrees of freedom of a node; by default those that the scene needs.
    pub motion: Option<MotionKind>,
    /// Elements that the description does not give, and modes and tolerance of runs; `engineering` by default.
    pub accuracy: Option<Accuracy>,
    /// Shafts.
    pub shafts: Vec<Shaft>,
    /// Sleeves around shafts.
    #[serde(default, skip_serializing_if = "is_default")]
    pub sleeves: Vec<Sleeve>,
    /// Gears.
    #[serde(default, skip_serializing_if = "is_default")]
    pub gears: Vec<Gear>,
    /// Rigid disks.
    #[serde(default, skip_serializing_if = "is_default")]
    pub disks: Vec<Disk>,
    /// Pairs of gears in mesh.
    #[serde(default, skip_serializing_if = "is_default")]
    pub meshes: Vec<Mesh>,
    /// Bearings.
    #[serde(default, skip_serializing_if = "is_default")]
    pub bearings: Vec<Bearing>,
    /// Torques on the shafts.
    #[serde(default, skip_serializing_if = "is_default")]
    pub torques: Vec<Torque>,
    /// Supports of bearings.
    #[serde(default, skip_serializing_if = "is_default")]
    pub supports: Vec<Support>,
    /// Housings, which carry several bearings.
    #[serde(default, skip_serializing_if = "is_default")]
    pub housings: Vec<Housing>,
    /// Couplings between shafts of one speed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub couplings: Vec<Coupling>,
    /// Drives, which hold the rotation.
    #[serde(default, skip_serializing_if = "is_default")]
    pub drives: Vec<Drive>,
    /// Lateral forces.
    #[serde(default, skip_serializing_if = "is_default")]
    pub forces: Vec<Force>,
    /// Notches of shafts, which only stresses depend on.
    #[serde(default, skip_serializing_if = "is_default")]
    pub notches: Vec<Notch>,
}

impl SceneDescription {
    /// The description without the entries that only determine loads: torques, forces, gravity, bows and unbalances. A torque
    /// over the speed stays, because its slope is a damping. The accuracy is absent too: of a model, it determines the elements alone.
    pub fn without_loads(&self) -> Self {
        let mut plain = Self { accuracy: None, ..self.clone() };
        plain.torques.retain(|torque| matches!(torque.value, Some(TorqueValue::Table(_))));
        plain.forces.clear();
        plain.notches.clear();
        plain.gravity = None;
        plain.shafts.iter_mut().for_each(|shaft| shaft.bow = None);
        plain.gears.iter_mut().for_each(|gear| gear.unbalance = None);
        plain.disks.iter_mut().for_each(|disk| disk.unbalance = None);
        plain
    }
}

/// Degrees of freedom of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// Lateral motion only: v, w, B, Γ.
    Lateral,
    /// Twist only: θ.
    Torsion,
    /// All: v, w, B, Γ, θ, and u where the scene has helical gears, axial forces or axial stiffness of bearings.
    Coupled,
}

/// Gravity as a number or as a vector, m/s².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number [m/s²] or a pair [y, z]")]
pub enum Gravity {
    /// Magnitude along −z, m/s².
    Down(f64),
    /// Components along y and z, m/s².
    Vector([f64; 2]),
}

/// A complex number as a real number or as `[re, im]`.
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

/// A notch of a shaft: a shoulder, a groove, a keyway or the end of a hub.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Notch {
    /// Name of the shaft.
    pub shaft: String,
    /// Position on the shaft, m.
    pub position: f64,
    /// Fatigue notch factor of bending and axial stresses.
    pub bending: Option<f64>,
    /// Fatigue notch factor of torsion.
    pub torsion: Option<f64>,
}

/// A rigid disk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disk {
    /// Name; unique in the system.
    pub name: String,
    /// Name of the shaft.
    pub shaft: String,
    /// Position on the shaft, m.
    pub position: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about a diameter, kg m².
    pub diametral_inertia: f64,
    /// Moment of inertia about the axis, kg m².
    pub polar_inertia: f64,
    /// Unbalance (mass times eccentricity), kg m, with its angle in the rotating shaft.
    pub unbalance: Option<Complex>,
}

/// A spur or helical gear. It needs `module` or `base_radius`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gear {
    /// Name; unique in the system.
    pub name: String,
    /// Name of the shaft.
    pub shaft: String,
    /// Position on the shaft, m.
    pub position: f64,
    /// Number of teeth.
    #[serde(deserialize_with = "whole")]
    pub teeth: u32,
    /// Whether the teeth point inwards: a ring gear.
    #[serde(default, skip_serializing_if = "is_default")]
    pub internal: bool,
    /// Module, m; of a helical gear the normal module.
    pub module: Option<f64>,
    /// Base radius, m.
    pub base_radius: Option<f64>,
    /// Face width, m.
    pub face_width: Option<f64>,
    /// Pressure angle of the basic rack, rad; 20° by default.
    pub pressure_angle: Option<f64>,
    /// Helix angle on the reference circle, rad, positive for a right-hand helix; a spur gear by default.
    pub helix_angle: Option<f64>,
    /// Profile shift coefficient.
    pub profile_shift: Option<f64>,
    /// Tip radius, m.
    pub tip_radius: Option<f64>,
    /// Mass, kg.
    pub mass: Option<f64>,
    /// Moment of inertia about a diameter, kg m².
    pub diametral_inertia: Option<f64>,
    /// Moment of inertia about the axis, kg m².
    pub polar_inertia: Option<f64>,
    /// Unbalance (mass times eccentricity), kg m, with its angle in the rotating shaft.
    pub unbalance: Option<Complex>,
    /// Run-out: offset of the base circle from the axis of the shaft, m, with its angle in the rotating shaft.
    pub runout: Option<Complex>,
}

/// A pair of gears in mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// Name of the driving gear.
    pub driver: String,
    /// Name of the driven gear.
    pub driven: String,
    /// Stiffness along the line of action, N/m, or a stiffness model; ISO 6336-1 by default.
    pub stiffness: Option<Stiffness>,
    /// Damping ratio ζ of the mesh, c = 2ζ√(k mₑ).
    pub damping_ratio: Option<f64>,
    /// Damping along the line of action, N s/m.
    pub damping: Option<f64>,
    /// Loss factor η of its stiffness, K(1 + iη sgn ω), which analyses in the frequency domain contain.
    pub loss_factor: Option<f64>,
    /// Whether the damping acts while the flanks are separated as well; only in contact by default.
    pub damping_in_separation: Option<bool>,
    /// Angle from y to the line of centres, driver to driven gear, rad.
    pub centre_line_angle: Option<f64>,
    /// Angle of the drive flank of a tooth of the driver on its base circle at the time zero, rad; 0 by default.
    pub tooth_angle: Option<f64>,
    /// Centre distance at rest, m; by default that without play, the sum of the pitch radii without profile shift (of a pair with
    /// an internal gear their difference).
    pub centre_distance: Option<f64>,
    /// Backlash along the line of action, m; by default the flanks never separate.
    pub backlash: Option<f64>,
    /// Tip relief of both gears.
    pub tip_relief: Option<TipRelief>,
    /// Unloaded transmission error.
    pub error: Option<TransmissionError>,
    /// Friction between the flanks: a coefficient, or a table; none by default.
    pub friction: Option<MeshFriction>,
    /// The turning carrier on which the planet of this mesh sits; none for gears on fixed axes.
    pub carrier: Option<Place>,
}

/// A gear or disk by name, or a position on a shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a gear, a disk, or a pair [shaft, position]")]
pub enum Place {
    /// Name of a gear or disk.
    Body(String),
    /// Name of a shaft and position on it, m.
    Shaft(String, f64),
}

/// A torque about +x: a `value`, or the torque that balances all others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torque {
    /// Place where the torque acts.
    pub at: Place,
    /// Torque, N m, constant or over time or speed.
    pub value: Option<TorqueValue>,
    /// Whether this torque balances all others.
    #[serde(default, skip_serializing_if = "is_default")]
    pub balance: bool,
}

impl SceneDescription {
    /// Reads a description from TOML.
    ///
    /// # Errors
    /// [`SceneError`] for invalid TOML, or with the path of an entry of the wrong type or name.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let document: toml::Table =
            toml::from_str(text).map_err(|error| SceneError::new("toml", error.to_string().trim_end()))?;
        Self::deserialize(toml::Value::Table(document)).map_err(|error| reading::with_line(error, text))
    }

    /// Reads a description from any serde source.
    ///
    /// # Errors
    /// [`SceneError`] with the path of an entry of the wrong type or name.
    pub fn deserialize<'source, D: serde::Deserializer<'source>>(source: D) -> Result<Self, SceneError> {
        reading::located(source)
    }

    /// Reads a description from Python objects, which convert booleans to numbers on request.
    ///
    /// # Errors
    /// [`SceneError`] with the path of an entry of the wrong type or name.
    pub fn from_objects<'source, D: serde::Deserializer<'source>>(source: D) -> Result<Self, SceneError> {
        // The intermediate `toml::Value` keeps the type of every entry, so that a boolean is not read as a number.
        Self::deserialize(reading::located::<toml::Value, D>(source)?)
    }

    /// Reads one bearing from Python objects.
    ///
    /// # Errors
    /// [`SceneError`] with the path of an entry of the wrong type or name.
    pub fn bearing_from_objects<'source, D: serde::Deserializer<'source>>(source: D) -> Result<Bearing, SceneError> {
        reading::located(reading::located::<toml::Value, D>(source)?)
    }

    /// Writes the description as TOML.
    ///
    /// # Errors
    /// [`SceneError`] if TOML cannot represent a value.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        toml::to_string(self).map_err(|error| SceneError::new("system", error))
    }
}

/// Whether an entry has its default value, which descriptions leave out.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
