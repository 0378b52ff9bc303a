//! Loads on the linear motion: forces of the connections through their interfaces, loads of a changing speed, and
//! prescribed loads.
//!
//! The integrated motion is the deviation from a reference and from the synchronous motion. The reference is the static
//! equilibrium, if it exists. The synchronous motion is the response of the linear motion to bow and unbalance. It does not
//! exist at a critical speed without damping. There, bow and unbalance of the shaft act as prescribed loads.

use std::ops::Range;

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::changing_speed::{ChangingSpeedLoads, LoadCounts, SpeedChange};
use super::prescribed::{Prescribed, prescribed_loads};
use super::rotating_source::{add_rotated, interface_amplitudes, synchronous_amplitudes};
use crate::connection::{GuaranteedInterval, Interface, InterfaceOptions, Tangent};
use crate::exponential::propagator::{InterfaceMaps, LinearizedDirection};
use crate::integrate::Halt;
use crate::mesh::{Contact, ContactMode, Overlap};
use crate::modal::ModalStateSpace;
use crate::motion::EquationOfMotion;

/// Loads on the linear motion.
#[derive(Clone, Debug)]
pub struct Loads<'m> {
    /// The equation of motion.
    pub motion: EquationOfMotion<'m>,
    /// Displacements of the reference, m or rad.
    pub reference: DVector<f64>,
    /// Interfaces of all connections.
    interfaces: Vec<Interface>,
    /// Number of interface scalars of all connections.
    pub scalars: usize,
    /// Whether the interface state also contains the rates of the scalars.
    pub has_rates: bool,
    /// Complex synchronous amplitudes of all displacements, m or rad, one column for each source.
    amplitudes: DMatrix<Complex<f64>>,
    /// Complex synchronous amplitudes of the scalars and rates, source after source.
    interface_amplitudes: Vec<Complex64>,
    prescribed: Vec<Prescribed>,
    /// Loads of a changing speed.
    changing: Option<Box<ChangingSpeedLoads>>,
    changing_counts: LoadCounts,
    /// Energy norm of the synchronous motion, averaged over the angles of the sources.
    pub synchronous_size: f64,
}

impl<'m> Loads<'m> {
    /// Collects the loads of a motion about `reference`, and the maps between them and `linear`. `synchronous` holds the
    /// complex amplitudes of all displacements, one column for each source. Columns of sources that are
    /// resonant, see [`super::is_resonant`], are not read.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles at the reference, with the index of the mesh.
    pub fn new(
        motion: EquationOfMotion<'m>,
        linear: &ModalStateSpace,
        reference: DVector<f64>,
        synchronous: &DMatrix<Complex<f64>>,
    ) -> Result<(Self, InterfaceMaps), (usize, Overlap)> {
        let interfaces = interfaces(&motion, &reference, linear.includes_meshes)?;
        let entries: Vec<Vec<(usize, f64)>> = interfaces.iter().flat_map(Interface::rows).collect();
        let has_rates = interfaces.iter().any(Interface::has_rates);
        let kinds: &[bool] = if has_rates { &[false, true] } else { &[false] };
        let rows: Vec<Vec<f64>> =
            kinds.iter().flat_map(|rate| entries.iter().map(|entry| linear.row(entry, *rate))).collect();
        let connection_columns: Vec<Vec<f64>> = entries.iter().map(|entry| linear.column(entry)).collect();
        let tangents = LinearizedDirection::all(&interfaces, linear.includes_meshes);
        let (prescribed, prescribed_columns) = prescribed_loads(&motion, linear, &interfaces, &entries, &reference);
        let amplitudes = synchronous_amplitudes(linear, motion.sources(), synchronous);
        let interface_amplitudes = interface_amplitudes(motion.sources(), kinds, &entries, &amplitudes);
        let mut loads = Self {
            scalars: entries.len(),
            motion,
            reference,
            interfaces,
            has_rates,
            amplitudes,
            interface_amplitudes,
            prescribed,
            changing: None,
            changing_counts: LoadCounts::default(),
            synchronous_size: 0.0,
        };
        loads.synchronous_size = loads.size_of_synchronous(linear.includes_meshes);
        let (parts, synchronous) = (linear.parts.clone(), loads.interface_amplitudes.clone());
        let (scalars, columns) = (connection_columns.len(), [connection_columns, prescribed_columns].concat());
        let maps =
            InterfaceMaps { rows, scalars, has_rates, columns, coupled_loads: scalars, parts, tangents, synchronous };
        Ok((loads, maps))
    }

