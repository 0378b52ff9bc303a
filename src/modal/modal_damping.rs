//! Modal damping: a damping ratio ζ on the undamped modes of low frequency.
//!
//! ```text
//! D = B R Bᵀ,    B = MΦ,    R = diag(2ζω)
//! ```
//!
//! D has a low rank. If bearings change with the speed, B = MV with a space V that contains the modes at every speed, and R
//! = Q diag(2ζω) Qᵀ for the modes Φ = VQ: a new speed takes a small eigenproblem. The modes that are left out respond without damping; far above the frequencies in question they respond
//! as springs. A band matrix replaces D where only an approximation is needed: for motions of the frequency |λ|, the matrix
//! ζ(|λ|M + K/|λ|) has the same damping, and for others the difference is at most ζ(|λ|M + K/|λ|) itself.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::cached::CachedModel;
use super::lowest::lowest_undamped;
use super::projected::Projected;
use super::real::{RealModes, null_motions, times};
use super::shift_invert::Problem;
use super::spectral_range::ShiftInverse;
use crate::connection::Row;
use crate::linalg::{DecompositionError, symmetric_pencil};
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
/// Part of a static displacement outside of the others below which it is left out.
const DEPENDENCE_TOLERANCE: f64 = 1e-8;

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
    /// B = MV, n × m in the order of the core.
    pub momenta: Arc<DMatrix<f64>>,
    /// R, m × m symmetric, 1/s.
    pub rates: DMatrix<f64>,
}

/// A space of displacements V that contains the undamped modes of low frequency at all speeds, because it contains those of one
/// model and the static displacements of the others under loads on the bearings (MacNeal 1971, Rubin 1975).
#[derive(Debug)]
pub struct ModalSpace {
    /// V, n × m, elastic motions orthonormal in M.
    shapes: DMatrix<f64>,
    /// MV.
    momenta: Arc<DMatrix<f64>>,
    /// Number of damped modes.
    damped: usize,
    /// Highest frequency of the modes, rad/s.
    pub(super) highest: f64,
}

impl ModalDamping {
    /// Damping of all elastic `modes`.
    pub(super) fn of_modes(model: &Model, modes: &RealModes) -> Self {
        Self::of_lowest(model, &DampedModes { shapes: modes.clone(), kept: modes.frequencies.len() })
    }

    /// The modal damping of a model for a highest frequency in question, with the loaded tooth flanks of `speed` (reference
    /// shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub(super) fn new(cached: &CachedModel, speed: f64, highest: Highest) -> Result<Self, DecompositionError> {
        Ok(Self::of_lowest(&cached.model, &DampedModes::new(cached, speed, highest)?))
    }

    /// Damping of the elastic modes among the first `kept` ones.
    fn of_lowest(model: &Model, modes: &DampedModes) -> Self {
        let (null, elastic) = (modes.shapes.null, modes.elastic());
        let momenta = model.mass_times(&modes.shapes.vectors.columns(null, elastic).into_owned());
        let ratio = model.scene.modal_damping;
        let rates = DMatrix::from_diagonal(&(modes.shapes.frequencies.rows(null, elastic) * (2.0 * ratio)));
        Self { ratio, momenta: Arc::new(momenta), rates }
    }

    /// Damping of the modes of `model` in a space, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition of the projected stiffness fails.
    pub(super) fn in_space(model: &Model, speed: f64, space: &ModalSpace) -> Result<Self, DecompositionError> {
        let stiffness = space.shapes.tr_mul(&times(&model.sparse_symmetric_stiffness(speed), &space.shapes));
        let size = stiffness.nrows();
        let symmetric = (&stiffness + stiffness.transpose()) / 2.0;
        let modes = symmetric_pencil(&symmetric, &DMatrix::identity(size, size), &DMatrix::zeros(size, 0))?;
        let ratio = model.scene.modal_damping;
        let kept = modes.vectors.columns(0, space.damped.min(size)).into_owned();
        let mut scaled = kept.clone();
        for (mut column, value) in scaled.column_iter_mut().zip(&modes.values) {
            column *= 2.0 * ratio * value.max(0.0).sqrt();
        }
        Ok(Self { ratio, momenta: Arc::clone(&space.momenta), rates: scaled * kept.transpose() })
    }

    /// D X for real columns X, n × k.
    pub(super) fn times(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        &*self.momenta * (&self.rates * self.momenta.tr_mul(columns))
    }

    /// Adds `factor`·D x to `sum`, both with n entries.
    pub(super) fn multiply_add(&self, factor: f64, x: &[f64], sum: &mut [f64]) {
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

    /// Weights of a band matrix close to S(λ) + λD for the weights of S(λ).
    pub(super) fn banded(&self, eigenvalue: Complex64, weights: Weights) -> Weights {
        let size = eigenvalue.norm();
        let damping = eigenvalue / size * self.ratio;
        Weights { stiffness: weights.stiffness + damping, mass: weights.mass + damping * (size * size), ..weights }
    }
}

