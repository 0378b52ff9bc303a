//! Values of scalars of the motion at modal states.

use num_complex::Complex64;
use pulp::Arch;

use crate::exponential::loads::Loads;
use crate::exponential::propagator::panel_kernel::accumulate_panel;
use crate::exponential::propagator::{Panel, Rows, kernel};
use crate::modal::ModalStateSpace;
use crate::model::Combination;

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
    /// Scratch: phasors of the sources.
    phasors: Vec<Complex64>,
    arch: Arch,
}

impl StateMap {
    /// Creates a map of rows with their values at the reference and their amplitudes, source after source.
    pub fn new(rows: Rows, reference: Vec<f64>, amplitudes: &[Complex64]) -> Self {
        let sources = amplitudes.len() / rows.count.max(1);
        Self {
            states: Vec::with_capacity(rows.size),
            values: Vec::with_capacity(rows.count),
            phasors: vec![Complex64::ZERO; sources],
            factors: vec![1.0; 1 + 2 * sources],
            prescribed: prescribed(reference, amplitudes),
            rows,
            arch: Arch::new(),
        }
    }

    /// Creates the map of combinations of coordinates, without the loads in their accelerations.
    pub fn of(loads: &Loads<'_>, linear: &ModalStateSpace, combinations: &[Combination]) -> Self {
        let row = |each: &Combination| {
            let mut sum = linear.rate_row(&linear.row(&each.acceleration, true));
            for row in [linear.row(&each.displacement, false), linear.row(&each.velocity, true)] {
                sum.iter_mut().zip(&row).for_each(|(sum, value)| *sum += value);
            }
            sum
        };
        let rows: Vec<_> = combinations.iter().map(row).collect();
        let at_reference = |each: &Combination| -> f64 {
            each.displacement.iter().map(|(index, factor)| loads.reference[*index] * factor).sum()
        };
        let amplitudes = loads.spins().into_iter().enumerate().flat_map(|(source, spin)| {
            let sum = move |row: &[(usize, f64)], rate: bool| -> Complex64 {
                row.iter().map(|(index, factor)| loads.amplitude(source, *index, rate) * *factor).sum()
            };
            combinations.iter().map(move |each| {
                let accelerated = sum(&each.acceleration, true) * Complex64::new(0.0, spin);
                sum(&each.displacement, false) + sum(&each.velocity, true) + accelerated
            })
        });
        let reference = combinations.iter().map(at_reference).collect();
        Self::new(Rows::new(&rows, &linear.parts), reference, &amplitudes.collect::<Vec<_>>())
    }

    /// Adds a state to those that are evaluated together.
    pub fn gather(&mut self, z: &[f64]) {
        self.states.extend_from_slice(z);
    }

    /// The values of all scalars at the gathered states, which belong to `instants`: one list for each instant.
    pub fn evaluate(&mut self, loads: &Loads<'_>, instants: &[f64]) -> impl Iterator<Item = &mut [f64]> {
        self.values.resize(instants.len() * self.rows.count, 0.0);
        kernel::row_products_of(self.arch, &self.rows, instants.len(), &self.states, &mut self.values);
        self.states.clear();
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
