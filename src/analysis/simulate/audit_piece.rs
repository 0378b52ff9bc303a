//! A part of a step in the energy audit: the powers at its abscissae, and the works that follow from them.

use std::sync::LazyLock;

use crate::integrate::quadrature_rules::{GAUSS, NESTED, NESTED_RULES, POINTS};

/// The rule with which the works of a part of a step are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    Gauss,
    /// The rule with this number in [`NESTED`].
    Nested(usize),
}

impl Rule {
    /// Abscissae and weights.
    pub fn points(self) -> impl Iterator<Item = (f64, f64)> {
        let (gauss, nested) = match self {
            Self::Gauss => (&GAUSS[..], (&NESTED[..0], 0)),
            Self::Nested(rule) => (&GAUSS[..0], (&NESTED[..POINTS[rule]], rule)),
        };
        gauss.iter().copied().chain(nested.0.iter().map(move |(at, weights)| (*at, weights[nested.1])))
    }

    /// The first abscissae, also those of more accurate nested rules, and their weights.
    pub fn points_up_to(self, end: usize) -> impl Iterator<Item = (f64, f64)> {
        match self {
            Self::Gauss => Self::Gauss.points(),
            Self::Nested(_) => Self::Nested(NESTED_RULES - 1).points(),
        }
        .take(end)
    }

    /// Legendre coefficients of the polynomials that are 1 at one abscissa and 0 at the others.
    fn expansions(self) -> &'static [Vec<f64>] {
        static EXPANSIONS: LazyLock<[Vec<Vec<f64>>; NESTED_RULES + 1]> = LazyLock::new(|| {
            let nested = [0, 1, 2, 3].map(|rule| expand(&NESTED.map(|(at, _)| at)[..POINTS[rule]]));
            let [a, b, c, d] = nested;
            [a, b, c, d, expand(&GAUSS.map(|(at, _)| at))]
        });
        match self {
            Self::Nested(rule) => &EXPANSIONS[rule],
            Self::Gauss => &EXPANSIONS[NESTED_RULES],
        }
    }
}

/// Legendre coefficients of the polynomials that are 1 at one of these abscissae and 0 at the others.
fn expand(abscissae: &[f64]) -> Vec<Vec<f64>> {
    let finest = || Rule::Nested(NESTED_RULES - 1).points();
    let of_node = |node: &f64| {
        let others = || abscissae.iter().filter(|other| *other != node);
        let mut coefficients = vec![0.0; abscissae.len()];
        for (at, weight) in (0..PARTS).flat_map(|part| finest().map(move |(at, weight)| (f64::from(part) + at, weight)))
        {
            let at = at / f64::from(PARTS);
            let basis =
                others().map(|other| (at - other) / (node - other)).product::<f64>() * weight / f64::from(PARTS);
            for (k, (coefficient, polynomial)) in coefficients.iter_mut().zip(legendre(at)).enumerate() {
                *coefficient += (2 * k + 1) as f64 * basis * polynomial;
            }
        }
        coefficients
    };
    abscissae.iter().map(of_node).collect()
}

/// Largest degree of an expansion.
const MAX_DEGREE: usize = NESTED.len() - 1;
/// The finest rule on each of so many parts integrates products of two expansions without error.
const PARTS: u8 = 8;

/// Powers at an instant, and the potentials of constant loads.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    /// Powers of every source, W.
    pub powers: [f64; 6],
    /// Constant loads times displacements, J: torques and forces, weights. Zero with the Gauss rule, where `powers` contain
    /// the constant loads.
    pub potentials: [f64; 2],
}

/// A part of a step with the samples at its abscissae.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Elapsed time at the beginning and at the end, s.
    pub span: [f64; 2],
    pub rule: Rule,
    pub samples: [Sample; NESTED.len()],
}

impl Piece {
    pub fn new(begin: f64, end: f64, rule: Rule) -> Self {
        Self { span: [begin, end], rule, samples: [Sample::default(); NESTED.len()] }
    }

    pub fn length(&self) -> f64 {
        self.span[1] - self.span[0]
    }

    /// Elapsed time at a fraction, s.
    pub fn time(&self, at: f64) -> f64 {
        if at == 1.0 { self.span[1] } else { self.span[0] + at * self.length() }
    }

