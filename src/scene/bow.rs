//! Residual bow: the stress-free shape b(x) = b_y + i b_z of a shaft, which rotates with it, and its slope b'(x).

use std::f64::consts::PI;

use num_complex::Complex64;

use super::description::{self, BowShape};
use super::{EntryPath, SceneError};

/// A checked residual bow.
#[derive(Clone, Debug)]
pub enum Bow {
    /// A given curve.
    Curve(BowCurve),
    /// The static sag of the shaft between its bearings, scaled to `amplitude`.
    Sag {
        /// Largest deflection, m, with its angle in the rotating shaft.
        amplitude: Complex64,
    },
}

/// A bow that is a known function of the position.
#[derive(Clone, Debug)]
pub enum BowCurve {
    /// A sine of n half waves, `amplitude`·sin(nπx/L).
    Waves {
        /// Largest deflection, m, with its angle in the rotating shaft.
        amplitude: Complex64,
        /// Wave number nπ/L, 1/m.
        wave_number: f64,
    },
    /// A cubic spline through measured points.
    Points(Spline),
}

impl BowCurve {
    /// Deflection, m, and slope at `x`, m.
    pub fn at(&self, x: f64) -> (Complex64, Complex64) {
        match self {
            Self::Waves { amplitude, wave_number } => {
                let (sin, cos) = (wave_number * x).sin_cos();
                (*amplitude * sin, *amplitude * (wave_number * cos))
            }
            Self::Points(spline) => spline.at(x),
        }
    }

    /// Second derivative, 1/m, at `x`, m.
    pub fn curvature(&self, x: f64) -> Complex64 {
        match self {
            Self::Waves { amplitude, wave_number } => {
                *amplitude * (-wave_number * wave_number * (wave_number * x).sin())
            }
            Self::Points(spline) => spline.curvature(x),
        }
    }

    /// Ends of the pieces of an interval, ascending from `from` to `to`, m, within which a polynomial of low degree
    /// represents the curvature of the bow.
    pub fn pieces(&self, from: f64, to: f64) -> Vec<f64> {
        let mut ends = vec![from];
        match self {
            Self::Waves { wave_number, .. } => {
                // A piece is at most as long as an angle of one radian.
                let count = (wave_number * (to - from)).ceil().max(1.0);
                let piece = (to - from) / count;
                ends.extend((1..count as usize).map(|i| from + piece * i as f64));
            }
            Self::Points(spline) => ends.extend(spline.x.iter().copied().filter(|x| *x > from && *x < to)),
        }
        ends.push(to);
        ends
    }
}

impl Bow {
    pub(super) fn new(given: &description::Bow, length: f64, at: &EntryPath) -> Result<Self, SceneError> {
        let lists = [
            ("positions", given.positions.is_some()),
            ("amplitudes", given.amplitudes.is_some()),
            ("phases", given.phases.is_some()),
        ];
        let scalars = [("amplitude", given.amplitude.is_some()), ("phase", given.phase.is_some())];
        let number = [("number", given.number.is_some())];
        let unused: Vec<_> = match given.shape {
            BowShape::HalfSine | BowShape::Sag => lists.iter().chain(&number).collect(),
            BowShape::Mode => lists.iter().collect(),
            BowShape::Points => scalars.iter().chain(&number).collect(),
        };
        if let Some((name, _)) = unused.iter().find(|(_, given)| *given) {
            return Err(at.field(name).error("is not a parameter of this shape"));
        }
        if given.shape == BowShape::Points {
            return Ok(Self::Curve(BowCurve::Points(points(given, length, at)?)));
        }
        let amplitude = given.amplitude.ok_or_else(|| at.error("needs amplitude"))?;
        let amplitude = at.field("amplitude").finite(amplitude)?;
        let phase = at.field("phase").finite(given.phase.unwrap_or(0.0))?;
        let amplitude = Complex64::from_polar(1.0, phase) * amplitude;
        let number = match given.shape {
            BowShape::Sag => return Ok(Self::Sag { amplitude }),
            BowShape::Mode => given.number.ok_or_else(|| at.error("needs number"))?,
            _ => 1,
        };
        if number == 0 {
            return Err(at.field("number").error("must be at least 1, got 0"));
        }
        Ok(Self::Curve(BowCurve::Waves { amplitude, wave_number: f64::from(number) * PI / length }))
    }
}

fn points(given: &description::Bow, length: f64, at: &EntryPath) -> Result<Spline, SceneError> {
    let positions = given.positions.as_ref().ok_or_else(|| at.error("needs positions"))?;
    let amplitudes = given.amplitudes.as_ref().ok_or_else(|| at.error("needs amplitudes"))?;
    let zeros = vec![0.0; positions.len()];
    let phases = given.phases.as_ref().unwrap_or(&zeros);
    for (name, list) in [("amplitudes", amplitudes), ("phases", phases)] {
        if list.len() != positions.len() {
            return Err(at.field(name).error(format!("has {} entries for {} positions", list.len(), positions.len())));
        }
    }
    if positions.len() < 2 {
        return Err(at.field("positions").error(format!("at least two points are needed, got {}", positions.len())));
    }
    let mut values = Vec::with_capacity(positions.len());
    let list = at.field("positions");
    for (index, x) in positions.iter().enumerate() {
        let place = list.index(index);
        place.finite(*x)?;
        if *x < -1e-9 * length || *x > length * (1.0 + 1e-9) {
            let millimetres = *x > 10.0 * length && x / 1e3 <= length * (1.0 + 1e-9);
            return Err(place.error(format!(
                "{x} m is outside the shaft, which is {length} m long{}",
                if millimetres { "; is it in millimetres?" } else { "" }
            )));
        }
        if index > 0 && *x <= positions[index - 1] {
            return Err(place
                .error(format!("must be larger than the previous position, {} m, got {x} m", positions[index - 1])));
        }
        let amplitude = at.field("amplitudes").index(index).finite(amplitudes[index])?;
        let phase = at.field("phases").index(index).finite(phases[index])?;
        values.push(Complex64::from_polar(1.0, phase) * amplitude);
    }
    Ok(Spline::new(positions.clone(), values))
}

