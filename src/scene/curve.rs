//! A real function through given points: cubic interpolation, monotone unless slopes are given, with the end values
//! outside.

use super::{EntryPath, SceneError};
use crate::numerics::{PiecewiseCubic, Place, monotone_slopes};

/// A function y(x) through points, with a continuous derivative.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(PiecewiseCubic<f64>);

impl Curve {
    /// The function through the points (x, y), of which there are at least two, in ascending order of x.
    pub(super) fn new(x: Vec<f64>, y: Vec<f64>) -> Self {
        let slopes = monotone_slopes(&x, &y);
        Self(PiecewiseCubic::new(x, y, slopes))
    }

    /// The same with given derivatives at the points.
    pub(super) fn with_slopes(mut self, slopes: Vec<f64>) -> Self {
        for (knot, slope) in self.0.knots.iter_mut().zip(slopes) {
            knot.slope = slope;
        }
        self
    }

    /// The value and its derivative.
    #[inline]
    pub fn at(&self, x: f64) -> [f64; 2] {
        match self.0.at(x) {
            Place::Before(end) | Place::Behind(end) => [end.value, 0.0],
            Place::Within { cubic, fraction, width } => [cubic.value(fraction), cubic.slope(fraction) / width],
        }
    }

    /// Width of each piece, and the coefficients of dy/dx = a + b s + c s² in the distance s from its begin.
    pub fn derivative_pieces(&self) -> impl Iterator<Item = (f64, [f64; 3])> + '_ {
        self.0.x.windows(2).enumerate().map(|(index, ends)| {
            let (width, [_, linear, square, cube]) = (ends[1] - ends[0], self.0.piece(index).coefficients);
            (width, [linear / width, 2.0 * square / width.powi(2), 3.0 * cube / width.powi(3)])
        })
    }

    fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.knots.iter().map(|knot| knot.value)
    }

    /// Difference of the largest and the smallest y of the points.
    pub fn span(&self) -> f64 {
        let [low, high] = self.values().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], y| [l.min(y), h.max(y)]);
        high - low
    }

    /// First and last x.
    pub fn range(&self) -> [f64; 2] {
        self.0.range()
    }

    /// Largest |y| of the points.
    pub fn largest(&self) -> f64 {
        self.values().fold(0.0, |most, y| most.max(y.abs()))
    }

    /// Mean distance of the points.
    pub fn mean_spacing(&self) -> f64 {
        let [first, last] = self.range();
        (last - first) / (self.0.x.len() - 1) as f64
    }

    /// Bound of |dy/dx| without given slopes: a monotone cubic is nowhere steeper than three times its secant.
    pub fn steepest(&self) -> f64 {
        let pieces = self.0.x.windows(2).zip(self.0.knots.windows(2));
        3.0 * pieces.map(|(x, y)| ((y[1].value - y[0].value) / (x[1] - x[0])).abs()).fold(0.0, f64::max)
    }
}

/// Refuses points that do not ascend, or values that do not fit them.
pub(super) fn check_points(
    at: &EntryPath,
    x_name: &str,
    y_name: &str,
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
