//! Linear response to what turns with the shafts, without time stepping.
//!
//! Shaft s excites at its own speed Ω_s: [K + iΩ_s(C + ΩG) − Ω_s²M] a = f_s, and the motion is Re(a e^{iϑ_s}). A gear
//! carries as many lines as there are shafts.

use nalgebra::{Complex, DMatrix, DVector};

use super::AnalysisError;
use crate::linalg::solve_complex;
use crate::modal::Basis;

/// Amplitudes a at `speed` of shaft after shaft as the source, one a column, in the inside order; the meshes are
/// linearised at rest.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found.
pub fn synchronous(basis: &Basis, speed: f64) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    with_flanks(basis, speed, speed)
}

/// The same with the flanks that carry at the speed `carrying`: at rest no speed says which.
pub(super) fn with_flanks(basis: &Basis, speed: f64, carrying: f64) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    let model = &basis.model;
    let mut amplitudes = DMatrix::zeros(model.len(), model.shafts.len());
    if model.shafts.iter().all(|shaft| shaft.excitations.is_empty()) {
        return Ok(amplitudes);
    }
    for (source, _) in model.shafts.iter().enumerate().filter(|(_, shaft)| !shaft.excitations.is_empty()) {
        amplitudes.set_column(source, &synchronous_of(basis, speed, carrying, source)?);
    }
    Ok(amplitudes)
}

/// Amplitudes a at `speed` of one shaft as the source, with the flanks that carry at the speed `carrying`.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found.
pub(super) fn synchronous_of(
    basis: &Basis,
    speed: f64,
    carrying: f64,
    source: usize,
) -> Result<DVector<Complex<f64>>, AnalysisError> {
    let model = &basis.model;
    let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(carrying));
    let rate = basis.damping_matrix(carrying)? + model.gyroscopic_matrix() * speed;
    let shaft = &model.shafts[source];
    let spin = shaft.ratio * speed;
    let mut dynamic = DMatrix::from_fn(model.len(), model.len(), |i, j| {
        Complex::new(stiffness[(i, j)] - spin * spin * mass[(i, j)], spin * rate[(i, j)])
    });
    if spin == 0.0 {
        // At rest null motions have no stiffness; the bow, which bends alone, does not drive them either.
        let real = basis.real_modes(carrying)?;
        let weighted = &mass * real.vectors.columns(0, real.null);
        let held = real.frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
        dynamic += (&weighted * weighted.transpose() * (held * held)).map(|value| Complex::new(value, 0.0));
    }
    let mut force = DMatrix::zeros(model.len(), 1);
    for excitation in &shaft.excitations {
        // v = Re(A e^{iϑ}) and w = Im(A e^{iϑ}) = Re(−iA e^{iϑ}).
        let amplitude = excitation.amplitude(spin, 0.0);
        force[(excitation.index, 0)] += amplitude;
        force[(excitation.index + 1, 0)] -= amplitude * Complex::i();
    }
    Ok(solve_complex(&dynamic, &force).column(0).into_owned())
}

/// Displacement and velocity of the synchronous motion where shaft s stands at e^{iϑ} = `turns[s]`.
pub(super) fn motion(
    basis: &Basis,
    speed: f64,
    amplitudes: &DMatrix<Complex<f64>>,
    turns: &[Complex<f64>],
) -> (DVector<f64>, DVector<f64>) {
    let n = basis.model.len();
    let (mut q, mut v) = (DVector::zeros(n), DVector::zeros(n));
    for (source, turn) in turns.iter().enumerate() {
        let spin = basis.model.shafts[source].ratio * speed;
        for (index, amplitude) in amplitudes.column(source).iter().enumerate() {
            let turned = amplitude * turn;
            q[index] += turned.re;
            v[index] -= spin * turned.im;
        }
    }
    (q, v)
}
