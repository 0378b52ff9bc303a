//! Band matrices with `L` subdiagonals and `L` superdiagonals, and their LU factors with partial pivoting.
//!
//! A row stores its `W` = 2L + 1 entries. Row exchanges fill at most `L` more superdiagonals, so the factors need the same
//! `W` entries per row (Golub and Van Loan, Matrix Computations, 4th ed., section 4.3). Factorization and solution take
//! time proportional to the number of rows, and they are backward stable, also for an indefinite matrix. The entries are
//! real or complex.

use nalgebra::ComplexField;
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
pub struct Band<T, const L: usize, const W: usize> {
    rows: Vec<[T; W]>,
}

impl<T: Number, const L: usize, const W: usize> Band<T, L, W> {
    /// Zero matrix with `size` rows.
    pub fn zeros(size: usize) -> Self {
        Self { rows: vec![[T::zero(); W]; size] }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.rows.len()
    }

    /// Whether an entry lies within the band.
    pub fn contains(row: usize, column: usize) -> bool {
        row.abs_diff(column) <= L
    }

    /// Adds `value` to the entry (`row`, `column`), which lies within the band.
    #[inline]
    pub fn add(&mut self, row: usize, column: usize, value: T) {
        self.rows[row][column + L - row] += value;
    }

    /// Calls `visit(row, column, value)` for every entry within the band.
    #[inline]
    pub fn for_each(&self, mut visit: impl FnMut(usize, usize, T)) {
        let size = self.size();
        for (row, entries) in self.rows.iter().enumerate() {
            for column in row.saturating_sub(L)..size.min(row + L + 1) {
                visit(row, column, entries[column + L - row]);
            }
        }
    }

    /// LU factors.
    ///
    /// # Errors
    /// [`Singular`] if a pivot is zero or not finite.
    pub fn factor(&self) -> Result<BandLu<T, L, W>, Singular> {
        let size = self.size();
        let mut upper = self.rows.clone();
        // Every row begins with its first column within the matrix.
        for (row, entries) in upper.iter_mut().enumerate().take(L) {
            entries.rotate_left(L - row);
            entries[W - (L - row)..].fill(T::zero());
        }
        let mut lower = vec![[T::zero(); L]; size];
        let mut pivots = Vec::with_capacity(size);
        for k in 0..size {
            let end = size.min(k + L + 1);
            let mut pivot = k;
            for row in k + 1..end {
                if upper[row][0].norm1() > upper[pivot][0].norm1() {
                    pivot = row;
                }
            }
            let largest = upper[pivot][0].norm1();
            if !(largest > 0.0 && largest.is_finite()) {
                return Err(Singular);
            }
            upper.swap(k, pivot);
            pivots.push(pivot - k);
            let (done, rest) = upper.split_at_mut(k + 1);
            let top = &done[k];
            let inverse = top[0].recip();
            for (entries, multiplier) in rest[..end - k - 1].iter_mut().zip(&mut lower[k]) {
                let factor = entries[0] * inverse;
                *multiplier = factor;
                for j in 1..W {
                    entries[j - 1] = entries[j] - factor * top[j];
                }
                entries[W - 1] = T::zero();
            }
        }
        let inverse = upper.iter().map(|entries| entries[0].recip()).collect();
        Ok(BandLu { upper, inverse, lower, pivots })
    }
}

/// LU factors of a [`Band`].
#[derive(Clone, Debug)]
pub struct BandLu<T, const L: usize, const W: usize> {
    /// Rows of U, each from its diagonal entry on.
    upper: Vec<[T; W]>,
    /// Inverses of the diagonal entries of U.
    inverse: Vec<T>,
    /// Multipliers of the rows below each pivot.
    lower: Vec<[T; L]>,
    /// Distance of the row that was exchanged with each row.
    pivots: Vec<usize>,
}

impl<T: Number, const L: usize, const W: usize> BandLu<T, L, W> {
    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&self, x: &mut [T]) {
        let size = self.upper.len();
        for k in 0..size {
            x.swap(k, k + self.pivots[k]);
            let (done, rest) = x.split_at_mut(k + 1);
            let value = done[k];
            for (entry, factor) in rest.iter_mut().zip(&self.lower[k]) {
                *entry -= *factor * value;
            }
        }
        for k in (0..size).rev() {
            let (head, tail) = x.split_at_mut(k + 1);
            let mut sum = head[k];
            for (entry, factor) in tail.iter().zip(&self.upper[k][1..]) {
                sum -= *factor * *entry;
            }
            head[k] = sum * self.inverse[k];
        }
    }

    /// Diagonal entries of U, with the sign of each row exchange; the determinant is their product.
    pub fn pivots(&self) -> impl Iterator<Item = T> + '_ {
        self.upper.iter().zip(&self.pivots).map(|(row, exchange)| if *exchange == 0 { row[0] } else { -row[0] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Complex, DMatrix};

    /// Entry of a test matrix without symmetry; `turn` makes it complex.
    fn entry(i: usize, j: usize) -> f64 {
        ((7 * i + 3 * j) as f64).sin() + if i == j { 0.1 } else { 0.0 }
    }

    fn check<T: Number, const L: usize, const W: usize>(size: usize, turn: T) {
        let mut band = Band::<T, L, W>::zeros(size);
        let mut dense = DMatrix::<T>::zeros(size, size);
        for i in 0..size {
            for j in i.saturating_sub(L)..size.min(i + L + 1) {
                let value = T::from_real(entry(i, j)) + turn * T::from_real(entry(j, i));
                band.add(i, j, value);
                dense[(i, j)] = value;
            }
        }
        let factors = band.factor().unwrap();
        let right: Vec<T> = (0..size).map(|i| T::from_real(i as f64 - 2.0)).collect();
        let mut x = right.clone();
        factors.solve(&mut x);
        for i in 0..size {
            let product = (0..size).map(|j| dense[(i, j)] * x[j]).fold(T::zero(), |sum, term| sum + term);
            assert!((product - right[i]).modulus() < 1e-12 * size as f64);
        }
        let determinant = factors.pivots().fold(T::one(), |product, pivot| product * pivot);
        let expected = dense.determinant();
        assert!((determinant - expected).modulus() < 1e-12 * expected.modulus());
    }

    #[test]
    fn real_and_complex_systems_of_every_small_size_are_solved() {
        for size in 1..12 {
            check::<f64, 3, 7>(size, 0.0);
            check::<f64, 1, 3>(size, 0.0);
            check::<Complex<f64>, 3, 7>(size, Complex::i());
            check::<Complex<f64>, 1, 3>(size, Complex::i());
        }
    }

    #[test]
    fn a_zero_pivot_is_exchanged_and_a_singular_matrix_is_refused() {
        let mut band = Band::<f64, 1, 3>::zeros(2);
        band.add(0, 1, 2.0);
        band.add(1, 0, 3.0);
        let mut x = [4.0, 9.0];
        band.factor().unwrap().solve(&mut x);
        assert_eq!(x, [3.0, 2.0]);
        band.add(1, 0, -3.0);
        assert!(band.factor().is_err());
        band.add(1, 0, f64::NAN);
        assert!(band.factor().is_err());
    }
}
