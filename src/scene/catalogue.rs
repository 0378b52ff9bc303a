//! Rolling bearings from their boundary dimensions or their designation: number and size of the rolling elements as estimates.
//!
//! Catalogues give bore d, outside diameter D and width B, not what rolls inside. The estimates:
//!
//! | kind | element diameter | elements | length |
//! |---|---|---|---|
//! | deep groove | 0.3 (D − d) | assembly angle 186°: 1 + 93°/asin(D_w/D_pw) | |
//! | angular contact | 0.3 (D − d) | distance of 1.15 D_w on the pitch circle | |
//! | cylindrical rollers | 0.25 (D − d) | distance of 1.45 D_w | B/2 |
//! | tapered rollers | 0.25 (D − d) | distance of 1.1 D_w | 0.7 B |
//! | needle cage | (D − d)/2, exact | distance of 1.6 D_w | 0.8 B |
//!
//! with the pitch diameter (D + d)/2. The relation of the assembly angle to the number of balls is that of Harris (Rolling
//! Bearing Analysis, 4th ed., 2001, chapter 2). The factors of the first rows reproduce the 209 and 218 bearings and the 209
//! roller bearing of its chapters 2 and 7 and the bearings that `tests/python/bearings/test_catalogue.py` lists; those of
//! tapered rollers and needle cages are usual proportions.

use serde::Serialize;

use super::description::{Bearing, BearingKind, ContactKind};
use super::{EntryPath, SceneError};

/// A size of a series.
struct Size {
    /// Bore code, the last two digits of a designation.
    code: u32,
    /// Outside diameter D, mm.
    outer: f64,
    /// Width B, or T of a tapered roller bearing, mm.
    width: f64,
    /// Contact angle, degrees.
    angle: f64,
}

const fn size(code: u32, outer: f64, width: f64) -> Size {
    Size { code, outer, width, angle: 0.0 }
}

const fn tapered(code: u32, outer: f64, width: f64, angle: f64) -> Size {
    Size { code, outer, width, angle }
}

/// Dimension series 10 of ISO 15.
#[rustfmt::skip]
const SERIES_60: [Size; 27] = [
    size(0, 26.0, 8.0), size(1, 28.0, 8.0), size(2, 32.0, 9.0), size(3, 35.0, 10.0), size(4, 42.0, 12.0),
    size(5, 47.0, 12.0), size(6, 55.0, 13.0), size(7, 62.0, 14.0), size(8, 68.0, 15.0), size(9, 75.0, 16.0),
    size(10, 80.0, 16.0), size(11, 90.0, 18.0), size(12, 95.0, 18.0), size(13, 100.0, 18.0), size(14, 110.0, 20.0),
    size(15, 115.0, 20.0), size(16, 125.0, 22.0), size(17, 130.0, 22.0), size(18, 140.0, 24.0), size(19, 145.0, 24.0),
    size(20, 150.0, 24.0), size(21, 160.0, 26.0), size(22, 170.0, 28.0), size(24, 180.0, 28.0), size(26, 200.0, 33.0),
    size(28, 210.0, 33.0), size(30, 225.0, 35.0),
];
/// Dimension series 02 of ISO 15.
#[rustfmt::skip]
const SERIES_62: [Size; 27] = [
    size(0, 30.0, 9.0), size(1, 32.0, 10.0), size(2, 35.0, 11.0), size(3, 40.0, 12.0), size(4, 47.0, 14.0),
    size(5, 52.0, 15.0), size(6, 62.0, 16.0), size(7, 72.0, 17.0), size(8, 80.0, 18.0), size(9, 85.0, 19.0),
    size(10, 90.0, 20.0), size(11, 100.0, 21.0), size(12, 110.0, 22.0), size(13, 120.0, 23.0), size(14, 125.0, 24.0),
    size(15, 130.0, 25.0), size(16, 140.0, 26.0), size(17, 150.0, 28.0), size(18, 160.0, 30.0), size(19, 170.0, 32.0),
    size(20, 180.0, 34.0), size(21, 190.0, 36.0), size(22, 200.0, 38.0), size(24, 215.0, 40.0), size(26, 230.0, 40.0),
    size(28, 250.0, 42.0), size(30, 270.0, 45.0),
];
/// Dimension series 03 of ISO 15.
#[rustfmt::skip]
const SERIES_63: [Size; 27] = [
    size(0, 35.0, 11.0), size(1, 37.0, 12.0), size(2, 42.0, 13.0), size(3, 47.0, 14.0), size(4, 52.0, 15.0),
    size(5, 62.0, 17.0), size(6, 72.0, 19.0), size(7, 80.0, 21.0), size(8, 90.0, 23.0), size(9, 100.0, 25.0),
    size(10, 110.0, 27.0), size(11, 120.0, 29.0), size(12, 130.0, 31.0), size(13, 140.0, 33.0), size(14, 150.0, 35.0),
    size(15, 160.0, 37.0), size(16, 170.0, 39.0), size(17, 180.0, 41.0), size(18, 190.0, 43.0), size(19, 200.0, 45.0),
    size(20, 215.0, 47.0), size(21, 225.0, 49.0), size(22, 240.0, 50.0), size(24, 260.0, 55.0), size(26, 280.0, 58.0),
    size(28, 300.0, 62.0), size(30, 320.0, 65.0),
];
/// Tapered roller bearings 320..X of ISO 355, with the width T of the assembled bearing.
#[rustfmt::skip]
const SERIES_320: [Size; 23] = [
    tapered(4, 42.0, 15.0, 14.0), tapered(5, 47.0, 15.0, 16.0), tapered(6, 55.0, 17.0, 16.0),
    tapered(7, 62.0, 18.0, 16.833), tapered(8, 68.0, 19.0, 14.167), tapered(9, 75.0, 20.0, 14.667),
    tapered(10, 80.0, 20.0, 15.75), tapered(11, 90.0, 23.0, 15.167), tapered(12, 95.0, 23.0, 16.0),
    tapered(13, 100.0, 23.0, 17.0), tapered(14, 110.0, 25.0, 16.167), tapered(15, 115.0, 25.0, 17.0),
    tapered(16, 125.0, 29.0, 15.75), tapered(17, 130.0, 29.0, 16.417), tapered(18, 140.0, 32.0, 15.75),
    tapered(19, 145.0, 32.0, 16.417), tapered(20, 150.0, 32.0, 17.0), tapered(21, 160.0, 35.0, 16.5),
    tapered(22, 170.0, 38.0, 16.0), tapered(24, 180.0, 38.0, 17.0), tapered(26, 200.0, 45.0, 16.167),
    tapered(28, 210.0, 45.0, 17.0), tapered(30, 225.0, 48.0, 17.0),
];

