//! Galerkin projection of the eigenvalue problem on a growing space.
//!
//! The space has undamped modes Φ of low frequency, and further directions W. The basis is orthonormal in M.

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::shift_invert::{Problem, corrected};
use crate::connection::Row;
use crate::linalg::{DecompositionError, Sparse, symmetric_pencil};
use crate::modal::state_space::{FirstOrder, damped};
use crate::modal::undamped::{RealModes, ShiftInverse, mass_times, times};

/// A direction that loses more than this factor in orthogonalization lies in the space.
const DEPENDENT: f64 = 1e-10;
/// A damper is effective at a rate s if its force is between 1/8 of the force (K + s²M)x and 8 times this force, for some
/// displacement x.
const EFFECTIVE: f64 = 8.0;
/// Eigenvalue of the scaled flexibility of the dampers, relative to the largest one, below which dampers share a direction.
const SHARED: f64 = 1e-10;
/// Ratio of the shift of a refinement to the eigenvalue: the matrix of an eigenvalue is singular.
const OFFSET: f64 = 1.01;

/// The space.
pub(in crate::modal) struct Galerkin<'p, 'm> {
    problem: &'p Problem<'m>,
    /// K − K_symmetric.
    skew_part: Sparse,
    /// V = [Φ, W], n × k; the first columns are rigid-body modes.
    basis: DMatrix<f64>,
    /// M V, n × k.
    momenta: DMatrix<f64>,
    /// Number of rigid-body modes.
    null: usize,
}

/// An approximation of an eigenpair.
#[derive(Clone, Debug)]
pub(in crate::modal) struct Approximation {
    /// λ with Im λ ≥ 0, rad/s.
    pub value: Complex64,
    /// Components of the mode shape in the basis, k entries of unit length.
    pub components: DVector<Complex64>,
}

impl<'p, 'm> Galerkin<'p, 'm> {
    /// The space of the undamped `modes`.
    pub fn new(problem: &'p Problem<'m>, modes: RealModes) -> Self {
        Self {
            skew_part: problem.model.sparse_skew_part(),
            momenta: problem.model.mass_times(&modes.vectors),
            basis: modes.vectors,
            null: modes.null,
            problem,
        }
    }

    /// Number of directions.
    pub fn size(&self) -> usize {
        self.basis.ncols()
    }

    /// Adds directions, n entries each.
    pub fn add(&mut self, directions: &[DVector<f64>]) {
        let model = self.problem.model;
        for direction in directions {
            let mut vector = direction.clone();
            let mut momentum = DVector::from_vec(mass_times(model, vector.as_slice()));
            let before = vector.dot(&momentum).max(0.0).sqrt();
            for _ in 0..2 {
                let parts = self.basis.tr_mul(&momentum);
                vector.gemv(-1.0, &self.basis, &parts, 1.0);
                momentum = DVector::from_vec(mass_times(model, vector.as_slice()));
            }
            let after = vector.dot(&momentum).max(0.0).sqrt();
            if after > DEPENDENT * before && after.is_finite() {
                let column = self.basis.ncols();
                self.basis = std::mem::take(&mut self.basis).insert_column(column, 0.0);
                self.basis.set_column(column, &vector.unscale(after));
                self.momenta = std::mem::take(&mut self.momenta).insert_column(column, 0.0);
                self.momenta.set_column(column, &momentum.unscale(after));
            }
        }
    }

    /// Adds the responses to the forces of dampers and circulatory springs at the rates s (1/s) at which these are effective.
    pub fn add_dampers(&mut self, rates: impl Iterator<Item = f64>) -> Result<(), DecompositionError> {
        let Problem { model, speed, .. } = *self.problem;
        let force = |row: &Row| {
            let mut force = DVector::zeros(model.len());
            row.iter().for_each(|(index, coefficient)| force[*index] += coefficient);
            force
        };
        let forces: Vec<DVector<f64>> = self.problem.damper_rows().iter().map(force).collect();
        if forces.is_empty() {
            return Ok(());
        }
        let forces = DMatrix::from_columns(&forces);
        let mut directions = Vec::new();
        for rate in rates {
            let responses = ShiftInverse::new(model, speed, rate)?.solve_columns(&forces)?;
            directions.extend(self.effective(rate, &forces, &responses));
        }
        self.add(&directions);
        Ok(())
    }

    /// The combinations of responses (K + s²M)⁻¹ f to forces at a rate s, 1/s, in which the forces of dampers and circulatory
    /// springs are effective.
    fn effective(&self, rate: f64, forces: &DMatrix<f64>, responses: &DMatrix<f64>) -> Vec<DVector<f64>> {
        let flexibility = forces.transpose() * responses;
        let scale = flexibility.diagonal().map(|value| 1.0 / value.max(f64::MIN_POSITIVE).sqrt());
        let scale = DMatrix::from_diagonal(&scale);
        let scaled = &scale * (&flexibility + flexibility.transpose()) * &scale / 2.0;
        let found = scaled.symmetric_eigen();
        let largest = found.eigenvalues.max();
        let kept: Vec<usize> =
            (0..forces.ncols()).filter(|index| found.eigenvalues[*index] > SHARED * largest).collect();
        let unit = |index: &usize| found.eigenvectors.column(*index) / found.eigenvalues[*index].sqrt();
        let unit = DMatrix::from_columns(&kept.iter().map(unit).collect::<Vec<_>>());
        // Orthonormal in K + s²M.
        let normal = responses * (scale * unit);
        let damping = times(&self.problem.rate, &normal) * rate + times(&self.skew_part, &normal);
        let ratio = normal.transpose() * damping;
        let ratio = (ratio.transpose() * ratio).symmetric_eigen();
        let is_effective = |index: &usize| (EFFECTIVE.powi(-2)..EFFECTIVE.powi(2)).contains(&ratio.eigenvalues[*index]);
        (0..kept.len()).filter(is_effective).map(|index| &normal * ratio.eigenvectors.column(index)).collect()
    }

