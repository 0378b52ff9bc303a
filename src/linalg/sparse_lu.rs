//! LU factors of a sparse matrix, column by column, with row exchanges where the diagonal is small.
//!
//! A column of L and U follows from the columns before it: a search in the graph of L finds the entries that are not zero, a
//! sparse triangular solution their values (Gilbert and Peierls, SIAM J. Sci. Stat. Comput. 9, 1988), so that time is proportional
//! to the number of multiplications. The search leaves out edges that others imply (symmetric pruning; Eisenstat and Liu, SIAM
//! J. Matrix Anal. Appl. 13, 1992). The order of the columns keeps the number of entries small ([`super::minimum_degree`]). The pivot is
//! the entry on the diagonal unless it is far below the largest one (threshold pivoting, as in KLU; Davis and Palamadai Natarajan,
//! ACM Trans. Math. Softw. 37, 2010); entries are compared relative to the largest one of their row in the matrix, so that units
//! do not matter.

use std::ops::Range;

use nalgebra::{Complex, ComplexField};
use thiserror::Error;

use crate::numerics::ROUND_OFF;

/// Error: a matrix has no LU factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the matrix is singular")]
pub struct Singular;

/// Real or complex numbers in double precision.
pub trait Number: ComplexField<RealField = f64> + Copy {}

impl<T: ComplexField<RealField = f64> + Copy> Number for T {}

/// Least size of a pivot on the diagonal over that of the largest entry of its column (as in KLU). Exchanges destroy the order of the
/// columns; refinement gives back the accuracy that small pivots cost.
const LEAST_PIVOT: f64 = 1e-3;
/// Mark of a row that is no pivot yet, and of one that no search has reached.
const NONE: u32 = u32::MAX;

/// An entry of a column.
#[derive(Clone, Copy, Debug)]
pub struct Entry<T> {
    /// Row, or number of a pivot.
    pub row: u32,
    pub value: T,
}

/// Sparse columns, one after the other.
#[derive(Clone, Debug)]
pub struct SparseColumns<T> {
    /// First entry of each column, and the number of entries.
    starts: Vec<usize>,
    entries: Vec<Entry<T>>,
}

impl<T: Number> SparseColumns<T> {
    fn with_capacity(columns: usize, entries: usize) -> Self {
        let mut starts = Vec::with_capacity(columns + 1);
        starts.push(0);
        Self { starts, entries: Vec::with_capacity(entries) }
    }

    /// A square matrix from entries (row, column, value); those of one place add up.
    pub fn new<I: Iterator<Item = (usize, usize, T)>>(size: usize, entries: impl Fn() -> I) -> Self {
        let mut starts = vec![0; size + 2];
        entries().for_each(|(_, column, _)| starts[column + 2] += 1);
        for column in 2..size + 2 {
            starts[column] += starts[column - 1];
        }
        let mut sorted = vec![Entry { row: 0, value: T::zero() }; starts[size + 1]];
        entries().for_each(|(row, column, value)| {
            let place = &mut starts[column + 1];
            sorted[*place] = Entry { row: row as u32, value };
            *place += 1;
        });
        starts.pop();
        Self { starts, entries: sorted }
    }

    /// Number of columns.
    pub fn size(&self) -> usize {
        self.starts.len() - 1
    }

    /// Entries of a column.
    #[inline(always)]
    pub fn column(&self, column: usize) -> &[Entry<T>] {
        &self.entries[self.starts[column]..self.starts[column + 1]]
    }

    /// Ends a column whose entries are appended.
    fn finish_column(&mut self) {
        self.starts.push(self.entries.len());
    }
}

impl SparseColumns<Complex<f64>> {
    /// The same matrix with real numbers, if every entry is real but for round-off.
    pub fn real(&self) -> Option<SparseColumns<f64>> {
        let real = |Entry { row, value }: &Entry<Complex<f64>>| {
            (value.im.abs() <= ROUND_OFF * value.re.abs()).then_some(Entry { row: *row, value: value.re })
        };
        let entries = self.entries.iter().map(real).collect::<Option<_>>()?;
        Some(SparseColumns { starts: self.starts.clone(), entries })
    }
}

