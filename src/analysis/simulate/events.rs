//! Events of a mesh: flanks separate or meet, the contact ratio falls below one, a tip touches the root of the other gear or
//! reaches beyond its base circle.
//!
//! A contact event is a change of the contact mode after the start of the run. The mode at the start is not an event.
//! Flanks that touch at the start have a deflection at the level of round-off, and its sign depends on the method. Therefore
//! a change also belongs to the start if the gears have moved by no more than round-off.

use super::checkpoint::{Margins, RecorderState};
use crate::integrate::Trajectory;
use crate::mesh::{Centres, ContactMode, Flank, GearMesh, Helix};
use crate::motion::{EquationOfMotion, SourceTerms};
use crate::numerics::ROUND_OFF;
use crate::scene::Gear;

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The drive flanks meet.
    Contact,
    /// The back flanks meet.
    BackContact,
    /// The flanks separate.
    Separation,
    /// Both flanks are in contact: the gear centres are too close for the backlash.
    Tight,
    /// The contact ratio falls below one.
    RatioBelowOne,
    /// The contact ratio rises to one again.
    RatioAboveOne,
    /// A tip touches the root of the other gear.
    TipInterference,
    /// The tips have clearance again.
    TipClearance,
    /// A tip reaches beyond the base circle of the other gear: it ends the path of contact.
    InvoluteInterference,
    /// Tips end the path of contact again.
    InvoluteClearance,
}

impl EventKind {
    /// Name in the Python package.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::BackContact => "back contact",
            Self::Separation => "separation",
            Self::Tight => "tight",
            Self::RatioBelowOne => "contact ratio below 1",
            Self::RatioAboveOne => "contact ratio above 1",
            Self::TipInterference => "tip interference",
            Self::TipClearance => "tip clearance",
            Self::InvoluteInterference => "involute interference",
            Self::InvoluteClearance => "involute clearance",
        }
    }
}

/// An event of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Index of the mesh.
    pub mesh: usize,
    /// Kind of the event.
    pub kind: EventKind,
}

/// Largest number of listed events. The statistics count further ones.
const MAX_EVENTS: usize = 1_000_000;

/// Records the events of all meshes.
#[derive(Clone, Debug)]
pub(super) struct EventRecorder {
    /// Events since the run started or continued.
    pub list: Vec<Event>,
    /// Number of events before the checkpoint from which the run continued.
    before: usize,
    /// Time at which the elapsed time is zero, s.
    origin: f64,
    /// Elapsed time at which the run starts, s.
    start: f64,
    /// Flank contact of each mesh; none before the first evaluation.
    flanks: Vec<Option<Flank>>,
    /// Whether the gears of each mesh have moved by more than round-off since the start.
    moved: Vec<bool>,
    /// Last margins of each mesh; none before the first evaluation.
    margins: Vec<Option<Margins>>,
}

impl EventRecorder {
    /// Creates the recorder of a run that begins at the elapsed time `start`, s. Elapsed time counts from `origin`, s.
    pub fn new(motion: &EquationOfMotion, origin: f64, start: f64) -> Self {
        let meshes = motion.model().meshes.len();
        Self {
            list: Vec::new(),
            before: 0,
            origin,
            start,
            flanks: vec![None; meshes],
            moved: vec![false; meshes],
            margins: vec![None; meshes],
        }
    }

    /// Continues from a checkpoint.
    pub fn resume(&mut self, recorder_state: &RecorderState) {
        self.before = recorder_state.events;
        self.margins.copy_from_slice(&recorder_state.margins);
    }

    /// State of the recorder, without the works of the energy audit.
    pub fn state(&self) -> RecorderState {
        RecorderState {
            events: self.before + self.list.len(),
            margins: self.margins.clone(),
            works: SourceTerms::default(),
            until: 0.0,
        }
    }

    /// Whether a mesh must be evaluated at every step. Other meshes are evaluated at output times.
    pub fn watches(motion: &EquationOfMotion) -> bool {
        motion.model().meshes.iter().any(GearMesh::is_time_varying)
    }

    fn push(&mut self, elapsed: f64, mesh: usize, kind: EventKind) {
        if self.before + self.list.len() < MAX_EVENTS {
            self.list.push(Event { time: self.origin + elapsed, mesh, kind });
        }
    }

