//! ISO 6336-1:2006, clause 9, method B: stiffness of steel gears with the standard basic rack, in the transverse section.

use crate::scene::Gear;

/// Stiffness per face width, N/m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iso6336 {
    /// Minimum flexibility q' of a pair, mm µm/N.
    pub flexibility: f64,
    /// Single stiffness c' of a pair, N/m².
    pub single: f64,
    /// Mesh stiffness c_γ, N/m².
    pub mesh: f64,
}

/// Correction factor of the theory: measured stiffness divided by theoretical stiffness of elastic teeth.
const MEASURED_OVER_THEORETICAL: f64 = 0.8;
/// Conversion factor from N/(mm µm) to N/m².
const N_PER_MM_UM: f64 = 1e9;

/// Stiffness of a pair of solid gears; the gear blank and basic rack factors C_R and C_B are 1. Helical gears have the virtual
/// numbers of teeth z/cos³β, and cos β converts the stiffness to the transverse section; `contact_ratio` is the transverse
/// one. An internal gear counts as a rack.
pub fn iso6336(a: &Gear, b: &Gear, contact_ratio: f64) -> Iso6336 {
    let helix = a.helix_angle.cos();
    let virtual_teeth = |gear: &Gear| if gear.internal { f64::INFINITY } else { f64::from(gear.teeth) / helix.powi(3) };
    let [za, zb] = [a, b].map(virtual_teeth);
    let (xa, xb) = (a.profile_shift, b.profile_shift);
    let flexibility = 0.047_23 + 0.155_51 / za + 0.257_91 / zb
        - 0.006_35 * xa
        - 0.116_54 * xa / za
        - 0.001_93 * xb
        - 0.241_88 * xb / zb
        + 0.005_29 * xa * xa
        + 0.001_82 * xb * xb;
    let single = MEASURED_OVER_THEORETICAL / flexibility * N_PER_MM_UM * helix;
    Iso6336 { flexibility, single, mesh: single * (0.75 * contact_ratio + 0.25) }
}
