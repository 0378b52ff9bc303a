//! Linear model in a subspace of the displacements: q = Φ η with ΦᵀMΦ = I.
//!
//! Galerkin projection keeps the structure of the second-order equations: mass and stiffness stay symmetric, damping
//! stays positive semidefinite, and the gyroscopic matrix stays skew-symmetric. A reduced model therefore has no growing
//! motion that the complete model does not have.

use std::sync::{Arc, OnceLock};

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::eigenvectors::{damped, undamped};
use super::first_order::FirstOrder;
use super::model::ModalStateSpace;
use crate::linalg::DecompositionError;
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
}

impl Projected {
    /// The model in undamped `modes`, at `speed` of the reference shaft, rad/s. Modal damping acts on these modes.
    pub(in crate::modal) fn new(model: &Model, modes: RealModes, speed: f64) -> Self {
        let (rate, skew_part) = (model.sparse_rate(speed), model.sparse_skew_part());
        let ratios = &model.scene.modal_damping;
        let mut damping = modes.project_sparse(&rate);
        for (index, frequency) in modes.frequencies.iter().enumerate().skip(modes.null) {
            damping[(index, index)] += ratios.rate(index - modes.null, *frequency);
        }
        Self {
            damping,
            skew_part: modes.project_sparse(&skew_part),
            undamped: rate.is_zero() && skew_part.is_zero() && ratios.is_zero(),
            modes,
            linear: OnceLock::new(),
        }
    }

    /// Eigenvalues with Im λ ≥ 0, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if the eigenvalue iteration fails.
    pub fn eigenvalues(&self) -> Result<Vec<Complex64>, DecompositionError> {
        let order = FirstOrder::projected(&self.modes, &self.damping, &self.skew_part, self.undamped);
        Ok(if self.undamped { undamped(&self.modes).0 } else { damped(&self.modes, &order)?.0 })
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
