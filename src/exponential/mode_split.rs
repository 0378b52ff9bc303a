//! Modes that are slow or fast within a step of one length.
//!
//! Under a load that is a polynomial of degree K over the fraction τ of a step h, a mode has the motion
//!
//! ```text
//! z(τ) = e^{Ahτ} (z₀ − g₀) + Σ gₙ τⁿ,        gₙ = (hA)⁻¹ [(n + 1) gₙ₊₁ − h b aₙ],   g_{K+1} = 0
//! ```
//!
//! where aₙ are the coefficients of the load: the polynomial is a motion under the load, and the rest is free. A slow mode
//! has a small hA, whose inverse would lose digits. Its complete motion is a power series:
//!
//! ```text
//! z(τ) = Σ gₙ τⁿ,        gₙ₊₁ = (hA gₙ + h b aₙ)/(n + 1),   g₀ = z₀
//! ```

use super::packed::{Aligned, WIDTH, aligned};
use crate::modal::ModePair;

/// Largest |λ| h of a slow mode, rad.
const SLOW: f64 = 2.0;
/// Highest power of the series: 2²⁴/24! is below round-off.
pub(super) const DEGREE: usize = 24;

/// The modes of a motion, divided into slow and fast ones for one step length. Lists have one entry for each slot.
#[derive(Clone, Debug)]
pub struct ModeSplit {
    /// Step h, s.
    pub step: f64,
    /// Entries of hA of slow modes; zero for fast ones.
    pub slow_blocks: [Aligned; 4],
    /// Entries of (hA)⁻¹ of fast modes; zero for slow ones.
    pub inverses: [Aligned; 4],
    /// 1 where the first, or the second, coordinate of a slot is slow, otherwise 0.
    pub is_slow: [Aligned; 2],
    /// Whether the slots of each chunk of [`WIDTH`] contain a slow mode.
    pub has_slow: Vec<bool>,
}

impl ModeSplit {
    /// Divides mode pairs for a step, s; `None` if the two coordinates of a pair are coupled and only one is slow.
    pub fn new(pairs: &[ModePair], step: f64) -> Option<Self> {
        let mut slow_blocks: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; pairs.len()]);
        let mut inverses = slow_blocks.clone();
        let mut is_slow: [Vec<f64>; 2] = std::array::from_fn(|_| vec![0.0; pairs.len()]);
        for (slot, pair) in pairs.iter().enumerate() {
            let slow = match pair {
                ModePair::Oscillation(value) => [value.norm() * step <= SLOW; 2],
                ModePair::Real(values) => values.map(|value| value.abs() * step <= SLOW),
                ModePair::RigidBodyPair(rate) if rate.abs() * step <= SLOW => [true; 2],
                ModePair::RigidBodyPair(_) => return None,
            };
            let [[a, b], [c, d]] = pair.block().map(|row| row.map(|entry| entry * step));
            let determinant = a * d - b * c;
            let inverse = match pair {
                ModePair::Real(_) => [1.0 / a, 0.0, 0.0, 1.0 / d],
                _ => [d / determinant, -b / determinant, -c / determinant, a / determinant],
            };
            for (entry, value) in [a, b, c, d].into_iter().enumerate() {
                let list = if slow[entry / 2] { &mut slow_blocks } else { &mut inverses };
                list[entry][slot] = if slow[entry / 2] { value } else { inverse[entry] };
            }
            for (list, slow) in is_slow.iter_mut().zip(slow) {
                list[slot] = if slow { 1.0 } else { 0.0 };
            }
        }
        let any = |chunk: usize| is_slow.iter().any(|list| list[chunk * WIDTH..][..WIDTH].contains(&1.0));
        Some(Self {
            step,
            has_slow: (0..pairs.len() / WIDTH).map(any).collect(),
            slow_blocks: slow_blocks.each_ref().map(|list| aligned(list)),
            inverses: inverses.each_ref().map(|list| aligned(list)),
            is_slow: is_slow.each_ref().map(|list| aligned(list)),
        })
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    #[test]
    fn each_coordinate_is_slow_or_fast() {
        let rigid = ModePair::RigidBodyPair(-1.0);
        let pairs = [ModePair::Oscillation(Complex64::new(-1.0, 100.0)), ModePair::Real([-1.0, -1e6]), rigid, rigid]
            .into_iter()
            .cycle()
            .take(2 * WIDTH)
            .collect::<Vec<_>>();
        let Some(split) = ModeSplit::new(&pairs, 1.0) else { panic!("no pair is coupled") };
        assert_eq!(
            [0, 1, 2].map(|slot| split.is_slow.each_ref().map(|list| list[slot])),
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
        );
        // A slow coordinate has no inverse, and a fast one no block.
        assert_eq!(split.inverses.each_ref().map(|list| list[1]), [0.0, 0.0, 0.0, -1e-6]);
        assert_eq!(split.slow_blocks.each_ref().map(|list| list[1]), [-1.0, 0.0, 0.0, 0.0]);
        assert_eq!(split.has_slow, [true, true]);
    }

    #[test]
    fn a_rigid_body_motion_that_decays_within_the_step_is_neither() {
        let pairs = vec![ModePair::RigidBodyPair(-1e3); WIDTH];
        assert!(ModeSplit::new(&pairs, 1e-3).is_some());
        assert!(ModeSplit::new(&pairs, 1e-2).is_none());
    }
}
