//! Floquet multipliers: eigenvalues of the derivative of the period map at a steady state.

use std::cell::RefCell;

use nalgebra::Complex;

use super::norm;
use super::preconditioner::Preconditioner;
use super::solver::DERIVATIVE_DIFFERENCE;
use crate::analysis::AnalysisError;
use crate::analysis::simulate::PeriodMap;
use crate::exponential::STAGE_SOLVE_RTOL;
use crate::linalg::{DecompositionError, Krylov, Operator};
use crate::modal::ModePair;
use crate::numerics::EQUALITY_TOLERANCE;

/// Sizes of the disturbance that the steps resolve, relative to the motion: the first one that can be integrated.
const DISTURBANCE_SIZES: [f64; 3] = [0.1, 0.01, 0.001];
/// Energy norm that differences are relative to where there is no motion, √J: that of a mesh of 2e8 N/m deflected by 1e-7 m.
const REST_ENERGY_NORM: f64 = 1e-3;
/// Energy norm below which there is no motion.
const MIN_ENERGY_NORM: f64 = 1e-100;
/// Largest residual of a multiplier, relative to it.
const MAX_RESIDUAL: f64 = 1e-6;
/// Largest number of products with the derivative.
const MAX_PRODUCTS: usize = 400;
/// Number of products over that between two checks of the residuals.
const CHECKED_PART: usize = 8;
/// Golden ratio, whose multiples have fractions without a pattern.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
/// Smallest part of a mode in the start vector of the Krylov space, relative to the largest one.
const SMALLEST_START: f64 = 1e-3;

/// Which multipliers are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Smallest magnitude.
    pub smallest: f64,
    /// Whether only the largest ones count: smaller ones may be missing.
    pub only_largest: bool,
}

/// The wanted multipliers, the largest first, of the steady state in which the map begins. They are those of the linear motion
/// if `is_constant`: the coefficients of the equation of motion are constant.
pub fn multipliers(
    map: &mut PeriodMap<'_>,
    wanted: Wanted,
    is_constant: bool,
) -> Result<Vec<Complex<f64>>, AnalysisError> {
    let smallest = wanted.smallest;
    let mut values = if is_constant { multipliers_of_modes(map) } else { multipliers_of_map(map, wanted)? };
    let period = map.period();
    // No load reaches the modes that the run leaves out: their motion is linear.
    values.extend(map.omitted_eigenvalues()?.into_iter().map(|value| (value * period).exp()));
    values.retain(|value| value.norm() >= smallest);
    values.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    Ok(values)
}

/// The multipliers e^{λT} of the modes of the run, without rigid-body motions that do not decay.
fn multipliers_of_modes(map: &PeriodMap<'_>) -> Vec<Complex<f64>> {
    let (linear, period) = (map.linear(), map.period());
    let rate = |pair: &ModePair| if let ModePair::RigidBodyPair(rate) = pair { Some(*rate) } else { None };
    let moving = linear.pairs().iter().filter_map(rate).filter(|rate| (rate * period).abs() >= EQUALITY_TOLERANCE);
    let modes = linear.eigenvalues().into_iter().chain(moving.map(Complex::from));
    modes.map(|value| (value * period).exp()).collect()
}

/// The wanted multipliers of the modes of the run, from disturbed periods.
fn multipliers_of_map(map: &mut PeriodMap<'_>, wanted: Wanted) -> Result<Vec<Complex<f64>>, AnalysisError> {
    let preconditioner = Preconditioner::new(map.linear(), map.period());
    let z = map.initial();
    map.adapt(&z)?;
    // Without a motion, the equations have no scale.
    let size = Some(map.size(&z)?).filter(|size| *size > MIN_ENERGY_NORM).unwrap_or(REST_ENERGY_NORM);
    let unknown: Vec<usize> = unknowns(map, &preconditioner);
    let is_affine = map.is_affine();
    for part in DISTURBANCE_SIZES {
        match map.refine(&disturbed(map, &z, &unknown, part * size)) {
            Ok(()) => break,
            Err(AnalysisError::Interrupted) => return Err(AnalysisError::Interrupted),
            // A disturbance may end the contact geometry, as where the base circles come to overlap.
            Err(_) => {}
        }
    }
    let base = map.apply(&z)?;
    let start = start_vector(map, &unknown, wanted.smallest);
    let operator = Monodromy { map: RefCell::new(map), z, base, size, unknown, is_affine, failure: RefCell::new(None) };
    let found = eigenvalues(&operator, start, wanted);
    if let Some(error) = operator.failure.take() {
        return Err(error);
    }
    found
}

/// A state at a distance `size` from `z`: its steps also resolve how a disturbance moves, which a steady motion need not
/// contain. Slow modes have the largest part.
fn disturbed(map: &PeriodMap<'_>, z: &[f64], unknown: &[usize], size: f64) -> Vec<f64> {
    let linear = map.linear();
    let rate =
        |entry: usize| linear.blocks.iter().filter_map(|list| list.get(entry % linear.slots)).map(|x| x * x).sum();
    let parts: Vec<f64> = unknown.iter().map(|entry| 1.0 / (1.0 + f64::sqrt(rate(*entry)) * map.period())).collect();
    let factor = size / norm(&parts).max(f64::MIN_POSITIVE);
    let mut state = z.to_vec();
    for (entry, part) in unknown.iter().zip(&parts) {
        state[*entry] += factor * part;
    }
    state
}

