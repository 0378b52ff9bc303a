//! A load that depends on time, on the angle of its shaft or on its actual speed.
//!
//! ```text
//! F(t)                 force or torque over time
//! F e^{inϑ_s}          force that turns at n times the speed of its shaft
//! T(|Ω_s + θ̇|)         torque over the actual speed of its shaft
//! ```
//!
//! It takes part in the stage equations of the exponential method as any other connection, so that the error estimate
//! covers it. A torque over the speed has the linear damping −∂T/∂ω at the prescribed speed.

use nalgebra::DMatrix;

use num_complex::Complex64;

use super::instant::{Instant, InterfaceOptions, Tangent};
use super::{Bounds, Coefficients, Row, along_row};
use crate::scene::{LoadLaw, SceneError, excluding, outside_table};

/// A load that depends on time, angle or speed.
#[derive(Clone, Debug)]
pub struct AppliedLoad {
    /// Path of its value in the scene.
    pub path: String,
    /// The scalars: v and w of its node, or the twist.
    pub rows: Vec<Row>,
    /// Index of its shaft.
    pub shaft: usize,
    /// Ratio of the speed of its shaft to that of the reference shaft.
    pub ratio: f64,
    /// Its law.
    pub law: LoadLaw,
}

impl AppliedLoad {
    /// Load on the scalars, N or N m, at an instant; `rate` is the first scalar's rate. Entries beyond the number of
    /// scalars are zero.
    #[inline]
    pub fn value(&self, instant: &Instant, rate: f64) -> [f64; 2] {
        let phase = &instant.phases[0];
        match &self.law {
            LoadLaw::Force(parts) => parts.each_ref().map(|part| part.at(instant.time)[0]),
            LoadLaw::Turning { amplitude, order } => {
                let force = amplitude * Complex64::from_polar(1.0, order * phase.angle);
                [force.re, force.im]
            }
            LoadLaw::Torque(curve) => [curve.at(instant.time)[0], 0.0],
            LoadLaw::SpeedTorque { curve, .. } => [curve.at((phase.spin + rate).abs())[0], 0.0],
        }
    }

    /// Constant part of the load on the scalars in an equilibrium at a speed of the reference shaft, rad/s: the torque at
    /// this speed; zero for other loads.
    pub fn constant(&self, speed: f64) -> f64 {
        match &self.law {
            LoadLaw::SpeedTorque { curve, .. } => curve.at((self.ratio * speed).abs())[0],
            _ => 0.0,
        }
    }

    /// ∂T/∂θ̇ of the load at the actual speed `spin` of its shaft, rad/s.
    fn slope(&self, spin: f64) -> f64 {
        match &self.law {
            LoadLaw::SpeedTorque { curve, .. } => curve.at(spin.abs())[1] * if spin < 0.0 { -1.0 } else { 1.0 },
            _ => 0.0,
        }
    }

    /// No stiffness, and the damping −∂T/∂θ̇ at a speed of the reference shaft, rad/s.
    pub fn linear(&self, speed: f64) -> Coefficients {
        let count = self.rows.len();
        let damping = DMatrix::from_diagonal_element(count, count, -self.slope(self.ratio * speed));
        Coefficients { stiffness: DMatrix::zeros(count, count), damping }
    }

    /// Bounds for the step limit of Runge–Kutta methods.
    pub fn bounds(&self) -> Bounds {
        let damping = match &self.law {
            LoadLaw::SpeedTorque { curve, .. } => curve.steepest(),
            _ => 0.0,
        };
        Bounds { excess_stiffness: 0.0, damping }
    }

    /// Refuses a speed of the reference shaft, rad/s, that its table does not contain.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed of the shaft and the range of the table.
    pub fn check(&self, speed: f64) -> Result<(), SceneError> {
        if let LoadLaw::SpeedTorque { curve, holds: false } = &self.law {
            let own = (self.ratio * speed).abs();
            if let Some(range) = excluding(curve.range(), own) {
                return Err(SceneError::new(&self.path, outside_table(range, "the shaft", own)));
            }
        }
        Ok(())
    }

    /// Rate of the first scalar for velocities v.
    #[inline]
    pub fn rate(&self, v: &[f64]) -> f64 {
        along_row(&self.rows[0], v)
    }

    /// Adds the load to the generalised forces.
    #[inline]
    pub fn apply(&self, instant: &Instant, v: &[f64], out: &mut [f64]) {
        for (row, value) in self.rows.iter().zip(self.value(instant, self.rate(v))) {
            row.iter().for_each(|(index, coefficient)| out[*index] += coefficient * value);
        }
    }

    /// Power of the load, W.
    pub fn power(&self, instant: &Instant, v: &[f64]) -> f64 {
        self.rows.iter().zip(self.value(instant, self.rate(v))).map(|(row, value)| value * along_row(row, v)).sum()
    }
}

/// A load in a run.
#[derive(Clone, Debug)]
pub struct LoadInterface {
    pub(super) load: AppliedLoad,
    /// Loads at the reference, N or N m.
    pub(super) reference_force: Vec<f64>,
    /// Damping that the linear motion contains, N m s/rad.
    contained: f64,
}

impl LoadInterface {
    pub(super) fn new(load: &AppliedLoad, options: InterfaceOptions<'_>) -> Self {
        let mut reference_force = vec![0.0; load.rows.len()];
        reference_force[0] = load.constant(options.speed);
        let contained = if options.contained { load.linear(options.speed).damping[(0, 0)] } else { 0.0 };
        Self { load: load.clone(), reference_force, contained }
    }

    pub(super) fn has_rates(&self) -> bool {
        matches!(self.load.law, LoadLaw::SpeedTorque { .. })
    }

    pub(super) fn is_affine(&self) -> bool {
        matches!(self.load.law, LoadLaw::Torque(_))
    }

    #[inline]
    pub(super) fn load(&self, instant: &Instant, rates: &[f64], load: &mut [f64], tangent: Option<Tangent<'_>>) {
        let rate = rates.first().copied().unwrap_or(0.0);
        for (i, (load, value)) in load.iter_mut().zip(self.load.value(instant, rate)).enumerate() {
            *load = value - self.reference_force[i];
        }
        load[0] += self.contained * rate;
        if let Some(Tangent { stiffness, damping }) = tangent {
            stiffness.fill(0.0);
            let slope =
                if self.has_rates() { self.load.slope(instant.phases[0].spin + rate) + self.contained } else { 0.0 };
            damping.fill(-slope);
        }
    }
}
