//! The steps of a clock, and the rows and columns through which a motion is acted on.

use std::cell::OnceCell;
use std::ops::Range;

use num_complex::Complex64;

use super::dense;
use super::packed::Panel;
use super::propagator::{StageResponse, StepPropagator};
use super::quadrature::QuadratureRule;
use super::time_grid::TimeGrid;
use crate::modal::{Form, ModalStateSpace, ModePair};

/// Rows and columns of the interface over a state z.
#[derive(Clone, Debug, Default)]
pub struct InterfaceMaps {
    /// w: scalars of the motion.
    pub rows: Vec<Vec<f64>>,
    /// b: loads, those of the meshes first.
    pub columns: Vec<Vec<f64>>,
    /// How many of the columns are the meshes'.
    pub meshes: usize,
    /// Slots of the parts of a state that nothing linear couples.
    pub parts: Vec<Range<usize>>,
    /// The laws of the meshes at rest.
    pub tangents: Vec<LinearizedContact>,
    /// Amplitudes of the rows in the synchronous motion, source after source.
    pub synchronous: Vec<Complex64>,
}

/// The law of a mesh at rest: its force is that of δ = g·u over its scalars, and its loads are −g times that.
#[derive(Clone, Debug)]
pub struct LinearizedContact {
    /// Its scalars among all.
    pub scalars: Range<usize>,
    /// g.
    pub gradient: Vec<f64>,
    /// √k where the energy of a state z does not contain that of the mesh; zero where it does.
    pub root: f64,
}

impl LinearizedContact {
    /// g·u √k of scalars: its square is twice the energy that the mesh has beside that of the state.
    pub fn mesh_energy_norm(&self, seen: &[f64]) -> f64 {
        self.root * self.along(seen, 0)
    }

    /// g times the scalars, or their rates, that begin at `from`.
    pub fn along(&self, seen: &[f64], from: usize) -> f64 {
        let own = &seen[from + self.scalars.start..from + self.scalars.end];
        own.iter().zip(&self.gradient).map(|(u, g)| u * g).sum()
    }
}

impl InterfaceMaps {
    /// A state with the strain of the meshes after it: the square of its length is twice the energy of both.
    pub fn with_mesh_energy(&self, mut state: Vec<f64>) -> Vec<f64> {
        let product = |row: &Vec<f64>| row.iter().zip(&state).map(|(w, z)| w * z).sum();
        let seen: Vec<f64> = self.rows.iter().take(self.meshes).map(product).collect();
        state.extend(self.tangents.iter().map(|tangent| tangent.mesh_energy_norm(&seen)));
        state
    }
}

/// Gram matrix of `count` vectors, one after the other.
pub fn gram(vectors: &[f64], count: usize) -> Panel {
    let len = vectors.len() / count.max(1);
    let vector = |k: usize| &vectors[k * len..(k + 1) * len];
    let dot = |i: usize, j: usize| vector(i).iter().zip(vector(j)).map(|(a, b)| a * b).sum();
    let entries: Vec<f64> = (0..count * count).map(|at| dot(at / count, at % count)).collect();
    Panel::new(&entries, count)
}

/// The steps of a clock, each made when it is first asked for.
#[derive(Clone, Debug)]
pub struct PropagatorCache<'m> {
    /// The nodes.
    pub rule: QuadratureRule,
    /// The lengths of the steps.
    pub time_grid: TimeGrid,
    /// The linear motion.
    pub linear: &'m ModalStateSpace,
    /// The rows and columns through which it is acted on.
    pub maps: InterfaceMaps,
    spins: Vec<f64>,
    /// Gram matrix of the meshes' columns b themselves.
    pub gram: Panel,
    propagators: Vec<OnceCell<StepPropagator>>,
    stage_responses: Vec<OnceCell<StageResponse>>,
}

impl<'m> PropagatorCache<'m> {
    /// The steps of `time_grid`; `spins` are those of what turns, rad/s.
    pub fn new(
        linear: &'m ModalStateSpace,
        rule: QuadratureRule,
        maps: InterfaceMaps,
        time_grid: TimeGrid,
        spins: Vec<f64>,
    ) -> Self {
        let columns: Vec<f64> = maps.columns.iter().take(maps.meshes).flatten().copied().collect();
        let gram = gram(&columns, maps.meshes);
        let empty =
            Self { rule, time_grid, linear, maps, spins, gram, propagators: Vec::new(), stage_responses: Vec::new() };
        let (propagators, stage_responses) = match &linear.form {
            Form::Pairs(_) => {
                (vec![OnceCell::new(); time_grid.finest + 1], vec![OnceCell::new(); time_grid.finest + 1])
            }
            // Longer steps are made of shorter ones, so all are made at once.
            Form::Dense(matrix) => dense::levels(matrix, &empty).into_iter().map(|(p, s)| (p.into(), s.into())).unzip(),
        };
        Self { propagators, stage_responses, ..empty }
    }

    /// What a step of a level makes of a state.
    pub fn propagator(&self, level: usize) -> &StepPropagator {
        self.propagators[level]
            .get_or_init(|| StepPropagator::of_pairs(self.pairs(), &self.rule, &self.maps, self.time_grid.step(level)))
    }

    /// What the nodes of a step of a level see.
    pub fn stage_response(&self, level: usize) -> &StageResponse {
        let step = self.time_grid.step(level);
        self.stage_responses[level]
            .get_or_init(|| StageResponse::of_pairs(self.pairs(), &self.rule, &self.maps, step, self.phasors(level)))
    }

    /// None where all has been made at once.
    fn pairs(&self) -> &[ModePair] {
        if let Form::Pairs(pairs) = &self.linear.form { pairs } else { &[] }
    }

    /// e^{iΩ c_i h} of the nodes and the sources.
    pub(super) fn phasors(&self, level: usize) -> Vec<Complex64> {
        let times = self.rule.nodes.iter().map(|node| node * self.time_grid.step(level));
        let at = |time: f64| self.spins.iter().map(move |spin| Complex64::from_polar(1.0, spin * time));
        times.flat_map(at).collect()
    }
}
