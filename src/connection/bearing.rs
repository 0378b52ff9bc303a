//! A bearing whose stiffness or damping depends on the speed of its shaft: f = −K(Ω_s) u − C(Ω_s) u̇ over u = (v, w).
//! Between two shafts Ω_s is the speed of its shaft relative to the other one.
//!
//! Where K and C depend on the frequency of the vibration too, `Model::at_frequency` has the bearing with those of one
//! frequency. A motion in time contains many frequencies: without that, [`SpeedDependentBearing::check`] refuses the bearing.
//!
//! At a constant speed K and C are constant, and `Model::with_tables_at` includes the bearing in the matrices. At a changing
//! speed every evaluation computes K and C for the current speed. The linear motion of the exponential method contains K
//! and C at one speed; the remainder is a load like that of any other connection. The energy ½uᵀKu also changes with K.
//! The drive prescribes the speed and therefore supplies this power: ½uᵀ(∂K/∂Ω_s)u Ω̇_s.

use super::instant::{Instant, InterfaceOptions, Tangent};
use super::{Bounds, Coefficients, Row, along_row};
use crate::scene::{Bearing, BearingCoefficient, EntryPath, Matrix2, SceneError, outside_frequencies, outside_table};

/// A bearing whose coefficients depend on the speed of its shaft or on the frequency of the vibration.
#[derive(Clone, Debug)]
pub struct SpeedDependentBearing {
    /// Index of the bearing in the scene.
    pub number: usize,
    /// The bearing with its tables.
    pub bearing: Bearing,
    /// The scalars v and w: displacements of the shaft relative to what the bearing stands on.
    pub rows: [Row; 2],
    /// Ratio of the speed of its shaft, relative to what it stands on, to the speed of the reference shaft.
    pub ratio: f64,
    /// Index of this speed in [`Model::turning_ratio`](crate::model::Model::turning_ratio).
    pub turning: usize,
}

impl SpeedDependentBearing {
    /// Stiffness and damping with their names.
    fn coefficients(&self) -> [(&'static str, &BearingCoefficient); 2] {
        [("stiffness", &self.bearing.stiffness), ("damping", &self.bearing.damping)]
    }

    /// Refuses a speed of the reference shaft [rad/s] that a table of the bearing does not contain, and tables over the frequency.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed and the range of the table; `turning` says what has the speed.
    pub fn check(&self, speed: f64, turning: &str) -> Result<(), SceneError> {
        let own = (self.ratio * speed).abs();
        for (name, coefficient) in self.coefficients() {
            let message = if coefficient.frequencies().is_empty() {
                coefficient.excludes(own).map(|range| outside_table(range, turning, own))
            } else {
                Some("depends on the frequency of the vibration, and this analysis is not for one frequency: the motion of a run, a steady state or a branch has many; give the coefficients at the frequency of interest, which SpeedTable.at_frequency has".to_owned())
            };
            if let Some(message) = message {
                return Err(EntryPath::entry("bearings", self.number).field(name).error(message));
            }
        }
        Ok(())
    }

    /// Refuses a frequency [rad/s] that a table of the bearing does not contain.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the frequency and the range of the table.
    pub fn check_frequency(&self, frequency: f64) -> Result<(), SceneError> {
        for (name, coefficient) in self.coefficients() {
            if let Some(range) = coefficient.excludes_frequency(frequency) {
                let message = outside_frequencies(range, frequency);
                return Err(EntryPath::entry("bearings", self.number).field(name).error(message));
            }
        }
        Ok(())
    }

    /// Frequencies at the knots of its tables, rad/s.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> {
        self.coefficients().into_iter().flat_map(|(_, coefficient)| coefficient.frequencies()).copied()
    }

    /// Speeds of the reference shaft at the knots of its tables, rad/s; none between shafts of one speed.
    pub fn knots(&self) -> impl Iterator<Item = f64> {
        self.coefficients()
            .into_iter()
            .filter(|_| self.ratio != 0.0)
            .flat_map(|(_, coefficient)| coefficient.speeds())
            .map(|speed| speed / self.ratio.abs())
    }

    /// Whether its tables use their end values at speeds outside their range.
    pub fn holds(&self) -> bool {
        self.bearing.stiffness.holds() && self.bearing.damping.holds()
    }

    /// The two scalars of the bearing for displacements, or their rates for velocities.
    #[inline]
    pub fn scalars(&self, q: &[f64]) -> [f64; 2] {
        self.rows.each_ref().map(|row| along_row(row, q))
    }

    /// Stiffness [N/m] and damping [N s/m] over (v, w) at a speed of the reference shaft, rad/s.
    #[inline]
    pub fn at(&self, speed: f64) -> [Matrix2; 2] {
        self.at_spin(self.ratio * speed)
    }

    /// Stiffness [N/m] and damping [N s/m] over (v, w) at a speed of its own shaft, rad/s.
    #[inline]
    fn at_spin(&self, spin: f64) -> [Matrix2; 2] {
        [self.bearing.stiffness.at(spin), self.bearing.damping.at(spin)]
    }

