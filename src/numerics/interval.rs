//! Searches on an interval: bisection, a root of a function, and a maximum.

use super::ROUND_OFF;

/// A point and the value of a function there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The point.
    pub at: f64,
    /// The value.
    pub value: f64,
}

/// A smooth function needs fewer than ten iterations.
const MAX_ITERATIONS: usize = 100;

/// Halves the interval between `before` and `after` until it is at most `resolution` long. `is_after` tells whether a point
/// belongs to the side of `after`. Returns the two ends.
///
/// # Errors
/// Those of `is_after`.
pub fn bisect<E>(
    before: f64,
    after: f64,
    resolution: f64,
    mut is_after: impl FnMut(f64) -> Result<bool, E>,
) -> Result<[f64; 2], E> {
    let [mut before, mut after] = [before, after];
    while (after - before).abs() > resolution {
        let middle = f64::midpoint(before, after);
        if middle == before || middle == after {
            break;
        }
        *(if is_after(middle)? { &mut after } else { &mut before }) = middle;
    }
    Ok([before, after])
}

/// The root between two points with values of opposite signs, up to round-off, by the method of Illinois (Dowell and Jarratt, BIT 11, 1971).
///
/// # Errors
/// Those of `value`.
pub fn root<E>([mut low, mut high]: [Sample; 2], mut value: impl FnMut(f64) -> Result<f64, E>) -> Result<f64, E> {
    for _ in 0..MAX_ITERATIONS {
        if (high.at - low.at).abs() <= ROUND_OFF * high.at.abs() || high.value == 0.0 {
            break;
        }
        let secant = high.at - high.value * (high.at - low.at) / (high.value - low.value);
        let at = if secant.is_finite() { secant } else { f64::midpoint(low.at, high.at) };
        if at == high.at || at == low.at {
            break;
        }
        let next = Sample { at, value: value(at)? };
        if (next.value < 0.0) != (high.value < 0.0) {
            low = high;
        } else {
            low.value /= 2.0;
        }
        high = next;
        if next.value.abs() <= ROUND_OFF * at.abs() {
            break;
        }
    }
    Ok(high.at)
}

/// The largest value between two points, by golden-section search. The function has one maximum there. `tolerance` is the
/// error of the position relative to the upper end; a maximum is flat, so that round-off prevents less than 1e-9.
///
/// # Errors
/// Those of `value`.
pub fn maximum<E>(low: f64, high: f64, tolerance: f64, value: impl Fn(f64) -> Result<f64, E>) -> Result<Sample, E> {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let sample = |at: f64| value(at).map(|value| Sample { at, value });
    let [mut low, mut high] = [low, high];
    let mut inner = [sample(high - golden * (high - low))?, sample(low + golden * (high - low))?];
    while high - low > tolerance * high.abs() {
        if inner[0].value > inner[1].value {
            high = inner[1].at;
            inner = [sample(high - golden * (high - low))?, inner[0]];
        } else {
            low = inner[0].at;
            inner = [inner[1], sample(low + golden * (high - low))?];
        }
    }
    Ok(if inner[0].value > inner[1].value { inner[0] } else { inner[1] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(value: f64) -> Result<f64, ()> {
        Ok(value)
    }

    #[test]
    fn searches_find_the_root_and_the_maximum_of_a_cosine() {
        let ends = [0.5, 2.0].map(|at: f64| Sample { at, value: at.cos() });
        assert!(root(ends, |x| exact(x.cos())).is_ok_and(|x| (x - std::f64::consts::FRAC_PI_2).abs() < 1e-11));
        let top = maximum(-1.0, 0.5, 1e-9, |x| exact((x - 0.1).cos()));
        assert!(top.is_ok_and(|top| (top.at - 0.1).abs() < 1e-7 && (top.value - 1.0).abs() < 1e-14));
        for [before, after] in [[0.5, 2.0], [2.0, 0.5]] {
            let is_after = |x: f64| Ok::<_, ()>((x > std::f64::consts::FRAC_PI_2) == (after > before));
            assert!(bisect(before, after, 1e-12, is_after).is_ok_and(|ends| (ends[1] - ends[0]).abs() <= 1e-12));
        }
    }
}
