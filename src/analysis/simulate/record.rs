//! Recording of selected quantities at the output times.

use super::audit::Audit;
use super::events::{Event, EventRecorder};
use super::{RecordPlan, RecorderState};
use crate::connection::{MESH_CHANNELS, Row, along_row, mesh_values};
use crate::exponential::{INSTANT_BATCH, MAX_WAITING};
use crate::integrate::{Deferred, FirstOrderSystem, Halt, Trajectory};
use crate::model::{Cut, Moving, PlaceRows, SECTION_FORCES, Turning};
use crate::motion::{CONSTANT_LOAD_SUMS, Energies, EquationOfMotion, SourceTerms};

/// The recorded motion. Each vector holds one row of values after another, one row for each time.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Times, s.
    pub time: Vec<f64>,
    /// (v, w) of every point, m.
    pub displacement: Vec<f64>,
    /// θ of every point, rad; zero in a scene without twist.
    pub twist: Vec<f64>,
    /// (v̇, ẇ) of every point, m/s; empty where not asked for, like the two following.
    pub velocity: Vec<f64>,
    /// θ̇ of every point, rad/s.
    pub twist_rate: Vec<f64>,
    /// (v̈, ẅ) of every point, m/s².
    pub acceleration: Vec<f64>,
    /// Axial motion; empty in a scene without it.
    pub axial: AxialRecord,
    /// Force of the shaft on the bearings of every bearing node over (y, z), N.
    pub bearing_force: Vec<f64>,
    /// Displacement (y, z) of the shaft at every recorded bearing node relative to what the bearing stands on, m.
    pub bearing_displacement: Vec<f64>,
    /// (N, Q_y, Q_z) of every cut, N; empty where not asked for, like the following.
    pub section_force: Vec<f64>,
    /// (M_y, M_z, T) of every cut, N m.
    pub section_moment: Vec<f64>,
    /// Quantities of [`ROLLING_CHANNELS`](crate::connection::ROLLING_CHANNELS) of every bearing node with rolling elements.
    pub rolling: Vec<f64>,
    /// One vector for each quantity of [`MESH_CHANNELS`].
    pub mesh: [Vec<f64>; MESH_CHANNELS.len()],
    /// Energies, J, and work of every source since the start, J; empty where not asked for.
    pub energy: Vec<(Energies, SourceTerms)>,
    /// Contact events and warnings of the meshes.
    pub events: Vec<Event>,
}

/// The recorded axial motion, in the form of [`Record`].
#[derive(Clone, Debug, Default)]
pub struct AxialRecord {
    /// u of every point, m.
    pub displacement: Vec<f64>,
    /// u̇ of every point, m/s; empty where not asked for.
    pub velocity: Vec<f64>,
    /// ü of every point, m/s²; empty where not asked for.
    pub acceleration: Vec<f64>,
    /// Force of the shaft on the bearings of every bearing node, N.
    pub bearing_force: Vec<f64>,
}

/// What is read at [`INSTANT_BATCH`] instants, one vector after the other.
struct Scratch {
    /// Displacements and velocities; behind the displacements, potentials where energies are recorded.
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    /// Accelerations; empty where none are recorded.
    acceleration: Vec<f64>,
    /// Displacements without the bow at one instant; empty where no energies are recorded.
    unbent: Vec<f64>,
    /// Rotation of every shaft at each recorded output without section forces, oldest first; empty where none are recorded.
    turnings: Vec<Turning>,
}

/// Records a run.
pub(super) struct Recorder<'a, 'm> {
    motion: EquationOfMotion<'m>,
    plan: &'a RecordPlan,
    times: &'a [f64],
    /// Time at which the elapsed time is zero, s.
    origin: f64,
    /// Indices of the coordinates that recording needs, and of those whose acceleration it needs.
    coordinates: Vec<usize>,
    accelerated: Vec<usize>,
    /// Shaft of each point, and of each bearing that is not on a pin, if its lateral motion is in a frame that turns.
    turning_points: Vec<Option<usize>>,
    turning_bearings: Vec<Option<usize>>,
    /// Displacements of the shafts at the bearing nodes relative to what the bearings stand on.
    bearing_rows: Vec<Option<[Row; 2]>>,
    /// Number of values behind the coordinates of a vector: potentials of constant loads, where energies are recorded.
    extra: usize,
    scratch: Scratch,
    /// Number of outputs whose energies of the shafts were deferred and are known.
    shaft_energies: usize,
    audit: Option<Audit>,
    events: EventRecorder,
    every_step: bool,
    record: Record,
}

