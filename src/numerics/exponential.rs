//! The exponential function of several complex numbers at once, in plain arithmetic that compilers vectorise.

use std::f64::consts::{FRAC_2_PI, LOG2_E};

/// Adding this number, 1.5·2⁵², leaves the nearest integer in the lowest bits.
const TO_INTEGER: f64 = 1.5 / f64::EPSILON;
/// π/2 and ln 2 in two parts each. The first has so few bits that its product with an integer below 2²⁰ is exact (fdlibm).
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// Real parts beyond this one are cut off: the result is then zero or infinite for every purpose.
const MAX_REAL: f64 = 700.0;

/// 1/m!. The series of eˣ with all terms ends at round-off for |x| ≤ 2.5.
pub const INVERSE_FACTORIAL: [f64; 24] = {
    let mut values = [1.0; 24];
    let mut m = 1;
    while m < values.len() {
        values[m] = values[m - 1] / m as f64;
        m += 1;
    }
    values
};
/// Coefficients of eˣ for |x| ≤ ln 2/2, and of cos √−x and sin √−x/√−x for √−x ≤ π/4: further ones are below round-off.
const EXPONENTIAL_COEFFICIENTS: [f64; 14] = every(0, 1);
const COSINE_COEFFICIENTS: [f64; 9] = every(0, 2);
const SINE_COEFFICIENTS: [f64; 9] = every(1, 2);

/// The inverse factorials of first, first + step, …
const fn every<const N: usize>(first: usize, step: usize) -> [f64; N] {
    let mut values = [0.0; N];
    let mut k = 0;
    while k < N {
        values[k] = INVERSE_FACTORIAL[first + step * k];
        k += 1;
    }
    values
}

/// Real and imaginary parts of e^{x + iy}, to a few units in the last place for |y| < 10⁶.
#[inline(always)]
pub fn exponential<const N: usize>([x, y]: &[[f64; N]; 2]) -> [[f64; N]; 2] {
    let (mut parts, mut quadrants, mut scales) = ([[0.0; N]; 2], [0_u64; N], [0.0; N]);
    for lane in 0..N {
        let x = x[lane].clamp(-MAX_REAL, MAX_REAL);
        let twos = x * LOG2_E + TO_INTEGER;
        let whole = twos - TO_INTEGER;
        parts[0][lane] = x - whole * LN_2[0] - whole * LN_2[1];
        scales[lane] = f64::from_bits((twos + f64::from(f64::MAX_EXP - 1)).to_bits() << (f64::MANTISSA_DIGITS - 1));
        let turns = y[lane] * FRAC_2_PI + TO_INTEGER;
        let whole = turns - TO_INTEGER;
        parts[1][lane] = y[lane] - whole * HALF_PI[0] - whole * HALF_PI[1];
        quadrants[lane] = turns.to_bits();
    }
    let [x, y] = parts;
    let minus_square = y.map(|y| -y * y);
    let size = polynomial(&EXPONENTIAL_COEFFICIENTS, &x);
    let (cosine, sine) =
        (polynomial(&COSINE_COEFFICIENTS, &minus_square), polynomial(&SINE_COEFFICIENTS, &minus_square));
    let mut result = [[0.0; N]; 2];
    for lane in 0..N {
        let size = size[lane] * scales[lane];
        let (cosine, sine) = ((cosine[lane] * size).to_bits(), (sine[lane] * y[lane] * size).to_bits());
        let quadrant = quadrants[lane];
        // Odd quarter turns exchange sine and cosine; the second bit is their sign.
        let exchanged = (cosine ^ sine) & (quadrant & 1).wrapping_neg();
        result[0][lane] = f64::from_bits(cosine ^ exchanged ^ ((quadrant.wrapping_add(1) & 2) << 62));
        result[1][lane] = f64::from_bits(sine ^ exchanged ^ ((quadrant & 2) << 62));
    }
    result
}

/// Value of a polynomial, lowest power first. Even and odd powers are summed apart: one sum would wait for each addition.
#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64], x: &[f64; N]) -> [f64; N] {
    let (pairs, last) = coefficients.as_chunks::<2>();
    let (mut even, mut odd) = ([last.first().copied().unwrap_or(0.0); N], [0.0; N]);
    for [zeroth, first] in pairs.iter().rev() {
        for lane in 0..N {
            let square = x[lane] * x[lane];
            even[lane] = even[lane] * square + zeroth;
            odd[lane] = odd[lane] * square + first;
        }
    }
    std::array::from_fn(|lane| even[lane] + odd[lane] * x[lane])
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::exponential;

    #[test]
    fn lanes_are_exponentials_of_single_numbers() {
        for (x, y) in [0.0, 1e-9, -0.3, 0.4, 5.0, -37.0, -800.0]
            .into_iter()
            .flat_map(|x| [0.0, 0.5, -0.8, 1.6, -3.2, 4.7, 1e3, -7.7e5].map(|y| (x, y)))
        {
            let [re, im] = exponential(&[[x; 4], [y; 4]]);
            let exact = Complex64::new(x, y).exp();
            // The number of quarter turns times ln 2 or π/2 is exact, so that the size of the phase costs no digit.
            assert!(
                (Complex64::new(re[3], im[3]) - exact).norm() < 4.0 * f64::EPSILON * exact.norm() + 1e-300,
                "{x} {y}"
            );
        }
    }
}
