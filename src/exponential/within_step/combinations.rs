//! Combinations of displacements, velocities and accelerations, with q̈ = V ż + q̈_s, ż = A z + Σ b p and the synchronous motion q_s.
//!
//! The loads p are those of the equation of motion at the state z, not their polynomial over the step. They follow from a few rows
//! for the interface state, in the contact modes of their step. The other rows may not fit into the cache of a processor core: they
//! are read once for several states, also of several steps.

use pulp::Arch;

use super::output::{INSTANT_BATCH, MAX_WAITING};
use super::state_map::StateMap;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::panel_kernel::accumulate_panel;
use crate::exponential::propagator::{InterfaceMaps, Panel, Rows};
use crate::integrate::Halt;
use crate::mesh::Contact;
use crate::modal::ModalStateSpace;
use crate::model::Combination;

/// Maps states z to combinations of coordinates.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct CombinationMap {
    /// The interface state.
    interface: StateMap,
    /// Combinations without loads.
    map: StateMap,
    /// V b: share of every load in every combination, a column for each load.
    mobility: Panel,
    arch: Arch,
    /// Elapsed times, s, and loads of the gathered states.
    instants: Vec<f64>,
    load_values: Vec<f64>,
    /// Scratch: contacts of an evaluation.
    contacts: Vec<Contact>,
}

impl CombinationMap {
    /// Collects the rows of combinations.
    pub fn new(
        loads: &Loads<'_>,
        linear: &ModalStateSpace,
        maps: &InterfaceMaps,
        combinations: &[Combination],
    ) -> Self {
        let accelerated: Vec<_> = combinations.iter().map(|each| linear.row(&each.acceleration, true)).collect();
        let product = |row: &[f64], column: &[f64]| row.iter().zip(column).map(|(w, b)| w * b).sum::<f64>();
        let mobility: Vec<_> =
            maps.columns.iter().flat_map(|column| accelerated.iter().map(|row| product(row, column))).collect();
        let (interface_rows, reference) = (Rows::new(&maps.rows, &linear.parts), vec![0.0; maps.rows.len()]);
        Self {
            interface: StateMap::new(interface_rows, reference, &maps.synchronous),
            map: StateMap::of(loads, linear, combinations),
            mobility: Panel::new(&mobility, combinations.len()),
            arch: Arch::new(),
            instants: Vec::with_capacity(MAX_WAITING),
            load_values: Vec::with_capacity(MAX_WAITING * loads.load_count()),
            contacts: vec![Contact::default(); loads.connection_count()],
        }
    }

    /// Adds a state.
    pub fn gather(&mut self, z: &[f64]) {
        self.interface.gather(z);
        self.map.gather(z);
    }

    /// Evaluates the loads at the last states, which belong to `instants`.
    ///
    /// # Errors
    /// [`Halt`] where a load is not defined. These states are then left out.
    pub fn add_loads(&mut self, loads: &Loads<'_>, instants: &[f64]) -> Result<(), Halt> {
        let (known, each) = (self.load_values.len(), loads.load_count());
        self.load_values.resize(known + instants.len() * each, 0.0);
        let mut interface_states = self.interface.evaluate(loads, instants);
        for (number, elapsed) in instants.iter().enumerate() {
            let values = &mut self.load_values[known + number * each..known + (number + 1) * each];
            // Without connections, there are no interface states.
            let interface_state = interface_states.next().unwrap_or_default();
            loads.load(*elapsed, interface_state, values, &mut self.contacts, None)?;
        }
        self.instants.extend_from_slice(instants);
        Ok(())
    }

    /// Passes the values at all states to `receive`, oldest first, if there are enough of them or `all` are wanted.
    pub fn evaluate(&mut self, loads: &Loads<'_>, all: bool, receive: &mut dyn FnMut(&[f64])) {
        if !all && self.instants.len() < INSTANT_BATCH {
            return;
        }
        let each = loads.load_count();
        for (number, values) in self.map.evaluate(loads, &self.instants).enumerate() {
            accumulate_panel(self.arch, &self.mobility, &self.load_values[number * each..(number + 1) * each], values);
            receive(values);
        }
        self.instants.clear();
        self.load_values.clear();
    }
}
