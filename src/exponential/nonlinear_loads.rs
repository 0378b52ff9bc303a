//! What acts on the linear motion: the meshes through their interfaces, and what is prescribed.
//!
//! EquationOfMotion is counted from a reference, the static equilibrium where there is one, and from the synchronous motion that
//! bow and unbalance make of the linear motion alone, which is exact. At a critical speed without damping there is no
//! such motion; bow and unbalance of that shaft then act as loads, like the meshes.

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::cache::{InterfaceMaps, LinearizedContact};
use crate::connection::{GuaranteedInterval, Interface, InterfaceOptions};
use crate::integrate::Halt;
use crate::mesh::{Contact, ContactMode, Overlap};
use crate::modal::ModalStateSpace;
use crate::motion::EquationOfMotion;

/// Digits that a synchronous motion near resonance may lose against what is left: five.
const RESONANT: f64 = 1e-5;
/// A load at the reference below this part of what acts there is round-off.
const BALANCED: f64 = 1e-11;

/// A load that does not depend on the motion.
#[derive(Clone, Copy, Debug)]
enum Prescribed {
    /// Always one.
    Constant,
    /// cos ϑ of a source.
    Cosine(usize),
    /// sin ϑ of a source.
    Sine(usize),
}

/// A shaft that excites.
#[derive(Clone, Copy, Debug)]
struct RotatingSource {
    shaft: usize,
    spin: f64,
    at_origin: Complex64,
}

impl RotatingSource {
    /// e^{iϑ}.
    fn turn(&self, elapsed: f64) -> Complex64 {
        self.at_origin * Complex64::from_polar(1.0, self.spin * elapsed)
    }
}

/// What acts on the linear motion.
#[derive(Clone, Debug)]
pub struct NonlinearLoads<'m> {
    /// The motion of which it is the non-linear part.
    pub motion: EquationOfMotion<'m>,
    /// The displacements that motion is counted from.
    pub reference: DVector<f64>,
    interfaces: Vec<Interface>,
    /// Scalars of all meshes.
    scalars: usize,
    /// Whether the rates of the scalars follow them.
    rates: bool,
    sources: Vec<RotatingSource>,
    /// Synchronous amplitudes of all displacements, a column for each source.
    amplitudes: DMatrix<Complex<f64>>,
    /// The same of the scalars and rates, source after source.
    seen: Vec<Complex64>,
    prescribed: Vec<Prescribed>,
    /// Energy norm of the synchronous motion.
    pub synchronous_size: f64,
}

impl<'m> NonlinearLoads<'m> {
    /// The field of a motion counted from `reference`, with the rows and columns through which it acts on `linear`;
    /// `synchronous` holds amplitudes of the displacements for shaft after shaft as the source, which are not looked at
    /// for a shaft that [`is_resonant`].
    ///
    /// # Errors
    /// [`Overlap`] of the base circles of the mesh named, at the reference.
    pub fn new(
        motion: EquationOfMotion<'m>,
        linear: &ModalStateSpace,
        reference: DVector<f64>,
        synchronous: &DMatrix<Complex<f64>>,
    ) -> Result<(Self, InterfaceMaps), (usize, Overlap)> {
        let model = motion.model();
        let interfaces = interfaces(&motion, &reference, linear.meshed)?;
        let entries: Vec<Vec<(usize, f64)>> = interfaces.iter().flat_map(Interface::rows).collect();
        let rates = interfaces.iter().any(Interface::has_rates);
        let kinds: &[bool] = if rates { &[false, true] } else { &[false] };
        let rows: Vec<Vec<f64>> =
            kinds.iter().flat_map(|rate| entries.iter().map(|entry| linear.row(entry, *rate))).collect();
        let mut columns: Vec<Vec<f64>> = entries.iter().map(|entry| linear.column(entry)).collect();
        let meshes = columns.len();
        let tangents = tangents(&interfaces, linear.meshed);

        let mut prescribed = Vec::new();
        let constant = constant_load(&motion, &interfaces, &entries, &reference);
        if !constant.is_empty() {
            prescribed.push(Prescribed::Constant);
            columns.push(linear.column(&constant));
        }
        let sources: Vec<RotatingSource> = motion
            .sources()
            .map(|shaft| RotatingSource { shaft, spin: motion.spin(shaft), at_origin: motion.turn(shaft, 0.0) })
            .collect();
        let mut amplitudes = DMatrix::zeros(model.len(), sources.len());
        for (index, source) in sources.iter().enumerate() {
            if is_resonant(linear, source.spin) {
                prescribed.extend([Prescribed::Cosine(index), Prescribed::Sine(index)]);
                let [cosine, sine] = motion.turning_forces(source.shaft);
                columns.extend([linear.column(&cosine), linear.column(&sine)]);
            } else {
                amplitudes.set_column(index, &synchronous.column(source.shaft));
            }
        }
        let mut seen = Vec::new();
        for (index, source) in sources.iter().enumerate() {
            for rate in kinds {
                seen.extend(entries.iter().map(|entry| {
                    let value: Complex64 = entry.iter().map(|(i, factor)| amplitudes[(*i, index)] * *factor).sum();
                    if *rate { value * Complex64::new(0.0, source.spin) } else { value }
                }));
            }
        }
        let mut field = Self {
            scalars: entries.len(),
            motion,
            reference,
            interfaces,
            rates,
            sources,
            amplitudes,
            seen,
            prescribed,
            synchronous_size: 0.0,
        };
        field.synchronous_size = field.size_of_synchronous(linear.meshed);
        let (parts, synchronous) = (linear.parts.clone(), field.seen.clone());
        Ok((field, InterfaceMaps { rows, columns, meshes, parts, tangents, synchronous }))
    }

