//! One step: what a state does by itself, the loads at the nodes, and the state after it.

use num_complex::Complex64;
use pulp::Arch;

use super::cache::{InterfaceMaps, PropagatorCache};
use super::contact_tangent::ContactTangentSolver;
use super::jump::Powers;
use super::kernel::{Aligned, aligned};
use super::nonlinear_loads::NonlinearLoads;
use super::packed::Rows;
use super::quadrature::MOST;
use super::small_lu::SmallLu;
use super::{Outcome, kernel};
use crate::integrate::{Halt, Statistics};
use crate::mesh::Contact;
use crate::modal::ModalStateSpace;

/// The method with all that a step needs.
#[derive(Clone, Debug)]
pub struct Stepper<'m> {
    /// What acts.
    pub field: NonlinearLoads<'m>,
    pub(super) cache: PropagatorCache<'m>,
    pub(super) arch: Arch,
    /// How many steps were tried.
    pub(super) steps: u64,
    bare_rows: Rows,
    /// Columns b, one after the other.
    pub(super) bare_columns: Aligned,
    /// Columns Aᵐ b, for loads that jump.
    pub(super) powers: Powers,
    /// Accelerations of the scalars under each load.
    mobility: Vec<f64>,
    /// Loads at the nodes, node after node, of the last step.
    pub(super) loads: Vec<f64>,
    /// Scalars and rates at the nodes, and the loads that they have told.
    pub(super) nodes: Vec<f64>,
    pub(super) evaluated_loads: Vec<f64>,
    /// Whether the nodes have yet to see what has become of the loads since.
    pub(super) stage_state_stale: bool,
    /// Scalars and rates, and loads, at the beginning and at the end.
    pub(super) begin: Vec<f64>,
    pub(super) end: Vec<f64>,
    pub(super) begin_load: Vec<f64>,
    pub(super) end_load: Vec<f64>,
    /// The state at the end.
    pub(super) after: Vec<f64>,
    pub(super) homogeneous_response: Vec<f64>,
    pub(super) residual: Vec<f64>,
    pub(super) phasors: Vec<Complex64>,
    /// The same, real and imaginary part after each other.
    phasor_parts: Vec<f64>,
    /// The elapsed time of these turns.
    turned: f64,
    /// Turns at the nodes, node after node, where loads depend on them.
    pub(super) stage_phasors: Vec<Complex64>,
    pub(super) defect: Vec<f64>,
    /// How much what is missed changes over a step, and that in parts of its size.
    pub(super) changed: Vec<f64>,
    pub(super) defect_ratio: f64,
    /// Energy norm that what is missed adds to a state in a second.
    pub(super) unresolved_error: f64,
    /// How many times as long as the step before it the last one was, with the weights that foretell its loads.
    extrapolation: (f64, Vec<f64>),
    /// Twice the energy of the meshes beside that of the state that was looked at last.
    mesh_energy_norm: f64,
    /// Contacts of the meshes at the nodes, node after node, at the beginning and at the end.
    pub(super) contacts: Vec<Contact>,
    pub(super) contacts_at_begin: Vec<Contact>,
    contacts_at_end: Vec<Contact>,
    /// Room for those elsewhere.
    pub(super) contacts_elsewhere: Vec<Contact>,
    affine: bool,
    /// Whether the flanks of a mesh may part, and whether teeth come and go at once.
    parts: bool,
    pub(super) sharp: bool,
    pub(super) small_lu: SmallLu,
    pub(super) tangent_solver: ContactTangentSolver,
    /// By how much an iteration of the loads shrinks what is missing, as far as that is known.
    pub(super) contraction: f64,
}

