//! A model together with its modes and state-space models, computed on first use and kept.

use std::any::Any;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector};

use super::components::ComponentModes;
use super::equilibrium::{EquilibriumError, EquilibriumSpeeds, equilibrium};
use super::first_order::FirstOrder;
use super::load_modes::modes_of_loads;
use super::projected::Projected;
use super::real::RealModes;
use super::recent::Recent;
use super::spectral_range::SpectralRange;
use super::state_space::ModalStateSpace;
use crate::linalg::{CoupledFactors, DecompositionError};
use crate::mesh::Geometry;
use crate::model::Model;
use crate::scene::{EntryPath, SceneError};

/// Smallest number of degrees of freedom for which a Krylov space gives two frequencies faster than all modes.
const MIN_KRYLOV: usize = 100;

/// Speed of the reference shaft, rad/s, and whether the meshes are included.
type Key = (f64, bool);

/// What a subspace depends on: speed of the reference shaft, rad/s, highest frequency, rad/s, and the scalars of its loads
/// and signals as entries (index, coefficient).
type SubspaceKey = (f64, f64, Vec<Vec<(usize, f64)>>);

/// What the dynamic stiffness without modal damping depends on: speed of the reference shaft, spin of the source shaft and
/// speed of the flanks in contact, rad/s.
type DynamicKey = [f64; 3];

/// What follows from the linear part of a model alone, computed on first use: of the loads, only torques over the speed have an
/// effect on it, their damping.
#[derive(Debug, Default)]
struct LinearPart {
    /// Undamped modes for each [`crate::model::Rotation`].
    modes: [OnceLock<Result<RealModes, DecompositionError>>; 3],
    /// Lowest and highest frequency for each [`crate::model::Rotation`].
    ranges: [OnceLock<Result<SpectralRange, DecompositionError>>; 3],
    /// State-space models; `None` marks a model that modes cannot represent.
    linear: Recent<Key, Option<Arc<ModalStateSpace>>>,
    /// Undamped modes of the components.
    components: OnceLock<Result<ComponentModes, DecompositionError>>,
    /// Subspaces.
    subspaces: Recent<SubspaceKey, Arc<Projected>>,
    /// Factors of the dynamic stiffness at the last speeds.
    dynamic: Recent<DynamicKey, Arc<CoupledFactors>>,
    /// The linear parts at the speeds (rad/s) of the last analyses, if bearings depend on the speed.
    at_speeds: Recent<f64, Arc<LinearPart>>,
}

/// A model with its undamped modes and its most recent state-space models.
#[derive(Debug)]
pub struct CachedModel {
    /// Assembled model.
    pub model: Model,
    /// Modes and state-space models, which models with other loads may share.
    linear_part: OnceLock<Arc<LinearPart>>,
    /// Models at the speeds (rad/s) of the last analyses, if bearings depend on the speed.
    at_speeds: Recent<f64, Arc<CachedModel>>,
    /// Displacements of the last static equilibria.
    equilibria: Recent<(Geometry, EquilibriumSpeeds), DVector<f64>>,
    /// Results of runs; their type belongs to a later folder.
    run_results: OnceLock<Arc<dyn Any + Send + Sync>>,
    /// The model of which this one is a variation.
    base: Option<Arc<CachedModel>>,
}

/// A model at a constant speed: the model itself if nothing in it depends on the speed.
#[derive(Debug)]
pub enum AtSpeed<'a> {
    /// The model itself.
    Same(&'a CachedModel),
    /// A model whose bearings have the coefficients of the speed.
    Specialised(Arc<CachedModel>),
}

impl Deref for AtSpeed<'_> {
    type Target = CachedModel;

    fn deref(&self) -> &CachedModel {
        match self {
            Self::Same(model) => model,
            Self::Specialised(model) => model,
        }
    }
}

impl CachedModel {
    /// Wraps a model; nothing is computed yet.
    pub fn new(model: Model) -> Self {
        Self {
            model,
            linear_part: OnceLock::new(),
            at_speeds: Recent::default(),
            equilibria: Recent::default(),
            run_results: OnceLock::new(),
            base: None,
        }
    }

    /// Wraps a model that differs from `base` in loads only: it shares the modes and state-space models of `base`, and its
    /// runs use the reduction of `base` where this keeps their accuracy.
    pub fn variation(model: Model, base: &Arc<Self>) -> Self {
        let variation = Self { base: Some(Arc::clone(base)), ..Self::new(model) };
        variation.share(base);
        variation
    }

    /// The model of which this one is a variation.
    pub fn base(&self) -> Option<&Self> {
        self.base.as_deref()
    }

    /// Shares the modes and state-space models of `other`, which has the same linear part. Has no effect after the first
    /// analysis of this model.
    pub fn share(&self, other: &Self) {
        self.linear_part.get_or_init(|| Arc::clone(other.linear_part()));
    }

    fn linear_part(&self) -> &Arc<LinearPart> {
        self.linear_part.get_or_init(Arc::default)
    }

