//! Centre distance of gears with profile shift (DIN 3960, ISO 21771): the one without play, the play of another one, and the
//! tips that it shortens.

use super::contact::PairGeometry;
use super::number::short;
use super::{EntryPath, Gear, SceneError};

/// Smallest tip clearance of a default tip radius, in modules. Full-depth teeth without profile shift have 0.25.
const MIN_TIP_CLEARANCE: f64 = 0.1;
/// Largest normal play, in modules, that a given backlash may leave out. Allowances of the tooth thickness are smaller.
const MAX_PLAY_BEYOND_BACKLASH: f64 = 0.1;
/// Largest overlap of the teeth, in modules, that a given centre distance may cause. Published distances are rounded.
const MAX_OVERLAP: f64 = 0.02;

/// The basic rack that two gears in mesh share, and their profile shifts.
struct Rack {
    /// Sum of the reference radii, m, with the signs of ISO 21771: negative if a gear is internal.
    reference_distance: f64,
    /// Transverse pressure angle α_t, rad.
    pressure_angle: f64,
    /// Sum x₁ + x₂ of the profile shift coefficients. That of an internal gear is positive where it moves the tips inwards.
    shift: f64,
    /// Number of teeth z₁ + z₂ over 2 tan α_n: the sum of the profile shifts that increases the involute by one.
    shift_by_involute: f64,
    /// Involute of the operating pressure angle without play, inv α_t + 2 (x₁ + x₂) tan α_n/(z₁ + z₂). No angle has a negative
    /// involute.
    involute: f64,
    /// Cosine of the helix angle on the base cylinder.
    base_helix_cosine: f64,
}

impl Rack {
    fn of([a, b]: [&Gear; 2]) -> Self {
        // A gear without module takes the rack of the other one.
        let gear = if a.rack.is_some() { a } else { b };
        let pressure_angle = gear.transverse_pressure_angle();
        let shift = a.profile_shift + b.profile_shift;
        let signed_sum = |of: fn(&Gear) -> f64| a.sign() * of(a) + b.sign() * of(b);
        let shift_by_involute = signed_sum(|gear| f64::from(gear.teeth)) / (2.0 * gear.pressure_angle.tan());
        Self {
            reference_distance: signed_sum(|gear| gear.pitch_radius),
            pressure_angle,
            shift,
            shift_by_involute,
            involute: involute(pressure_angle) + shift / shift_by_involute,
            base_helix_cosine: gear.base_helix_angle().cos(),
        }
    }

    /// Centre distance at which the flanks have no play, m; `None` if there is none.
    fn distance_without_play(&self) -> Option<f64> {
        if self.shift == 0.0 {
            return Some(self.reference_distance.abs());
        }
        let of = |angle: f64| self.reference_distance.abs() * self.pressure_angle.cos() / angle.cos();
        (self.involute > 0.0).then(|| of(angle_of_involute(self.involute)))
    }

    /// Normal play j_n = m_t (z₁ + z₂) cos α_t cos β_b (inv α_w − inv α_w0) of the flanks at a centre distance, m, with the
    /// operating pressure angle α_w and that without play, α_w0; negative where the teeth overlap.
    fn normal_play(&self, distance: f64) -> f64 {
        let base = self.reference_distance * self.pressure_angle.cos();
        // Rounded base radii may permit a distance that is slightly too small for the rack.
        let angle = (base.abs() / distance).min(1.0).acos();
        2.0 * base * self.base_helix_cosine * (involute(angle) - self.involute)
    }
}

/// inv α = tan α − α.
pub(super) fn involute(angle: f64) -> f64 {
    angle.tan() - angle
}

/// The angle α > 0, rad, with inv α = `involute` > 0, by Newton's method for u = tan α.
///
/// u − arctan u is convex and increases, and is smaller than u³/3. The first step from u = ∛(3 inv α) therefore leads to or
/// above the root, and the further steps decrease towards it until round-off ends the decrease.
fn angle_of_involute(involute: f64) -> f64 {
    let step = |tangent: f64| tangent - (tangent - tangent.atan() - involute) * (1.0 + tangent.powi(-2));
    let mut tangent = step((3.0 * involute).cbrt());
    loop {
        let next = step(tangent);
        if next < tangent {
            tangent = next;
        } else {
            return tangent.atan();
        }
    }
}

