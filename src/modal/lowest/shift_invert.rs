//! The eigenvalue problem [λ²M + λD + K] x = 0 with D = C + ΩG and modal damping, and its first-order form inverted at a shift s.
//!
//! ```text
//! T (x, z) = (u, x + s u),    S(s) u = −M z − (D + sM) x,    λ = s + 1/θ    for an eigenvalue θ of T
//! ```
//!
//! The state is y = (x, z), z = λx. Each product with T solves one system with sparse factors. Without
//! damping, gyroscopic and circulatory forces T = (K + s²M)⁻¹M is half as large, and symmetric. The inner product is that
//! of the energy, in which T is normal if nothing damps.

use nalgebra::{DMatrix, DVector, DVectorViewMut};
use num_complex::Complex64;

use super::contour::{self, Known};
use super::selection::ascending;
use crate::linalg::{CoupledFactors, DecompositionError, LuFactors, MAX_BACKWARD_ERROR, Operator, Sparse};
use crate::modal::undamped::{ModalDamping, SpectralRange, null_motions};
use crate::model::{Model, Weights};

/// Largest relative difference of the Rayleigh quotient from the eigenvalue of the space.
const MAX_CORRECTION: f64 = 1e-6;

/// An eigenvalue with its mode shape.
pub struct Eigenpair {
    /// λ with Im λ ≥ 0, rad/s.
    pub value: Complex64,
    /// φ with φᴴMφ = 1, n entries in the order of the core.
    pub shape: DVector<Complex64>,
}

impl Eigenpair {
    /// The first `count` modes in ascending order.
    pub fn lowest(mut all: Vec<Self>, count: usize) -> Vec<Self> {
        all.sort_by(|a, b| ascending(a.value, b.value));
        all.truncate(count);
        all
    }
}

/// Matrices of the problem and its rigid-body modes.
pub struct Problem<'m> {
    pub model: &'m Model,
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
    /// s, rad/s.
    pub shift: f64,
    /// M.
    pub mass: Sparse,
    /// C + ΩG, the part of D without modal damping.
    pub rate: Sparse,
    /// Modal damping, the other part of D.
    pub modal: Option<&'m ModalDamping>,
    /// Symmetric part of K.
    pub stiffness: Sparse,
    /// Whether D and the skew part of K are zero.
    pub undamped: bool,
    /// Rigid-body modes, one per column, orthonormal in M.
    pub null: DMatrix<f64>,
    /// Numbers of the rigid-body modes whose velocity D does not act on.
    pub free: Vec<usize>,
}

impl<'m> Problem<'m> {
    /// The problem at a speed of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if the rigid-body modes cannot be found.
    pub fn new(
        model: &'m Model,
        speed: f64,
        range: &SpectralRange,
        modal: Option<&'m ModalDamping>,
    ) -> Result<Self, DecompositionError> {
        let rate = model.sparse_rate(speed);
        let circulates =
            model.local_elements().any(|element| element.skew_part().as_flattened().iter().any(|k| *k != 0.0))
                || model.circulation.is_some_and(|speed| speed != 0.0);
        let null = null_motions(model, speed)?;
        // Coordinates with unit inertia have one unit; round-off of the rigid-body modes is relative to their largest entry.
        let mass = model.sparse_mass();
        let inertia = mass.diagonal();
        let scaled = |row: usize, column: usize, value: f64| value.abs() / (inertia[row] * inertia[column]).sqrt();
        let largest = rate.largest(scaled);
        let acts = |column: usize| {
            let motion: Vec<f64> = null.column(column).iter().copied().collect();
            let mut force = vec![0.0; motion.len()];
            rate.multiply_add(1.0, &motion, &mut force);
            let size = motion.iter().zip(&inertia).map(|(x, m)| x.abs() * m.sqrt()).fold(0.0, f64::max);
            force.iter().zip(&inertia).any(|(force, m)| force.abs() / m.sqrt() > MAX_BACKWARD_ERROR * largest * size)
        };
        let shift = range.slowest.unwrap_or(range.fastest.max(1.0));
        Ok(Self {
            shift,
            undamped: rate.is_zero() && !circulates && modal.is_none(),
            free: (0..null.ncols()).filter(|column| !acts(*column)).collect(),
            stiffness: model.sparse_symmetric_stiffness(speed),
            model,
            speed,
            mass,
            rate,
            modal,
            null,
        })
    }

    /// States (x, z) of λ = 0: the positions of rigid-body modes, and the velocities on which nothing acts.
    pub fn rigid_states(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        let n = self.model.len();
        let state = move |column: usize, first: usize| {
            let mut state = vec![0.0; 2 * n];
            state[first..first + n].copy_from_slice(self.null.column(column).as_slice());
            state
        };
        let positions = (0..self.null.ncols()).map(move |column| state(column, 0));
        positions.chain(self.free.iter().map(move |column| state(*column, n)))
    }

