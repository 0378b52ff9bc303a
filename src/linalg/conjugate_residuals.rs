//! Generalized conjugate residuals (Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20, 1983) for an operator close to the
//! identity. The residuals are those of GMRES (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 1986).

use nalgebra::DVector;

use super::sparse_lu::Number;

/// Largest number of products with the operator.
const MAX_PRODUCTS: usize = 80;

/// A direction d of the search with its image A d, which has unit length, and W A d.
struct Direction<T> {
    vector: DVector<T>,
    image: DVector<T>,
    weighted: DVector<T>,
}

/// The vector with the smallest residual that a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastResidual<T: Number> {
    /// The vector.
    pub x: DVector<T>,
    /// Number of products with the operator.
    pub products: usize,
    /// Whether its residual is as small as asked.
    pub is_converged: bool,
}

/// Solves A x = b up to a residual of `rtol`·‖b‖ in the norm √(xᴴWx), where `weigh` gives W x, with at most `MAX_PRODUCTS` products.
///
/// # Errors
/// That of `apply`, which gives A x.
pub fn conjugate_residuals<T: Number, E>(
    b: &DVector<T>,
    rtol: f64,
    mut apply: impl FnMut(&DVector<T>) -> Result<DVector<T>, E>,
    weigh: impl Fn(&DVector<T>) -> DVector<T>,
) -> Result<LeastResidual<T>, E> {
    // `f64::max` would replace NaN by zero; `clamp` returns NaN.
    let norm = |x: &DVector<T>| x.dotc(&weigh(x)).real().clamp(0.0, f64::INFINITY).sqrt();
    let size = norm(b);
    let (mut x, mut residual) = (DVector::zeros(b.len()), b.clone());
    let mut known: Vec<Direction<T>> = Vec::new();
    while norm(&residual) > rtol * size && known.len() < MAX_PRODUCTS {
        let (mut vector, mut image) = (residual.clone(), apply(&residual)?);
        for other in &known {
            let part = other.weighted.dotc(&image);
            vector.axpy(-part, &other.vector, T::one());
            image.axpy(-part, &other.image, T::one());
        }
        let mut weighted = weigh(&image);
        let length = image.dotc(&weighted).real().max(0.0).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            break;
        }
        [&mut vector, &mut image, &mut weighted].into_iter().for_each(|x| x.unscale_mut(length));
        let step = weighted.dotc(&residual);
        x.axpy(step, &vector, T::one());
        residual.axpy(-step, &image, T::one());
        known.push(Direction { vector, image, weighted });
    }
    // A norm that is not a number leaves the loop.
    let is_converged = size.is_finite() && norm(&residual) <= rtol * size;
    Ok(LeastResidual { x, products: known.len(), is_converged })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Complex, DMatrix};

    type Complex64 = Complex<f64>;

    use super::*;

    fn close_to_identity(distance: f64) -> DMatrix<Complex64> {
        DMatrix::from_fn(8, 8, |i, j| {
            let entry = Complex64::new(((i + 3 * j) as f64).sin(), ((2 * i + j) as f64).cos()) * (distance / 8.0);
            if i == j { 1.0 + entry } else { entry }
        })
    }

    #[test]
    fn a_system_is_solved_in_few_products() {
        let a = close_to_identity(0.05);
        let b = DVector::from_fn(8, |i, _| Complex64::new(1.0 + i as f64, -0.5));
        let weigh = |x: &DVector<Complex64>| DVector::from_fn(8, |i, _| x[i] * 10.0_f64.powi(i as i32));
        let found = conjugate_residuals(&b, 1e-12, |x| Ok::<_, ()>(&a * x), weigh);
        let LeastResidual { x, products, is_converged } = found.unwrap_or_else(|()| unreachable!());
        assert!(is_converged && (&a * x - &b).norm() < 1e-10 * b.norm());
        assert!((3..=8).contains(&products), "{products} products");
    }

    #[test]
    fn a_singular_system_has_no_solution() {
        let b = DVector::from_element(8, Complex64::ONE);
        let apply = |x: &DVector<Complex64>| Ok::<_, ()>(DVector::from_element(8, x[0] - x[0]));
        let is_converged = |b| conjugate_residuals(b, 1e-12, apply, DVector::clone).map(|found| found.is_converged);
        assert_eq!(is_converged(&b), Ok(false));
        let invalid = DVector::from_element(8, Complex64::from(f64::NAN));
        assert_eq!(is_converged(&invalid), Ok(false));
    }

    #[test]
    fn a_real_system_is_solved() {
        let a = DMatrix::from_fn(6, 6, |i, j| if i == j { 2.0 } else { ((i + 3 * j) as f64).sin() / 3.0 });
        let b = DVector::from_fn(6, |i, _| 1.0 + i as f64);
        let found = conjugate_residuals(&b, 1e-13, |x| Ok::<_, ()>(&a * x), DVector::clone);
        assert!(found.is_ok_and(|found| (&a * found.x - &b).norm() < 1e-11));
    }
}
