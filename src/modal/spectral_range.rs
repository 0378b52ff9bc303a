//! Lowest and highest undamped frequency at rest from Krylov spaces, in time proportional to n.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::real::{RealModes, null_motions};
use crate::linalg::{CoupledFactors, DecompositionError, Krylov, Operator, Singular, Sparse};
use crate::model::{Model, Weights};

/// Relative change of a frequency at which an iteration ends.
const CONVERGED: f64 = 1e-7;
/// Steps between two comparisons.
const STEPS: usize = 20;
/// Largest number of steps.
const MAX_STEPS: usize = 120;
/// Shift of the first iteration for the lowest frequency, relative to the highest one: round-off of the stiffness is
/// 1e-8 of it.
const SHIFT: f64 = 1e-5;

/// Lowest and highest undamped frequency at rest, of the symmetric part of the stiffness.
#[derive(Clone, Debug)]
pub struct SpectralRange {
    /// Lowest frequency above zero, rad/s; `None` if there is only rigid-body motion.
    pub slowest: Option<f64>,
    /// Highest frequency, rad/s.
    pub fastest: f64,
    /// Mode shape of the highest frequency, n entries in the order of the core.
    pub fastest_shape: DVector<f64>,
}

impl SpectralRange {
    /// Frequencies of known modes.
    pub(super) fn of_modes(modes: &RealModes) -> Self {
        Self {
            slowest: modes.frequencies.iter().copied().find(|frequency| *frequency > 0.0),
            fastest: modes.highest(),
            fastest_shape: modes.vectors.column(modes.frequencies.imax()).into_owned(),
        }
    }

    /// Frequencies of a model with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if an iteration fails.
    pub(super) fn new(model: &Model, speed: f64) -> Result<Self, DecompositionError> {
        let stiffness = model.sparse_symmetric_stiffness(speed);
        let (fastest, shape) = largest(&MassInverse { model, stiffness: &stiffness }, &DMatrix::zeros(model.len(), 0))?;
        let fastest = fastest.sqrt();
        let null = null_motions(model, speed)?;
        let mut slowest = None;
        if null.ncols() < model.len() && fastest > 0.0 {
            let mut shift = SHIFT * fastest;
            // The second shift is close to the lowest frequency.
            for _ in 0..2 {
                let inverse = ShiftInverse::new(model, speed, shift)?;
                let (value, _) = largest(&inverse, &null)?;
                let frequency = (1.0 / value - shift * shift).max(0.0).sqrt();
                slowest = Some(frequency);
                shift = frequency.max(shift);
            }
        }
        Ok(Self { slowest, fastest, fastest_shape: shape })
    }
}

/// Largest eigenvalue and its vector, apart from those of the columns of `locked`.
fn largest(operator: &impl Operator, locked: &DMatrix<f64>) -> Result<(f64, DVector<f64>), DecompositionError> {
    let locked = locked.column_iter().map(|column| column.iter().copied().collect());
    let mut space = Krylov::new(operator, locked);
    let mut previous = 0.0;
    loop {
        for _ in 0..STEPS {
            space.step()?;
        }
        let pairs = space.ritz_pairs()?;
        let pair = pairs.iter().max_by(|a, b| a.value.re.total_cmp(&b.value.re));
        let Some(pair) = pair else {
            return Ok((0.0, DVector::zeros(operator.size())));
        };
        let value = pair.value.re;
        if (value - previous).abs() <= CONVERGED * value || space.steps() >= MAX_STEPS || space.is_complete() {
            return Ok((value, space.vector(pair).map(|entry| entry.re)));
        }
        previous = value;
    }
}

/// M⁻¹K.
struct MassInverse<'m> {
    model: &'m Model,
    stiffness: &'m Sparse,
}

impl Operator for MassInverse<'_> {
    const SYMMETRIC: bool = true;

    fn size(&self) -> usize {
        self.model.len()
    }

    fn apply(&self, x: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        let mut image = vec![0.0; x.len()];
        self.stiffness.multiply_add(1.0, x, &mut image);
        self.model.solve_mass(&mut image);
        Ok(image)
    }

    fn weigh(&self, x: &[f64]) -> Vec<f64> {
        mass_times(self.model, x)
    }
}

/// (K + s²M)⁻¹M with a shift s, rad/s.
pub(super) struct ShiftInverse<'m> {
    model: &'m Model,
    factors: CoupledFactors,
}

impl<'m> ShiftInverse<'m> {
    pub fn new(model: &'m Model, speed: f64, shift: f64) -> Result<Self, DecompositionError> {
        let weights = Weights { symmetric: true, ..Weights::dynamic(Complex64::from(shift), 0.0) };
        let weights = Weights { damping: Complex64::ZERO, ..weights };
        let factors = model.dynamic_stiffness(&weights, speed).factor(1.0)?;
        Ok(Self { model, factors })
    }
}

impl Operator for ShiftInverse<'_> {
    const SYMMETRIC: bool = true;

    fn size(&self) -> usize {
        self.model.len()
    }

    fn apply(&self, x: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        Ok(solve_real(self.model, &self.factors, &mass_times(self.model, x))?)
    }

    fn weigh(&self, x: &[f64]) -> Vec<f64> {
        mass_times(self.model, x)
    }
}

/// M x.
pub(super) fn mass_times(model: &Model, x: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    model.multiply_mass(x, &mut product);
    product
}

/// Solution of a real system in the order of the core.
pub(super) fn solve_real(model: &Model, factors: &CoupledFactors, right: &[f64]) -> Result<Vec<f64>, Singular> {
    let right: Vec<Complex64> = right.iter().map(|value| Complex64::from(*value)).collect();
    let mut x = model.to_circular(&right);
    factors.solve(&mut x)?;
    Ok(model.from_circular(&x).iter().map(|value| value.re).collect())
}
