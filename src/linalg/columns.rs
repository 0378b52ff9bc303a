//! Products with the columns of a tall matrix, one after the other in memory.
//!
//! Sums run over fixed lanes in plain arithmetic, so that results do not depend on the instruction set. `pulp` selects the
//! instruction set at run time, and the compiler vectorises the loops for it.

use pulp::Arch;

use super::sparse_lu::Number;

/// Number of numbers that SIMD loops handle together.
pub const LANES: usize = 8;

/// Columns that share one pass over the vector.
const COLUMNS_PER_PASS: usize = 4;

/// Vᴴx for the columns V of x.len() entries each.
pub fn products<T: Number>(columns: &[T], x: &[T]) -> Vec<T> {
    let size = x.len().max(1);
    let mut out = Vec::with_capacity(columns.len() / size);
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let together = columns.chunks_exact(COLUMNS_PER_PASS * size);
            let rest = together.remainder();
            for columns in together {
                out.extend(products_of::<T, COLUMNS_PER_PASS>(columns, x));
            }
            for column in rest.chunks_exact(size) {
                out.extend(products_of::<T, 1>(column, x));
            }
        },
    );
    out
}

#[inline(always)]
fn products_of<T: Number, const N: usize>(columns: &[T], x: &[T]) -> [T; N] {
    let mut sums = [[T::zero(); LANES]; N];
    let (whole, last) = x.as_chunks::<LANES>();
    let columns: [&[T]; N] = std::array::from_fn(|k| &columns[k * x.len()..(k + 1) * x.len()]);
    let chunks: [&[[T; LANES]]; N] = columns.map(|column| &column.as_chunks::<LANES>().0[..whole.len()]);
    for (i, x) in whole.iter().enumerate() {
        for (sums, column) in sums.iter_mut().zip(chunks) {
            for ((sum, value), x) in sums.iter_mut().zip(column[i]).zip(x) {
                *sum += value.conjugate() * *x;
            }
        }
    }
    let start = x.len() - last.len();
    std::array::from_fn(|k| {
        let tail = columns[k][start..].iter().zip(last);
        let rest = tail.fold(T::zero(), |sum, (value, x)| sum + value.conjugate() * *x);
        sums[k].iter().fold(rest, |sum, part| sum + *part)
    })
}

/// `x += Σ weights[k] V_k` for the columns V of `size` entries each, of which the first x.len() are read.
pub fn add_combination<T: Number>(columns: &[T], size: usize, weights: &[T], x: &mut [T]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let (fours, rest) = weights.as_chunks::<COLUMNS_PER_PASS>();
            let count = x.len();
            let mut columns = columns.chunks_exact(size.max(1)).map(|column| &column[..count]);
            for weights in fours {
                if let [Some(a), Some(b), Some(c), Some(d)] = std::array::from_fn(|_| columns.next()) {
                    for ((((x, a), b), c), d) in x.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                        *x += (weights[0] * *a + weights[1] * *b) + (weights[2] * *c + weights[3] * *d);
                    }
                }
            }
            for (weight, column) in rest.iter().zip(columns) {
                x.iter_mut().zip(column).for_each(|(x, value)| *x += *weight * *value);
            }
        },
    );
}

/// The first `count` entries of the sum of the columns V_k with their weights.
pub fn combination<T: Number>(columns: &[T], size: usize, weights: &[T], count: usize) -> Vec<T> {
    let mut sum = vec![T::zero(); count];
    add_combination(columns, size, weights, &mut sum);
    sum
}

/// Scalar product, summed in lanes because one sum would wait for each addition.
#[inline(always)]
pub fn product(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    fn check<T: Number>(turn: T) {
        let entry = |i: usize| T::from_real((i as f64).sin()) + turn * T::from_real((3.0 * i as f64).cos());
        for size in [1, 7, 8, 21] {
            for count in [0, 1, 4, 6] {
                let columns: Vec<T> = (0..size * count).map(entry).collect();
                let x: Vec<T> = (0..size).map(|i| entry(i + 5)).collect();
                let found = products(&columns, &x);
                assert_eq!(found.len(), count);
                let mut sum = x[..size / 2].to_vec();
                add_combination(&columns, size, &found, &mut sum);
                for (k, column) in columns.chunks_exact(size).enumerate() {
                    let expected = column.iter().zip(&x).fold(T::zero(), |sum, (v, x)| sum + v.conjugate() * *x);
                    assert!((expected - found[k]).modulus() < 1e-13);
                }
                for (i, sum) in sum.iter().enumerate() {
                    let expected = (0..count).fold(x[i], |sum, k| sum + found[k] * columns[k * size + i]);
                    assert!((expected - *sum).modulus() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn products_and_combinations_of_real_and_complex_columns_are_those_of_their_entries() {
        check(0.0);
        check(Complex::<f64>::i());
    }
}
