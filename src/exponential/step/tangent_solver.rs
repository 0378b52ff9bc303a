//! Correction of the stage loads by the stiffness and the damping of the connections.
//!
//! The load of a connection changes with the motion in d directions g over its scalars u: one for a mesh, up to the number
//! of scalars for another connection. Its forces f act on the scalars as the load −Σ g f. If the other loads change g·u by
//! ℓ and g·u̇ by ℓ̇, the forces of all stages and directions follow from
//!
//! ```text
//! f = K(ℓ − G f) + C(ℓ̇ − Ġ f),
//! ```
//!
//! where −G f and −Ġ f are the changes of g·u and g·u̇ that the forces cause themselves. K and C are the stiffness and the
//! damping beyond those that the linear motion contains. They are block-diagonal: one block, d × d, for each stage and
//! connection.

use pulp::Arch;

use super::context::StepContext;
use super::small_lu::SmallLu;
use super::stages::Stages;
use crate::connection::Tangent;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::{LinearizedDirection, Panel, panel_kernel};

/// The linear system of all stages and directions. One unknown is the force of one direction at one stage.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct TangentSolver {
    /// Entries of the blocks of K (N/m), stage after stage, connection after connection, row after row; then, where rates
    /// matter, of C (N·s/m). The matrix is factorised for them.
    pub residual_tangent: Vec<f64>,
    /// K and C that the next solution needs.
    next_tangent: Vec<f64>,
    /// One for K alone, two where rates matter.
    kinds: usize,
    /// Indices of the force, and of the change in `deflection_change`, that each entry of K and C relates.
    entries: Vec<[usize; 2]>,
    /// Step level for which the matrix is factorised.
    level: usize,
    /// Whether the matrix is regular.
    solvable: bool,
    /// Whether K and C vanish, so that there is nothing to correct.
    idle: bool,
    system: SmallLu,
    /// Loads of all stages for a unit force: −g.
    force_loads: Panel,
    /// ℓ (m) of all stages and directions and, where rates matter, ℓ̇ (m/s).
    deflection_change: Vec<f64>,
}

impl TangentSolver {
    /// Allocates the system of a number of stages.
    pub fn new(loads: &Loads<'_>, tangents: &[LinearizedDirection], stages: usize) -> Self {
        let (directions, load_count) = (tangents.len(), loads.load_count());
        let (size, len) = (stages * directions, stages * load_count);
        let mut force_loads = vec![0.0; size * len];
        for (unknown, column) in force_loads.chunks_exact_mut(len.max(1)).enumerate() {
            let LinearizedDirection { scalars, gradient, .. } = &tangents[unknown % directions];
            let own = scalars.clone().map(|scalar| unknown / directions * load_count + scalar);
            own.zip(gradient).for_each(|(at, g)| column[at] = -g);
        }
        let kinds = if loads.has_rates { 2 } else { 1 };
        let entries = entries(loads, kinds, stages, directions);
        Self {
            residual_tangent: vec![f64::NAN; entries.len()],
            next_tangent: vec![0.0; entries.len()],
            kinds,
            entries,
            level: usize::MAX,
            solvable: false,
            idle: false,
            system: SmallLu::new(size),
            force_loads: Panel::new(&force_loads, len),
            deflection_change: vec![0.0; kinds * size],
        }
    }

