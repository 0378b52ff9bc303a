//! Steady linear response to everything that turns once with a shaft, in the frequency domain: bow, unbalance, turning forces,
//! run-out of gears, and the first harmonic of transmission errors of a shaft.
//!
//! Shaft s excites at its speed ω relative to the frame of its lateral motion, which is Ω_s if this frame is at rest:
//! [K + iω(C + ΩG) − ω²M] a = f_s. The motion is the sum of Re(a e^{iϑ_s}) over all shafts, with the angles ϑ_s in these frames.

use nalgebra::{Complex, DMatrix, DVector};

use super::modes::is_banded;
use super::sources::{Harmonic, add_mesh_error};
use super::{AnalysisError, Dense};
use crate::linalg::{Side, backward_error, matrix_of_columns, solve_complex};
use crate::modal::{CachedModel, DynamicKey, Highest, MAX_DENSE, Solved};
use crate::model::{Excitation, Model, StructuralDamping};
use crate::motion::RotatingLoad;
use crate::scene::{EntryPath, SceneError};

/// Part of the excitation by a rotating shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExcitationPart {
    /// Everything that turns with the shaft.
    #[default]
    All,
    /// Bow only.
    Bow,
    /// Unbalance only.
    Unbalance,
}

impl ExcitationPart {
    /// Finds a part by its name, which the entry `at` contains.
    ///
    /// # Errors
    /// [`SceneError`] for another name.
    pub(crate) fn named(name: &str, at: &EntryPath<'_>) -> Result<Self, SceneError> {
        match name {
            "both" => Ok(Self::All),
            "bow" => Ok(Self::Bow),
            "unbalance" => Ok(Self::Unbalance),
            _ => Err(at.error(format!("must be \"both\", \"bow\" or \"unbalance\", got \"{name}\""))),
        }
    }
}

/// Largest relative residual of a response. Machines reach 1e-11, and scenes with stiffnesses of very different size 2e-6; a
/// response that is wrong has a residual near one.
pub(super) const MAX_RESIDUAL: f64 = 1e-4;

/// Response to the rotation of one shaft.
#[derive(Clone, Debug)]
pub struct SourceResponse {
    /// Phasors a, n entries in the order of the core, m and rad.
    pub phasors: DVector<Complex<f64>>,
    /// Relative residual of the equations: the componentwise backward error max |f − S a|/(|S||a| + |f|); of a large model with
    /// modal damping, the part of the response in the energy norm.
    pub residual: f64,
}

impl SourceResponse {
    /// The response without force.
    pub(super) fn zero(model: &Model) -> Self {
        Self { phasors: DVector::zeros(model.len()), residual: 0.0 }
    }

    /// The response at a speed, rad/s, to the shaft called `source`.
    ///
    /// # Errors
    /// [`AnalysisError`] if it does not satisfy the equations.
    pub(super) fn checked(self, speed: f64, source: &str) -> Result<Self, AnalysisError> {
        // A residual that is not a number is refused as well.
        if self.residual <= MAX_RESIDUAL {
            return Ok(self);
        }
        Err(AnalysisError::Convergence(format!(
            "the synchronous response to shaft \"{source}\" at {speed} rad/s does not satisfy the equations of motion: its residual is {:.3e}, above the limit {MAX_RESIDUAL:.1e}; add damping or change the speed",
            self.residual
        )))
    }
}

/// The error of a speed without an accurate response, rad/s.
fn unsolved(speed: f64) -> AnalysisError {
    AnalysisError::Convergence(format!(
        "the synchronous response at {speed} rad/s has no accurate solution: it is an undamped critical speed; add damping or change the speed"
    ))
}

/// Phasors of the bow of all shafts, each over the coordinates of its own shaft, in the coordinate order of the core, m.
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

/// Memory that synchronous responses need.
pub fn memory_of_responses(model: &Model) -> Dense {
    if !model.scene.modal_damping.is_zero() && !is_banded(model) { Dense::Undamped } else { Dense::Bands }
}

/// Highest spin of a shaft at `speeds` of the reference shaft, rad/s.
pub fn highest_spin(model: &Model, speeds: &[f64]) -> Highest {
    let fastest = speeds.iter().map(|speed| speed.abs()).fold(0.0, f64::max);
    Highest::Frequency(model.max_speed_ratio() * fastest)
}

