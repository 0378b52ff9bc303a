//! Damped modes at a given speed: [λ²M + λ(C + ΩG) + K] φ = 0.
//!
//! Eigenvalues come from the first-order form in undamped modal coordinates ([`crate::modal::state_space`]). Without
//! damping its matrix is skew-symmetric, so the eigenvalues are well conditioned. faer does not balance matrices: the
//! unscaled matrix of M⁻¹K and M⁻¹C would give growth rates Re λ > 0 that do not exist.

use nalgebra::{Complex, DVector};

use super::residual::{LARGEST_RESIDUAL, Residual, Residuals};
use super::structural::{with_all_structural_damping, with_structural_damping};
use super::whirl::{Classifier, Whirl};
use crate::linalg::DecompositionError;
use crate::modal::cache::{CachedModel, EquationForces};
use crate::modal::lowest::{Eigenpair, Highest, ModeSelection, Problem, ascending, lowest};
use crate::modal::state_space::{damped, physical, undamped};
use crate::modal::undamped::ModalDamping;
use crate::model::Model;
use crate::numerics::EQUALITY_TOLERANCE;

/// One mode of vibration: a conjugate pair of eigenvalues, or one real eigenvalue.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Eigenvalue λ with Im λ ≥ 0, rad/s.
    pub eigenvalue: Complex<f64>,
    /// Mode shape φ, n entries in the order of the core: φᴴMφ = 1, the largest entry is real and positive.
    pub shape: DVector<Complex<f64>>,
    /// Type of motion.
    pub whirl: Whirl,
    /// Residual of the equations of motion.
    pub residual: Residual,
}

/// Damping ratio −Re λ/|λ| of an eigenvalue; 0 for 0.
pub fn damping_ratio(eigenvalue: Complex<f64>) -> f64 {
    let size = eigenvalue.norm();
    if size == 0.0 { 0.0 } else { -eigenvalue.re / size }
}

impl Mode {
    /// Damped frequency |Im λ|/2π, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.eigenvalue.im / (2.0 * std::f64::consts::PI)
    }

    /// Damping ratio −Re λ/|λ|; zero for a rigid-body mode.
    pub fn damping_ratio(&self) -> f64 {
        damping_ratio(self.eigenvalue)
    }

    /// Re(φ̄_i (Mφ)_i), the share of each coordinate in the kinetic energy, n entries in the order of the core with the sum 1.
    pub fn kinetic_shares(&self, model: &Model) -> DVector<f64> {
        let part = |part: fn(&Complex<f64>) -> f64| {
            let values = self.shape.map(|value| part(&value));
            let mut momentum = DVector::zeros(values.len());
            model.multiply_mass(values.as_slice(), momentum.as_mut_slice());
            values.component_mul(&momentum)
        };
        part(|value| value.re) + part(|value| value.im)
    }
}

/// The `count` lowest modes of a selection at `speed` of the reference shaft, rad/s, in ascending order of |λ|, from dense matrices.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub fn modes(
    cached: &CachedModel,
    speed: f64,
    count: usize,
    selection: ModeSelection,
) -> Result<Vec<Mode>, DecompositionError> {
    let real = cached.real_modes(speed)?;
    let order = cached.first_order(speed)?;
    let mut found = if order.undamped { undamped(real) } else { damped(real, &order)? };
    if cached.model.has_structural_damping() {
        found = with_all_structural_damping(&cached.model, speed, real, &order, found)?;
    }
    let (eigenvalues, coordinates) = found;
    let pair = |(value, coordinates): (Complex<f64>, &DVector<Complex<f64>>)| Eigenpair {
        value,
        shape: physical(real, coordinates),
    };
    let is_wanted = |index: &usize| selection.contains(&cached.model, speed, eigenvalues[*index]);
    let mut order: Vec<usize> = (0..eigenvalues.len()).filter(is_wanted).collect();
    order.sort_by(|a, b| ascending(eigenvalues[*a], eigenvalues[*b]));
    order.truncate(count);
    let modal =
        (!cached.model.scene.modal_damping.is_zero()).then(|| ModalDamping::new(&cached.model, real, f64::INFINITY));
    let pairs = order.into_iter().map(|index| pair((eigenvalues[index], &coordinates[index])));
    modes_of(cached, speed, modal.as_ref(), pairs)
}

/// The `count` lowest modes of a selection at `speed` of the reference shaft, rad/s, in ascending order of |λ|, from the band
/// matrices of the shafts. Time and memory are proportional to n.
///
/// `None` where the lowest modes cannot be told apart from the others, as with many overdamped ones.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub fn structured_modes(
    cached: &CachedModel,
    speed: f64,
    count: usize,
    selection: ModeSelection,
) -> Result<Option<Vec<Mode>>, DecompositionError> {
    let mut highest = Highest::Mode(count);
    loop {
        let modal = cached.modal_damping(speed, highest)?;
        let problem = Problem::new(&cached.model, speed, cached.spectral_range(speed)?, modal.as_deref())?;
        let Some(mut pairs) = lowest(&problem, count, selection)? else { return Ok(None) };
        let top = pairs.iter().map(|pair| pair.value.norm()).fold(0.0, f64::max);
        if matches!(highest, Highest::Mode(_)) && modal.as_ref().is_some_and(|modal| top > modal.reach) {
            // Strong dampers leave fewer low modes than the undamped ones that were counted.
            highest = Highest::Frequency(top);
            continue;
        }
        if cached.model.has_structural_damping() {
            pairs = with_structural_damping(&cached.model, speed, modal.as_deref(), pairs)?;
        }
        return modes_of(cached, speed, modal.as_deref(), pairs.into_iter()).map(Some);
    }
}

/// Modes with their whirl and their residuals.
///
/// # Errors
/// [`DecompositionError`] if the stiffness has no factors.
pub fn modes_of(
    cached: &CachedModel,
    speed: f64,
    modal: Option<&ModalDamping>,
    pairs: impl Iterator<Item = Eigenpair>,
) -> Result<Vec<Mode>, DecompositionError> {
    let classifier = Classifier::new(&cached.model, speed);
    let range = cached.spectral_range(speed)?;
    let mut residuals = Residuals::new(&cached.model, range, speed, EquationForces::All(modal));
    let mode = |Eigenpair { value, shape }: Eigenpair| {
        let mut residual = residuals.of(value, &shape)?;
        residual.limit = residual.limit.min(LARGEST_RESIDUAL);
        let shape = normalized(shape);
        Ok(Mode { eigenvalue: value, whirl: classifier.classify(value, &shape), shape, residual })
    };
    pairs.map(mode).collect()
}

/// Type of motion of the mode with λ = `eigenvalue`, rad/s, and the shape φ = `shape`, n entries in the order of the core.
pub fn whirl(model: &Model, speed: f64, eigenvalue: Complex<f64>, shape: &DVector<Complex<f64>>) -> Whirl {
    Classifier::new(model, speed).classify(eigenvalue, shape)
}

/// Multiplies a shape by a phase factor that makes its largest entry real and positive.
///
/// The length needs no change: with φ = Φη, ηᴴη = 1 is equivalent to φᴴMφ = 1.
fn normalized(shape: DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let mut largest = Complex::new(0.0, 0.0);
    for value in shape.iter() {
        // Of equal magnitudes the first one fixes the phase: modes of mirrored systems then have mirrored shapes.
        if value.norm() > largest.norm() * (1.0 + EQUALITY_TOLERANCE) {
            largest = *value;
        }
    }
    let phase = largest.conj() / largest.norm();
    shape.map(|value| value * phase)
}
