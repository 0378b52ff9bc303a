//! Generalized conjugate residuals (Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20, 1983) for an operator close to the
//! identity.

use nalgebra::DVector;
use num_complex::Complex64;

/// Largest number of products with the operator.
const MAX_PRODUCTS: usize = 60;

/// A direction d of the search with its image A d, which has unit length, and W A d.
struct Direction {
    vector: DVector<Complex64>,
    image: DVector<Complex64>,
    weighted: DVector<Complex64>,
}

/// Solves A x = b up to a residual of `rtol`·‖b‖ in the norm √(xᴴWx), where `weigh` gives W x. Second: the number of products
/// with A. `None` if the residual is larger after 60 products.
///
/// # Errors
/// That of `apply`, which gives A x.
pub fn conjugate_residuals<E>(
    b: &DVector<Complex64>,
    rtol: f64,
    mut apply: impl FnMut(&DVector<Complex64>) -> Result<DVector<Complex64>, E>,
    weigh: impl Fn(&DVector<Complex64>) -> DVector<Complex64>,
) -> Result<Option<(DVector<Complex64>, usize)>, E> {
    // `f64::max` would replace NaN by zero; `clamp` returns NaN.
    let norm = |x: &DVector<Complex64>| x.dotc(&weigh(x)).re.clamp(0.0, f64::INFINITY).sqrt();
    let size = norm(b);
    let (mut x, mut residual) = (DVector::zeros(b.len()), b.clone());
    let mut known: Vec<Direction> = Vec::new();
    while norm(&residual) > rtol * size {
        if known.len() == MAX_PRODUCTS {
            return Ok(None);
        }
        let (mut vector, mut image) = (residual.clone(), apply(&residual)?);
        for other in &known {
            let part = other.weighted.dotc(&image);
            vector.axpy(-part, &other.vector, Complex64::ONE);
            image.axpy(-part, &other.image, Complex64::ONE);
        }
        let mut weighted = weigh(&image);
        let length = image.dotc(&weighted).re.max(0.0).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Ok(None);
        }
        [&mut vector, &mut image, &mut weighted].into_iter().for_each(|x| *x /= Complex64::from(length));
        let step = weighted.dotc(&residual);
        x.axpy(step, &vector, Complex64::ONE);
        residual.axpy(-step, &image, Complex64::ONE);
        known.push(Direction { vector, image, weighted });
    }
    // A norm that is not a number leaves the loop.
    Ok(size.is_finite().then_some((x, known.len())))
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

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
        let (x, products) = found.ok().flatten().unwrap_or_default();
        assert!((&a * x - &b).norm() < 1e-10 * b.norm());
        assert!((3..=8).contains(&products), "{products} products");
    }

    #[test]
    fn a_singular_system_has_no_solution() {
        let b = DVector::from_element(8, Complex64::ONE);
        let apply = |x: &DVector<Complex64>| Ok::<_, ()>(DVector::from_element(8, x[0] - x[0]));
        assert_eq!(conjugate_residuals(&b, 1e-12, apply, DVector::clone), Ok(None));
        let invalid = DVector::from_element(8, Complex64::from(f64::NAN));
        assert_eq!(conjugate_residuals(&invalid, 1e-12, apply, DVector::clone), Ok(None));
    }
}
