//! Rolling bearing: check of its entries.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;

use super::description::{self, ContactKind};
use super::hertz::{ball_stiffness, roller_stiffness};
use super::{EntryPath, SceneError, catalogue, given};

/// Numbers of elements: fewer do not hold the shaft in every direction; the largest slewing bearings have about 300.
const ELEMENTS: RangeInclusive<u32> = 3..=1000;
/// Usual radius of a groove over the diameter of its balls.
const GROOVE_CONFORMITY: f64 = 0.52;

/// Geometry and contact of a rolling bearing.
#[derive(Clone, Debug, PartialEq)]
pub struct Rolling {
    /// Number n of rolling elements.
    pub elements: u32,
    /// Diameter of an element over the pitch diameter, d/D.
    pub diameter_ratio: f64,
    /// Pitch diameter D, m.
    pub pitch_diameter: f64,
    /// Groove radii of the inner and the outer race over the diameter of a ball.
    pub groove: [f64; 2],
    /// Radial internal clearance, the free motion of the shaft from side to side, m; negative for a preload.
    pub clearance: f64,
    /// Stiffness K of one element between both races, N/m^p.
    pub hertz_stiffness: f64,
    /// Whether the contact is a line (rollers) instead of a point (balls).
    pub line_contact: bool,
    /// Contact angle, rad; negative for a bearing that carries a load along −x.
    pub contact_angle: f64,
    /// Angle of the first element from y towards z at the shaft angle 0, rad.
    pub phase: f64,
    /// Axial force with which it is mounted, N, in the direction of the contact angle, or along the axis if that is 0, for a bearing with five degrees of freedom; none for one that moves along y and z.
    pub axial_preload: Option<f64>,
}

impl Rolling {
    /// Speed of the cage over the speed of the inner ring where the outer ring stands.
    pub fn cage_ratio(&self) -> f64 {
        (1.0 - self.diameter_ratio * self.contact_angle.cos()) / 2.0
    }

    /// Checks the entries of a bearing at the entry `at`; none for a bearing of another kind.
    ///
    /// # Errors
    /// [`SceneError`] for entries of another kind of bearing, a missing entry, elements that do not fit on the pitch circle, and
    /// values that are not possible.
    pub(super) fn new(given: &description::Bearing, at: &EntryPath) -> Result<Option<Self>, SceneError> {
        if !given.is_rolling() {
            return Ok(None);
        }
        let given = &catalogue::completed(given, at)?;
        let film = given.film_entries().into_iter().filter(|(name, _)| *name != "clearance");
        let others: Vec<_> = film.chain(given![given; stiffness]).collect();
        at.refuse(&others, "a rolling bearing takes none; leave it out, or leave out elements, element_diameter, pitch_diameter and the other entries of a rolling bearing")?;
        let needed = |name: &str, value: Option<f64>| {
            let missing = || at.error(format!("missing field `{name}` of the rolling bearing"));
            value.ok_or_else(missing)
        };
        let elements = given.elements.ok_or_else(|| at.error("missing field `elements` of the rolling bearing"))?;
        let diameter = at.field("element_diameter").positive(needed("element_diameter", given.element_diameter)?)?;
        let pitch = at.field("pitch_diameter").positive(needed("pitch_diameter", given.pitch_diameter)?)?;
        check_fit(elements, diameter, pitch, at)?;
        let clearance = at.field("clearance").finite(needed("clearance", given.clearance)?)?;
        if clearance.abs() >= diameter {
            let message = format!(
                "must be below element_diameter, {diameter} m, in size, got {clearance}; usual are 5e-6 to 1e-4 m, and a negative one is a preload"
            );
            return Err(at.field("clearance").error(message));
        }
        let contact_angle = at.field("contact_angle").finite(given.contact_angle.unwrap_or(0.0))?;
        if contact_angle.abs() >= FRAC_PI_2 {
            let message = format!("must be between -pi/2 and pi/2 rad, got {contact_angle}; is it in degrees?");
            return Err(at.field("contact_angle").error(message));
        }
        let line_contact = given.contact == Some(ContactKind::Roller);
        let ratio = diameter / pitch;
        let (hertz_stiffness, groove) = if line_contact {
            (line_stiffness(given, at)?, [GROOVE_CONFORMITY; 2])
        } else {
            point_contact(given, diameter, ratio, contact_angle, at)?
        };
        let phase = at.field("phase").finite(given.phase.unwrap_or(0.0))?;
        let axial_preload = axial_preload(given, line_contact, contact_angle, at)?;
        Ok(Some(Self {
            elements,
            diameter_ratio: ratio,
            pitch_diameter: pitch,
            groove,
            clearance,
            hertz_stiffness,
            line_contact,
            contact_angle,
            phase,
            axial_preload,
        }))
    }
}

