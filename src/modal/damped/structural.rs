//! Modes with structural damping: S(λ) φ = 0 with the signs of the frequencies relative to each shaft ([`StructuralDamping`]).
//!
//! For a small model, eigenvalues of the first-order form in undamped modes give all modes. Each range of frequencies in which no
//! sign changes has an eigenproblem of its own.
//!
//! For a large model, Newton's method starts at the modes without structural damping. Structural damping can mix modes of close
//! frequencies. If a support has a loss factor in one direction only, two modes of equal frequency become two modes with different
//! damping. For such a group, the small eigenproblem of its mode shapes therefore gives the start.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use crate::linalg::{DecompositionError, Eigen, complex_eigen, solve_complex};
use crate::modal::cache::{EquationForces, dynamic_force};
use crate::modal::lowest::{Eigenpair, ModeAtSpeed, mode_near};
use crate::modal::state_space::{Eigenvectors, FirstOrder};
use crate::modal::undamped::{ModalDamping, RealModes};
use crate::model::{Model, SAME_ROTATION, StructuralDamping};
use crate::numerics::EQUALITY_TOLERANCE;

/// Largest relative distance of a frequency from those with its signs: the residual of the mode then stays below its limit.
const MAX_OUTSIDE: f64 = 1e-5;
/// Relative step of λ in the central difference of S, which is quadratic in λ: only round-off depends on the step.
const DIFFERENCE_STEP: f64 = 3e-5;
/// Smallest correlation |φᴴMφ'|² of two shapes of one mode.
pub const MIN_CORRELATION: f64 = 0.9;

/// The modes with structural damping of those without it, in ascending order.
///
/// # Errors
/// [`DecompositionError::Structural`] if Newton's method does not lead to as many modes.
pub(super) fn with_structural_damping(
    model: &Model,
    speed: f64,
    modal: Option<&ModalDamping>,
    pairs: Vec<Eigenpair>,
) -> Result<Vec<Eigenpair>, DecompositionError> {
    // Rigid-body and overdamped motions have no structural damping.
    let (standing, mut vibrating): (Vec<_>, Vec<_>) = pairs.into_iter().partition(|pair| pair.value.im == 0.0);
    vibrating.sort_by(|a, b| a.value.im.total_cmp(&b.value.im));
    // A loss factor η changes an eigenvalue λ by about iηλ/2.
    let distance = model.largest_loss_factor();
    let mut found: Vec<Eigenpair> = Vec::new();
    let mut left = &vibrating[..];
    while let Some(first) = left.first() {
        let is_close = |pair: &&Eigenpair| (pair.value - first.value).norm() <= distance * first.value.norm();
        let (group, others) = left.split_at(left.iter().take_while(is_close).count());
        left = others;
        for start in starts(model, speed, modal, group)? {
            let met = mode_near(model, modal, &start).ok_or(DecompositionError::Structural)?;
            let pair = Eigenpair { value: met.eigenvalue, shape: met.shape };
            if found.iter().any(|known| is_same(model, known, &pair)) {
                return Err(DecompositionError::Structural);
            }
            found.push(pair);
        }
    }
    found.extend(standing);
    let count = found.len();
    Ok(Eigenpair::lowest(found, count))
}

/// The eigenvalues and modal coordinates with structural damping, and of those without it, `found`, the ones without
/// oscillation; `order` is the first-order form without structural damping.
///
/// # Errors
/// [`DecompositionError`] if an eigenvalue iteration does not converge, or fewer modes vibrate than without structural damping.
pub(super) fn with_all_structural_damping(
    model: &Model,
    speed: f64,
    real: &RealModes,
    order: &FirstOrder,
    found: Eigenvectors,
) -> Result<Eigenvectors, DecompositionError> {
    let pairs = found.0.into_iter().zip(found.1);
    let (vibrating, standing): (Vec<_>, Vec<_>) = pairs.partition(|(value, _)| value.im > 0.0);
    let turning = model.shafts.iter().filter(|shaft| shaft.loss_factor > 0.0);
    let mut spins: Vec<f64> = turning.map(|shaft| (shaft.ratio * speed).abs()).filter(|spin| *spin > 0.0).collect();
    spins.sort_by(f64::total_cmp);
    spins.dedup_by(|a, b| *a - *b <= 4.0 * SAME_ROTATION * *a);
    // Frequencies between the speeds of the shafts, and those of the shafts themselves, where their sign is zero.
    let mut lossy = Vec::new();
    let mut low = 0.0;
    for spin in spins.iter().copied().chain([f64::INFINITY]) {
        let inside = if spin.is_finite() { f64::midpoint(low, spin) } else { 2.0 * low.max(1.0) };
        let ends = [low * (1.0 + SAME_ROTATION), spin * (1.0 - SAME_ROTATION)];
        lossy.extend(between(model, StructuralDamping { frequency: inside, speed }, real, order, ends)?);
        if spin.is_finite() {
            let ends = [spin * (1.0 - SAME_ROTATION), spin * (1.0 + SAME_ROTATION)];
            lossy.extend(between(model, StructuralDamping { frequency: spin, speed }, real, order, ends)?);
        }
        low = spin;
    }
    // Motions that hardly oscillate have no structural damping, and others of them take their place.
    let oscillation = |mode: &Vibration| mode.value.im / mode.value.norm();
    lossy.sort_by(|a, b| a.outside.total_cmp(&b.outside).then(oscillation(b).total_cmp(&oscillation(a))));
    if lossy.len() < vibrating.len() {
        return Err(DecompositionError::Structural);
    }
    lossy.truncate(vibrating.len());
    Ok(lossy.into_iter().map(|mode| (mode.value, mode.coordinates)).chain(standing).unzip())
}

