//! What happens to a mesh: flanks that part and meet, a contact ratio below one, tips that touch the other root.

use super::checkpoint::{Margins, RecorderState};
use crate::integrate::Trajectory;
use crate::mesh::{Centres, ContactMode, Flank, GearMesh};
use crate::motion::EquationOfMotion;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The drive flanks meet.
    Contact,
    /// The back flanks meet.
    BackContact,
    /// The flanks part.
    Separation,
    /// Both flanks press: the centres have closed by more than the backlash.
    Tight,
    /// The contact ratio falls below one.
    RatioBelowOne,
    /// The contact ratio rises to one again.
    RatioAboveOne,
    /// A tip touches the root of the other gear.
    TipInterference,
    /// The tips are clear again.
    TipClearance,
}

impl EventKind {
    /// The name that users read.
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
        }
    }
}

/// When, to which mesh, what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Index of the mesh.
    pub mesh: usize,
    /// What happened.
    pub kind: EventKind,
}

/// More events than this are counted in the statistics alone.
const MOST: usize = 1_000_000;

/// Watches the meshes.
#[derive(Clone, Debug)]
pub(super) struct EventRecorder {
    pub list: Vec<Event>,
    /// How many the same run had listed before it was paused.
    before: usize,
    origin: f64,
    flanks: Vec<Option<Flank>>,
    /// Contact ratio less one, and tip clearance in metres, when last seen.
    margins: Vec<Option<Margins>>,
}

impl EventRecorder {
    pub fn new(motion: &EquationOfMotion, origin: f64) -> Self {
        let meshes = motion.model().meshes.len();
        Self { list: Vec::new(), before: 0, origin, flanks: vec![None; meshes], margins: vec![None; meshes] }
    }

    /// Goes on from what the same run has seen.
    pub fn take_up(&mut self, seen: &RecorderState) {
        self.before = seen.events;
        self.margins.copy_from_slice(&seen.margins);
    }

    /// What was seen; the works are another's.
    pub fn seen(&self) -> RecorderState {
        RecorderState {
            events: self.before + self.list.len(),
            margins: self.margins.clone(),
            works: [0.0; 6],
            until: 0.0,
        }
    }

    /// Whether there is a mesh to watch at every step; the others are seen when they are recorded.
    pub fn watches(motion: &EquationOfMotion) -> bool {
        motion.model().meshes.iter().any(GearMesh::varies)
    }

    fn push(&mut self, elapsed: f64, mesh: usize, kind: EventKind) {
        if self.before + self.list.len() < MOST {
            self.list.push(Event { time: self.origin + elapsed, mesh, kind });
        }
    }

    /// Sees the laws of the steps to come.
    pub fn switched(&mut self, elapsed: f64, contact_modes: &[i64]) {
        for (mesh, code) in contact_modes.chunks_exact(ContactMode::CODE).enumerate() {
            let flank = ContactMode::from_code(code).flank;
            let before = self.flanks[mesh].replace(flank);
            if before.is_some_and(|before| before != flank) {
                let kind = match flank {
                    Flank::Drive => EventKind::Contact,
                    Flank::Back => EventKind::BackContact,
                    Flank::Apart => EventKind::Separation,
                    Flank::Both => EventKind::Tight,
                };
                self.push(elapsed, mesh, kind);
            }
        }
    }

    /// Sees the end of a step, for meshes whose teeth are modelled.
    pub fn step(&mut self, motion: &EquationOfMotion, step: &impl Trajectory) {
        let Some(q) = step.end_displacement() else {
            return;
        };
        for (index, mesh) in motion.model().meshes.iter().enumerate().filter(|(_, mesh)| mesh.varies()) {
            // Centres that overlap stop the run elsewhere.
            if let Ok(apart) = mesh.centres(&motion.turning(index, step.end()), &mesh.relative(q)) {
                self.see(motion, index, step.end(), &apart);
            }
        }
    }

    /// Sees the centres of a mesh.
    pub fn see(&mut self, motion: &EquationOfMotion, index: usize, elapsed: f64, centres: &Centres) {
        let pair = &motion.model().scene.meshes[index];
        let [a, b] = [pair.driver, pair.driven].map(|gear| &motion.model().scene.gears[gear]);
        let reach = (a.tip_radius + b.root_radius()).max(b.tip_radius + a.root_radius());
        let now = [centres.contact_ratio - 1.0, centres.distance - reach];
        let before = self.margins[index].replace((elapsed, now));
        let kinds = [
            (EventKind::RatioBelowOne, EventKind::RatioAboveOne),
            (EventKind::TipInterference, EventKind::TipClearance),
        ];
        for (i, (lost, won)) in kinds.into_iter().enumerate() {
            match before {
                None if now[i] < 0.0 => self.push(elapsed, index, lost),
                Some((then, margins)) if (margins[i] < 0.0) != (now[i] < 0.0) => {
                    let part = margins[i] / (margins[i] - now[i]);
                    let kind = if now[i] < 0.0 { lost } else { won };
                    self.push(then + part * (elapsed - then), index, kind);
                }
                _ => {}
            }
        }
    }
}