    /// Work of every source, J.
    pub fn works(&self) -> [f64; 6] {
        let mut works = self.sum(|power| power);
        if let Rule::Nested(_) = self.rule {
            self.add_potentials(&self.samples[1].potentials, &mut works);
        }
        works
    }

    /// Adds the potentials of constant loads at an instant minus those at the beginning.
    fn add_potentials(&self, potentials: &[f64], works: &mut [f64; 6]) {
        for (work, (end, begin)) in works.iter_mut().zip(potentials.iter().zip(&self.samples[0].potentials)) {
            *work += end - begin;
        }
    }

    /// Integral of the absolute powers, and the absolute works of constant loads, J.
    pub fn magnitude(&self) -> f64 {
        let [begin, end] = [0, 1].map(|end: usize| self.samples[end].potentials);
        let constant: f64 = begin.iter().zip(end).map(|(begin, end)| (end - begin).abs()).sum();
        self.sum(f64::abs).iter().sum::<f64>() + constant
    }

    fn sum(&self, term: impl Fn(f64) -> f64) -> [f64; 6] {
        let mut sums = [0.0; 6];
        for ((_, weight), sample) in self.rule.points().zip(&self.samples) {
            for (sum, power) in sums.iter_mut().zip(&sample.powers) {
                *sum += weight * self.length() * term(*power);
            }
        }
        sums
    }

    /// Work of every source from the beginning to the fraction `part`, J, where the constant loads have these potentials: the
    /// integral of the polynomials through the powers.
    pub fn works_until(&self, part: f64, potentials: &[f64]) -> [f64; 6] {
        let at = legendre(part);
        let mut works = [0.0; 6];
        for (coefficients, sample) in self.rule.expansions().iter().zip(&self.samples) {
            // The integral of P_k from 0 to the fraction is (P_{k+1} - P_{k-1})/(4k + 2).
            let higher = coefficients.iter().enumerate().skip(1);
            let sum: f64 = higher.map(|(k, factor)| factor * (at[k + 1] - at[k - 1]) / (4 * k + 2) as f64).sum();
            let weight = self.length() * (coefficients[0] * part + sum);
            works.iter_mut().zip(&sample.powers).for_each(|(work, power)| *work += weight * power);
        }
        if let Rule::Nested(_) = self.rule {
            self.add_potentials(potentials, &mut works);
        }
        works
    }
}

/// The Legendre polynomials up to the degree after [`MAX_DEGREE`], moved to the interval [0, 1].
fn legendre(at: f64) -> [f64; MAX_DEGREE + 2] {
    let (x, mut values) = (2.0 * at - 1.0, [1.0; MAX_DEGREE + 2]);
    values[1] = x;
    for k in 1..=MAX_DEGREE {
        let order = k as f64;
        values[k + 1] = ((2.0 * order + 1.0) * x * values[k] - order * values[k - 1]) / (order + 1.0);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::{Piece, Rule};

    #[test]
    fn partial_works_of_polynomials_are_exact() {
        for (rule, points) in [Rule::Gauss, Rule::Nested(0), Rule::Nested(1), Rule::Nested(2), Rule::Nested(3)]
            .into_iter()
            .zip([3, 3, 5, 9, 17])
        {
            let degree = points - 1;
            let mut piece = Piece::new(3.0, 5.0, rule);
            for ((at, _), sample) in rule.points().zip(&mut piece.samples) {
                sample.powers = std::array::from_fn(|source| source as f64 * at.powi(degree));
                sample.potentials = [at, -at];
            }
            for part in [0.0, 0.1, 0.5, 0.77, 1.0] {
                let exact = 2.0 * f64::powi(part, degree + 1) / f64::from(degree + 1);
                let potential = if rule == Rule::Gauss { 0.0 } else { part };
                // Seventeen abscissae with seventeen polynomials each.
                let works = piece.works_until(part, &[part, -part]);
                assert!((works[0] - potential).abs() < 1e-13 && (works[1] - exact + potential).abs() < 1e-13);
                assert!((works[2] - 2.0 * exact).abs() < 1e-13 && (works[5] - 5.0 * exact).abs() < 1e-13);
            }
        }
    }
}
