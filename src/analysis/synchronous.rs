//! ModalStateSpace response to what turns with the shafts, without time stepping.
//!
//! Shaft s excites at its own speed Ω_s: [K + iΩ_s(C + ΩG) − Ω_s²M] a = f_s, and the motion is Re(a e^{iϑ_s}). A gear
//! carries as many lines as there are shafts.

use nalgebra::{Complex, DMatrix, DVector};

use super::AnalysisError;
use crate::linalg::solve_complex;
use crate::modal::CachedModel;
use crate::model::{Excitation, Model};
use crate::scene::Node;

/// What turns with a shaft and is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExcitationPart {
    /// Bow and unbalance.
    #[default]
    Both,
    /// The bow alone.
    Bow,
    /// Unbalance alone.
    Unbalance,
}

/// Amplitudes a at `speed` of shaft after shaft as the source, one a column, in the inside order; the meshes are
/// linearised at rest.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found.
pub fn synchronous(
    cached: &CachedModel,
    speed: f64,
    part: ExcitationPart,
) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    let columns = (0..cached.model.shafts.len()).map(|source| synchronous_of(cached, speed, speed, source, part));
    Ok(DMatrix::from_columns(&columns.collect::<Result<Vec<_>, _>>()?))
}

/// The bow b e^{iϑ} of every shaft as amplitudes over its own coordinates, in the inside order: what it would be if
/// nothing bent it.
pub fn bow(model: &Model) -> DVector<Complex<f64>> {
    let mut amplitudes = DVector::zeros(model.len());
    for shaft in &model.shafts {
        if let (Some(chain), Some(bow)) = (&shaft.bending, &shaft.bow) {
            for (index, value) in bow.iter().enumerate() {
                amplitudes[chain.start + 2 * index] = *value;
                amplitudes[chain.start + 2 * index + 1] = -value * Complex::i();
            }
        }
    }
    amplitudes
}

/// Amplitudes of the force over (y, z) on the bearings of `nodes`, N, where a shaft of speed `spin` excites the motion.
pub fn bearing_forces(
    model: &Model,
    nodes: &[Node],
    spin: f64,
    amplitudes: &DVector<Complex<f64>>,
) -> Vec<[Complex<f64>; 2]> {
    let part = |part: fn(&Complex<f64>) -> f64| amplitudes.iter().map(part).collect::<Vec<_>>();
    let (re, im) = (part(|value| value.re), part(|value| value.im));
    // q̇ = Re(iω a e^{iϑ}): in phase −ω Im a, a quarter turn ahead ω Re a.
    let rate = |part: &[f64], factor: f64| part.iter().map(|value| factor * value).collect::<Vec<_>>();
    let (rate_re, rate_im) = (rate(&im, -spin), rate(&re, spin));
    let force = |node: &Node| {
        let (re, im) = (model.bearing_force(*node, &re, &rate_re), model.bearing_force(*node, &im, &rate_im));
        [0, 1].map(|row| Complex::new(re[row], im[row]))
    };
    nodes.iter().map(force).collect()
}

/// The amplitudes of bow and unbalance with the flanks that carry at the speed `carrying`: at rest no speed says which.
pub(super) fn with_flanks(
    cached: &CachedModel,
    speed: f64,
    carrying: f64,
) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    let model = &cached.model;
    let mut amplitudes = DMatrix::zeros(model.len(), model.shafts.len());
    if model.shafts.iter().all(|shaft| shaft.excitations.is_empty()) {
        return Ok(amplitudes);
    }
    for (source, _) in model.shafts.iter().enumerate().filter(|(_, shaft)| !shaft.excitations.is_empty()) {
        amplitudes.set_column(source, &synchronous_of(cached, speed, carrying, source, ExcitationPart::Both)?);
    }
    Ok(amplitudes)
}

/// Amplitudes a at `speed` of one shaft as the source, with the flanks that carry at the speed `carrying`.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found.
pub(super) fn synchronous_of(
    cached: &CachedModel,
    speed: f64,
    carrying: f64,
    source: usize,
    part: ExcitationPart,
) -> Result<DVector<Complex<f64>>, AnalysisError> {
    let model = &cached.model;
    let shaft = &model.shafts[source];
    let spin = shaft.ratio * speed;
    let acting = |excitation: &Excitation| match part {
        ExcitationPart::Both => excitation.amplitude(spin, 0.0),
        ExcitationPart::Bow => excitation.bow,
        ExcitationPart::Unbalance => excitation.unbalance_amplitude(spin, 0.0),
    };
    if shaft.excitations.iter().all(|excitation| acting(excitation) == Complex::ZERO) {
        return Ok(DVector::zeros(model.len()));
    }
    let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(carrying));
    let rate = cached.damping_matrix(carrying)? + model.gyroscopic_matrix() * speed;
    let mut dynamic = DMatrix::from_fn(model.len(), model.len(), |i, j| {
        Complex::new(stiffness[(i, j)] - spin * spin * mass[(i, j)], spin * rate[(i, j)])
    });
    if spin == 0.0 {
        // At rest null motions have no stiffness; the bow, which bends alone, does not drive them either.
        let real = cached.real_modes(carrying)?;
        let weighted = &mass * real.vectors.columns(0, real.null);
        let held = real.frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
        dynamic += (&weighted * weighted.transpose() * (held * held)).map(|value| Complex::new(value, 0.0));
    }
    let mut force = DMatrix::zeros(model.len(), 1);
    for excitation in &shaft.excitations {
        // v = Re(A e^{iϑ}) and w = Im(A e^{iϑ}) = Re(−iA e^{iϑ}).
        let amplitude = acting(excitation);
        force[(excitation.index, 0)] += amplitude;
        force[(excitation.index + 1, 0)] -= amplitude * Complex::i();
    }
    Ok(solve_complex(&dynamic, &force).column(0).into_owned())
}

/// Displacement and velocity of the synchronous motion where shaft s stands at e^{iϑ} = `turns[s]`.
pub(super) fn motion(
    cached: &CachedModel,
    speed: f64,
    amplitudes: &DMatrix<Complex<f64>>,
    turns: &[Complex<f64>],
) -> (DVector<f64>, DVector<f64>) {
    let n = cached.model.len();
    let (mut q, mut v) = (DVector::zeros(n), DVector::zeros(n));
    for (source, turn) in turns.iter().enumerate() {
        let spin = cached.model.shafts[source].ratio * speed;
        for (index, amplitude) in amplitudes.column(source).iter().enumerate() {
            let turned = amplitude * turn;
            q[index] += turned.re;
            v[index] -= spin * turned.im;
        }
    }
    (q, v)
}
