//! Displacements and velocities of the coordinates asked for, from a state.

use num_complex::Complex64;
use pulp::Arch;

use super::driver::Reached;
use super::kernel;
use super::nonlinear_loads::{NonlinearLoads, add_turned};
use super::packed::Rows;
use super::substep::SubstepSampler;
use crate::integrate::{Span, Trajectory, at_each};
use crate::modal::ModalStateSpace;

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
pub struct OutputMap {
    selection: Selection,
    rows: Rows,
    reference: Vec<f64>,
    /// Of the synchronous motion, source after source.
    amplitudes: Vec<Complex64>,
    /// States side by side, and what is seen of them.
    states: Vec<f64>,
    values: Vec<f64>,
    /// What is seen of both ends of a step.
    ends: Vec<f64>,
    phasors: Vec<Complex64>,
    arch: Arch,
}

impl OutputMap {
    /// What a selection of a field's motion needs.
    pub fn new(field: &NonlinearLoads<'_>, linear: &ModalStateSpace, selection: Selection) -> Self {
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
            states: Vec::with_capacity(linear.len()),
            values: Vec::with_capacity(both().count()),
            ends: Vec::new(),
            phasors: vec![Complex64::ZERO; field.sources()],
            rows: Rows::new(&rows, &linear.parts),
            reference,
            amplitudes,
            selection,
            arch: Arch::new(),
        }
    }

    /// Displacements and velocities of the selection at a state, into whole vectors.
    pub fn read(&mut self, field: &NonlinearLoads<'_>, elapsed: f64, z: &[f64], q: &mut [f64], v: &mut [f64]) {
        self.gather(z);
        self.read_gathered(field, &[elapsed], q, v);
    }

    /// Puts a state beside those that are to be read together.
    pub(super) fn gather(&mut self, z: &[f64]) {
        self.states.extend_from_slice(z);
    }

    /// The same at the instants of the states that were gathered, one vector after the other.
    pub(super) fn read_gathered(&mut self, field: &NonlinearLoads<'_>, instants: &[f64], q: &mut [f64], v: &mut [f64]) {
        self.see(instants.len());
        self.write(field, instants, q, v);
    }

    /// The same within a step whose ends are known with their rates, by the cubic through them.
    pub(super) fn interpolate(
        &mut self,
        field: &NonlinearLoads<'_>,
        span: &Span<'_>,
        instants: &[f64],
        q: &mut [f64],
        v: &mut [f64],
    ) {
        let sides = [span.before.0, span.before.1, span.after.0, span.after.1];
        sides.into_iter().for_each(|z| self.gather(z));
        self.see(sides.len());
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
        self.write(field, instants, q, v);
    }

    /// What is seen of the states that were gathered.
    fn see(&mut self, states: usize) {
        self.values.resize(states * self.rows.count, 0.0);
        kernel::seen_of(self.arch, &self.rows, states, &self.states, &mut self.values);
        self.states.clear();
    }

    /// Adds what is carried to the values and writes them where they belong.
    fn write(&mut self, field: &NonlinearLoads<'_>, instants: &[f64], q: &mut [f64], v: &mut [f64]) {
        let count = self.rows.count.max(1);
        for (values, (elapsed, q, v)) in self.values.chunks_exact_mut(count).zip(at_each(instants, q, v)) {
            field.phasors(elapsed, &mut self.phasors);
            for (value, reference) in values.iter_mut().zip(&self.reference) {
                *value += reference;
            }
            for (turn, amplitudes) in self.phasors.iter().zip(self.amplitudes.chunks_exact(count)) {
                add_turned(amplitudes, *turn, values);
            }
            let (displacements, velocities) = values.split_at(self.selection.displacements.len());
            for (index, value) in self.selection.displacements.iter().zip(displacements) {
                q[*index] = *value;
            }
            for (index, value) in self.selection.velocities.iter().zip(velocities) {
                v[*index] = *value;
            }
        }
    }
}

/// The motion over a step, for those who look at it.
pub(super) struct StepTrajectory<'a, 'm> {
    pub reached: Reached<'a, 'm>,
    pub output: &'a mut OutputMap,
    pub sample: &'a mut SubstepSampler,
}

impl Trajectory for StepTrajectory<'_, '_> {
    fn begin(&self) -> f64 {
        self.reached.begin
    }

    fn end(&self) -> f64 {
        self.reached.end
    }

    fn states(&mut self, instants: &[f64], _: &[usize], q: &mut [f64], v: &mut [f64]) {
        let Reached { stepper, level, z, begin, .. } = self.reached;
        let step = stepper.cache.time_grid.step(level);
        for elapsed in instants {
            let within = elapsed - begin;
            // Times asked for on the grid of the steps are met as exactly as they can be told.
            let z = if (within - step).abs() <= 1e-9 * step {
                &stepper.after
            } else if within.abs() <= 1e-9 * step {
                z
            } else {
                self.sample.within(stepper, level, z, within)
            };
            self.output.gather(z);
        }
        self.output.read_gathered(&stepper.field, instants, q, v);
    }

    fn is_resolved(&self) -> bool {
        false
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        None
    }
}