impl<'a, 'm> Recorder<'a, 'm> {
    /// Creates a recorder of a run with the relative tolerance `tolerance` that starts at the elapsed time `start`, s.
    pub fn new(
        motion: EquationOfMotion<'m>,
        plan: &'a RecordPlan,
        times: &'a [f64],
        origin: f64,
        start: f64,
        tolerance: f64,
    ) -> Self {
        let model = motion.model();
        let count = times.len();
        let room = |channels: usize| Vec::with_capacity(count * channels);
        let record = Record {
            time: room(1),
            displacement: room(2 * plan.points.len()),
            twist: room(plan.points.len()),
            velocity: room(if plan.velocity { 2 * plan.points.len() } else { 0 }),
            twist_rate: room(if plan.velocity { plan.points.len() } else { 0 }),
            acceleration: room(if plan.acceleration { 2 * plan.points.len() } else { 0 }),
            axial: AxialRecord::default(),
            bearing_force: room(2 * plan.bearings.len()),
            bearing_displacement: room(2 * plan.bearings.len()),
            section_force: room(SECTION_FORCES / 2 * plan.cuts.len()),
            section_moment: room(SECTION_FORCES / 2 * plan.cuts.len()),
            rolling: Vec::new(),
            mesh: std::array::from_fn(|_| room(plan.meshes.len())),
            energy: Vec::with_capacity(if plan.energy { count } else { 0 }),
            events: Vec::new(),
        };
        let extra = if plan.energy { CONSTANT_LOAD_SUMS } else { 0 };
        // A motion without rows for section forces gives the coordinates from which they follow.
        let with_cuts = |mut coordinates: Vec<usize>| {
            coordinates.extend(plan.cuts.iter().flat_map(Cut::coordinates));
            coordinates.sort_unstable();
            coordinates.dedup();
            coordinates
        };
        let has_accelerations = plan.acceleration || !plan.cuts.is_empty();
        let turnings = if plan.cuts.is_empty() { 0 } else { MAX_WAITING * model.scene.shafts.len() };
        let turns = |shaft: &usize| model.scene.frame_of(*shaft).is_some();
        let on_axis = |shaft: &usize| model.scene.carrier_of(*shaft).is_none();
        Self {
            coordinates: with_cuts(plan.coordinates(model)),
            turning_points: plan.points.iter().map(|point| model.scene.shaft(&point.part).filter(turns)).collect(),
            // What acts on a pin stays in the frame of its carrier.
            turning_bearings: plan.bearings.iter().map(|node| Some(node.shaft).filter(turns).filter(on_axis)).collect(),
            bearing_rows: plan.bearings.iter().map(|node| model.bearing_displacement(*node)).collect(),
            scratch: Scratch {
                displacement: vec![0.0; INSTANT_BATCH * (model.len() + extra)],
                velocity: vec![0.0; INSTANT_BATCH * (model.len() + extra)],
                acceleration: vec![0.0; if has_accelerations { INSTANT_BATCH * model.len() } else { 0 }],
                turnings: Vec::with_capacity(turnings),
                unbent: vec![0.0; if plan.energy { model.len() } else { 0 }],
            },
            extra,
            shaft_energies: 0,
            accelerated: with_cuts(plan.accelerated(model)),
            audit: plan.energy.then(|| Audit::new(start, tolerance, model)),
            events: EventRecorder::new(&motion, origin, start),
            every_step: plan.energy || EventRecorder::watches(&motion),
            motion,
            plan,
            times,
            origin,
            record,
        }
    }

    /// Elapsed time of the next output, s; none after the last one.
    pub fn next(&self) -> Option<f64> {
        self.times.get(self.record.time.len()).map(|time| time - self.origin)
    }

