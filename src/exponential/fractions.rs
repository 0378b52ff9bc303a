//! e^{At} of a motion in mode pairs for any time t within the longest step, as a product of tabulated matrices.
//!
//! t is written in digits to the base 16, in units of a fraction of the shortest substep. Each digit has a table of fifteen
//! matrices, computed at its first use. Other tables for each step level hold frequent fractions of a step: hundredths,
//! where output times at equal intervals often are, each computed at its first use, and the abscissae of the rules that
//! integrate powers.

use std::sync::OnceLock;

use super::packed::{Aligned, aligned};
use super::phi::{Block, exponential_of_pair};
use super::time_grid::TimeGrid;
use crate::integrate::quadrature_rules::NESTED;
use crate::modal::ModePair;

/// Binary digits of a digit to the base 16.
const BITS: usize = 4;
/// Halvings from the shortest substep, within which no mode rotates by a radian, to the unit. A Taylor series of a few terms
/// is exact within it.
const FURTHER_HALVINGS: usize = 12;

/// Values of a digit other than zero.
const VALUES: usize = (1 << BITS) - 1;

/// Largest number of digits: at most 30 + 12 binary digits, and one digit for the longest step itself.
pub(super) const MAX_DIGITS: usize = 12;

/// Number of equal parts of a step that have a table.
const PARTS: usize = 100;

/// Tables of e^{At}.
#[derive(Clone, Debug)]
pub struct Fractions {
    /// Unit of the digits, s.
    pub unit: f64,
    /// For each digit, the lowest first, e^{At} with t = 1 to 15 times its value.
    digits: Vec<Powers>,
    /// For each step level, e^{At} with t = 1 to 99 hundredths of the step.
    parts: Vec<OnceLock<Powers>>,
    /// For each step level, e^{At} with t at the abscissae of [`NESTED`].
    abscissae: Vec<OnceLock<Vec<[Aligned; 4]>>>,
    time_grid: TimeGrid,
}

/// A fraction of a step whose e^{At} has a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fraction {
    /// A number of hundredths.
    Hundredths(usize),
    /// The abscissa of [`NESTED`] with this index.
    Abscissa(usize),
}

/// The powers 1, 2, … of e^{At} for a time t, s.
#[derive(Clone, Debug)]
struct Powers {
    time: f64,
    /// Entries of the blocks.
    matrices: Vec<OnceLock<[Aligned; 4]>>,
}

impl Powers {
    fn new(time: f64, count: usize) -> Self {
        Self { time, matrices: vec![OnceLock::new(); count] }
    }

    /// The power of an exponent from 1 on, with the smallest number of products.
    fn get(&self, pairs: &[ModePair], exponent: usize) -> &[Aligned; 4] {
        self.matrices[exponent - 1].get_or_init(|| {
            if exponent == 1 {
                return packed(pairs.iter().map(|pair| exponential_of_pair(pair, self.time)));
            }
            let half = exponent / 2;
            let [a, b] = [half, exponent - half].map(|factor| self.get(pairs, factor));
            packed((0..pairs.len()).map(|slot| product(&block(a, slot), &block(b, slot))))
        })
    }
}

impl Fractions {
    /// The tables of a time grid.
    pub fn new(time_grid: &TimeGrid) -> Self {
        let digits = (time_grid.substep + FURTHER_HALVINGS).div_ceil(BITS);
        let unit = time_grid.longest / (1_u64 << (BITS * digits)) as f64;
        let digit = |position| Powers::new(unit * (1_u64 << (BITS * position)) as f64, VALUES);
        let parts = vec![OnceLock::new(); time_grid.finest + 1];
        let abscissae = vec![OnceLock::new(); time_grid.finest + 1];
        Self { unit, digits: (0..=digits).map(digit).collect(), parts, abscissae, time_grid: *time_grid }
    }

    /// The fraction with a table closest to a time, s, within a step, s, and its time, s.
    pub fn nearest(time: f64, step: f64) -> (Fraction, f64) {
        let hundredths = (time / step * PARTS as f64).round();
        let mut nearest = (Fraction::Hundredths(hundredths as usize), hundredths / PARTS as f64 * step);
        for (index, (at, _)) in NESTED.iter().enumerate() {
            if (at * step - time).abs() < (nearest.1 - time).abs() {
                nearest = (Fraction::Abscissa(index), at * step);
            }
        }
        nearest
    }