impl ModalSpace {
    /// The space for a highest frequency in question: modes of `cached`, and static displacements under the loads `rows`, with the
    /// loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub(super) fn new(
        cached: &CachedModel,
        rows: &[Row],
        speed: f64,
        highest: Highest,
    ) -> Result<Self, DecompositionError> {
        Self::of_modes(cached, rows, speed, &DampedModes::new(cached, speed, highest)?)
    }

    /// The same with the `count` lowest modes; `None` if band matrices do not give them.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub(super) fn of_lowest(
        cached: &CachedModel,
        rows: &[Row],
        speed: f64,
        count: usize,
    ) -> Result<Option<Self>, DecompositionError> {
        let Some(shapes) = lowest_modes(cached, speed, count)? else {
            return Ok(None);
        };
        Self::of_modes(cached, rows, speed, &DampedModes { kept: shapes.frequencies.len(), shapes }).map(Some)
    }

    /// The space of known modes and of static displacements.
    fn of_modes(
        cached: &CachedModel,
        rows: &[Row],
        speed: f64,
        modes: &DampedModes,
    ) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let (null, damped) = (modes.shapes.null, modes.elastic());
        let known = modes.shapes.vectors.columns(0, null + damped).into_owned();
        let mut loads = DMatrix::zeros(model.len(), rows.len());
        for (row, mut load) in rows.iter().zip(loads.column_iter_mut()) {
            row.iter().for_each(|(index, coefficient)| load[*index] += coefficient);
        }
        let shift = cached.spectral_range(speed)?.slowest.unwrap_or(1.0);
        let mut statics = ShiftInverse::new(model, speed, shift)?.solve_columns(&loads)?;
        let norm = |x: nalgebra::DVectorView<'_, f64>| model.kinetic_form(x.into_owned().as_slice()).sqrt();
        let scale =
            DVector::from_iterator(rows.len(), statics.column_iter().map(|x| 1.0 / norm(x).max(f64::MIN_POSITIVE)));
        // The known modes are orthonormal in M.
        for _ in 0..2 {
            statics -= &known * known.tr_mul(&model.mass_times(&statics));
        }
        let mut form = statics.tr_mul(&model.mass_times(&statics));
        form.iter_mut().enumerate().for_each(|(place, value)| {
            *value *= scale[place % rows.len()] * scale[place / rows.len()];
        });
        let found = form.symmetric_eigen();
        let independent = (0..rows.len()).filter(|index| found.eigenvalues[*index] > DEPENDENCE_TOLERANCE);
        let scaled = DMatrix::from_diagonal(&scale);
        let mut columns: Vec<DVector<f64>> = known.column_iter().skip(null).map(|column| column.into_owned()).collect();
        columns
            .extend(independent.map(|index| {
                &statics * (&scaled * found.eigenvectors.column(index)) / found.eigenvalues[index].sqrt()
            }));
        let shapes = DMatrix::from_columns(&columns);
        let momenta = Arc::new(model.mass_times(&shapes));
        let highest = modes.shapes.frequencies[modes.kept - 1];
        Ok(Self { shapes, momenta, damped, highest })
    }

    /// A model in this space at `speed` of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub(super) fn project(&self, model: &Model, speed: f64) -> Result<Projected, DecompositionError> {
        let null = null_motions(model, speed)?;
        let columns: Vec<_> = null.column_iter().chain(self.shapes.column_iter()).map(|x| x.into_owned()).collect();
        let modes = RealModes::in_subspace(model, speed, &DMatrix::from_columns(&columns))?;
        Ok(Projected::new(model, modes, speed))
    }
}

/// The lowest undamped modes, of which the first `kept` ones have damping.
struct DampedModes {
    shapes: RealModes,
    kept: usize,
}

impl DampedModes {
    fn new(cached: &CachedModel, speed: f64, highest: Highest) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let all = || -> Result<Self, DecompositionError> {
            let shapes = cached.real_modes(speed)?.clone();
            Ok(Self { kept: shapes.frequencies.len(), shapes })
        };
        let largest = (MAX_KRYLOV_FRACTION * model.len() as f64) as usize;
        let mut size = MIN_DAMPED_MODES;
        loop {
            let is_last = 2 * size > largest;
            if size > largest && model.len() <= MAX_DENSE {
                return all();
            }
            let Some(shapes) = lowest_modes(cached, speed, size.min(largest))? else {
                return all();
            };
            let limit = match highest {
                Highest::Frequency(frequency) => frequency,
                Highest::Mode(number) => shapes.frequencies.get(number).copied().unwrap_or(f64::INFINITY),
            };
            let frequencies = shapes.frequencies.as_slice();
            let kept = (1..frequencies.len())
                .rev()
                .find(|index| frequencies[*index] > (1.0 + GAP) * frequencies[index - 1])
                .unwrap_or(frequencies.len());
            if frequencies[kept - 1] >= FREQUENCY_MARGIN * limit || is_last && model.len() > MAX_DENSE {
                return Ok(Self { shapes, kept });
            }
            size *= 2;
        }
    }

    /// Number of elastic modes with damping.
    fn elastic(&self) -> usize {
        self.kept.saturating_sub(self.shapes.null)
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