    /// Adds the loads of a changing speed, and their rows and columns to the maps.
    pub fn add_changing_speed(&mut self, linear: &ModalStateSpace, change: &SpeedChange, maps: &mut InterfaceMaps) {
        let loads = ChangingSpeedLoads::new(&self.motion, linear, change, &self.reference, maps);
        self.changing_counts = loads.counts();
        self.changing = Some(Box::new(loads));
    }

    /// Longest step from an instant on, s, where the time grid has steps of up to `longest`; infinite at a constant
    /// speed.
    #[inline]
    pub fn longest_step(&self, elapsed: f64, longest: f64) -> f64 {
        let Some(changing) = &self.changing else {
            return f64::INFINITY;
        };
        let speed = |at: f64| self.motion.reference_shaft(at).map_or(0.0, |shaft| shaft.speed.abs());
        changing.longest_step(speed(elapsed).max(speed(elapsed + longest)))
    }

    /// Length of the interface state: number of scalars and rates.
    pub fn interface_len(&self) -> usize {
        self.scalars * if self.has_rates { 2 } else { 1 } + self.changing_counts.scalars
    }

    /// Number of loads.
    pub fn load_count(&self) -> usize {
        self.scalars + self.changing_counts.loads + self.prescribed.len()
    }

    /// Number of connections with an interface.
    pub fn connection_count(&self) -> usize {
        self.interfaces.len()
    }

    /// Number of loads that depend on the motion: those of connections, one for each interface scalar, and those of a
    /// changing speed.
    pub fn coupled_load_count(&self) -> usize {
        self.scalars + self.changing_counts.coupled_loads
    }

    /// Angular velocities of the sources, rad/s.
    pub fn spins(&self) -> Vec<f64> {
        self.motion.sources().iter().map(|source| source.spin).collect()
    }

    /// Whether bow and unbalance of a shaft act as prescribed loads.
    pub fn is_resonant(&self) -> bool {
        self.prescribed.iter().any(|load| !matches!(load, Prescribed::Constant))
    }

    /// Writes e^{iϑ} of every source.
    pub fn phasors(&self, elapsed: f64, phasors: &mut [Complex64]) {
        for (phasor, source) in phasors.iter_mut().zip(self.motion.sources()) {
            *phasor = source.phasor(elapsed, None);
        }
    }

    /// Adds the synchronous motion to the interface state `u`.
    pub fn add_synchronous(&self, phasors: &[Complex64], u: &mut [f64]) {
        for (index, phasor) in phasors.iter().enumerate() {
            self.add_source(index, *phasor, u);
        }
    }

    /// Whether every connection has one scalar and its load is an affine function of it.
    pub fn is_affine(&self) -> bool {
        self.changing_counts.coupled_loads == 0 && self.interfaces.iter().all(Interface::is_affine)
    }

    /// Adds the synchronous motion at a time for which no phasors are stored.
    pub fn add_synchronous_at(&self, elapsed: f64, u: &mut [f64]) {
        for (index, source) in self.motion.sources().iter().enumerate() {
            self.add_source(index, source.phasor(elapsed, None), u);
        }
    }

    /// Adds the synchronous motion of one source to the interface state `u`.
    fn add_source(&self, index: usize, phasor: Complex64, u: &mut [f64]) {
        add_rotated(&self.interface_amplitudes[index * self.interface_len()..], phasor, u);
    }

