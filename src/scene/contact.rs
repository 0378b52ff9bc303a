//! Checks of the contact of a pair of gears at rest: path of contact, contact ratio, interference and undercut.

use super::centre_distance::{distance_without_play, involute, largest_tip_radius};
use super::number::short;
use super::{EntryPath, Gear, SceneError};
use crate::numerics::EQUALITY_TOLERANCE;

/// Lengths of a pair of gears along the line of action, from the driver to the driven gear.
///
/// They have signs with which a pair with an internal gear has the equations of an external one: the base radius of the driven
/// gear, C sin α and √(tip radius² − base radius²) of the internal gear are then negative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairGeometry {
    /// Base radii of driver and driven gear, m.
    pub base_radius: [f64; 2],
    /// √(tip radius² − base radius²) of driver and driven gear, m: length of the line of action from base circle to tip.
    pub tip_reach: [f64; 2],
    /// The tip reach that must be below C sin α, so that no tip reaches beyond the base circle of the other gear, m: the larger
    /// one, or that of the internal gear.
    pub limiting_reach: f64,
    /// Position of the base circle of the driver on the line of action, which limits the path of contact: 0, or −∞ if the driver
    /// is internal.
    driver_limit: f64,
    /// Position of the base circle of the driven gear minus C sin α: 0, or ∞ if the driven gear is internal.
    driven_limit: f64,
    /// Sign of C sin α.
    sign: f64,
}

impl PairGeometry {
    pub fn of([a, b]: [&Gear; 2]) -> Self {
        let sign = a.sign() * b.sign();
        let tip_reach = [a, b].map(|gear| gear.sign() * gear.tip_reach());
        let [first, second] = tip_reach;
        let limit = |gear: &Gear| if gear.internal { f64::INFINITY } else { 0.0 };
        Self {
            base_radius: [a.base_radius, sign * b.base_radius],
            tip_reach,
            limiting_reach: if sign < 0.0 { first.min(second) } else { first.max(second) },
            driver_limit: -limit(a),
            driven_limit: limit(b),
            sign,
        }
    }

    /// Sum of the base radii, m.
    pub fn base_circles(&self) -> f64 {
        self.base_radius[0] + self.base_radius[1]
    }

    /// Length C sin α of the line of action between the base circles at a centre distance, m.
    pub fn tangent(&self, centre_distance: f64) -> f64 {
        let sum = self.base_circles().abs();
        self.sign * ((centre_distance - sum) * (centre_distance + sum)).sqrt()
    }

    /// Positions of the base circles on the line of action, which limit the path of contact because a flank has no involute
    /// inside its base circle, m.
    #[inline(always)]
    pub fn limits(&self, tangent: f64) -> [f64; 2] {
        [self.driver_limit, tangent + self.driven_limit]
    }

    /// Begin and end of the path of contact on the line of action, m, measured from the interference point of the driver. Tip
    /// circles and base circles limit it.
    #[inline(always)]
    pub fn path_of_contact(&self, tangent: f64) -> [f64; 2] {
        let [low, high] = self.limits(tangent);
        [(tangent - self.tip_reach[1]).max(low), self.tip_reach[0].min(high)]
    }
}

