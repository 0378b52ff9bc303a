//! e^{At} of a motion in mode pairs for any time t within the longest step, as a product of tabulated matrices.
//!
//! t is written in digits to the base 16, in units of a fraction of the shortest substep. Each digit has a table of fifteen
//! matrices, each computed at its first use.

use std::sync::OnceLock;

use super::packed::{Aligned, aligned};
use super::phi::{Block, phi_of_pair};
use super::time_grid::TimeGrid;
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

/// Tables of e^{At}.
#[derive(Clone, Debug)]
pub struct Fractions {
    /// Unit of the digits, s.
    pub unit: f64,
    /// For each digit, the lowest first, e^{At} with t = 1 to 15 times its value.
    tables: Vec<[OnceLock<[Aligned; 4]>; VALUES]>,
}

impl Fractions {
    /// The tables of a time grid.
    pub fn new(time_grid: &TimeGrid) -> Self {
        let digits = (time_grid.event + FURTHER_HALVINGS).div_ceil(BITS);
        let unit = time_grid.longest / (1_u64 << (BITS * digits)) as f64;
        Self { unit, tables: (0..=digits).map(|_| Default::default()).collect() }
    }

    /// Positions and digits of a number of units, the lowest first.
    pub fn digits(units: u64) -> impl Iterator<Item = (usize, usize)> {
        (0..MAX_DIGITS).map(move |position| (position, (units >> (BITS * position)) as usize % (1 << BITS)))
    }

    /// e^{At} of a digit from 1 to 15 at `position`.
    pub fn matrix(&self, pairs: &[ModePair], position: usize, digit: usize) -> &[Aligned; 4] {
        self.tables[position][digit - 1].get_or_init(|| {
            if digit == 1 {
                let time = self.unit * (1_u64 << (BITS * position)) as f64;
                return packed(pairs.iter().map(|pair| phi_of_pair(pair, time)[0]));
            }
            // The powers with the smallest number of products.
            let (a, b) = if digit % 2 == 0 { (digit / 2, digit / 2) } else { (digit - 1, 1) };
            let [a, b] = [a, b].map(|factor| self.matrix(pairs, position, factor));
            packed((0..pairs.len()).map(|slot| product(&block(a, slot), &block(b, slot))))
        })
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
    fn digits_give_the_exponential_of_any_number_of_units() {
        let time_grid = TimeGrid { longest: 4e-4, finest: 20, event: 9 };
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
