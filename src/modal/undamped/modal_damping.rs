//! Modal damping: damping ratios ζ of the undamped modes of low frequency.
//!
//! ```text
//! D = B R Bᵀ,    B = MΦ,    R = diag(2ζω)
//! ```
//!
//! D has a low rank. The modes that are left out respond without damping; far above the frequencies in question they respond
//! as springs. A sparse matrix replaces D where only an approximation is needed: for motions of the frequency |λ|, the matrix
//! ζ(|λ|M + K/|λ|) with the ratio of the nearest mode has the same damping, and for others the difference is at most this
//! matrix itself, if all modes have the same ratio.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::real::{RealModes, null_motions, times};
use crate::linalg::{DecompositionError, matrix_of_columns, symmetric_eigen};
use crate::model::{Model, Weights};
use crate::scene::DampingRatios;

/// Damping of undamped modes.
#[derive(Debug)]
pub struct ModalDamping {
    /// ζ of each mode.
    pub ratios: DampingRatios,
    /// ω of the damped modes, rad/s, ascending.
    pub frequencies: Vec<f64>,
    /// B = MV, n × m in the order of the core.
    pub momenta: Arc<DMatrix<f64>>,
    /// R, m × m symmetric, 1/s.
    pub rates: DMatrix<f64>,
    /// Largest |λ| of a mode that other damped modes would not change, rad/s; infinite if all modes have damping.
    pub reach: f64,
}

/// Undamped modes with their modal damping, for derivatives of D = MΦ diag(2ζω) ΦᵀM.
pub struct DampedMotions {
    /// Φ, n × m, orthonormal in M.
    pub shapes: DMatrix<f64>,
    /// MΦ, n × m.
    pub momenta: DMatrix<f64>,
    /// ω² of each mode, 1/s².
    pub squares: Vec<f64>,
    /// Number of modes with damping, the first ones.
    pub damped: usize,
}

impl DampedMotions {
    /// 2ζω of modes with these ω², 1/s.
    pub fn rates(ratios: &DampingRatios, squares: &[f64]) -> Vec<f64> {
        let rate = |(index, square): (usize, &f64)| ratios.rate(index, square.max(0.0).sqrt());
        squares.iter().enumerate().map(rate).collect()
    }
}

impl ModalDamping {
    /// The modes of the model in the space of its momenta, and its rigid-body modes at the end, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition of the projected stiffness fails.
    pub fn motions(&self, model: &Model, speed: f64) -> Result<DampedMotions, DecompositionError> {
        let (mut shapes, mut momenta) = ((*self.momenta).clone(), (*self.momenta).clone());
        shapes.as_mut_slice().chunks_exact_mut(model.len().max(1)).for_each(|shape| model.solve_mass(shape));
        let mut squares: Vec<f64> = self.frequencies.iter().map(|frequency| frequency * frequency).collect();
        // The momenta of modes have diagonal rates; modes of equal frequency keep their ratios.
        if self.rates != DMatrix::from_diagonal(&self.rates.diagonal()) {
            let stiffness = shapes.transpose() * times(&model.sparse_symmetric_stiffness(speed), &shapes);
            let modes = symmetric_eigen(&((&stiffness + stiffness.transpose()) / 2.0))?;
            squares = modes.values.iter().copied().collect();
            (shapes, momenta) = (shapes * &modes.vectors, momenta * modes.vectors);
        }
        let null = null_motions(model, speed)?;
        squares.resize(squares.len() + null.ncols(), 0.0);
        let with = |columns: &DMatrix<f64>, null: &DMatrix<f64>| {
            matrix_of_columns(model.len(), &columns.column_iter().chain(null.column_iter()).collect::<Vec<_>>())
        };
        let (shapes, momenta) = (with(&shapes, &null), with(&momenta, &model.mass_times(&null)));
        Ok(DampedMotions { shapes, momenta, squares, damped: self.frequencies.len() })
    }

    /// Damping of elastic modes, for modes up to |λ| = `reach`, rad/s.
    pub(in crate::modal) fn new(model: &Model, modes: &RealModes, reach: f64) -> Self {
        let (null, elastic) = (modes.null, modes.frequencies.len() - modes.null);
        let momenta = model.mass_times(&modes.vectors.columns(null, elastic).into_owned());
        let ratios = model.scene.modal_damping.clone();
        let frequencies = modes.frequencies.as_slice()[null..null + elastic].to_vec();
        let rate = |(index, frequency): (usize, &f64)| ratios.rate(index, *frequency);
        let rates = DVector::from_iterator(elastic, frequencies.iter().enumerate().map(rate));
        Self { rates: DMatrix::from_diagonal(&rates), ratios, frequencies, momenta: Arc::new(momenta), reach }
    }

    /// Adds `factor`·D x to `sum`, both with n entries.
    pub(in crate::modal) fn multiply_add(&self, factor: f64, x: &[f64], sum: &mut [f64]) {
        let modal = &self.rates * self.momenta.tr_mul(&nalgebra::DVectorView::from_slice(x, x.len()));
        let length = sum.len();
        nalgebra::DVectorViewMut::from_slice(sum, length).gemv(factor, &self.momenta, &modal, 1.0);
    }

    /// D x, n entries.
    pub fn product(&self, model: &Model, x: &DVector<Complex64>) -> DVector<Complex64> {
        model.product(x, |x, out| {
            out.fill(0.0);
            self.multiply_add(1.0, x, out);
        })
    }

    /// ζ of the mode whose frequency is nearest, rad/s.
    fn ratio_near(&self, frequency: f64) -> f64 {
        let above = self.frequencies.partition_point(|known| *known < frequency);
        let distance = |index: &usize| self.frequencies.get(*index).map_or(f64::INFINITY, |w| (w - frequency).abs());
        let below = above.saturating_sub(1);
        let nearest = if distance(&below) < distance(&above) { below } else { above };
        self.ratios.of_mode(nearest, frequency)
    }

    /// Weights of a sparse matrix close to S(λ) + λD for the weights of S(λ).
    pub(in crate::modal) fn banded(&self, eigenvalue: Complex64, weights: Weights) -> Weights {
        let size = eigenvalue.norm();
        let damping = eigenvalue / size * self.ratio_near(size);
        Weights { stiffness: weights.stiffness + damping, mass: weights.mass + damping * (size * size), ..weights }
    }
}
