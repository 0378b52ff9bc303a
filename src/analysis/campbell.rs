//! Campbell diagram: tracks modes over the speed and finds their intersections with excitation lines, and the speeds at
//! which they become unstable.
//!
//! Modes are tracked by their shapes in the energy: y = (φ, λφ) with the inner product φᴴKφ' + (λφ)ᴴM(λ'φ'). In this form,
//! the modes of an undamped system with gyroscopic moments are orthogonal at every speed. Therefore |yᴴy'|² (a modal
//! assurance criterion weighted with mass and stiffness; Allemang, Sound and Vibration 37, 2003) adds up to one over all
//! modes. If every mode keeps more than half of its energy, assigning the largest values first is optimal. A speed step is
//! halved if a mode keeps less than [`MIN_CORRELATION`], or if two modes that mix exchange their order. Small steps
//! distinguish a veering, where two modes gradually exchange their shapes, from a crossing, where their shapes do not
//! change.
//!
//! Of a large model only the lowest modes are computed at each speed, a few more than are tracked.

mod state;
mod threshold;

use std::sync::Arc;

use nalgebra::{Complex, DVector};

use super::assignment::{Assignment, MIN_CORRELATION, equal};
use super::modes::{FURTHER_MODES, highest_damped, require, uses_bands};
use super::own_frequency::{self, lowest_modes, lowest_modes_in_tables};
use super::{AnalysisError, Interrupt, Threads};
use crate::modal::{
    self, AtSpeed, CachedModel, EquationForces, FullEquations, Highest, ModalDamping, Mode, ModeAtSpeed, ModeSelection,
    ModeSpace, Residual, Residuals, Unknown, Whirl,
};
use crate::model::Model;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::EntryPath;
use state::{Energy, State};
pub use threshold::Threshold;

/// Largest number of times that a step is halved.
const MAX_HALVINGS: u32 = 10;
/// Largest number of times that the range of an intersection is halved.
const MAX_BISECTIONS: u32 = 40;
/// Largest number of times that a step is halved before the lowest modes are computed.
const MAX_FOLLOWED_HALVINGS: i32 = 4;
/// Fraction of the first step at which modes with equal eigenvalues at the first speed are distinguished.
const START_OFFSET: f64 = 1e-3;
/// Smallest |yᴴy'|² between a mode and its intersection with a line.
const MIN_CORRELATION_ON_LINE: f64 = 0.7;
/// Number of speeds before the current one from which modes are extrapolated: by parabolas.
const EXTRAPOLATED_SPEEDS: usize = 2;
/// Largest dimension of the space of modes for each tracked mode. Beyond it, the space begins again with the last modes.
const MAX_DIMENSIONS_PER_MODE: usize = 8;
/// Part of the highest computed frequency above which a mode may have left the computed ones.
const NEAR_TOP: f64 = 0.8;

/// Source of an excitation at a multiple of the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcitationSource {
    /// Rotation of the shaft with this index.
    Shaft(usize),
    /// Tooth engagement of the mesh with this index.
    Mesh(usize),
}

/// An excitation line ω = order·Ω ≥ 0, with the speed Ω of the reference shaft.
#[derive(Clone, Copy, Debug)]
pub struct ExcitationLine {
    /// Source of the excitation.
    pub source: ExcitationSource,
    /// Harmonic of the frequency of the source.
    pub harmonic: u32,
    /// Frequency relative to the speed of the reference shaft, with the sign of the speeds.
    pub order: f64,
}

/// An intersection of a mode with an excitation line.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    /// Index of the mode.
    pub mode: usize,
    /// Index of the line.
    pub line: usize,
    /// Speed Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Eigenvalue λ of the mode, rad/s.
    pub eigenvalue: Complex<f64>,
    /// Direction of whirl of the mode.
    pub whirl: Whirl,
    /// The larger one of |Im λ/(order·Ω) − 1| and the residual of the mode.
    pub residual: f64,
}

