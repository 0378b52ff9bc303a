//! Combinations of displacements, velocities and accelerations, with q̈ = V ż + q̈_s, ż = A z + Σ b p and the synchronous motion q_s.
//!
//! The loads p are those of the equation of motion at the state z, not their polynomial over the step.

use num_complex::Complex64;
use pulp::Arch;

use super::state_map::StateMap;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::panel_kernel::accumulate_panel;
use crate::exponential::propagator::{InterfaceMaps, Panel, Rows};
use crate::integrate::{Halt, Span};
use crate::mesh::Contact;
use crate::modal::ModalStateSpace;
use crate::model::Combination;

/// Maps a state z to combinations of coordinates.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct CombinationMap {
    /// Combinations without loads, then the interface state.
    map: StateMap,
    loaded: LoadedCombinations,
}

impl CombinationMap {
    /// Collects the rows of combinations, whose values it writes at the indices `targets`.
    pub fn new(
        loads: &Loads<'_>,
        linear: &ModalStateSpace,
        maps: &InterfaceMaps,
        combinations: &[Combination],
        targets: Vec<usize>,
    ) -> Self {
        let accelerated: Vec<_> = combinations.iter().map(|each| linear.row(&each.acceleration, true)).collect();
        let own = combinations.iter().zip(&accelerated).map(|(each, accelerated)| {
            let rows = [linear.row(&each.displacement, false), linear.row(&each.velocity, true)];
            let mut sum = linear.rate_row(accelerated);
            rows.iter().for_each(|row| sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value));
            sum
        });
        let rows: Vec<_> = own.chain(maps.rows.iter().cloned()).collect();
        let product = |row: &[f64], column: &[f64]| row.iter().zip(column).map(|(w, b)| w * b).sum::<f64>();
        let mobility: Vec<_> =
            maps.columns.iter().flat_map(|column| accelerated.iter().map(|row| product(row, column))).collect();
        let (sources, interface_len) = (loads.source_count(), maps.rows.len());
        let amplitudes = loads.spins().into_iter().enumerate().flat_map(|(source, spin)| {
            let sum = move |row: &[(usize, f64)], rate: bool| -> Complex64 {
                row.iter().map(|(index, factor)| loads.amplitude(source, *index, rate) * *factor).sum()
            };
            let own = combinations.iter().map(move |each| {
                let accelerated = sum(&each.acceleration, true) * Complex64::new(0.0, spin);
                sum(&each.displacement, false) + sum(&each.velocity, true) + accelerated
            });
            own.chain(maps.synchronous[source * interface_len..][..interface_len].iter().copied())
        });
        let at_reference = |each: &Combination| -> f64 {
            each.displacement.iter().map(|(index, factor)| loads.reference[*index] * factor).sum()
        };
        let mut reference: Vec<f64> = combinations.iter().map(at_reference).collect();
        reference.resize(rows.len(), 0.0);
        Self {
            map: StateMap::new(Rows::new(&rows, &linear.parts), reference, amplitudes.collect(), sources),
            loaded: LoadedCombinations {
                mobility: Panel::new(&mobility, combinations.len()),
                arch: Arch::new(),
                targets,
                load_values: vec![0.0; loads.load_count()],
                contacts: vec![Contact::default(); loads.connection_count()],
                phasors: vec![Complex64::ZERO; sources],
            },
        }
    }

    /// Adds a state to those that [`Self::read_gathered`] reads together.
    pub fn gather(&mut self, z: &[f64]) {
        self.map.gather(z);
    }

    /// Writes the values at all gathered states, which belong to `instants`, one vector after the other.
    ///
    /// # Errors
    /// [`Halt`] where a load is not defined.
    pub fn read_gathered(&mut self, loads: &Loads<'_>, instants: &[f64], a: &mut [f64]) -> Result<(), Halt> {
        self.loaded.write(loads, self.map.evaluate(loads, instants), instants, a)
    }

    /// Writes the values at instants within a step whose states are the cubic through both ends.
    ///
    /// # Errors
    /// [`Halt`] where a load is not defined.
    pub fn interpolate(
        &mut self,
        loads: &Loads<'_>,
        span: &Span<'_>,
        instants: &[f64],
        a: &mut [f64],
    ) -> Result<(), Halt> {
        self.loaded.write(loads, self.map.interpolate(loads, span, instants), instants, a)
    }
}

/// The combinations with the accelerations under the loads.
#[derive(Clone, Debug)]
struct LoadedCombinations {
    /// Index at which each value is written.
    targets: Vec<usize>,
    /// V b: share of every load in every combination, a column for each load.
    mobility: Panel,
    arch: Arch,
    /// Scratch: loads, contacts and phasors of an evaluation.
    load_values: Vec<f64>,
    contacts: Vec<Contact>,
    phasors: Vec<Complex64>,
}

impl LoadedCombinations {
    /// Writes the combinations for the values of [`CombinationMap::map`] at each instant, one vector after the other.
    fn write<'v>(
        &mut self,
        loads: &Loads<'_>,
        values: impl Iterator<Item = &'v mut [f64]>,
        instants: &[f64],
        a: &mut [f64],
    ) -> Result<(), Halt> {
        let len = (a.len() / instants.len().max(1)).max(1);
        for ((elapsed, values), a) in instants.iter().zip(values).zip(a.chunks_exact_mut(len)) {
            let (own, interface_state) = values.split_at_mut(self.targets.len());
            loads.phasors(*elapsed, &mut self.phasors);
            loads.load(*elapsed, &self.phasors, interface_state, &mut self.load_values, &mut self.contacts, None)?;
            accumulate_panel(self.arch, &self.mobility, &self.load_values, own);
            for (index, value) in self.targets.iter().zip(own) {
                a[*index] = *value;
            }
        }
        Ok(())
    }
}