/// Axial force with which a bearing with five degrees of freedom is mounted; none for a bearing with two.
fn axial_preload(
    given: &description::Bearing,
    line_contact: bool,
    contact_angle: f64,
    at: &EntryPath,
) -> Result<Option<f64>, SceneError> {
    match given.degrees_of_freedom {
        None | Some(2) => match given.axial_preload {
            Some(_) => Err(at.field("axial_preload").error("needs degrees_of_freedom = 5; give it, or leave this out")),
            None => Ok(None),
        },
        Some(5) => {
            for (name, value) in
                [("axial_stiffness", given.axial_stiffness), ("tilting_stiffness", given.tilting_stiffness)]
            {
                if value.is_some_and(|value| value != 0.0) {
                    let message =
                        "follows from the rolling elements of a bearing with degrees_of_freedom = 5; leave it out";
                    return Err(at.field(name).error(message));
                }
            }
            let place = at.field("axial_preload");
            let force = place.finite(given.axial_preload.unwrap_or(0.0))?;
            if force < 0.0 && contact_angle != 0.0 {
                let message =
                    format!("must not be negative, got {force}: it acts in the direction of the contact angle");
                return Err(place.error(message));
            }
            if force != 0.0 && line_contact && contact_angle == 0.0 {
                return Err(
                    place.error("cannot press rollers with the contact angle 0; leave it out, or give contact_angle")
                );
            }
            Ok(Some(force))
        }
        Some(other) => {
            let message = format!("must be 2 (along y and z) or 5 (with the axis and the tilts), got {other}");
            Err(at.field("degrees_of_freedom").error(message))
        }
    }
}

/// Refuses elements that do not fit on the pitch circle.
fn check_fit(elements: u32, diameter: f64, pitch: f64, at: &EntryPath) -> Result<(), SceneError> {
    if !ELEMENTS.contains(&elements) {
        let (least, most) = ELEMENTS.into_inner();
        let message = format!("must be between {least} and {most}, got {elements}; fewer do not hold the shaft");
        return Err(at.field("elements").error(message));
    }
    if diameter >= pitch {
        let message =
            format!("must be below pitch_diameter, {pitch} m, got {diameter}; pitch_diameter goes through the centres");
        return Err(at.field("element_diameter").error(message));
    }
    let distance = pitch * (PI / f64::from(elements)).sin();
    if distance < diameter {
        let most = (PI / (diameter / pitch).asin()).floor();
        let message = format!(
            "{elements} elements of {diameter} m overlap on a pitch circle of {pitch} m, where their centres are {distance:.6} m apart; at most {most} fit"
        );
        return Err(at.field("elements").error(message));
    }
    Ok(())
}

/// Stiffness of a ball, the given one or that of its geometry, and its groove radii.
fn point_contact(
    given: &description::Bearing,
    diameter: f64,
    ratio: f64,
    contact_angle: f64,
    at: &EntryPath,
) -> Result<(f64, [f64; 2]), SceneError> {
    if given.roller_length.is_some() {
        return Err(at.field("roller_length").error("a ball has none; give contact=\"roller\""));
    }
    let radius = |name: &str, value: Option<f64>| {
        let found = at.field(name).finite(value.unwrap_or(GROOVE_CONFORMITY))?;
        if found > 0.5 {
            return Ok(found);
        }
        let message = format!(
            "radius of the groove over element_diameter must be above 0.5, got {found}; usual are 0.515 to 0.53"
        );
        Err(at.field(name).error(message))
    };
    let groove = [radius("inner_groove", given.inner_groove)?, radius("outer_groove", given.outer_groove)?];
    let stiffness = match given.hertz_stiffness {
        Some(stiffness) => at.field("hertz_stiffness").positive(stiffness)?,
        None => ball_stiffness(diameter, ratio, contact_angle, groove),
    };
    Ok((stiffness, groove))
}

/// Stiffness of a roller: the given one, or that of its length.
fn line_stiffness(given: &description::Bearing, at: &EntryPath) -> Result<f64, SceneError> {
    at.refuse(&given![given; inner_groove, outer_groove], "a roller has none; leave it out, or give contact=\"ball\"")?;
    let length = given.roller_length.map(|length| at.field("roller_length").positive(length)).transpose()?;
    match (given.hertz_stiffness, length) {
        (Some(stiffness), _) => at.field("hertz_stiffness").positive(stiffness),
        (None, Some(length)) => Ok(roller_stiffness(length)),
        (None, None) => Err(at.error(
            "missing field `roller_length` or `hertz_stiffness` of the roller bearing, from which its stiffness follows",
        )),
    }
}
