//! Number of eigenvalues within a contour that an iteration did not find.
//!
//! The determinant of the dynamic stiffness S(λ) is a polynomial whose zeros are the eigenvalues. By the argument
//! principle, the change of its phase along a closed contour is 2π times the number of zeros inside. Here the determinant is
//! divided by the factors λ − λ_k of the known eigenvalues: what remains has no zero inside if none is missing, and its
//! phase changes slowly. S is real for real λ, so the upper half of a contour that is symmetric to the real axis is enough.

use num_complex::Complex64;

use crate::linalg::Determinant;

/// Largest change of the complex logarithm in one step along the contour.
const MAX_CHANGE: f64 = 0.8;
/// Change below which the next step is longer.
const SMALL_CHANGE: f64 = 0.35;
/// Ratio of the lengths of successive steps.
const GROWTH: f64 = 2.0;
/// Largest number of determinants of one contour.
const MAX_DETERMINANTS: usize = 3000;
/// Largest distance of the change of phase, in half turns, from an integer.
const MAX_FRACTION: f64 = 0.05;

/// Known eigenvalues.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    /// Number of eigenvalues that are zero.
    pub zeros: usize,
    /// Other real eigenvalues, and one of each conjugate pair, rad/s.
    pub values: Vec<Complex64>,
}

/// Rectangle −left < Re λ < right, |Im λ| < top, rad/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub left: f64,
    pub right: f64,
    pub top: f64,
}

/// Phase and logarithm of the magnitude of the determinant at λ without the factors of the known eigenvalues.
fn deflated(determinant: Determinant, known: &Known, at: Complex64) -> Determinant {
    let mut product = Determinant::product(std::iter::empty());
    for value in &known.values {
        let mut factor = at - value;
        if value.im != 0.0 {
            factor *= at - value.conj();
        }
        let size = factor.norm();
        product = Determinant { phase: product.phase * (factor / size), logarithm: product.logarithm + size.ln() };
    }
    let zeros = Complex64::from_polar(1.0, at.arg() * known.zeros as f64);
    Determinant {
        phase: determinant.phase / (product.phase * zeros),
        logarithm: determinant.logarithm - product.logarithm - known.zeros as f64 * at.norm().ln(),
    }
}

/// Number of eigenvalues inside of `contour` that are missing in `known`, negative if a known value is none; `None` if it
/// cannot be determined.
pub(super) fn missing(
    determinant: impl Fn(Complex64) -> Option<Determinant>,
    known: &Known,
    contour: Rectangle,
) -> Option<i64> {
    let Rectangle { left, right, top } = contour;
    let corners = [
        Complex64::new(right, 0.0),
        Complex64::new(right, top),
        Complex64::new(-left, top),
        Complex64::new(-left, 0.0),
    ];
    let value = |at: Complex64| determinant(at).map(|found| deflated(found, known, at));
    let (mut turned, mut count) = (0.0, 0);
    let mut here = value(corners[0])?;
    let mut step = 0.1 * top.min(right);
    for side in corners.windows(2) {
        let length = (side[1] - side[0]).norm();
        let direction = (side[1] - side[0]) / length;
        let mut distance = 0.0;
        while distance < length {
            let next = (distance + step).min(length);
            let there = value(side[0] + direction * next)?;
            let turn = (there.phase / here.phase).arg();
            let change = turn.abs() + (there.logarithm - here.logarithm).abs();
            count += 1;
            if count > MAX_DETERMINANTS || !change.is_finite() {
                return None;
            }
            if change > MAX_CHANGE {
                step = (next - distance) / GROWTH;
                if step < 1e-12 * length {
                    return None;
                }
                continue;
            }
            (distance, here, turned) = (next, there, turned + turn);
            if change < SMALL_CHANGE {
                step *= GROWTH;
            }
        }
    }
    let half_turns = turned / std::f64::consts::PI;
    let missing = half_turns.round();
    ((half_turns - missing).abs() < MAX_FRACTION).then_some(missing as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two oscillators without damping, a damped one and two real eigenvalues.
    const VALUES: [Complex64; 5] = [
        Complex64::new(0.0, 3.0),
        Complex64::new(0.0, 3.0),
        Complex64::new(-0.5, 7.0),
        Complex64::new(-4.0, 0.0),
        Complex64::new(-90.0, 0.0),
    ];

    fn determinant(at: Complex64) -> Option<Determinant> {
        let factors = VALUES.iter().flat_map(|value| {
            let conjugate = (value.im != 0.0).then(|| at - value.conj());
            [at - value].into_iter().chain(conjugate)
        });
        Some(Determinant::product(factors.chain([at, at])))
    }

    #[test]
    fn every_missing_eigenvalue_is_counted() {
        let contour = Rectangle { left: 100.0, right: 1.0, top: 5.0 };
        let missing = |zeros: usize, values: &[Complex64]| {
            super::missing(determinant, &Known { zeros, values: values.to_vec() }, contour)
        };
        assert_eq!(missing(2, &VALUES), Some(0));
        // A pair counts twice; the third pair is outside.
        assert_eq!(missing(2, &VALUES[1..]), Some(2));
        assert_eq!(missing(2, &VALUES[2..4]), Some(5));
        assert_eq!(missing(2, &VALUES[..2]), Some(2));
        assert_eq!(missing(0, &[]), Some(8));
        // A value that is no eigenvalue is a pole.
        assert_eq!(missing(2, &[&VALUES[..], &[Complex64::new(0.0, 2.0)]].concat()), Some(-2));
    }
}