/// Centre distance of two gears at which their flanks have no play, m; `None` if there is none.
pub(super) fn distance_without_play(pair: [&Gear; 2]) -> Option<f64> {
    Rack::of(pair).distance_without_play()
}

/// Default centre distance of two gears, m: the one without play.
pub(super) fn default_distance(pair: [&Gear; 2], at: &EntryPath) -> Result<f64, SceneError> {
    let rack = Rack::of(pair);
    rack.distance_without_play().ok_or_else(|| {
        let [first, second] = pair.map(|gear| &gear.body.name);
        at.field("centre_distance").error(format!(
            "no distance is without play: the values of profile_shift of \"{first}\" and \"{second}\" add up to {}, and \
             their teeth need {} than {}; use a {} profile_shift, or give centre_distance",
            short(rack.shift),
            if rack.shift_by_involute < 0.0 { "less" } else { "more" },
            short(-involute(rack.pressure_angle) * rack.shift_by_involute),
            if rack.shift_by_involute < 0.0 { "smaller" } else { "larger" },
        ))
    })
}

/// Warns of a given centre distance with more play than the given backlash, m, or with teeth that overlap.
pub(super) fn check_play(
    pair: [&Gear; 2],
    distance: f64,
    backlash: Option<f64>,
    at: &EntryPath,
    warnings: &mut Vec<String>,
) {
    // The rack of a gear is unknown if the description gives its base radius only.
    if pair.iter().any(|gear| gear.rack.is_none()) {
        return;
    }
    let (rack, module) = (Rack::of(pair), pair[0].module);
    let play = rack.normal_play(distance);
    let little = backlash.filter(|backlash| play - backlash > MAX_PLAY_BEYOND_BACKLASH * module);
    let overlap = play < -MAX_OVERLAP * module;
    if little.is_none() && !overlap {
        return;
    }
    let without =
        rack.distance_without_play().map_or_else(String::new, |without| format!(", {without:.6} m is without play"));
    let given = backlash.map_or_else(String::new, |backlash| format!(", backlash is {} m", short(backlash)));
    // The play of an internal gear shrinks with the centre distance.
    let (wider, closer) = if rack.reference_distance < 0.0 { ("smaller", "larger") } else { ("larger", "smaller") };
    let cause = if overlap {
        format!("the teeth overlap unless they are thinner; use a {wider} centre_distance or a smaller profile_shift")
    } else {
        format!("use a backlash of at least this play, a {closer} centre_distance or a larger profile_shift")
    };
    warnings.push(format!(
        "{}: the normal play of the flanks at {distance} m is {} m{given}{without}; {cause}",
        at.field("centre_distance"),
        short(play)
    ));
}

/// Largest tip radius of the first gear, m, negative for an internal gear, that keeps the least tip clearance to the root circle
/// of the second one and, for an internal gear, stays outside the base circle of its pinion along the line of action. Without
/// profile shift the first limit is infinite, because the teeth are those of the basic rack at any centre distance.
pub(super) fn largest_tip_radius(gear: &Gear, other: &Gear, distance: f64) -> f64 {
    let tangent = PairGeometry::of([gear, other]).tangent(distance);
    let involute = if gear.internal { -gear.base_radius.hypot(tangent) } else { f64::INFINITY };
    if gear.profile_shift + other.profile_shift == 0.0 {
        return involute;
    }
    let root = other.sign() * other.root_radius();
    involute.min(distance.copysign(tangent) - root - MIN_TIP_CLEARANCE * gear.module)
}

#[cfg(test)]
mod tests {
    use super::{angle_of_involute, involute};

    #[test]
    fn the_inverse_of_the_involute_is_exact_to_round_off() {
        for step in 1..1550 {
            let angle = 1e-3 * f64::from(step);
            let found = angle_of_involute(involute(angle));
            // Round-off of tan α − α, which the derivative tan²α of the involute divides.
            let allowed = f64::EPSILON * (4.0 * angle + 8.0 * angle.tan() / angle.tan().powi(2));
            assert!((found - angle).abs() <= allowed, "{angle}: {found}");
        }
        for power in -300..300 {
            let value = 10.0_f64.powi(power);
            let found = angle_of_involute(value);
            assert!(found > 0.0 && found <= std::f64::consts::FRAC_PI_2, "{value}: {found}");
        }
    }
}