impl<'m> Stepper<'m> {
    /// A stepper of a field, with a table of steps.
    pub fn new(field: NonlinearLoads<'m>, cache: PropagatorCache<'m>) -> Self {
        let (linear, maps) = (cache.linear, &cache.maps);
        let (stages, seen, loads) = (cache.rule.stages(), field.seen(), field.loads());
        Self {
            arch: Arch::new(),
            steps: 0,
            bare_rows: Rows::new(&maps.rows, &maps.parts),
            bare_columns: aligned(&maps.columns.concat()),
            powers: Powers::new(linear, maps),
            mobility: mobility(linear, maps, field.mesh_loads()),
            loads: vec![0.0; stages * loads],
            nodes: vec![0.0; stages * seen],
            evaluated_loads: vec![0.0; stages * loads],
            stage_state_stale: false,
            begin: vec![0.0; seen],
            end: vec![0.0; seen],
            begin_load: vec![0.0; loads],
            end_load: vec![0.0; loads],
            after: vec![0.0; linear.len()],
            homogeneous_response: vec![0.0; stages * seen],
            residual: vec![0.0; stages * loads],
            phasors: vec![Complex64::ZERO; field.sources()],
            phasor_parts: vec![0.0; 2 * field.sources()],
            turned: f64::NAN,
            stage_phasors: vec![Complex64::ZERO; stages * field.sources()],
            defect: vec![0.0; field.mesh_loads()],
            changed: vec![0.0; field.mesh_loads()],
            defect_ratio: 0.0,
            unresolved_error: 0.0,
            extrapolation: (0.0, vec![0.0; stages * (stages + 1)]),
            small_lu: SmallLu::new(stages * field.mesh_loads()),
            tangent_solver: ContactTangentSolver::new(&field, &maps.tangents, stages),
            contraction: f64::INFINITY,
            contacts: vec![Contact::default(); stages * field.meshes()],
            contacts_at_begin: vec![Contact::default(); field.meshes()],
            contacts_at_end: vec![Contact::default(); field.meshes()],
            contacts_elsewhere: vec![Contact::default(); field.meshes()],
            mesh_energy_norm: 0.0,
            affine: field.is_affine(),
            parts: field.motion.parts(),
            sharp: field.motion.model().meshes.iter().any(|mesh| mesh.teeth.is_sharp()),
            field,
            cache,
        }
    }

    /// Energy norm of the motion that a state stands for, about the reference: of the one that was looked at last.
    pub(super) fn size(&self, z: &[f64]) -> f64 {
        let mut square = [0.0];
        kernel::scalars(self.arch, z, z, &mut square);
        (square[0] + self.mesh_energy_norm + self.field.synchronous_size.powi(2)).sqrt()
    }

    /// Twice the energy of the meshes that that of a state of such scalars does not contain.
    fn mesh_energy_norm(&self, seen: &[f64]) -> f64 {
        self.cache.maps.tangents.iter().map(|tangent| tangent.mesh_energy_norm(seen).powi(2)).sum()
    }

    /// By how much the polynomial of scalars and rates is off at a part of the last step, where the state is `z`; `point`
    /// is left on the polynomial.
    pub(super) fn measure_off(&self, part: f64, elapsed: f64, z: &[f64], point: &mut [f64], off: &mut [f64]) {
        self.interpolate(part, point);
        self.see(elapsed, z, off);
        for (off, polynomial) in off.iter_mut().zip(point) {
            *off -= *polynomial;
        }
    }

    /// Scalars and rates of a state at an instant whose turns are not at hand.
    pub(super) fn see(&self, elapsed: f64, z: &[f64], out: &mut [f64]) {
        kernel::seen(self.arch, &self.bare_rows, z, out);
        self.field.add_synchronous_at(elapsed, out);
    }

    /// Turns what turns to an instant: a step begins where the one before it has ended.
    fn turn(&mut self, elapsed: f64) {
        if self.turned != elapsed {
            self.field.phasors(elapsed, &mut self.phasors);
            self.turned = elapsed;
        }
    }

    /// Scalars, rates and loads of the state that a step begins with.
    pub(super) fn look(&mut self, elapsed: f64, z: &[f64], statistics: &mut Statistics) -> Result<(), Halt> {
        kernel::seen(self.arch, &self.bare_rows, z, &mut self.begin);
        self.mesh_energy_norm = self.mesh_energy_norm(&self.begin);
        self.turn(elapsed);
        self.field.add_synchronous(&self.phasors, &mut self.begin);
        self.field.load(elapsed, &self.phasors, &self.begin, &mut self.begin_load, &mut self.contacts_at_begin)?;
        statistics.evaluations += 1;
        Ok(())
    }

    /// Scalars, rates and loads of the state that a step ends with.
    pub(super) fn look_ahead(&mut self, elapsed: f64, statistics: &mut Statistics) -> Result<(), Halt> {
        kernel::seen(self.arch, &self.bare_rows, &self.after, &mut self.end);
        self.mesh_energy_norm = self.mesh_energy_norm(&self.end);
        self.turn(elapsed);
        self.field.add_synchronous(&self.phasors, &mut self.end);
        self.field.load(elapsed, &self.phasors, &self.end, &mut self.end_load, &mut self.contacts_at_end)?;
        statistics.evaluations += 1;
        Ok(())
    }

    /// How fast teeth swing at the beginning of a step whose flanks may part, rad/s.
    pub(super) fn swing_at_begin(&self) -> f64 {
        if self.parts {
            self.field.holds(&self.contacts_at_begin).map(|hold| hold.swing).fold(0.0, f64::max)
        } else {
            0.0
        }
    }

