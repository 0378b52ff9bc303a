//! Checks of the contact of a pair of gears at rest: path of contact, contact ratio, interference and undercut.

use super::centre_distance::{distance_without_play, largest_tip_radius};
use super::number::short;
use super::{EntryPath, Gear, SceneError};
use crate::numerics::EQUALITY_TOLERANCE;

/// Begin and end of the path of contact on the line of action, m, measured from the interference point of the driver.
///
/// `tangent` = C sin α is the length of the line of action between the base circles, m. `tip_reach` is
/// √(tip radius² − base radius²) of driver and driven gear, m. The tip circles limit the path. The base circles limit
/// it too, because a flank has no involute inside its base circle.
#[inline(always)]
pub(crate) fn path_of_contact(tangent: f64, tip_reach: [f64; 2]) -> [f64; 2] {
    [(tangent - tip_reach[1]).max(0.0), tip_reach[0].min(tangent)]
}

/// Refuses a pair without contact at rest. Warns of a contact ratio below one and of involute interference.
pub(super) fn check_contact(
    [a, b]: [&Gear; 2],
    centre_distance: f64,
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let reach = [a.tip_reach(), b.tip_reach()];
    let base_circles = a.base_radius + b.base_radius;
    let tangent = ((centre_distance - base_circles) * (centre_distance + base_circles)).sqrt();
    let pitch = a.base_pitch();
    let [low, high] = path_of_contact(tangent, reach);
    let (transverse, overlap) = ((high - low) / pitch, a.overlap(b) / pitch);
    let ratio = transverse + overlap;
    let names = [&a.body.name, &b.body.name];
    if transverse <= 0.0 {
        let largest = base_circles.hypot(reach[0] + reach[1]);
        let message = format!(
            "the teeth of \"{}\" and \"{}\" cannot touch: their tips reach each other on the line of action up to a \
             centre distance of {largest:.6} m, got {centre_distance} m; reduce it, or enlarge tip_radius",
            names[0], names[1]
        );
        return Err(at.field("centre_distance").error(message));
    }
    let mut interferes = false;
    for (of, other) in [(0, 1), (1, 0)] {
        let excess = reach[of] - tangent;
        if excess > EQUALITY_TOLERANCE * tangent {
            interferes = true;
            let without = (reach[0] + reach[1] - tangent) / pitch + overlap;
            warnings.push(format!(
                "{at}: involute interference: the tips of \"{}\" reach {:.3} mm beyond the base circle of \"{}\" along \
                 the line of action; there is no contact there, so the contact ratio is {ratio:.3}, not {without:.3}; \
                 use a larger profile_shift or more teeth on \"{}\", or a smaller tip_radius of \"{}\"",
                names[of],
                1e3 * excess,
                names[other],
                names[other],
                names[of]
            ));
        }
    }
    if ratio < 1.0 - EQUALITY_TOLERANCE {
        let without =
            distance_without_play([a, b]).filter(|without| centre_distance > without * (1.0 + EQUALITY_TOLERANCE));
        let cause = if let Some(without) = without {
            format!("centre_distance is {centre_distance} m, {without:.6} m is without play")
        } else if interferes {
            "interference shortens the path of contact".to_owned()
        } else if [(a, b), (b, a)].iter().any(|(gear, other)| has_short_tips(gear, other, centre_distance)) {
            format!("the tip radii are {:.6} m and {:.6} m; full-depth teeth reach further", a.tip_radius, b.tip_radius)
        } else {
            let angle = tangent.atan2(base_circles).to_degrees();
            format!("the profile shifts increase the pressure angle to {}°", short(angle))
        };
        warnings.push(format!(
            "{at}: the contact ratio is {ratio:.3}, below 1: no teeth are in contact for {:.0} % of the mesh cycle; \
             probable cause: {cause}",
            100.0 * (1.0 - ratio)
        ));
    }
    Ok(())
}

/// Whether the tip radius is below its default.
fn has_short_tips(gear: &Gear, other: &Gear, centre_distance: f64) -> bool {
    let full_depth = gear.full_depth_tip_radius().min(largest_tip_radius(gear, other, centre_distance));
    gear.tip_radius < full_depth * (1.0 - EQUALITY_TOLERANCE)
}

/// Warns of undercut: the generating rack cuts the flank near the base circle of gears with fewer than 2(1 − x) cos β/sin²α_t
/// teeth. The limit is rounded to a whole number, as usual: 17 teeth for 20° without profile shift.
pub(super) fn check_undercut(gear: &Gear, at: &EntryPath, warnings: &mut Vec<String>) {
    let square = gear.transverse_pressure_angle().sin().powi(2) / gear.helix_angle.cos();
    let limit = (2.0 * (1.0 - gear.profile_shift) / square).round();
    let teeth = f64::from(gear.teeth);
    if teeth < limit {
        let shift = 1.0 - teeth * square / 2.0;
        warnings.push(format!(
            "{at}: {teeth} teeth with a profile_shift of {} are undercut (fewer than {limit}): the contact ratio is at \
             most the reported value, and the roots of the teeth are weaker; use a profile_shift of {shift:.3} or more",
            gear.profile_shift
        ));
    }
}
