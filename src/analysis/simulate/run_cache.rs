//! A system with the results that its runs share: a repeated run computes them once.
//!
//! A key holds all that its result reads beside the system, so that no result depends on what ran before.

use std::ops::Deref;
use std::sync::{Arc, Mutex};

use nalgebra::{Complex, DMatrix, DVector};

use super::reduction::{KnownReduction, ReductionKey};
use crate::exponential::{PropagatorCache, PropagatorKey};
use crate::modal::{AtSpeed, CachedModel, ModalStateSpace, Recent};
use crate::model::Model;

/// Number of settings whose propagators and reductions are kept: they take most of the memory, see docs/limits.md.
const KEPT_SETTINGS: usize = 2;

/// Inputs, beside the model, of a synchronous motion that runs use: equal inputs give equal motions, which are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SynchronousKey {
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
    /// Speed of the reference shaft that determines the flanks in contact, rad/s.
    pub flank_speed: f64,
    /// Whether modal damping acts on the modes of the components.
    pub uses_components: bool,
}

/// What the synchronous responses of a linear motion read: the arguments of [`ModalStateSpace::synchronous`].
#[derive(Clone, Debug)]
pub(super) struct ResponseKey {
    /// The linear motion ż = A z.
    pub linear: Arc<ModalStateSpace>,
    /// Angular velocity of each source, rad/s.
    pub spins: Vec<f64>,
    /// Force of each source at the shaft angles 0 and π/2 as entries (index, value), N and N m.
    pub forces: Vec<[Vec<(usize, f64)>; 2]>,
}

impl PartialEq for ResponseKey {
    fn eq(&self, other: &Self) -> bool {
        // Two computations of one linear motion have the same entries, but comparing these takes long.
        Arc::ptr_eq(&self.linear, &other.linear) && self.spins == other.spins && self.forces == other.forces
    }
}

impl ResponseKey {
    /// The response to each source; none where the linear motion gives none.
    pub fn responses(&self) -> SourceResponses {
        let sources = self.spins.iter().zip(&self.forces);
        Arc::new(sources.map(|(spin, force)| self.linear.synchronous(*spin, force)).collect())
    }
}

/// Complex amplitudes of the synchronous motion, m and rad: one column for each source shaft.
pub(super) type Amplitudes = Arc<DMatrix<Complex<f64>>>;

/// Complex amplitudes of the modes and their speeds in the synchronous motion of each source; none where there is no response.
pub(super) type SourceResponses = Arc<Vec<Option<DVector<Complex<f64>>>>>;

/// A model with its modes, state-space models and the results that its runs share.
#[derive(Debug)]
pub struct System {
    cached: CachedModel,
    /// Results of the last runs.
    pub(super) known: RunCache,
    /// The system of which this one is a variation.
    pub(super) base: Option<Arc<System>>,
}

impl System {
    /// Wraps a model; nothing is computed yet.
    pub fn new(model: Model) -> Self {
        Self { cached: CachedModel::new(model), known: RunCache::default(), base: None }
    }

    /// Wraps a model that differs from `base` in loads only: it shares the modes and state-space models of `base`, and its
    /// runs use the reduction of `base` where this keeps their accuracy.
    pub fn variation(model: Model, base: &Arc<Self>) -> Self {
        let variation = Self { base: Some(Arc::clone(base)), ..Self::new(model) };
        variation.share(base);
        variation
    }
}

impl Deref for System {
    type Target = CachedModel;

    fn deref(&self) -> &CachedModel {
        &self.cached
    }
}

/// The model of a run, with the results that the runs of its system share.
pub(super) struct RunModel<'a> {
    pub at_speed: AtSpeed<'a>,
    pub known: &'a RunCache,
}

impl Deref for RunModel<'_> {
    type Target = CachedModel;

    fn deref(&self) -> &CachedModel {
        &self.at_speed
    }
}

/// Results of the last runs.
#[derive(Debug, Default)]
pub(super) struct RunCache {
    /// Propagators.
    pub propagators: Recent<Arc<PropagatorKey>, Arc<PropagatorCache>, KEPT_SETTINGS>,
    /// Synchronous motions.
    pub synchronous: Recent<SynchronousKey, Amplitudes>,
    /// Synchronous responses of the linear motion; they keep this in memory, as the propagators do.
    pub responses: Recent<ResponseKey, SourceResponses, KEPT_SETTINGS>,
    /// Reductions with their measured errors; none for a run that keeps all modes.
    pub reductions: Recent<ReductionKey, Option<KnownReduction>, KEPT_SETTINGS>,
    /// Reduction that variations of the model share; none for a run that fails or keeps all modes. One variation finds it,
    /// while the others wait.
    pub shared_reductions: Mutex<Recent<ReductionKey, Option<KnownReduction>, KEPT_SETTINGS>>,
}
