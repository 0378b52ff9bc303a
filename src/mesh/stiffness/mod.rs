//! Stiffness of a mesh: a mean, tooth pairs on the path of contact, or a function of the mesh cycle.
//!
//! Pair j has the position s_j = s + j·p_b on the path, measured from the interference point of the driver. It carries
//! load between lo = max(0, t − √(tip_b² − r_b²)) and hi = min(t, √(tip_a² − r_a²)), with t = C sin α. The tips limit
//! the path; if a tip reaches beyond a base circle, this base circle limits the path. With the engagement w_j of the
//! pair, its stiffness k_j and its tip relief r_j, the elastic energy and the force are
//!
//! ```text
//! U = ½ Σ_j w_j k_j (δ − r_j)²,        F = ∂U/∂δ
//! ```
//!
//! The stiffness depends on the moving centres through lo, hi, t and s.

mod curve;
mod engagement;
mod lines;
mod loads;
mod model;
mod pair;
mod potential_energy;
mod shared;

pub use curve::{PeriodicCurve, UniformCurve};
pub(super) use engagement::smooth_step;
pub use lines::ContactLines;
pub use model::{Iso6336, build, iso6336};
pub use pair::ToothPair;
pub use potential_energy::{CONTACT_COMPLIANCE, Tooth};
pub use shared::Shared;

use crate::mesh::ContactPath;
use crate::scene::{Engagement, Relief};

/// Elastic energy of a mesh at a deflection, and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElasticState {
    /// Elastic energy U, J.
    pub energy: f64,
    /// Force ∂U/∂δ, N.
    pub force: f64,
    /// Stiffness ∂²U/∂δ², N/m.
    pub stiffness: f64,
    /// ∂U/∂s, N: derivative with respect to the position of the pairs on the path.
    pub by_position: f64,
    /// ∂U/∂(C sin α), N: derivative with respect to the length of the line of action.
    pub by_tangent: f64,
}

impl ElasticState {
    /// That of a stiffness k, N/m, with its derivatives over the position of the pairs and the length of the line of action.
    #[inline(always)]
    fn of_spring([k, by_position, by_tangent]: [f64; 3], deflection: f64) -> Self {
        let half = deflection * deflection / 2.0;
        Self {
            energy: k * half,
            force: k * deflection,
            stiffness: k,
            by_position: by_position * half,
            by_tangent: by_tangent * half,
        }
    }
}

/// The stiffness of a mesh.
#[derive(Clone, Debug)]
pub enum Stiffness {
    /// Constant, N/m.
    Mean(f64),
    /// Pairs of teeth.
    Pairs {
        /// Stiffness of one pair.
        pair: ToothPair,
        /// Sharp or smooth beginning and end of the contact of a pair.
        engagement: Engagement,
        /// Tip relief, if the teeth have any.
        relief: Option<Relief>,
    },
    /// Pairs of helical teeth.
    Lines(ContactLines),
    /// Pairs of teeth that share the gear bodies.
    Shared(Shared),
    /// Stiffness of the whole mesh over its cycle, N/m.
    Cycle(PeriodicCurve),
}

impl Stiffness {
    /// Energy and forces at `deflection`, m. `engaged` is the first and the last pair in contact with sharp engagement.
    /// `path` is evaluated only if the stiffness depends on it.
    #[inline]
    pub fn elastic_state(
        &self,
        path: impl FnOnce() -> ContactPath,
        engaged: (i64, i64),
        deflection: f64,
    ) -> ElasticState {
        if let Some(k) = self.while_engaged(engaged) {
            return ElasticState {
                energy: k * deflection * deflection / 2.0,
                force: k * deflection,
                stiffness: k,
                ..ElasticState::default()
            };
        }
        let path = &path();
        match self {
            // `while_engaged` has returned its stiffness.
            Self::Mean(_) => ElasticState::default(),
            Self::Shared(shared) => shared.elastic_state(path, engaged, deflection),
            Self::Lines(lines) => lines.elastic_state(path, deflection),
            Self::Cycle(cycle) => {
                // Stiffness, and its derivatives by position and by tangent.
                let (k, slope) = cycle.at(path.position / path.pitch);
                ElasticState::of_spring([k, slope / path.pitch, 0.0], deflection)
            }
            Self::Pairs { pair, engagement, relief } => {
                let (first, last) = engagement.range(path, engaged);
                let [low_slope, high_slope] = path.end_slopes();
                let mut sum = ElasticState::default();
                for j in first..last + 1 {
                    let s = path.position + j as f64 * path.pitch;
                    let [k, slope, by_tangent] = pair.at(s, path.tangent);
                    let (entered, left) = (s - path.low, path.high - s);
                    let w = engagement.weight(entered, left, path.pitch);
                    let r = relief.as_ref().map_or([0.0; 3], |relief| relief.at(entered, left));
                    // A relieved pair carries no load before it touches; without relief the force is linear.
                    let d = if relief.is_some() { (deflection - r[0]).max(0.0) } else { deflection };
                    let half = d * d / 2.0;
                    let (by_entered, by_left) =
                        (half * k * w[1] - w[0] * k * d * r[1], half * k * w[2] - w[0] * k * d * r[2]);
                    sum.energy += w[0] * k * half;
                    sum.force += w[0] * k * d;
                    sum.stiffness += if d == 0.0 && relief.is_some() { 0.0 } else { w[0] * k };
                    sum.by_position += half * w[0] * slope + by_entered - by_left;
                    sum.by_tangent += half * w[0] * by_tangent - low_slope * by_entered + high_slope * by_left;
                }
                sum
            }
        }
    }

