//! Bearings whose force is a nonlinear function of the motion.

use super::{BearingCoefficient, EntryPath, Journal, Matrix2, Rolling, SceneError, description};

/// A bearing whose force is a nonlinear function of the motion.
#[derive(Clone, Debug)]
pub enum Nonlinear {
    /// An oil film.
    Journal(Journal),
    /// Rolling elements.
    Rolling(Rolling),
}

/// Checks a nonlinear bearing outside a scene; gives its law and its damping over (y, z), N s/m. Errors begin with `bearing`.
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