    /// Number of scalars and rates that it sees.
    pub fn seen(&self) -> usize {
        self.scalars * if self.rates { 2 } else { 1 }
    }

    /// Number of loads.
    pub fn loads(&self) -> usize {
        self.scalars + self.prescribed.len()
    }

    /// Number of meshes.
    pub fn meshes(&self) -> usize {
        self.interfaces.len()
    }

    /// Number of loads of the meshes.
    pub fn mesh_loads(&self) -> usize {
        self.scalars
    }

    /// Spins of what turns, rad/s.
    pub fn spins(&self) -> Vec<f64> {
        self.sources.iter().map(|source| source.spin).collect()
    }

    /// Whether a shaft's bow and unbalance act as loads.
    pub fn is_resonant(&self) -> bool {
        self.prescribed.iter().any(|load| !matches!(load, Prescribed::Constant))
    }

    /// e^{iϑ} of every source.
    pub fn phasors(&self, elapsed: f64, phasors: &mut [Complex64]) {
        for (turn, source) in phasors.iter_mut().zip(&self.sources) {
            *turn = source.turn(elapsed);
        }
    }

    /// Adds what the synchronous motion contributes to the scalars and rates `u`.
    pub fn add_synchronous(&self, phasors: &[Complex64], u: &mut [f64]) {
        for (index, turn) in phasors.iter().enumerate() {
            self.add_source(index, *turn, u);
        }
    }

    /// Whether the loads of every mesh are a straight line over its one scalar.
    pub fn is_affine(&self) -> bool {
        self.interfaces.iter().all(Interface::is_affine)
    }

    /// The same at an instant whose turns are not at hand.
    pub fn add_synchronous_at(&self, elapsed: f64, u: &mut [f64]) {
        for (index, source) in self.sources.iter().enumerate() {
            self.add_source(index, source.turn(elapsed), u);
        }
    }

    /// Adds what one source contributes to the scalars and rates `u`.
    fn add_source(&self, index: usize, turn: Complex64, u: &mut [f64]) {
        add_turned(&self.seen[index * self.seen()..], turn, u);
    }

    /// The loads at scalars and rates `u`, of which each mesh takes its own, and the contacts of the meshes.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    #[inline(always)]
    pub fn load(
        &self,
        elapsed: f64,
        phasors: &[Complex64],
        u: &[f64],
        loads: &mut [f64],
        contacts: &mut [Contact],
    ) -> Result<(), Halt> {
        let (scalars, rates) = u.split_at(self.scalars);
        let mut from = 0;
        for (interface, contact) in self.interfaces.iter().zip(contacts) {
            let to = from + interface.scalars();
            let rates = rates.get(from..to).unwrap_or_default();
            let instant = self.motion.instant(interface.mesh(), elapsed);
            *contact = interface
                .load(&instant, &scalars[from..to], rates, &mut loads[from..to])
                .map_err(|overlap| halt(interface, overlap))?;
            from = to;
        }
        for (load, prescribed) in loads[from..].iter_mut().zip(&self.prescribed) {
            *load = match prescribed {
                Prescribed::Constant => 1.0,
                Prescribed::Cosine(source) => phasors[*source].re,
                Prescribed::Sine(source) => phasors[*source].im,
            };
        }
        Ok(())
    }

