//! Linear model in a subspace of the displacements: q = Φ η with ΦᵀMΦ = I.
//!
//! Galerkin projection keeps the structure of the second-order equations: mass and stiffness stay symmetric, damping
//! stays positive semidefinite, and the gyroscopic matrix stays skew-symmetric. A reduced model therefore has no growing
//! motion that the complete model does not have.

use std::sync::{Arc, OnceLock};

use nalgebra::{Complex, DMatrix, DVector};

use super::first_order::FirstOrder;
use super::model::ModalStateSpace;
use super::recent::Recent;
use crate::linalg::{DecompositionError, LuFactors};
use crate::modal::undamped::RealModes;
use crate::model::Model;

/// Undamped modes of a subspace, with the other linear forces in their coordinates η.
#[derive(Clone, Debug)]
pub struct Projected {
    /// Undamped modes of the subspace, n rows, m columns.
    pub modes: RealModes,
    /// Φᵀ(C + ΩG)Φ with modal damping, m × m.
    damping: DMatrix<f64>,
    /// Φᵀ(K − K_symmetric)Φ, m × m.
    skew_part: DMatrix<f64>,
    /// Whether C + ΩG and K − K_symmetric are zero.
    undamped: bool,
    /// State-space model, computed at the first use.
    linear: OnceLock<Arc<ModalStateSpace>>,
    /// Factors of the dynamic stiffness with modal damping at the last spins, rad/s.
    dynamic: Arc<Recent<f64, Arc<LuFactors<Complex<f64>>>>>,
}

impl Projected {
    /// The model in undamped `modes`, at `speed` of the reference shaft, rad/s. Modal damping acts on these modes.
    pub(in crate::modal) fn new(model: &Model, modes: RealModes, speed: f64) -> Self {
        let (rate, skew_part, ratio) = (model.sparse_rate(speed), model.sparse_skew_part(), model.scene.modal_damping);
        let mut damping = modes.project_sparse(&rate);
        for (index, frequency) in modes.frequencies.iter().enumerate() {
            damping[(index, index)] += 2.0 * ratio * frequency;
        }
        Self {
            damping,
            skew_part: modes.project_sparse(&skew_part),
            undamped: rate.is_zero() && skew_part.is_zero() && ratio == 0.0,
            modes,
            linear: OnceLock::new(),
            dynamic: Arc::default(),
        }
    }

    /// Adds the effect of modal damping, in this subspace, to the synchronous motion `bare` of the complete model without
    /// it: complex displacement amplitudes, n entries, under a force that rotates with `spin`, rad/s.
    ///
    /// Both satisfy S x = f with S = K − Ω²M + iΩ(C + ΩG); modal damping D adds iΩD to S, so that their difference y solves
    /// (S + iΩD) y = −iΩD x.
    pub fn with_modal_damping(&self, model: &Model, spin: f64, bare: DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let (ratio, size) = (model.scene.modal_damping, self.modes.frequencies.len());
        let part = |of: fn(&Complex<f64>) -> f64| {
            self.modes.vectors.tr_mul(&model.mass_times(&DMatrix::from_columns(&[bare.map(|value| of(&value))])))
        };
        let (re, im) = (part(|value| value.re), part(|value| value.im));
        let force = DMatrix::from_fn(size, 1, |mode, _| {
            Complex::new(im[mode], -re[mode]) * (spin * 2.0 * ratio * self.modes.frequencies[mode])
        });
        let entry = |i: usize, j: usize| {
            let diagonal = if i == j { self.modes.frequencies[i].powi(2) - spin * spin } else { 0.0 };
            Complex::new(diagonal + self.skew_part[(i, j)], spin * self.damping[(i, j)])
        };
        let factors = || LuFactors::new(&DMatrix::from_fn(size, size, entry));
        let change = self.dynamic.get_or(spin, || Arc::new(factors())).solve(&force);
        let [re, im] = [|value: Complex<f64>| value.re, |value: Complex<f64>| value.im]
            .map(|of| &self.modes.vectors * change.map(of));
        bare.zip_zip_map(&re.column(0), &im.column(0), |value, re, im| value + Complex::new(re, im))
    }

    /// The same with a known state-space model.
    pub(in crate::modal) fn with_state_space(self, linear: Arc<ModalStateSpace>) -> Self {
        Self { linear: OnceLock::from(linear), ..self }
    }

    /// State-space model of the subspace.
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition fails.
    pub fn state_space(&self) -> Result<Arc<ModalStateSpace>, DecompositionError> {
        if let Some(known) = self.linear.get() {
            return Ok(Arc::clone(known));
        }
        let order = FirstOrder::projected(&self.modes, &self.damping, &self.skew_part, self.undamped);
        let found = Arc::new(ModalStateSpace::new(&self.modes, &order)?);
        Ok(Arc::clone(self.linear.get_or_init(|| found)))
    }
}
