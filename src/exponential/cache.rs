//! Propagators of all step lengths. Each is computed at its first use.

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

/// The propagators and stage responses of all step levels of a time grid.
#[derive(Clone, Debug)]
pub struct PropagatorCache {
    /// Stages of a step and their polynomials.
    pub rule: QuadratureRule,
    /// Step lengths.
    pub time_grid: TimeGrid,
    /// The linear motion ż = A z.
    pub linear: Arc<ModalStateSpace>,
    /// Rows and columns of the interface over z.
    pub maps: InterfaceMaps,
    /// Angular velocities of the rotating sources, rad/s.
    spins: Vec<f64>,
    /// Gram matrix of the columns b of the mesh loads.
    pub gram: Panel,
    propagators: Vec<OnceLock<StepPropagator>>,
    stage_responses: Vec<OnceLock<StageResponse>>,
    /// For each step level the slow and the fast modes; `None` if the motion within a step does not use them.
    mode_splits: Vec<OnceLock<Option<ModeSplit>>>,
    /// e^{At} within a step.
    pub fractions: Fractions,
}

impl PropagatorCache {
    /// Creates the cache of a time grid; `spins` are the angular velocities of the rotating sources, rad/s.
    pub fn new(
        linear: Arc<ModalStateSpace>,
        rule: QuadratureRule,
        maps: InterfaceMaps,
        time_grid: TimeGrid,
        spins: Vec<f64>,
    ) -> Self {
        let columns: Vec<f64> = maps.columns.iter().take(maps.meshes).flatten().copied().collect();
        let gram = gram(&columns, maps.meshes);
        let (propagators, stage_responses) = match &linear.matrix {
            StateMatrix::Pairs(_) => {
                (vec![OnceLock::new(); time_grid.finest + 1], vec![OnceLock::new(); time_grid.finest + 1])
            }
            // Doubling a step yields the next longer one, so that all levels are computed together.
            StateMatrix::Dense(matrix) => {
                let phasors = |level| stage_phasors(&rule, &time_grid, &spins, level);
                let levels = dense::levels(matrix, &rule, &maps, &time_grid, phasors);
                levels.into_iter().map(|(propagator, response)| (propagator.into(), response.into())).unzip()
            }
        };
        let mode_splits = vec![OnceLock::new(); time_grid.finest + 1];
        let fractions = Fractions::new(&time_grid);
        Self { rule, time_grid, linear, maps, spins, gram, propagators, stage_responses, mode_splits, fractions }
    }

    /// Whether this is the cache of a linear motion with a rule, interface maps, a time grid and spins.
    pub fn serves(
        &self,
        linear: &Arc<ModalStateSpace>,
        rule: &QuadratureRule,
        maps: &InterfaceMaps,
        time_grid: &TimeGrid,
        spins: &[f64],
    ) -> bool {
        Arc::ptr_eq(&self.linear, linear)
            && (self.rule.stages(), self.rule.explicit) == (rule.stages(), rule.explicit)
            && self.time_grid == *time_grid
            && self.spins == spins
            && self.maps == *maps
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