/// A Campbell diagram.
#[derive(Clone, Debug)]
pub struct Campbell {
    /// Eigenvalues λ by speed and mode, rad/s.
    pub eigenvalues: Vec<Vec<Complex<f64>>>,
    /// Direction of whirl by speed and mode.
    pub whirl: Vec<Vec<Whirl>>,
    /// Excitation lines.
    pub lines: Vec<ExcitationLine>,
    /// Intersections in ascending order of |Ω|.
    pub intersections: Vec<Intersection>,
    /// Speeds at which modes become unstable or stable, in ascending order of |Ω|.
    pub thresholds: Vec<Threshold>,
}

/// Excitation lines of the rotation of every shaft and of `harmonics` harmonics of every mesh frequency, at speeds with the sign
/// `sense`.
pub fn lines(cached: &CachedModel, harmonics: u32, sense: f64) -> Vec<ExcitationLine> {
    let scene = &cached.model.scene;
    // Unbalance turns relative to the frame of its shaft.
    let relative =
        scene.speed_ratios.iter().enumerate().map(|(shaft, ratio)| (shaft, ratio - scene.frame_ratio(shaft)));
    let turning = |(shaft, ratio): (usize, f64)| ExcitationLine {
        source: ExcitationSource::Shaft(shaft),
        harmonic: 1,
        order: ratio.abs() * sense,
    };
    let teeth = scene.meshes.iter().enumerate().flat_map(|(index, mesh)| {
        let order = scene.mesh_order(mesh) * sense;
        let line = move |harmonic| ExcitationLine {
            source: ExcitationSource::Mesh(index),
            harmonic,
            order: order * f64::from(harmonic),
        };
        (1..=harmonics).map(line)
    });
    // A shaft at rest excites nothing, and one that turns with its frame has a constant force there.
    let shafts = relative.filter(|(shaft, ratio)| *ratio != 0.0 && scene.speed_ratios[*shaft] != 0.0);
    shafts.map(turning).chain(teeth).collect()
}

/// Tracks the `count` lowest modes over `speeds` of one sign and of ascending magnitude, rad/s, and intersects them with [`lines`].
///
/// # Errors
/// [`AnalysisError`] if the speeds have both signs or their magnitudes do not ascend, a decomposition fails, or `interrupt` requests a stop.
pub fn campbell(
    cached: &CachedModel,
    speeds: &[f64],
    count: usize,
    harmonics: u32,
    threads: &Threads,
    interrupt: &Interrupt,
) -> Result<Campbell, AnalysisError> {
    let sense = sense_of(speeds);
    for (index, speed) in speeds.iter().enumerate() {
        let place = EntryPath::entry("speeds", index);
        place.finite(*speed)?;
        if *speed * sense < 0.0 {
            let message = format!("must have the sign of the last speed, {}, got {speed}", speeds[speeds.len() - 1]);
            return Err(place.error(message).into());
        }
        if index > 0 && speed.abs() <= speeds[index - 1].abs() {
            let message = format!("must be farther from zero than the previous speed, got {speed}");
            return Err(place.error(message).into());
        }
    }
    let common = cached.common_to(speeds)?;
    let mut tracker = Tracker::new(&common, speeds, count, harmonics, threads, interrupt)?;
    let mut diagram = Campbell {
        eigenvalues: Vec::new(),
        whirl: Vec::new(),
        lines: tracker.lines.clone(),
        intersections: Vec::new(),
        thresholds: Vec::new(),
    };
    for speed in speeds {
        tracker.advance_to(*speed)?;
        diagram.eigenvalues.push(tracker.modes.iter().map(|mode| mode.eigenvalue).collect());
        diagram.whirl.push(tracker.modes.iter().map(|mode| mode.whirl).collect());
    }
    diagram.intersections = tracker.intersections;
    diagram.intersections.sort_by(|a, b| a.speed.abs().total_cmp(&b.speed.abs()).then(a.mode.cmp(&b.mode)));
    diagram.thresholds = tracker.thresholds;
    diagram.thresholds.sort_by(|a, b| a.speed.abs().total_cmp(&b.speed.abs()).then(a.mode.cmp(&b.mode)));
    Ok(diagram)
}

