//! The interface at the beginning or at the end of a step.

use super::context::{SourcePhasors, StepContext};
use crate::exponential::loads::Loads;
use crate::integrate::{Halt, Statistics};
use crate::mesh::Contact;

/// Interface state, loads and contacts at one instant.
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
