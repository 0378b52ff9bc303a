//! Band matrices with a number of subdiagonals and as many superdiagonals, and their LU factors with partial pivoting.
//!
//! With L subdiagonals a row stores its W = 2L + 1 entries. Row exchanges fill at most L more superdiagonals, so the factors
//! need the same W entries per row (Golub and Van Loan, Matrix Computations, 4th ed., section 4.3). Factorization and
//! solution take time proportional to the number of rows, and they are backward stable, also for an indefinite matrix. The
//! entries are real or complex.

use std::ops::Range;

use crate::numerics::ROUND_OFF;
use nalgebra::{Complex, ComplexField};
use pulp::Arch;
use thiserror::Error;

/// Error: a matrix has no LU factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the matrix is singular")]
pub struct Singular;

/// Real or complex numbers in double precision.
pub trait Number: ComplexField<RealField = f64> + Copy {}

impl<T: ComplexField<RealField = f64> + Copy> Number for T {}

/// A band matrix; row i stores the columns from i − L to i + L.
#[derive(Clone, Debug)]
pub struct Band<T> {
    /// L.
    reach: usize,
    /// Number of rows.
    size: usize,
    /// Entries row by row, W for each row.
    entries: Vec<T>,
}

impl<T: Number> Band<T> {
    /// Zero matrix with `size` rows and `reach` subdiagonals.
    pub fn zeros(size: usize, reach: usize) -> Self {
        Self { reach, size, entries: vec![T::zero(); size * (2 * reach + 1)] }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether an entry lies within the band.
    pub fn contains(&self, row: usize, column: usize) -> bool {
        row.abs_diff(column) <= self.reach
    }

    /// Adds `value` to the entry (`row`, `column`), which lies within the band.
    #[inline]
    pub fn add(&mut self, row: usize, column: usize, value: T) {
        // The entry (row, column) has the place (2L + 1)·row + column + L − row.
        self.entries[2 * self.reach * row + column + self.reach] += value;
    }

    /// The columns of row `row` within the band, and its entries there.
    #[inline]
    pub fn row(&self, row: usize) -> (Range<usize>, &[T]) {
        let columns = row.saturating_sub(self.reach)..self.size.min(row + self.reach + 1);
        // The entry (row, column) has the place (2L + 1)·row + column + L − row.
        let first = 2 * self.reach * row + self.reach + columns.start;
        let entries = &self.entries[first..first + columns.len()];
        (columns, entries)
    }

    /// LU factors.
    ///
    /// # Errors
    /// [`Singular`] if a pivot is zero or not finite.
    pub fn factor(self) -> Result<BandLu<T>, Singular> {
        // The compiler unrolls the loops over a constant number of entries: that of a diagonal matrix, and of shafts of degree one
        // in torsion and in bending.
        Arch::new().dispatch(
            #[inline(always)]
            || match self.reach {
                0 => self.factor_with(0, true),
                1 => self.factor_with(1, true),
                3 => self.factor_with(3, true),
                reach => self.factor_with(reach, true),
            },
        )
    }

    /// The same without row exchanges: accurate for a positive definite matrix, whose pivots are positive.
    ///
    /// # Errors
    /// As [`Self::factor`].
    pub fn factor_without_exchanges(self) -> Result<BandLu<T>, Singular> {
        let reach = self.reach;
        Arch::new().dispatch(
            #[inline(always)]
            || self.factor_with(reach, false),
        )
    }

    #[inline(always)]
    fn factor_with(self, reach: usize, exchanges: bool) -> Result<BandLu<T>, Singular> {
        let (size, width) = (self.size, 2 * reach + 1);
        // Without exchanges, U has no more superdiagonals than the matrix.
        let filled = if exchanges { width } else { reach + 1 };
        let mut upper = self.entries;
        // Every row begins with its first column within the matrix.
        for (row, entries) in upper.chunks_exact_mut(width).enumerate().take(reach) {
            entries.rotate_left(reach - row);
            entries[width - (reach - row)..].fill(T::zero());
        }
        let mut lower = vec![T::zero(); size * reach];
        let mut pivots = Vec::with_capacity(size);
        let mut inverse = Vec::with_capacity(size);
        for k in 0..size {
            let end = size.min(k + reach + 1);
            let mut pivot = k;
            for row in k + 1..if exchanges { end } else { k + 1 } {
                if upper[row * width].norm1() > upper[pivot * width].norm1() {
                    pivot = row;
                }
            }
            let largest = upper[pivot * width].norm1();
            if !(largest > 0.0 && largest.is_finite()) {
                return Err(Singular);
            }
            let (done, rest) = upper.split_at_mut((k + 1) * width);
            let top = &mut done[k * width..];
            if pivot > k {
                top.swap_with_slice(&mut rest[(pivot - k - 1) * width..(pivot - k) * width]);
            }
            pivots.push(pivot - k);
            let reciprocal = top[0].recip();
            inverse.push(reciprocal);
            let below = rest.chunks_exact_mut(width).zip(&mut lower[k * reach..(k + 1) * reach]);
            for (entries, multiplier) in below.take(end - k - 1) {
                let factor = entries[0] * reciprocal;
                *multiplier = factor;
                for j in 1..filled {
                    entries[j - 1] = entries[j] - factor * top[j];
                }
                entries.copy_within(filled.., filled - 1);
                entries[width - 1] = T::zero();
            }
        }
        Ok(BandLu { reach, upper, inverse, lower, pivots })
    }
}

impl Band<Complex<f64>> {
    /// The same matrix with real numbers, if every entry is real but for round-off.
    pub fn real(&self) -> Option<Band<f64>> {
        let entries =
            self.entries.iter().map(|value| (value.im.abs() <= ROUND_OFF * value.re.abs()).then_some(value.re));
        Some(Band { reach: self.reach, size: self.size, entries: entries.collect::<Option<_>>()? })
    }
}

/// LU factors of a [`Band`].
#[derive(Clone, Debug)]
pub struct BandLu<T> {
    /// L.
    reach: usize,
    /// Rows of U, each from its diagonal entry on, W entries for each row.
    upper: Vec<T>,
    /// Inverses of the diagonal entries of U.
    inverse: Vec<T>,
    /// Multipliers of the rows below each pivot, L for each row.
    lower: Vec<T>,
    /// Distance of the row that was exchanged with each row.
    pivots: Vec<usize>,
}

impl<T: Number> BandLu<T> {
    /// Number of rows.
    pub fn size(&self) -> usize {
        self.pivots.len()
    }

    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&self, x: &mut [T]) {
        self.solve_part(x, 0, 0);
    }

