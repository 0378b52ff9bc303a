//! Springs between single coordinates and the ground that constrain the null motions of a model.
//!
//! A null motion (rigid-body rotation, a shaft without bearings) has no stiffness, so K is singular. A load that drives no
//! null motion has a solution, which is unique but for null motions. With as many springs as there are null motions, on
//! coordinates that determine these, the matrix is regular. No spring carries a force: the load and K x do no work on the
//! null motions, so the springs do none either. The solution is therefore exact, whatever the stiffness of the springs.

use nalgebra::{ComplexField, DMatrix, DVector};
use num_complex::Complex64;

use crate::linalg::CoupledChains;
use crate::model::Model;

/// Springs that constrain null motions.
#[derive(Clone, Debug, Default)]
pub struct Pins {
    /// Null motions N, n × r, orthonormal in M.
    null: DMatrix<f64>,
    /// M N, n × r.
    weighted: DMatrix<f64>,
    /// Coordinate and stiffness of each spring, r entries.
    springs: Vec<(usize, f64)>,
}

impl Pins {
    /// Springs for the null motions of `null`, n × r and orthonormal in M.
    pub fn new(model: &Model, null: &DMatrix<f64>) -> Self {
        let stiffness = model.chain_stiffness();
        // The energy of a spring measures the motion of its coordinate, whatever the unit.
        let mut left = null.clone();
        for (mut row, stiffness) in left.row_iter_mut().zip(&stiffness) {
            row *= stiffness.sqrt();
        }
        let mut springs = Vec::with_capacity(null.ncols());
        for _ in 0..null.ncols() {
            // The coordinate that the remaining null motions move most; its motion is then taken out of them.
            let sizes = left.row_iter().map(|row| row.norm_squared()).enumerate();
            let (coordinate, _) = sizes.fold((0, -1.0), |most, one| if one.1 > most.1 { one } else { most });
            springs.push((coordinate, stiffness[coordinate]));
            let direction = left.row(coordinate).transpose().normalize();
            let along = &left * &direction;
            left -= along * direction.transpose();
        }
        Self { null: null.clone(), weighted: model.mass_times(null), springs }
    }

    /// Adds the springs to a matrix.
    pub fn add_to(&self, model: &Model, matrix: &mut CoupledChains) {
        for (coordinate, stiffness) in &self.springs {
            model.add_entry(matrix, *coordinate, *coordinate, Complex64::from(*stiffness));
        }
    }

    /// Part of a residual force that the springs carry, distributed like inertia forces that do the same work on the null
    /// motions. Connections do no work on them, so that the round-off of their forces has no part in it.
    pub fn carried(&self, residual: &DVector<f64>) -> DVector<f64> {
        &self.weighted * self.null.tr_mul(residual)
    }

    /// Subtracts the null motions of `x`, so that NᵀM x = 0.
    pub fn remove_null_motions<T: ComplexField<RealField = f64>>(&self, x: &mut DVector<T>) {
        for (null, weighted) in self.null.column_iter().zip(self.weighted.column_iter()) {
            let parts = x.iter().zip(weighted.iter()).map(|(x, weight)| x.clone().scale(*weight));
            let component = parts.fold(T::zero(), |sum, part| sum + part);
            x.iter_mut().zip(null.iter()).for_each(|(x, null)| *x -= component.clone().scale(*null));
        }
    }
}
