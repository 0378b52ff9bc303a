//! Legendre polynomials, their integrals, and the Gauss rules on their roots.

use std::f64::consts::PI;

/// P_n(ξ) on [−1, 1], by the recurrence of three terms.
pub fn legendre(n: usize, xi: f64) -> f64 {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * xi * value - k * before) / (k + 1.0));
    }
    value
}

/// Integrated Legendre polynomial of degree n ≥ 2, ψ_n = (P_n − P_{n−2})/√(4n − 2), which vanishes at ξ = ±1. The
/// derivatives are orthonormal: ∫ψ_m' ψ_n' dξ = δ_mn (Szabó and Babuška 1991, Finite Element Analysis, section 6.1).
pub fn integrated(n: usize, xi: f64) -> f64 {
    (legendre(n, xi) - legendre(n - 2, xi)) / (4.0 * n as f64 - 2.0).sqrt()
}

/// Derivative ψ_n'(ξ) of [`integrated`].
pub fn integrated_slope(n: usize, xi: f64) -> f64 {
    (n as f64 - 0.5).sqrt() * legendre(n - 1, xi)
}

/// Integral of ψ_{n−1} from −1 to ξ for n ≥ 4. It has degree n and vanishes at ξ = ±1 with its slope.
pub fn twice_integrated(n: usize, xi: f64) -> f64 {
    // ∫P_k dξ = (P_{k+1} − P_{k−1})/(2k + 1).
    let part = |k: usize| (legendre(k + 1, xi) - legendre(k - 1, xi)) / (2.0 * k as f64 + 1.0);
    (part(n - 1) - part(n - 3)) / (4.0 * n as f64 - 6.0).sqrt()
}

/// Abscissae on [0, 1], ascending, and weights of the Gauss rule with `points` points, which integrates polynomials of
/// degree below twice `points`.
pub fn gauss(points: usize) -> Vec<(f64, f64)> {
    let count = points as f64;
    let root = |index: usize| {
        // Newton's method from an approximation of the root; it converges in fewer steps than these.
        let mut x = (PI * (index as f64 + 0.75) / (count + 0.5)).cos();
        for _ in 0..8 {
            x -= legendre(points, x) / slope(points, x);
        }
        (0.5 - x / 2.0, 1.0 / ((1.0 - x * x) * slope(points, x).powi(2)))
    };
    (0..points).map(root).collect()
}

/// P_n'(ξ) for |ξ| < 1.
fn slope(n: usize, xi: f64) -> f64 {
    let before = if n == 0 { 0.0 } else { legendre(n - 1, xi) };
    n as f64 * (before - xi * legendre(n, xi)) / (1.0 - xi * xi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_integrate_polynomials_of_degree_below_twice_their_points() {
        for points in 1..=24 {
            let rule = gauss(points);
            assert!(rule.windows(2).all(|pair| pair[0].0 < pair[1].0));
            for degree in 0..2 * points {
                let sum: f64 = rule.iter().map(|(x, weight)| weight * x.powi(degree as i32)).sum();
                // Each point contributes a few rounding errors.
                assert!((sum * (degree + 1) as f64 - 1.0).abs() < 1e-14 * points as f64, "{points} {degree}");
            }
        }
    }

    #[test]
    fn functions_vanish_at_the_ends_and_their_slopes_are_orthonormal() {
        let rule = gauss(12);
        let product =
            |f: &dyn Fn(f64) -> f64| rule.iter().map(|(x, weight)| 2.0 * weight * f(2.0 * x - 1.0)).sum::<f64>();
        for m in 2..=10 {
            assert!([-1.0, 1.0].iter().all(|end| integrated(m, *end).abs() < 1e-15));
            for n in 2..=10 {
                let form = product(&|x| integrated_slope(m, x) * integrated_slope(n, x));
                assert!((form - f64::from(m == n)).abs() < 1e-14);
            }
            // ∫ψ_m' f dξ = −∫ψ_m f' dξ for a function f that vanishes at the ends, here ψ_2.
            let parts =
                product(&|x| integrated_slope(m, x) * integrated(2, x) + integrated(m, x) * integrated_slope(2, x));
            assert!(parts.abs() < 1e-14);
        }
        for n in 4..=10 {
            assert!([-1.0, 1.0].iter().all(|end| twice_integrated(n, *end).abs() < 1e-15));
            let parts =
                product(&|x| twice_integrated(n, x) * integrated_slope(3, x) + integrated(n - 1, x) * integrated(3, x));
            assert!(parts.abs() < 1e-14);
        }
    }
}
