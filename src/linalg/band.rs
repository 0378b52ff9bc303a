//! Band matrices, in which the matrices of a chain are added up, and their LU factors without row exchanges.

use std::ops::Range;

use pulp::Arch;

use super::sparse_lu::{Number, Singular};

/// A band matrix; row i stores the columns from i − L to i + L.
#[derive(Clone, Debug)]
pub struct Band<T> {
    /// L.
    reach: usize,
    /// Number of rows.
    size: usize,
    /// Entries row by row, 2L + 1 for each row.
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
        let first = 2 * self.reach * row + self.reach + columns.start;
        let entries = &self.entries[first..first + columns.len()];
        (columns, entries)
    }

    /// LU factors of a positive definite matrix, whose pivots are positive.
    ///
    /// # Errors
    /// [`Singular`] if a pivot is zero or not finite.
    pub fn factor(mut self) -> Result<BandLu<T>, Singular> {
        let mut inverse = Vec::with_capacity(self.size);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for k in 0..self.size {
                    let (width, count) = (2 * self.reach + 1, self.reach.min(self.size - k - 1));
                    let (done, rest) = self.entries.split_at_mut((k + 1) * width);
                    let top = &done[k * width + self.reach..][..=count];
                    if top[0].is_zero() || !top[0].is_finite() {
                        return Err(Singular);
                    }
                    let reciprocal = top[0].recip();
                    inverse.push(reciprocal);
                    for (below, entries) in rest.chunks_exact_mut(width).take(count).enumerate() {
                        let entries = &mut entries[self.reach - 1 - below..][..=count];
                        let factor = entries[0] * reciprocal;
                        entries[0] = factor;
                        entries[1..].iter_mut().zip(&top[1..]).for_each(|(entry, above)| *entry -= factor * *above);
                    }
                }
                Ok(())
            },
        )?;
        Ok(BandLu { factors: self, inverse })
    }
}

/// LU factors of a [`Band`].
#[derive(Clone, Debug)]
pub struct BandLu<T> {
    /// L without the diagonal of ones, and U.
    factors: Band<T>,
    /// Inverses of the diagonal entries of U.
    inverse: Vec<T>,
}

impl<T: Number> BandLu<T> {
    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&self, x: &mut [T]) {
        for row in 0..x.len() {
            let (columns, entries) = self.factors.row(row);
            let before = columns.start..row;
            let terms = x[before].iter().zip(entries).map(|(x, factor)| *factor * *x);
            x[row] = terms.fold(x[row], |sum, term| sum - term);
        }
        for row in (0..x.len()).rev() {
            let (columns, entries) = self.factors.row(row);
            let after = row + 1..columns.end;
            let terms = x[after].iter().zip(&entries[row + 1 - columns.start..]).map(|(x, factor)| *factor * *x);
            x[row] = terms.fold(x[row], |sum, term| sum - term) * self.inverse[row];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn positive_definite_systems_of_every_small_size_are_solved() -> Result<(), Singular> {
        for size in 1..12 {
            for reach in [0, 1, 3, 6] {
                let mut band = Band::zeros(size, reach);
                let mut dense = DMatrix::zeros(size, size);
                for i in 0..size {
                    for j in i.saturating_sub(reach)..size.min(i + reach + 1) {
                        let value = ((7 * i * j + 3 * (i + j)) as f64).sin() + if i == j { 8.0 } else { 0.0 };
                        band.add(i, j, value);
                        dense[(i, j)] = value;
                    }
                }
                let right = DVector::from_fn(size, |i, _| i as f64 - 2.0);
                let mut x = right.clone();
                band.factor()?.solve(x.as_mut_slice());
                assert!((dense * x - right).norm() < 1e-13 * size as f64);
            }
        }
        assert!(Band::<f64>::zeros(2, 1).factor().is_err());
        Ok(())
    }
}
