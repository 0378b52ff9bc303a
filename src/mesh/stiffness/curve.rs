//! Cubic splines on equally spaced knots, evaluated in constant time.

use std::f64::consts::PI;

/// Knots with values and slopes.
#[derive(Clone, Debug)]
pub struct UniformCurve {
    start: f64,
    spacing: f64,
    knots: Vec<(f64, f64)>,
    /// Coefficients of the cubic between two knots, in multiples of the spacing, lowest power first.
    pieces: Vec<[f64; 4]>,
}

impl UniformCurve {
    /// Creates the natural cubic spline through `values` at start, start + spacing, …. It is constant beyond its ends.
    pub fn new(start: f64, spacing: f64, values: &[f64]) -> Self {
        let n = values.len();
        let mut diagonal = vec![4.0; n];
        (diagonal[0], diagonal[n - 1]) = (2.0, 2.0);
        let rise = |i: usize| 3.0 * (values[(i + 1).min(n - 1)] - values[i.saturating_sub(1)]) / spacing;
        let mut slope: Vec<f64> = (0..n).map(rise).collect();
        for i in 1..n {
            let factor = 1.0 / diagonal[i - 1];
            diagonal[i] -= factor;
            slope[i] -= factor * slope[i - 1];
        }
        slope[n - 1] /= diagonal[n - 1];
        for i in (0..n - 1).rev() {
            slope[i] = (slope[i] - slope[i + 1]) / diagonal[i];
        }
        Self::through(start, spacing, values.iter().copied().zip(slope).collect())
    }

    /// The curve through knots with values and slopes.
    fn through(start: f64, spacing: f64, knots: Vec<(f64, f64)>) -> Self {
        let pieces = knots.windows(2).map(|ends| cubic(ends[0], ends[1], spacing)).collect();
        Self { start, spacing, knots, pieces }
    }

    /// Value and slope at `x`.
    #[inline]
    pub fn at(&self, x: f64) -> (f64, f64) {
        let place = (x - self.start) / self.spacing;
        if place <= 0.0 {
            return (self.knots[0].0, 0.0);
        }
        // The conversion to a signed integer takes fewer instructions than that to an unsigned one.
        let i = place as i64;
        match self.pieces.get(i as usize) {
            Some(piece) => evaluate(piece, place - i as f64, self.spacing),
            None => (self.knots[self.pieces.len()].0, 0.0),
        }
    }

    /// The curve with its values multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let knots = self.knots.iter().map(|(value, slope)| (value * factor, slope * factor)).collect();
        Self::through(self.start, self.spacing, knots)
    }
}

/// A periodic function of the mesh cycle.
#[derive(Clone, Debug)]
pub enum PeriodicCurve {
    /// Mean k̄, and amplitude aₙ and phase pₙ (rad) of each harmonic: k̄ + Σ aₙ cos(2πn·x + pₙ), x in cycles.
    Fourier(f64, Vec<[f64; 2]>),
    /// Values at equally spaced points of the cycle, and the slopes of the periodic cubic spline through them.
    Table(Vec<(f64, f64)>),
}

impl PeriodicCurve {
    /// The periodic cubic spline through `values` at 0, 1/n, 2/n, … of the cycle.
    pub fn table(values: &[f64]) -> Self {
        let n = values.len();
        let rise = |i: usize| 3.0 * (values[(i + 1) % n] - values[(i + n - 1) % n]) * n as f64;
        // Gauss–Seidel on the cyclic system s₋ + 4s + s₊ = rise: every sweep divides the error by four, so that 60 sweeps
        // reach round-off.
        let mut slope: Vec<f64> = (0..n).map(|i| rise(i) / 6.0).collect();
        for _ in 0..60 {
            for i in 0..n {
                slope[i] = (rise(i) - slope[(i + n - 1) % n] - slope[(i + 1) % n]) / 4.0;
            }
        }
        Self::Table(values.iter().copied().zip(slope).collect())
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
                evaluate(&cubic(knots[i], knots[(i + 1) % n], spacing), place - i as f64, spacing)
            }
        }
    }

    /// Mean over the cycle.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Fourier(mean, _) => *mean,
            Self::Table(knots) => knots.iter().map(|knot| knot.0).sum::<f64>() / knots.len() as f64,
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

/// Coefficients of the cubic between two knots, lowest power first, over the fraction of their `spacing`.
#[inline]
fn cubic(left: (f64, f64), right: (f64, f64), spacing: f64) -> [f64; 4] {
    let rise = right.0 - left.0;
    let (m0, m1) = (left.1 * spacing, right.1 * spacing);
    [left.0, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise]
}

/// Value and slope of a cubic at the fraction `s` of the `spacing`.
#[inline]
fn evaluate([value, rise, square, cube]: &[f64; 4], s: f64, spacing: f64) -> (f64, f64) {
    (value + s * (rise + s * (square + s * cube)), (rise + s * (2.0 * square + 3.0 * s * cube)) / spacing)
}