    /// The same for a right-hand side that is zero before the entry `from`; the entries of the solution before `to` are not
    /// computed.
    pub fn solve_part(&self, x: &mut [T], from: usize, to: usize) {
        // As in [`Band::factor`].
        Arch::new().dispatch(
            #[inline(always)]
            || match self.reach {
                0 => self.solve_with(0, x, from, to),
                1 => self.solve_with(1, x, from, to),
                3 => self.solve_with(3, x, from, to),
                reach => self.solve_with(reach, x, from, to),
            },
        );
    }

    #[inline(always)]
    fn solve_with(&self, reach: usize, x: &mut [T], from: usize, to: usize) {
        let width = 2 * reach + 1;
        // Row exchanges move an entry up by the reach at most.
        // A diagonal matrix has no multipliers.
        for (k, lower) in self.lower.chunks_exact(reach.max(1)).enumerate().skip(from.saturating_sub(reach)) {
            x.swap(k, k + self.pivots[k]);
            let (done, rest) = x.split_at_mut(k + 1);
            let value = done[k];
            for (entry, factor) in rest.iter_mut().zip(lower) {
                *entry -= *factor * value;
            }
        }
        for (k, upper) in self.upper.chunks_exact(width).enumerate().skip(to).rev() {
            let (head, tail) = x.split_at_mut(k + 1);
            let mut sum = head[k];
            for (entry, factor) in tail.iter().zip(&upper[1..]) {
                sum -= *factor * *entry;
            }
            head[k] = sum * self.inverse[k];
        }
    }