/// Tracked modes at an earlier speed.
struct Previous {
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    modes: Vec<State>,
}

/// A model at a speed, whose matrices are projected on the space of displacements.
struct Projected<'a> {
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    cached: AtSpeed<'a>,
    modal: Option<Arc<ModalDamping>>,
}

impl Projected<'_> {
    fn equations(&self) -> FullEquations<'_> {
        FullEquations { model: &self.cached.model, modal: self.modal.as_deref() }
    }
}

/// Tracked modes up to the current speed.
struct Tracker<'a> {
    cached: &'a CachedModel,
    threads: &'a Threads,
    interrupt: &'a Interrupt,
    /// The model whose energy is the inner product.
    basis: AtSpeed<'a>,
    energy: Energy,
    /// Space of displacements in which Newton's method finds modes.
    space: ModeSpace,
    /// The model whose matrices are projected on the space; None before the first speed.
    projected: Option<Projected<'a>>,
    /// Number of modes that are computed at each speed.
    wanted: usize,
    /// Sign of the speeds.
    sense: f64,
    lines: Vec<ExcitationLine>,
    /// Current speed, rad/s; None before the first speed.
    speed: Option<f64>,
    modes: Vec<State>,
    /// The tracked modes at the last speeds before the current one, at most [`EXTRAPOLATED_SPEEDS`], the earliest first.
    previous: Vec<Previous>,
    intersections: Vec<Intersection>,
    thresholds: Vec<Threshold>,
}

impl<'a> Tracker<'a> {
    fn new(
        cached: &'a CachedModel,
        speeds: &[f64],
        count: usize,
        harmonics: u32,
        threads: &'a Threads,
        interrupt: &'a Interrupt,
    ) -> Result<Self, AnalysisError> {
        // Of bearings that depend on speed or frequency, those of one speed and frequency are as good as any for the inner product.
        let basis = cached.at(speeds.first().copied().unwrap_or(0.0), cached.model.lowest_frequency())?;
        let wanted = count.saturating_add(FURTHER_MODES);
        let sense = sense_of(speeds);
        let mut tracker = Self {
            cached,
            threads,
            interrupt,
            space: ModeSpace::new(&cached.model),
            projected: None,
            energy: Energy::new(&basis.model, sense),
            basis,
            wanted,
            sense,
            lines: lines(cached, harmonics, sense),
            speed: None,
            modes: Vec::new(),
            previous: Vec::new(),
            intersections: Vec::new(),
            thresholds: Vec::new(),
        };
        if let Some(first) = speeds.first() {
            // Forward and backward modes are equal at standstill; their shapes differ at a small speed.
            let start = speeds.get(1).map_or(*first, |second| first + START_OFFSET * (second - first));
            if !cached.model.depends_on_frequency() {
                let modes = lowest_modes(cached, beyond_standstill(start, sense), count, ModeSelection::Vibrations)?;
                tracker.modes = modes.into_iter().map(|mode| State::new(&tracker.energy, mode)).collect();
                return Ok(tracker);
            }
            loop {
                let states = tracker.at(start)?;
                let vibrates = |state: &&State| modal::vibrates(&cached.model, start, state.eigenvalue);
                tracker.modes = states.iter().filter(vibrates).take(count).cloned().collect();
                // The mode that the tables of the bearings do not contain is the error.
                if tracker.modes.len() == count
                    || lowest_modes(cached, start, tracker.wanted, ModeSelection::All)?.len() < tracker.wanted
                {
                    break;
                }
                // Rigid-body modes and overdamped modes are not tracked.
                tracker.wanted += count.saturating_sub(tracker.modes.len());
            }
        }
        Ok(tracker)
    }

    fn at(&self, speed: f64) -> Result<Arc<Vec<State>>, AnalysisError> {
        self.interrupt.check()?;
        let speed = beyond_standstill(speed, self.sense);
        let count = if self.is_partial() { self.wanted } else { usize::MAX };
        let mut modes = lowest_modes_in_tables(self.cached, speed, count)?;
        if self.cached.model.depends_on_frequency() && modes.len() < self.modes.len() {
            // The mode that the tables of the bearings do not contain is the error.
            modes = lowest_modes(self.cached, speed, count, ModeSelection::All)?;
        }
        Ok(Arc::new(modes.into_iter().map(|mode| State::new(&self.energy, mode)).collect()))
    }