/// A series of designations.
struct Series {
    prefix: &'static str,
    kind: BearingKind,
    sizes: &'static [Size],
}

/// The known series.
const SERIES: [Series; 6] = [
    Series { prefix: "60", kind: BearingKind::DeepGroove, sizes: &SERIES_60 },
    Series { prefix: "62", kind: BearingKind::DeepGroove, sizes: &SERIES_62 },
    Series { prefix: "63", kind: BearingKind::DeepGroove, sizes: &SERIES_63 },
    Series { prefix: "N2", kind: BearingKind::CylindricalRoller, sizes: &SERIES_62 },
    Series { prefix: "NU2", kind: BearingKind::CylindricalRoller, sizes: &SERIES_62 },
    Series { prefix: "320", kind: BearingKind::TaperedRoller, sizes: &SERIES_320 },
];

/// What is known of a bearing before its elements are estimated.
struct Known {
    kind: BearingKind,
    /// Bore, outside diameter and width, m.
    boundary: [f64; 3],
    /// Contact angle, rad.
    contact_angle: f64,
}

/// Elements that a kind and boundary dimensions have in the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Estimate {
    /// Kind of the bearing.
    pub kind: BearingKind,
    /// Bore d, m.
    pub bore: f64,
    /// Outside diameter D, m.
    pub outer: f64,
    /// Width B, m.
    pub width: f64,
    /// Number of elements.
    pub elements: u32,
    /// Diameter of an element, m.
    pub element_diameter: f64,
    /// Pitch diameter, m.
    pub pitch_diameter: f64,
    /// Effective length of a roller, m; none for balls.
    pub roller_length: Option<f64>,
    /// Contact angle, rad.
    pub contact_angle: f64,
    /// Relative uncertainty of the stiffness under a load, from that of number, sizes and groove radii of the elements.
    pub stiffness_uncertainty: f64,
}

/// The estimate of a bearing with a designation or with kind and boundary; none for another one.
///
/// # Errors
/// [`SceneError`] for an unknown designation, impossible dimensions, and a designation beside dimensions.
pub(crate) fn estimate(given: &Bearing, at: &EntryPath) -> Result<Option<Estimate>, SceneError> {
    let known = match (&given.designation, given.boundary) {
        (None, None) => {
            return match given.kind {
                None => Ok(None),
                Some(_) => Err(at.error("missing field `boundary`, [bore, outer, width], of a bearing with a kind")),
            };
        }
        (Some(_), Some(_)) => {
            return Err(at.field("boundary").error("belongs to the designation; leave one of them out"));
        }
        (Some(name), None) => {
            if given.kind.is_some() {
                return Err(at.field("kind").error("belongs to the designation; leave one of them out"));
            }
            designated(name, &at.field("designation"))?
        }
        (None, Some(boundary)) => {
            let kind = given.kind.ok_or_else(|| at.error("missing field `kind` of a bearing with a boundary"))?;
            check_boundary(boundary, &at.field("boundary"))?;
            let usual_angle: f64 = match kind {
                BearingKind::AngularContact => 40.0,
                BearingKind::TaperedRoller => 15.0,
                BearingKind::DeepGroove | BearingKind::CylindricalRoller | BearingKind::NeedleCage => 0.0,
            };
            Known { kind, boundary, contact_angle: usual_angle.to_radians() }
        }
    };
    Ok(Some(elements_of(&known)))
}