/// Phasors of the synchronous response at one speed, rad/s, in m and rad: one column for each source shaft, in the coordinate
/// order of the core. The meshes are linearised at rest.
///
/// # Errors
/// [`AnalysisError`] if a response has no accurate solution.
pub fn synchronous(
    cached: &CachedModel,
    speed: f64,
    part: ExcitationPart,
) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    let highest = highest_spin(&cached.model, &[speed]);
    let one = |source| Ok(synchronous_of(cached, speed, speed, source, part, highest)?.phasors);
    let columns = (0..cached.model.shafts.len()).map(one).collect::<Result<Vec<_>, AnalysisError>>()?;
    Ok(matrix_of_columns(cached.model.len(), &columns))
}

/// Response at `speed` to one source shaft, with the flanks in contact at the speed `flank_speed`, both rad/s, and with the modal
/// damping for the `highest` frequency in question.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found, or the response does not satisfy the equations.
pub(super) fn synchronous_of(
    cached: &CachedModel,
    speed: f64,
    flank_speed: f64,
    source: usize,
    part: ExcitationPart,
    highest: Highest,
) -> Result<SourceResponse, AnalysisError> {
    let spin = cached.model.shafts[source].ratio_in_frame() * speed;
    let cached = cached.at(speed, spin)?;
    let model = &cached.model;
    let Some(force) = rotating_force(model, Harmonic { frequency: spin, speed: flank_speed }, source, part) else {
        return Ok(SourceResponse::zero(model));
    };
    let name = &model.scene.shafts[source].name;
    let key = DynamicKey { speed, spin, flank_speed };
    let found = solve(&cached, key, highest, Side::Right, 0.0, &force)?;
    found.ok_or_else(|| unsolved(speed))?.checked(speed, name)
}

/// Response at `speed`, rad/s, to a load of a run, whose meshes contain run-out and transmission errors.
///
/// # Errors
/// As [`synchronous_of`].
pub(super) fn response_to(
    cached: &CachedModel,
    speed: f64,
    load: &RotatingLoad,
    highest: Highest,
) -> Result<SourceResponse, AnalysisError> {
    let cached = cached.at(speed, load.spin)?;
    let mut force = DVector::zeros(cached.model.len());
    let [cosine, sine] = load.columns();
    cosine.iter().for_each(|(index, value)| force[*index] += *value);
    sine.iter().for_each(|(index, value)| force[*index] -= Complex::i() * *value);
    let key = DynamicKey { speed, spin: load.spin, flank_speed: speed };
    let found = solve(&cached, key, highest, Side::Right, 0.0, &force)?;
    found.ok_or_else(|| unsolved(speed))?.checked(speed, &cached.model.scene.shafts[load.shaft].name)
}

/// Solves S x = f, or Sᵀ x = f for [`Side::Left`]. Sparse matrices without modal damping give a solution with at most the backward
/// error `tolerance`; zero asks for round-off. `None` at an undamped natural frequency of a model that is too large for dense
/// matrices.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found.
pub(super) fn solve(
    cached: &CachedModel,
    key: DynamicKey,
    highest: Highest,
    side: Side,
    tolerance: f64,
    force: &DVector<Complex<f64>>,
) -> Result<Option<SourceResponse>, AnalysisError> {
    let model = &cached.model;
    // Modal damping has no force without velocity.
    let is_damped = !model.scene.modal_damping.is_zero() && key.spin != 0.0;
    if !is_damped || is_banded(model) {
        let found = banded(cached, key, is_damped.then_some(highest), side, tolerance, force)?;
        // At an undamped natural frequency the response is very large: the dense solution shows its size.
        if found.is_some() || model.len() > MAX_DENSE {
            return Ok(found);
        }
    }
    solve_dense(cached, key, side, force).map(Some)
}

