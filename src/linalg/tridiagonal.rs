//! The largest eigenvalue of a symmetric tridiagonal matrix and its vector, in time proportional to the number of rows.
//!
//! The number of negative pivots of T − xI is the number of eigenvalues below x (Sylvester's law of inertia; Golub and Van
//! Loan, Matrix Computations, 4th ed., section 8.4). Bisection with this count finds the largest one, inverse iteration its
//! vector.

use super::sparse_lu::{Pivots, SparseColumns, SparseLu};
use crate::numerics::SUM_ROUND_OFF;

/// Largest number of bisections: each halves an interval of doubles.
const MAX_BISECTIONS: usize = 128;
/// Number of inverse iterations. One is enough unless the start vector has almost no part in the eigenvector.
const INVERSE_ITERATIONS: usize = 3;

/// Largest eigenvalue of the matrix with the diagonal entries `diagonal`, m of them, and `beside` next to them, m − 1.
pub fn largest_eigenvalue(diagonal: &[f64], beside: &[f64]) -> f64 {
    let reach = |row: usize| {
        let side = |index: Option<usize>| index.and_then(|index| beside.get(index)).map_or(0.0, |value| value.abs());
        side(row.checked_sub(1)) + side(Some(row))
    };
    // Gershgorin's circles contain the eigenvalue; no diagonal entry is larger.
    let mut low = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut high = diagonal.iter().enumerate().map(|(row, value)| value + reach(row)).fold(low, f64::max);
    for _ in 0..MAX_BISECTIONS {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if is_bound(diagonal, beside, middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Whether every eigenvalue is below `x`: every pivot of T − xI is negative.
fn is_bound(diagonal: &[f64], beside: &[f64], x: f64) -> bool {
    let mut pivot = f64::NEG_INFINITY;
    let before = std::iter::once(0.0).chain(beside.iter().copied());
    diagonal.iter().zip(before).all(|(value, before)| {
        pivot = value - x - before * before / pivot;
        pivot < 0.0
    })
}

/// Eigenvector of unit length of the eigenvalue `value`, m entries.
pub fn eigenvector(diagonal: &[f64], beside: &[f64], value: f64) -> Vec<f64> {
    let size = diagonal.len();
    let own = || diagonal.iter().enumerate().map(|(row, entry)| (row, row, entry - value * (1.0 + SUM_ROUND_OFF)));
    let pairs = || beside.iter().enumerate().take(size.saturating_sub(1));
    let sides = || pairs().flat_map(|(row, entry)| [(row, row + 1, *entry), (row + 1, row, *entry)]);
    let shifted = SparseColumns::new(size, || own().chain(sides()));
    let mut vector = vec![1.0; size];
    if let Ok(factors) = SparseLu::new(&shifted, (0..size).collect(), Pivots::Threshold) {
        for _ in 0..INVERSE_ITERATIONS {
            factors.solve(&mut vector);
            let length = vector.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|entry| *entry /= length);
        }
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_eigenpair_of_a_chain_of_springs_is_found() {
        for size in [1, 2, 3, 10, 200] {
            let (diagonal, beside) = (vec![2.0; size], vec![-1.0; size - 1]);
            let angle = std::f64::consts::PI * size as f64 / (size + 1) as f64;
            let expected = 2.0 - 2.0 * angle.cos();
            let value = largest_eigenvalue(&diagonal, &beside);
            assert!((value - expected).abs() <= 8.0 * f64::EPSILON * expected, "{size}: {value} {expected}");
            let vector = eigenvector(&diagonal, &beside, value);
            for row in 0..size {
                let next = |index: Option<usize>| index.and_then(|index| vector.get(index)).copied().unwrap_or(0.0);
                let image = 2.0 * vector[row] - next(row.checked_sub(1)) - next(Some(row + 1));
                assert!((image - value * vector[row]).abs() < 1e-14, "{size}");
            }
            assert!((vector.iter().map(|entry| entry * entry).sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn uncoupled_rows_have_the_largest_diagonal_entry() {
        let (diagonal, beside) = ([1.0, 5.0, -3.0], [0.0, 0.0]);
        assert_eq!(largest_eigenvalue(&diagonal, &beside), 5.0);
        let vector = eigenvector(&diagonal, &beside, 5.0);
        assert!((vector[1].abs() - 1.0).abs() < 1e-15 && vector[0].abs() < 1e-14);
    }
}