/// Where pivots are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pivots {
    /// On the diagonal where they are large enough.
    Threshold,
    /// On the diagonal, for the inertia of a Hermitian matrix.
    Diagonal,
}

/// LU factors.
#[derive(Clone, Debug)]
pub struct SparseLu<T> {
    /// Column of the matrix of each pivot.
    columns: Vec<usize>,
    /// Row of the matrix of each pivot.
    rows: Vec<usize>,
    /// Columns of L without the diagonal of ones, over the rows of the matrix.
    lower: SparseColumns<T>,
    /// Columns of U without the diagonal, over the pivots.
    upper: SparseColumns<T>,
    pivots: Vec<T>,
    inverse: Vec<T>,
}

impl<T: Number> SparseLu<T> {
    /// Factors of a matrix whose columns are eliminated in the order `order`.
    ///
    /// # Errors
    /// [`Singular`] if a column has no pivot, or one that is not finite.
    pub fn new(matrix: &SparseColumns<T>, order: Vec<usize>, pivoting: Pivots) -> Result<Self, Singular> {
        let size = matrix.size();
        let mut scale = vec![0.0_f64; size];
        for Entry { row, value } in &matrix.entries {
            scale[*row as usize] = scale[*row as usize].max(value.norm1());
        }
        scale.iter_mut().for_each(|scale| *scale = scale.recip());
        // Without fill, each factor has half of the entries.
        let half = matrix.entries.len() / 2 + size;
        let mut lower = SparseColumns::with_capacity(size, half);
        let mut upper = SparseColumns::with_capacity(size, half);
        let (mut rows, mut pivots, mut inverse) =
            (Vec::with_capacity(size), Vec::with_capacity(size), Vec::with_capacity(size));
        // Number of the pivot in each row, and the last column whose search reached the row.
        let (mut pivot_of, mut reached_by) = (vec![NONE; size], vec![NONE; size]);
        let mut work = vec![T::zero(); size];
        // End of the entries of each column of L that searches follow.
        let mut ends: Vec<usize> = Vec::with_capacity(size);
        // Pivots before this column on which it depends, and rows that can be its pivot.
        let (mut before, mut below) = (Vec::<u32>::new(), Vec::<u32>::new());
        for (k, column) in order.iter().enumerate() {
            before.clear();
            below.clear();
            let mut reach = |row: u32, before: &mut Vec<u32>| {
                if reached_by[row as usize] != k as u32 {
                    reached_by[row as usize] = k as u32;
                    match pivot_of[row as usize] {
                        NONE => below.push(row),
                        pivot => before.push(pivot),
                    }
                }
            };
            for Entry { row, value } in matrix.column(*column) {
                work[*row as usize] += *value;
                reach(*row, &mut before);
            }
            let mut next = 0;
            while let Some(pivot) = before.get(next).map(|pivot| *pivot as usize) {
                lower.entries[lower.starts[pivot]..ends[pivot]]
                    .iter()
                    .for_each(|entry: &Entry<T>| reach(entry.row, &mut before));
                next += 1;
            }
            before.sort_unstable();
            for pivot in &before {
                let value: T = std::mem::replace(&mut work[rows[*pivot as usize]], T::zero());
                upper.entries.push(Entry { row: *pivot, value });
                for entry in lower.column(*pivot as usize) {
                    work[entry.row as usize] -= entry.value * value;
                }
            }
            upper.finish_column();
            let size_of = |row: usize, work: &[T]| work[row].norm1() * scale[row];
            let mut row = *column;
            if pivoting == Pivots::Threshold {
                let (mut largest, mut most) = (row, 0.0);
                for candidate in &below {
                    let size = size_of(*candidate as usize, &work);
                    if size > most {
                        (largest, most) = (*candidate as usize, size);
                    }
                }
                if pivot_of[row] != NONE || size_of(row, &work) < LEAST_PIVOT * most {
                    row = largest;
                }
            }
            let pivot = work[row];
            if pivot.is_zero() || !pivot.is_finite() || pivot_of[row] != NONE {
                return Err(Singular);
            }
            let reciprocal = pivot.recip();
            for candidate in &below {
                let value = std::mem::replace(&mut work[*candidate as usize], T::zero());
                if *candidate as usize != row {
                    lower.entries.push(Entry { row: *candidate, value: value * reciprocal });
                }
            }
            lower.finish_column();
            pivot_of[row] = k as u32;
            rows.push(row);
            pivots.push(pivot);
            inverse.push(reciprocal);
            ends.push(lower.entries.len());
            // A later search that reaches a column with an entry in this row, and in whose row this column has one, finds the other
            // rows of it through this column.
            for earlier in before.iter().map(|pivot| *pivot as usize) {
                let entries: Range<usize> = lower.starts[earlier]..lower.starts[earlier + 1];
                let own = &mut lower.entries[entries.clone()];
                if ends[earlier] == entries.end && own.iter().any(|entry| entry.row as usize == row) {
                    let mut count = 0;
                    for index in 0..own.len() {
                        if pivot_of[own[index].row as usize] != NONE {
                            own.swap(index, count);
                            count += 1;
                        }
                    }
                    ends[earlier] = entries.start + count;
                }
            }
        }
        Ok(Self { columns: order, rows, lower, upper, pivots, inverse })
    }

    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&self, x: &mut [T]) {
        let mut y = Vec::with_capacity(x.len());
        for (k, row) in self.rows.iter().enumerate() {
            let value = x[*row];
            for entry in self.lower.column(k) {
                x[entry.row as usize] -= entry.value * value;
            }
            y.push(value);
        }
        for (k, column) in self.columns.iter().enumerate().rev() {
            let value = y[k] * self.inverse[k];
            for entry in self.upper.column(k) {
                y[entry.row as usize] -= entry.value * value;
            }
            x[*column] = value;
        }
    }

    /// Replaces the right-hand side `x` by the solution with the transposed matrix.
    pub fn solve_transposed(&self, x: &mut [T]) {
        let mut y: Vec<T> = Vec::with_capacity(x.len());
        for (k, column) in self.columns.iter().enumerate() {
            let terms = self.upper.column(k).iter().map(|entry| entry.value * y[entry.row as usize]);
            y.push(terms.fold(x[*column], |sum, term| sum - term) * self.inverse[k]);
        }
        for (k, row) in self.rows.iter().enumerate().rev() {
            let terms = self.lower.column(k).iter().map(|entry| entry.value * x[entry.row as usize]);
            x[*row] = terms.fold(y[k], |sum, term| sum - term);
        }
    }

    /// Number of entries of both factors without the pivots.
    #[cfg(test)]
    pub fn entries(&self) -> usize {
        self.lower.entries.len() + self.upper.entries.len()
    }

    /// Pivots, of which the product is the determinant but for the sign of [`Self::is_odd`].
    pub fn pivots(&self) -> &[T] {
        &self.pivots
    }

    /// Whether the rows of the pivots are an odd permutation of their columns.
    pub fn is_odd(&self) -> bool {
        let mut row_of = vec![0; self.rows.len()];
        self.columns.iter().zip(&self.rows).for_each(|(column, row)| row_of[*column] = *row);
        let mut is_odd = false;
        for start in 0..row_of.len() {
            while row_of[start] != start {
                let next = row_of[start];
                row_of.swap(start, next);
                is_odd = !is_odd;
            }
        }
        is_odd
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::minimum_degree::minimum_degree;
    use nalgebra::{DMatrix, DVector};

    /// Entries of a matrix without symmetry, of which a row holds about four; `seed` varies it. Some entries are on the diagonal.
    fn entries(size: usize, seed: usize) -> Vec<(usize, usize, f64)> {
        let mut state = seed as u64 + 1;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        let mut found: Vec<_> = (0..size).map(|i| (i, (i + 1) % size, 0.5 + number())).collect();
        for _ in 0..3 * size {
            let place = [number(), number()].map(|part| (part * size as f64) as usize);
            found.push((place[0], place[1], number() - 0.5));
        }
        found
    }

    fn of<T: Number>(size: usize, entries: &[(usize, usize, T)]) -> SparseColumns<T> {
        SparseColumns::new(size, || entries.iter().copied())
    }

    fn order(size: usize, places: &[(usize, usize, f64)]) -> Vec<usize> {
        minimum_degree(size, &places.iter().map(|(row, column, _)| (*row, *column)).collect::<Vec<_>>())
    }

    fn check<T: Number>(size: usize, seed: usize, turn: T) -> Result<(), Singular> {
        let places = entries(size, seed);
        let entries: Vec<_> = places
            .iter()
            .map(|(row, column, value)| (*row, *column, T::from_real(*value) + turn * T::from_real(value * value)))
            .collect();
        let mut dense = DMatrix::<T>::zeros(size, size);
        entries.iter().for_each(|(row, column, value)| dense[(*row, *column)] += *value);
        let factors = SparseLu::new(&of(size, &entries), order(size, &places), Pivots::Threshold)?;
        let right = DVector::from_fn(size, |i, _| T::from_real(i as f64 - 2.0));
        let size_of = |x: &DVector<T>| 1e-10 * (right.norm() + dense.norm() * x.norm());
        let mut x = right.clone();
        factors.solve(x.as_mut_slice());
        assert!((&dense * &x - &right).norm() < size_of(&x), "{size} {seed}");
        let mut x = right.clone();
        factors.solve_transposed(x.as_mut_slice());
        assert!((dense.transpose() * &x - &right).norm() < size_of(&x), "{size} {seed}");
        let mut product = factors.pivots().iter().fold(T::one(), |product, pivot| product * *pivot);
        if factors.is_odd() {
            product = -product;
        }
        let expected = dense.determinant();
        assert!((product - expected).modulus() < 1e-9 * expected.modulus(), "{size} {seed}: {product} {expected}");
        Ok(())
    }

    #[test]
    fn solutions_and_determinants_are_those_of_the_dense_matrix() -> Result<(), Singular> {
        for size in [1, 2, 3, 5, 8, 13, 40] {
            for seed in 0..20 {
                check(size, seed, 0.0)?;
                check(size, seed, Complex::<f64>::i())?;
            }
        }
        Ok(())
    }

    #[test]
    fn units_of_the_rows_do_not_matter() -> Result<(), Singular> {
        let size = 30;
        let places = entries(size, 3);
        let scaled: Vec<_> = places
            .iter()
            .map(|(row, column, value)| (*row, *column, value * 2.0_f64.powi(7 * (*row as i32 % 9))))
            .collect();
        let factors = [&places, &scaled]
            .map(|entries| SparseLu::new(&of(size, entries), order(size, &places), Pivots::Threshold));
        let [plain, scaled] = factors;
        assert_eq!(plain?.rows, scaled?.rows);
        Ok(())
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        for entries in [
            vec![(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 4.0)],
            vec![(0, 0, 1.0), (0, 1, 1.0)],
            vec![(0, 0, f64::NAN), (1, 1, 1.0)],
            vec![(0, 0, 1.0)],
        ] {
            assert!(SparseLu::new(&of(2, &entries), vec![0, 1], Pivots::Threshold).is_err(), "{entries:?}");
        }
    }

    #[test]
    fn a_tridiagonal_matrix_fills_nothing() -> Result<(), Singular> {
        let size = 50;
        let beside = (1..size).flat_map(|i| [(i, i - 1, -1.0), (i - 1, i, -1.0)]);
        let entries: Vec<_> = (0..size).map(|i| (i, i, 3.0)).chain(beside).collect();
        let factors = SparseLu::new(&of(size, &entries), order(size, &entries), Pivots::Threshold)?;
        assert_eq!([&factors.lower, &factors.upper].map(|part| part.entries.len()), [size - 1; 2]);
        Ok(())
    }
}
