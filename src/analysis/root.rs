//! The root of a function of one speed, by the method of Illinois (Dowell and Jarratt, BIT 11, 1971).

use super::AnalysisError;

/// Relative error of the root.
const TOLERANCE: f64 = 1e-12;
/// A smooth function needs fewer than ten iterations.
const ITERATIONS: usize = 100;

/// The root between two points (speed, value) with values of opposite signs.
pub(super) fn root(
    [mut low, mut high]: [(f64, f64); 2],
    value: impl Fn(f64) -> Result<f64, AnalysisError>,
) -> Result<f64, AnalysisError> {
    for _ in 0..ITERATIONS {
        if (high.0 - low.0).abs() <= TOLERANCE * high.0.abs() || high.1 == 0.0 {
            break;
        }
        let secant = high.0 - high.1 * (high.0 - low.0) / (high.1 - low.1);
        let speed = if secant.is_finite() { secant } else { f64::midpoint(low.0, high.0) };
        if speed == high.0 || speed == low.0 {
            break;
        }
        let next = (speed, value(speed)?);
        if (next.1 < 0.0) != (high.1 < 0.0) {
            low = high;
        } else {
            low.1 /= 2.0;
        }
        high = next;
        if next.1.abs() <= TOLERANCE * speed.abs() {
            break;
        }
    }
    Ok(high.0)
}