/// A mode with signs of structural damping.
struct Vibration {
    /// λ, rad/s.
    value: Complex64,
    /// η of unit length.
    coordinates: DVector<Complex64>,
    /// By how much Im λ was outside of the frequencies with these signs, relative to it.
    outside: f64,
}

/// The modes whose frequency lies between two ends. Round-off may leave a mode that is as fast as a shaft out on both sides:
/// frequencies a little outside become those of the ends.
fn between(
    model: &Model,
    damping: StructuralDamping,
    real: &RealModes,
    order: &FirstOrder,
    [low, high]: [f64; 2],
) -> Result<Vec<Vibration>, DecompositionError> {
    let (elastic, moving) = (&order.elastic, &order.moving);
    let shapes = real.vectors.map(Complex64::from);
    let mut forces = DMatrix::zeros(shapes.nrows(), shapes.ncols());
    for (row, column, value) in model.structural_entries(damping, damping.speed) {
        for mode in 0..shapes.ncols() {
            forces[(row, mode)] += value * shapes[(column, mode)];
        }
    }
    let projected = shapes.tr_mul(&forces);
    let mut matrix = order.matrix.map(Complex64::from);
    for (row, i) in moving.iter().enumerate() {
        for (column, j) in elastic.iter().enumerate() {
            matrix[(elastic.len() + row, column)] -= projected[(*i, *j)] / real.frequencies[*j];
        }
    }
    let Eigen { values, vectors } = complex_eigen(&matrix)?;
    let pair = |(value, vector): (&Complex64, nalgebra::DVectorView<'_, Complex64>)| {
        let frequency = value.im.clamp(low, high);
        let outside = (value.im - frequency).abs() / frequency;
        if value.im <= 0.0 || outside.is_nan() || outside > MAX_OUTSIDE {
            return None;
        }
        let mut coordinates = DVector::zeros(real.frequencies.len());
        for (row, mode) in moving.iter().enumerate() {
            coordinates[*mode] = vector[elastic.len() + row] / value;
        }
        for (row, mode) in elastic.iter().enumerate() {
            coordinates[*mode] = vector[row] / real.frequencies[*mode];
        }
        let norm = coordinates.norm();
        Some(Vibration { value: Complex64::new(value.re, frequency), coordinates: coordinates.unscale(norm), outside })
    };
    Ok(values.iter().zip(vectors.column_iter()).filter_map(pair).collect())
}

/// Whether two eigenpairs are one mode.
fn is_same(model: &Model, first: &Eigenpair, second: &Eigenpair) -> bool {
    (first.value - second.value).norm() <= EQUALITY_TOLERANCE * second.value.norm() && {
        let momentum = model.product(&second.shape, |x, out| model.multiply_mass(x, out));
        first.shape.dotc(&momentum).norm_sqr() > MIN_CORRELATION
    }
}

/// Approximate modes with structural damping, from a group of close modes without it. With their shapes X, they solve the small
/// eigenproblem XᴴS(λ₀)X + (λ − λ₀)XᴴS'(λ₀)X.
fn starts(
    model: &Model,
    speed: f64,
    modal: Option<&ModalDamping>,
    group: &[Eigenpair],
) -> Result<Vec<ModeAtSpeed>, DecompositionError> {
    if let [pair] = group {
        return Ok(vec![ModeAtSpeed { speed, eigenvalue: pair.value, shape: pair.shape.clone() }]);
    }
    let middle: Complex64 = group.iter().map(|pair| pair.value).sum::<Complex64>() / group.len() as f64;
    let step = middle * DIFFERENCE_STEP;
    let force = |eigenvalue: Complex64, shape: &DVector<Complex64>| {
        let mut force = dynamic_force(model, [speed; 2], eigenvalue, shape, EquationForces::All(modal));
        model.add_structural_force(middle, speed, shape, &mut force);
        force
    };
    let shapes: Vec<DVector<Complex64>> = group.iter().map(|pair| pair.shape.clone()).collect();
    let shapes = DMatrix::from_columns(&shapes);
    let projected = |eigenvalue: Complex64| {
        let forces: Vec<_> = group.iter().map(|pair| force(eigenvalue, &pair.shape)).collect();
        shapes.ad_mul(&DMatrix::from_columns(&forces))
    };
    let at = projected(middle);
    // S is quadratic in λ, so that the central difference is exact.
    let slope = (projected(middle + step) - projected(middle - step)) / (step * 2.0);
    let Eigen { values, vectors } = complex_eigen(&-solve_complex(&slope, &at))?;
    let start = |(value, vector): (&Complex64, nalgebra::DVectorView<'_, Complex64>)| {
        let shape = &shapes * vector;
        let size = model.complex_kinetic_form(&shape).sqrt();
        ModeAtSpeed { speed, eigenvalue: middle + value, shape: shape.unscale(size) }
    };
    Ok(values.iter().zip(vectors.column_iter()).map(start).collect())
}
