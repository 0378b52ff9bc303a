//! Shaft angles of long runs, without the digits that a large product loses.

use num_complex::Complex64;

/// e^{iΩt} for any t: the product Ωt is taken with its rounding error (Dekker 1971), which at Ωt = 1e8 rad would
/// otherwise turn the shaft by 1e-8 rad.
pub fn phase(spin: f64, time: f64) -> Complex64 {
    let product = spin * time;
    if !product.is_finite() {
        return Complex64::new(f64::NAN, f64::NAN);
    }
    let (spin_high, spin_low) = split(spin);
    let (time_high, time_low) = split(time);
    let error = ((spin_high * time_high - product) + spin_high * time_low + spin_low * time_high) + spin_low * time_low;
    Complex64::from_polar(1.0, product) * Complex64::from_polar(1.0, error)
}

/// The upper and the lower half of the digits of a number (Veltkamp).
fn split(value: f64) -> (f64, f64) {
    let shifted = value * 134_217_729.0;
    let high = shifted - (shifted - value);
    (high, value - high)
}
