//! Propagators of all step lengths. Each is computed at its first use.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use num_complex::Complex64;

use super::dense;
use super::fractions::Fractions;
use super::interface_maps::{InterfaceMaps, gram};
use super::mode_split::ModeSplit;
use super::packed::Panel;
use super::propagator::{StageResponse, StepPropagator};
use super::quadrature::QuadratureRule;
use super::time_grid::TimeGrid;
use crate::modal::{ModalStateSpace, ModePair, StateMatrix};

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
    /// For each step level the slow and the fast modes; `None` if the motion within a step does not use them.
    mode_splits: Vec<OnceLock<Option<ModeSplit>>>,
    /// e^{At} within a step.
    pub fractions: Fractions,
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
        let PropagatorKey { linear, rule, maps, time_grid, spins } = &*key;
        let columns: Vec<f64> = maps.columns.iter().take(maps.coupled_loads).flatten().copied().collect();
        let gram = gram(&columns, maps.coupled_loads);
        let (propagators, stage_responses) = match &linear.matrix {
            StateMatrix::Pairs(_) => {
                (vec![OnceLock::new(); time_grid.finest + 1], vec![OnceLock::new(); time_grid.finest + 1])
            }
            // Doubling a step yields the next longer one, so that all levels are computed together.
            StateMatrix::Dense(matrix) => {
                let phasors = |level| stage_phasors(rule, time_grid, spins, level);
                let levels = dense::levels(matrix, rule, maps, time_grid, phasors);
                levels.into_iter().map(|(propagator, response)| (propagator.into(), response.into())).unzip()
            }
        };
        let mode_splits = vec![OnceLock::new(); time_grid.finest + 1];
        let fractions = Fractions::new(time_grid);
        Self { gram, propagators, stage_responses, mode_splits, fractions, key }
    }

    /// Propagator of the state over a step of a level.
    pub fn propagator(&self, level: usize) -> &StepPropagator {
        self.propagators[level]
            .get_or_init(|| StepPropagator::of_pairs(self.pairs(), &self.rule, &self.maps, self.time_grid.step(level)))
    }

    /// Slow and fast modes of a step of a level; `None` if A is dense, or a pair of modes is neither.
    pub fn mode_split(&self, level: usize) -> Option<&ModeSplit> {
        let split = || match &self.linear.matrix {
            StateMatrix::Pairs(pairs) => ModeSplit::new(pairs, self.time_grid.step(level), self.rule.whole.len()),
            StateMatrix::Dense(_) => None,
        };
        self.mode_splits[level].get_or_init(split).as_ref()
    }

    /// Interface states at the stages of a step of a level.
    pub fn stage_response(&self, level: usize) -> &StageResponse {
        self.stage_responses[level].get_or_init(|| {
            let phasors = stage_phasors(&self.rule, &self.time_grid, &self.spins, level);
            StageResponse::of_pairs(self.pairs(), &self.rule, &self.maps, self.time_grid.step(level), phasors)
        })
    }

    /// Mode pairs of the linear motion; none for the dense form, whose levels are all computed at construction.
    pub fn pairs(&self) -> &[ModePair] {
        if let StateMatrix::Pairs(pairs) = &self.linear.matrix { pairs } else { &[] }
    }
}

/// e^{iΩ c_i h} of every stage i and source, stage after stage.
fn stage_phasors(rule: &QuadratureRule, time_grid: &TimeGrid, spins: &[f64], level: usize) -> Vec<Complex64> {
    let times = rule.nodes.iter().map(|node| node * time_grid.step(level));
    let at = |time: f64| spins.iter().map(move |spin| Complex64::from_polar(1.0, spin * time));
    times.flat_map(at).collect()
}
