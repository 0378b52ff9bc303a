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
    /// Number of terms of the series of each chunk of [`WIDTH`] slots; zero without a slow mode.
    pub terms: Vec<usize>,
}

impl ModeSplit {
    /// Divides mode pairs for a step, s, under loads with `powers` coefficients; `None` if the two coordinates of a pair are
    /// coupled and only one is slow.
    pub fn new(pairs: &[ModePair], step: f64, powers: usize) -> Option<Self> {
        let mut slow_blocks: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; pairs.len()]);
        let mut inverses = slow_blocks.clone();
        let mut is_slow: [Vec<f64>; 2] = std::array::from_fn(|_| vec![0.0; pairs.len()]);
        let mut terms = vec![0; pairs.len() / WIDTH];
        for (slot, pair) in pairs.iter().enumerate() {
            let slow = match pair {
                ModePair::RigidBodyPair(rate) if rate.abs() * step > SLOW => return None,
                _ => rates(pair).map(|rate| rate * step <= SLOW),
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
            let rotations = rates(pair).map(|rate| rate * step);
            for rotation in rotations.into_iter().zip(slow).filter_map(|(rotation, slow)| slow.then_some(rotation)) {
                let terms = &mut terms[slot / WIDTH];
                *terms = series_terms(rotation, powers).max(*terms);
            }
        }
        Some(Self {
            step,
            terms,
            slow_blocks: slow_blocks.each_ref().map(|list| aligned(list)),
            inverses: inverses.each_ref().map(|list| aligned(list)),
            is_slow: is_slow.each_ref().map(|list| aligned(list)),
        })
    }
}

/// |λ| of both coordinates of a pair, rad/s.
fn rates(pair: &ModePair) -> [f64; 2] {
    match pair {
        ModePair::Oscillation(value) => [value.norm(); 2],
        ModePair::Real(values) => values.map(f64::abs),
        ModePair::RigidBodyPair(rate) => [rate.abs(); 2],
    }
}

/// Number of terms of the series of a slow mode with |λ|h = `rotation`, under loads with K + 1 = `powers` coefficients. From
/// g_{K+2} on, which the rotation of a rigid body still needs, each term is hA/n times the one before.
fn series_terms(rotation: f64, powers: usize) -> usize {
    let (mut terms, mut size) = (powers + 2, 1.0);
    while terms <= DEGREE && size >= f64::EPSILON / 2.0 {
        size *= rotation / terms as f64;
        terms += 1;
    }
    terms
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
        let Some(split) = ModeSplit::new(&pairs, 1.0, 5) else { panic!("no pair is coupled") };
        assert_eq!(
            [0, 1, 2].map(|slot| split.is_slow.each_ref().map(|list| list[slot])),
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
        );
        // A slow coordinate has no inverse, and a fast one no block.
        assert_eq!(split.inverses.each_ref().map(|list| list[1]), [0.0, 0.0, 0.0, -1e-6]);
        assert_eq!(split.slow_blocks.each_ref().map(|list| list[1]), [-1.0, 0.0, 0.0, 0.0]);
        assert_eq!(split.terms, [series_terms(1.0, 5); 2]);
    }

    #[test]
    fn a_series_ends_where_its_terms_are_round_off() {
        assert_eq!(series_terms(0.0, 5), 8);
        assert_eq!(series_terms(SLOW, 6), DEGREE + 1);
        // Without a load, the terms are those of the exponential function.
        for rotation in [1e-3, 0.1, 0.5, 1.0] {
            let terms = series_terms(rotation, 0);
            let last = (1..terms).map(|n| rotation / n as f64).product::<f64>();
            assert!(last < f64::EPSILON, "{rotation}: {terms}");
        }
    }

    #[test]
    fn a_rigid_body_motion_that_decays_within_the_step_is_neither() {
        let pairs = vec![ModePair::RigidBodyPair(-1e3); WIDTH];
        assert!(ModeSplit::new(&pairs, 1e-3, 5).is_some());
        assert!(ModeSplit::new(&pairs, 1e-2, 5).is_none());
    }
}
