//! Loads at the nodes that agree with the motion they cause.
//!
//! The stage equations p = P(u), u = u_free + H p have as many unknowns as nodes times loads, whatever the size of the
//! scene. Loads that are straight lines make them linear; others are found by iteration, which contracts like h²Δk/m, and
//! where it does not, by Newton.

use super::kernel;
use super::step::Stepper;
use crate::integrate::{Halt, Statistics};

/// A contraction that is not measured is taken to be so many times as large.
const CAUTION: f64 = 2.0;
/// No iteration is trusted to shrink what is missing by more: contacts are those of before it.
const TRUSTED: f64 = 1e-3;
/// Iterations before Newton takes over.
const ITERATIONS: usize = 16;
/// An iteration that shrinks by less than this is left to Newton.
const SLOW: f64 = 0.4;
/// Newton steps before a step is given up.
const NEWTON: usize = 12;
/// An iteration has also ended where round-off keeps it from shrinking further, in parts of the load.
const ROUND_OFF: f64 = 1e-14;

impl Stepper<'_> {
    /// What the loads that stand cause at node `i`, into `nodes`.
    fn respond(&mut self, level: usize, i: usize) {
        let of_node = i * self.field.seen()..(i + 1) * self.field.seen();
        let node = &mut self.nodes[of_node.clone()];
        node.copy_from_slice(&self.homogeneous_response[of_node]);
        kernel::accumulate_panel(self.arch, &self.cache.stage_response(level).response[i], &self.loads, node);
    }

    /// What the loads that stand cause at all nodes.
    fn respond_all(&mut self, level: usize) {
        (0..self.cache.rule.stages()).for_each(|i| self.respond(level, i));
    }

    /// Lets the nodes of the last step see what its loads cause, where that has been left open.
    pub(super) fn refresh(&mut self, level: usize) {
        if std::mem::take(&mut self.stage_state_stale) {
            self.respond_all(level);
        }
    }

    /// Evaluates the loads at node `i`, into `residual`.
    fn evaluate(&mut self, level: usize, elapsed: f64, i: usize) -> Result<(), Halt> {
        let (loads, seen, meshes) = (self.field.loads(), self.field.seen(), self.field.meshes());
        let time = elapsed + self.cache.rule.nodes[i] * self.cache.time_grid.step(level);
        let (u, load) = (&self.nodes[i * seen..(i + 1) * seen], &mut self.residual[i * loads..(i + 1) * loads]);
        let sources = self.phasors.len();
        let phasors = &self.stage_phasors[i * sources..(i + 1) * sources];
        self.field.load(time, phasors, u, load, &mut self.contacts[i * meshes..(i + 1) * meshes])
    }

    /// Evaluates the loads at all nodes, into `residual`.
    fn sweep(&mut self, level: usize, elapsed: f64, statistics: &mut Statistics) -> Result<(), Halt> {
        let stages = self.cache.rule.stages();
        for i in 0..stages {
            self.evaluate(level, elapsed, i)?;
        }
        statistics.evaluations += stages as u64;
        Ok(())
    }

    /// Evaluates node after node, each under the latest loads of all.
    pub(super) fn pass(&mut self, level: usize, elapsed: f64, statistics: &mut Statistics) -> Result<(), Halt> {
        let (stages, loads) = (self.cache.rule.stages(), self.field.loads());
        for i in 0..stages {
            self.respond(level, i);
            self.evaluate(level, elapsed, i)?;
            let of_node = i * loads..(i + 1) * loads;
            let (stood, found) = (&mut self.loads[of_node.clone()], &mut self.residual[of_node.clone()]);
            stood.swap_with_slice(found);
        }
        statistics.evaluations += stages as u64;
        Ok(())
    }

    /// Adds what is missing of the loads at all nodes, and what follows from that; what was missing is left in `residual`.
    /// Whether that can be solved.
    fn improve(&mut self, level: usize, elapsed: f64, statistics: &mut Statistics) -> Result<bool, Halt> {
        self.respond_all(level);
        self.sweep(level, elapsed, statistics)?;
        self.evaluated_loads.copy_from_slice(&self.residual);
        for (load, found) in self.loads.iter_mut().zip(&mut self.residual) {
            (*load, *found) = (*found, *found - *load);
        }
        Ok(self.correct(level))
    }

    /// Solves stage equations that are linear: p = P(u_free) + P′ H p. Whether that succeeded.
    pub(super) fn solve_affine(
        &mut self,
        level: usize,
        elapsed: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let (meshes, loads) = (self.field.mesh_loads(), self.field.loads());
        self.nodes.copy_from_slice(&self.homogeneous_response);
        self.sweep(level, elapsed, statistics)?;
        let (stage_response, stages) = (self.cache.stage_response(level), self.cache.rule.stages());
        self.loads.copy_from_slice(&self.residual);
        self.small_lu.begin();
        for (node, residual) in self.residual.chunks_exact(loads).enumerate() {
            for (k, own) in residual[..meshes].iter().enumerate() {
                let row = node * meshes + k;
                let slope = -self.field.residual_tangent(k, &self.contacts[row])[0];
                let response = stage_response.response_of(node, k);
                self.small_lu.add_row(row, slope, meshes, loads, &response);
                // What is prescribed acts through the slope too.
                let prescribed = (0..stages).flat_map(|node| node * loads + meshes..(node + 1) * loads);
                let others = prescribed.map(|column| response(column) * self.residual[column]);
                self.small_lu.right[row] = own + slope * others.sum::<f64>();
            }
        }
        if !self.small_lu.solve() {
            return Ok(false);
        }
        for (loads, solved) in self.loads.chunks_exact_mut(loads).zip(self.small_lu.right.chunks_exact(meshes.max(1))) {
            loads[..meshes].copy_from_slice(solved);
        }
        self.stage_state_stale = true;
        Ok(true)
    }

    /// Solves the stage equations from the loads that stand; whether that succeeded.
    pub(super) fn solve(
        &mut self,
        level: usize,
        elapsed: f64,
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let step = self.cache.time_grid.step(level);
        let mut before = f64::INFINITY;
        if !self.predict(level) {
            return Ok(false);
        }
        for iteration in 0..ITERATIONS {
            let solvable = self.improve(level, elapsed, statistics)?;
            let change = self.change(step);
            if !solvable || !change.is_finite() {
                return Ok(false);
            }
            // What is left after this iteration is the change times ρ/(1 − ρ), ρ that of the step before, and some more,
            // until it is measured.
            let contraction = if iteration > 0 { change / before } else { CAUTION * self.contraction };
            if iteration > 0 {
                self.contraction = contraction;
            }
            let shrinks = contraction.max(TRUSTED);
            let left = if shrinks < 1.0 { change * shrinks / (1.0 - shrinks) } else { change };
            if left <= tolerance || change <= ROUND_OFF * self.added(step) {
                self.stage_state_stale = true;
                return Ok(true);
            }
            if iteration > 1 && contraction > SLOW {
                break;
            }
            before = change;
        }
        self.newton(level, elapsed, tolerance, statistics)
    }

    /// Energy norm of what the changes in `residual` add to a state over a step.
    pub(super) fn change(&self, step: f64) -> f64 {
        let mut change: f64 = 0.0;
        for changes in self.residual.chunks_exact(self.field.loads()) {
            let square = kernel::form(self.arch, &self.cache.gram, &changes[..self.field.mesh_loads()]);
            if !square.is_finite() {
                return f64::INFINITY;
            }
            change = change.max(square);
        }
        step * change.sqrt()
    }

    /// Energy norm of what `loads` add to a state over a step.
    fn added(&self, step: f64) -> f64 {
        let meshes = self.field.mesh_loads();
        let nodes = self.loads.chunks_exact(self.field.loads());
        step * nodes.map(|loads| kernel::form(self.arch, &self.cache.gram, &loads[..meshes])).fold(0.0, f64::max).sqrt()
    }

    pub(super) fn newton(
        &mut self,
        level: usize,
        elapsed: f64,
        tolerance: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let (meshes, loads, seen) = (self.field.mesh_loads(), self.field.loads(), self.field.seen());
        for _ in 0..NEWTON {
            self.respond_all(level);
            self.sweep(level, elapsed, statistics)?;
            let (stage_response, step) = (self.cache.stage_response(level), self.cache.time_grid.step(level));
            self.small_lu.begin();
            for (i, node) in self.cache.rule.nodes.iter().enumerate() {
                let phasors = &self.stage_phasors[i * self.phasors.len()..(i + 1) * self.phasors.len()];
                let u = &mut self.nodes[i * seen..(i + 1) * seen];
                let load = &self.residual[i * loads..(i + 1) * loads];
                let time = elapsed + node * step;
                for k in 0..seen {
                    // A small part of it, and of what a mesh moves by: a nanometre, or so many radians.
                    let small = 1e-7 * u[k].abs().max(1e-2);
                    let stands = u[k];
                    u[k] += small;
                    let moved = u[k] - stands;
                    let slopes = self.small_lu.slopes(loads);
                    let outcome = self.field.load(time, phasors, u, slopes, &mut self.contacts_elsewhere);
                    u[k] = stands;
                    outcome?;
                    for (slope, load) in slopes.iter_mut().zip(load) {
                        *slope = (*slope - load) / moved;
                    }
                    self.small_lu.add(i * meshes, meshes, loads, stage_response.response_of(i, k));
                }
                statistics.evaluations += seen as u64;
            }
            // (1 − P′H) Δp = P(u) − p for the loads of the meshes; the others are what they are.
            for (i, (old, new)) in self.loads.chunks_exact_mut(loads).zip(self.residual.chunks_exact(loads)).enumerate()
            {
                for k in 0..meshes {
                    self.small_lu.right[i * meshes + k] = new[k] - old[k];
                }
                old[meshes..].copy_from_slice(&new[meshes..]);
            }
            if !self.small_lu.solve() {
                return Ok(false);
            }
            let solved = self.small_lu.right.chunks_exact(meshes.max(1));
            for ((load, change), solved) in
                self.loads.chunks_exact_mut(loads).zip(self.residual.chunks_exact_mut(loads)).zip(solved)
            {
                for ((load, change), solved) in load.iter_mut().zip(change).zip(solved) {
                    *load += solved;
                    *change = *solved;
                }
            }
            let change = self.change(step);
            if !change.is_finite() {
                return Ok(false);
            }
            if change <= tolerance || change <= ROUND_OFF.sqrt() * 1e-3 * self.added(step) {
                self.respond_all(level);
                self.evaluated_loads.copy_from_slice(&self.loads);
                return Ok(true);
            }
        }
        Ok(false)
    }
}
