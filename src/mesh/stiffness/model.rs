//! From what a user says of the teeth to the stiffness of the mesh.

use super::{CONTACT_COMPLIANCE, Cycle, Pair, Stiffness, Tooth, UniformCurve, iso6336, mean_of_pairs};
use crate::mesh::Involute;
use crate::scene::{Engagement, Gear, Scale, StiffnessModel, Teeth};

/// Knots of the compliance of a tooth.
const KNOTS: usize = 257;

/// The stiffness that `teeth` describe, on the path of contact of the centres at rest.
pub fn build(teeth: &Teeth, pair: [&Gear; 2], involute: &Involute) -> Stiffness {
    let [low, high] = involute.path_at_rest();
    let pitch = involute.base_pitch;
    let pairs = |shape: Pair, scale: &Scale| {
        let pair = match scale {
            Scale::Pair(k) => shape.scaled(*k),
            Scale::Mean(mean) => {
                shape.clone().scaled(mean / mean_of_pairs(&shape, &teeth.engagement, low, high, pitch))
            }
        };
        Stiffness::Pairs { pair, engagement: teeth.engagement, relief: teeth.relief }
    };
    match &teeth.stiffness {
        StiffnessModel::Mean(k) => Stiffness::Mean(*k),
        StiffnessModel::Iso6336(width) => {
            let [a, b] = pair;
            Stiffness::Mean(iso6336(a, b, (high - low) / pitch).mesh * width)
        }
        StiffnessModel::Square(scale) => pairs(Pair::Uniform(1.0), scale),
        StiffnessModel::Parabolic(scale, end_ratio) => {
            let path = ((low + high) / 2.0, (high - low) / 2.0);
            pairs(Pair::Parabolic { middle: 1.0, end_ratio: *end_ratio, path }, scale)
        }
        StiffnessModel::PotentialEnergy(width, bores) => {
            // Beyond the ends of the path at rest by half the engagement, and a little more: the centres move.
            let half = if let Engagement::Smooth(width) = teeth.engagement { width / 2.0 } else { 0.0 };
            let margin = (half + 0.2) * pitch;
            let table = |tooth: Tooth, from: f64, to: f64| {
                let (from, to) = ((from - margin).max(0.0), to + margin);
                let spacing = (to - from) / (KNOTS - 1) as f64;
                let values: Vec<f64> = (0..KNOTS).map(|i| tooth.compliance(from + i as f64 * spacing)).collect();
                UniformCurve::new(from, spacing, &values)
            };
            let (tangent, [a, b]) = (involute.tangent_at_rest(), pair);
            let tables = [
                table(Tooth::new(a, bores[0]), low, high),
                table(Tooth::new(b, bores[1]), tangent - high, tangent - low),
            ];
            let pair = Pair::Teeth { contact: CONTACT_COMPLIANCE, teeth: Box::new(tables), reach: tangent - low };
            pairs(pair, &Scale::Pair(*width))
        }
        StiffnessModel::Table(values) => Stiffness::Cycle(Cycle::table(values)),
        StiffnessModel::Fourier(mean, harmonics) => Stiffness::Cycle(Cycle::Fourier(*mean, harmonics.clone())),
    }
}
