//! Displacements and velocities of selected coordinates, from modal states.

use num_complex::Complex64;
use pulp::Arch;

use super::kernel;
use super::nonlinear_loads::NonlinearLoads;
use super::packed::Rows;
use super::rotating_source::add_rotated;
use crate::integrate::{Span, at_each};
use crate::modal::ModalStateSpace;
use crate::motion::PowerCoordinates;

/// Coordinates that a run reads.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Indices of the displacements.
    pub displacements: Vec<usize>,
    /// Indices of the velocities.
    pub velocities: Vec<usize>,
    /// Coordinates from which powers follow, if the run records energies.
    pub powers: Option<PowerCoordinates>,
}

/// Rows that map a state z to the selected displacements and velocities.
#[derive(Clone, Debug)]
pub struct OutputMap {
    /// Indices of the displacements, then those of sums of displacements, which are written behind all coordinates.
    displacements: Vec<usize>,
    /// Indices of the velocities.
    velocities: Vec<usize>,
    /// The map to the coordinates from which powers follow.
    powers: Option<Box<OutputMap>>,
    rows: Rows,
    /// Values at the reference, m or rad; zero for velocities.
    reference: Vec<f64>,
    /// Complex amplitudes of the synchronous motion, source after source.
    amplitudes: Vec<Complex64>,
    /// Scratch: gathered states, one after the other, and their values.
    states: Vec<f64>,
    values: Vec<f64>,
    /// Scratch: values at both ends of a step.
    ends: Vec<f64>,
    /// Scratch: phasors of the sources.
    phasors: Vec<Complex64>,
    arch: Arch,
}

impl OutputMap {
    /// Collects the rows of a selection.
    pub fn new(nonlinear_loads: &NonlinearLoads<'_>, linear: &ModalStateSpace, selection: Selection) -> Self {
        let Selection { displacements, velocities, powers } = selection;
        let powers = powers.map(|PowerCoordinates { displacements, velocities, combinations }| {
            Box::new(Self::of_sums(nonlinear_loads, linear, (displacements, velocities), &combinations))
        });
        Self { powers, ..Self::of_sums(nonlinear_loads, linear, (displacements, velocities), &[]) }
    }

    /// Collects the rows of displacements and velocities with these indices, and of sums of displacements.
    fn of_sums(
        nonlinear_loads: &NonlinearLoads<'_>,
        linear: &ModalStateSpace,
        (mut displacements, velocities): (Vec<usize>, Vec<usize>),
        sums: &[Vec<(usize, f64)>],
    ) -> Self {
        let single = |index: &usize| vec![(*index, 1.0)];
        let mut scalars: Vec<_> = displacements.iter().map(|index| (single(index), false)).collect();
        scalars.extend(sums.iter().map(|entries| (entries.clone(), false)));
        scalars.extend(velocities.iter().map(|index| (single(index), true)));
        let first = nonlinear_loads.reference.len();
        displacements.extend(first..first + sums.len());
        let rows: Vec<_> = scalars.iter().map(|(entries, rate)| linear.row(entries, *rate)).collect();
        let amplitude = |source: usize, entries: &[(usize, f64)], rate: bool| -> Complex64 {
            entries.iter().map(|(index, factor)| nonlinear_loads.amplitude(source, *index, rate) * factor).sum()
        };
        let amplitudes = (0..nonlinear_loads.source_count())
            .flat_map(|source| scalars.iter().map(move |(entries, rate)| amplitude(source, entries, *rate)))
            .collect();
        let at_reference = |entries: &[(usize, f64)]| {
            entries.iter().map(|(index, factor)| nonlinear_loads.reference[*index] * factor).sum()
        };
        let reference = scalars.iter().map(|(entries, rate)| if *rate { 0.0 } else { at_reference(entries) }).collect();
        Self {
            states: Vec::with_capacity(linear.len()),
            values: Vec::with_capacity(scalars.len()),
            ends: Vec::new(),
            phasors: vec![Complex64::ZERO; nonlinear_loads.source_count()],
            rows: Rows::new(&rows, &linear.parts),
            reference,
            amplitudes,
            displacements,
            velocities,
            powers: None,
            arch: Arch::new(),
        }
    }

    /// The map to the coordinates from which powers follow, if there is one.
    pub(super) fn powers(&mut self) -> Option<&mut Self> {
        self.powers.as_deref_mut()
    }

    /// Writes the selected displacements and velocities of a state into vectors of all coordinates.
    pub fn read(
        &mut self,
        nonlinear_loads: &NonlinearLoads<'_>,
        elapsed: f64,
        z: &[f64],
        q: &mut [f64],
        v: &mut [f64],
    ) {
        self.gather(z);
        self.read_gathered(nonlinear_loads, &[elapsed], q, v);
    }

    /// Adds a state to those that [`Self::read_gathered`] reads together.
    pub(super) fn gather(&mut self, z: &[f64]) {
        self.states.extend_from_slice(z);
    }

    /// Writes the selected coordinates of all gathered states, which belong to `instants`, one vector after the other.
    pub(super) fn read_gathered(
        &mut self,
        nonlinear_loads: &NonlinearLoads<'_>,
        instants: &[f64],
        q: &mut [f64],
        v: &mut [f64],
    ) {
        self.map_states(instants.len());
        self.write(nonlinear_loads, instants, q, v);
    }

    /// Writes the selected coordinates at instants within a step, by the cubic through the states and rates at both ends.
    pub(super) fn interpolate(
        &mut self,
        nonlinear_loads: &NonlinearLoads<'_>,
        span: &Span<'_>,
        instants: &[f64],
        q: &mut [f64],
        v: &mut [f64],
    ) {
        let sides = [span.before.0, span.before.1, span.after.0, span.after.1];
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
        self.write(nonlinear_loads, instants, q, v);
    }

    /// Maps the gathered states to values.
    fn map_states(&mut self, states: usize) {
        self.values.resize(states * self.rows.count, 0.0);
        kernel::row_products_of(self.arch, &self.rows, states, &self.states, &mut self.values);
        self.states.clear();
    }

    /// Adds the reference and the synchronous motion to the values and writes them to their coordinates.
    fn write(&mut self, nonlinear_loads: &NonlinearLoads<'_>, instants: &[f64], q: &mut [f64], v: &mut [f64]) {
        let count = self.rows.count.max(1);
        for (values, (elapsed, q, v)) in self.values.chunks_exact_mut(count).zip(at_each(instants, q, v)) {
            nonlinear_loads.phasors(elapsed, &mut self.phasors);
            for (value, reference) in values.iter_mut().zip(&self.reference) {
                *value += reference;
            }
            for (phasor, amplitudes) in self.phasors.iter().zip(self.amplitudes.chunks_exact(count)) {
                add_rotated(amplitudes, *phasor, values);
            }
            let (displacements, velocities) = values.split_at(self.displacements.len());
            for (index, value) in self.displacements.iter().zip(displacements) {
                q[*index] = *value;
            }
            for (index, value) in self.velocities.iter().zip(velocities) {
                v[*index] = *value;
            }
        }
    }
}
