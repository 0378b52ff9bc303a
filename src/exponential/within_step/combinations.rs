//! Combinations of displacements, velocities and accelerations, with q̈ = V ż + q̈_s, ż = A z + Σ b p and the synchronous motion q_s.
//!
//! The loads p are those of the equation of motion at the state z, not their polynomial over the step. They follow from a few rows
//! for the interface state, in the contact modes of their step. The other rows may not fit into the cache of a processor core: they
//! are read once for several states, also of several steps.

use num_complex::Complex64;
use pulp::Arch;

use super::output::{INSTANT_BATCH, MAX_WAITING};
use super::state_map::StateMap;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::panel_kernel::accumulate_panel;
use crate::exponential::propagator::{InterfaceMaps, Panel, Rows};
use crate::integrate::{Halt, Span};
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
    /// Scratch: a state, contacts and phasors of an evaluation.
    state: Vec<f64>,
    contacts: Vec<Contact>,
    phasors: Vec<Complex64>,
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
        let own = combinations.iter().zip(&accelerated).map(|(each, accelerated)| {
            let rows = [linear.row(&each.displacement, false), linear.row(&each.velocity, true)];
            let mut sum = linear.rate_row(accelerated);
            rows.iter().for_each(|row| sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value));
            sum
        });
        let rows: Vec<_> = own.collect();
        let product = |row: &[f64], column: &[f64]| row.iter().zip(column).map(|(w, b)| w * b).sum::<f64>();
        let mobility: Vec<_> =
            maps.columns.iter().flat_map(|column| accelerated.iter().map(|row| product(row, column))).collect();
        let sources = loads.source_count();
        let amplitudes = loads.spins().into_iter().enumerate().flat_map(|(source, spin)| {
            let sum = move |row: &[(usize, f64)], rate: bool| -> Complex64 {
                row.iter().map(|(index, factor)| loads.amplitude(source, *index, rate) * *factor).sum()
            };
            combinations.iter().map(move |each| {
                let accelerated = sum(&each.acceleration, true) * Complex64::new(0.0, spin);
                sum(&each.displacement, false) + sum(&each.velocity, true) + accelerated
            })
        });
        let at_reference = |each: &Combination| -> f64 {
            each.displacement.iter().map(|(index, factor)| loads.reference[*index] * factor).sum()
        };
        let reference = combinations.iter().map(at_reference).collect();
        let state_map = |rows: &[Vec<f64>], reference: Vec<f64>, amplitudes: Vec<Complex64>| {
            StateMap::new(Rows::new(rows, &linear.parts), reference, amplitudes, sources)
        };
        Self {
            interface: state_map(&maps.rows, vec![0.0; maps.rows.len()], maps.synchronous.clone()),
            map: state_map(&rows, reference, amplitudes.collect()),
            mobility: Panel::new(&mobility, combinations.len()),
            arch: Arch::new(),
            instants: Vec::with_capacity(MAX_WAITING),
            load_values: Vec::with_capacity(MAX_WAITING * loads.load_count()),
            state: vec![0.0; linear.len()],
            contacts: vec![Contact::default(); loads.connection_count()],
            phasors: vec![Complex64::ZERO; sources],
        }
    }

    /// Adds a state.
    pub fn gather(&mut self, z: &[f64]) {
        self.interface.gather(z);
        self.map.gather(z);
    }

    /// Adds the states at instants within a step, by the cubic through both ends.
    pub fn gather_within(&mut self, span: &Span<'_>, instants: &[f64]) {
        for elapsed in instants {
            span.write_cubic(*elapsed, &mut self.state);
            self.interface.gather(&self.state);
            self.map.gather(&self.state);
        }
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
            loads.phasors(*elapsed, &mut self.phasors);
            loads.load(*elapsed, &self.phasors, interface_state, values, &mut self.contacts, None)?;
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
