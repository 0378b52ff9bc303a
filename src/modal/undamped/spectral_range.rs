//! Lowest and highest undamped frequency at rest from Krylov spaces, in time proportional to n.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::real::{RealModes, null_motions};
use crate::linalg::{
    CoupledFactors, DecompositionError, MAX_BACKWARD_ERROR, Operator, Sparse, eigenvector, largest_eigenvalue,
};
use crate::model::{Model, Weights};

/// Relative change of a frequency at which an iteration ends.
const CONVERGED: f64 = 1e-7;
/// Steps between two comparisons for the highest frequency, close to which there are many.
const STEPS: usize = 10;
/// The same for the lowest one.
const FEW_STEPS: usize = 4;
/// Largest number of steps.
const MAX_STEPS: usize = 300;
/// Shift of the iteration for the lowest frequency, relative to the highest one: round-off of the stiffness is 1e-8 of
/// it.
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
    pub(in crate::modal) fn of_modes(modes: &RealModes) -> Self {
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
    pub(in crate::modal) fn new(model: &Model, speed: f64) -> Result<Self, DecompositionError> {
        let stiffness = model.sparse_symmetric_stiffness(speed);
        let none = DMatrix::zeros(model.len(), 0);
        let mass = model.sparse_mass();
        let (fastest, shape) = largest(&MassInverse { model, mass: &mass, stiffness: &stiffness }, &none, STEPS)?;
        let fastest = fastest.sqrt();
        let null = null_motions(model, speed)?;
        let mut slowest = None;
        if null.ncols() < model.len() && fastest > 0.0 {
            let shift = SHIFT * fastest;
            let inverse = ShiftInverse { tolerance: MAX_BACKWARD_ERROR, ..ShiftInverse::new(model, speed, shift)? };
            let (value, _) = largest(&UndampedInverse { inverse, mass: &mass }, &null, FEW_STEPS)?;
            slowest = Some((1.0 / value - shift * shift).max(0.0).sqrt());
        }
        Ok(Self { slowest, fastest, fastest_shape: shape })
    }
}

/// Largest eigenvalue and its vector, apart from those of the columns of `locked`, by the Lanczos method without
/// reorthogonalization, with comparisons every `interval` steps: copies of a converged eigenvalue do no harm (Golub and Van Loan, section 10.3).
fn largest(
    operator: &impl Operator<Scalar = f64>,
    locked: &DMatrix<f64>,
    interval: usize,
) -> Result<(f64, DVector<f64>), DecompositionError> {
    let size = operator.size();
    let locked_momenta: Vec<DVector<f64>> = locked
        .column_iter()
        .map(|column| DVector::from_vec(operator.weigh(&column.iter().copied().collect::<Vec<_>>())))
        .collect();
    let without_locked = |x: &mut DVector<f64>| {
        for (column, weighted) in locked.column_iter().zip(&locked_momenta) {
            let part = weighted.dot(x);
            x.axpy(-part, &column, 1.0);
        }
    };
    let weigh = |x: &DVector<f64>| DVector::from_vec(operator.weigh(x.as_slice()));
    // A fixed start vector with components in all directions.
    let mut vector = DVector::from_fn(size, |i, _| ((i * i) as f64).sin());
    vector = DVector::from_vec(operator.apply(vector.as_slice())?);
    without_locked(&mut vector);
    let mut weighted = weigh(&vector);
    let length = weighted.dot(&vector).max(0.0).sqrt();
    if length == 0.0 {
        return Ok((0.0, DVector::zeros(size)));
    }
    weighted /= length;
    let mut basis = vec![vector / length];
    let (mut diagonal, mut beside): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut previous = 0.0;
    loop {
        let last = basis.len() - 1;
        let mut next = DVector::from_vec(operator.apply(basis[last].as_slice())?);
        without_locked(&mut next);
        if last > 0 {
            next.axpy(-beside[last - 1], &basis[last - 1], 1.0);
        }
        let along = weighted.dot(&next);
        next.axpy(-along, &basis[last], 1.0);
        diagonal.push(along);
        weighted = weigh(&next);
        let length = weighted.dot(&next).max(0.0).sqrt();
        let steps = diagonal.len();
        let is_end = steps >= MAX_STEPS.min(size) || length <= f64::EPSILON * along.abs();
        if is_end || steps.is_multiple_of(interval) {
            let value = largest_eigenvalue(&diagonal, &beside);
            if is_end || (value - previous).abs() <= CONVERGED * value {
                let mut shape = DVector::zeros(size);
                let components = eigenvector(&diagonal, &beside, value);
                basis.iter().zip(components).for_each(|(vector, part)| shape.axpy(part, vector, 1.0));
                return Ok((value, shape));
            }
            previous = value;
        }
        beside.push(length);
        weighted /= length;
        basis.push(next / length);
    }
}