    /// Evaluates the loads and the contacts of all connections at the interface state `u`; into `tangent`, stiffness (N/m) and
    /// damping (N·s/m) of the connections over their directions minus those that the linear motion contains, connection after
    /// connection.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap or a journal touches its bearing.
    #[inline(always)]
    pub fn load(
        &self,
        elapsed: f64,
        u: &[f64],
        loads: &mut [f64],
        contacts: &mut [Contact],
        mut tangent: Option<Tangent<'_>>,
    ) -> Result<(), Halt> {
        let (scalars, rates) = self.split(u);
        let mut from = 0;
        for (interface, contact) in self.interfaces.iter().zip(contacts) {
            let to = from + interface.scalars();
            let rates = rates.get(from..to).unwrap_or_default();
            let instant = self.motion.instant(interface.mesh(), interface.turning(), elapsed);
            let tangent = tangent.as_mut().map(|all| all.split_off(interface.direction_count().pow(2)));
            *contact = interface
                .load(&instant, &scalars[from..to], rates, &mut loads[from..to], tangent)
                .map_err(|reason| Halt::out_of_range(interface.mesh(), reason))?;
            from = to;
        }
        if let (Some(changing), Some(shaft)) = (&self.changing, self.motion.reference_shaft(elapsed)) {
            changing.load(elapsed, &shaft, &u[u.len() - self.changing_counts.scalars..], &mut loads[from..]);
            from += self.changing_counts.loads;
        }
        for (load, prescribed) in loads[from..].iter_mut().zip(&self.prescribed) {
            *load = prescribed.value(self.motion.sources(), elapsed);
        }
        Ok(())
    }

    /// The directions of each connection among those of all connections.
    pub fn direction_ranges(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let mut from = 0;
        self.interfaces.iter().map(move |interface| {
            let own = from..from + interface.direction_count();
            from = own.end;
            own
        })
    }

    /// Number of entries of the tangent of all connections: Σ d².
    pub fn tangent_len(&self) -> usize {
        self.interfaces.iter().map(|interface| interface.direction_count().pow(2)).sum()
    }