/// A cubic spline through complex points with not-a-knot ends; a parabola through three points, a line through two.
/// It is extrapolated as a straight line: a straight part adds no curvature where nothing was measured.
#[derive(Clone, Debug)]
pub struct Spline {
    x: Vec<f64>,
    value: Vec<Complex64>,
    slope: Vec<Complex64>,
}

impl Spline {
    fn new(x: Vec<f64>, value: Vec<Complex64>) -> Self {
        let slope = slopes(&x, &value);
        Self { x, value, slope }
    }

    /// First and last point, m.
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// Deflection, m, and slope at `x`, m.
    pub fn at(&self, x: f64) -> (Complex64, Complex64) {
        let last = self.x.len() - 1;
        if x <= self.x[0] || x >= self.x[last] {
            let end = if x <= self.x[0] { 0 } else { last };
            return (self.value[end] + self.slope[end] * (x - self.x[end]), self.slope[end]);
        }
        let Cubic { value, m0, square, cube, h, s } = self.cubic(x);
        let value = value + (m0 + (square + cube * s) * s) * s;
        (value, (m0 + (square * 2.0 + cube * (3.0 * s)) * s) / h)
    }

    /// Second derivative, 1/m, at `x`, m.
    pub fn curvature(&self, x: f64) -> Complex64 {
        if x <= self.x[0] || x >= self.x[self.x.len() - 1] {
            return Complex64::ZERO;
        }
        let Cubic { square, cube, h, s, .. } = self.cubic(x);
        (square * 2.0 + cube * (6.0 * s)) / (h * h)
    }

    /// The polynomial around `x`, m, between the first and the last point.
    fn cubic(&self, x: f64) -> Cubic {
        let i = self.x.partition_point(|knot| *knot <= x) - 1;
        let h = self.x[i + 1] - self.x[i];
        let s = (x - self.x[i]) / h;
        let rise = self.value[i + 1] - self.value[i];
        // Hermite form: value = v₀ + s·h·m₀ + s²(3·rise − h(2m₀ + m₁)) + s³(h(m₀ + m₁) − 2·rise).
        let (m0, m1) = (self.slope[i] * h, self.slope[i + 1] * h);
        let (square, cube) = (rise * 3.0 - m0 * 2.0 - m1, m0 + m1 - rise * 2.0);
        Cubic { value: self.value[i], m0, square, cube, h, s }
    }
}

/// A piece of a spline: value + m₀ s + square·s² + cube·s³ at the fraction `s` of its length `h`, m.
struct Cubic {
    value: Complex64,
    m0: Complex64,
    square: Complex64,
    cube: Complex64,
    h: f64,
    s: f64,
}

/// Slopes at the knots for a continuous second derivative (de Boor, A Practical Guide to Splines, chapter IV).
fn slopes(x: &[f64], value: &[Complex64]) -> Vec<Complex64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let d: Vec<Complex64> = value.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / *h).collect();
    if n == 2 {
        return vec![d[0]; 2];
    }
    if n == 3 {
        let curvature = (d[1] - d[0]) / (h[0] + h[1]);
        return vec![d[0] - curvature * h[0], d[0] + curvature * h[0], d[1] + curvature * h[1]];
    }
    let mut lower = vec![0.0; n];
    let mut diagonal = vec![0.0; n];
    let mut upper = vec![0.0; n];
    let mut right = vec![Complex64::ZERO; n];
    diagonal[0] = h[1];
    upper[0] = h[0] + h[1];
    right[0] = (d[0] * ((h[0] + 2.0 * upper[0]) * h[1]) + d[1] * (h[0] * h[0])) / upper[0];
    for i in 1..n - 1 {
        lower[i] = h[i];
        diagonal[i] = 2.0 * (h[i - 1] + h[i]);
        upper[i] = h[i - 1];
        right[i] = (d[i - 1] * h[i] + d[i] * h[i - 1]) * 3.0;
    }
    let (a, b) = (h[n - 2], h[n - 3]);
    diagonal[n - 1] = b;
    lower[n - 1] = a + b;
    right[n - 1] = (d[n - 3] * (a * a) + d[n - 2] * ((2.0 * (a + b) + a) * b)) / (a + b);
    for i in 1..n {
        let factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        let previous = right[i - 1];
        right[i] -= previous * factor;
    }
    let mut slope = vec![Complex64::ZERO; n];
    slope[n - 1] = right[n - 1] / diagonal[n - 1];
    for i in (0..n - 1).rev() {
        slope[i] = (right[i] - slope[i + 1] * upper[i]) / diagonal[i];
    }
    slope
}
