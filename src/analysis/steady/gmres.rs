//! GMRES (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) for an operator that only gives products.

use nalgebra::{DMatrix, DVector};

use super::norm;
use crate::numerics::ROUND_OFF;

/// Largest dimension of the Krylov space.
const MAX_PRODUCTS: usize = 80;

/// Solves A x = b up to a residual of `rtol`·|b|, or the smallest one in the largest space.
///
/// # Errors
/// That of `apply`, which gives A x.
pub fn gmres<E>(b: &[f64], rtol: f64, mut apply: impl FnMut(&[f64]) -> Result<Vec<f64>, E>) -> Result<Vec<f64>, E> {
    let size = norm(b);
    if size == 0.0 {
        return Ok(b.to_vec());
    }
    let mut basis = vec![DVector::from_column_slice(b) / size];
    // Columns of the Hessenberg matrix.
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut weights = DVector::zeros(0);
    while columns.len() < MAX_PRODUCTS.min(b.len()) {
        let mut image = DVector::from_vec(apply(basis[columns.len()].as_slice())?);
        let before = image.norm();
        let mut column = vec![0.0; basis.len()];
        // Twice, because the first time leaves round-off of the removed components.
        for _ in 0..2 {
            for (entry, vector) in column.iter_mut().zip(&basis) {
                let part = vector.dot(&image);
                image.axpy(-part, vector, 1.0);
                *entry += part;
            }
        }
        let rest = image.norm();
        // A product that loses more in the orthogonalization lies in the space.
        let is_complete = rest <= ROUND_OFF * before;
        column.push(if is_complete { 0.0 } else { rest });
        columns.push(column);
        let count = columns.len();
        let hessenberg =
            DMatrix::from_fn(count + 1, count, |row, column| columns[column].get(row).copied().unwrap_or(0.0));
        let mut right = DVector::zeros(count + 1);
        right[0] = size;
        let solution = hessenberg.clone().svd(true, true).solve(&right, f64::EPSILON);
        weights = solution.unwrap_or_else(|_| DVector::zeros(count));
        if is_complete || (right - hessenberg * &weights).norm() <= rtol * size {
            break;
        }
        basis.push(image / rest);
    }
    let mut x = DVector::zeros(b.len());
    for (weight, vector) in weights.iter().zip(&basis) {
        x.axpy(*weight, vector, 1.0);
    }
    Ok(x.as_slice().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dense_system_is_solved() -> Result<(), ()> {
        let a = DMatrix::from_fn(6, 6, |i, j| if i == j { 2.0 } else { ((i + 3 * j) as f64).sin() / 3.0 });
        let b: Vec<f64> = (0..6).map(|i| 1.0 + f64::from(i)).collect();
        let x = gmres(&b, 1e-13, |x| Ok::<_, ()>((&a * DVector::from_column_slice(x)).as_slice().to_vec()))?;
        assert!((&a * DVector::from_vec(x) - DVector::from_vec(b)).norm() < 1e-11);
        Ok(())
    }
}