    /// Stiffness and damping of a contact of a mesh that the linear motion does not contain, N/m and N·s/m.
    pub fn residual_tangent(&self, mesh: usize, contact: &Contact) -> [f64; 2] {
        let interface = &self.interfaces[mesh];
        interface.residual_tangent(self.motion.contact_mode(interface.mesh()), contact)
    }

    /// How long the flanks of the meshes stay as they are in their contacts.
    pub fn holds<'a>(&'a self, contacts: &'a [Contact]) -> impl Iterator<Item = GuaranteedInterval> + 'a {
        self.interfaces.iter().zip(contacts).map(|(interface, contact)| {
            interface.guaranteed_interval(self.motion.contact_mode(interface.mesh()), contact)
        })
    }

    /// How far each flank of a mesh is from a change of law in a contact, m.
    pub fn margins(&self, mesh: usize, contact: &Contact) -> [f64; 2] {
        let interface = &self.interfaces[mesh];
        interface.margins(self.motion.contact_mode(interface.mesh()), contact)
    }

    /// Every interface with its scalars and rates (empty where they do not matter) of `u`.
    fn each<'a>(&'a self, u: &'a [f64]) -> impl Iterator<Item = (&'a Interface, &'a [f64], &'a [f64])> {
        let (scalars, rates) = u.split_at(self.scalars);
        let mut from = 0;
        self.interfaces.iter().map(move |interface| {
            let to = from + interface.scalars();
            let seen = (interface, &scalars[from..to], rates.get(from..to).unwrap_or_default());
            from = to;
            seen
        })
    }

    /// Writes the laws that hold at scalars and rates `u`; the flanks of meshes that are `unchanged` stay as they are.
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
        for (mesh, (interface, scalars, rates)) in self.each(u).enumerate() {
            let unchanged = unchanged.get(mesh) == Some(&true);
            let instant = self.motion.instant(interface.mesh(), elapsed);
            let contact_mode = interface
                .contact_mode(&instant, scalars, rates, unchanged)
                .map_err(|overlap| halt(interface, overlap))?;
            contact_modes.extend(contact_mode.iter().flat_map(ContactMode::code));
        }
        Ok(())
    }

    /// Where the ends of the paths of contact stand among the pairs of teeth that come and go at once, each with the pair
    /// that is the first or the last between them under the law that holds, into `ends`.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn ends(&self, elapsed: f64, u: &[f64], ends: &mut Vec<(f64, i64)>) -> Result<(), Halt> {
        ends.clear();
        for (interface, scalars, _) in self.each(u) {
            let instant = self.motion.instant(interface.mesh(), elapsed);
            interface.ends(&instant, scalars, ends).map_err(|overlap| halt(interface, overlap))?;
        }
        Ok(())
    }

    /// Displacements and velocities of the reference and the synchronous motion.
    pub fn carried(&self, elapsed: f64) -> (DVector<f64>, DVector<f64>) {
        let (mut q, mut v) = (self.reference.clone(), DVector::zeros(self.reference.len()));
        let mut phasors = vec![Complex64::ZERO; self.sources.len()];
        self.phasors(elapsed, &mut phasors);
        for (index, (source, turn)) in self.sources.iter().zip(&phasors).enumerate() {
            for (i, amplitude) in self.amplitudes.column(index).iter().enumerate() {
                let turned = amplitude * turn;
                q[i] += turned.re;
                v[i] -= source.spin * turned.im;
            }
        }
        (q, v)
    }

    /// Synchronous amplitude that a source makes of one displacement, or of its rate.
    pub fn amplitude(&self, source: usize, index: usize, rate: bool) -> Complex64 {
        let amplitude = self.amplitudes[(index, source)];
        if rate { amplitude * Complex64::new(0.0, self.sources[source].spin) } else { amplitude }
    }

    /// Number of sources.
    pub fn sources(&self) -> usize {
        self.sources.len()
    }

    /// √(Σ (aᴴKa + Ω²aᴴMa)/2) over the sources: the root of the mean square over their angles.
    fn size_of_synchronous(&self, meshed: bool) -> f64 {
        let model = self.motion.model();
        let elastic_form = |vector: &[f64]| match meshed {
            true => model.elastic_form(vector, |mesh| self.motion.sigma_of(mesh)),
            false => model.unmeshed_elastic_form(vector),
        };
        let mut sum = 0.0;
        for (index, source) in self.sources.iter().enumerate() {
            for part in [|value: &Complex<f64>| value.re, |value: &Complex<f64>| value.im] {
                let vector: Vec<f64> = self.amplitudes.column(index).iter().map(part).collect();
                sum += (elastic_form(&vector) + source.spin * source.spin * model.kinetic_form(&vector)) / 2.0;
            }
        }
        sum.max(0.0).sqrt()
    }
}

