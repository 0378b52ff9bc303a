//! Tooth pairs on shared gear bodies: every pair in contact deforms the bodies and thereby displaces the other pairs.
//!
//! κ_j = w_j k_j is the stiffness of pair j without the bodies, weighted by its engagement. c_j is the compliance of
//! both bodies at the position of pair j. The bodies couple two pairs by the geometric mean of their compliances,
//! f_i f_j with f = √c. The compliance matrix is then diag(1/κ) + f fᵀ. The mesh stiffness is the sum of all entries of
//! its inverse:
//!
//! ```text
//! K = Σκ − (Σκf)² / (1 + Σκf²)
//! ```
//!
//! K is positive. It equals 1/(1/κ + c) for one pair. For pairs with equal body compliance c it equals 1/(1/Σκ + c):
//! fillet and body are then in series with all pairs in parallel.

use super::{ElasticState, MEAN_PIECES, ToothPair, UniformCurve};
use crate::mesh::ContactPath;
use crate::numerics::gauss;
use crate::scene::Engagement;

/// Tooth pairs and their shared gear bodies.
#[derive(Clone, Debug)]
pub struct Shared {
    /// One pair without the bodies.
    pub pair: ToothPair,
    /// Compliance of the driver's body as a function of s, and of the driven body as a function of C sin α − s, m/N.
    pub bodies: Box<[UniformCurve; 2]>,
    /// Sharp or smooth beginning and end of the contact of a pair.
    pub engagement: Engagement,
}

/// A sum over the pairs, and its derivatives with respect to s and to C sin α.
type Sum = [f64; 3];

impl Shared {
    /// Energy and forces at `deflection`, m. `engaged` is the first and the last pair in contact with sharp engagement.
    #[inline(never)]
    pub(super) fn elastic_state(&self, path: &ContactPath, engaged: (i64, i64), deflection: f64) -> ElasticState {
        let (first, last) = self.engagement.range(path, engaged);
        let [low_slope, high_slope] = path.end_slopes();
        let (mut sum, mut with_root, mut with_body): (Sum, Sum, Sum) = Default::default();
        for j in first..last + 1 {
            let s = path.position + j as f64 * path.pitch;
            let [k, k_travel, k_opening] = self.pair.at(s, path.tangent);
            let [w, by_entered, by_left] = self.engagement.weight(s - path.low, path.high - s, path.pitch);
            let stiffness = [
                w * k,
                w * k_travel + k * (by_entered - by_left),
                w * k_opening + k * (high_slope * by_left - low_slope * by_entered),
            ];
            let ((driver, by_s), (driven, by_rest)) = (self.bodies[0].at(s), self.bodies[1].at(path.tangent - s));
            let body = [driver + driven, by_s - by_rest, by_rest];
            let root = body[0].sqrt();
            let root = [root, body[1] / (2.0 * root), body[2] / (2.0 * root)];
            for i in 0..3 {
                sum[i] += stiffness[i];
                let product =
                    |other: &Sum| if i == 0 { w * k * other[0] } else { stiffness[i] * other[0] + w * k * other[i] };
                with_root[i] += product(&root);
                with_body[i] += product(&body);
            }
        }
        let part = with_root[0] / (1.0 + with_body[0]);
        let slope = |i: usize| sum[i] - 2.0 * part * with_root[i] + part * part * with_body[i];
        let stiffness = sum[0] - part * with_root[0];
        ElasticState::of_spring([stiffness, slope(1), slope(2)], deflection)
    }

    fn stiffness(&self, path: &ContactPath, position: f64) -> f64 {
        let path = ContactPath { position, ..*path };
        self.elastic_state(&path, path.engaged(), 1.0).stiffness
    }

    /// Mean over the mesh cycle, N/m, by the two-point Gauss rule on pieces between the engagement changes.
    pub(super) fn mean(&self, path: &ContactPath) -> f64 {
        let pitch = path.pitch;
        let half = self.engagement.half_ramp(pitch);
        let mut marks = [path.low - half, path.low + half, path.high - half, path.high + half, 0.0, 0.0]
            .map(|end: f64| end.rem_euclid(pitch));
        marks[5] = pitch;
        marks.sort_by(f64::total_cmp);
        let rule = gauss(2);
        let piece = |from: f64, to: f64| {
            let h = (to - from) / MEAN_PIECES as f64;
            let at = |i: usize, part: f64| self.stiffness(path, from + h * (i as f64 + part));
            let sum = |i: usize| rule.iter().map(|(part, weight)| weight * at(i, *part)).sum::<f64>();
            (0..MEAN_PIECES).map(sum).sum::<f64>() * h
        };
        marks.windows(2).map(|ends| piece(ends[0], ends[1])).sum::<f64>() / pitch
    }

    /// The largest stiffness among 1000 positions of the mesh cycle, N/m.
    pub(super) fn largest(&self, path: &ContactPath) -> f64 {
        (0..1000).map(|i| self.stiffness(path, f64::from(i) / 1000.0 * path.pitch)).fold(0.0, f64::max)
    }
}