    /// Adopts the contact modes of the following steps. `read` writes displacements and velocities at that instant. They are
    /// read only if they decide whether a change belongs to the start.
    pub fn switched(
        &mut self,
        motion: &EquationOfMotion,
        elapsed: f64,
        read: &mut dyn FnMut(&mut [f64], &mut [f64]),
        q: &mut [f64],
        v: &mut [f64],
        contact_modes: &[i64],
    ) {
        let mut is_read = false;
        for (mesh, code) in contact_modes.chunks_exact(ContactMode::CODE_LENGTH).enumerate() {
            let flank = ContactMode::from_code(code).flank;
            let before = self.flanks[mesh].replace(flank);
            if before.is_none_or(|before| before == flank) {
                continue;
            }
            if !self.moved[mesh] {
                if !is_read {
                    read(q, v);
                    is_read = true;
                }
                self.moved[mesh] = has_moved(&motion.model().meshes[mesh], v, elapsed - self.start);
            }
            if self.moved[mesh] {
                let kind = match flank {
                    Flank::Drive => EventKind::Contact,
                    Flank::Back => EventKind::BackContact,
                    Flank::Separated => EventKind::Separation,
                    Flank::Both => EventKind::Tight,
                };
                self.push(elapsed, mesh, kind);
            }
        }
    }

    /// Evaluates the end of a step for meshes with varying stiffness.
    pub fn step(&mut self, motion: &EquationOfMotion, step: &impl Trajectory) {
        let Some(q) = step.end_displacement() else {
            return;
        };
        for (index, mesh) in motion.model().meshes.iter().enumerate().filter(|(_, mesh)| mesh.is_time_varying()) {
            // The integrator reports overlapping base circles.
            if let Ok(centres) = mesh.centres(&motion.phases(index, step.end()), &mesh.relative(q)) {
                self.check(motion, index, step.end(), &centres);
            }
        }
    }

    /// Evaluates the margins of a mesh from its gear centres.
    pub fn check(&mut self, motion: &EquationOfMotion, index: usize, elapsed: f64, centres: &Centres) {
        let pair = &motion.model().scene.meshes[index];
        let [a, b] = [pair.driver, pair.driven].map(|gear| &motion.model().scene.gears[gear]);
        // With the signs of ISO 21771, the distance of an internal gear is negative.
        let signed = |own: &Gear, other: &Gear| own.sign() * own.tip_radius + other.sign() * other.root_radius();
        let now = Margins {
            elapsed,
            contact_ratio: centres.contact_ratio - 1.0,
            tip_clearance: a.sign() * b.sign() * centres.distance - signed(a, b).max(signed(b, a)),
            involute_clearance: centres.involute_clearance,
        };
        let before = self.margins[index].replace(now);
        let margins: [fn(&Margins) -> f64; 3] =
            [|at| at.contact_ratio, |at| at.tip_clearance, |at| at.involute_clearance];
        let kinds = [
            (EventKind::RatioBelowOne, EventKind::RatioAboveOne),
            (EventKind::TipInterference, EventKind::TipClearance),
            (EventKind::InvoluteInterference, EventKind::InvoluteClearance),
        ];
        for ((lost, won), margin) in kinds.into_iter().zip(margins) {
            let now = margin(&now);
            match before.map(|before| (before.elapsed, margin(&before))) {
                None if now < 0.0 => self.push(elapsed, index, lost),
                // Base circles that overlap have no contact ratio.
                Some((_, last)) if last.is_nan() || now.is_nan() => {}
                Some((then, last)) if (last < 0.0) != (now < 0.0) => {
                    let part = last / (last - now);
                    let kind = if now < 0.0 { lost } else { won };
                    self.push(then + part * (elapsed - then), index, kind);
                }
                _ => {}
            }
        }
    }
}

/// Whether gears with velocities `v` have moved by more than round-off in the time `since` the start.
fn has_moved(mesh: &GearMesh, v: &[f64], since: f64) -> bool {
    let rate = mesh.relative(v);
    // No flank closes faster than this.
    let fastest = rate.rolling_displacement.abs() + rate.relative_displacement[0].hypot(rate.relative_displacement[1]);
    let tilting = |helix: &Helix| {
        let [y, z] = mesh.involute.centres_at_rest();
        helix.slope.abs() * y.hypot(z) * rate.tilt[0].hypot(rate.tilt[1])
    };
    let fastest = fastest + mesh.helix.as_ref().map_or(0.0, tilting);
    // Measured deflections of touching flanks at the start are below 1e-16 of the base radius.
    fastest * since > ROUND_OFF * mesh.involute.base_radius[0]
}
