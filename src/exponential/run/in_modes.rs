//! The motion ż = A z + Σ b p(t, w z) in modal coordinates, for Runge–Kutta methods.
//!
//! Modal damping is a dense matrix over the displacements, but block-diagonal in these coordinates.

use pulp::Arch;

use crate::exponential::loads::Loads;
use crate::exponential::propagator::{InterfaceMaps, kernel};
use crate::exponential::within_step::OutputMap;
use crate::integrate::{Deferred, FirstOrderSystem, Halt, Span, Trajectory};
use crate::mesh::Contact;
use crate::modal::ModalStateSpace;

/// The loads on the linear motion, as a first-order system in z.
#[derive(Clone, Debug)]
pub struct InModes<'m> {
    loads: Loads<'m>,
    linear: &'m ModalStateSpace,
    maps: InterfaceMaps,
    output: OutputMap,
    /// Rows w, one after the other.
    rows: Vec<f64>,
    arch: Arch,
    /// Indices of all slots: contact modes depend on every mode.
    every_slot: Vec<usize>,
    /// Scratch: interface state, loads and contacts of an evaluation, and a state within a step.
    interface_state: Vec<f64>,
    load_values: Vec<f64>,
    contacts: Vec<Contact>,
    state: Vec<f64>,
}

impl<'m> InModes<'m> {
    /// Creates the system; `output` maps z to the coordinates that observers read.
    pub fn new(loads: Loads<'m>, linear: &'m ModalStateSpace, maps: InterfaceMaps, output: OutputMap) -> Self {
        Self {
            rows: maps.rows.concat(),
            arch: Arch::new(),
            every_slot: (0..linear.slots).collect(),
            interface_state: vec![0.0; loads.interface_len()],
            load_values: vec![0.0; loads.load_count()],
            contacts: vec![Contact::default(); loads.connection_count()],
            state: vec![0.0; linear.len()],
            loads,
            linear,
            maps,
            output: output.complete(),
        }
    }

    /// Computes the interface state of a state z.
    fn observe(&mut self, elapsed: f64, z: &[f64]) {
        kernel::scalars(self.arch, &self.rows, z, &mut self.interface_state);
        self.loads.add_synchronous_at(elapsed, &mut self.interface_state);
    }

    /// Passes the output map and the state at each of the instants within a step to `visit`.
    fn visit_states(&mut self, span: &Span<'_>, instants: &[f64], mut visit: impl FnMut(&mut OutputMap, &[f64])) {
        for elapsed in instants {
            span.write_cubic(*elapsed, &mut self.state);
            visit(&mut self.output, &self.state);
        }
    }

    /// The loads on the linear motion.
    pub fn loads(&self) -> &Loads<'m> {
        &self.loads
    }
}

impl FirstOrderSystem for InModes<'_> {
    fn len(&self) -> usize {
        self.linear.len()
    }

    fn derivative(&mut self, elapsed: f64, z: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        self.observe(elapsed, z);
        self.loads.load(elapsed, &self.interface_state, &mut self.load_values, &mut self.contacts, None)?;
        self.linear.multiply(z, derivative);
        for (p, column) in self.load_values.iter().zip(&self.maps.columns) {
            for (derivative, b) in derivative.iter_mut().zip(column) {
                *derivative += b * p;
            }
        }
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        self.loads.motion.switching().map(|_| self.every_slot.as_slice())
    }

    fn within(&self, span: &Span<'_>, elapsed: f64, z: &mut [f64]) {
        // The step resolves every mode, so that the cubic is accurate for all of them.
        span.write_cubic(elapsed, z);
    }

    fn trajectory<'a>(&'a mut self, span: Span<'a>) -> impl Trajectory + 'a {
        ModalTrajectory { span, system: self }
    }

    fn physical(&mut self, elapsed: f64, z: &[f64], q: &mut [f64], v: &mut [f64]) {
        self.output.read(&self.loads, elapsed, z, q, v);
    }

    fn contact_modes_at(&mut self, elapsed: f64, z: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        self.observe(elapsed, z);
        self.loads.contact_modes(elapsed, &self.interface_state, &[], contact_modes)
    }

    fn set_contact_modes(&mut self, contact_modes: &[i64]) {
        self.loads.motion.set_contact_modes(contact_modes);
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        let mut square = [0.0];
        kernel::scalars(self.arch, difference, difference, &mut square);
        square[0].sqrt()
    }

    fn size(&mut self, z: &[f64]) -> f64 {
        self.norm(z).hypot(self.loads.synchronous_size)
    }
}

/// The motion over a step, for observers.
struct ModalTrajectory<'a, 'm> {
    span: Span<'a>,
    system: &'a mut InModes<'m>,
}

impl Trajectory for ModalTrajectory<'_, '_> {
    fn begin(&self) -> f64 {
        self.span.start
    }

    fn end(&self) -> f64 {
        self.span.start + self.span.step
    }

    fn states(&mut self, instants: &[f64], _: &[usize], q: &mut [f64], v: &mut [f64]) {
        let system = &mut *self.system;
        system.visit_states(&self.span, instants, |output, z| output.gather(z));
        system.output.read_gathered(&system.loads, instants, q, v);
    }

    fn accelerations(&mut self, instants: &[f64], _: &[usize], a: &mut [f64]) -> Result<(), Halt> {
        let system = &mut *self.system;
        system.visit_states(&self.span, instants, |output, z| {
            output.accelerations.iter_mut().for_each(|map| map.gather(z));
        });
        system.output.read_accelerations(&system.loads, instants, a)
    }

    fn combines(&mut self, instants: &[f64]) -> Result<bool, Halt> {
        let system = &mut *self.system;
        system.visit_states(&self.span, instants, |output, z| {
            output.combinations.iter_mut().for_each(|map| map.gather(z));
        });
        let Some(map) = &mut system.output.combinations else { return Ok(false) };
        map.add_loads(&system.loads, instants)?;
        Ok(true)
    }

    fn deferred(&mut self, receive: &mut dyn FnMut(Deferred<'_>)) {
        self.system.output.evaluate_deferred(&self.system.loads, true, receive);
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        None
    }
}
