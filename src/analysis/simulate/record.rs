//! Recording: the motion at the times asked for, of the coordinates asked for.

use super::audit::Audit;
use super::events::{Event, EventRecorder};
use super::{RecordPlan, RecorderState};
use crate::integrate::{FirstOrderSystem, Halt, Trajectory};
use crate::mesh::MeshState;
use crate::motion::{Energies, EquationOfMotion};

/// What is recorded of a mesh, in this order.
pub const MESH_FIELDS: [&str; 8] = [
    "deflection",
    "force",
    "stiffness",
    "pressure_angle",
    "centre_distance",
    "centre_line_angle",
    "contact_ratio",
    "pairs_in_contact",
];

/// The recorded motion, time after time.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Times, s.
    pub time: Vec<f64>,
    /// (v, w) of every point, m.
    pub displacement: Vec<f64>,
    /// θ of every point, rad; zero in a scene without twist.
    pub twist: Vec<f64>,
    /// Force of the shaft on the bearings of every bearing node over (y, z), N.
    pub bearing_force: Vec<f64>,
    /// The fields of every mesh: field after field, each time after time.
    pub mesh: [Vec<f64>; 8],
    /// Energies, J, and works of [`SOURCES`](crate::motion::SOURCES) since the start, J; empty where not asked for.
    pub energy: Vec<(Energies, [f64; 6])>,
    /// What happened to the meshes.
    pub events: Vec<Event>,
}

/// Records while a run goes on.
pub(super) struct Recorder<'a, 'm> {
    motion: EquationOfMotion<'m>,
    plan: &'a RecordPlan,
    times: &'a [f64],
    origin: f64,
    coordinates: Vec<usize>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    audit: Option<Audit>,
    events: EventRecorder,
    every_step: bool,
    record: Record,
}

impl<'a, 'm> Recorder<'a, 'm> {
    /// A recorder of `plan` at `times` in a run from `start` on (elapsed time), which counts from `origin`.
    pub fn new(motion: EquationOfMotion<'m>, plan: &'a RecordPlan, times: &'a [f64], origin: f64, start: f64) -> Self {
        let model = motion.model();
        let count = times.len();
        let room = |channels: usize| Vec::with_capacity(count * channels);
        let record = Record {
            time: room(1),
            displacement: room(2 * plan.points.len()),
            twist: room(plan.points.len()),
            bearing_force: room(2 * plan.bearings.len()),
            mesh: std::array::from_fn(|_| room(plan.meshes.len())),
            energy: Vec::with_capacity(if plan.energy { count } else { 0 }),
            events: Vec::new(),
        };
        Self {
            coordinates: plan.coordinates(model),
            displacement: vec![0.0; model.len()],
            velocity: vec![0.0; model.len()],
            audit: plan.energy.then(|| Audit::new(start, model)),
            events: EventRecorder::new(&motion, origin, start),
            every_step: plan.energy || EventRecorder::watches(&motion),
            motion,
            plan,
            times,
            origin,
            record,
        }
    }

    /// Elapsed time of the next record.
    pub fn next(&self) -> Option<f64> {
        self.times.get(self.record.time.len()).map(|time| time - self.origin)
    }

    /// Records all that is due within a step.
    pub fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        while let Some(elapsed) = self.next().filter(|elapsed| *elapsed <= end) {
            motion.states(&[elapsed], &self.coordinates, &mut self.displacement, &mut self.velocity);
            let works = match &mut self.audit {
                Some(audit) => audit.count(&mut self.motion, motion, elapsed)?,
                None => [0.0; 6],
            };
            self.sample(elapsed, works)?;
            self.record.time.push(self.times[self.record.time.len()]);
        }
        if let Some(audit) = &mut self.audit {
            audit.count(&mut self.motion, motion, end)?;
        }
        self.events.step(&self.motion, motion);
        Ok(())
    }

    /// Whether every step must be seen.
    pub fn sees_every_step(&self) -> bool {
        self.every_step
    }

    /// Takes over the laws of the steps to come.
    pub fn switched(&mut self, elapsed: f64, read: &mut dyn FnMut(&mut [f64], &mut [f64]), contact_modes: &[i64]) {
        match &mut self.audit {
            Some(audit) => audit.switch(&mut self.motion, elapsed, read, contact_modes),
            None => self.motion.set_contact_modes(contact_modes),
        }
        let room = (&mut self.displacement[..], &mut self.velocity[..]);
        self.events.switched(&self.motion, elapsed, read, room, contact_modes);
    }

    fn sample(&mut self, elapsed: f64, works: [f64; 6]) -> Result<(), Halt> {
        let model = self.motion.model();
        let (q, v) = (&self.displacement, &self.velocity);
        // What may fail comes first, so that a record never holds a part of an instant.
        let mut meshes = Vec::with_capacity(self.plan.meshes.len());
        for mesh in &self.plan.meshes {
            let state = self.motion.mesh_state(*mesh, elapsed, q, v);
            meshes.push(state.map_err(|overlap| Halt::Overlap { mesh: *mesh, overlap })?);
        }
        if self.plan.energy {
            let energies = self.motion.energies(elapsed, q, v);
            let energies = energies.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
            self.record.energy.push((energies, works));
        }
        for (mesh, state) in self.plan.meshes.iter().zip(&meshes) {
            self.events.see(&self.motion, *mesh, elapsed, &state.centres);
            for (series, value) in self.record.mesh.iter_mut().zip(fields(state)) {
                series.push(value);
            }
        }
        for point in &self.plan.points {
            let translation = model.numbering.translation(point.node);
            self.record.displacement.extend(translation.map_or([0.0; 2], |v| [q[v], q[v + 1]]));
            self.record.twist.push(model.numbering.twist(point.node).map_or(0.0, |index| q[index]));
        }
        for node in &self.plan.bearings {
            let force = self.motion.bearing_force(*node, elapsed, q, v);
            self.record.bearing_force.extend(force);
        }
        Ok(())
    }

    /// Goes on as the recorder of the same run that has seen what is given, under the laws that held then.
    pub fn take_up(&mut self, seen: &RecorderState, contact_modes: &[i64]) {
        self.motion.set_contact_modes(contact_modes);
        self.events.take_up(seen);
        if let Some(audit) = &mut self.audit {
            audit.take_up(seen);
        }
    }

    /// What was recorded, and what was seen.
    pub fn finish(mut self) -> (Record, RecorderState) {
        let mut seen = self.events.seen();
        if let Some(audit) = &self.audit {
            (seen.works, seen.until) = audit.counted();
        }
        self.record.events = self.events.list;
        (self.record, seen)
    }
}

/// The fields of a mesh, as [`MESH_FIELDS`] names them.
pub fn fields(state: &MeshState) -> [f64; 8] {
    [
        state.deflection,
        state.force,
        state.stiffness,
        state.centres.pressure_angle,
        state.centres.distance,
        state.centres.angle,
        state.centres.contact_ratio,
        state.pairs_in_contact,
    ]
}