    /// The tracked mode with these `ends` at a speed between theirs: by Newton's method, or that of the lowest modes which
    /// correlates most with the ends.
    fn between(&mut self, ends: [(f64, &State); 2], speed: f64) -> Result<State, AnalysisError> {
        let [low, high] = ends;
        let part = ((speed - low.0) / (high.0 - low.0)).clamp(0.0, 1.0);
        let nearest = if part < 0.5 { low.1 } else { high.1 };
        let eigenvalue = low.1.eigenvalue * (1.0 - part) + high.1.eigenvalue * part;
        let start = ModeAtSpeed { speed, eigenvalue, shape: nearest.shape() };
        let found = self.modes_near(Unknown::Frequency, vec![start])?.pop();
        if let Some(found) = found.filter(|found| is_like(ends, found)) {
            return Ok(found);
        }
        Ok(most_like(ends, &self.at(speed)?).unwrap_or(low.1).clone())
    }

    /// The modes near `starts`, all at one speed; only those before the first one that Newton's method does not find.
    fn modes_near(&mut self, unknown: Unknown, starts: Vec<ModeAtSpeed>) -> Result<Vec<State>, AnalysisError> {
        self.interrupt.check()?;
        let Some(speed) = starts.first().map(|start| start.speed) else { return Ok(Vec::new()) };
        let mut states = Vec::new();
        if self.cached.model.depends_on_frequency() {
            let near = |start: &ModeAtSpeed| {
                self.interrupt.check()?;
                own_frequency::mode_near(self.cached, self.highest(), start)
            };
            for met in self.threads.map(&starts, near)?.into_iter().map_while(|met| met) {
                let cached = &*self.cached.at(speed, met.eigenvalue.im)?;
                let modal = cached.modal_damping(speed, self.highest())?;
                let forces = EquationForces::All(modal.as_deref());
                let residual = modal::residual(cached, speed, met.eigenvalue, &met.shape, forces)?;
                states.push(self.state(&cached.model, met, residual));
            }
        } else {
            let at_speed = self.cached.at_speed(speed)?;
            let modal = at_speed.modal_damping(speed, self.highest())?;
            self.project(Projected { speed, cached: at_speed.clone(), modal: modal.clone() });
            let (model, modal) = (&at_speed.model, modal.as_deref());
            let range = self.basis.spectral_range(speed)?;
            let mut residuals = Residuals::new(model, range, speed, EquationForces::All(modal));
            for start in starts {
                self.interrupt.check()?;
                let residual = |met: &ModeAtSpeed| {
                    residuals.speed = met.speed;
                    residuals.of(met.eigenvalue, &met.shape)
                };
                let met = self.space.mode_near(model, modal, unknown, start, residual, |found| found.value)?;
                let Some((met, residual)) = met else { break };
                states.push(self.state(model, met, residual));
            }
        }
        let accurate = states.iter().take_while(|state| state.residual.is_accurate()).count();
        states.truncate(accurate);
        Ok(states)
    }

    /// Projects the matrices of a model on the space. A new space, or one that has grown too large, begins with the shapes of the
    /// tracked modes at the current and at the previous speed.
    fn project(&mut self, to: Projected<'a>) {
        let (model, modal) = (&to.cached.model, to.modal.as_deref());
        match &self.projected {
            Some(known) if self.space.dimension() <= MAX_DIMENSIONS_PER_MODE * self.modes.len() => {
                if self.cached.model.depends_on_speed() && known.speed != to.speed {
                    self.space.change(&known.equations(), &to.equations(), [known.speed, to.speed]);
                }
            }
            _ => {
                self.space = ModeSpace::new(model);
                let before = self.previous.last().into_iter().flat_map(|previous| &previous.modes);
                for mode in self.modes.iter().chain(before) {
                    self.space.extend(model, modal, to.speed, &mode.shape());
                }
            }
        }
        self.projected = Some(to);
    }

