//! The same motion for Runge–Kutta methods, in the coordinates of the modes.
//!
//! Damping that is a ratio of every mode is dense over the displacements, and diagonal here: ż = A z + Σ b p(t, w z)
//! costs a few numbers for each mode.

use num_complex::Complex64;
use pulp::Arch;

use super::cache::InterfaceMaps;
use super::kernel;
use super::nonlinear_loads::NonlinearLoads;
use super::output::OutputMap;
use crate::integrate::{FirstOrderSystem, Halt, Span, Trajectory};
use crate::mesh::Contact;
use crate::modal::ModalStateSpace;

/// A field on its modes, as a system to integrate.
#[derive(Clone, Debug)]
pub struct InModes<'m> {
    field: NonlinearLoads<'m>,
    linear: &'m ModalStateSpace,
    maps: InterfaceMaps,
    output: OutputMap,
    /// Everything, where the coordinates of an instant are asked for as a whole.
    rows: Vec<f64>,
    arch: Arch,
    every: Vec<usize>,
    u: Vec<f64>,
    loads: Vec<f64>,
    contacts: Vec<Contact>,
    phasors: Vec<Complex64>,
}

impl<'m> InModes<'m> {
    /// The system of a field; `output` is what will be looked at.
    pub fn new(field: NonlinearLoads<'m>, linear: &'m ModalStateSpace, maps: InterfaceMaps, output: OutputMap) -> Self {
        Self {
            rows: maps.rows.concat(),
            arch: Arch::new(),
            every: (0..linear.slots).collect(),
            u: vec![0.0; field.seen()],
            loads: vec![0.0; field.loads()],
            contacts: vec![Contact::default(); field.meshes()],
            phasors: vec![Complex64::ZERO; field.sources()],
            field,
            linear,
            maps,
            output,
        }
    }

    /// Scalars and rates of a state.
    fn look(&mut self, elapsed: f64, z: &[f64]) {
        kernel::scalars(self.arch, &self.rows, z, &mut self.u);
        self.field.phasors(elapsed, &mut self.phasors);
        self.field.add_synchronous(&self.phasors, &mut self.u);
    }

    /// What acts.
    pub fn field(&self) -> &NonlinearLoads<'m> {
        &self.field
    }
}

impl FirstOrderSystem for InModes<'_> {
    fn len(&self) -> usize {
        self.linear.len()
    }

    fn derivative(&mut self, elapsed: f64, z: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        self.look(elapsed, z);
        self.field.load(elapsed, &self.phasors, &self.u, &mut self.loads, &mut self.contacts)?;
        self.linear.multiply(z, derivative);
        for (p, column) in self.loads.iter().zip(&self.maps.columns) {
            for (derivative, b) in derivative.iter_mut().zip(column) {
                *derivative += b * p;
            }
        }
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        self.field.motion.switching().map(|_| self.every.as_slice())
    }

    fn within(&self, span: &Span<'_>, elapsed: f64, z: &mut [f64]) {
        // Every mode is resolved by the step.
        let weights = span.cubic(elapsed);
        let sides = [span.before.0, span.before.1, span.after.0, span.after.1];
        for (at, z) in z.iter_mut().enumerate() {
            *z = weights.iter().zip(sides).map(|(weight, side)| weight * side[at]).sum();
        }
    }

    fn trajectory<'a>(&'a mut self, span: Span<'a>) -> impl Trajectory + 'a {
        InStep { span, system: self }
    }

    fn physical(&mut self, elapsed: f64, z: &[f64], q: &mut [f64], v: &mut [f64]) {
        self.output.read(&self.field, elapsed, z, q, v);
    }

    fn contact_modes_at(&mut self, elapsed: f64, z: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        self.look(elapsed, z);
        self.field.contact_modes(elapsed, &self.u, &[], contact_modes)
    }

    fn set_contact_modes(&mut self, contact_modes: &[i64]) {
        self.field.motion.set_contact_modes(contact_modes);
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        let mut square = [0.0];
        kernel::scalars(self.arch, difference, difference, &mut square);
        square[0].sqrt()
    }

    fn size(&mut self, z: &[f64]) -> f64 {
        self.norm(z).hypot(self.field.synchronous_size)
    }
}

/// A step, for those who look at it.
struct InStep<'a, 'm> {
    span: Span<'a>,
    system: &'a mut InModes<'m>,
}

impl Trajectory for InStep<'_, '_> {
    fn begin(&self) -> f64 {
        self.span.start
    }

    fn end(&self) -> f64 {
        self.span.start + self.span.step
    }

    fn states(&mut self, instants: &[f64], _: &[usize], q: &mut [f64], v: &mut [f64]) {
        let system = &mut *self.system;
        system.output.interpolate(&system.field, &self.span, instants, q, v);
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        None
    }
}
