//! How stiff a mesh is: a mean, pairs of teeth on the path of contact, or a function of the mesh cycle.
//!
//! A pair stands at s_j = s + j·p_b on the path, measured from the interference point of the driver, and carries
//! between lo = max(0, t − √(tip_b² − r_b²)) and hi = min(t, √(tip_a² − r_a²)), t = C sin α: both ends follow from the
//! tips, unless a tip reaches beyond the base circle of the other gear. With w_j the engagement of the pair, k_j its
//! stiffness there and r_j its tip relief, the mesh stores
//!
//! ```text
//! U = ½ Σ_j w_j k_j (δ − r_j)²,        F = ∂U/∂δ
//! ```
//!
//! and the stiffness of a mesh follows the moving centres through lo, hi, t and s without a rule of its own.

mod curve;
mod engagement;
mod iso6336;
mod model;
mod pair;
mod potential_energy;
mod shared;

pub use curve::{Cycle, UniformCurve};
pub use iso6336::{Iso6336, iso6336};
pub use model::build;
pub use pair::Pair;
pub use potential_energy::{CONTACT_COMPLIANCE, Tooth};
pub use shared::Shared;

use crate::scene::{Engagement, Relief};

/// Where the pairs are: s of pair 0, the path of contact, and the base pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPath {
    /// s of pair 0, m.
    pub position: f64,
    /// C sin α, the length of the line of action between the base circles, m.
    pub tangent: f64,
    /// Beginning of the path of contact, m.
    pub low: f64,
    /// Its end, m.
    pub high: f64,
    /// Base pitch, m.
    pub pitch: f64,
}

impl ContactPath {
    /// Derivatives of both ends over C sin α: an end at a tip of the driven gear, or at its base circle, follows it.
    #[inline]
    fn end_slopes(&self) -> [f64; 2] {
        [f64::from(u8::from(self.low > 0.0)), f64::from(u8::from(self.high >= self.tangent))]
    }

    /// Where the ends stand among the pairs, in base pitches.
    pub fn ends(&self) -> [f64; 2] {
        [self.low, self.high].map(|end| (end - self.position) / self.pitch)
    }

    /// First and last pair between the ends; last < first where there is none.
    pub fn engaged(&self) -> (i64, i64) {
        let [low, high] = self.ends();
        (low.ceil() as i64, high.floor() as i64)
    }
}

/// What a mesh stores at a deflection, and how that changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stored {
    /// Elastic energy U, J.
    pub energy: f64,
    /// Force ∂U/∂δ, N.
    pub force: f64,
    /// Stiffness ∂²U/∂δ², N/m.
    pub stiffness: f64,
    /// ∂U/∂s, N: pairs that travel along the path.
    pub travel: f64,
    /// ∂U/∂(C sin α), N: the path of contact changes as the centres move along the line of centres.
    pub opening: f64,
}

/// The stiffness of a mesh.
#[derive(Clone, Debug)]
pub enum Stiffness {
    /// The same always, N/m.
    Mean(f64),
    /// Pairs of teeth.
    Pairs {
        /// One pair.
        pair: Pair,
        /// How a pair comes into contact and leaves it.
        engagement: Engagement,
        /// Tip relief, if the teeth have any.
        relief: Option<Relief>,
    },
    /// Pairs of teeth that share the gear bodies.
    Shared(Shared),
    /// The whole mesh over its cycle.
    Cycle(Cycle),
}

