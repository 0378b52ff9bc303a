//! Displacements and velocities of the coordinates asked for, from a state.

use num_complex::Complex64;
use pulp::Arch;

use super::driver::Reached;
use super::field::{Field, add_turned};
use super::kernel;
use super::packed::Rows;
use super::sample::Sample;
use crate::integrate::{Span, Trajectory};
use crate::modal::Linear;

/// Coordinates that are looked at.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Those whose displacement is wanted.
    pub displacements: Vec<usize>,
    /// Those whose velocity is.
    pub velocities: Vec<usize>,
}

/// The rows of a selection.
#[derive(Clone, Debug)]
pub struct Output {
    selection: Selection,
    rows: Rows,
    reference: Vec<f64>,
    /// Of the synchronous motion, source after source.
    amplitudes: Vec<Complex64>,
    values: Vec<f64>,
    ends: [Vec<f64>; 4],
    turns: Vec<Complex64>,
    arch: Arch,
}

impl Output {
    /// What a selection of a field's motion needs.
    pub fn new(field: &Field<'_>, linear: &Linear, selection: Selection) -> Self {
        let both = || {
            let displacements = selection.displacements.iter().map(|index| (*index, false));
            displacements.chain(selection.velocities.iter().map(|index| (*index, true)))
        };
        let rows: Vec<_> = both().map(|(index, rate)| linear.row(&[(index, 1.0)], rate)).collect();
        let amplitudes = (0..field.sources())
            .flat_map(|source| both().map(move |(index, rate)| field.amplitude(source, index, rate)))
            .collect();
        let reference = both().map(|(index, rate)| if rate { 0.0 } else { field.reference[index] }).collect();
        Self {
            values: vec![0.0; both().count()],
            ends: std::array::from_fn(|_| vec![0.0; both().count()]),
            turns: vec![Complex64::ZERO; field.sources()],
            rows: Rows::new(&rows, &linear.parts),
            reference,
            amplitudes,
            selection,
            arch: Arch::new(),
        }
    }

    /// Displacements and velocities of the selection at a state, into whole vectors.
    pub fn read(&mut self, field: &Field<'_>, elapsed: f64, z: &[f64], q: &mut [f64], v: &mut [f64]) {
        kernel::seen(self.arch, &self.rows, z, &mut self.values);
        self.write(field, elapsed, q, v);
    }

    /// The same within a step whose ends are known with their rates, by the cubic through them.
    pub fn interpolate(&mut self, field: &Field<'_>, span: &Span<'_>, elapsed: f64, q: &mut [f64], v: &mut [f64]) {
        let sides = [span.before.0, span.before.1, span.after.0, span.after.1];
        for (end, z) in self.ends.iter_mut().zip(sides) {
            kernel::seen(self.arch, &self.rows, z, end);
        }
        let weights = span.cubic(elapsed);
        for (at, value) in self.values.iter_mut().enumerate() {
            *value = weights.iter().zip(&self.ends).map(|(weight, end)| weight * end[at]).sum();
        }
        self.write(field, elapsed, q, v);
    }

    /// Adds what is carried to the values and writes them where they belong.
    fn write(&mut self, field: &Field<'_>, elapsed: f64, q: &mut [f64], v: &mut [f64]) {
        field.turns(elapsed, &mut self.turns);
        for (value, reference) in self.values.iter_mut().zip(&self.reference) {
            *value += reference;
        }
        for (turn, amplitudes) in self.turns.iter().zip(self.amplitudes.chunks_exact(self.values.len().max(1))) {
            add_turned(amplitudes, *turn, &mut self.values);
        }
        let (displacements, velocities) = self.values.split_at(self.selection.displacements.len());
        for (index, value) in self.selection.displacements.iter().zip(displacements) {
            q[*index] = *value;
        }
        for (index, value) in self.selection.velocities.iter().zip(velocities) {
            v[*index] = *value;
        }
    }
}

/// The motion over a step, for those who look at it.
pub(super) struct Course<'a, 'm> {
    pub reached: Reached<'a, 'm>,
    pub output: &'a mut Output,
    pub sample: &'a mut Sample,
}

impl Trajectory for Course<'_, '_> {
    fn begin(&self) -> f64 {
        self.reached.begin
    }

    fn end(&self) -> f64 {
        self.reached.end
    }

    fn state(&mut self, elapsed: f64, _: &[usize], q: &mut [f64], v: &mut [f64]) {
        let Reached { stepper, level, z, begin, .. } = self.reached;
        let step = stepper.table.clock.step(level);
        let within = elapsed - begin;
        // Times asked for on the grid of the steps are met as exactly as they can be told.
        if (within - step).abs() <= 1e-9 * step {
            self.output.read(&stepper.field, elapsed, &stepper.after, q, v);
        } else if within.abs() <= 1e-9 * step {
            self.output.read(&stepper.field, elapsed, z, q, v);
        } else {
            let z = self.sample.within(stepper, level, z, within);
            self.output.read(&stepper.field, elapsed, z, q, v);
        }
    }

    fn is_resolved(&self) -> bool {
        false
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        None
    }
}