    /// Replaces the right-hand side `x` by the solution with the transposed matrix.
    pub fn solve_transposed(&self, x: &mut [T]) {
        let width = 2 * self.reach + 1;
        for (k, upper) in self.upper.chunks_exact(width).enumerate() {
            let (head, tail) = x.split_at_mut(k + 1);
            head[k] *= self.inverse[k];
            for (entry, factor) in tail.iter_mut().zip(&upper[1..]) {
                *entry -= *factor * head[k];
            }
        }
        for (k, lower) in self.lower.chunks_exact(self.reach.max(1)).enumerate().rev() {
            let (head, tail) = x.split_at_mut(k + 1);
            for (entry, factor) in tail.iter().zip(lower) {
                head[k] -= *factor * *entry;
            }
            x.swap(k, k + self.pivots[k]);
        }
    }

    /// Diagonal entries of U, with the sign of each row exchange; the determinant is their product.
    pub fn pivots(&self) -> impl Iterator<Item = T> + '_ {
        let diagonal = self.upper.iter().step_by(2 * self.reach + 1);
        diagonal.zip(&self.pivots).map(|(value, exchange)| if *exchange == 0 { *value } else { -*value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Entry of a test matrix without symmetry; `turn` makes it complex.
    fn entry(i: usize, j: usize) -> f64 {
        ((7 * i + 3 * j) as f64).sin() + if i == j { 0.1 } else { 0.0 }
    }

    fn check<T: Number>(size: usize, reach: usize, turn: T) -> Result<(), Singular> {
        let mut band = Band::<T>::zeros(size, reach);
        let mut dense = DMatrix::<T>::zeros(size, size);
        for i in 0..size {
            for j in i.saturating_sub(reach)..size.min(i + reach + 1) {
                let value = T::from_real(entry(i, j)) + turn * T::from_real(entry(j, i));
                band.add(i, j, value);
                dense[(i, j)] = value;
            }
        }
        let factors = band.clone().factor()?;
        let right: Vec<T> = (0..size).map(|i| T::from_real(i as f64 - 2.0)).collect();
        let mut x = right.clone();
        factors.solve(&mut x);
        for i in 0..size {
            let product = (0..size).map(|j| dense[(i, j)] * x[j]).fold(T::zero(), |sum, term| sum + term);
            assert!((product - right[i]).modulus() < 1e-12 * size as f64);
        }
        let mut y = right.clone();
        factors.solve_transposed(&mut y);
        for i in 0..size {
            let product = (0..size).map(|j| dense[(j, i)] * y[j]).fold(T::zero(), |sum, term| sum + term);
            assert!((product - right[i]).modulus() < 1e-12 * size as f64);
        }
        for from in 0..size {
            let mut complete: Vec<T> = (0..size).map(|i| if i < from { T::zero() } else { right[i] }).collect();
            let mut part = complete.clone();
            factors.solve(&mut complete);
            factors.solve_part(&mut part, from, from / 2);
            assert_eq!(part[from / 2..], complete[from / 2..]);
        }
        let determinant = factors.pivots().fold(T::one(), |product, pivot| product * pivot);
        let expected = dense.determinant();
        assert!((determinant - expected).modulus() < 1e-12 * expected.modulus());
        Ok(())
    }

    #[test]
    fn real_and_complex_systems_of_every_small_size_are_solved() -> Result<(), Singular> {
        for size in 1..12 {
            for reach in [0, 1, 3, 6] {
                check(size, reach, 0.0)?;
                check(size, reach, Complex::<f64>::i())?;
            }
        }
        Ok(())
    }

    #[test]
    fn a_zero_pivot_is_exchanged_and_a_singular_matrix_is_refused() -> Result<(), Singular> {
        let mut band = Band::<f64>::zeros(2, 1);
        band.add(0, 1, 2.0);
        band.add(1, 0, 3.0);
        let mut x = [4.0, 9.0];
        band.clone().factor()?.solve(&mut x);
        assert_eq!(x, [3.0, 2.0]);
        band.add(1, 0, -3.0);
        assert!(band.clone().factor().is_err());
        band.add(1, 0, f64::NAN);
        assert!(band.factor().is_err());
        Ok(())
    }
}