/// Refuses a pair without contact at rest. Warns of a contact ratio below one and of involute interference.
pub(super) fn check_contact(
    [a, b]: [&Gear; 2],
    centre_distance: f64,
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let lengths = PairGeometry::of([a, b]);
    let (reach, base_circles, tangent) = (lengths.tip_reach, lengths.base_circles(), lengths.tangent(centre_distance));
    let pitch = a.base_pitch();
    let [low, high] = lengths.path_of_contact(tangent);
    let (transverse, overlap) = ((high - low) / pitch, a.overlap(b) / pitch);
    let ratio = transverse + overlap;
    let names = [&a.body.name, &b.body.name];
    if transverse <= 0.0 {
        let bound = base_circles.hypot(reach[0] + reach[1]);
        let (from, change, tips) =
            if tangent < 0.0 { ("from", "increase", "change") } else { ("up to", "reduce", "enlarge") };
        let message = format!(
            "the teeth of \"{}\" and \"{}\" cannot touch: their tips reach each other on the line of action {from} a \
             centre distance of {bound:.6} m, got {centre_distance} m; {change} it, or {tips} tip_radius",
            names[0], names[1]
        );
        return Err(at.field("centre_distance").error(message));
    }
    if tangent < 0.0 {
        check_internal([a, b], centre_distance, tangent.abs(), at)?;
    }
    let mut interferes = false;
    for (of, other) in [(0, 1), (1, 0)].into_iter().filter(|_| tangent > 0.0) {
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
            let angle = (tangent / base_circles).atan().abs().to_degrees();
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

/// Refuses interference of an internal gear with its pinion: of its tips with the base circle of the pinion, and of the tips of
/// both where they leave each other (trochoid interference).
fn check_internal(pair: [&Gear; 2], centre_distance: f64, tangent: f64, at: &EntryPath) -> Result<(), SceneError> {
    let [pinion, ring] = if pair[0].internal { [pair[1], pair[0]] } else { pair };
    let names = [&pinion.body.name, &ring.body.name];
    let excess = tangent - ring.tip_reach();
    if excess > EQUALITY_TOLERANCE * tangent {
        return Err(at.error(format!(
            "involute interference: the tips of \"{}\" reach {:.3} mm beyond the base circle of \"{}\" along the line of \
             action; use a tip_radius of \"{}\" above {} m, or more teeth on \"{}\"",
            names[1],
            1e3 * excess,
            names[0],
            names[1],
            short(ring.base_radius.hypot(tangent)),
            names[0]
        )));
    }
    // The tip circles meet at the angles θ about the centres. A tip of the pinion is there before the tip of the ring whose flank
    // it has left, unless the difference of both angles, in turns of the ring, is negative.
    let [inner, outer] = [pinion.tip_radius, ring.tip_radius];
    let cosine = |adjacent: f64, opposite: f64| {
        (centre_distance.powi(2) + adjacent.powi(2) - opposite.powi(2)) / (2.0 * centre_distance * adjacent)
    };
    let [of_pinion, of_ring] = [-cosine(inner, outer), cosine(outer, inner)];
    if of_pinion.abs() >= 1.0 || of_ring.abs() >= 1.0 {
        return Ok(());
    }
    let working = involute(((ring.base_radius - pinion.base_radius) / centre_distance).acos());
    let own = |gear: &Gear| involute((gear.base_radius / gear.tip_radius).min(1.0).acos());
    let turned = (of_pinion.acos() + own(pinion) - working) * f64::from(pinion.teeth) / f64::from(ring.teeth);
    let clearance = turned + working - own(ring) - of_ring.acos();
    if clearance < 0.0 {
        return Err(at.error(format!(
            "trochoid interference: the tips of \"{}\" cut those of \"{}\" by {:.3} mm where they leave each other; use fewer \
             teeth on \"{}\", a smaller tip_radius of it, or a larger tip_radius of \"{}\"",
            names[0],
            names[1],
            -1e3 * clearance * outer,
            names[0],
            names[1]
        )));
    }
    Ok(())
}

/// Whether the teeth are shorter than by default.
fn has_short_tips(gear: &Gear, other: &Gear, centre_distance: f64) -> bool {
    let sign = gear.sign();
    let full_depth = (sign * gear.full_depth_tip_radius()).min(largest_tip_radius(gear, other, centre_distance));
    sign * gear.tip_radius < full_depth - EQUALITY_TOLERANCE * full_depth.abs()
}

/// Warns of undercut: the generating rack cuts the flank near the base circle of gears with fewer than 2(1 − x) cos β/sin²α_t
/// teeth. The limit is rounded to a whole number, as usual: 17 teeth for 20° without profile shift.
pub(super) fn check_undercut(gear: &Gear, at: &EntryPath, warnings: &mut Vec<String>) {
    if gear.internal {
        return;
    }
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