    /// Whether the engagement of tooth pairs is sharp. The stiffness then jumps at engagement changes.
    pub fn is_sharp(&self) -> bool {
        let (Self::Pairs { engagement, .. } | Self::Shared(Shared { engagement, .. })) = self else { return false };
        *engagement == Engagement::Sharp
    }

    /// Whether the teeth have tip relief. The number of touching pairs then increases with the deflection.
    pub fn is_relieved(&self) -> bool {
        matches!(self, Self::Pairs { relief: Some(_), .. })
    }

    /// Whether the stiffness is constant between changes of the pairs in contact.
    pub fn is_piecewise_constant(&self) -> bool {
        self.while_engaged((0, 0)).is_some()
    }

    /// The stiffness of the `engaged` pairs, N/m, if it does not depend on their position.
    #[inline]
    fn while_engaged(&self, engaged: (i64, i64)) -> Option<f64> {
        match self {
            Self::Mean(k) => Some(*k),
            Self::Pairs { pair: ToothPair::Uniform(k), engagement: Engagement::Sharp, relief: None } => {
                let (first, last) = engaged;
                Some(k * (last - first + 1).max(0) as f64)
            }
            _ => None,
        }
    }

    /// Whether the stiffness is constant.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Mean(_))
    }

    /// Mean over the mesh cycle on a path of contact, N/m.
    pub fn mean(&self, path: &ContactPath) -> f64 {
        match self {
            Self::Mean(k) => *k,
            Self::Cycle(cycle) => cycle.mean(),
            Self::Shared(shared) => shared.mean(path),
            // The mean over the cycle does not depend on the overlap.
            Self::Pairs { pair, engagement, .. } | Self::Lines(ContactLines { pair, engagement }) => {
                mean_of_pairs(pair, engagement, path)
            }
        }
    }

    /// Stiffness at a position on a path of contact, m, if all touching pairs carry, N/m.
    pub fn at(&self, path: &ContactPath, position: f64) -> f64 {
        let path = ContactPath { position, ..*path };
        // Tip relief is small beside this deflection, m.
        self.elastic_state(|| path, path.engaged(), 1.0).stiffness
    }

    /// Upper bound of the stiffness, N/m.
    pub fn largest(&self, path: &ContactPath) -> f64 {
        match self {
            Self::Mean(k) => *k,
            Self::Cycle(cycle) => cycle.largest(),
            Self::Shared(shared) => shared.largest(path),
            Self::Pairs { pair, .. } | Self::Lines(ContactLines { pair, .. }) => {
                pair.largest(path) * ((path.high - path.low) / path.pitch).ceil().max(1.0)
            }
        }
    }
}

/// Number of pieces of the path or cycle on which a mean stiffness is integrated. The rule has an error of h⁴.
const MEAN_PIECES: usize = 256;

/// (1/p_b)∫w k ds over the path of contact, N/m, by Simpson's rule. The pieces meet at the kinks of the engagement w,
/// which extends beyond the path.
fn mean_of_pairs(pair: &ToothPair, engagement: &Engagement, path: &ContactPath) -> f64 {
    let &ContactPath { tangent, low, high, pitch, .. } = path;
    let half = engagement.half_ramp(pitch);
    let at = |s: f64| engagement.weight(s - low, high - s, pitch)[0] * pair.at(s, tangent)[0];
    let piece = |from: f64, to: f64| {
        let h = (to - from) / MEAN_PIECES as f64;
        let simpson = |i: usize| {
            let s = from + i as f64 * h;
            (at(s) + 4.0 * at(s + h / 2.0) + at(s + h)) * h / 6.0
        };
        (0..MEAN_PIECES).map(simpson).sum::<f64>()
    };
    let (entered, leaving) = ((low + half).min(high), (high - half).max(low));
    (piece(low - half, entered.min(leaving))
        + piece(entered.min(leaving), leaving.max(entered))
        + piece(leaving.max(entered), high + half))
        / pitch
}
