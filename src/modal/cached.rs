//! A model together with its modes and state-space models, computed on first use and kept.

use std::ops::Deref;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::DMatrix;

use super::first_order::FirstOrder;
use super::projected::Projected;
use super::real::RealModes;
use super::spectral_range::SpectralRange;
use super::state_space::ModalStateSpace;
use crate::linalg::DecompositionError;
use crate::model::Model;
use crate::scene::SceneError;

/// Number of state-space models that are kept. A parameter study asks repeatedly for a few speeds.
const CAPACITY: usize = 8;

/// Smallest number of degrees of freedom for which a Krylov space gives two frequencies faster than all modes.
const MIN_KRYLOV: usize = 100;

/// Speed of the reference shaft, rad/s, and whether the meshes are included.
type Key = (f64, bool);

/// What a subspace depends on: speed of the reference shaft, rad/s, highest frequency, rad/s, and the scalars of its loads
/// and signals as entries (index, coefficient).
type SubspaceKey = (f64, f64, Vec<Vec<(usize, f64)>>);

/// A model with its undamped modes and its most recent state-space models.
#[derive(Debug)]
pub struct CachedModel {
    /// Assembled model.
    pub model: Model,
    /// Undamped modes for each [`crate::model::Rotation`].
    modes: [OnceLock<Result<RealModes, DecompositionError>>; 3],
    /// Lowest and highest frequency for each [`crate::model::Rotation`].
    ranges: [OnceLock<Result<SpectralRange, DecompositionError>>; 3],
    /// The last [`CAPACITY`] state-space models; `None` marks a model that modes cannot represent.
    linear: Mutex<Vec<(Key, Option<Arc<ModalStateSpace>>)>>,
    /// The last [`CAPACITY`] subspaces.
    subspaces: Mutex<Vec<(SubspaceKey, Arc<Projected>)>>,
    /// Models at the speeds (rad/s) of the last analyses, if bearings depend on the speed.
    at_speeds: Mutex<Vec<(f64, Arc<CachedModel>)>>,
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
            modes: [const { OnceLock::new() }; 3],
            ranges: [const { OnceLock::new() }; 3],
            linear: Mutex::new(Vec::new()),
            subspaces: Mutex::default(),
            at_speeds: Mutex::default(),
        }
    }

    /// The model at a constant speed of the reference shaft, rad/s; see [`Model::at_speed`].
    ///
    /// # Errors
    /// [`SceneError`] if a bearing has no coefficients, or a torque no value, at the speed.
    pub fn at_speed(&self, speed: f64) -> Result<AtSpeed<'_>, SceneError> {
        if self.model.bearings.is_empty() {
            self.model.check_speed(speed)?;
            return Ok(AtSpeed::Same(self));
        }
        let mut list = self.at_speeds.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = list.iter().find(|(known, _)| *known == speed) {
            return Ok(AtSpeed::Specialised(Arc::clone(known)));
        }
        let model = Arc::new(Self::new(self.model.at_speed(speed)?));
        if list.len() >= CAPACITY {
            list.remove(0);
        }
        list.push((speed, Arc::clone(&model)));
        Ok(AtSpeed::Specialised(model))
    }

    /// Undamped modes, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition fails, or a bearing depends on the speed.
    pub fn real_modes(&self, speed: f64) -> Result<&RealModes, DecompositionError> {
        if !self.model.bearings.is_empty() {
            return Err(DecompositionError::SpeedDependent);
        }
        let cell = &self.modes[self.model.rotation(speed) as usize];
        cell.get_or_init(|| RealModes::new(&self.model, speed)).as_ref().map_err(|error| *error)
    }

    /// Lowest and highest undamped frequency, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if an iteration fails, or a bearing depends on the speed.
    pub fn spectral_range(&self, speed: f64) -> Result<&SpectralRange, DecompositionError> {
        if !self.model.bearings.is_empty() {
            return Err(DecompositionError::SpeedDependent);
        }
        let cell = &self.ranges[self.model.rotation(speed) as usize];
        let range = || {
            if self.model.len() < MIN_KRYLOV || self.modes[self.model.rotation(speed) as usize].get().is_some() {
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
        if let Some(Some(linear)) = self.lookup((speed, true)) {
            return Ok(linear);
        }
        let linear = Arc::new(ModalStateSpace::new(self.real_modes(speed)?, &self.first_order(speed)?)?);
        self.store((speed, true), Some(Arc::clone(&linear)));
        Ok(linear)
    }

    /// State-space model at `speed` without the meshes, so that shafts are uncoupled; `None` if the modes are too
    /// ill-conditioned to represent it.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear_without_meshes(&self, speed: f64) -> Result<Option<Arc<ModalStateSpace>>, DecompositionError> {
        if let Some(linear) = self.lookup((speed, false)) {
            return Ok(linear);
        }
        let linear = ModalStateSpace::without_meshes(&self.model, speed)?.map(Arc::new);
        self.store((speed, false), linear.clone());
        Ok(linear)
    }

    /// The complete model at `speed` of the reference shaft, rad/s, in its undamped modes.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be computed.
    pub fn projected(&self, speed: f64) -> Result<Projected, DecompositionError> {
        let damping = self.damping_matrix(speed)? + self.model.gyroscopic_matrix() * speed;
        Ok(Projected::new(&self.model, self.real_modes(speed)?.clone(), &damping))
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
        let list = || self.subspaces.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = list().iter().find(|(known, _)| *known == key) {
            return Ok(Arc::clone(known));
        }
        let found = Arc::new(find(&key.2)?);
        let mut list = list();
        if list.len() >= CAPACITY {
            list.remove(0);
        }
        list.push((key, Arc::clone(&found)));
        Ok(found)
    }

    fn lookup(&self, key: Key) -> Option<Option<Arc<ModalStateSpace>>> {
        // A panic in another thread cannot leave the list half-written, so a poisoned lock is safe to use.
        let list = self.linear.lock().unwrap_or_else(PoisonError::into_inner);
        list.iter().find(|(known, _)| *known == key).map(|(_, linear)| linear.clone())
    }

    fn store(&self, key: Key, linear: Option<Arc<ModalStateSpace>>) {
        let mut list = self.linear.lock().unwrap_or_else(PoisonError::into_inner);
        if list.len() >= CAPACITY {
            list.remove(0);
        }
        list.push((key, linear));
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
