//! Linear model in a subspace of the displacements: q = Φ η with ΦᵀMΦ = I.
//!
//! Galerkin projection keeps the structure of the second-order equations: mass and stiffness stay symmetric, damping
//! stays positive semidefinite, and the gyroscopic matrix stays skew-symmetric. A reduced model therefore has no growing
//! motion that the complete model does not have. The projection is repeatable: a subspace of a subspace is one too.

use std::sync::{Arc, OnceLock};

use nalgebra::DMatrix;

use super::components::modes_of_components;
use super::first_order::FirstOrder;
use super::real::RealModes;
use super::state_space::ModalStateSpace;
use crate::linalg::{DecompositionError, symmetric_pencil};
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
    /// The model in the modes of its components up to `limit`, rad/s, and in the static displacements under loads at the
    /// coordinates `loaded`, at `speed` of the reference shaft, rad/s. Modal damping acts on the modes of this subspace.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes cannot be computed.
    pub fn of_components(model: &Model, speed: f64, loaded: &[usize], limit: f64) -> Result<Self, DecompositionError> {
        let modes = modes_of_components(model, speed, loaded, limit)?;
        let damping = model.damping_matrix(speed) + model.gyroscopic_matrix() * speed;
        let mut projected = Self::new(model, modes, &damping);
        let ratio = model.scene.modal_damping;
        for (index, frequency) in projected.modes.frequencies.iter().enumerate() {
            projected.damping[(index, index)] += 2.0 * ratio * frequency;
        }
        projected.undamped &= ratio == 0.0;
        Ok(projected)
    }

    /// The model in undamped `modes`, with the n × n matrix `damping` of C + ΩG.
    pub(super) fn new(model: &Model, modes: RealModes, damping: &DMatrix<f64>) -> Self {
        let skew_part = model.skew_part_matrix();
        Self {
            damping: modes.project(damping),
            skew_part: modes.project(&skew_part),
            undamped: damping.amax() == 0.0 && skew_part.amax() == 0.0,
            modes,
            linear: OnceLock::new(),
        }
    }

    /// The same with a known state-space model.
    pub(super) fn with_state_space(self, linear: Arc<ModalStateSpace>) -> Self {
        Self { linear: OnceLock::from(linear), ..self }
    }

    /// Damping of an undamped mode by itself, 1/s.
    pub(super) fn damping_of(&self, mode: usize) -> f64 {
        self.damping[(mode, mode)]
    }

    /// The model in a subspace of this one; `directions` are its orthonormal directions in the coordinates η of the
    /// elastic modes, one per column. Rigid-body modes are always in the subspace.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes of the subspace cannot be computed.
    pub fn restricted(&self, model: &Model, speed: f64, directions: &DMatrix<f64>) -> Result<Self, DecompositionError> {
        let (null, elastic) = (self.modes.null, self.modes.frequencies.len() - self.modes.null);
        let frequencies = self.modes.frequencies.rows(null, elastic);
        let scaled = DMatrix::from_fn(elastic, directions.ncols(), |i, j| frequencies[i] * directions[(i, j)]);
        let stiffness = scaled.tr_mul(&scaled);
        let size = stiffness.nrows();
        let rotation = symmetric_pencil(&stiffness, &DMatrix::identity(size, size), &DMatrix::zeros(size, 0))?.vectors;
        let shapes = self.modes.vectors.columns(null, elastic) * (directions * rotation);
        let mut vectors = DMatrix::zeros(model.len(), null + size);
        vectors.columns_mut(0, null).copy_from(&self.modes.vectors.columns(0, null));
        vectors.columns_mut(null, size).copy_from(&shapes);
        let modes = RealModes::of_shapes(model, speed, vectors, null);
        let coordinates = self.modes.vectors.tr_mul(&model.mass_times(&modes.vectors));
        let project = |matrix: &DMatrix<f64>| coordinates.tr_mul(&(matrix * &coordinates));
        let (damping, skew_part) = (project(&self.damping), project(&self.skew_part));
        Ok(Self { modes, damping, skew_part, undamped: self.undamped, linear: OnceLock::new() })
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
