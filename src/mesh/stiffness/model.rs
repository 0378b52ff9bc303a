//! Construction of the mesh stiffness from the checked description of the teeth.

use super::{
    CONTACT_COMPLIANCE, ContactLines, PeriodicCurve, Shared, Stiffness, Tooth, ToothPair, UniformCurve, mean_of_pairs,
};
use crate::mesh::{ContactPath, Involute};
use crate::scene::{Foundation, Gear, Scale, StiffnessModel, Teeth};

/// Number of knots of the compliance curve of a tooth.
const COMPLIANCE_KNOTS: usize = 257;

/// The stiffness of the mesh in the transverse section that `teeth` describe, scaled on the path of contact of the centres at
/// rest. Given numbers are those in the direction normal to the teeth, which is the same for spur gears.
pub fn build(teeth: &Teeth, pair: [&Gear; 2], involute: &Involute) -> Stiffness {
    let at_rest = involute.path_at_rest();
    let ContactPath { low, high, pitch, .. } = at_rest;
    let cosine = pair[0].base_helix_angle().cos();
    // k_t = k_n cos²β_b.
    let transverse = |normal: f64| normal * cosine * cosine;
    let pairs = |pair: ToothPair| {
        if at_rest.overlap > 0.0 {
            Stiffness::Lines(ContactLines { pair, engagement: teeth.engagement })
        } else {
            Stiffness::Pairs { pair, engagement: teeth.engagement, relief: teeth.relief }
        }
    };
    let scaled = |shape: ToothPair, scale: &Scale| {
        pairs(match scale {
            Scale::Pair(k) => shape.scaled(transverse(*k)),
            Scale::Mean(mean) => {
                let own = mean_of_pairs(&shape, &teeth.engagement, &at_rest);
                shape.scaled(transverse(*mean) / own)
            }
        })
    };
    match &teeth.stiffness {
        StiffnessModel::Mean(k) => Stiffness::Mean(transverse(*k)),
        StiffnessModel::Iso6336(width) => {
            let [a, b] = pair;
            Stiffness::Mean(iso6336(a, b, (high - low) / pitch).mesh * width)
        }
        StiffnessModel::Square(scale) => scaled(ToothPair::Uniform(1.0), scale),
        StiffnessModel::Parabolic(scale, end_ratio) => {
            let (centre, half_length) = ((low + high) / 2.0, (high - low) / 2.0);
            scaled(ToothPair::Parabolic { middle: 1.0, end_ratio: *end_ratio, centre, half_length }, scale)
        }
        StiffnessModel::PotentialEnergy(width, bores, foundation) => {
            potential_energy(teeth, pair, pitch, *width, bores, *foundation, pairs)
        }
        StiffnessModel::Table(values) => {
            let values: Vec<f64> = values.iter().map(|value| transverse(*value)).collect();
            Stiffness::Cycle(PeriodicCurve::table(&values))
        }
        StiffnessModel::Fourier(mean, harmonics) => {
            let harmonics = harmonics.iter().map(|[amplitude, phase]| [transverse(*amplitude), *phase]).collect();
            Stiffness::Cycle(PeriodicCurve::Fourier(transverse(*mean), harmonics))
        }
    }
}

/// The stiffness of teeth by the potential-energy method: `pitch` is the base pitch, m, `width` the face width, m, and `bores`
/// the radii of the bores, m.
fn potential_energy(
    teeth: &Teeth,
    pair: [&Gear; 2],
    pitch: f64,
    width: f64,
    bores: &[f64; 2],
    foundation: Foundation,
    pairs: impl Fn(ToothPair) -> Stiffness,
) -> Stiffness {
    // Contact points lie between the larger one of base circle and root circle, and the tip circle. A smooth
    // engagement adds half of its width. A margin of a fifth of the pitch follows, because a spline is least
    // accurate at its ends.
    let margin = (teeth.engagement.half_ramp(1.0) + 0.2) * pitch;
    let table = |gear: &Gear, bore: f64, compliance: fn(&Tooth, f64) -> f64| {
        let (from, to) = (gear.root_reach() - margin, gear.tip_reach() + margin);
        let tooth = Tooth::new(gear, bore);
        let spacing = (to - from) / (COMPLIANCE_KNOTS - 1) as f64;
        let values: Vec<f64> = (0..COMPLIANCE_KNOTS).map(|i| compliance(&tooth, from + i as f64 * spacing)).collect();
        UniformCurve::new(from, spacing, &values)
    };
    let tables = |compliance| Box::new([0, 1].map(|i| table(pair[i], bores[i], compliance)));
    let pair = |compliance| ToothPair::Teeth { contact: CONTACT_COMPLIANCE, teeth: tables(compliance) };
    match foundation {
        Foundation::Separate => pairs(pair(Tooth::compliance).scaled(width)),
        Foundation::Shared => Stiffness::Shared(Shared {
            pair: pair(Tooth::flexure).scaled(width),
            bodies: Box::new(tables(Tooth::foundation).map(|curve| curve.scaled(1.0 / width))),
            engagement: teeth.engagement,
        }),
    }
}

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

/// ISO 6336-1:2006, clause 9, method B: stiffness of a pair of solid steel gears with the standard basic rack, in the transverse
/// section; the gear blank and basic rack factors C_R and C_B are 1. Helical gears have the virtual
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