    /// The rigid-body modes, on which modal damping has no effect.
    pub fn rigid_body_modes(&self) -> impl Iterator<Item = Eigenpair> + '_ {
        let shapes = self.null.column_iter().map(|column| column.map(Complex64::from));
        shapes.map(|shape| Eigenpair { value: Complex64::ZERO, shape })
    }

    /// Adds the part of a motion in the rigid-body modes to `sum`, both with n entries.
    pub fn add_rigid_part(&self, motion: &DVector<Complex64>, sum: &mut DVector<Complex64>) {
        let momentum = self.model.product(motion, |x, out| self.model.multiply_mass(x, out));
        for mode in self.null.column_iter() {
            let part: Complex64 = mode.iter().zip(&momentum).map(|(x, momentum)| momentum * *x).sum();
            sum.iter_mut().zip(&mode).for_each(|(sum, x)| *sum += part * *x);
        }
    }

    /// The same problem with K_symmetric and without D: that of the undamped modes.
    pub fn without_damping(&self) -> Self {
        Self {
            model: self.model,
            speed: self.speed,
            shift: self.shift,
            mass: self.mass.clone(),
            rate: Sparse::new(self.model.len(), Vec::new()),
            modal: None,
            stiffness: self.stiffness.clone(),
            undamped: true,
            null: self.null.clone(),
            free: (0..self.null.ncols()).collect(),
        }
    }

    /// Weights of S(λ); of a sparse matrix close to it with modal damping. Nowhere between them is a matrix singular, apart from
    /// the neighbourhood of eigenvalues.
    pub fn weights(&self, at: Complex64) -> Weights {
        let weights = Weights::dynamic(at, self.speed);
        if self.undamped {
            return Weights { damping: Complex64::ZERO, gyroscopic: Complex64::ZERO, symmetric: true, ..weights };
        }
        match self.modal {
            Some(modal) => modal.banded(at, weights),
            None => weights,
        }
    }

    /// Number of eigenvalues with |λ| < `radius` that are missing in `found`; `None` if it cannot be determined. Without damping it
    /// is the inertia of K − radius²·M (Sturm sequence; Golub and Van Loan, section 8.4).
    pub fn missing_in_disk(&self, found: &[Complex64], radius: f64) -> Option<i64> {
        if self.undamped {
            let matrix = self.model.dynamic_stiffness(&self.weights(Complex64::new(0.0, radius)), self.speed);
            let known = self.null.ncols() + found.iter().filter(|value| value.norm() < radius).count();
            if let Some(negative) = matrix.negative_eigenvalues() {
                return Some(negative as i64 - known as i64);
            }
        }
        let zeros = self.null.ncols() + if self.undamped { self.null.ncols() } else { self.free.len() };
        let determinant = |at: Complex64| {
            let matrix = self.model.dynamic_stiffness(&self.weights(at), self.speed);
            matrix.determinant().ok()
        };
        contour::missing_in_disk(determinant, &Known { zeros, values: found.to_vec() }, radius)
    }

    /// The root of λ² + λ φᴴDφ + φᴴKφ next to `value`, for φᴴMφ = 1. The elastic energy of the strains has less round-off
    /// than K.
    pub fn rayleigh(&self, value: Complex64, shape: &DVector<Complex64>) -> Complex64 {
        let parts = [shape.map(|entry| entry.re), shape.map(|entry| entry.im)];
        let elastic =
            |part: &DVector<f64>| self.model.elastic_form(part.as_slice(), |mesh| self.model.sigma(mesh, self.speed));
        let mut stiffness = Complex64::from(elastic(&parts[0]) + elastic(&parts[1]));
        let supports = self.model.supports.iter();
        let supports = supports.map(|support| (support, [shape[support.index], shape[support.index + 1]]));
        let links = self.model.links.iter().map(|link| (&link.local, link.complex_scalars(shape.as_slice())));
        for (element, local) in supports.chain(links) {
            for (row, left) in element.skew_part().iter().zip(local) {
                for (value, right) in row.iter().zip(local) {
                    stiffness += left.conj() * right * *value;
                }
            }
        }
        self.model.visit_circulation(&mut |row, column, value| {
            stiffness += shape[row].conj() * shape[column] * value;
        });
        let images = parts.each_ref().map(|part| {
            let mut image = DVector::zeros(part.len());
            self.rate.multiply_add(1.0, part.as_slice(), image.as_mut_slice());
            if let Some(modal) = self.modal {
                modal.multiply_add(1.0, part.as_slice(), image.as_mut_slice());
            }
            image
        });
        let rate = Complex64::new(
            parts[0].dot(&images[0]) + parts[1].dot(&images[1]),
            parts[0].dot(&images[1]) - parts[1].dot(&images[0]),
        );
        corrected(value, rate, stiffness)
    }
}