impl Stiffness {
    /// Energy and forces at `deflection`; `engaged` are the pairs that carry where engagement is sharp. Where the pairs
    /// are is asked for only if it matters.
    #[inline]
    pub fn stored(&self, path: impl FnOnce() -> ContactPath, engaged: (i64, i64), deflection: f64) -> Stored {
        if let Some(k) = self.while_engaged(engaged) {
            return Stored {
                energy: k * deflection * deflection / 2.0,
                force: k * deflection,
                stiffness: k,
                ..Stored::default()
            };
        }
        let path = &path();
        match self {
            // Always engaged.
            Self::Mean(_) => Stored::default(),
            Self::Shared(shared) => shared.stored(path, engaged, deflection),
            Self::Cycle(cycle) => {
                let (k, slope) = cycle.at(path.position / path.pitch);
                let half = deflection * deflection / 2.0;
                Stored {
                    energy: k * half,
                    force: k * deflection,
                    stiffness: k,
                    travel: slope / path.pitch * half,
                    opening: 0.0,
                }
            }
            Self::Pairs { pair, engagement, relief } => {
                let (first, last) = engagement.range(path, engaged);
                let [low_slope, high_slope] = path.end_slopes();
                let mut sum = Stored::default();
                for j in first..last + 1 {
                    let s = path.position + j as f64 * path.pitch;
                    let [k, slope, by_tangent] = pair.at(s, path.tangent);
                    let (entered, left) = (s - path.low, path.high - s);
                    let w = engagement.weight(entered, left, path.pitch);
                    let r = relief.as_ref().map_or([0.0; 3], |relief| relief.at(entered, left));
                    // A relieved pair that does not touch yet carries nothing; without relief the law is linear.
                    let d = if relief.is_some() { (deflection - r[0]).max(0.0) } else { deflection };
                    let half = d * d / 2.0;
                    let (by_entered, by_left) =
                        (half * k * w[1] - w[0] * k * d * r[1], half * k * w[2] - w[0] * k * d * r[2]);
                    sum.energy += w[0] * k * half;
                    sum.force += w[0] * k * d;
                    sum.stiffness += if d == 0.0 && relief.is_some() { 0.0 } else { w[0] * k };
                    sum.travel += half * w[0] * slope + by_entered - by_left;
                    sum.opening += half * w[0] * by_tangent - low_slope * by_entered + high_slope * by_left;
                }
                sum
            }
        }
    }

    /// Whether pairs come and go in jumps.
    pub fn is_sharp(&self) -> bool {
        let (Self::Pairs { engagement, .. } | Self::Shared(Shared { engagement, .. })) = self else { return false };
        *engagement == Engagement::Sharp
    }

    /// Whether the tips are relieved: pairs then touch one after the other as the deflection grows.
    pub fn is_relieved(&self) -> bool {
        matches!(self, Self::Pairs { relief: Some(_), .. })
    }

    /// Whether it is the same as long as no pair comes or goes.
    pub fn is_stepwise(&self) -> bool {
        self.while_engaged((0, 0)).is_some()
    }

    /// The stiffness that lasts as long as the `engaged` pairs do, N/m, where it does not depend on where they are.
    #[inline]
    fn while_engaged(&self, (first, last): (i64, i64)) -> Option<f64> {
        match self {
            Self::Mean(k) => Some(*k),
            Self::Pairs { pair: Pair::Uniform(k), engagement: Engagement::Sharp, relief: None } => {
                Some(k * (last - first + 1).max(0) as f64)
            }
            _ => None,
        }
    }

    /// Whether it is the same always.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Mean(_))
    }

    /// Mean over the mesh cycle, N/m, on this path of contact.
    pub fn mean(&self, path: &ContactPath) -> f64 {
        match self {
            Self::Mean(k) => *k,
            Self::Cycle(cycle) => cycle.mean(),
            Self::Shared(shared) => shared.mean(path),
            Self::Pairs { pair, engagement, .. } => mean_of_pairs(pair, engagement, path),
        }
    }

    /// A bound of the stiffness, N/m.
    pub fn largest(&self, path: &ContactPath) -> f64 {
        match self {
            Self::Mean(k) => *k,
            Self::Cycle(cycle) => cycle.largest(),
            Self::Shared(shared) => shared.largest(path),
            Self::Pairs { pair, .. } => pair.largest(path) * ((path.high - path.low) / path.pitch).ceil().max(1.0),
        }
    }
}

/// (1/p_b)∫w k ds over the path of contact, where w reaches beyond it, by Simpson's rule on pieces that meet
/// where w bends.
fn mean_of_pairs(pair: &Pair, engagement: &Engagement, path: &ContactPath) -> f64 {
    const PIECES: usize = 256;
    let &ContactPath { tangent, low, high, pitch, .. } = path;
    let half = if let Engagement::Smooth(width) = engagement { width * pitch / 2.0 } else { 0.0 };
    let at = |s: f64| engagement.weight(s - low, high - s, pitch)[0] * pair.at(s, tangent)[0];
    let piece = |from: f64, to: f64| {
        let h = (to - from) / PIECES as f64;
        let simpson = |i: usize| {
            let s = from + i as f64 * h;
            (at(s) + 4.0 * at(s + h / 2.0) + at(s + h)) * h / 6.0
        };
        (0..PIECES).map(simpson).sum::<f64>()
    };
    let (entered, leaving) = ((low + half).min(high), (high - half).max(low));
    (piece(low - half, entered.min(leaving))
        + piece(entered.min(leaving), leaving.max(entered))
        + piece(leaving.max(entered), high + half))
        / pitch
}