    /// How fast they swing at its nodes and its end, and for each mesh whether its flanks stay as they are, from one node
    /// to the next; nothing where no flanks part.
    pub(super) fn settle(&self, level: usize, unchanged: &mut Vec<bool>) -> f64 {
        unchanged.clear();
        if !self.parts {
            return 0.0;
        }
        let gap = self.cache.rule.gap() * self.cache.time_grid.step(level);
        unchanged.resize(self.field.meshes(), true);
        let mut swing: f64 = 0.0;
        for contacts in self.contacts.chunks_exact(unchanged.len().max(1)).chain([&self.contacts_at_end[..]]) {
            for (unchanged, hold) in unchanged.iter_mut().zip(self.field.holds(contacts)) {
                *unchanged &= hold.time >= gap;
                swing = swing.max(hold.swing);
            }
        }
        swing
    }

    /// How far each flank of a mesh was from a change of law at the beginning, at the nodes and at the end of the last
    /// step, m.
    pub(super) fn margins(&self, mesh: usize) -> [[f64; MOST + 2]; 2] {
        let meshes = self.field.meshes();
        let sides = [&self.contacts_at_begin[..], &self.contacts[..], &self.contacts_at_end[..]];
        let mut margins = [[0.0; MOST + 2]; 2];
        for (k, contacts) in sides.into_iter().flat_map(|side| side.chunks_exact(meshes)).enumerate() {
            for (margins, margin) in margins.iter_mut().zip(self.field.margins(mesh, &contacts[mesh])) {
                margins[k] = margin;
            }
        }
        margins
    }

    /// Takes the end of the last step as the beginning of the next.
    pub(super) fn commit(&mut self, z: &mut Vec<f64>) {
        std::mem::swap(z, &mut self.after);
        std::mem::swap(&mut self.begin, &mut self.end);
        std::mem::swap(&mut self.begin_load, &mut self.end_load);
        std::mem::swap(&mut self.contacts_at_begin, &mut self.contacts_at_end);
    }

    /// Guesses the loads at the nodes and what the nodes see: those of the beginning, or, where `memory` holds both of
    /// the step before this one, the rigidity of its contacts, its length and the contraction of its iteration, the
    /// polynomials through them all.
    pub(super) fn guess(&mut self, level: usize, memory: &[f64]) {
        if !self.remembers() {
            return;
        }
        let (loads, seen, rule) = (self.field.loads(), self.field.seen(), &self.cache.rule);
        let step = self.cache.time_grid.step(level);
        let kept = self.loads.len() + self.nodes.len();
        // That of a run of other stages is of no use.
        let whole = kept + self.tangent_solver.residual_tangent.len() + 2;
        let Some([memory @ .., length, contraction]) = (memory.len() == whole).then_some(memory) else {
            self.loads.chunks_exact_mut(loads).for_each(|load| load.copy_from_slice(&self.begin_load));
            self.nodes.chunks_exact_mut(seen).for_each(|node| node.copy_from_slice(&self.begin));
            self.contraction = f64::INFINITY;
            self.tangent_solver.guess(&self.field, &self.contacts_at_begin, None);
            return;
        };
        let (memory, residual_tangent) = memory.split_at(kept);
        self.tangent_solver.guess(&self.field, &self.contacts_at_begin, Some(residual_tangent));
        // It grows as the square of a step under stiffness, and as the step itself under damping.
        let longer = step / length;
        self.contraction = contraction * longer.max(longer * longer);
        if self.extrapolation.0 != longer {
            rule.extrapolation(longer, &mut self.extrapolation.1);
            self.extrapolation.0 = longer;
        }
        let (before, seen_before) = memory.split_at(self.loads.len());
        kernel::extrapolate(self.arch, &self.begin_load, before, &self.extrapolation.1, &mut self.loads);
        kernel::extrapolate(self.arch, &self.begin, seen_before, &self.extrapolation.1, &mut self.nodes);
    }