    /// Eigenpairs of the projected problem apart from rigid-body modes.
    pub fn eigenpairs(&self) -> Result<Vec<Approximation>, DecompositionError> {
        let model = self.problem.model;
        let (null, elastic) = (self.null, self.basis.ncols() - self.null);
        let columns = self.basis.columns(null, elastic).into_owned();
        let stiffness = columns.transpose() * times(&self.problem.stiffness, &columns);
        let stiffness = (&stiffness + stiffness.transpose()) / 2.0;
        let rotation =
            symmetric_pencil(&stiffness, &DMatrix::identity(elastic, elastic), &DMatrix::zeros(elastic, 0))?.vectors;
        let mut vectors = DMatrix::zeros(model.len(), null + elastic);
        vectors.columns_mut(0, null).copy_from(&self.basis.columns(0, null));
        vectors.columns_mut(null, elastic).copy_from(&(columns * rotation));
        let modes = RealModes::of_shapes(model, self.problem.speed, vectors, null);
        // Ψ = V R.
        let rotation = self.momenta.transpose() * &modes.vectors;
        let mut damping = modes.project_sparse(&self.problem.rate);
        if let Some(modal) = self.problem.modal {
            damping += modes.vectors.transpose() * modal.times(&modes.vectors);
        }
        let skew_part = modes.project_sparse(&self.skew_part);
        let order = FirstOrder::projected(&modes, &damping, &skew_part, false);
        let (values, coordinates) = damped(&modes, &order)?;
        let rest = values.into_iter().zip(coordinates).filter(|(value, _)| *value != Complex64::ZERO);
        let approximation = |(value, eta): (Complex64, DVector<Complex64>)| {
            let rate = eta.dotc(&product(&damping, &eta));
            let elastic: f64 =
                eta.iter().zip(&modes.frequencies).map(|(x, frequency)| x.norm_sqr() * frequency.powi(2)).sum();
            let stiffness = eta.dotc(&product(&skew_part, &eta)) + elastic;
            let value = corrected(value, rate, stiffness);
            // A real eigenvalue has no sign of zero, which would count in the order.
            let value = Complex64::new(value.re, value.im.abs());
            Approximation { value, components: product(&rotation, &eta) }
        };
        Ok(rest.map(approximation).collect())
    }

    /// Mode shape, n entries.
    pub fn shape(&self, of: &Approximation) -> DVector<Complex64> {
        product(&self.basis, &of.components)
    }

    /// S(σ)⁻¹ r for the residual r of an approximation, with the dynamic stiffness S as a band matrix and a shift σ close to
    /// the eigenvalue: the error of the mode shape, outside of the space. Second: its size relative to the mode shape in the
    /// energy norm xᴴ(K_symmetric + |λ|²M)x.
    pub fn error(&self, of: &Approximation) -> Result<(DVector<Complex64>, f64), DecompositionError> {
        let Problem { model, speed, .. } = *self.problem;
        let (value, shape) = (of.value, self.shape(of));
        let mass = model.product(&shape, |x, out| model.multiply_mass(x, out)) * (value * value);
        let rate = model.product(&shape, |x, out| {
            self.problem.rate.multiply_add(1.0, x, out);
            if let Some(modal) = self.problem.modal {
                modal.multiply_add(1.0, x, out);
            }
        }) * value;
        let elastic = model.product(&shape, |x, out| model.multiply_stiffness(speed, false, x, out));
        let mut error = model.to_circular((elastic + mass + rate).as_slice());
        let weights = self.problem.weights(value * OFFSET);
        let factors = model.dynamic_stiffness(&weights, speed).factor(if value.re < 0.0 { -1.0 } else { 1.0 })?;
        factors.solve(&mut error)?;
        let mut error = DVector::from_vec(model.from_circular(&error));
        error -= product(&self.basis, &product(&self.momenta.transpose(), &error));
        let energy = |x: &DVector<Complex64>| {
            let elastic = model.product(x, |x, out| self.problem.stiffness.multiply_add(1.0, x, out));
            x.dotc(&elastic).re.max(0.0) + value.norm_sqr() * model.complex_kinetic_form(x)
        };
        let size = (energy(&error) / energy(&shape)).sqrt();
        Ok((error, size))
    }
}

/// A x for a real matrix A.
fn product(matrix: &DMatrix<f64>, x: &DVector<Complex64>) -> DVector<Complex64> {
    let part = |of: fn(&Complex64) -> f64| matrix * x.map(|value| of(&value));
    part(|value| value.re).zip_map(&part(|value| value.im), Complex::new)
}
