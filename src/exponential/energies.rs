//! Energies of the shafts at output instants.
//!
//! They follow from all displacements and velocities, whose map from modal states does not fit into the fast memory of a
//! processor. States of several instants are therefore collected, also over several steps, and the map is read once for
//! all of them.

use super::nonlinear_loads::NonlinearLoads;
use super::output::OutputMap;
use crate::integrate::at_each;

/// Number of instants that are evaluated together.
const BATCH: usize = 8;
/// Largest number of instants that wait: the last outputs of a step are added to those of earlier steps.
const MAX_WAITING: usize = 2 * BATCH;

/// Collects states, and computes their energies.
#[derive(Clone, Debug)]
pub(super) struct ShaftEnergies {
    /// The map to all coordinates.
    output: OutputMap,
    /// Elapsed times of the collected states, s.
    instants: Vec<f64>,
    /// Scratch: displacements and velocities at all instants, and displacements without the bow.
    q: Vec<f64>,
    v: Vec<f64>,
    unbent: Vec<f64>,
}

impl ShaftEnergies {
    /// Allocates the energies of a model with `len` coordinates, to all of which `output` maps.
    pub fn new(output: OutputMap, len: usize) -> Self {
        Self {
            output,
            instants: Vec::with_capacity(MAX_WAITING),
            q: vec![0.0; MAX_WAITING * len],
            v: vec![0.0; MAX_WAITING * len],
            unbent: vec![0.0; len],
        }
    }

    /// The map to all coordinates.
    pub fn into_output(self) -> OutputMap {
        self.output
    }

    /// Adds the state z at an instant.
    pub fn collect(&mut self, elapsed: f64, z: &[f64]) {
        self.instants.push(elapsed);
        self.output.gather(z);
    }

    /// Passes kinetic energy and elastic energy of the shafts, J, of all collected states to `receive`, oldest first, if there
    /// are enough of them or `all` are wanted.
    pub fn evaluate(&mut self, loads: &NonlinearLoads<'_>, all: bool, receive: &mut dyn FnMut([f64; 2])) {
        if self.instants.len() < if all { 1 } else { BATCH } {
            return;
        }
        let room = self.instants.len() * self.unbent.len();
        let (q, v) = (&mut self.q[..room], &mut self.v[..room]);
        self.output.read_gathered(loads, &self.instants, q, v);
        for (elapsed, q, v) in at_each(&self.instants, q, v) {
            receive(loads.motion.shaft_energies(elapsed, q, v, &mut self.unbent));
        }
        self.instants.clear();
    }
}