    /// Steps from `z` at `elapsed` by a level's step to `end`, which round-off may part from their sum; the state after
    /// it is left in `after`. The loads are found to within `tolerance`, the energy norm of what they may leave.
    ///
    /// # Errors
    /// [`Halt`] where the field is not defined.
    pub(super) fn step(
        &mut self,
        level: usize,
        (elapsed, end): (f64, f64),
        z: &[f64],
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<Outcome, Halt> {
        self.steps += 1;
        self.stage_state_stale = false;
        if self.field.loads() > 0 {
            self.turn(elapsed);
            let stage_response = self.cache.stage_response(level);
            kernel::seen(self.arch, &stage_response.rows, z, &mut self.homogeneous_response);
            for (parts, turn) in self.phasor_parts.chunks_exact_mut(2).zip(&self.phasors) {
                parts.copy_from_slice(&[turn.re, turn.im]);
            }
            kernel::accumulate_panel(
                self.arch,
                &stage_response.synchronous,
                &self.phasor_parts,
                &mut self.homogeneous_response,
            );
            if self.field.is_resonant() {
                let phasors = self.phasors.iter().cycle().zip(&stage_response.phasors);
                for (at_node, (turn, by)) in self.stage_phasors.iter_mut().zip(phasors) {
                    *at_node = turn * by;
                }
            }
            if self.cache.rule.explicit {
                self.pass(level, elapsed, statistics)?;
            } else if self.affine {
                if !self.solve_affine(level, elapsed, statistics)? {
                    return Ok(Outcome::Unsolved);
                }
            } else if !self.solve(level, elapsed, tolerance, statistics)? {
                return Ok(Outcome::Unsolved);
            }
        }
        self.cache.propagator(level).advance(self.arch, &self.loads, z, &mut self.after);
        self.look_ahead(end, statistics)?;
        Ok(Outcome::Solved)
    }

    /// Whether a step begins with what the one before it tells.
    pub(super) fn remembers(&self) -> bool {
        !self.affine && !self.cache.rule.explicit && self.field.mesh_loads() > 0
    }

    /// Scalars and rates at a part of the last step, by the polynomial through its beginning, its nodes and its end.
    pub(super) fn interpolate(&self, part: f64, point: &mut [f64]) {
        let seen = point.len();
        let weights = self.cache.rule.through(part);
        let (first, last) = (weights[0], weights[self.cache.rule.stages() + 1]);
        for (k, point) in point.iter_mut().enumerate() {
            let inner = weights[1..].iter().zip(self.nodes.chunks_exact(seen)).map(|(weight, u)| weight * u[k]);
            *point = first * self.begin[k] + inner.sum::<f64>() + last * self.end[k];
        }
    }

    /// The loads at a part of the last step, by the polynomial through its beginning, its nodes and its end.
    pub(super) fn loads_at(&self, part: f64, out: &mut [f64]) {
        self.weigh(&self.cache.rule.through(part), out);
    }

    /// Loads of the last step at its beginning, its nodes and its end, weighted and added up.
    pub(super) fn weigh(&self, weights: &[f64; MOST + 2], out: &mut [f64]) {
        let (first, last) = (weights[0], weights[self.cache.rule.stages() + 1]);
        for ((out, begin), end) in out.iter_mut().zip(&self.begin_load).zip(&self.end_load) {
            *out = first * begin + last * end;
        }
        for (weight, node) in weights[1..].iter().zip(self.loads.chunks_exact(out.len().max(1))) {
            for (out, load) in out.iter_mut().zip(node) {
                *out += weight * load;
            }
        }
    }

    /// Adds to scalars and rates what loads that are larger by `jump` for the time `ahead` will undo: half the square of
    /// that time, and the time itself, times the accelerations.
    pub(super) fn path_correction(&self, jump: &[f64], ahead: f64, u: &mut [f64]) {
        let (scalars, rates) = u.split_at_mut(self.field.mesh_loads());
        for (k, (scalar, mobility)) in scalars.iter_mut().zip(self.mobility.chunks_exact(jump.len().max(1))).enumerate()
        {
            let acceleration: f64 = mobility.iter().zip(jump).map(|(mobility, jump)| mobility * jump).sum();
            *scalar += ahead * ahead / 2.0 * acceleration;
            if let Some(rate) = rates.get_mut(k) {
                *rate += ahead * acceleration;
            }
        }
    }

    /// The loads at scalars and rates `u`, into `out`.
    pub(super) fn load_at(&mut self, elapsed: f64, u: &[f64], out: &mut [f64]) -> Result<(), Halt> {
        self.turn(elapsed);
        self.field.load(elapsed, &self.phasors, u, out, &mut self.contacts_elsewhere)
    }
}

/// w A b of every scalar and load: what a load accelerates it by.
fn mobility(linear: &ModalStateSpace, maps: &InterfaceMaps, scalars: usize) -> Vec<f64> {
    let mut rate = vec![0.0; linear.len()];
    let mut mobility = vec![0.0; scalars * maps.columns.len()];
    for (load, column) in maps.columns.iter().enumerate() {
        linear.multiply(column, &mut rate);
        for (scalar, row) in maps.rows.iter().take(scalars).enumerate() {
            mobility[scalar * maps.columns.len() + load] = row.iter().zip(&rate).map(|(w, rate)| w * rate).sum();
        }
    }
    mobility
}
