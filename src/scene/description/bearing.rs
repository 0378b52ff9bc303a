//! Entries of bearings.

use serde::{Deserialize, Serialize};

use super::{Base, BearingCoefficient, Coefficient};

/// A bearing under a shaft: linear with `stiffness`, on the ground, a support or a housing; or a journal bearing on the ground
/// with `diameter` and the other entries of its film; or a rolling bearing with `elements` and the other entries of its elements.
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
    /// Loss factor η of its stiffness, K(1 + iη sgn ω), which analyses in the frequency domain contain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loss_factor: Option<f64>,
    /// Diameter of a journal, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter: Option<f64>,
    /// Length of a journal bearing, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Radial clearance of a journal bearing, m; radial internal clearance (from side to side) of a rolling bearing, m.
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
    /// Designation of a rolling bearing, e.g. "6308", from which its elements are estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub designation: Option<String>,
    /// Kind of a rolling bearing whose elements are estimated from its boundary.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<BearingKind>,
    /// Bore, outside diameter and width of a rolling bearing, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundary: Option<[f64; 3]>,
    /// Number of rolling elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elements: Option<u32>,
    /// Diameter of a rolling element, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element_diameter: Option<f64>,
    /// Diameter of the circle through the centres of the rolling elements, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_diameter: Option<f64>,
    /// Stiffness of one rolling element between both races, N/m^1.5 or N/m^(10/9); by default that of the geometry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hertz_stiffness: Option<f64>,
    /// Kind of the rolling elements; balls by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactKind>,
    /// Contact angle, rad, negative for a bearing that carries a load along −x; 0 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_angle: Option<f64>,
    /// Number of directions in which the rings move against each other: 2 (default) along y and z, 5 with the axis and the tilts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<u32>,
    /// Axial force with which a bearing with five degrees of freedom is mounted, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial_preload: Option<f64>,
    /// Angle of the first rolling element from y towards z at the shaft angle 0, rad; 0 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<f64>,
    /// Groove radius of the inner race over the diameter of its balls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inner_groove: Option<f64>,
    /// Groove radius of the outer race over the diameter of its balls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outer_groove: Option<f64>,
    /// Effective length of a roller, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roller_length: Option<f64>,
    /// Basic dynamic load rating of a rolling bearing, or of one that a linear bearing stands for, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamic_rating: Option<f64>,
    /// Basic static load rating, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_rating: Option<f64>,
    /// What it stands on; the ground by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<Base>,
}

impl Bearing {
    /// The bearing with the same stiffness, N/m, in both lateral directions instead of its own stiffness, film or elements, and
    /// without damping.
    pub fn with_stiffness(&self, stiffness: f64) -> Self {
        Self {
            shaft: self.shaft.clone(),
            position: self.position,
            stiffness: Some(BearingCoefficient::Constant(Coefficient::Isotropic(stiffness))),
            axial_stiffness: self.axial_stiffness,
            tilting_stiffness: self.tilting_stiffness,
            support: self.support.clone(),
            ..Self::default()
        }
    }

    /// Whether an entry of a rolling bearing is given. Contact and contact angle of a linear bearing with a rating are those of
    /// the rolling bearing for which it stands.
    pub fn is_rolling(&self) -> bool {
        let lengths = [self.element_diameter, self.pitch_diameter, self.hertz_stiffness, self.phase];
        let others = [self.inner_groove, self.outer_groove, self.roller_length, self.axial_preload];
        let catalogue = self.designation.is_some() || self.kind.is_some() || self.boundary.is_some();
        let is_rated_spring = self.stiffness.is_some() && self.dynamic_rating.is_some();
        catalogue
            || self.degrees_of_freedom.is_some()
            || self.elements.is_some()
            || (self.contact.is_some() || self.contact_angle.is_some()) && !is_rated_spring
            || lengths.iter().chain(&others).any(Option::is_some)
    }

    /// The entries of a journal bearing, and whether each is given.
    pub fn film_entries(&self) -> [(&'static str, bool); 6] {
        [
            ("diameter", self.diameter.is_some()),
            ("length", self.length.is_some()),
            ("clearance", self.clearance.is_some()),
            ("viscosity", self.viscosity.is_some()),
            ("film", self.film.is_some()),
            ("grooves", self.grooves.is_some()),
        ]
    }
}

/// Kind of a rolling bearing in a catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BearingKind {
    /// Deep groove ball bearing.
    DeepGroove,
    /// Angular contact ball bearing.
    AngularContact,
    /// Cylindrical roller bearing.
    CylindricalRoller,
    /// Tapered roller bearing.
    TaperedRoller,
    /// Needle roller and cage assembly, whose raceways are the shaft and the bore around it.
    NeedleCage,
}

/// Kind of rolling elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactKind {
    /// Balls: point contact.
    #[default]
    Ball,
    /// Cylindrical or tapered rollers: line contact.
    Roller,
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
