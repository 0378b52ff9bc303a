//! Loads and interface states at the stages and at the ends of a step.

use super::context::{SourcePhasors, StepContext, StepSpan};
use crate::connection::Tangent;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::{kernel, panel_kernel};
use crate::integrate::{Halt, Statistics};
use crate::mesh::Contact;

/// The stages of the last step. Every vector is stored stage after stage.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct Stages {
    /// Loads p_i of the polynomial of the step, N or N·m.
    pub loads: Vec<f64>,
    /// Loads P(t_i, u_i) that were evaluated last.
    pub evaluated_loads: Vec<f64>,
    /// Residual P(t_i, u_i) − p_i. [`Self::evaluate_all`] first stores P here.
    pub residual: Vec<f64>,
    /// Interface states u_i: scalars, then rates.
    pub interface_states: Vec<f64>,
    /// Interface states without the loads of the step: w e^{A c_i h} z and the synchronous motion.
    pub homogeneous_response: Vec<f64>,
    /// Contacts of all connections, stage after stage.
    pub contacts: Vec<Contact>,
    /// Whether `loads` have changed since `interface_states` were computed.
    stale: bool,
    /// Scratch: real and imaginary part of every source phasor at the beginning of the step.
    phasor_parts: Vec<f64>,
}

impl Stages {
    /// Allocates a number of stages.
    pub fn new(loads: &Loads<'_>, stages: usize) -> Self {
        let (len, states) = (stages * loads.load_count(), stages * loads.interface_len());
        Self {
            loads: vec![0.0; len],
            evaluated_loads: vec![0.0; len],
            residual: vec![0.0; len],
            interface_states: vec![0.0; states],
            homogeneous_response: vec![0.0; states],
            contacts: vec![Contact::default(); stages * loads.connection_count()],
            stale: false,
            phasor_parts: vec![0.0; 2 * loads.source_count()],
        }
    }

    /// Starts a step: the interface states are those of the last evaluation.
    pub fn mark_current(&mut self) {
        self.stale = false;
    }

    /// Records that the loads have changed since the last evaluation.
    pub fn mark_stale(&mut self) {
        self.stale = true;
    }

    /// Computes the response to the state `z` alone, for a step that begins at the time of `phasors`.
    pub fn prepare(&mut self, context: &StepContext<'_>, level: usize, phasors: &SourcePhasors, z: &[f64]) {
        let stage_response = context.cache.stage_response(level);
        kernel::row_products(context.arch, &stage_response.rows, z, &mut self.homogeneous_response);
        for (parts, phasor) in self.phasor_parts.chunks_exact_mut(2).zip(&phasors.values) {
            parts.copy_from_slice(&[phasor.re, phasor.im]);
        }
        let synchronous = &stage_response.synchronous;
        panel_kernel::accumulate_panel(context.arch, synchronous, &self.phasor_parts, &mut self.homogeneous_response);
    }

    /// Computes the interface state of stage `i` under the current loads.
    fn respond(&mut self, context: &StepContext<'_>, level: usize, i: usize) {
        let len = context.loads.interface_len();
        let of_stage = i * len..(i + 1) * len;
        let state = &mut self.interface_states[of_stage.clone()];
        state.copy_from_slice(&self.homogeneous_response[of_stage]);
        panel_kernel::accumulate_panel(
            context.arch,
            &context.cache.stage_response(level).response[i],
            &self.loads,
            state,
        );
    }

    /// Computes the interface states of all stages under the current loads.
    pub fn respond_all(&mut self, context: &StepContext<'_>, level: usize) {
        (0..context.stages()).for_each(|i| self.respond(context, level, i));
    }

    /// Computes the interface states of the last step again if its loads have changed since.
    pub fn refresh(&mut self, context: &StepContext<'_>, level: usize) {
        if std::mem::take(&mut self.stale) {
            self.respond_all(context, level);
        }
    }

    /// Evaluates the loads of stage `i` into `residual`, and their tangent.
    fn evaluate(
        &mut self,
        context: &StepContext<'_>,
        span: StepSpan,
        i: usize,
        tangent: Option<Tangent<'_>>,
    ) -> Result<(), Halt> {
        let loads = &context.loads;
        let (load_count, len) = (loads.load_count(), loads.interface_len());
        let connections = loads.connection_count();
        let time = span.begin + context.cache.rule.nodes[i] * context.step(span.level);
        let (u, load) =
            (&self.interface_states[i * len..(i + 1) * len], &mut self.residual[i * load_count..(i + 1) * load_count]);
        loads.load(time, u, load, &mut self.contacts[i * connections..(i + 1) * connections], tangent)
    }

    /// Evaluates the loads of all stages into `residual`, and their tangent, stage after stage.
    pub fn evaluate_all(
        &mut self,
        context: &StepContext<'_>,
        span: StepSpan,
        mut tangent: Option<Tangent<'_>>,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let (stages, len) = (context.stages(), context.loads.tangent_len());
        for i in 0..stages {
            self.evaluate(context, span, i, tangent.as_mut().map(|all| all.split_off(len)))?;
        }
        statistics.evaluations += stages as u64;
        Ok(())
    }

    /// Evaluates the stages of an explicit rule: each uses the loads of the stages before it.
    pub fn evaluate_in_sequence(
        &mut self,
        context: &StepContext<'_>,
        span: StepSpan,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let (stages, load_count) = (context.stages(), context.loads.load_count());
        for i in 0..stages {
            self.respond(context, span.level, i);
            self.evaluate(context, span, i, None)?;
            let of_stage = i * load_count..(i + 1) * load_count;
            self.loads[of_stage.clone()].swap_with_slice(&mut self.residual[of_stage]);
        }
        statistics.evaluations += stages as u64;
        Ok(())
    }
}

/// States of the interfaces, loads and contacts at one instant of a step.
#[derive(Clone, Debug)]
pub struct StepPoint {
    /// Interface scalars (m, or rad), then their rates where loads depend on them.
    pub interface_state: Vec<f64>,
    /// Loads on the scalars (N, or N·m), then the prescribed loads.
    pub load: Vec<f64>,
    /// Contacts of all connections.
    pub contacts: Vec<Contact>,
    /// Twice the mesh energy that |z|² does not contain, J.
    pub mesh_energy: f64,
}

impl StepPoint {
    /// Allocates a point.
    pub fn new(loads: &Loads<'_>) -> Self {
        Self {
            interface_state: vec![0.0; loads.interface_len()],
            load: vec![0.0; loads.load_count()],
            contacts: vec![Contact::default(); loads.connection_count()],
            mesh_energy: 0.0,
        }
    }

    /// Evaluates the interface of the state `z`.
    ///
    /// # Errors
    /// [`Halt`] where the loads are not defined.
    pub fn evaluate(
        &mut self,
        context: &StepContext<'_>,
        phasors: &mut SourcePhasors,
        elapsed: f64,
        z: &[f64],
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let loads = &context.loads;
        context.observe(z, &mut self.interface_state);
        self.mesh_energy = context.mesh_energy(&self.interface_state);
        phasors.update(loads, elapsed);
        loads.add_synchronous(&phasors.values, &mut self.interface_state);
        loads.load(elapsed, &self.interface_state, &mut self.load, &mut self.contacts, None)?;
        statistics.evaluations += 1;
        Ok(())
    }
}