    /// A mode of the `model` at its speed.
    fn state(&self, model: &Model, met: ModeAtSpeed, residual: Residual) -> State {
        let ModeAtSpeed { speed, eigenvalue, shape } = met;
        let whirl = modal::whirl(model, speed, eigenvalue, &shape);
        State::new(&self.energy, Mode { eigenvalue, shape, whirl, residual })
    }

    /// Whether only the lowest modes are computed at each speed.
    fn is_partial(&self) -> bool {
        uses_bands(&self.cached.model, self.wanted)
    }

    /// Computes more modes from here on if a tracked mode may lie above the computed `states`; whether it may.
    fn extend(&mut self, states: &[State], assignment: &Assignment) -> bool {
        let top = states.iter().map(|state| state.eigenvalue.norm()).fold(0.0, f64::max);
        let partial = states.len() <= self.wanted && self.is_partial();
        let left = |(mode, index): (&State, &usize)| {
            mode.eigenvalue.norm() > NEAR_TOP * top && mode.correlation(&states[*index]) < MIN_CORRELATION
        };
        let extends = partial && self.modes.iter().zip(&assignment.states).any(left);
        if extends {
            self.wanted += FURTHER_MODES;
            // Further modes have modal damping.
            self.projected = None;
        }
        extends
    }

    /// Tracks the modes to `speed`: each by Newton's method, in smaller steps where that is not clear, or else among the
    /// lowest modes.
    fn advance_to(&mut self, speed: f64) -> Result<(), AnalysisError> {
        let mut halved = 0;
        while self.can_follow() && speed != 0.0 && halved <= MAX_FOLLOWED_HALVINGS {
            let target = self.speed.map_or(speed, |from| speed - (speed - from) * (1.0 - 0.5_f64.powi(halved)));
            match self.followed(target)? {
                Some(states) => {
                    self.adopt(target, &states, (0..self.modes.len()).collect())?;
                    if target == speed {
                        return Ok(());
                    }
                    halved -= 1;
                }
                None if self.speed.is_none() => break,
                None => halved += 1,
            }
        }
        let states = self.at(speed)?;
        self.advance(speed, states, 0)
    }

    /// The tracked modes at `speed` by Newton's method, which begins with those at the current speed; `None` where it does not
    /// lead to the same modes without doubt.
    fn followed(&mut self, speed: f64) -> Result<Option<Vec<State>>, AnalysisError> {
        let starts = (0..self.modes.len()).map(|mode| self.expected(mode, speed)).collect();
        let states = self.modes_near(Unknown::Frequency, starts)?;
        let is_repeated = |(index, state): (usize, &State)| {
            states[..index].iter().any(|other| equal(other.eigenvalue, state.eigenvalue))
        };
        if states.len() < self.modes.len() || states.iter().enumerate().any(is_repeated) {
            return Ok(None);
        }
        let assignment = self.assign(&states);
        let is_same = assignment.states.iter().enumerate().all(|(mode, state)| mode == *state);
        Ok((assignment.clear && is_same).then_some(states))
    }

    /// A tracked mode extrapolated to `speed` from the last speeds (polynomial of Lagrange).
    fn expected(&self, mode: usize, speed: f64) -> ModeAtSpeed {
        let current = &self.modes[mode];
        let known = self.previous.iter().map(|previous| (previous.speed, &previous.modes[mode]));
        let known = known.filter(|(_, before)| before.correlation(current) > MIN_CORRELATION);
        let points: Vec<(f64, &State)> = known.chain([(self.speed.unwrap_or(speed), current)]).collect();
        let (mut eigenvalue, mut shape) = (Complex::ZERO, DVector::zeros(self.cached.model.len()));
        for (at, state) in &points {
            let others = points.iter().map(|(other, _)| *other).filter(|other| other != at);
            let weight: f64 = others.map(|other| (speed - other) / (at - other)).product();
            let phase = state.product(current);
            eigenvalue += state.eigenvalue * weight;
            shape += state.shape() * (phase * (weight / phase.norm()));
        }
        ModeAtSpeed { speed, eigenvalue, shape }
    }