    /// e^{At}, where t is a fraction of the step of a step level; none for the beginning and the end of the step.
    pub fn part(&self, pairs: &[ModePair], level: usize, fraction: Fraction) -> Option<&[Aligned; 4]> {
        let step = self.time_grid.step(level);
        match fraction {
            Fraction::Hundredths(count @ 1..PARTS) => {
                let powers = self.parts[level].get_or_init(|| Powers::new(step / PARTS as f64, PARTS - 1));
                Some(powers.get(pairs, count))
            }
            Fraction::Hundredths(_) => None,
            Fraction::Abscissa(index) => {
                let of_pair = |at: f64| packed(pairs.iter().map(|pair| exponential_of_pair(pair, at * step)));
                let all = || NESTED.iter().map(|(at, _)| of_pair(*at)).collect();
                self.abscissae[level].get_or_init(all).get(index)
            }
        }
    }

    /// Positions and digits of a number of units, the lowest first.
    pub fn digits(units: u64) -> impl Iterator<Item = (usize, usize)> {
        (0..MAX_DIGITS).map(move |position| (position, (units >> (BITS * position)) as usize % (1 << BITS)))
    }

    /// e^{At} of a digit from 1 to 15 at `position`.
    pub fn matrix(&self, pairs: &[ModePair], position: usize, digit: usize) -> &[Aligned; 4] {
        let powers = &self.digits[position];
        // Steps end at any digit: later steps then allocate nothing.
        if powers.matrices.last().is_some_and(|last| last.get().is_none()) {
            (1..=VALUES).for_each(|exponent| {
                powers.get(pairs, exponent);
            });
        }
        powers.get(pairs, digit)
    }
}

/// The entries of blocks, one list each.
fn packed(blocks: impl Iterator<Item = Block>) -> [Aligned; 4] {
    let mut lists: [Vec<f64>; 4] = Default::default();
    for [[a, b], [c, d]] in blocks {
        lists.iter_mut().zip([a, b, c, d]).for_each(|(list, entry)| list.push(entry));
    }
    lists.each_ref().map(|list| aligned(list))
}

fn block([a, b, c, d]: &[Aligned; 4], slot: usize) -> Block {
    [[a[slot], b[slot]], [c[slot], d[slot]]]
}

fn product(a: &Block, b: &Block) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    #[test]
    fn fractions_give_the_exponential_of_parts_of_a_step() {
        let time_grid = TimeGrid { longest: 4e-4, finest: 3, substep: 2 };
        let fractions = Fractions::new(&time_grid);
        let value = Complex64::new(-30.0, 2e5);
        let of_hundredths = |count: usize| (count as f64 / 100.0, Fraction::Hundredths(count));
        let of_abscissa = |index: usize| (NESTED[index].0, Fraction::Abscissa(index));
        let hundredths = [(0, 1), (1, 7), (2, 50), (3, 99)].map(|(level, count)| (level, of_hundredths(count)));
        let abscissae = [(0, 3), (1, 5), (2, 14)].map(|(level, index)| (level, of_abscissa(index)));
        for (level, (at, fraction)) in hundredths.into_iter().chain(abscissae) {
            let (nearest, time) = Fractions::nearest(0.9999 * at * time_grid.step(level), time_grid.step(level));
            assert_eq!(nearest, fraction);
            let Some([a, b, ..]) = fractions.part(&[ModePair::Oscillation(value); 8], level, fraction) else {
                panic!("{fraction:?} has no table")
            };
            assert!((Complex64::new(a[0], b[0]) - (value * time).exp()).norm() < 1e-13, "{level} {fraction:?}");
        }
        let ends = [0, 100].map(|count| fractions.part(&[], 0, Fraction::Hundredths(count)));
        assert!(ends.iter().all(Option::is_none));
    }

    #[test]
    fn digits_give_the_exponential_of_any_number_of_units() {
        let time_grid = TimeGrid { longest: 4e-4, finest: 20, substep: 9 };
        let fractions = Fractions::new(&time_grid);
        let value = Complex64::new(-30.0, 2e5);
        let pairs = [ModePair::Oscillation(value); 8];
        let whole = (time_grid.longest / fractions.unit).round() as u64;
        for units in [1, 15, 16, 12345, whole / 3, whole - 1, whole] {
            let mut found = Complex64::ONE;
            for (position, digit) in Fractions::digits(units).filter(|(_, digit)| *digit > 0) {
                let [a, b, ..] = fractions.matrix(&pairs, position, digit);
                found *= Complex64::new(a[0], b[0]);
            }
            // The phase is rounded to 80 rad times the machine precision, in each of seven digits.
            assert!((found - (value * (units as f64 * fractions.unit)).exp()).norm() < 1e-13, "{units}");
        }
    }
}
