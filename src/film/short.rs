//! Short film (Ocvirk) with cavitation by Gümbel's condition: pressure where the film is squeezed, zero elsewhere.
//!
//! With L ≪ D the pressure is a parabola along the bearing. In the frame of the unit vectors ŵ = w/|w| and ŵ⊥, the force is
//!
//! ```text
//! f = ∫ cos α e_α / (1 − u·e_α)³ dα = ½ (∂²S/∂a², ∂²S/∂a∂b),    −π/2 ≤ α ≤ π/2,    u = (a, b)
//! S = ∫ dα / (1 − u·e_α) = 2A/Δ,    Δ² = 1 − a² − b²,    A = atan((1 + a − b)/Δ) + atan((1 + a + b)/Δ)
//! ```
//!
//! because every derivative of the integrand by u multiplies it by e_α/(1 − u·e_α). With ∂A/∂a = 1/Δ and
//! ∂A/∂b = ab/(Δ(1 − b²)) all derivatives of S follow from S itself. No term is singular at u = 0.
//! For a steady eccentricity these are the forces of Ocvirk (NACA TN 2808, 1952): ε²/(1 − ε²)² and πε/(4(1 − ε²)^{3/2}).

use super::{Matrix, Response, Vector, direction};

/// |w| f and its derivatives at u and w; |u| < 1.
#[inline]
pub fn response(u: Vector, w: Vector) -> Response {
    let (along, size) = direction(w);
    let across = [-along[1], along[0]];
    let (a, b) = (u[0] * along[0] + u[1] * along[1], u[0] * across[0] + u[1] * across[1]);
    let [second, third] = derivatives(a, b);
    let [aa, ab, bb] = second.map(|value| value / 2.0);
    let [aaa, aab, abb] = third.map(|value| size * value / 2.0);
    let outside = |m: Matrix| -> Matrix {
        let axes = [along, across];
        let entry = |i: usize, j: usize| {
            let terms = (0..4).map(|at| axes[at / 2][i] * m[at / 2][at % 2] * axes[at % 2][j]);
            terms.sum()
        };
        [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
    };
    Response {
        force: [0, 1].map(|i| size * (aa * along[i] + ab * across[i])),
        displacement: outside([[aaa, aab], [aab, abb]]),
        // The pressure vanishes at the ends of the squeezed part, so that their motion does not contribute.
        velocity: outside([[aa, ab], [ab, bb]]),
    }
}

/// Derivatives of S: aa, ab, bb, and aaa, aab, abb.
#[inline]
fn derivatives(a: f64, b: f64) -> [[f64; 3]; 2] {
    let square = 1.0 - a * a - b * b;
    let delta = square.sqrt();
    let s = 2.0 * (((1.0 + a - b) / delta).atan() + ((1.0 + a + b) / delta).atan()) / delta;
    // E = 1/Δ², with ∂E/∂a = 2aE² and ∂E/∂b = 2bE². X = E S.
    let e = 1.0 / square;
    let (e_a, e_b) = (2.0 * a * e * e, 2.0 * b * e * e);
    let (e_aa, e_ab, e_bb) =
        (2.0 * e * e + 8.0 * a * a * e * e * e, 8.0 * a * b * e * e * e, 2.0 * e * e + 8.0 * b * b * e * e * e);
    // S_a = a X + 2E and S_b = b X + 2E m with m = ab/(1 − b²).
    let x = e * s;
    let rest = 1.0 - b * b;
    let m = a * b / rest;
    let m_b = a * (1.0 + b * b) / (rest * rest);
    let (s_a, s_b) = (a * x + 2.0 * e, b * x + 2.0 * e * m);
    let (x_a, x_b) = (e_a * s + e * s_a, e_b * s + e * s_b);
    let s_aa = x + a * x_a + 2.0 * e_a;
    let s_ab = a * x_b + 2.0 * e_b;
    let s_bb = x + b * x_b + 2.0 * e_b * m + 2.0 * e * m_b;
    let x_aa = e_aa * s + 2.0 * e_a * s_a + e * s_aa;
    let x_ab = e_ab * s + e_a * s_b + e_b * s_a + e * s_ab;
    let x_bb = e_bb * s + 2.0 * e_b * s_b + e * s_bb;
    let s_aaa = 2.0 * x_a + a * x_aa + 2.0 * e_aa;
    let s_aab = x_b + a * x_ab + 2.0 * e_ab;
    let s_abb = a * x_bb + 2.0 * e_bb;
    [[s_aa, s_ab, s_bb], [s_aaa, s_aab, s_abb]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_equal_the_integrals() {
        // The trapezoidal rule of a smooth integrand on 20000 intervals, with its end correction, is exact to 1e-12.
        let integral = |u: Vector, of: &dyn Fn(f64, f64) -> f64, power: i32| {
            let count = 20_000;
            let step = std::f64::consts::PI / f64::from(count);
            let value = |k: i32| {
                let (sin, cos) = (-std::f64::consts::FRAC_PI_2 + f64::from(k) * step).sin_cos();
                of(cos, sin) / (1.0 - u[0] * cos - u[1] * sin).powi(power)
            };
            let inner: f64 = (1..count).map(value).sum();
            step * (inner + (value(0) + value(count)) / 2.0)
        };
        for u in [[0.0, 0.0], [1e-9, 0.3], [0.5, -0.2], [-0.6, 0.1], [0.1, 0.8]] {
            let [second, third] = derivatives(u[0], u[1]);
            let twice: [&dyn Fn(f64, f64) -> f64; 3] = [&|c, _| c * c, &|c, s| c * s, &|_, s| s * s];
            for (found, of) in second.into_iter().zip(twice) {
                let expected = 2.0 * integral(u, of, 3);
                assert!((found - expected).abs() < 1e-5 * second[0].abs(), "{u:?} {found} {expected}");
            }
            let thrice: [&dyn Fn(f64, f64) -> f64; 3] = [&|c, _| c * c * c, &|c, s| c * c * s, &|c, s| c * s * s];
            for (found, of) in third.into_iter().zip(thrice) {
                let expected = 6.0 * integral(u, of, 4);
                assert!((found - expected).abs() < 1e-5 * third[0].abs(), "{u:?} {found} {expected}");
            }
        }
    }

    #[test]
    fn a_steady_journal_has_the_forces_of_ocvirk() {
        for ratio in [1e-6_f64, 0.1, 0.266_298, 0.7, 0.95] {
            // Ω = 2: w = −x × u.
            let found = response([ratio, 0.0], [0.0, -ratio]).force;
            let square = 1.0 - ratio * ratio;
            let radial = 2.0 * ratio * ratio / (square * square);
            let tangential = -std::f64::consts::PI * ratio / (2.0 * square.powf(1.5));
            assert!((found[0] - radial).abs() < 1e-12 * (radial + ratio), "{found:?} {radial}");
            assert!((found[1] - tangential).abs() < 1e-12 * tangential.abs(), "{found:?} {tangential}");
        }
    }
}
