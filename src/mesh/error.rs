//! Unloaded transmission error e(t): harmonics of the mesh and of both shafts, and a table over the mesh cycle.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::contact::ShaftPhase;
use super::stiffness::PeriodicCurve;
use crate::scene::TransmissionError;

/// Transmission error that can be evaluated at any shaft angle.
#[derive(Clone, Debug)]
pub(super) struct ErrorCurve {
    harmonics: [(PeriodicCurve, f64); 3],
    table: Option<PeriodicCurve>,
    teeth: f64,
}

impl ErrorCurve {
    /// Creates the transmission error of a mesh; `teeth` is the number of teeth of the driver.
    pub fn new(given: &TransmissionError, teeth: u32) -> Self {
        let teeth = f64::from(teeth);
        let of = |harmonics: &Vec<[f64; 2]>| PeriodicCurve::Fourier(0.0, harmonics.clone());
        Self {
            harmonics: [(of(&given.tooth), teeth), (of(&given.driver), 1.0), (of(&given.driven), 1.0)],
            table: (!given.table.is_empty()).then(|| PeriodicCurve::table(&given.table)),
            teeth,
        }
    }

    /// Part of the transmission error that has the period of the teeth, m, at an angle of the driver, rad.
    pub fn of_teeth(&self, angle: f64) -> f64 {
        let cycles = self.teeth * angle / (2.0 * PI);
        let [(harmonics, _), ..] = &self.harmonics;
        harmonics.at(cycles).0 + self.table.as_ref().map_or(0.0, |table| table.at(cycles).0)
    }

    /// Phasor of the first harmonic of the shaft of the driver, 0, or of the driven gear, 1, m.
    pub fn first_of_shaft(&self, gear: usize) -> Complex64 {
        match &self.harmonics[1 + gear].0 {
            PeriodicCurve::Fourier(_, harmonics) => {
                harmonics.first().map_or(Complex64::ZERO, |[size, phase]| Complex64::from_polar(*size, *phase))
            }
            _ => Complex64::ZERO,
        }
    }

    /// Transmission error e, m, and its rate, m/s.
    pub fn at(&self, phases: &[ShaftPhase; 2]) -> (f64, f64) {
        let [driver, driven] = phases;
        let mut sum = (0.0, 0.0);
        let mut add = |cycle: &PeriodicCurve, order: f64, phase: &ShaftPhase| {
            let (value, slope) = cycle.at(order * phase.angle / (2.0 * PI));
            sum.0 += value;
            sum.1 += slope * order * phase.spin / (2.0 * PI);
        };
        for ((cycle, order), phase) in self.harmonics.iter().zip([driver, driver, driven]) {
            add(cycle, *order, phase);
        }
        if let Some(table) = &self.table {
            add(table, self.teeth, driver);
        }
        sum
    }
}