    /// Stiffness and damping as matrices over the scalars, at a speed of the reference shaft, rad/s.
    pub fn linear(&self, speed: f64) -> Coefficients {
        let [stiffness, damping] = self.at(speed);
        Coefficients::over_two(&stiffness, &damping)
    }

    /// Bounds of the coefficients at all speeds of the tables. The stiffness is relative to the stiffness at `speed`.
    pub fn bounds(&self, speed: f64) -> Bounds {
        let [reference, _] = self.at(speed);
        let largest = |values: &[Matrix2], less: &Matrix2| {
            // Every entry is monotone between two knots, so its largest deviation is at a knot.
            let entry =
                |i: usize, j: usize| values.iter().map(|value| (value[i][j] - less[i][j]).abs()).fold(0.0, f64::max);
            entry(0, 0).hypot(entry(0, 1)).hypot(entry(1, 0).hypot(entry(1, 1)))
        };
        Bounds {
            excess_stiffness: largest(self.bearing.stiffness.extremes(), &reference),
            damping: largest(self.bearing.damping.extremes(), &[[0.0; 2]; 2]),
        }
    }

    /// Force of the shaft on the bearing, components (y, z), N, at a speed of the reference shaft, rad/s.
    #[inline]
    pub fn force(&self, speed: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
        let ([k, c], u, rate) = (self.at(speed), self.scalars(q), self.scalars(v));
        std::array::from_fn(|row| k[row][0] * u[0] + k[row][1] * u[1] + c[row][0] * rate[0] + c[row][1] * rate[1])
    }

    /// Elastic energy ½uᵀKu, J.
    pub fn energy(&self, speed: f64, q: &[f64]) -> f64 {
        let [k, _] = self.at(speed);
        form(&k, self.scalars(q)) / 2.0
    }

    /// Powers, W: the power that the changing stiffness takes from the drive, and the power that damping and
    /// cross-coupling take from the shaft. `speed` (rad/s) and `acceleration` (rad/s²) are those of the reference shaft.
    pub fn powers(&self, speed: f64, acceleration: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
        let ([k, c], u, rate) = (self.at(speed), self.scalars(q), self.scalars(v));
        let own = self.ratio * speed;
        // The table is a function of |Ω_s|.
        let faster = self.ratio * acceleration * own.signum();
        let stiffening = form(&self.bearing.stiffness.slope(own), u) * faster / 2.0;
        let circulating = (k[0][1] - k[1][0]) / 2.0 * (rate[0] * u[1] - rate[1] * u[0]);
        [stiffening, form(&c, rate) + circulating]
    }
}

/// A bearing with speed-dependent coefficients in a run at a changing speed.
#[derive(Clone, Debug)]
pub struct BearingInterface {
    pub(super) bearing: SpeedDependentBearing,
    /// Stiffness, N/m, and damping, N s/m, over (v, w) that the linear motion contains.
    contained: [Matrix2; 2],
    /// Displacements (v, w) at the reference, m.
    reference: [f64; 2],
    /// Generalised forces at the reference with the contained stiffness, N.
    pub(super) reference_force: [f64; 2],
}

impl BearingInterface {
    pub(super) fn new(bearing: &SpeedDependentBearing, options: InterfaceOptions<'_>) -> Self {
        let (contained, reference) = (bearing.at(options.bearing_speed), bearing.scalars(options.reference));
        let reference_force = contained[0].map(|row| -(row[0] * reference[0] + row[1] * reference[1]));
        Self { bearing: bearing.clone(), contained, reference, reference_force }
    }

    /// Stiffness and damping at an instant beyond those that the linear motion contains.
    #[inline]
    fn remainder(&self, instant: &Instant) -> [Matrix2; 2] {
        let mut remainder = self.bearing.at_spin(instant.phases[0].spin);
        for (value, contained) in remainder.as_flattened_mut().iter_mut().zip(self.contained.as_flattened()) {
            for (value, contained) in value.iter_mut().zip(contained) {
                *value -= contained;
            }
        }
        remainder
    }

    #[inline]
    pub(super) fn load(
        &self,
        instant: &Instant,
        u: &[f64],
        rates: &[f64],
        load: &mut [f64],
        tangent: Option<Tangent<'_>>,
    ) {
        let [stiffness, damping] = self.remainder(instant);
        let displacement = [self.reference[0] + u[0], self.reference[1] + u[1]];
        for ((k, c), load) in stiffness.iter().zip(&damping).zip(load) {
            *load = -(k[0] * displacement[0] + k[1] * displacement[1] + c[0] * rates[0] + c[1] * rates[1]);
        }
        if let Some(tangent) = tangent {
            tangent.stiffness.copy_from_slice(stiffness.as_flattened());
            tangent.damping.copy_from_slice(damping.as_flattened());
        }
    }
}

/// Quadratic form uᵀku.
fn form(k: &Matrix2, u: [f64; 2]) -> f64 {
    k[0][0] * u[0] * u[0] + (k[0][1] + k[1][0]) * u[0] * u[1] + k[1][1] * u[1] * u[1]
}
