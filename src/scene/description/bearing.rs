//! Entries of bearings.

use serde::{Deserialize, Serialize};

use super::{Base, BearingCoefficient, Coefficient, Complex};
use crate::scene::given;

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
    pub stiffness: Option<BearingCoefficient>,
    /// Damping, N s/m.
    pub damping: Option<BearingCoefficient>,
    /// Stiffness along the axis of the shaft, N/m.
    pub axial_stiffness: Option<f64>,
    /// Damping along the axis of the shaft, N s/m.
    pub axial_damping: Option<f64>,
    /// Stiffness against rotations about y and z, N m/rad.
    pub tilting_stiffness: Option<f64>,
    /// Damping of rotations about y and z, N m s/rad.
    pub tilting_damping: Option<f64>,
    /// Loss factor η of its stiffness, K(1 + iη sgn ω), which analyses in the frequency domain contain.
    pub loss_factor: Option<f64>,
    /// Distance of the centre of the bearing from its place in the drawing, y + iz, m.
    pub misalignment: Option<Complex>,
    /// Diameter of a journal, m.
    pub diameter: Option<f64>,
    /// Length of a journal bearing, m.
    pub length: Option<f64>,
    /// Radial clearance of a journal bearing, m; radial internal clearance (from side to side) of a rolling bearing, m.
    pub clearance: Option<f64>,
    /// Dynamic viscosity of the oil, Pa s.
    pub viscosity: Option<f64>,
    /// Model of the film; by default short for a plain profile, else finite.
    pub film: Option<FilmModel>,
    /// Axial grooves of a finite film: angle of the middle from y towards z, and extent, rad.
    pub grooves: Option<Vec<[f64; 2]>>,
    /// Profile of a journal bearing; plain by default.
    pub profile: Option<Profile>,
    /// Preload m of the lobes of a profile or of tilting pads.
    pub preload: Option<f64>,
    /// Closest place of a lobe, or pivot of a tilting pad, as a part of its extent in the direction of rotation.
    pub offset: Option<f64>,
    /// Angle by which a profile is turned from y towards z, rad.
    pub orientation: Option<f64>,
    /// Pads of a journal bearing of another profile.
    pub pads: Option<Vec<Pad>>,
    /// Number of tilting pads.
    pub pad_count: Option<u32>,
    /// Extent of the arc of a tilting pad, rad; 5/6 of its share of the turn by default.
    pub pad_extent: Option<f64>,
    /// Moment of inertia of a tilting pad about its pivot, kg m².
    pub pad_inertia: Option<f64>,
    /// Mass of a tilting pad on a flexible pivot, kg.
    pub pad_mass: Option<f64>,
    /// Stiffness of the pivots along their radius, N/m; rigid by default.
    pub pivot_stiffness: Option<f64>,
    /// Whether linear analyses have the tilts as coordinates or coefficients in which they are eliminated.
    pub reduced: Option<Reduction>,
    /// Where a finite film ruptures; by Reynolds' condition by default.
    pub rupture: Option<Rupture>,
    /// Designation of a rolling bearing, e.g. "6308", from which its elements are estimated.
    pub designation: Option<String>,
    /// Kind of a rolling bearing whose elements are estimated from its boundary.
    pub kind: Option<BearingKind>,
    /// Bore, outside diameter and width of a rolling bearing, m.
    pub boundary: Option<[f64; 3]>,
    /// Number of rolling elements.
    pub elements: Option<u32>,
    /// Diameter of a rolling element, m.
    pub element_diameter: Option<f64>,
    /// Diameter of the circle through the centres of the rolling elements, m.
    pub pitch_diameter: Option<f64>,
    /// Stiffness of one rolling element between both races, N/m^1.5 or N/m^(10/9); by default that of the geometry.
    pub hertz_stiffness: Option<f64>,
    /// Kind of the rolling elements; balls by default.
    pub contact: Option<ContactKind>,
    /// Contact angle, rad, negative for a bearing that carries a load along −x; 0 by default.
    pub contact_angle: Option<f64>,
    /// Number of directions in which the rings move against each other: 2 (default) along y and z, 5 with the axis and the tilts.
    pub degrees_of_freedom: Option<u32>,
    /// Axial force with which a bearing with five degrees of freedom is mounted, N.
    pub axial_preload: Option<f64>,
    /// Angle of the first rolling element from y towards z at the shaft angle 0, rad; 0 by default.
    pub phase: Option<f64>,
    /// Groove radius of the inner race over the diameter of its balls.
    pub inner_groove: Option<f64>,
    /// Groove radius of the outer race over the diameter of its balls.
    pub outer_groove: Option<f64>,
    /// Effective length of a roller, m.
    pub roller_length: Option<f64>,
    /// Basic dynamic load rating of a rolling bearing, or of one that a linear bearing stands for, N.
    pub dynamic_rating: Option<f64>,
    /// Basic static load rating, N.
    pub static_rating: Option<f64>,
    /// What it stands on; the ground by default.
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
        let is_rated_spring = self.stiffness.is_some() && self.dynamic_rating.is_some();
        let entries = given![self; designation, kind, boundary, degrees_of_freedom, elements, element_diameter, pitch_diameter,
            hertz_stiffness, phase, inner_groove, outer_groove, roller_length, axial_preload];
        entries.iter().any(|(_, is_given)| *is_given)
            || (self.contact.is_some() || self.contact_angle.is_some()) && !is_rated_spring
    }

    /// The entries of a journal bearing, and whether each is given.
    pub fn film_entries(&self) -> [(&'static str, bool); 18] {
        given![self; diameter, length, clearance, viscosity, film, grooves, profile, preload, offset, orientation, pads, rupture,
            pad_count, pad_extent, pad_inertia, pad_mass, pivot_stiffness, reduced]
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

/// Profile of the bore of a journal bearing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Profile {
    /// Cylinder.
    #[default]
    #[serde(rename = "plain")]
    Plain,
    /// Cylinder with axial grooves at y and −y.
    #[serde(rename = "two axial grooves")]
    Grooves,
    /// Two lobes above each other (elliptical).
    #[serde(rename = "lemon")]
    Lemon,
    /// Two halves displaced along their joint.
    #[serde(rename = "offset")]
    Offset,
    /// Three lobes, one of them at −z.
    #[serde(rename = "three-lobe")]
    ThreeLobe,
    /// Four lobes, with a groove at −z.
    #[serde(rename = "four-lobe")]
    FourLobe,
}

/// Frequency for which the tilts of pads are eliminated from the coefficients of a bearing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reduction {
    /// That of the rotation of the shaft.
    Synchronous,
    /// That of each mode: the tilts stay coordinates.
    Own,
}

/// Where a film ruptures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rupture {
    /// Where the pressure and its gradient vanish.
    #[default]
    Reynolds,
    /// Where the pressure of the film without rupture is negative (Gümbel).
    Gumbel,
}

/// A pad of a journal bearing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pad {
    /// Angle from y towards z at which its arc begins, rad.
    pub begin: f64,
    /// Extent of its arc, rad.
    pub extent: f64,
    /// Axial length, m; that of the bearing by default.
    pub length: Option<f64>,
    /// Radial clearance of the pad, m; that of the bearing by default.
    pub clearance: Option<f64>,
    /// Preload m = 1 − bearing clearance/pad clearance; 0 by default.
    pub preload: Option<f64>,
    /// Place closest to the centred journal, as a part of the extent in the direction of rotation; 0.5 by default.
    pub offset: Option<f64>,
}
