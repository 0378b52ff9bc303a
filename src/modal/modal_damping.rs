//! Modal damping: a damping ratio ζ on the undamped modes of low frequency.
//!
//! ```text
//! D = B diag(2ζω) Bᵀ,    B = MΦ
//! ```
//!
//! D has a low rank. The modes that are left out respond without damping; far above the frequencies in question they respond
//! as springs. A band matrix replaces D where only an approximation is needed: for motions of the frequency |λ|, the matrix
//! ζ(|λ|M + K/|λ|) has the same damping, and for others the difference is at most ζ(|λ|M + K/|λ|) itself.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::cached::CachedModel;
use super::lowest::lowest_undamped;
use super::real::RealModes;
use super::shift_invert::Problem;
use crate::linalg::DecompositionError;
use crate::model::{Model, Weights};

/// Smallest number of elastic modes with damping. In the machines of `examples/machines` with a ratio of 0.01, the others change
/// responses to bow and unbalance by less than 1e-5 of their size.
const MIN_DAMPED_MODES: usize = 60;
/// Smallest ratio of the highest frequency with damping to the highest one in question. In the same machines, modes beyond this
/// limit change eigenvalues by less than 1e-7 of their size.
const FREQUENCY_MARGIN: f64 = 8.0;
/// Part of all modes up to which a Krylov space gives the lowest ones faster than dense matrices give all.
const MAX_KRYLOV_FRACTION: f64 = 0.3;
/// Largest number of degrees of freedom for which dense matrices give all modes.
const MAX_DENSE: usize = 2000;
/// Smallest relative distance of the frequency of a mode that is left out from that of a damped one: the modes of both planes of a
/// shaft stay together.
const GAP: f64 = 1e-3;

/// Highest frequency in question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Highest {
    /// This frequency, rad/s.
    Frequency(f64),
    /// The undamped frequency of the mode with this number, rigid-body modes included.
    Mode(usize),
}

/// Damping of undamped modes.
#[derive(Debug)]
pub struct ModalDamping {
    /// ζ.
    pub ratio: f64,
    /// B, n × m in the order of the core.
    pub momenta: DMatrix<f64>,
    /// 2ζω, 1/s, m entries, positive.
    pub rates: DVector<f64>,
}

impl ModalDamping {
    /// Damping of all elastic `modes`.
    pub(super) fn of_modes(model: &Model, modes: &RealModes) -> Self {
        Self::of_lowest(model, modes, modes.frequencies.len())
    }

    /// The modal damping of a model for a highest frequency in question, with the loaded tooth flanks of `speed` (reference
    /// shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub(super) fn new(cached: &CachedModel, speed: f64, highest: Highest) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let largest = (MAX_KRYLOV_FRACTION * model.len() as f64) as usize;
        let mut size = MIN_DAMPED_MODES;
        loop {
            let is_last = 2 * size > largest;
            if size > largest && model.len() <= MAX_DENSE {
                return Ok(Self::of_modes(model, cached.real_modes(speed)?));
            }
            let Some(modes) = lowest_modes(cached, speed, size.min(largest))? else {
                return Ok(Self::of_modes(model, cached.real_modes(speed)?));
            };
            let limit = match highest {
                Highest::Frequency(frequency) => frequency,
                Highest::Mode(number) => modes.frequencies.get(number).copied().unwrap_or(f64::INFINITY),
            };
            let frequencies = modes.frequencies.as_slice();
            let kept = (1..frequencies.len())
                .rev()
                .find(|index| frequencies[*index] > (1.0 + GAP) * frequencies[index - 1])
                .unwrap_or(frequencies.len());
            if frequencies[kept - 1] >= FREQUENCY_MARGIN * limit || is_last && model.len() > MAX_DENSE {
                return Ok(Self::of_lowest(model, &modes, kept));
            }
            size *= 2;
        }
    }

    /// Damping of the elastic modes among the first `kept` ones.
    fn of_lowest(model: &Model, modes: &RealModes, kept: usize) -> Self {
        let ratio = model.scene.modal_damping;
        let elastic = kept - modes.null;
        let momenta = model.mass_times(&modes.vectors.columns(modes.null, elastic).into_owned());
        let rates = modes.frequencies.rows(modes.null, elastic) * (2.0 * ratio);
        Self { ratio, momenta, rates }
    }

    /// D X for real columns X, n × k.
    pub(super) fn times(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut modal = self.momenta.tr_mul(columns);
        modal.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.rates));
        &self.momenta * modal
    }

    /// Adds `factor`·D x to `sum`, both with n entries.
    pub(super) fn multiply_add(&self, factor: f64, x: &[f64], sum: &mut [f64]) {
        let mut modal = self.momenta.tr_mul(&nalgebra::DVectorView::from_slice(x, x.len()));
        modal.component_mul_assign(&self.rates);
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

    /// Weights of a band matrix close to S(λ) + λD for the weights of S(λ).
    pub(super) fn banded(&self, eigenvalue: Complex64, weights: Weights) -> Weights {
        let size = eigenvalue.norm();
        let damping = eigenvalue / size * self.ratio;
        Weights { stiffness: weights.stiffness + damping, mass: weights.mass + damping * (size * size), ..weights }
    }
}

/// The `count` lowest undamped modes from band matrices.
fn lowest_modes(cached: &CachedModel, speed: f64, count: usize) -> Result<Option<RealModes>, DecompositionError> {
    let model = &cached.model;
    let problem = Problem::new(model, speed, cached.spectral_range(speed)?, None)?.without_damping();
    undamped_modes(&problem, count)
}

/// The `count` lowest modes of an undamped problem.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub(super) fn undamped_modes(problem: &Problem<'_>, count: usize) -> Result<Option<RealModes>, DecompositionError> {
    let Some(pairs) = lowest_undamped(problem, count)? else {
        return Ok(None);
    };
    let columns: Vec<DVector<f64>> = pairs.iter().map(|pair| pair.shape.map(|value| value.re)).collect();
    let vectors = DMatrix::from_columns(&columns);
    Ok(Some(RealModes::of_shapes(problem.model, problem.speed, vectors, problem.null.ncols())))
}