    /// Lower bounds on the time to the next contact change of each connection.
    pub fn guaranteed_intervals<'a>(
        &'a self,
        contacts: &'a [Contact],
    ) -> impl Iterator<Item = GuaranteedInterval> + 'a {
        self.interfaces.iter().zip(contacts).map(|(interface, contact)| {
            interface.guaranteed_interval(self.motion.contact_mode(interface.mesh()), contact)
        })
    }

    /// Margins of both flanks of a connection to the next contact change, m; infinite if it is no mesh.
    pub fn margins(&self, connection: usize, contact: &Contact) -> [f64; 2] {
        let interface = &self.interfaces[connection];
        interface.margins(self.motion.contact_mode(interface.mesh()), contact)
    }

    /// Iterates over the interfaces with their scalars and rates in `u`; rates are empty if loads do not depend on them.
    fn each<'a>(&'a self, u: &'a [f64]) -> impl Iterator<Item = (&'a Interface, &'a [f64], &'a [f64])> {
        let (scalars, rates) = self.split(u);
        let mut from = 0;
        self.interfaces.iter().map(move |interface| {
            let to = from + interface.scalars();
            let own = (interface, &scalars[from..to], rates.get(from..to).unwrap_or_default());
            from = to;
            own
        })
    }

    /// The scalars of the connections in an interface state, and their rates; no rates if loads do not depend on them.
    #[inline(always)]
    fn split<'a>(&self, u: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        u[..u.len() - self.changing_counts.scalars].split_at(self.scalars)
    }

    /// Writes the contact modes at the interface state `u` as integer codes. The flank contact of connections
    /// that are `unchanged` is not evaluated.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn contact_modes(
        &self,
        elapsed: f64,
        u: &[f64],
        unchanged: &[bool],
        contact_modes: &mut Vec<i64>,
    ) -> Result<(), Halt> {
        contact_modes.clear();
        for (connection, (interface, scalars, rates)) in self.each(u).enumerate() {
            let unchanged = unchanged.get(connection) == Some(&true);
            let instant = self.motion.instant(interface.mesh(), interface.turning(), elapsed);
            let contact_mode = interface
                .contact_mode(&instant, scalars, rates, unchanged)
                .map_err(|overlap| Halt::out_of_range(interface.mesh(), overlap.into()))?;
            contact_modes.extend(contact_mode.iter().flat_map(ContactMode::code));
        }
        contact_modes.extend(self.motion.piece_at(elapsed));
        Ok(())
    }

    /// Writes the positions of the ends of the paths of contact, in tooth pairs, for meshes with sharp engagement, each with
    /// the first or last pair in contact in the current contact mode.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn path_ends(&self, elapsed: f64, u: &[f64], ends: &mut Vec<(f64, i64)>) -> Result<(), Halt> {
        ends.clear();
        for (interface, scalars, _) in self.each(u) {
            let instant = self.motion.instant(interface.mesh(), interface.turning(), elapsed);
            interface
                .ends(&instant, scalars, ends)
                .map_err(|overlap| Halt::out_of_range(interface.mesh(), overlap.into()))?;
        }
        Ok(())
    }

    /// Displacements and velocities of the reference plus the synchronous motion.
    pub fn reference_motion(&self, elapsed: f64) -> (DVector<f64>, DVector<f64>) {
        let (mut q, mut v) = (self.reference.clone(), DVector::zeros(self.reference.len()));
        for (index, source) in self.motion.sources().iter().enumerate() {
            let phasor = source.phasor(elapsed, None);
            for (i, amplitude) in self.amplitudes.column(index).iter().enumerate() {
                let rotated = amplitude * phasor;
                q[i] += rotated.re;
                v[i] -= source.spin * rotated.im;
            }
        }
        (q, v)
    }

    /// Complex synchronous amplitude of one displacement, or of its rate, for one source.
    pub fn amplitude(&self, source: usize, index: usize, rate: bool) -> Complex64 {
        let amplitude = self.amplitudes[(index, source)];
        if rate { amplitude * Complex64::new(0.0, self.motion.sources()[source].spin) } else { amplitude }
    }

    /// Number of rotating sources.
    pub fn source_count(&self) -> usize {
        self.motion.sources().len()
    }

    /// √(Σ (aᴴKa + Ω²aᴴMa)/2) over the sources: the root mean square over their angles.
    fn size_of_synchronous(&self, includes_meshes: bool) -> f64 {
        let model = self.motion.model();
        let elastic_form = |vector: &[f64]| match includes_meshes {
            true => model.elastic_form(vector, |mesh| self.motion.sigma_of(mesh)),
            false => model.elastic_form_without_meshes(vector),
        };
        let mut sum = 0.0;
        for (index, source) in self.motion.sources().iter().enumerate() {
            for part in [|value: &Complex<f64>| value.re, |value: &Complex<f64>| value.im] {
                let vector: Vec<f64> = self.amplitudes.column(index).iter().map(part).collect();
                sum += (elastic_form(&vector) + source.spin * source.spin * model.kinetic_form(&vector)) / 2.0;
            }
        }
        sum.max(0.0).sqrt()
    }
}

/// The interfaces of all connections.
fn interfaces(
    motion: &EquationOfMotion,
    reference: &DVector<f64>,
    contained: bool,
) -> Result<Vec<Interface>, (usize, Overlap)> {
    let mut interfaces = Vec::new();
    for (index, connection) in motion.connections().enumerate() {
        let options = InterfaceOptions {
            geometry: motion.geometry(),
            reference: reference.as_slice(),
            contained,
            speed: motion.linear_speed(),
            bearing_speed: motion.largest_speed(),
            highest_frequency: motion.highest_mesh_frequency(),
            mobility: if index < motion.model().meshes.len() { motion.mobility(index) } else { 0.0 },
        };
        // Only meshes have base circles, and they come first.
        interfaces.push(Interface::new(connection, options).map_err(|overlap| (index, overlap))?);
    }
    Ok(interfaces)
}
