//! Accelerations of selected coordinates: q̈ = V ż + q̈_s with ż = A z + Σ b p and the synchronous motion q_s.
//!
//! The loads p are those of the equation of motion at the state z, not their polynomial over the step.

use num_complex::Complex64;

use super::state_map::StateMap;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::{InterfaceMaps, Rows};
use crate::integrate::{Halt, Span};
use crate::mesh::Contact;
use crate::modal::ModalStateSpace;

/// Maps a state z to the accelerations of selected coordinates.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct AccelerationMap {
    /// Accelerations of the coordinates without loads, then the interface state.
    map: StateMap,
    loaded: LoadedAccelerations,
}

impl AccelerationMap {
    /// Collects the rows of the coordinates with these indices.
    pub fn new(loads: &Loads<'_>, linear: &ModalStateSpace, maps: &InterfaceMaps, coordinates: Vec<usize>) -> Self {
        let velocities: Vec<_> = coordinates.iter().map(|index| linear.row(&[(*index, 1.0)], true)).collect();
        let rows: Vec<_> = velocities.iter().map(|row| linear.rate_row(row)).chain(maps.rows.iter().cloned()).collect();
        let product = |row: &[f64], column: &[f64]| row.iter().zip(column).map(|(w, b)| w * b).sum::<f64>();
        let mobility = velocities.iter().flat_map(|row| maps.columns.iter().map(|column| product(row, column)));
        let (sources, interface_len) = (loads.source_count(), maps.rows.len());
        let amplitudes = loads.spins().into_iter().enumerate().flat_map(|(source, spin)| {
            let rate = Complex64::new(0.0, spin);
            let own = coordinates.iter().map(move |index| loads.amplitude(source, *index, true) * rate);
            own.chain(maps.synchronous[source * interface_len..][..interface_len].iter().copied())
        });
        let reference = vec![0.0; rows.len()];
        Self {
            map: StateMap::new(Rows::new(&rows, &linear.parts), reference, amplitudes.collect(), sources),
            loaded: LoadedAccelerations {
                mobility: mobility.collect(),
                coordinates,
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

    /// Writes the accelerations at all gathered states, which belong to `instants`, one vector after the other.
    ///
    /// # Errors
    /// [`Halt`] where a load is not defined.
    pub fn read_gathered(&mut self, loads: &Loads<'_>, instants: &[f64], a: &mut [f64]) -> Result<(), Halt> {
        self.loaded.write(loads, self.map.evaluate(loads, instants), instants, a)
    }

    /// Writes the accelerations at instants within a step whose states are the cubic through both ends.
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

/// The accelerations with those under the loads.
#[derive(Clone, Debug)]
struct LoadedAccelerations {
    /// Indices of the coordinates.
    coordinates: Vec<usize>,
    /// V b: acceleration of every coordinate under every load, coordinate after coordinate.
    mobility: Vec<f64>,
    /// Scratch: loads, contacts and phasors of an evaluation.
    load_values: Vec<f64>,
    contacts: Vec<Contact>,
    phasors: Vec<Complex64>,
}

impl LoadedAccelerations {
    /// Writes the accelerations for the values of [`AccelerationMap::map`] at each instant, one vector after the other.
    fn write<'v>(
        &mut self,
        loads: &Loads<'_>,
        values: impl Iterator<Item = &'v [f64]>,
        instants: &[f64],
        a: &mut [f64],
    ) -> Result<(), Halt> {
        let (count, len) = (self.load_values.len(), (a.len() / instants.len().max(1)).max(1));
        for ((elapsed, values), a) in instants.iter().zip(values).zip(a.chunks_exact_mut(len)) {
            let (own, interface_state) = values.split_at(self.coordinates.len());
            loads.phasors(*elapsed, &mut self.phasors);
            loads.load(*elapsed, &self.phasors, interface_state, &mut self.load_values, &mut self.contacts, None)?;
            for (at, (index, value)) in self.coordinates.iter().zip(own).enumerate() {
                let mobility = &self.mobility[at * count..(at + 1) * count];
                let by_loads: f64 =
                    mobility.iter().zip(&self.load_values).map(|(mobility, load)| mobility * load).sum();
                a[*index] = value + by_loads;
            }
        }
        Ok(())
    }
}