/// The bearing with the entries of its estimate where it gives none; itself without designation and boundary.
///
/// # Errors
/// [`SceneError`] as for [`estimate`].
pub(super) fn completed(given: &Bearing, at: &EntryPath) -> Result<Bearing, SceneError> {
    let Some(estimate) = estimate(given, at)? else {
        return Ok(given.clone());
    };
    let mut complete = given.clone();
    let contact = if estimate.roller_length.is_some() { ContactKind::Roller } else { ContactKind::Ball };
    if given.contact.is_some_and(|given| given != contact) {
        return Err(at.field("contact").error("differs from that of the kind or designation; leave it out"));
    }
    complete.contact = Some(contact);
    complete.elements = given.elements.or(Some(estimate.elements));
    complete.element_diameter = given.element_diameter.or(Some(estimate.element_diameter));
    complete.pitch_diameter = given.pitch_diameter.or(Some(estimate.pitch_diameter));
    complete.roller_length = given.roller_length.or(estimate.roller_length);
    complete.contact_angle = given.contact_angle.or(Some(estimate.contact_angle));
    complete.clearance = given.clearance.or(Some(0.0));
    Ok(complete)
}

/// Kind, boundary dimensions and contact angle of a designation.
fn designated(name: &str, at: &EntryPath) -> Result<Known, SceneError> {
    let plain: String = name.trim().to_uppercase().chars().filter(|sign| !sign.is_whitespace()).collect();
    let found = SERIES.iter().find_map(|series| {
        let code = plain.strip_prefix(series.prefix)?;
        let code =
            if series.kind == BearingKind::TaperedRoller { code.strip_suffix('X').unwrap_or(code) } else { code };
        let two_digits = code.len() == 2 && code.bytes().all(|digit| digit.is_ascii_digit());
        let code: u32 = two_digits.then(|| code.parse().ok())??;
        series.sizes.iter().find(|size| size.code == code).map(|size| (series.kind, size))
    });
    let Some((kind, size)) = found else {
        return Err(at.error(format!("\"{name}\" is not known; known are {}, without suffixes; give kind and boundary, or elements, element_diameter and pitch_diameter", known_designations())));
    };
    // The code of a larger bore is the bore, mm, over 5.
    let bore = match size.code {
        0 => 10.0,
        1 => 12.0,
        2 => 15.0,
        3 => 17.0,
        code => 5.0 * f64::from(code),
    };
    let boundary = [bore, size.outer, size.width].map(|length| length / 1000.0);
    Ok(Known { kind, boundary, contact_angle: size.angle.to_radians() })
}

/// Text that lists the known designations of each series, for example "6000 to 6030".
fn known_designations() -> String {
    let range = |series: &Series| {
        let code = |size: Option<&Size>| size.map_or(0, |size| size.code);
        let (first, last) = (code(series.sizes.first()), code(series.sizes.last()));
        format!("{0}{first:02} to {0}{last:02}", series.prefix)
    };
    SERIES.iter().map(range).collect::<Vec<_>>().join(", ")
}

fn check_boundary(boundary: [f64; 3], at: &EntryPath) -> Result<(), SceneError> {
    for (index, length) in boundary.iter().enumerate() {
        at.index(index).positive(*length)?;
    }
    let [bore, outer, _] = boundary;
    if outer <= bore {
        return Err(at.index(1).error(format!("must be above the bore, {bore} m, got {outer}")));
    }
    Ok(())
}

/// The estimate of number and size of the elements.
fn elements_of(known: &Known) -> Estimate {
    let [bore, outer, width] = known.boundary;
    let (section, pitch) = (outer - bore, (outer + bore) / 2.0);
    // Elements at a distance on the pitch circle, relative to their diameter.
    let spaced = |diameter: f64, distance: f64| (std::f64::consts::PI * pitch / (distance * diameter)).floor();
    let (diameter, count, length, uncertainty) = match known.kind {
        BearingKind::DeepGroove => {
            let diameter = 0.3 * section;
            (diameter, (1.0 + 93.0_f64.to_radians() / (diameter / pitch).asin()).round(), None, 0.15)
        }
        BearingKind::AngularContact => (0.3 * section, spaced(0.3 * section, 1.15), None, 0.15),
        BearingKind::CylindricalRoller => (0.25 * section, spaced(0.25 * section, 1.45), Some(0.5 * width), 0.25),
        BearingKind::TaperedRoller => (0.25 * section, spaced(0.25 * section, 1.1), Some(0.7 * width), 0.3),
        BearingKind::NeedleCage => (0.5 * section, spaced(0.5 * section, 1.6), Some(0.8 * width), 0.3),
    };
    Estimate {
        kind: known.kind,
        bore,
        outer,
        width,
        elements: count as u32,
        element_diameter: diameter,
        pitch_diameter: pitch,
        roller_length: length,
        contact_angle: known.contact_angle,
        stiffness_uncertainty: uncertainty,
    }
}
