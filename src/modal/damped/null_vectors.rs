//! Right and left vectors of an eigenvalue λ, S(λ) x = 0 and yᵀ S(λ) = 0, by inverse iteration.
//!
//! The solutions are those of sparse factors. Modal damping D = B R Bᵀ adds a matrix of low rank (Woodbury; Golub
//! and Van Loan, Matrix Computations, 4th ed., section 2.1.4): (S + λBRBᵀ)⁻¹ f = S⁻¹ (f − B c) with (I + λRG) c = λR Bᵀ S⁻¹ f and
//! G = Bᵀ S⁻¹ B. Time and memory are proportional to n.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::residual::{Residual, residual};
use crate::linalg::{CoupledFactors, DecompositionError, LuFactors, Side, Singular, image_of_parts, matrix_of_columns};
use crate::modal::cache::{CachedModel, EquationForces, dynamic_force};
use crate::modal::lowest::Highest;
use crate::modal::undamped::ModalDamping;
use crate::model::{Model, Weights};
use crate::numerics::ROOT_OF_ROUND_OFF;

/// Relative distance of the shift from the eigenvalue: above its round-off, so that the factors exist.
const SHIFT: f64 = 1e-10;
/// Iterations, each of which reduces other vectors by SHIFT over the relative distance of their eigenvalues.
const ITERATIONS: usize = 4;
/// Vectors beyond the asked ones, which show further equal eigenvalues.
const SPARE: usize = 2;

/// Vectors of equal eigenvalues.
pub struct NullVectors {
    /// Right vectors x, n entries each in the order of the core.
    pub right: Vec<DVector<Complex64>>,
    /// Left vectors y, n entries each in the order of the core.
    pub left: Vec<DVector<Complex64>>,
    /// yᵀ ∂S/∂λ x, one row for each y.
    pub slopes: DMatrix<Complex64>,
    /// Whether a further vector has an equal eigenvalue.
    pub has_more: bool,
    /// Largest residual of a right vector.
    pub residual: Residual,
}

impl NullVectors {
    /// `count` right and left vectors of an eigenvalue, rad/s, with structural damping and the modal damping for a highest frequency
    /// in question, rad/s, at a speed of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn new(
        cached: &CachedModel,
        eigenvalue: Complex64,
        speed: f64,
        count: usize,
        highest: f64,
    ) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let modal = cached.modal_damping(speed, Highest::Frequency(highest))?;
        let inverse = Inverse::new(model, eigenvalue * (1.0 + SHIFT), speed, modal.as_deref())?;
        let scale = energy_scale(model, eigenvalue, speed);
        let (right, has_more) = iterate(&scale, count, |x| inverse.solve(Side::Right, x))?;
        let (left, _) = iterate(&scale, count, |x| inverse.solve(Side::Left, x))?;
        let slope = |x: &DVector<Complex64>| {
            let inertia = model.product(x, |x, out| model.multiply_mass(x, out)) * (2.0 * eigenvalue);
            // The rate of a force is that of S less its value at λ = 0 and its inertia at λ = 1.
            let forces = |at: f64| {
                let all = EquationForces::All(modal.as_deref());
                dynamic_force(model, [speed; 2], Complex64::from(at), x, all)
            };
            inertia + (forces(1.0) - forces(-1.0)) * Complex64::from(0.5)
        };
        let images: Vec<_> = right.iter().map(slope).collect();
        let slopes = DMatrix::from_fn(left.len(), images.len(), |row, column| left[row].dot(&images[column]));
        let mut worst: Option<Residual> = None;
        for shape in &right {
            let found = residual(cached, speed, eigenvalue, shape, EquationForces::All(modal.as_deref()))?;
            // A residual that is not a number stays.
            worst = worst.filter(|worst| worst.value.is_nan() || found.value <= worst.value).or(Some(found));
        }
        let residual = worst.unwrap_or(Residual { value: 0.0, limit: f64::INFINITY });
        Ok(Self { right, left, slopes, has_more, residual })
    }
}

/// Inverse root of the energies of unit displacements: translations and rotations have different units.
fn energy_scale(model: &Model, eigenvalue: Complex64, speed: f64) -> DVector<f64> {
    let (stiffness, mass) = (model.sparse_stiffness(speed).diagonal(), model.sparse_mass().diagonal());
    let energy = stiffness.iter().zip(&mass).map(|(k, m)| k.abs() + eigenvalue.norm_sqr() * m);
    DVector::from_iterator(mass.len(), energy.map(|energy| 1.0 / energy.sqrt()))
}

