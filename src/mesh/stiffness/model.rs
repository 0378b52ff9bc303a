//! Construction of the mesh stiffness from the checked description of the teeth.

use super::{
    CONTACT_COMPLIANCE, ContactLines, PeriodicCurve, Shared, Stiffness, Tooth, ToothPair, UniformCurve, iso6336,
    mean_of_pairs,
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
