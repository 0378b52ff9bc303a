//! Results that the runs of one system share: a repeated run computes them once.

use std::sync::{Arc, Mutex, Weak};

use nalgebra::{Complex, DMatrix};

use super::known_reduction::{KnownReduction, ReductionKey};
use crate::exponential::PropagatorCache;
use crate::modal::{ModalStateSpace, Recent};

/// Number of settings whose propagators and reductions are kept: they take most of the memory, see docs/limits.md.
pub(super) const SETTINGS: usize = 2;

/// What the synchronous motion at the start of a run depends on: speed, and speed of the flanks in contact, rad/s, and
/// whether modal damping acts in component modes.
type StartKey = (f64, f64, bool);

/// Complex amplitudes of the synchronous motion, m and rad: one column for each source shaft.
type Amplitudes = Arc<DMatrix<Complex<f64>>>;

/// Results of the last runs.
#[derive(Debug, Default)]
pub(super) struct RunCache {
    /// Propagators.
    pub propagators: Recent<(), Arc<PropagatorCache>, SETTINGS>,
    /// Synchronous motions at the start.
    pub start_amplitudes: Recent<StartKey, Amplitudes>,
    /// Synchronous motions of a linear motion at a speed, rad/s, which changes or not.
    pub amplitudes: Recent<(f64, bool, Identity), Amplitudes>,
    /// Reductions with their measured errors.
    pub reductions: Recent<ReductionKey, KnownReduction, SETTINGS>,
    /// Reductions that variations of the model share; none for a run that fails or is not reduced.
    pub shared_reductions: Mutex<Vec<(ReductionKey, Vec<KnownReduction>)>>,
}

/// A linear motion as a key, which does not keep its matrices in memory.
#[derive(Clone, Debug)]
pub(super) struct Identity(Weak<ModalStateSpace>);

impl Identity {
    /// The identity of a linear motion.
    pub fn of(linear: &Arc<ModalStateSpace>) -> Self {
        Self(Arc::downgrade(linear))
    }
}

impl PartialEq for Identity {
    fn eq(&self, other: &Self) -> bool {
        self.0.ptr_eq(&other.0)
    }
}