/// The root of λ² + λ·`rate` + `stiffness` next to `value`.
fn corrected(value: Complex64, rate: Complex64, stiffness: Complex64) -> Complex64 {
    let root = (rate * rate - 4.0 * stiffness).sqrt();
    let corrected = [(-rate + root) / 2.0, (-rate - root) / 2.0].into_iter().fold(
        Complex64::new(f64::INFINITY, 0.0),
        |best, one| {
            if (one - value).norm() < (best - value).norm() { one } else { best }
        },
    );
    let near = (corrected - value).norm() <= MAX_CORRECTION * value.norm();
    if near && (value.im != 0.0) == (corrected.im > 0.0) { corrected } else { value }
}

/// T of the first-order form.
pub(in crate::modal) struct FirstOrderInverse<'p, 'm> {
    problem: &'p Problem<'m>,
    factors: CoupledFactors,
    /// Modal damping.
    update: Option<Update>,
}

/// Change of the inverse of S by modal damping (Woodbury; Golub and Van Loan, Matrix Computations, 4th ed., section 2.1.4):
/// (S + sBRBᵀ)⁻¹ = S⁻¹ − X (I + sR BᵀX)⁻¹ sR Bᵀ S⁻¹ with X = S⁻¹B.
struct Update {
    /// X, n × m.
    responses: DMatrix<f64>,
    /// sR, m × m.
    rates: DMatrix<f64>,
    /// Factors of I + sR BᵀX, m × m.
    capacity: LuFactors<f64>,
}

impl<'p, 'm> FirstOrderInverse<'p, 'm> {
    /// T at the shift of the problem.
    pub fn new(problem: &'p Problem<'m>) -> Result<Self, DecompositionError> {
        let shift = problem.shift;
        let weights = Weights::dynamic(Complex64::from(shift), problem.speed);
        let factors = problem.model.dynamic_stiffness(&weights, problem.speed).factor()?;
        let update = problem.modal.map(|modal| -> Result<_, DecompositionError> {
            let responses = problem.model.solve_columns(&factors, &modal.momenta)?;
            let rates = &modal.rates * shift;
            let mut capacity = &rates * (modal.momenta.transpose() * &responses);
            (0..capacity.nrows()).for_each(|index| capacity[(index, index)] += 1.0);
            Ok(Update { responses, rates, capacity: LuFactors::new(&capacity) })
        });
        Ok(Self { problem, factors, update: update.transpose()? })
    }
}

impl Operator for FirstOrderInverse<'_, '_> {
    type Scalar = f64;
    const SYMMETRIC: bool = false;

    fn size(&self) -> usize {
        2 * self.problem.model.len()
    }

    fn apply(&self, state: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        let Problem { model, mass, rate, modal, shift, .. } = self.problem;
        let (x, z) = state.split_at(model.len());
        let velocity: Vec<f64> = x.iter().zip(z).map(|(x, z)| z + shift * x).collect();
        let mut force = vec![0.0; model.len()];
        mass.multiply_add(-1.0, &velocity, &mut force);
        rate.multiply_add(-1.0, x, &mut force);
        if let Some(modal) = modal {
            modal.multiply_add(-1.0, x, &mut force);
        }
        let mut image = model.solve_real(&self.factors, 0.0, &force)?;
        if let (Some(modal), Some(Update { responses, rates, capacity })) = (modal, &self.update) {
            let image = &mut DVectorViewMut::from_slice(&mut image, model.len());
            let modal = DMatrix::from_columns(&[rates * modal.momenta.tr_mul(image)]);
            image.gemv(-1.0, responses, &capacity.solve(&modal).column(0), 1.0);
        }
        for index in 0..model.len() {
            image.push(x[index] + shift * image[index]);
        }
        Ok(image)
    }

    /// The inner product is xᵀ(K + s²M)x' + zᵀMz', with the symmetric part of K.
    fn weigh(&self, state: &[f64]) -> Vec<f64> {
        let Problem { model, mass, shift, stiffness, .. } = self.problem;
        let (x, z) = state.split_at(model.len());
        let mut weighted = vec![0.0; state.len()];
        let (force, momentum) = weighted.split_at_mut(model.len());
        stiffness.multiply_add(1.0, x, force);
        mass.multiply_add(shift * shift, x, force);
        mass.multiply_add(1.0, z, momentum);
        weighted
    }
}
