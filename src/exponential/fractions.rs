//! e^{At} of a motion in mode pairs for any time t within the longest step, as a product of tabulated matrices.
//!
//! t is written in digits to the base 16, in units of a fraction of the shortest substep. Each digit has a table of fifteen
//! matrices.

use std::cell::OnceCell;

use super::packed::{Aligned, aligned};
use super::phi::{Block, phi_of_pair};
use super::time_grid::TimeGrid;
use crate::modal::ModePair;

/// Binary digits of a digit to the base 16.
const BITS: usize = 4;
/// Halvings from the shortest substep, within which no mode rotates by a radian, to the unit. A Taylor series of a few terms
/// is exact within it.
const FURTHER_HALVINGS: usize = 12;

/// Largest number of digits: at most 30 + 12 binary digits, and one digit for the longest step itself.
pub(super) const MAX_DIGITS: usize = 12;

/// Tables of e^{At}.
#[derive(Clone, Debug)]
pub struct Fractions {
    /// Unit of the digits, s.
    pub unit: f64,
    /// For each digit, the lowest first, e^{At} with t = 1 to 15 times its value, computed at the first use.
    tables: Vec<OnceCell<Vec<[Aligned; 4]>>>,
}

impl Fractions {
    /// The tables of a time grid.
    pub fn new(time_grid: &TimeGrid) -> Self {
        let digits = (time_grid.event + FURTHER_HALVINGS).div_ceil(BITS);
        let unit = time_grid.longest / (1_u64 << (BITS * digits)) as f64;
        Self { unit, tables: vec![OnceCell::new(); digits + 1] }
    }

    /// Positions and digits of a number of units, the lowest first.
    pub fn digits(units: u64) -> impl Iterator<Item = (usize, usize)> {
        (0..MAX_DIGITS).map(move |position| (position, (units >> (BITS * position)) as usize % (1 << BITS)))
    }

    /// e^{At} of a digit from 1 to 15 at `position`.
    pub fn matrix(&self, pairs: &[ModePair], position: usize, digit: usize) -> &[Aligned; 4] {
        let table = self.tables[position].get_or_init(|| {
            let time = self.unit * (1_u64 << (BITS * position)) as f64;
            table(pairs.iter().map(|pair| phi_of_pair(pair, time)[0]).collect())
        });
        &table[digit - 1]
    }
}

/// The first fifteen powers of matrices, each with the smallest number of products.
fn table(first: Vec<Block>) -> Vec<[Aligned; 4]> {
    let mut powers: Vec<Vec<Block>> = vec![first];
    for power in 2..1 << BITS {
        let (a, b) = if power % 2 == 0 { (power / 2, power / 2) } else { (power - 1, 1) };
        let product = powers[a - 1].iter().zip(&powers[b - 1]).map(|(a, b)| product(a, b)).collect();
        powers.push(product);
    }
    let list = |blocks: &Vec<Block>, row: usize, column: usize| {
        aligned(&blocks.iter().map(|block| block[row][column]).collect::<Vec<_>>())
    };
    let packed = |blocks| [list(blocks, 0, 0), list(blocks, 0, 1), list(blocks, 1, 0), list(blocks, 1, 1)];
    powers.iter().map(packed).collect()
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
