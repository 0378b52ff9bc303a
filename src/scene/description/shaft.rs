//! Description of a shaft: sections, material and residual bow.

use serde::{Deserialize, Serialize};

use super::reading::some_whole;

/// An isotropic elastic material. It needs one of `poisson_ratio` and `shear_modulus`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Poisson's ratio.
    pub poisson_ratio: Option<f64>,
    /// Shear modulus, Pa.
    pub shear_modulus: Option<f64>,
}

/// Poisson's ratio of steel.
pub const STEEL_POISSON_RATIO: f64 = 0.3;
/// Steel: 207 GPa, Poisson's ratio 0.3, 7850 kg/m³.
pub const STEEL: Material =
    Material { youngs_modulus: 207e9, density: 7850.0, poisson_ratio: Some(STEEL_POISSON_RATIO), shear_modulus: None };

/// A shaft: uniform (`length`, `outer_diameter`, …, `elements`) or stepped (`segments`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shaft {
    /// Name; unique in the system.
    pub name: String,
    /// Length, m.
    pub length: Option<f64>,
    /// Outer diameter, m.
    pub outer_diameter: Option<f64>,
    /// Inner diameter, m; zero by default.
    pub inner_diameter: Option<f64>,
    /// Smallest number of elements.
    #[serde(default, deserialize_with = "some_whole")]
    pub elements: Option<usize>,
    /// Degree of the elements; one by default.
    #[serde(default, deserialize_with = "some_whole")]
    pub degree: Option<usize>,
    /// Whether shear deformation is modelled; true by default.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub shear: bool,
    /// Material; steel by default.
    pub material: Option<Material>,
    /// Axial force, N, positive for tension; zero by default.
    pub axial_force: Option<f64>,
    /// Internal damping β, s: the viscous damping βK of the shaft in coordinates that rotate with it; zero by default.
    pub internal_damping: Option<f64>,
    /// Loss factor η of the material: K(1 + iη sgn(ω − Ω)) in linear analyses; zero by default.
    pub loss_factor: Option<f64>,
    /// Residual bow.
    pub bow: Option<Bow>,
    /// Speed relative to the reference shaft, of a shaft that no mesh or coupling connects to it.
    pub speed_ratio: Option<f64>,
    /// Segments of a stepped shaft, from x = 0.
    pub segments: Option<Vec<Segment>>,
}

impl Shaft {
    /// Whether the description gives no number of elements.
    pub fn is_automatic(&self) -> bool {
        let mut segments = self.segments.iter().flatten();
        self.elements.is_none() && segments.all(|segment| segment.elements.is_none())
    }
}

/// A part of a shaft: a cylinder, or a cone with other diameters at its end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Length, m.
    pub length: f64,
    /// Outer diameter at its begin, m.
    pub outer_diameter: f64,
    /// Inner diameter at its begin, m; zero by default.
    #[serde(default)]
    pub inner_diameter: f64,
    /// Outer diameter at its end, m; that at its begin by default.
    pub end_outer_diameter: Option<f64>,
    /// Inner diameter at its end, m; that at its begin by default.
    pub end_inner_diameter: Option<f64>,
    /// Material; that of the shaft by default.
    pub material: Option<Material>,
    /// Smallest number of elements.
    #[serde(default, deserialize_with = "some_whole")]
    pub elements: Option<usize>,
}

/// A tube around a shaft between two positions, such as an impeller hub, a coupling hub or a shrunk ring. Its mass and inertia
/// always belong to the shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sleeve {
    /// Name of the shaft.
    pub shaft: String,
    /// Position of its begin, m.
    pub begin: f64,
    /// Position of its end, m.
    pub end: f64,
    /// Outer diameter, m.
    pub outer_diameter: f64,
    /// Inner diameter, m.
    pub inner_diameter: f64,
    /// Material; steel by default.
    pub material: Option<Material>,
    /// What it adds to the stiffness of the shaft; nothing by default.
    pub stiffness: Option<SleeveStiffness>,
}

/// What a sleeve adds to the stiffness of its shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"none\", \"full\" or a number from 0 to 1")]
pub enum SleeveStiffness {
    /// Nothing, or all of its own stiffness.
    Word(SleeveStiffnessWord),
    /// A fraction of its own stiffness.
    Fraction(f64),
}

/// A word for the stiffness of a sleeve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SleeveStiffnessWord {
    /// Mass only.
    None,
    /// All of its own stiffness.
    Full,
}

/// Shape of a residual bow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BowShape {
    /// A sine with one half wave over the length.
    HalfSine,
    /// The static sag of the shaft between its bearings.
    Sag,
    /// A sine with `number` half waves over the length.
    Mode,
    /// A curve through measured points.
    Points,
}

/// A residual bow: the shape and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bow {
    /// Shape of the curve.
    pub shape: BowShape,
    /// Largest deflection, m.
    pub amplitude: Option<f64>,
    /// Angle in the rotating shaft, rad.
    pub phase: Option<f64>,
    /// Number of half waves over the length.
    #[serde(default, deserialize_with = "some_whole")]
    pub number: Option<u32>,
    /// Positions of the points on the shaft, m.
    pub positions: Option<Vec<f64>>,
    /// Deflection at each point, m.
    pub amplitudes: Option<Vec<f64>>,
    /// Angle in the rotating shaft at each point, rad.
    pub phases: Option<Vec<f64>>,
}

fn yes() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde requires this signature")]
fn is_true(flag: &bool) -> bool {
    *flag
}