    /// Whether Newton's method can follow the tracked modes: no two are equal, as in identical shafts.
    fn can_follow(&self) -> bool {
        let is_equal = |(index, mode): (usize, &State)| {
            self.modes[..index].iter().any(|other| equal(other.eigenvalue, mode.eigenvalue))
        };
        !self.modes.iter().enumerate().any(is_equal)
    }

    /// Which undamped modes have modal damping.
    fn highest(&self) -> Highest {
        highest_damped(&self.cached.model, self.wanted)
    }

    /// Tracks the modes to the states at `speed`.
    fn advance(&mut self, speed: f64, states: Arc<Vec<State>>, halved: u32) -> Result<(), AnalysisError> {
        let assignment = self.assign(&states);
        if let Some(from) = self.speed {
            if !assignment.clear && halved == 0 && self.extend(&states, &assignment) {
                let states = self.at(speed)?;
                return self.advance(speed, states, halved);
            }
            if !assignment.clear && halved < MAX_HALVINGS {
                let middle = f64::midpoint(from, speed);
                let between = self.at(middle)?;
                self.advance(middle, between, halved + 1)?;
                return self.advance(speed, states, halved + 1);
            }
        }
        self.adopt(speed, &states, assignment.states)
    }

    /// Takes the states with these indices at `speed` for the tracked modes, and finds what lies between the current speed and
    /// this one.
    fn adopt(&mut self, speed: f64, states: &[State], indices: Vec<usize>) -> Result<(), AnalysisError> {
        if let Some(from) = self.speed {
            for (mode, index) in indices.iter().enumerate() {
                let known = self.modes[mode].clone();
                let ends = [(from, &known), (speed, &states[*index])];
                let intersections = self.intersections_between(mode, ends)?;
                self.intersections.extend(intersections);
                let threshold = self.threshold_between(mode, ends)?;
                self.thresholds.extend(threshold);
            }
        }
        self.previous.extend(self.speed.map(|speed| Previous { speed, modes: self.modes.clone() }));
        self.previous.drain(..self.previous.len().saturating_sub(EXTRAPOLATED_SPEEDS));
        for (mode, index) in self.modes.iter_mut().zip(indices) {
            let state = &states[index];
            let distinct = states.iter().filter(|other| equal(other.eigenvalue, state.eigenvalue)).count() == 1;
            (mode.eigenvalue, mode.whirl) = (state.eigenvalue, state.whirl);
            if distinct {
                *mode = state.clone();
            }
        }
        self.speed = Some(speed);
        Ok(())
    }

    fn assign(&self, states: &[State]) -> Assignment {
        let correlations: Vec<Vec<f64>> =
            self.modes.iter().map(|mode| states.iter().map(|state| mode.correlation(state)).collect()).collect();
        let common = |a: usize, b: usize| self.modes[a].correlation(&self.modes[b]);
        let values = |of: &[State]| of.iter().map(|state| state.eigenvalue).collect::<Vec<_>>();
        Assignment::new(&correlations, common, &values(&self.modes), &values(states), usize::MAX)
    }

