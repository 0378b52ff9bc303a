//! Piecewise cubic polynomials through given points (Hermite form), and the slopes that make them splines or monotone.
//!
//! Between two knots of distance h, with the values y₀, y₁ and the slopes m₀, m₁, over the fraction s of the distance:
//!
//! y(s) = y₀ + h m₀ s + (3(y₁ − y₀) − h(2m₀ + m₁)) s² + (h(m₀ + m₁) − 2(y₁ − y₀)) s³

use std::ops::{Add, Mul, Sub};

/// What a cubic interpolates: real or complex numbers, or matrices.
pub trait Value: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Value for T {}

/// Value and slope at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<T> {
    /// Value y.
    pub value: T,
    /// Derivative dy/dx.
    pub slope: T,
}

/// A cubic polynomial over the fraction s of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic<T> {
    /// Coefficients of 1, s, s² and s³.
    pub coefficients: [T; 4],
}

impl<T: Value> Cubic<T> {
    /// The polynomial between two knots at the distance `width`.
    #[inline]
    pub fn between(begin: Knot<T>, end: Knot<T>, width: f64) -> Self {
        let rise = end.value - begin.value;
        let (m, n) = (begin.slope * width, end.slope * width);
        Self { coefficients: [begin.value, m, rise * 3.0 - m * 2.0 - n, m + n - rise * 2.0] }
    }

    /// Value at the fraction `s`.
    #[inline]
    pub fn value(&self, s: f64) -> T {
        let [constant, linear, square, cube] = self.coefficients;
        constant + (linear + (square + cube * s) * s) * s
    }

    /// Derivative dy/ds at the fraction `s`: the width of the interval times dy/dx.
    #[inline]
    pub fn slope(&self, s: f64) -> T {
        let [_, linear, square, cube] = self.coefficients;
        linear + (square * 2.0 + cube * (3.0 * s)) * s
    }

    /// Second derivative d²y/ds² at the fraction `s`.
    #[inline]
    pub fn curvature(&self, s: f64) -> T {
        let [_, _, square, cube] = self.coefficients;
        square * 2.0 + cube * (6.0 * s)
    }
}

/// Where a point lies among the knots of a piecewise cubic.
#[derive(Clone, Copy, Debug)]
pub enum Place<T> {
    /// Before the first knot, which it contains.
    Before(Knot<T>),
    /// Between two knots, or at the first one.
    Within {
        /// The polynomial between the two knots.
        cubic: Cubic<T>,
        /// Fraction of their distance.
        fraction: f64,
        /// Their distance.
        width: f64,
    },
    /// At the last knot, which it contains, or behind it.
    Behind(Knot<T>),
}

/// A function y(x) with a continuous derivative, cubic between knots.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseCubic<T> {
    /// Ascending positions of the knots, at least two.
    pub x: Vec<f64>,
    /// Values and slopes at the knots.
    pub knots: Vec<Knot<T>>,
}

impl<T: Value> PiecewiseCubic<T> {
    /// The function through points with given slopes; the three sequences have the same length.
    pub fn new(x: Vec<f64>, values: impl IntoIterator<Item = T>, slopes: impl IntoIterator<Item = T>) -> Self {
        let knots = values.into_iter().zip(slopes).map(|(value, slope)| Knot { value, slope }).collect();
        Self { x, knots }
    }

    /// Positions of the first and of the last knot.
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// The polynomial at `x`. At a knot, it begins there.
    #[inline]
    pub fn at(&self, x: f64) -> Place<T> {
        let above = self.x.partition_point(|knot| *knot <= x);
        if above == 0 {
            return Place::Before(self.knots[0]);
        }
        if above == self.x.len() {
            return Place::Behind(self.knots[above - 1]);
        }
        let begin = self.x[above - 1];
        let width = self.x[above] - begin;
        Place::Within { cubic: self.piece(above - 1), fraction: (x - begin) / width, width }
    }

    /// The polynomial between the knots `index` and `index` + 1.
    #[inline]
    pub fn piece(&self, index: usize) -> Cubic<T> {
        Cubic::between(self.knots[index], self.knots[index + 1], self.x[index + 1] - self.x[index])
    }
}