    /// Records all outputs within a step, up to `end`.
    pub fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        if let Some(audit) = &mut self.audit {
            audit.integrate(&self.motion, motion, end)?;
        }
        loop {
            let mut instants = [0.0; INSTANT_BATCH];
            let left = &self.times[self.record.time.len()..];
            let due = left.iter().map(|time| time - self.origin).take_while(|elapsed| *elapsed <= end);
            let count = instants.iter_mut().zip(due).map(|(instant, elapsed)| *instant = elapsed).count();
            if count == 0 {
                break;
            }
            let instants = &instants[..count];
            let len = self.motion.model().len();
            let room = count * (len + self.extra);
            let (q, v) = (&mut self.scratch.displacement[..room], &mut self.scratch.velocity[..room]);
            motion.states(instants, &self.coordinates, q, v);
            let has_cuts = !self.plan.cuts.is_empty();
            let is_combined = has_cuts && !self.has_turning_frame() && motion.combines(instants)?;
            if self.plan.acceleration || has_cuts && !is_combined {
                motion.accelerations(instants, &self.accelerated, &mut self.scratch.acceleration[..count * len])?;
            }
            for (index, elapsed) in instants.iter().enumerate() {
                self.sample(*elapsed, index, motion.defers_energies())?;
                self.record.time.push(self.times[self.record.time.len()]);
                if has_cuts {
                    self.add_turnings(*elapsed, index);
                }
                if has_cuts && !is_combined {
                    self.turn_to_ground(*elapsed, index);
                    self.add_section_forces(|recorder, cut, turning| cut.forces(&recorder.moving(index), turning));
                }
            }
            motion.deferred(&mut |quantity| self.add_deferred(quantity));
        }
        self.events.step(&self.motion, motion);
        Ok(())
    }

    /// Whether the recorder reads every step.
    pub fn sees_every_step(&self) -> bool {
        self.every_step
    }

    /// Adopts the contact modes of the following steps.
    pub fn switched(&mut self, elapsed: f64, read: &mut dyn FnMut(&mut [f64], &mut [f64]), contact_modes: &[i64]) {
        match &mut self.audit {
            Some(audit) => audit.switch(&mut self.motion, elapsed, read, contact_modes),
            None => self.motion.set_contact_modes(contact_modes),
        }
        let len = self.motion.model().len();
        let (q, v) = (&mut self.scratch.displacement[..len], &mut self.scratch.velocity[..len]);
        self.events.switched(&self.motion, elapsed, read, q, v, contact_modes);
    }

    /// Adds a quantity to the oldest output without it.
    pub fn add_deferred(&mut self, quantity: Deferred<'_>) {
        match quantity {
            Deferred::ShaftEnergies(energies) => self.add_shaft_energies(energies),
            Deferred::Combinations(values) => {
                let mut values = values.chunks_exact((values.len() / self.plan.cuts.len().max(1)).max(1));
                self.add_section_forces(|_, cut, turning| cut.combined(values.next().unwrap_or_default(), turning));
            }
        }
    }

    /// Adds kinetic energy and elastic energy of the shafts, J.
    fn add_shaft_energies(&mut self, [kinetic, shafts]: [f64; 2]) {
        if let Some((energies, _)) = self.record.energy.get_mut(self.shaft_energies) {
            (energies.kinetic, energies.shafts) = (kinetic, shafts);
        }
        self.shaft_energies += 1;
    }

    /// Records one output from the displacements and velocities at `elapsed`, which have this index among those that were
    /// read. [`Self::add_shaft_energies`] completes its energies if they are `deferred`.
    fn sample(&mut self, elapsed: f64, index: usize, deferred: bool) -> Result<(), Halt> {
        let model = self.motion.model();
        let (own, begin) = (index * model.len()..(index + 1) * model.len(), index * (model.len() + self.extra));
        let (q, potentials) = self.scratch.displacement[begin..begin + model.len() + self.extra].split_at(model.len());
        let v = &self.scratch.velocity[begin..begin + model.len()];
        // Quantities that can fail come first, so that the record holds complete outputs only.
        let mut meshes = Vec::with_capacity(self.plan.meshes.len());
        for mesh in &self.plan.meshes {
            let state = self.motion.mesh_state(*mesh, elapsed, q, v);
            meshes.push(state.map_err(|overlap| Halt::Overlap { mesh: *mesh, overlap })?);
        }
        if let Some(audit) = &self.audit {
            let deferred = deferred.then_some(potentials);
            let energies = energies(&self.motion, audit, elapsed, q, v, deferred, &mut self.scratch.unbent)?;
            self.record.energy.push(energies);
        }
        for (mesh, state) in self.plan.meshes.iter().zip(&meshes) {
            self.events.check(&self.motion, *mesh, elapsed, &state.centres);
            for (series, value) in self.record.mesh.iter_mut().zip(mesh_values(state)) {
                series.push(value);
            }
        }
        for (point, shaft) in self.plan.points.iter().zip(&self.turning_points) {
            let frame = shaft.and_then(|shaft| self.motion.frame(shaft, elapsed));
            let PlaceRows { displacement, twist, .. } = &point.rows;
            let lateral = |of: &[f64]| displacement.as_ref().map_or([0.0; 2], |rows| along_rows(rows, of));
            let twist = |of: &[f64]| twist.as_ref().map_or(0.0, |row| along_row(row, of));
            let place = lateral(q);
            self.record.displacement.extend(frame.map_or(place, |frame| frame.turned(place)));
            self.record.twist.push(twist(q));
            if self.plan.velocity {
                let rate = lateral(v);
                self.record.velocity.extend(frame.map_or(rate, |frame| frame.velocity(place, rate)));
                self.record.twist_rate.push(twist(v));
            }
            if self.plan.acceleration {
                let own = lateral(&self.scratch.acceleration[own.clone()]);
                let seen = frame.map_or(own, |frame| frame.acceleration(place, lateral(v), own));
                self.record.acceleration.extend(seen);
            }
        }
        for ((node, rows), shaft) in self.plan.bearings.iter().zip(&self.bearing_rows).zip(&self.turning_bearings) {
            let frame = shaft.and_then(|shaft| self.motion.frame(shaft, elapsed));
            let force = self.motion.bearing_force(*node, elapsed, q, v);
            let across = [force[0], force[1]];
            self.record.bearing_force.extend(frame.map_or(across, |frame| frame.turned(across)));
            if model.scene.axial {
                self.record.axial.bearing_force.push(force[2]);
            }
            let place = rows.as_ref().map_or([0.0; 2], |rows| along_rows(rows, q));
            self.record.bearing_displacement.extend(frame.map_or(place, |frame| frame.turned(place)));
            if model.rolls_at(*node) {
                self.record.rolling.extend(self.motion.rolling_contact(*node, elapsed, q));
            }
        }
        if model.scene.axial {
            let axial = |of: &[f64]| {
                let rows = self.plan.points.iter().map(|point| &point.rows.axial);
                rows.map(|row| row.as_ref().map_or(0.0, |row| along_row(row, of))).collect::<Vec<_>>()
            };
            self.record.axial.displacement.extend(axial(q));
            if self.plan.velocity {
                self.record.axial.velocity.extend(axial(v));
            }
            if self.plan.acceleration {
                let a = &self.scratch.acceleration[own];
                self.record.axial.acceleration.extend(axial(a));
            }
        }
        Ok(())
    }

    /// Adds the rotation of all shafts at `elapsed`, which has this index among the instants that were read.
    fn add_turnings(&mut self, elapsed: f64, index: usize) {
        let (model, Scratch { displacement, turnings, .. }) = (self.motion.model(), &mut self.scratch);
        let displacement = &displacement[index * (model.len() + self.extra)..][..model.len()];
        let shafts = 0..model.scene.shafts.len();
        turnings.extend(shafts.map(|shaft| self.motion.turning(shaft, elapsed, displacement)));
    }

    /// Whether a lateral motion is that in a frame that turns.
    fn has_turning_frame(&self) -> bool {
        self.motion.model().scene.has_turning_frame()
    }

    /// Turns the bending of shafts in frames that turn to the motion seen from the ground, from which section forces follow. The
    /// motion has this index among those that were read.
    fn turn_to_ground(&mut self, elapsed: f64, index: usize) {
        let model = self.motion.model();
        let (begin, own) = (index * (model.len() + self.extra), index * model.len());
        for (shaft, bent) in model.shafts.iter().enumerate() {
            let (Some(frame), Some(chain)) = (self.motion.frame(shaft, elapsed), &bent.bending) else { continue };
            for pair in chain.coordinates::<2>().step_by(2) {
                let Scratch { displacement, velocity, acceleration, .. } = &mut self.scratch;
                let [q, v] = [&mut *displacement, &mut *velocity].map(|of| &mut of[begin + pair..begin + pair + 2]);
                let a = &mut acceleration[own + pair..own + pair + 2];
                let [place, rate, change] = [&*q, &*v, &*a].map(|of| [of[0], of[1]]);
                q.copy_from_slice(&frame.turned(place));
                v.copy_from_slice(&frame.velocity(place, rate));
                a.copy_from_slice(&frame.acceleration(place, rate, change));
            }
        }
    }

    /// The motion at the instant with this index among those that were read.
    fn moving(&self, index: usize) -> Moving<'_> {
        let (len, begin) = (self.motion.model().len(), index * (self.motion.model().len() + self.extra));
        Moving {
            displacement: &self.scratch.displacement[begin..begin + len],
            velocity: &self.scratch.velocity[begin..begin + len],
            acceleration: &self.scratch.acceleration[index * len..(index + 1) * len],
        }
    }

    /// Records the section forces of the oldest output without them.
    fn add_section_forces(&mut self, mut forces: impl FnMut(&Self, &Cut, Turning) -> [f64; SECTION_FORCES]) {
        let shafts = self.motion.model().scene.shafts.len();
        // An output that could not be recorded has no rotations.
        if self.scratch.turnings.len() < shafts {
            return;
        }
        for cut in &self.plan.cuts {
            let forces = forces(self, cut, self.scratch.turnings[cut.shaft]);
            let (force, moment) = forces.split_at(SECTION_FORCES / 2);
            self.record.section_force.extend_from_slice(force);
            self.record.section_moment.extend_from_slice(moment);
        }
        self.scratch.turnings.drain(..shafts);
    }

    /// Continues from the state of the recorder at a checkpoint and the contact modes there.
    pub fn resume(&mut self, recorder_state: &RecorderState, contact_modes: &[i64]) {
        self.motion.set_contact_modes(contact_modes);
        self.events.resume(recorder_state);
        if let Some(audit) = &mut self.audit {
            audit.resume(recorder_state);
        }
    }

    /// Returns the record and the state of the recorder.
    pub fn finish(mut self) -> (Record, RecorderState) {
        let mut recorder_state = self.events.state();
        if let Some(audit) = &self.audit {
            (recorder_state.works, recorder_state.until) = audit.works();
        }
        self.record.events = self.events.list;
        (self.record, recorder_state)
    }
}

/// Energies and works at an output, from displacements and velocities. The potentials of constant loads are given if the
/// energies of the shafts are deferred; otherwise both follow from all coordinates.
fn energies(
    motion: &EquationOfMotion<'_>,
    audit: &Audit,
    elapsed: f64,
    q: &[f64],
    v: &[f64],
    potentials: Option<&[f64]>,
    unbent: &mut [f64],
) -> Result<(Energies, SourceTerms), Halt> {
    let others = motion.connection_energies(elapsed, q, v);
    let [bearings, meshes] = others.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
    let ([kinetic, shafts], works) = match potentials {
        Some(potentials) => ([0.0; 2], audit.works_at(elapsed, potentials)),
        None => (motion.shaft_energies(elapsed, q, v, unbent), audit.works_at(elapsed, &audit.loads.times(q))),
    };
    Ok((Energies { kinetic, shafts, bearings, meshes }, works))
}

/// Sums of values with the coefficients of each row.
fn along_rows(rows: &[Row; 2], values: &[f64]) -> [f64; 2] {
    rows.each_ref().map(|row| along_row(row, values))
}