/// Phasors of the force of a source shaft, whose speed relative to its frame is the frequency of `at`; `None` without force.
pub(super) fn rotating_force(
    model: &Model,
    at: Harmonic,
    source: usize,
    part: ExcitationPart,
) -> Option<DVector<Complex<f64>>> {
    let spin = at.frequency + model.shafts[source].frame * at.speed;
    let acting = |excitation: &Excitation| match part {
        ExcitationPart::All => excitation.amplitude(spin, 0.0),
        ExcitationPart::Bow => excitation.steady_amplitude(),
        ExcitationPart::Unbalance => excitation.unbalance_amplitude(spin, 0.0),
    };
    let excitations = model.shafts[source].excitations.iter().map(|excitation| (excitation.index, acting(excitation)));
    let mut excitations = excitations.filter(|(_, amplitude)| *amplitude != Complex::ZERO).peekable();
    let count = if part == ExcitationPart::All { model.meshes.len() } else { 0 };
    let errors = (0..count).map(|mesh| (mesh, model.meshes[mesh].turning_error(model.sigma(mesh, at.speed), source)));
    let mut errors = errors.filter(|(_, error)| *error != Complex::ZERO).peekable();
    if excitations.peek().is_none() && errors.peek().is_none() {
        return None;
    }
    let mut force = DVector::zeros(model.len());
    for (index, amplitude) in excitations {
        // v = Re(A e^{iϑ}) and w = Im(A e^{iϑ}) = Re(−iA e^{iϑ}).
        force[index] += amplitude;
        force[index + 1] -= amplitude * Complex::i();
    }
    for (mesh, error) in errors {
        add_mesh_error(model, mesh, at, error, force.as_mut_slice());
    }
    force.iter().any(|value| *value != Complex::ZERO).then_some(force)
}

/// Solves S x = f with sparse factors, without modal damping to a backward error or, if it is zero, to
/// round-off; `None` if round-off leaves no accurate solution.
fn banded(
    cached: &CachedModel,
    key: DynamicKey,
    highest: Option<Highest>,
    side: Side,
    tolerance: f64,
    force: &DVector<Complex<f64>>,
) -> Result<Option<SourceResponse>, AnalysisError> {
    let solver = cached.dynamic_solver(key, highest)?;
    let found =
        solver.as_ref().as_ref().ok().and_then(|solver| solver.solve(&cached.model, side, tolerance, force).ok());
    Ok(found.map(|Solved { phasors, residual, .. }| SourceResponse { phasors, residual }))
}

/// The same with the dense matrix, which may contain modal damping.
fn solve_dense(
    cached: &CachedModel,
    DynamicKey { speed, spin, flank_speed }: DynamicKey,
    side: Side,
    force: &DVector<Complex<f64>>,
) -> Result<SourceResponse, AnalysisError> {
    let model = &cached.model;
    Dense::Undamped.require(model)?;
    let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(flank_speed));
    let rate = cached.damping_matrix(flank_speed)? + model.gyroscopic_matrix() * speed;
    let mut dynamic = DMatrix::from_fn(model.len(), model.len(), |i, j| {
        Complex::new(stiffness[(i, j)] - spin * spin * mass[(i, j)], spin * rate[(i, j)])
    });
    if model.has_structural_damping() {
        let damping = StructuralDamping { frequency: spin, speed };
        for (row, column, value) in model.structural_entries(damping, flank_speed) {
            dynamic[(row, column)] += value;
        }
    }
    if spin == 0.0 {
        // Null motions have no stiffness at standstill. The bow does not drive them, so that an artificial stiffness has
        // no effect.
        let real = cached.real_modes(flank_speed)?;
        let weighted = &mass * real.vectors.columns(0, real.null);
        let lowest = real.frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
        dynamic += (&weighted * weighted.transpose() * (lowest * lowest)).map(|value| Complex::new(value, 0.0));
    }
    if side == Side::Left {
        dynamic.transpose_mut();
    }
    let right = DMatrix::from_column_slice(model.len(), 1, force.as_slice());
    let phasors = solve_complex(&dynamic, &right).column(0).into_owned();
    let residual = backward_error(&dynamic, force, &phasors);
    Ok(SourceResponse { phasors, residual })
}

/// Displacement and velocity of the synchronous motion at the shaft angles e^{iϑ_s} = `rotations[s]`.
pub(super) fn motion(
    cached: &CachedModel,
    speed: f64,
    amplitudes: &DMatrix<Complex<f64>>,
    rotations: &[Complex<f64>],
) -> (DVector<f64>, DVector<f64>) {
    let n = cached.model.len();
    let (mut q, mut v) = (DVector::zeros(n), DVector::zeros(n));
    for (source, rotation) in rotations.iter().enumerate() {
        let spin = cached.model.shafts[source].ratio_in_frame() * speed;
        for (index, amplitude) in amplitudes.column(source).iter().enumerate() {
            let value = amplitude * rotation;
            q[index] += value.re;
            v[index] -= spin * value.im;
        }
    }
    (q, v)
}
