//! Contact lines of helical teeth: the stiffness of a pair is that of its transverse sections, integrated over the face.
//!
//! A section at the distance x from the middle of the face meets the path of contact at s + x tan β_b. With the overlap
//! o = b tan β_b, the stiffness of pair j of the whole face width b and its engagement w_j
//!
//! ```text
//! U = ½ δ² Σ_j ∫ w_j k_j(s_j + ξ o) dξ,        −½ ≤ ξ ≤ ½
//! ```
//!
//! The integrals over the ramps of the engagement and over the part between them are computed by Gauss rules, which are
//! exact for constant and parabolic stiffness. Without ramps the stiffness has kinks, but no jumps.

use std::sync::LazyLock;

use super::{ElasticState, ToothPair};
use crate::mesh::ContactPath;
use crate::numerics::gauss;
use crate::scene::Engagement;

/// The five-point Gauss rule, exact up to degree nine: a ramp has the degree five and a parabolic pair two.
pub(super) static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss(5));

/// Pairs of helical teeth.
#[derive(Clone, Debug)]
pub struct ContactLines {
    /// Stiffness of a pair that is in contact over its whole face width.
    pub pair: ToothPair,
    /// Sharp or smooth beginning and end of the contact of a section.
    pub engagement: Engagement,
}

impl ContactLines {
    /// Energy and forces at `deflection`, m.
    pub(super) fn elastic_state(&self, path: &ContactPath, deflection: f64) -> ElasticState {
        let half_ramp = self.engagement.half_ramp(path.pitch);
        let (first, last) = self.engagement.touching(path);
        let slopes = path.end_slopes();
        let mut sum = Sums::default();
        for j in first..last + 1 {
            self.add_pair(path, half_ramp, path.position + j as f64 * path.pitch, slopes, &mut sum);
        }
        ElasticState::of_spring([sum.stiffness, sum.by_position, sum.by_tangent], deflection)
    }

    /// Adds the stiffness of the pair at the position `s`, m, with its derivatives.
    fn add_pair(&self, path: &ContactPath, half_ramp: f64, s: f64, [low_slope, high_slope]: [f64; 2], sum: &mut Sums) {
        let overlap = path.overlap;
        let place = |position: f64| ((position - s) / overlap).clamp(-0.5, 0.5);
        let (low, high) = (place(path.low + half_ramp), place(path.high - half_ramp));
        let ends = [place(path.low - half_ramp), low.min(high), low.max(high), place(path.high + half_ramp)];
        for piece in ends.windows(2) {
            let length = piece[1] - piece[0];
            if length <= 0.0 {
                continue;
            }
            for (at, weight) in &*RULE {
                let y = s + (piece[0] + at * length) * overlap;
                let [k, slope, by_tangent] = self.pair.at(y, path.tangent);
                let [w, by_entered, by_left] = self.engagement.weight(y - path.low, path.high - y, path.pitch);
                let share = weight * length;
                sum.stiffness += share * w * k;
                sum.by_position += share * (w * slope + k * (by_entered - by_left));
                sum.by_tangent += share * (w * by_tangent + k * (high_slope * by_left - low_slope * by_entered));
            }
        }
        if self.engagement == Engagement::Sharp {
            // The ends of the path move along the contact line.
            let end = |position: f64| {
                let inside = (position - s).abs() < overlap / 2.0;
                if inside { self.pair.at(position, path.tangent)[0] / overlap } else { 0.0 }
            };
            let (entered, left) = (end(path.low), end(path.high));
            sum.by_position += entered - left;
            sum.by_tangent += high_slope * left - low_slope * entered;
        }
    }
}

/// Stiffness, N/m, and its derivatives with respect to the position of the pairs and to the length of the line of action,
/// N/m².
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    stiffness: f64,
    by_position: f64,
    by_tangent: f64,
}