/// Start vector of the Krylov space: the modes as the linear motion leaves them after so many periods that those whose multipliers
/// are smaller than `smallest` have the smallest part. As many products with the derivative would do the same.
fn start_vector(map: &PeriodMap<'_>, unknown: &[usize], smallest: f64) -> Vec<f64> {
    let rates = map.linear().pairs().iter().map(|pair| match pair {
        ModePair::Oscillation(value) => [value.re; 2],
        ModePair::Real(rates) => *rates,
        ModePair::RigidBodyPair(rate) => [0.0, *rate],
    });
    let (rates, slots): (Vec<[f64; 2]>, usize) = (rates.collect(), map.linear().slots);
    let periods = if smallest < 1.0 { SMALLEST_START.ln() / smallest.ln() } else { MAX_PRODUCTS as f64 };
    let time = periods.min(MAX_PRODUCTS as f64) * map.period();
    // Different parts, so that no symmetry cancels them.
    let part = |number: usize| 0.5 + (number as f64 * GOLDEN_RATIO).fract();
    let decay = |entry: usize| (rates[entry % slots][entry / slots] * time).exp().clamp(SMALLEST_START, 1.0);
    unknown.iter().enumerate().map(|(number, entry)| part(number) * decay(*entry)).collect()
}

/// Entries of z that are unknowns: neither padding nor rigid-body motion.
fn unknowns(map: &PeriodMap<'_>, preconditioner: &Preconditioner) -> Vec<usize> {
    let linear = map.linear();
    let used = |slot: usize| slot < linear.modes || linear.parts.len() > 1;
    (0..linear.len()).filter(|entry| used(entry % linear.slots) && !preconditioner.is_rigid(*entry)).collect()
}

/// The derivative of a period map over its unknowns.
struct Monodromy<'s, 'a> {
    map: RefCell<&'s mut PeriodMap<'a>>,
    z: Vec<f64>,
    /// P(z).
    base: Vec<f64>,
    size: f64,
    unknown: Vec<usize>,
    is_affine: bool,
    /// The reason for which a run ended early.
    failure: RefCell<Option<AnalysisError>>,
}

impl Monodromy<'_, '_> {
    fn product(&self, direction: &[f64]) -> Result<Vec<f64>, AnalysisError> {
        let length = norm(direction);
        if length == 0.0 {
            return Ok(direction.to_vec());
        }
        let factor = if self.is_affine { 1.0 } else { DERIVATIVE_DIFFERENCE } * self.size / length;
        let mut moved = self.z.clone();
        for (entry, part) in self.unknown.iter().zip(direction) {
            moved[*entry] += factor * part;
        }
        let image = self.map.borrow_mut().apply(&moved)?;
        Ok(self.unknown.iter().map(|entry| (image[*entry] - self.base[*entry]) / factor).collect())
    }
}

impl Operator for Monodromy<'_, '_> {
    type Scalar = f64;
    const SYMMETRIC: bool = false;

    fn size(&self) -> usize {
        self.unknown.len()
    }

    fn apply(&self, x: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        if self.failure.borrow().is_some() {
            return Ok(vec![0.0; x.len()]);
        }
        Ok(self.product(x).unwrap_or_else(|error| {
            *self.failure.borrow_mut() = Some(error);
            vec![0.0; x.len()]
        }))
    }

    fn weigh(&self, x: &[f64]) -> Vec<f64> {
        x.to_vec()
    }
}

/// The wanted eigenvalues.
///
/// # Errors
/// [`AnalysisError::Convergence`] if one of them is not accurate.
fn eigenvalues(
    operator: &Monodromy<'_, '_>,
    start: Vec<f64>,
    wanted: Wanted,
) -> Result<Vec<Complex<f64>>, AnalysisError> {
    let mut space = Krylov::new(operator, []);
    space.add_vector(start);
    let limit = operator.size().min(MAX_PRODUCTS);
    let (mut smallest, mut largest_residual, mut next_check) = (wanted.smallest, 0.0, 1);
    for count in 1..=limit {
        space.step()?;
        if operator.failure.borrow().is_some() {
            return Ok(Vec::new());
        }
        if count < next_check.min(limit) {
            continue;
        }
        next_check = count + 1 + count / CHECKED_PART;
        let pairs = space.ritz_pairs()?;
        if wanted.only_largest {
            let accurate = pairs.iter().filter(|pair| pair.residual <= MAX_RESIDUAL);
            smallest = accurate.map(|pair| pair.value.norm()).fold(wanted.smallest, f64::max);
        }
        // An approximation may become one of the wanted values if its residual reaches them.
        let may_be_wanted = pairs.iter().filter(|pair| pair.value.norm() * (1.0 + pair.residual) >= smallest);
        largest_residual = may_be_wanted.clone().map(|pair| pair.residual).fold(0.0, f64::max);
        if count == operator.size() || largest_residual <= MAX_RESIDUAL && may_be_wanted.count() + 2 < count {
            let largest = pairs.iter().map(|pair| pair.value.norm()).fold(0.0, f64::max);
            let lost =
                largest * if operator.is_affine { STAGE_SOLVE_RTOL } else { STAGE_SOLVE_RTOL / DERIVATIVE_DIFFERENCE };
            if lost > smallest {
                return Err(AnalysisError::Convergence(format!(
                    "multipliers: those below {lost:.0e} are lost in the round-off of the largest one, {largest:.1e}; take a larger magnitude with multipliers(magnitude)"
                )));
            }
            return Ok(pairs.iter().map(|pair| pair.value).filter(|value| value.norm() >= smallest).collect());
        }
    }
    if limit == 0 {
        return Ok(Vec::new());
    }
    Err(AnalysisError::Convergence(format!(
        "multipliers: one of magnitude {smallest} or more has a relative residual of {largest_residual:.1e} after {limit} products, and must have {MAX_RESIDUAL:e}; add damping, or take a larger magnitude with multipliers(magnitude)"
    )))
}
