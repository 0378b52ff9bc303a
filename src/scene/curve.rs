//! A real function through given points: cubic interpolation, monotone unless slopes are given, with the end values
//! outside.

use super::speed_table::slopes_of_entry;
use super::{EntryPath, SceneError};

/// A function y(x) through points, with a continuous derivative.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    /// dy/dx at each point.
    slopes: Vec<f64>,
}

impl Curve {
    /// The function through the points (x, y), of which there are at least two, in ascending order of x.
    pub(super) fn new(x: Vec<f64>, y: Vec<f64>) -> Self {
        Self { slopes: slopes_of_entry(&x, &y), x, y }
    }

    /// The same with given derivatives at the points.
    pub(super) fn with_slopes(self, slopes: Vec<f64>) -> Self {
        Self { slopes, ..self }
    }

    /// The value and its derivative.
    #[inline]
    pub fn at(&self, x: f64) -> [f64; 2] {
        let (above, last) = (self.x.partition_point(|knot| *knot <= x), self.x.len() - 1);
        if above == 0 || x >= self.x[last] {
            let end = if above == 0 { 0 } else { last };
            return [self.y[end], 0.0];
        }
        let (left, right) = (above - 1, above);
        let (width, t) = (self.x[right] - self.x[left], x - self.x[left]);
        let (y, m, n) = (self.y[left], self.slopes[left], self.slopes[right]);
        let secant = (self.y[right] - y) / width;
        let (c, d) = ((3.0 * secant - 2.0 * m - n) / width, (m + n - 2.0 * secant) / (width * width));
        [y + t * (m + t * (c + t * d)), m + t * (2.0 * c + t * 3.0 * d)]
    }

    /// Width of each piece, and the coefficients of dy/dx = a + b s + c s² in the distance s from its begin.
    pub fn derivative_pieces(&self) -> impl Iterator<Item = (f64, [f64; 3])> + '_ {
        let knots = self.x.windows(2).zip(self.y.windows(2)).zip(self.slopes.windows(2));
        knots.map(|((x, y), slopes)| {
            let (width, m, n) = (x[1] - x[0], slopes[0], slopes[1]);
            let secant = (y[1] - y[0]) / width;
            (width, [m, 2.0 * (3.0 * secant - 2.0 * m - n) / width, 3.0 * (m + n - 2.0 * secant) / (width * width)])
        })
    }

    /// Difference of the largest and the smallest y of the points.
    pub fn span(&self) -> f64 {
        let [low, high] = self.y.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], y| [l.min(*y), h.max(*y)]);
        high - low
    }

    /// First and last x.
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// Largest |y| of the points.
    pub fn largest(&self) -> f64 {
        self.y.iter().fold(0.0, |most, y| most.max(y.abs()))
    }

    /// Mean distance of the points.
    pub fn mean_spacing(&self) -> f64 {
        let [first, last] = self.range();
        (last - first) / (self.x.len() - 1) as f64
    }

    /// Bound of |dy/dx| without given slopes: a monotone cubic is nowhere steeper than three times its secant.
    pub fn steepest(&self) -> f64 {
        let secants = self.x.windows(2).zip(self.y.windows(2)).map(|(x, y)| ((y[1] - y[0]) / (x[1] - x[0])).abs());
        3.0 * secants.fold(0.0, f64::max)
    }
}

/// Refuses points that do not ascend, or values that do not fit them.
pub(super) fn check_points(
    at: &EntryPath,
    [x_name, y_name]: [&str; 2],
    x: &[f64],
    y: &[num_complex::Complex64],
) -> Result<(), SceneError> {
    let place = at.field(x_name);
    if x.len() < 2 {
        return Err(place.error(format!("needs at least 2 entries, got {}", x.len())));
    }
    for (index, value) in x.iter().enumerate() {
        place.index(index).finite(*value)?;
        if index > 0 && *value <= x[index - 1] {
            let message = format!("must be above the entry before it, {}, got {value}", x[index - 1]);
            return Err(place.index(index).error(message));
        }
    }
    let place = at.field(y_name);
    if y.len() != x.len() {
        return Err(place.error(format!("needs one value for each of the {} {x_name}, got {}", x.len(), y.len())));
    }
    for (index, value) in y.iter().enumerate() {
        place.index(index).finite(value.re)?;
        place.index(index).finite(value.im)?;
    }
    Ok(())
}