/// `count` vectors of the largest eigenvalues of `solve`, and whether there are more such eigenvalues.
fn iterate(
    scale: &DVector<f64>,
    count: usize,
    solve: impl Fn(&DVector<Complex64>) -> Result<DVector<Complex64>, Singular>,
) -> Result<(Vec<DVector<Complex64>>, bool), DecompositionError> {
    let size = scale.len();
    let wide = size.min(count + SPARE);
    // Fixed numbers without a pattern give the same result at every call: the fractional parts of multiples of the golden ratio.
    let entry = |row: usize, column: usize| {
        let number = (row * wide + column + 1) as f64 * 0.618_033_988_749_894_9;
        Complex64::from(number.fract() - 0.5)
    };
    let mut vectors = DMatrix::from_fn(size, wide, entry);
    let mut growth = DVector::zeros(wide);
    for _ in 0..ITERATIONS {
        let mut images = Vec::with_capacity(wide);
        for column in vectors.column_iter() {
            let scaled = column.zip_map(scale, |value, factor| value / factor);
            images.push(solve(&scaled)?.zip_map(scale, |value, factor| value / factor));
        }
        let found = matrix_of_columns(size, &images).svd(true, false);
        growth = found.singular_values;
        vectors = found.u.ok_or(DecompositionError::Eigenvalues)?;
    }
    let has_more = growth.iter().filter(|one| **one > SHIFT / ROOT_OF_ROUND_OFF * growth[0]).count() > count;
    let shape = |column: usize| vectors.column(column).zip_map(scale, |value, factor| value * factor);
    Ok(((0..count.min(wide)).map(shape).collect(), has_more))
}

/// The inverse of S(λ) with modal damping.
struct Inverse<'m> {
    model: &'m Model,
    factors: CoupledFactors,
    update: Option<Update<'m>>,
}

/// Modal damping in the inverse.
struct Update<'m> {
    modal: &'m ModalDamping,
    /// λR, m × m symmetric.
    rates: DMatrix<Complex64>,
    /// Factors of I + λRG and of I + λRGᵀ, m × m.
    capacities: [LuFactors<Complex64>; 2],
}

impl<'m> Inverse<'m> {
    fn new(
        model: &'m Model,
        eigenvalue: Complex64,
        speed: f64,
        modal: Option<&'m ModalDamping>,
    ) -> Result<Self, DecompositionError> {
        let factors = model.dynamic_stiffness(&Weights::mode(eigenvalue, speed), speed).factor()?;
        let mut inverse = Self { model, factors, update: None };
        if let Some(modal) = modal {
            let momenta = &modal.momenta;
            let mut responses = DMatrix::zeros(momenta.ncols(), momenta.ncols());
            for (column, mut image) in momenta.column_iter().zip(responses.column_iter_mut()) {
                let x = inverse.plain(Side::Right, &column.map(Complex64::from))?;
                image.copy_from(&projected(momenta, &x));
            }
            let rates = modal.rates.map(|rate| eigenvalue * rate);
            let identity = DMatrix::identity(rates.nrows(), rates.ncols());
            let capacity = |responses: &DMatrix<Complex64>| LuFactors::new(&(&identity + &rates * responses));
            let capacities = [capacity(&responses), capacity(&responses.transpose())];
            inverse.update = Some(Update { modal, rates, capacities });
        }
        Ok(inverse)
    }

    /// The solution without modal damping.
    fn plain(&self, side: Side, force: &DVector<Complex64>) -> Result<DVector<Complex64>, Singular> {
        self.model.solve(&self.factors, side, None, force.as_slice()).map(|(x, _)| x)
    }

    fn solve(&self, side: Side, force: &DVector<Complex64>) -> Result<DVector<Complex64>, Singular> {
        let found = self.plain(side, force)?;
        let Some(Update { modal, rates, capacities }) = &self.update else {
            return Ok(found);
        };
        let forces = DMatrix::from_columns(&[rates * projected(&modal.momenta, &found)]);
        let forces = capacities[usize::from(side == Side::Left)].solve(&forces);
        let change = image_of_parts(&forces.column(0).into_owned(), |part| &*modal.momenta * part);
        self.plain(side, &(force - change))
    }
}

/// Bᵀ x.
fn projected(momenta: &DMatrix<f64>, x: &DVector<Complex64>) -> DVector<Complex64> {
    image_of_parts(x, |part| momenta.tr_mul(part))
}
