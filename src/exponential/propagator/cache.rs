//! Propagators of all step lengths. Each is computed at its first use.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use num_complex::Complex64;

use super::interface_maps::{InterfaceMaps, gram};
use super::packed::Panel;
use super::quadrature::QuadratureRule;
use super::step_maps::{StageResponse, StepPropagator};
use super::time_grid::TimeGrid;
use crate::modal::{ModalStateSpace, ModePair};

/// What the propagators of a run follow from.
#[derive(Clone, Debug)]
pub struct PropagatorKey {
    /// The linear motion ż = A z.
    pub linear: Arc<ModalStateSpace>,
    /// Stages of a step and their polynomials.
    pub rule: QuadratureRule,
    /// Rows and columns of the interface over z.
    pub maps: InterfaceMaps,
    /// Step lengths.
    pub time_grid: TimeGrid,
    /// Angular velocities of the rotating sources, rad/s.
    pub spins: Vec<f64>,
}

impl PartialEq for PropagatorKey {
    fn eq(&self, other: &Self) -> bool {
        // Two computations of one linear motion have the same entries, but comparing these takes long.
        Arc::ptr_eq(&self.linear, &other.linear)
            && self.rule == other.rule
            && self.time_grid == other.time_grid
            && self.spins == other.spins
            && self.maps == other.maps
    }
}

/// The propagators and stage responses of all step levels of a time grid.
#[derive(Clone, Debug)]
pub struct PropagatorCache {
    /// What all entries follow from.
    key: Arc<PropagatorKey>,
    /// Gram matrix of the columns b of the loads that depend on the motion.
    pub gram: Panel,
    propagators: Vec<OnceLock<StepPropagator>>,
    stage_responses: Vec<OnceLock<StageResponse>>,
}

impl Deref for PropagatorCache {
    type Target = PropagatorKey;

    fn deref(&self) -> &PropagatorKey {
        &self.key
    }
}

impl PropagatorCache {
    /// Creates the cache of a key.
    pub fn new(key: Arc<PropagatorKey>) -> Self {
        let PropagatorKey { maps, time_grid, .. } = &*key;
        let columns: Vec<f64> = maps.columns.iter().take(maps.coupled_loads).flatten().copied().collect();
        let gram = gram(&columns, maps.coupled_loads);
        let propagators = vec![OnceLock::new(); time_grid.finest + 1];
        let stage_responses = vec![OnceLock::new(); time_grid.finest + 1];
        Self { gram, propagators, stage_responses, key }
    }

    /// Propagator of the state over a step of a level.
    pub fn propagator(&self, level: usize) -> &StepPropagator {
        self.propagators[level]
            .get_or_init(|| StepPropagator::of_pairs(self.pairs(), &self.rule, &self.maps, self.time_grid.step(level)))
    }

    /// Interface states at the stages of a step of a level.
    pub fn stage_response(&self, level: usize) -> &StageResponse {
        self.stage_responses[level].get_or_init(|| {
            let phasors = stage_phasors(&self.rule, &self.time_grid, &self.spins, level);
            StageResponse::of_pairs(self.pairs(), &self.rule, &self.maps, self.time_grid.step(level), &phasors)
        })
    }

    /// Mode pairs of the linear motion. Motions with a dense matrix have no propagators.
    pub fn pairs(&self) -> &[ModePair] {
        self.linear.pairs()
    }
}

/// e^{iΩ c_i h} of every stage i and source, stage after stage.
fn stage_phasors(rule: &QuadratureRule, time_grid: &TimeGrid, spins: &[f64], level: usize) -> Vec<Complex64> {
    let times = rule.nodes.iter().map(|node| node * time_grid.step(level));
    let at = |time: f64| spins.iter().map(move |spin| Complex64::from_polar(1.0, spin * time));
    times.flat_map(at).collect()
}