/// M⁻¹K.
struct MassInverse<'m> {
    model: &'m Model,
    mass: &'m Sparse,
    stiffness: &'m Sparse,
}

impl Operator for MassInverse<'_> {
    type Scalar = f64;
    const SYMMETRIC: bool = true;

    fn size(&self) -> usize {
        self.model.len()
    }

    fn apply(&self, x: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        let mut image = image(self.stiffness, x);
        self.model.solve_mass(&mut image);
        Ok(image)
    }

    fn weigh(&self, x: &[f64]) -> Vec<f64> {
        image(self.mass, x)
    }
}

/// (K + s²M)⁻¹ with a shift s, rad/s.
pub struct ShiftInverse<'m> {
    model: &'m Model,
    /// Factors of K + s²M in circular coordinates.
    pub factors: CoupledFactors,
    /// s, rad/s.
    pub shift: f64,
    /// Componentwise backward error of the solutions; zero for the smallest one.
    tolerance: f64,
}

impl<'m> ShiftInverse<'m> {
    pub fn new(model: &'m Model, speed: f64, shift: f64) -> Result<Self, DecompositionError> {
        let weights = Weights { symmetric: true, ..Weights::dynamic(Complex64::from(shift), 0.0) };
        let weights = Weights { damping: Complex64::ZERO, ..weights };
        let matrix = model.dynamic_stiffness(&weights, speed);
        let factors = matrix.factor()?;
        Ok(Self { model, factors, shift, tolerance: 0.0 })
    }

    /// (K + s²M)⁻¹ F, n × m.
    pub fn solve_columns(&self, forces: &DMatrix<f64>) -> Result<DMatrix<f64>, DecompositionError> {
        Ok(self.model.solve_columns(&self.factors, forces)?)
    }

    /// (K + s²M)⁻¹ f, n entries.
    pub fn solve(&self, force: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        Ok(self.model.solve_real(&self.factors, self.tolerance, force)?)
    }
}

/// (K + s²M)⁻¹M with a shift s, rad/s.
pub struct UndampedInverse<'m> {
    pub inverse: ShiftInverse<'m>,
    /// M.
    pub mass: &'m Sparse,
}

impl Operator for UndampedInverse<'_> {
    type Scalar = f64;
    const SYMMETRIC: bool = true;
    const IN_PAIRS: bool = true;

    fn size(&self) -> usize {
        self.inverse.model.len()
    }

    fn apply(&self, x: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        self.inverse.solve(&self.weigh(x))
    }

    fn apply_both(&self, x: &[f64], y: &[f64]) -> Result<[Vec<f64>; 2], DecompositionError> {
        let momenta = [x, y].map(|x| DVector::from_vec(self.weigh(x)));
        let solved = self.inverse.solve_columns(&DMatrix::from_columns(&momenta))?;
        Ok([0, 1].map(|column| solved.column(column).iter().copied().collect()))
    }

    fn weigh(&self, x: &[f64]) -> Vec<f64> {
        image(self.mass, x)
    }
}

/// A x of a sparse matrix A.
fn image(matrix: &Sparse, x: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; x.len()];
    matrix.multiply_add(1.0, x, &mut image);
    image
}
