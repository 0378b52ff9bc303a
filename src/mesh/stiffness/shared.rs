//! Pairs of teeth on gear bodies that they share: every pair in contact loads the bodies, and bends the others' roots.
//!
//! With κ_j = w_j k_j the stiffness of pair j without the bodies, weighted by its engagement, and c_j the compliance of
//! both bodies at its place, a body that couples two pairs by the geometric mean of their compliances, f_i f_j with
//! f = √c, gives the compliance matrix diag(1/κ) + f fᵀ. The mesh is as stiff as its inverse, summed over all pairs:
//!
//! ```text
//! K = Σκ − (Σκf)² / (1 + Σκf²)
//! ```
//!
//! which is positive, is 1/(1/κ + c) for one pair, and 1/(1/Σκ + c) for pairs at places of equal compliance (fillet and
//! body once for all pairs, in series with them).

use super::{ContactPath, ElasticState, ToothPair, UniformCurve};
use crate::scene::Engagement;

/// Pairs and the bodies that they share.
#[derive(Clone, Debug)]
pub struct Shared {
    /// One pair without the bodies.
    pub pair: ToothPair,
    /// Compliance of the driver's body over s, and of the driven one's over C sin α − s, m/N.
    pub bodies: Box<[UniformCurve; 2]>,
    /// How a pair comes into contact and leaves it.
    pub engagement: Engagement,
}

/// A sum over the pairs, and its derivatives over their position and over C sin α.
type Sum = [f64; 3];

impl Shared {
    /// Energy and forces at `deflection`, where `engaged` are the pairs that carry where engagement is sharp.
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
        let half = deflection * deflection / 2.0;
        ElasticState {
            energy: stiffness * half,
            force: stiffness * deflection,
            stiffness,
            by_position: slope(1) * half,
            by_tangent: slope(2) * half,
        }
    }

    fn stiffness(&self, path: &ContactPath, position: f64) -> f64 {
        let path = ContactPath { position, ..*path };
        self.elastic_state(&path, path.engaged(), 1.0).stiffness
    }

    /// Mean over the mesh cycle, N/m: the two-point Gauss rule on pieces that meet where an engagement begins or ends.
    pub(super) fn mean(&self, path: &ContactPath) -> f64 {
        const PIECES: usize = 256;
        let pitch = path.pitch;
        let half = if let Engagement::Smooth(width) = self.engagement { width * pitch / 2.0 } else { 0.0 };
        let mut marks = [path.low - half, path.low + half, path.high - half, path.high + half, 0.0, 0.0]
            .map(|end: f64| end.rem_euclid(pitch));
        marks[5] = pitch;
        marks.sort_by(f64::total_cmp);
        let offset = 0.5 / 3.0_f64.sqrt();
        let piece = |from: f64, to: f64| {
            let h = (to - from) / PIECES as f64;
            let at = |i: usize, part: f64| self.stiffness(path, from + h * (i as f64 + part));
            (0..PIECES).map(|i| (at(i, 0.5 - offset) + at(i, 0.5 + offset)) * h / 2.0).sum::<f64>()
        };
        marks.windows(2).map(|ends| piece(ends[0], ends[1])).sum::<f64>() / pitch
    }

    /// The largest stiffness over the mesh cycle, to a part in 1000 of it.
    pub(super) fn largest(&self, path: &ContactPath) -> f64 {
        (0..1000).map(|i| self.stiffness(path, f64::from(i) / 1000.0 * path.pitch)).fold(0.0, f64::max)
    }
}
