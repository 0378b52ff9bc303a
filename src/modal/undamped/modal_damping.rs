//! Modal damping: damping ratios ζ of the undamped modes of low frequency.
//!
//! ```text
//! D = B R Bᵀ,    B = MΦ,    R = diag(2ζω)
//! ```
//!
//! D has a low rank. The modes that are left out respond without damping; far above the frequencies in question they respond
//! as springs. A band matrix replaces D where only an approximation is needed: for motions of the frequency |λ|, the matrix
//! ζ(|λ|M + K/|λ|) with the ratio of the nearest mode has the same damping, and for others the difference is at most this
//! matrix itself, if all modes have the same ratio.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::real::RealModes;
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

impl ModalDamping {
    /// Damping of the elastic modes among the first `kept` ones, for modes up to |λ| = `reach`, rad/s.
    pub(in crate::modal) fn new(model: &Model, modes: &RealModes, kept: usize, reach: f64) -> Self {
        let (null, elastic) = (modes.null, kept.saturating_sub(modes.null));
        let momenta = model.mass_times(&modes.vectors.columns(null, elastic).into_owned());
        let ratios = model.scene.modal_damping.clone();
        let frequencies = modes.frequencies.as_slice()[null..null + elastic].to_vec();
        let rate = |(index, frequency): (usize, &f64)| 2.0 * ratios.of_mode(index, *frequency) * frequency;
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

    /// Weights of a band matrix close to S(λ) + λD for the weights of S(λ).
    pub(in crate::modal) fn banded(&self, eigenvalue: Complex64, weights: Weights) -> Weights {
        let size = eigenvalue.norm();
        let damping = eigenvalue / size * self.ratio_near(size);
        Weights { stiffness: weights.stiffness + damping, mass: weights.mass + damping * (size * size), ..weights }
    }
}
