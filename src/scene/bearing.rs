//! Checked bearings.

use std::f64::consts::FRAC_PI_2;

use num_complex::Complex64;

use super::place::Names;
use super::{
    Attachment, BearingCoefficient, EntryPath, Journal, Matrix2, Node, Rolling, SceneDescription, SceneError, Shaft,
    SpringDamper, complex, description,
};

/// A bearing.
#[derive(Clone, Debug)]
pub struct Bearing {
    /// Node of the shaft.
    pub node: Node,
    /// Stiffness over (y, z), N/m.
    pub stiffness: BearingCoefficient,
    /// Damping over (y, z), N s/m.
    pub damping: BearingCoefficient,
    /// The law of a bearing with a nonlinear force, from which its stiffness follows; none for a linear bearing.
    pub nonlinear: Option<Nonlinear>,
    /// Index of the housing that stands for its tilting pads, whose motions are coordinates.
    pub pads: Option<usize>,
    /// Stiffness, N/m, and damping, N s/m, along the axis.
    pub axial: SpringDamper,
    /// Stiffness, N m/rad, and damping, N m s/rad, of rotations about y and z.
    pub tilting: SpringDamper,
    /// Loss factor η of the stiffness.
    pub loss_factor: f64,
    /// Distance of the centre of the bearing from its place in the drawing, y + iz, m: the displacement of the shaft at which the
    /// force of the bearing is zero.
    pub misalignment: Complex64,
    /// Its place on a housing or on another shaft; `None` on the ground.
    pub attachment: Option<Attachment>,
}

impl Bearing {
    /// The rolling elements of a bearing with five degrees of freedom.
    pub fn ring(&self) -> Option<&Rolling> {
        match &self.nonlinear {
            Some(Nonlinear::Rolling(rolling)) => Some(rolling).filter(|rolling| rolling.axial_preload.is_some()),
            Some(Nonlinear::Journal(_)) | None => None,
        }
    }

    /// Whether it has constant coefficients: a linear bearing has stiffness and damping, and a ring of five degrees of freedom has
    /// damping beside the force of its elements.
    pub fn has_constant_part(&self) -> bool {
        self.nonlinear.is_none() || self.ring().is_some()
    }

    /// Whether it is a linear element between the shaft and the ground without a force in the drawing.
    pub fn is_plain_support(&self) -> bool {
        self.attachment.is_none() && self.misalignment == Complex64::ZERO
    }

    /// Its nodes: that of its shaft and, for a bearing between two shafts, that of the other one, such as the carrier of a planet.
    pub fn nodes(&self) -> impl Iterator<Item = Node> + Clone + use<> {
        let other = match self.attachment {
            Some(Attachment::Shaft(node) | Attachment::Pin { carrier: node, .. }) => Some(node),
            Some(Attachment::Housing { .. }) | None => None,
        };
        std::iter::once(self.node).chain(other)
    }
}

/// Checks the bearings of a scene.
pub(super) fn bearings(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
    attachments: &[Option<Attachment>],
) -> Result<Vec<Bearing>, SceneError> {
    let bearing = |(index, bearing): (usize, &description::Bearing)| {
        let at = EntryPath::entry("bearings", index);
        check_ratings(bearing, &at)?;
        Ok(Bearing {
            node: names.node(shafts, &bearing.shaft, bearing.position, &at)?,
            nonlinear: nonlinear(bearing, &at)?,
            pads: None,
            stiffness: BearingCoefficient::new(bearing.stiffness.as_ref(), &at.field("stiffness"))?,
            damping: BearingCoefficient::new(bearing.damping.as_ref(), &at.field("damping"))?,
            axial: SpringDamper::new("axial", bearing.axial_stiffness, bearing.axial_damping, &at)?,
            tilting: SpringDamper::new("tilting", bearing.tilting_stiffness, bearing.tilting_damping, &at)?,
            loss_factor: loss_factor(bearing, &at)?,
            misalignment: misalignment(bearing, &at)?,
            attachment: attachments[index],
        })
    };
    system.bearings.iter().enumerate().map(bearing).collect()
}

