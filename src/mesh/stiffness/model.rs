//! From what a user says of the teeth to the stiffness of the mesh.

use super::{Cycle, Pair, Stiffness, Tooth, UniformCurve, iso6336, pair_stiffness};
use crate::mesh::Involute;
use crate::scene::{Engagement, Gear, Scale, StiffnessModel, Teeth};

/// Knots of a pair that is tabulated from its teeth.
const KNOTS: usize = 129;

/// The stiffness that `teeth` describe, on the path of contact of the centres at rest.
pub fn build(teeth: &Teeth, pair: [&Gear; 2], involute: &Involute) -> Stiffness {
    let [low, high] = involute.path_at_rest();
    let pitch = involute.base_pitch;
    let pairs = |shape: Pair, scale: &Scale| {
        let pair = match scale {
            Scale::Pair(k) => shape.scaled(*k),
            Scale::Mean(mean) => {
                let unit = shape.integral(low, high) / pitch;
                shape.scaled(mean / unit)
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
            let tooth = [Tooth::new(pair[0], bores[0]), Tooth::new(pair[1], bores[1])];
            // Beyond the ends of the path at rest by half the engagement, and a little more: the centres move.
            let half = if let Engagement::Smooth(width) = teeth.engagement { width / 2.0 } else { 0.0 };
            let (from, to) = (low - (half + 0.1) * pitch, high + (half + 0.1) * pitch);
            let spacing = (to - from) / (KNOTS - 1) as f64;
            let at = |i: usize| pair_stiffness(&tooth[0], &tooth[1], involute.tangent_at_rest(), from + i as f64 * spacing);
            let values: Vec<f64> = (0..KNOTS).map(at).collect();
            pairs(Pair::Tabulated(UniformCurve::new(from, spacing, &values)), &Scale::Pair(*width))
        }
        StiffnessModel::Table(values) => Stiffness::Cycle(Cycle::table(values)),
        StiffnessModel::Fourier(mean, harmonics) => Stiffness::Cycle(Cycle::Fourier(*mean, harmonics.clone())),
    }
}