/// The interfaces of all connections that the linear motion does not replace.
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
            highest_swing: motion.fastest_swing(),
            mobility: if index < motion.model().meshes.len() { motion.mobility(index) } else { 0.0 },
        };
        // Only meshes have base circles, and they come first.
        interfaces.extend(Interface::new(connection, options).map_err(|overlap| (index, overlap))?);
    }
    Ok(interfaces)
}

/// The end of a run where the base circles of a mesh overlap; no other connection has any.
fn halt(interface: &Interface, overlap: Overlap) -> Halt {
    Halt::Overlap { mesh: interface.mesh().unwrap_or_default(), overlap }
}

/// Adds the real parts of amplitudes that have turned by `turn` to `values`.
#[inline]
pub(super) fn add_turned(amplitudes: &[Complex64], turn: Complex64, values: &mut [f64]) {
    for (value, amplitude) in values.iter_mut().zip(amplitudes) {
        *value += amplitude.re * turn.re - amplitude.im * turn.im;
    }
}

/// Whether a shaft of this spin runs at a critical speed that nothing damps: it has no synchronous motion.
pub fn is_resonant(linear: &ModalStateSpace, spin: f64) -> bool {
    linear.nearest(spin) < RESONANT * spin.abs()
}

/// The laws of the meshes at rest.
fn tangents(interfaces: &[Interface], meshed: bool) -> Vec<LinearizedContact> {
    let mut from = 0;
    let tangent = |interface: &Interface| {
        let (gradient, stiffness) = interface.tangent();
        let scalars = from..from + gradient.len();
        from = scalars.end;
        let root = if meshed { 0.0 } else { stiffness.sqrt() };
        LinearizedContact { scalars, gradient: gradient.to_vec(), root }
    };
    interfaces.iter().map(tangent).collect()
}

/// What acts at the reference and is not held there, as entries (index, value).
fn constant_load(
    motion: &EquationOfMotion,
    interfaces: &[Interface],
    entries: &[Vec<(usize, f64)>],
    reference: &DVector<f64>,
) -> Vec<(usize, f64)> {
    let model = motion.model();
    let load = &model.constant_load;
    let mut residual = load.clone();
    let mut scale = load.map(f64::abs);
    let mut add = |index: usize, value: f64| {
        residual[index] += value;
        scale[index] += value.abs();
    };
    for (row, value) in model.static_force(reference).iter().enumerate() {
        add(row, -value);
    }
    let reference_force = interfaces.iter().flat_map(Interface::reference_force);
    for (entry, reference_force) in entries.iter().zip(reference_force) {
        for (index, factor) in entry {
            add(*index, factor * reference_force);
        }
    }
    // Coordinates are of two kinds, forces and moments; each is measured against all of its kind.
    let largest = |lateral: bool| {
        let dofs = model.numbering.dofs().iter().filter(|dof| dof.kind.is_lateral() == lateral);
        dofs.map(|dof| scale[dof.index]).fold(0.0, f64::max)
    };
    let sizes = [largest(false), largest(true)];
    let acts = model
        .numbering
        .dofs()
        .iter()
        .any(|dof| residual[dof.index].abs() > BALANCED * sizes[usize::from(dof.kind.is_lateral())]);
    if acts { residual.iter().copied().enumerate().filter(|(_, value)| *value != 0.0).collect() } else { Vec::new() }
}