/// Slopes of the cubic spline with not-a-knot ends through points (x, y): the second derivative is continuous, the third one at
/// the second and the last knot but one too (de Boor, A Practical Guide to Splines, chapter IV). Through three points it is a
/// parabola, through two a line.
pub fn spline_slopes<T: Value>(x: &[f64], y: &[T]) -> Vec<T> {
    let count = x.len();
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let d: Vec<T> = y.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) * (1.0 / h)).collect();
    if count == 2 {
        return vec![d[0]; 2];
    }
    if count == 3 {
        let curvature = (d[1] - d[0]) * (1.0 / (h[0] + h[1]));
        return vec![d[0] - curvature * h[0], d[0] + curvature * h[0], d[1] + curvature * h[1]];
    }
    let whole = h[0] + h[1];
    let mut rows = vec![Row { lower: 0.0, diagonal: h[1], upper: whole }];
    let mut right = vec![(d[0] * ((h[0] + 2.0 * whole) * h[1]) + d[1] * (h[0] * h[0])) * (1.0 / whole)];
    for i in 1..count - 1 {
        rows.push(Row { lower: h[i], diagonal: 2.0 * (h[i - 1] + h[i]), upper: h[i - 1] });
        right.push((d[i - 1] * h[i] + d[i] * h[i - 1]) * 3.0);
    }
    let (a, b) = (h[count - 2], h[count - 3]);
    rows.push(Row { lower: a + b, diagonal: b, upper: 0.0 });
    right.push((d[count - 3] * (a * a) + d[count - 2] * ((2.0 * (a + b) + a) * b)) * (1.0 / (a + b)));
    solve_tridiagonal(rows, right)
}

/// Slopes of the natural cubic spline through `values` at equal distances: no curvature at the ends.
pub fn natural_slopes(values: &[f64], spacing: f64) -> Vec<f64> {
    let last = values.len() - 1;
    let rise = |i: usize| 3.0 * (values[(i + 1).min(last)] - values[i.saturating_sub(1)]) / spacing;
    let row = |i: usize| Row { lower: 1.0, diagonal: if i == 0 || i == last { 2.0 } else { 4.0 }, upper: 1.0 };
    solve_tridiagonal((0..=last).map(row).collect(), (0..=last).map(rise).collect())
}

/// Slopes of the periodic cubic spline through `values` at 0, h, 2h, … of a period.
pub fn periodic_slopes(values: &[f64], spacing: f64) -> Vec<f64> {
    let count = values.len();
    let neighbours = |i: usize| [(i + count - 1) % count, (i + 1) % count];
    let rise = |i: usize| 3.0 * (values[neighbours(i)[1]] - values[neighbours(i)[0]]) / spacing;
    // Gauss–Seidel on the cyclic system s₋ + 4s + s₊ = rise: every sweep divides the error by four, so that 60 sweeps
    // reach round-off.
    let mut slopes: Vec<f64> = (0..count).map(|i| rise(i) / 6.0).collect();
    for _ in 0..60 {
        for i in 0..count {
            let [before, after] = neighbours(i).map(|other| slopes[other]);
            slopes[i] = (rise(i) - before - after) / 4.0;
        }
    }
    slopes
}

/// Slopes of a cubic through points (x, y) that is monotone where the points are (Fritsch and Carlson, SIAM J. Numer. Anal. 17,
/// 1980): the weighted harmonic mean of the two secants, zero at an extremum (Fritsch and Butland, SIAM J. Sci. Stat. Comput.
/// 5, 1984). `scipy.interpolate.PchipInterpolator` is the same function.
pub fn monotone_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let widths: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let secants: Vec<f64> = y.windows(2).zip(&widths).map(|(pair, width)| (pair[1] - pair[0]) / width).collect();
    let last = secants.len() - 1;
    if last == 0 {
        return vec![secants[0]; 2];
    }
    let inner = (1..=last).map(|k| {
        let (left, right) = (secants[k - 1], secants[k]);
        if left * right <= 0.0 {
            return 0.0;
        }
        let (w, v) = (2.0 * widths[k] + widths[k - 1], widths[k] + 2.0 * widths[k - 1]);
        (w + v) / (w / left + v / right)
    });
    let begin = end_slope([widths[0], widths[1]], [secants[0], secants[1]]);
    let end = end_slope([widths[last], widths[last - 1]], [secants[last], secants[last - 1]]);
    std::iter::once(begin).chain(inner).chain([end]).collect()
}

