//! Growing modes: the real part of their eigenvalue is positive, beyond round-off.

use num_complex::Complex64;

/// Smallest ratio of a growth rate Re λ to |λ| and to the speed that counts as unstable; round-off causes smaller ones.
const MIN_GROWTH: f64 = 1e-6;

/// Whether a mode with the eigenvalue λ, rad/s, grows at a speed of the reference shaft, rad/s.
pub fn is_growing(eigenvalue: Complex64, speed: f64) -> bool {
    eigenvalue.re > MIN_GROWTH * eigenvalue.norm().max(speed.abs())
}
