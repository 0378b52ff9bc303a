//! Number of eigenvalues in a disk that an iteration did not find.
//!
//! The determinant of the dynamic stiffness S(λ) is a polynomial whose zeros are the eigenvalues. By the argument
//! principle, the change of its phase along a circle is 2π times the number of zeros inside. Here the determinant is
//! divided by the factors λ − λ_k of the known eigenvalues: what remains has no zero inside if none is missing, and its
//! phase changes slowly. S is real for real λ, so the upper half of the circle is enough.
//!
//! The logarithm of the determinant is a smooth function of ln λ apart from the zeros. Its phase is known up to multiples
//! of 2π. The polynomial through the previous points in ln λ predicts the next value and so selects the multiple; the step
//! is halved where the prediction is uncertain or fails. The number of determinants hardly depends on the number of
//! eigenvalues outside.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::linalg::Determinant;

/// Largest difference of the complex logarithm from its prediction, and half of that of the predictions from all previous points and
/// from one less. The latter bounds the error of the prediction by half a turn: a larger error could differ from its value between −π
/// and π by whole turns.
const MAX_ERROR: f64 = 0.5;
/// Difference of the complex logarithm from its prediction below which the next step on the contour is longer.
const SMALL_ERROR: f64 = 0.05;
/// Ratio of the lengths of successive steps.
const GROWTH: f64 = 8.0;
/// First step in ln λ: the complex logarithm of a polynomial of degree 10⁴ changes by less than half a turn.
const FIRST_STEP: f64 = 1e-4;
/// Largest step in ln λ.
const MAX_STEP: f64 = 0.7;
/// Smallest step in ln λ: an eigenvalue lies on the contour.
const MIN_STEP: f64 = 1e-9;
/// Number of points of the polynomial that predicts the next value.
const POINTS: usize = 6;
/// Largest number of determinants of one contour.
const MAX_DETERMINANTS: usize = 2000;

/// Known eigenvalues.
#[derive(Clone, Debug, Default)]
pub(in crate::modal) struct Known {
    /// Number of eigenvalues that are zero.
    pub zeros: usize,
    /// Other real eigenvalues, and one of each conjugate pair, rad/s.
    pub values: Vec<Complex64>,
}

/// Logarithm, up to multiples of 2πi, of the determinant at λ without the factors of the known eigenvalues.
fn deflated(determinant: Determinant, known: &Known, at: Complex64) -> Complex64 {
    let factors = known.values.iter().flat_map(|value| {
        let conjugate = (value.im != 0.0).then(|| at - value.conj());
        [at - value].into_iter().chain(conjugate)
    });
    let product = Determinant::product(factors);
    let zeros = at.ln() * known.zeros as f64;
    Complex64::new(
        determinant.logarithm - product.logarithm - zeros.re,
        determinant.phase.arg() - product.phase.arg() - zeros.im,
    )
}

/// Value at `z` of the polynomial through points (z, value), by Neville's algorithm.
fn extrapolated(points: &[(Complex64, Complex64)], z: Complex64) -> Complex64 {
    let mut values: Vec<Complex64> = points.iter().map(|(_, value)| *value).collect();
    for order in 1..points.len() {
        for index in 0..points.len() - order {
            let (first, last) = (points[index].0, points[index + order].0);
            values[index] = ((z - last) * values[index] + (first - z) * values[index + 1]) / (first - last);
        }
    }
    values[0]
}

/// `value` with its imaginary part reduced to (−π, π].
fn reduced(value: Complex64) -> Complex64 {
    Complex64::new(value.re, Complex64::from_polar(1.0, value.im).arg())
}

