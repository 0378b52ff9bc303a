//! Cubic splines on equally spaced knots, evaluated in constant time.

use std::f64::consts::PI;

use crate::numerics::{Cubic, Knot, natural_slopes, periodic_slopes};

/// A natural cubic spline on equally spaced knots. It is constant beyond its ends.
#[derive(Clone, Debug)]
pub struct UniformCurve {
    start: f64,
    spacing: f64,
    first: f64,
    last: f64,
    /// The polynomials between the knots. Stored, they take fewer operations.
    pieces: Vec<Cubic<f64>>,
}

impl UniformCurve {
    /// The curve through `values` at start, start + spacing, …
    pub fn new(start: f64, spacing: f64, values: &[f64]) -> Self {
        let slopes = natural_slopes(values, spacing);
        let knots: Vec<_> = values.iter().zip(slopes).map(|(value, slope)| Knot { value: *value, slope }).collect();
        let pieces = knots.windows(2).map(|ends| Cubic::between(ends[0], ends[1], spacing)).collect();
        Self { start, spacing, first: values[0], last: values[values.len() - 1], pieces }
    }

    /// Value and slope at `x`.
    #[inline]
    pub fn at(&self, x: f64) -> (f64, f64) {
        let place = (x - self.start) / self.spacing;
        if place <= 0.0 {
            return (self.first, 0.0);
        }
        // The conversion to a signed integer takes fewer instructions than that to an unsigned one.
        let i = place as i64;
        match self.pieces.get(i as usize) {
            Some(piece) => {
                let s = place - i as f64;
                (piece.value(s), piece.slope(s) / self.spacing)
            }
            None => (self.last, 0.0),
        }
    }

    /// The curve with its values multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let scaled = |piece: Cubic<f64>| Cubic { coefficients: piece.coefficients.map(|value| value * factor) };
        Self {
            first: self.first * factor,
            last: self.last * factor,
            pieces: self.pieces.into_iter().map(scaled).collect(),
            ..self
        }
    }
}

/// A periodic function of the mesh cycle.
#[derive(Clone, Debug)]
pub enum PeriodicCurve {
    /// Mean k̄, and amplitude aₙ and phase pₙ (rad) of each harmonic: k̄ + Σ aₙ cos(2πn·x + pₙ), x in cycles.
    Fourier(f64, Vec<[f64; 2]>),
    /// The periodic cubic spline through equally spaced points of the cycle.
    Table(Vec<Knot<f64>>),
}

impl PeriodicCurve {
    /// The periodic cubic spline through `values` at 0, 1/n, 2/n, … of the cycle.
    pub fn table(values: &[f64]) -> Self {
        let slopes = periodic_slopes(values, 1.0 / values.len() as f64);
        Self::Table(values.iter().zip(slopes).map(|(value, slope)| Knot { value: *value, slope }).collect())
    }

    /// Value and slope per cycle at `x` cycles.
    #[inline]
    pub fn at(&self, x: f64) -> (f64, f64) {
        let x = x - x.floor();
        match self {
            Self::Fourier(mean, harmonics) => {
                let mut sum = (*mean, 0.0);
                for (n, [amplitude, phase]) in harmonics.iter().enumerate() {
                    let order = 2.0 * PI * (n + 1) as f64;
                    let (sin, cos) = (order * x + phase).sin_cos();
                    sum.0 += amplitude * cos;
                    sum.1 -= amplitude * order * sin;
                }
                sum
            }
            Self::Table(knots) => {
                let n = knots.len();
                let place = x * n as f64;
                let i = (place as usize).min(n - 1);
                let spacing = 1.0 / n as f64;
                let (cubic, s) = (Cubic::between(knots[i], knots[(i + 1) % n], spacing), place - i as f64);
                (cubic.value(s), cubic.slope(s) / spacing)
            }
        }
    }

    /// Mean over the cycle.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Fourier(mean, _) => *mean,
            Self::Table(knots) => knots.iter().map(|knot| knot.value).sum::<f64>() / knots.len() as f64,
        }
    }

    /// The smallest of at least 1000 samples.
    pub fn smallest(&self) -> f64 {
        self.samples().fold(f64::INFINITY, f64::min)
    }

    /// The largest of at least 1000 samples.
    pub fn largest(&self) -> f64 {
        self.samples().fold(0.0, f64::max)
    }

    /// Values at equally spaced points of the cycle: at least 1000, and at least 16 in a period of the highest harmonic
    /// or 4 in a piece of the spline.
    fn samples(&self) -> impl Iterator<Item = f64> {
        let count = match self {
            Self::Fourier(_, harmonics) => 16 * harmonics.len(),
            Self::Table(knots) => 4 * knots.len(),
        };
        let count = count.max(1000);
        (0..count).map(move |i| self.at(i as f64 / count as f64).0)
    }
}
