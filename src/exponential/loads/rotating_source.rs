//! The synchronous motion that rotating loads cause at a constant speed.

use nalgebra::{Complex, DMatrix};
use num_complex::Complex64;

use crate::modal::ModalStateSpace;
use crate::motion::RotatingLoad;

/// Relative distance of an eigenvalue from iΩ below which a shaft is resonant. Nearer to resonance, the synchronous motion
/// would lose more than five digits.
const RESONANCE_DISTANCE: f64 = 1e-5;

/// Adds the real parts of amplitudes times a phasor to `values`.
#[inline]
pub(super) fn add_rotated(amplitudes: &[Complex64], phasor: Complex64, values: &mut [f64]) {
    for (value, amplitude) in values.iter_mut().zip(amplitudes) {
        *value += amplitude.re * phasor.re - amplitude.im * phasor.im;
    }
}

/// Whether a shaft with this angular velocity, rad/s, runs at an undamped critical speed, without a synchronous motion.
pub fn is_resonant(linear: &ModalStateSpace, spin: f64) -> bool {
    linear.resonance_distance(spin) < RESONANCE_DISTANCE * spin.abs()
}

/// Synchronous amplitudes of all displacements, one column for each source; zero at resonance. `synchronous` has the
/// same columns.
pub(in crate::exponential) fn synchronous_amplitudes(
    linear: &ModalStateSpace,
    sources: &[RotatingLoad],
    synchronous: &DMatrix<Complex<f64>>,
) -> DMatrix<Complex<f64>> {
    let mut amplitudes = DMatrix::zeros(synchronous.nrows(), sources.len());
    for (index, _) in sources.iter().enumerate().filter(|(_, source)| !is_resonant(linear, source.spin)) {
        amplitudes.set_column(index, &synchronous.column(index));
    }
    amplitudes
}

/// Synchronous amplitudes of the interface scalars and, where needed, of their rates, source after source.
pub(in crate::exponential) fn interface_amplitudes(
    sources: &[RotatingLoad],
    kinds: &[bool],
    entries: &[Vec<(usize, f64)>],
    amplitudes: &DMatrix<Complex<f64>>,
) -> Vec<Complex64> {
    let mut values = Vec::new();
    for (index, source) in sources.iter().enumerate() {
        for rate in kinds {
            values.extend(entries.iter().map(|entry| {
                let value: Complex64 = entry.iter().map(|(i, factor)| amplitudes[(*i, index)] * *factor).sum();
                if *rate { value * Complex64::new(0.0, source.spin) } else { value }
            }));
        }
    }
    values
}