/// Number of eigenvalues with |λ| < `radius`, rad/s, that are missing in `known`, negative if a known value is none; `None` if it
/// cannot be determined.
pub(in crate::modal) fn missing_in_disk(
    determinant: impl Fn(Complex64) -> Option<Determinant>,
    known: &Known,
    radius: f64,
) -> Option<i64> {
    let value = |z: Complex64| determinant(z.exp()).map(|found| deflated(found, known, z.exp()));
    let first = Complex64::from(radius.ln());
    let begin = value(first)?;
    let mut points = vec![(first, begin)];
    let (mut end, mut step, mut count, mut angle) = (begin, FIRST_STEP, 0, 0.0);
    while angle < PI {
        let next = if angle + step > (1.0 - MIN_STEP) * PI { PI } else { angle + step };
        let z = Complex64::new(first.re, next);
        let predicted = extrapolated(&points, z);
        let rest = points.get(1..).filter(|rest| !rest.is_empty());
        if rest.is_some_and(|rest| (predicted - extrapolated(rest, z)).norm() > 2.0 * MAX_ERROR) {
            step = (next - angle) / 2.0;
            continue;
        }
        let error = reduced(value(z)? - predicted);
        count += 1;
        if count > MAX_DETERMINANTS || !error.is_finite() {
            return None;
        }
        if error.norm() > MAX_ERROR {
            step = (next - angle) / 2.0;
            if step < MIN_STEP {
                return None;
            }
            continue;
        }
        end = predicted + error;
        if points.len() == 1 {
            // S is real for real λ, so that the values are mirrored at the real axis.
            points.insert(0, (z.conj(), begin + (end - begin).conj()));
        }
        points.push((z, end));
        if points.len() > POINTS {
            points.remove(0);
        }
        angle = next;
        if error.norm() < SMALL_ERROR {
            step = (step * GROWTH).min(MAX_STEP);
        }
    }
    let half_turns = (end - begin).im / PI;
    let missing = half_turns.round();
    ((half_turns - missing).abs() < SMALL_ERROR).then_some(missing as i64)
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

    /// Determinant with these zeros, two zeros at the origin, and `others` of high frequency.
    fn determinant(others: usize) -> impl Fn(Complex64) -> Option<Determinant> {
        let high = (0..others).map(|index| Complex64::new(-0.1 * index as f64, 200.0 + 30.0 * index as f64));
        let values: Vec<Complex64> = VALUES.into_iter().chain(high).collect();
        move |at| {
            let factors = values.iter().flat_map(|value| {
                let conjugate = (value.im != 0.0).then(|| at - value.conj());
                [at - value].into_iter().chain(conjugate)
            });
            Some(Determinant::product(factors.chain([at, at])))
        }
    }

    #[test]
    fn every_missing_eigenvalue_is_counted() {
        let missing = |zeros: usize, values: &[Complex64]| {
            missing_in_disk(determinant(0), &Known { zeros, values: values.to_vec() }, 5.0)
        };
        assert_eq!(missing(2, &VALUES), Some(0));
        // A pair counts twice; the third pair and the last real eigenvalue are outside.
        assert_eq!(missing(2, &VALUES[1..]), Some(2));
        assert_eq!(missing(2, &VALUES[2..4]), Some(4));
        assert_eq!(missing(2, &VALUES[..2]), Some(1));
        assert_eq!(missing(0, &[]), Some(7));
        // A value that is no eigenvalue is a pole.
        assert_eq!(missing(2, &[&VALUES[..], &[Complex64::new(0.0, 2.0)]].concat()), Some(-2));
    }

    #[test]
    fn whole_turns_of_the_phase_are_not_lost() {
        // The circle begins where the phase of a determinant of high degree changes most.
        for others in [750, 1000, 1500, 3000] {
            let missing = missing_in_disk(determinant(others), &Known { zeros: 2, values: VALUES[1..].to_vec() }, 5.0);
            assert_eq!(missing, Some(2), "{others}");
        }
    }

    /// Counts eigenvalues with |λ| < 5 that are missing in `values`; returns their number and that of the determinants.
    fn counted(others: usize, values: &[Complex64]) -> (Option<i64>, usize) {
        let calls = std::cell::Cell::new(0);
        let determinant = determinant(others);
        let counting = |at| {
            calls.set(calls.get() + 1);
            determinant(at)
        };
        let missing = missing_in_disk(counting, &Known { zeros: 2, values: values.to_vec() }, 5.0);
        (missing, calls.get())
    }

    #[test]
    fn many_other_eigenvalues_do_not_disturb_the_count() {
        for others in [10, 100, 1000] {
            let (missing, calls) = counted(others, &VALUES[1..]);
            assert_eq!(missing, Some(2));
            assert!(calls < 60, "{calls} determinants for {others}");
        }
    }

    #[test]
    fn approximations_outside_save_determinants_and_count_for_nothing() {
        // The third pair is close to the circle; its approximation is wrong by a tenth.
        let rough = [Complex64::new(-0.4, 7.7), Complex64::new(-80.0, 0.0), Complex64::new(3.0, 50.0)];
        let close = [Complex64::new(-0.5, 5.01); 2];
        for inside in [&[0, 1, 3][..], &[1, 3], &[0, 1]] {
            let known: Vec<Complex64> = inside.iter().map(|index| VALUES[*index]).collect();
            let (missing, calls) = counted(20, &known);
            let (same, fewer) = counted(20, &[&known[..], &rough].concat());
            assert!(missing.is_some() && missing == same && fewer <= calls, "{missing:?} {same:?}: {calls}, {fewer}");
            assert_eq!(counted(20, &[&known[..], &close].concat()).0, missing);
        }
    }
}
