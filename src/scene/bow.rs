//! Residual bow: the stress-free shape b(x) = b_y + i b_z of a shaft, which rotates with it, and its slope b'(x).

use std::f64::consts::PI;

use num_complex::Complex64;

use super::description::{self, BowShape};
use super::{EntryPath, SceneError, given};
use crate::numerics::{Knot, PiecewiseCubic, Place, spline_slopes};

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
            Self::Points(spline) => ends.extend(spline.0.x.iter().copied().filter(|x| *x > from && *x < to)),
        }
        ends.push(to);
        ends
    }
}

impl Bow {
    pub(super) fn new(given: &description::Bow, length: f64, at: &EntryPath) -> Result<Self, SceneError> {
        let lists = given![given; positions, amplitudes, phases];
        let unused: &[(&'static str, bool)] = match given.shape {
            BowShape::HalfSine | BowShape::Sag => &[&lists[..], &given![given; number]].concat(),
            BowShape::Mode => &lists,
            BowShape::Points => &given![given; amplitude, phase, number],
        };
        at.refuse(unused, "is not a parameter of this shape")?;
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
pub struct Spline(PiecewiseCubic<Complex64>);

impl Spline {
    fn new(x: Vec<f64>, values: Vec<Complex64>) -> Self {
        let slopes = spline_slopes(&x, &values);
        Self(PiecewiseCubic::new(x, values, slopes))
    }

    /// First and last point, m.
    pub fn range(&self) -> [f64; 2] {
        self.0.range()
    }

    /// Deflection, m, and slope at `x`, m.
    pub fn at(&self, x: f64) -> (Complex64, Complex64) {
        let line = |end: f64, knot: Knot<Complex64>| (knot.value + knot.slope * (x - end), knot.slope);
        match self.0.at(x) {
            Place::Before(knot) => line(self.range()[0], knot),
            Place::Within { cubic, fraction, width } => (cubic.value(fraction), cubic.slope(fraction) / width),
            Place::Behind(knot) => line(self.range()[1], knot),
        }
    }

    /// Second derivative, 1/m, at `x`, m.
    pub fn curvature(&self, x: f64) -> Complex64 {
        match self.0.at(x) {
            Place::Within { cubic, fraction, width } => cubic.curvature(fraction) / (width * width),
            Place::Before(_) | Place::Behind(_) => Complex64::ZERO,
        }
    }
}