/// The slope at an end: that of the parabola through three knots, limited so that the first cubic is monotone. Widths and secants
/// count from the end inwards.
fn end_slope(widths: [f64; 2], secants: [f64; 2]) -> f64 {
    let slope = ((2.0 * widths[0] + widths[1]) * secants[0] - widths[0] * secants[1]) / (widths[0] + widths[1]);
    if slope * secants[0] <= 0.0 {
        0.0
    } else if secants[0] * secants[1] < 0.0 && slope.abs() > 3.0 * secants[0].abs() {
        3.0 * secants[0]
    } else {
        slope
    }
}

/// A row of a tridiagonal matrix.
#[derive(Clone, Copy, Debug)]
struct Row {
    lower: f64,
    diagonal: f64,
    upper: f64,
}

/// Solves a tridiagonal system by elimination without pivoting.
fn solve_tridiagonal<T: Value>(mut rows: Vec<Row>, mut right: Vec<T>) -> Vec<T> {
    for i in 1..rows.len() {
        let factor = rows[i].lower / rows[i - 1].diagonal;
        rows[i].diagonal -= factor * rows[i - 1].upper;
        right[i] = right[i] - right[i - 1] * factor;
    }
    let last = rows.len() - 1;
    right[last] = right[last] * (1.0 / rows[last].diagonal);
    for i in (0..last).rev() {
        right[i] = (right[i] - right[i + 1] * rows[i].upper) * (1.0 / rows[i].diagonal);
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(curve: &PiecewiseCubic<f64>, x: f64) -> f64 {
        match curve.at(x) {
            Place::Within { cubic, fraction, .. } => cubic.value(fraction),
            Place::Before(_) => f64::NEG_INFINITY,
            Place::Behind(_) => f64::INFINITY,
        }
    }

    #[test]
    fn a_spline_reproduces_a_cubic_and_its_derivatives() {
        let f = |x: f64| 1.0 + x * (2.0 - x * (0.5 - 0.25 * x));
        let x: Vec<f64> = vec![0.0, 0.3, 1.1, 1.7, 2.6];
        let y: Vec<f64> = x.iter().map(|x| f(*x)).collect();
        let curve = PiecewiseCubic::new(x.clone(), y.clone(), spline_slopes(&x, &y));
        for step in 0..26 {
            let at = f64::from(step) / 10.0;
            // Round-off of a tridiagonal system with five rows.
            assert!((value(&curve, at) - f(at)).abs() < 1e-13);
            let Place::Within { cubic, fraction, width } = curve.at(at) else { panic!("{at} lies among the knots") };
            assert!((cubic.slope(fraction) / width - (2.0 - at + 0.75 * at * at)).abs() < 1e-12);
            assert!((cubic.curvature(fraction) / (width * width) - (1.5 * at - 1.0)).abs() < 1e-11);
        }
    }

    #[test]
    fn monotone_points_give_a_monotone_curve_with_their_values() {
        let (x, y) = (vec![0.0, 1.0, 2.0, 5.0], vec![1.0, 1.1, 9.0, 9.5]);
        let slopes = monotone_slopes(&x, &y);
        let curve = PiecewiseCubic::new(x.clone(), y.clone(), slopes);
        let mut before = 0.0;
        for step in 0..500 {
            let next = value(&curve, f64::from(step) / 100.0);
            assert!(next >= before);
            before = next;
        }
        assert!(x.iter().zip(&y).take(3).all(|(x, y)| value(&curve, *x) == *y));
        assert!(matches!(curve.at(5.0), Place::Behind(_)) && matches!(curve.at(-0.1), Place::Before(_)));
    }

    #[test]
    fn a_periodic_spline_has_continuous_second_derivatives() {
        let values = [1.0, 2.0, 0.5, 0.7, 3.0];
        let slopes = periodic_slopes(&values, 0.2);
        let piece = |i: usize| {
            let knot = |i: usize| Knot { value: values[i % 5], slope: slopes[i % 5] };
            Cubic::between(knot(i), knot(i + 1), 0.2)
        };
        assert!((0..5).all(|i| (piece(i).curvature(1.0) - piece((i + 1) % 5).curvature(0.0)).abs() < 1e-13));
    }
}