    /// The intersections of a mode with all lines between two speeds.
    fn intersections_between(
        &mut self,
        mode: usize,
        ends: [(f64, &State); 2],
    ) -> Result<Vec<Intersection>, AnalysisError> {
        let mut intersections = Vec::new();
        // The modes at the ends, and those between them that the searches find.
        let mut known: Vec<(f64, State)> = ends.iter().map(|(speed, state)| (*speed, (*state).clone())).collect();
        // A mode without frequency at standstill lies on every line there; a small speed tells on which side it continues.
        if ends[0].0 == 0.0 && ends[0].1.eigenvalue.im <= EQUALITY_TOLERANCE * ends[1].1.eigenvalue.im {
            let speed = START_OFFSET * ends[1].0;
            known[0] = (speed, self.between(ends, speed)?);
        }
        for line in 0..self.lines.len() {
            let order = self.lines[line].order;
            let above = [&known[0], &known[known.len() - 1]].map(|(speed, state)| state.eigenvalue.im > order * speed);
            if above[0] != above[1] {
                self.interrupt.check()?;
                let (speed, state) = if self.cached.model.depends_on_speed() {
                    self.root_of(&mut known, |speed, state| state.eigenvalue.im - order * speed)?
                } else {
                    self.intersection(order, ends)?
                };
                let State { eigenvalue, whirl, residual, .. } = state;
                let residual = residual.with((eigenvalue.im / (order * speed) - 1.0).abs());
                require(residual, || {
                    format!("the intersection of mode {} with the order {order} at {speed} rad/s", mode + 1)
                })?;
                intersections.push(Intersection { mode, line, speed, eigenvalue, whirl, residual: residual.value });
            }
        }
        Ok(intersections)
    }

    /// The intersection of a mode with the line ω = `order`·Ω between two speeds on opposite sides of the line: by Newton's
    /// method, which begins between closer speeds where it does not lead to this mode. Matrices must not depend on the speed.
    ///
    /// On the line, the sign of the frequency relative to a shaft is zero, so that its loss factor has no effect; a root of the
    /// frequencies beside the line does not see that.
    fn intersection(&mut self, order: f64, ends: [(f64, &State); 2]) -> Result<(f64, State), AnalysisError> {
        let [mut low, mut high] = ends.map(|(speed, state)| (speed, state.clone()));
        let gap = |(speed, state): &(f64, State)| state.eigenvalue.im - order * speed;
        for _ in 0..MAX_BISECTIONS {
            let part = gap(&low).abs() / (gap(&low).abs() + gap(&high).abs());
            let nearest = if part < 0.5 { &low.1 } else { &high.1 };
            let speed = low.0 + part * (high.0 - low.0);
            let eigenvalue = Complex::new(nearest.eigenvalue.re, order * speed);
            let start = ModeAtSpeed { speed, eigenvalue, shape: nearest.shape() };
            let ends = [(low.0, &low.1), (high.0, &high.1)];
            // Newton's method may find another mode on the line: accept it only if its shape correlates with this mode.
            if let Some(found) = self.modes_near(Unknown::Speed(order), vec![start])?.pop() {
                let speed = found.eigenvalue.im / order;
                let [part, slack] =
                    [(speed - low.0) / (high.0 - low.0), EQUALITY_TOLERANCE * high.0 / (high.0 - low.0)];
                if part >= -slack && part <= 1.0 + slack && is_like(ends, &found) {
                    return Ok((speed, found));
                }
            }
            let middle = f64::midpoint(low.0, high.0);
            let found = (middle, self.between(ends, middle)?);
            if (gap(&low) > 0.0) == (gap(&found) > 0.0) {
                low = found;
            } else {
                high = found;
            }
        }
        Ok(high)
    }
}

/// The mode between two speeds whose shape correlates most with those of the `ends`.
fn most_like<'s>(ends: [(f64, &State); 2], states: &'s [State]) -> Option<&'s State> {
    let like = |state: &State| ends[0].1.correlation(state) + ends[1].1.correlation(state);
    states.iter().max_by(|a, b| like(a).total_cmp(&like(b)))
}

/// Sign of speeds that have one sign: 1 for standstill alone.
fn sense_of(speeds: &[f64]) -> f64 {
    if speeds.last().is_some_and(|speed| *speed < 0.0) { -1.0 } else { 1.0 }
}

/// A speed at which the flanks in contact are those of speeds with the sign `sense`.
fn beyond_standstill(speed: f64, sense: f64) -> f64 {
    if speed == 0.0 { sense * f64::MIN_POSITIVE } else { speed }
}

/// Whether a mode between two speeds is that of the `ends`: its shape is close to one of them.
fn is_like(ends: [(f64, &State); 2], found: &State) -> bool {
    ends.iter().any(|(_, state)| found.correlation(state) > MIN_CORRELATION_ON_LINE)
}