/// Checks load ratings, which analyses of the life of a bearing use, and the contact of a linear bearing that has them.
fn check_ratings(given: &description::Bearing, at: &EntryPath) -> Result<(), SceneError> {
    for (name, rating) in [("dynamic_rating", given.dynamic_rating), ("static_rating", given.static_rating)] {
        let Some(rating) = rating else { continue };
        let place = at.field(name);
        place.positive(rating)?;
        if given.stiffness.is_none() && !given.is_rolling() {
            return Err(place.error("is that of a rolling bearing, and an oil film has none; remove it"));
        }
    }
    if let (Some(angle), Some(_)) = (given.contact_angle, &given.stiffness) {
        let place = at.field("contact_angle");
        if place.finite(angle)?.abs() >= FRAC_PI_2 {
            return Err(place.error(format!("must be between -pi/2 and pi/2 rad, got {angle}; is it in degrees?")));
        }
    }
    Ok(())
}

/// The loss factor of a linear bearing.
fn loss_factor(given: &description::Bearing, at: &EntryPath) -> Result<f64, SceneError> {
    let place = at.field("loss_factor");
    match given.loss_factor {
        Some(_) if given.stiffness.is_none() => {
            Err(place.error("is that of a linear bearing with a stiffness; remove it"))
        }
        factor => place.non_negative(factor.unwrap_or(0.0)),
    }
}

/// The misalignment of a linear bearing with constant coefficients.
fn misalignment(given: &description::Bearing, at: &EntryPath) -> Result<Complex64, SceneError> {
    let place = at.field("misalignment");
    let found = complex(given.misalignment, &place)?;
    let is_constant = |coefficient: Option<&description::BearingCoefficient>| {
        BearingCoefficient::new(coefficient, at).is_ok_and(|coefficient| coefficient.constant().is_some())
    };
    let coefficients = [given.stiffness.as_ref(), given.damping.as_ref()];
    if given.misalignment.is_some() && (given.stiffness.is_none() || !coefficients.into_iter().all(is_constant)) {
        return Err(place.error("is that of a linear bearing with constant stiffness and damping; remove it"));
    }
    Ok(found)
}

/// A bearing whose force is a nonlinear function of the motion.
#[derive(Clone, Debug)]
pub enum Nonlinear {
    /// An oil film.
    Journal(Journal),
    /// Rolling elements.
    Rolling(Rolling),
}

/// Checks the description of a nonlinear bearing that belongs to no scene, and returns its law and its damping over (y, z), N s/m. The
/// path of an error begins with `bearing`.
///
/// # Errors
/// [`SceneError`] as for the bearing of a scene, or for a linear bearing.
pub fn bearing(given: &description::Bearing) -> Result<(Nonlinear, Matrix2), SceneError> {
    let at = EntryPath::root("bearing");
    let law = nonlinear(given, &at)?.ok_or_else(|| at.error("is a linear bearing"))?;
    let damping = BearingCoefficient::new(given.damping.as_ref(), &at.field("damping"))?;
    Ok((law, damping.constant().unwrap_or_default()))
}

/// The nonlinear law of a bearing; none for a linear one.
pub(super) fn nonlinear(given: &description::Bearing, at: &EntryPath) -> Result<Option<Nonlinear>, SceneError> {
    match Rolling::new(given, at)? {
        Some(rolling) => {
            if let Some(description::BearingCoefficient::Table(_)) = given.damping {
                let message = "a rolling bearing takes no table; give a number, a pair or a 2x2 matrix";
                return Err(at.field("damping").error(message));
            }
            Ok(Some(Nonlinear::Rolling(rolling)))
        }
        None => Ok(Journal::new(given, at)?.map(Nonlinear::Journal)),
    }
}