    /// The model at a constant speed of the reference shaft, rad/s; see [`Model::at_speed`]. Nonlinear bearings have the
    /// coefficients of the static equilibrium at that speed, with live geometry of the meshes.
    ///
    /// # Errors
    /// [`SceneError`] if a bearing has no coefficients, or a torque no value, at the speed, or nonlinear bearings have no
    /// equilibrium.
    pub fn at_speed(&self, speed: f64) -> Result<AtSpeed<'_>, SceneError> {
        if self.model.is_at(speed) {
            self.model.check_speed(speed)?;
            return Ok(AtSpeed::Same(self));
        }
        if let Some(known) = self.at_speeds.get(&speed) {
            return Ok(AtSpeed::Specialised(known));
        }
        let mut model = self.model.at_speed(speed)?;
        if !model.is_at(speed) {
            model = at_operating_point(model, speed)?;
        }
        let model = Self::new(model);
        model.linear_part.get_or_init(|| self.linear_part().at_speed(speed));
        let model = Arc::new(model);
        self.at_speeds.insert(speed, Arc::clone(&model));
        Ok(AtSpeed::Specialised(model))
    }

    /// The model whose nonlinear bearings have the coefficients of a speed of the reference shaft, rad/s, while tables of
    /// bearings keep their dependence on the speed: the model of a run at a changing speed.
    ///
    /// # Errors
    /// As [`Self::at_speed`].
    pub fn with_points_of(&self, speed: f64) -> Result<AtSpeed<'_>, SceneError> {
        if self.model.nonlinear_bearings.is_empty() {
            return Ok(AtSpeed::Same(self));
        }
        let at_speed = self.at_speed(speed)?;
        let mut points = at_speed.model.nonlinear_bearings.iter().filter_map(|bearing| bearing.point);
        let model = self.model.clone();
        let points: Vec<_> = model.nonlinear_bearings.iter().map(|bearing| bearing.number).zip(&mut points).collect();
        let of = |number: usize| points.iter().find(|(known, _)| *known == number).map(|(_, point)| *point);
        let model = model.with_points(|bearing| of(bearing.number).unwrap_or_default());
        Ok(AtSpeed::Specialised(Arc::new(Self::new(model))))
    }

    /// Displacements of the static equilibrium, as [`equilibrium`].
    ///
    /// # Errors
    /// As [`equilibrium`].
    pub fn equilibrium(&self, geometry: Geometry, speeds: EquilibriumSpeeds) -> Result<DVector<f64>, EquilibriumError> {
        self.equilibria.get_or_try((geometry, speeds), || equilibrium(&self.model, geometry, speeds))
    }

    /// The results that runs of this model share, in a type of a later folder.
    pub fn run_results<T: Any + Default + Send + Sync>(&self) -> Arc<T> {
        let known = self.run_results.get_or_init(|| Arc::new(T::default()));
        Arc::clone(known).downcast().unwrap_or_default()
    }

    /// Undamped modes, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition fails, or a bearing depends on the speed.
    pub fn real_modes(&self, speed: f64) -> Result<&RealModes, DecompositionError> {
        if self.model.lacks_coefficients() {
            return Err(DecompositionError::SpeedDependent);
        }
        let cell = &self.linear_part().modes[self.model.rotation(speed) as usize];
        cell.get_or_init(|| RealModes::new(&self.model, speed)).as_ref().map_err(|error| *error)
    }

    /// Lowest and highest undamped frequency, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if an iteration fails, or a bearing depends on the speed.
    pub fn spectral_range(&self, speed: f64) -> Result<&SpectralRange, DecompositionError> {
        if self.model.lacks_coefficients() {
            return Err(DecompositionError::SpeedDependent);
        }
        let cell = &self.linear_part().ranges[self.model.rotation(speed) as usize];
        let range = || {
            // The choice does not depend on what is known, so that the same run has the same steps.
            if self.model.len() < MIN_KRYLOV {
                Ok(SpectralRange::of_modes(self.real_modes(speed)?))
            } else {
                SpectralRange::new(&self.model, speed)
            }
        };
        cell.get_or_init(range).as_ref().map_err(|error| *error)
    }

    /// State-space model of the complete system at `speed` of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear(&self, speed: f64) -> Result<Arc<ModalStateSpace>, DecompositionError> {
        let known = &self.linear_part().linear;
        if let Some(Some(linear)) = known.get(&(speed, true)) {
            return Ok(linear);
        }
        let linear = Arc::new(ModalStateSpace::new(self.real_modes(speed)?, &self.first_order(speed)?)?);
        known.insert((speed, true), Some(Arc::clone(&linear)));
        Ok(linear)
    }

    /// State-space model at `speed` without the meshes, so that shafts are uncoupled; `None` if the modes are too
    /// ill-conditioned to represent it.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear_without_meshes(&self, speed: f64) -> Result<Option<Arc<ModalStateSpace>>, DecompositionError> {
        let known = &self.linear_part().linear;
        if let Some(linear) = known.get(&(speed, false)) {
            return Ok(linear);
        }
        let linear = ModalStateSpace::without_meshes(&self.model, speed)?.map(Arc::new);
        known.insert((speed, false), linear.clone());
        Ok(linear)
    }

    /// The complete model at `speed` of the reference shaft, rad/s, in its undamped modes.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be computed.
    pub fn projected(&self, speed: f64) -> Result<Projected, DecompositionError> {
        let projected = Projected::new(&self.model, self.real_modes(speed)?.clone(), speed);
        Ok(projected.with_state_space(self.linear(speed)?))
    }

    /// Undamped modes of the components.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn component_modes(&self) -> Result<&ComponentModes, DecompositionError> {
        self.linear_part().components.get_or_init(|| ComponentModes::new(&self.model)).as_ref().map_err(|error| *error)
    }

    /// Undamped modes that `loads` (n entries each) excite, in a Krylov space of `steps` vectors, with the loaded tooth flanks
    /// of `speed` (reference shaft, rad/s). Time and memory are proportional to n.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails, or a bearing depends on the speed.
    pub fn modes_of_loads(
        &self,
        speed: f64,
        loads: &[Vec<f64>],
        steps: usize,
    ) -> Result<RealModes, DecompositionError> {
        modes_of_loads(&self.model, speed, self.spectral_range(speed)?, loads, steps)
    }

    /// The subspace of a key; `find` computes it from its loads and signals, unless it is known.
    ///
    /// # Errors
    /// [`DecompositionError`] of `find`.
    pub fn subspace(
        &self,
        key: SubspaceKey,
        find: impl FnOnce(&[Vec<(usize, f64)>]) -> Result<Projected, DecompositionError>,
    ) -> Result<Arc<Projected>, DecompositionError> {
        let subspaces = &self.linear_part().subspaces;
        if let Some(known) = subspaces.get(&key) {
            return Ok(known);
        }
        let found = Arc::new(find(&key.2)?);
        subspaces.insert(key, Arc::clone(&found));
        Ok(found)
    }

    /// Factors of the dynamic stiffness of a key; `find` computes them, unless they are known.
    ///
    /// # Errors
    /// Those of `find`.
    pub fn dynamic_factors<E>(
        &self,
        key: DynamicKey,
        find: impl FnOnce() -> Result<CoupledFactors, E>,
    ) -> Result<Arc<CoupledFactors>, E> {
        self.linear_part().dynamic.get_or_try(key, || find().map(Arc::new))
    }

    /// First-order form of the complete system at `speed` of the reference shaft, rad/s.
    pub(super) fn first_order(&self, speed: f64) -> Result<FirstOrder, DecompositionError> {
        let model = &self.model;
        let damping = self.damping_matrix(speed)? + model.gyroscopic_matrix() * speed;
        Ok(FirstOrder::new(self.real_modes(speed)?, &damping, &model.skew_part_matrix()))
    }

    /// Damping matrix C of shafts, bearings and meshes, n × n in the order of the core, including modal damping.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes that modal damping needs cannot be computed.
    pub fn damping_matrix(&self, speed: f64) -> Result<DMatrix<f64>, DecompositionError> {
        let mut matrix = self.model.damping_matrix(speed);
        if let Some(modal) = self.modal_damping_matrix(speed)? {
            matrix += modal;
        }
        Ok(matrix)
    }

    /// Modal damping matrix MΦ·diag(2ζω)·ΦᵀM, n × n; `None` if the scene has no modal damping.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes cannot be computed.
    pub fn modal_damping_matrix(&self, speed: f64) -> Result<Option<DMatrix<f64>>, DecompositionError> {
        let ratio = self.model.scene.modal_damping;
        if ratio == 0.0 {
            return Ok(None);
        }
        Ok(Some(self.real_modes(speed)?.damping_matrix(&self.model, ratio)))
    }
}

/// The model with the coefficients of its nonlinear bearings at the static equilibrium at a speed, rad/s.
fn at_operating_point(model: Model, speed: f64) -> Result<Model, SceneError> {
    let model = model.with_provisional_points();
    match equilibrium(&model, Geometry::Live, speed.into()) {
        Ok(q) => Ok(model.with_points_at(speed, q.as_slice())),
        Err(EquilibriumError::Scene(error)) => Err(error),
        Err(error) => {
            let number = model.nonlinear_bearings.first().map_or(0, |bearing| bearing.number);
            let message =
                format!("no static equilibrium at {speed} rad/s, which the stiffness of the bearing needs: {error}");
            Err(EntryPath::entry("bearings", number).error(message))
        }
    }
}

impl LinearPart {
    /// The linear part at a speed of the reference shaft, rad/s.
    fn at_speed(&self, speed: f64) -> Arc<Self> {
        if let Some(known) = self.at_speeds.get(&speed) {
            return known;
        }
        let found = Arc::new(Self::default());
        self.at_speeds.insert(speed, Arc::clone(&found));
        found
    }
}