    /// Where an evaluation of the stages writes the K and C that the next solution needs.
    pub fn tangent(&mut self) -> Tangent<'_> {
        let len = self.next_tangent.len() / self.kinds;
        let (stiffness, damping) = self.next_tangent.split_at_mut(len);
        Tangent { stiffness, damping }
    }

    /// Takes K and C of the first stage for all stages.
    pub fn repeat_first(&mut self, stages: usize) {
        let Tangent { stiffness, damping } = self.tangent();
        for own in [stiffness, damping] {
            let len = own.len() / stages;
            (1..stages).for_each(|stage| own.copy_within(..len, stage * len));
        }
    }

    /// Takes K and C of the stages of the previous step.
    pub fn set_tangent(&mut self, previous: &[f64]) {
        self.next_tangent.copy_from_slice(previous);
    }

    /// K and C that the next solution needs.
    pub fn next_tangent(&self) -> &[f64] {
        &self.next_tangent
    }

    /// Factorises the matrix for a step of a level, where K, C or the level have changed. `own_response` holds G and Ġ.
    /// Returns whether the matrix is regular.
    fn factorize(&mut self, level: usize, own_response: &[f64]) -> bool {
        // K and C of a mesh change only if tooth pairs enter or leave contact, so that most steps reuse the factors.
        if self.level != level || self.residual_tangent != self.next_tangent {
            self.level = level;
            self.residual_tangent.copy_from_slice(&self.next_tangent);
            self.idle = self.residual_tangent.iter().all(|value| *value == 0.0);
            self.solvable = self.idle || {
                let size = self.system.right.len();
                let terms = self.residual_tangent.iter().zip(&self.entries);
                let response = |change: usize| &own_response[change * size..(change + 1) * size];
                self.system.fill(terms.map(|(value, [force, change])| (*force, *value, response(*change))));
                self.system.factor()
            };
        }
        self.solvable
    }

    /// Solves for the forces under `deflection_change` and adds their loads −g f.
    fn add_forces(&mut self, arch: Arch, loads: &mut [f64]) {
        self.system.right.fill(0.0);
        for (value, [force, change]) in self.residual_tangent.iter().zip(&self.entries) {
            self.system.right[*force] += value * self.deflection_change[*change];
        }
        self.system.substitute();
        panel_kernel::accumulate_panel(arch, &self.force_loads, &self.system.right, loads);
    }

    /// Corrects predicted stage loads for the difference between the motion that they cause and the predicted interface
    /// states. Returns whether the correction exists. The interface states are scratch afterwards.
    pub fn predict(&mut self, context: &StepContext<'_>, level: usize, stages: &mut Stages) -> bool {
        let loads = &context.loads;
        let (len, rates) = (loads.interface_len(), loads.scalars);
        let (stage_response, tangents) = (context.cache.stage_response(level), &context.cache.maps.tangents);
        if !self.factorize(level, &stage_response.own) || self.idle {
            return self.solvable;
        }
        for (state, homogeneous) in stages.interface_states.iter_mut().zip(&stages.homogeneous_response) {
            *state = homogeneous - *state;
        }
        let size = self.system.right.len();
        for (from, changes) in [0, rates].into_iter().zip(self.deflection_change.chunks_exact_mut(size)) {
            let of_stages = stages.interface_states.chunks_exact(len).zip(changes.chunks_exact_mut(tangents.len()));
            for (state, changes) in of_stages {
                for (change, tangent) in changes.iter_mut().zip(tangents) {
                    *change = tangent.along(state, from);
                }
            }
        }
        panel_kernel::accumulate_panel(context.arch, &stage_response.along, &stages.loads, &mut self.deflection_change);
        self.add_forces(context.arch, &mut stages.loads);
        true
    }

    /// Corrects the stage loads of a step for the motion that their last change, the residual, causes at
    /// the connections. Returns whether the correction exists.
    pub fn correct(&mut self, context: &StepContext<'_>, level: usize, stages: &mut Stages) -> bool {
        let stage_response = context.cache.stage_response(level);
        if !self.factorize(level, &stage_response.own) || self.idle {
            return self.solvable;
        }
        self.deflection_change.fill(0.0);
        panel_kernel::accumulate_panel(
            context.arch,
            &stage_response.along,
            &stages.residual,
            &mut self.deflection_change,
        );
        self.add_forces(context.arch, &mut stages.loads);
        true
    }
}

/// The force and the change that every entry of K, and then of C, relates.
fn entries(loads: &Loads<'_>, kinds: usize, stages: usize, directions: usize) -> Vec<[usize; 2]> {
    let mut entries = Vec::with_capacity(kinds * stages * loads.tangent_len());
    for at in (0..kinds * stages).map(|at| at * directions) {
        for block in loads.direction_ranges() {
            for row in block.clone() {
                entries.extend(block.clone().map(|column| [(at + row) % (stages * directions), at + column]));
            }
        }
    }
    entries
}
