//! Values of scalars of the motion at modal states.

use num_complex::Complex64;
use pulp::Arch;

use crate::exponential::loads::Loads;
use crate::exponential::propagator::panel_kernel::accumulate_panel;
use crate::exponential::propagator::{Panel, Rows, kernel};
use crate::integrate::Span;

/// Rows that map a state z to scalars, with what the reference and the synchronous motion add to them.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct StateMap {
    rows: Rows,
    /// Values at the reference, which are zero for rates, then for each source the values of the synchronous motion at the phase
    /// zero and a quarter turn later.
    prescribed: Panel,
    /// Working memory: the factor of each column of `prescribed`: 1, then the cosine and sine of the phase of each source.
    factors: Vec<f64>,
    /// Scratch: gathered states, one after the other, and the values of their scalars.
    states: Vec<f64>,
    values: Vec<f64>,
    /// Scratch: values at both ends of a step.
    ends: Vec<f64>,
    /// Scratch: phasors of the sources.
    phasors: Vec<Complex64>,
    arch: Arch,
}

impl StateMap {
    /// Creates a map of rows with their values at the reference and their amplitudes, source after source.
    pub fn new(rows: Rows, reference: Vec<f64>, amplitudes: Vec<Complex64>, sources: usize) -> Self {
        Self {
            states: Vec::with_capacity(rows.size),
            values: Vec::with_capacity(rows.count),
            ends: Vec::new(),
            phasors: vec![Complex64::ZERO; sources],
            factors: vec![1.0; 1 + 2 * sources],
            prescribed: prescribed(reference, &amplitudes),
            rows,
            arch: Arch::new(),
        }
    }

    /// Adds a state to those that are evaluated together.
    pub fn gather(&mut self, z: &[f64]) {
        self.states.extend_from_slice(z);
    }

    /// The values of all scalars at the gathered states, which belong to `instants`: one list for each instant.
    pub fn evaluate(&mut self, loads: &Loads<'_>, instants: &[f64]) -> impl Iterator<Item = &mut [f64]> {
        self.map_states(instants.len());
        self.complete(loads, instants)
    }

    /// The same at instants within a step, by the cubic through the states and rates at both ends.
    pub fn interpolate(
        &mut self,
        loads: &Loads<'_>,
        span: &Span<'_>,
        instants: &[f64],
    ) -> impl Iterator<Item = &mut [f64]> {
        let sides = [span.before.state, span.before.derivative, span.after.state, span.after.derivative];
        sides.into_iter().for_each(|z| self.gather(z));
        self.map_states(sides.len());
        std::mem::swap(&mut self.ends, &mut self.values);
        let count = self.rows.count.max(1);
        self.values.resize(instants.len() * self.rows.count, 0.0);
        for (elapsed, values) in instants.iter().zip(self.values.chunks_exact_mut(count)) {
            let weights = span.cubic(*elapsed);
            for (at, value) in values.iter_mut().enumerate() {
                let ends = self.ends[at..].iter().step_by(count);
                *value = weights.iter().zip(ends).map(|(weight, end)| weight * end).sum();
            }
        }
        self.complete(loads, instants)
    }

    /// Maps the gathered states to values.
    fn map_states(&mut self, states: usize) {
        self.values.resize(states * self.rows.count, 0.0);
        kernel::row_products_of(self.arch, &self.rows, states, &self.states, &mut self.values);
        self.states.clear();
    }

    /// Adds the reference and the synchronous motion to the values.
    fn complete(&mut self, loads: &Loads<'_>, instants: &[f64]) -> impl Iterator<Item = &mut [f64]> {
        let count = self.rows.count.max(1);
        for (values, elapsed) in self.values.chunks_exact_mut(count).zip(instants) {
            loads.phasors(*elapsed, &mut self.phasors);
            for (factors, phasor) in self.factors[1..].as_chunks_mut::<2>().0.iter_mut().zip(&self.phasors) {
                *factors = [phasor.re, phasor.im];
            }
            accumulate_panel(self.arch, &self.prescribed, &self.factors, values);
        }
        self.values.chunks_exact_mut(count)
    }
}

/// The panel of [`StateMap::prescribed`]; the real part of an amplitude a times a phasor e is Re a Re e − Im a Im e.
fn prescribed(mut reference: Vec<f64>, amplitudes: &[Complex64]) -> Panel {
    let count = reference.len();
    for amplitudes in amplitudes.chunks_exact(count.max(1)) {
        reference.extend(amplitudes.iter().map(|amplitude| amplitude.re));
        reference.extend(amplitudes.iter().map(|amplitude| -amplitude.im));
    }
    Panel::new(&reference, count)
}
