//! Checks the friction between the flanks of a mesh.

use super::description;
use super::teeth::DEFAULT_ENGAGEMENT;
use super::{EntryPath, Gear, SceneError};

/// Coefficient of friction between the flanks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionLaw {
    /// Constant.
    Constant(f64),
    /// Mean coefficient of lubricated steel gears by ISO/TR 14179-2 (Schlenk 1994), for the load and the speed of the instant.
    Lubricated {
        /// Dynamic viscosity of the oil at its temperature, Pa s.
        viscosity: f64,
        /// Arithmetic mean roughness of the flanks, m.
        roughness: f64,
        /// Factor X_L of the lubricant; 1 for mineral oil.
        lubricant_factor: f64,
        /// Smaller face width, m.
        face_width: f64,
        /// Reference radius of the driver, m.
        pitch_radius: f64,
    },
}

/// Checked friction between the flanks of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient.
    pub law: FrictionLaw,
    /// Length of the path of contact about the pitch point on which the friction changes its sign, as a fraction of the base
    /// pitch.
    pub transition: f64,
}

/// Checks the friction of a pair of gears; none without friction.
pub(super) fn friction(
    given: &description::MeshFriction,
    pair: [&Gear; 2],
    at: &EntryPath,
) -> Result<Option<Friction>, SceneError> {
    let given = match given {
        description::MeshFriction::Coefficient(coefficient) => {
            description::FrictionTable { coefficient: Some(*coefficient), ..description::FrictionTable::default() }
        }
        description::MeshFriction::Table(table) => table.clone(),
    };
    let place = at.field("transition");
    // By default that of the engagement of tooth pairs, which lowers the loss of the gears 25/50 by 0.1 %.
    let transition = place.positive(given.transition.unwrap_or(DEFAULT_ENGAGEMENT))?;
    if transition > 0.5 {
        return Err(place.error(format!("must be at most half a base pitch, 0.5, got {transition}")));
    }
    let law = match (given.coefficient, given.viscosity, given.roughness) {
        (Some(coefficient), None, None) => {
            if given.lubricant_factor.is_some() {
                return Err(at
                    .field("lubricant_factor")
                    .error("needs viscosity and roughness in place of coefficient"));
            }
            FrictionLaw::Constant(at.field("coefficient").non_negative(coefficient)?)
        }
        (None, Some(viscosity), Some(roughness)) => FrictionLaw::Lubricated {
            viscosity: at.field("viscosity").positive(viscosity)?,
            roughness: at.field("roughness").positive(roughness)?,
            lubricant_factor: at.field("lubricant_factor").positive(given.lubricant_factor.unwrap_or(1.0))?,
            face_width: match pair.map(|gear| gear.face_width) {
                [Some(a), Some(b)] => a.min(b),
                _ => return Err(at.error("needs the face_width of both gears, or a coefficient")),
            },
            pitch_radius: pair[0].pitch_radius,
        },
        _ => return Err(at.error("needs either coefficient, or viscosity and roughness")),
    };
    Ok((law != FrictionLaw::Constant(0.0)).then_some(Friction { law, transition }))
}
