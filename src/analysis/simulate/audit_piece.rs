//! A part of a step in the energy audit: the powers at its points, and the works that follow from them.
//!
//! The Clenshaw–Curtis rule with N intervals integrates the polynomial through the powers at the fractions (1 − cos(kπ/N))/2.
//! A rule has every second point of the rule with twice as many intervals.

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::motion::{CONSTANT_LOAD_SUMS, SourceTerms};

/// Largest number of intervals of a rule.
pub(super) const MAX_INTERVALS: usize = 8;
/// One value for each point.
type PointValues = [f64; MAX_INTERVALS + 1];

/// cos(kπ/N) for the largest N and a full turn.
static COSINES: LazyLock<[f64; 2 * MAX_INTERVALS]> =
    LazyLock::new(|| std::array::from_fn(|k| (PI * k as f64 / MAX_INTERVALS as f64).cos()));
/// Weights of each rule for the complete interval, by its number of intervals.
static WHOLE: LazyLock<[PointValues; MAX_INTERVALS + 1]> =
    LazyLock::new(|| std::array::from_fn(|intervals| weights(intervals.max(1), 1.0)));

/// Fraction of the interval of a point.
pub(super) fn fraction(point: usize) -> f64 {
    (1.0 - COSINES[point]) / 2.0
}

/// Weights of the values at the points of a rule for the integral from the beginning to the fraction `part`.
fn weights(intervals: usize, part: f64) -> PointValues {
    let x = 2.0 * part - 1.0;
    // Integrals of the Chebyshev polynomials from −1 to x: T_j has the integral T_{j+1}/(2j + 2) − T_{j−1}/(2j − 2).
    let mut integrals: PointValues = [0.0; MAX_INTERVALS + 1];
    let (mut before, mut value, mut sign) = (x, 1.0, 1.0);
    for (j, integral) in integrals[..=intervals].iter_mut().enumerate() {
        let (order, next) = (j as f64, if j == 0 { x } else { 2.0 * x * value - before });
        *integral = match j {
            0 => x + 1.0,
            1 => (x * x - 1.0) / 2.0,
            _ => next / (2.0 * order + 2.0) - before / (2.0 * order - 2.0) - sign / (order * order - 1.0),
        };
        (before, value, sign) = (value, next, -sign);
    }
    let stride = MAX_INTERVALS / intervals;
    let halved = |k: usize| if k.is_multiple_of(intervals) { 0.5 } else { 1.0 };
    let mut weights = [0.0; MAX_INTERVALS + 1];
    for k in 0..=intervals {
        // T_j is cos(jπ(1 − k/N)) at point k.
        let term =
            |(j, integral): (usize, &f64)| halved(j) * COSINES[j * (intervals - k) * stride % COSINES.len()] * integral;
        let sum: f64 = integrals[..=intervals].iter().enumerate().map(term).sum();
        weights[k * stride] = halved(k) * sum / intervals as f64;
    }
    weights
}

/// Powers at an instant, and the potentials of constant loads.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    /// Power of every source, W.
    pub powers: SourceTerms,
    /// Constant loads times displacements, J: torques and forces, weights.
    pub potentials: [f64; CONSTANT_LOAD_SUMS],
}

/// A part of a step with the samples at its points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Elapsed time at the beginning and at the end, s.
    pub span: [f64; 2],
    /// Number of intervals of the rule: a power of two.
    pub intervals: usize,
    /// Samples at the points of the rule with most intervals.
    pub samples: [Sample; MAX_INTERVALS + 1],
}

impl Piece {
    pub fn new(span: [f64; 2]) -> Self {
        Self { span, intervals: 1, samples: [Sample::default(); MAX_INTERVALS + 1] }
    }

    /// Elapsed time of a point, s.
    pub fn time(&self, point: usize) -> f64 {
        let [begin, end] = self.span;
        if point == MAX_INTERVALS { end } else { begin + fraction(point) * (end - begin) }
    }

    /// Work of every source, J.
    pub fn works(&self) -> SourceTerms {
        self.integral(&WHOLE[self.intervals], &self.samples[MAX_INTERVALS].potentials)
    }

    /// Work of every source from the beginning to an instant, J, where the constant loads have these potentials: the integral
    /// of the polynomials through the powers.
    pub fn works_until(&self, elapsed: f64, potentials: &[f64]) -> SourceTerms {
        let [begin, end] = self.span;
        if elapsed >= end {
            self.works()
        } else {
            self.integral(&weights(self.intervals, (elapsed - begin) / (end - begin)), potentials)
        }
    }

    /// Integral of the absolute powers, and the absolute works of constant loads, J.
    pub fn magnitude(&self) -> f64 {
        let [begin, end] = [0, MAX_INTERVALS].map(|end: usize| self.samples[end].potentials);
        let constant: f64 = begin.iter().zip(end).map(|(begin, end)| (end - begin).abs()).sum();
        let powers = WHOLE[self.intervals].iter().zip(&self.samples);
        let sum = powers.map(|(weight, sample)| weight * sample.powers.magnitude());
        sum.sum::<f64>() * (self.span[1] - self.span[0]) + constant
    }

    /// Sum of the powers with weights, and the potentials at the same instant minus those at the beginning, J.
    fn integral(&self, weights: &PointValues, potentials: &[f64]) -> SourceTerms {
        let mut works = SourceTerms::default();
        for (weight, sample) in weights.iter().zip(&self.samples) {
            works = works.plus(weight * (self.span[1] - self.span[0]), &sample.powers);
        }
        let begin = &self.samples[0].potentials;
        works.torque += potentials[0] - begin[0];
        works.gravity += potentials[1] - begin[1];
        works
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_INTERVALS, Piece, fraction};
    use crate::motion::SourceTerms;

    #[test]
    fn works_of_polynomials_are_exact() {
        for intervals in [1, 2, 4, 8] {
            let mut piece = Piece { intervals, ..Piece::new([3.0, 5.0]) };
            for point in (0..=MAX_INTERVALS).step_by(MAX_INTERVALS / intervals) {
                let at = fraction(point);
                let power = |source: usize| source as f64 * at.powi(intervals as i32);
                piece.samples[point].powers = SourceTerms::from_values(std::array::from_fn(power));
                piece.samples[point].potentials = [at, -at];
            }
            for part in [0.0, 0.1, 0.5, 0.77, 1.0] {
                let exact = 2.0 * f64::powi(part, intervals as i32 + 1) / (intervals + 1) as f64;
                // Nine points with nine polynomials each.
                let works = piece.works_until(3.0 + 2.0 * part, &[part, -part]).values();
                assert!((works[0] - part).abs() < 1e-14 && (works[1] - exact + part).abs() < 1e-14);
                assert!((works[2] - 2.0 * exact).abs() < 1e-14 && (works[5] - 5.0 * exact).abs() < 1e-13);
            }
        }
    }
}
