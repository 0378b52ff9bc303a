//! Modes followed over the speed, and the speeds at which they meet what excites them.
//!
//! A mode is followed by its shape. In y = (ωη, η̇), half of whose square is the energy, the modes of an undamped train
//! are orthogonal at every speed, gyroscopic moments and all, so |yᴴy'|² (a modal assurance criterion with mass *and*
//! stiffness as weights; Allemang, Sound and Vibration 37, 2003) adds up to one over all modes. Where every mode keeps
//! more than a half of itself, the largest values are the optimal assignment. A step that does not keep [`CLEAR`] of
//! every mode, or in which two modes that mix change places, is halved: what is left of their meeting tells a veering,
//! where each mode takes the other's shape over by and by, from a crossing, where they pass each other.

use std::rc::Rc;

use nalgebra::{Complex, DVector};

use super::{AnalysisError, Interrupt};
use crate::modal::{self, CachedModel, OrderIntersection, Quadratic, Whirl};
use crate::scene::EntryPath;

/// A step in which a mode keeps less than this part of its energy in its shape is halved.
const CLEAR: f64 = 0.9;
/// Modes that change places in a step and mix by less than this veer within a hundredth of it: they cross.
const UNMIXED: f64 = 1e-4;
/// How often a step is halved at most.
const HALVINGS: u32 = 10;
/// Eigenvalues that differ by less than this part are equal: their shapes are any combination.
const EQUAL: f64 = 1e-7;
/// The part of the first step at which modes that are equal at the first speed are told apart.
const APART: f64 = 1e-3;
/// The part of its shape by which a mode on a line is known again.
const KNOWN: f64 = 0.7;

/// What excites a train at a multiple of the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcitationSource {
    /// The turning of a shaft.
    Shaft(usize),
    /// The teeth of a mesh.
    Mesh(usize),
}

/// A line of the diagram: ω = order·Ω, with Ω the speed of the reference shaft.
#[derive(Clone, Copy, Debug)]
pub struct ExcitationLine {
    /// What excites.
    pub source: ExcitationSource,
    /// The harmonic of its own frequency.
    pub harmonic: u32,
    /// Frequency over the speed of the reference shaft.
    pub order: f64,
}

/// A speed at which a mode meets a line.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    /// Index of the mode.
    pub mode: usize,
    /// Index of the line.
    pub line: usize,
    /// Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// λ there, rad/s.
    pub eigenvalue: Complex<f64>,
    /// How the mode whirls there.
    pub whirl: Whirl,
}

/// A Campbell diagram.
#[derive(Clone, Debug)]
pub struct Campbell {
    /// λ of every mode, speed after speed.
    pub eigenvalues: Vec<Vec<Complex<f64>>>,
    /// Whirl of every mode, speed after speed.
    pub whirl: Vec<Vec<Whirl>>,
    /// The lines.
    pub lines: Vec<ExcitationLine>,
    /// Where modes meet lines, by ascending speed.
    pub intersections: Vec<Intersection>,
}

/// One mode at one speed: y of unit length beside its eigenvalue.
#[derive(Clone, Debug)]
struct State {
    eigenvalue: Complex<f64>,
    whirl: Whirl,
    energy: DVector<Complex<f64>>,
}

/// Every shaft's turning, and `harmonics` of the tooth frequency of every mesh.
pub fn lines(cached: &CachedModel, harmonics: u32) -> Vec<ExcitationLine> {
    let scene = &cached.model.scene;
    let turning = |(shaft, ratio): (usize, &f64)| ExcitationLine {
        source: ExcitationSource::Shaft(shaft),
        harmonic: 1,
        order: ratio.abs(),
    };
    let teeth = scene.meshes.iter().enumerate().flat_map(|(index, mesh)| {
        let gear = &scene.gears[mesh.driver];
        let order = f64::from(gear.teeth) * scene.speed_ratios[gear.body.node.shaft].abs();
        let line = move |harmonic| ExcitationLine {
            source: ExcitationSource::Mesh(index),
            harmonic,
            order: order * f64::from(harmonic),
        };
        (1..=harmonics).map(line)
    });
    scene.speed_ratios.iter().enumerate().map(turning).chain(teeth).collect()
}

/// The `count` lowest modes over ascending `speeds`, with the lines of [`lines`].
///
/// # Errors
/// [`AnalysisError`] if the speeds do not ascend from zero or above, a decomposition fails, or `interrupt` asks to stop.
pub fn campbell(
    cached: &CachedModel,
    speeds: &[f64],
    count: usize,
    harmonics: u32,
    interrupt: &Interrupt,
) -> Result<Campbell, AnalysisError> {
    for (index, speed) in speeds.iter().enumerate() {
        let place = EntryPath::entry("speeds", index);
        place.non_negative(*speed)?;
        if index > 0 && *speed <= speeds[index - 1] {
            return Err(place.error(format!("must be above the one before, got {speed}")).into());
        }
    }
    let mut tracker = Tracker::new(cached, speeds, count, harmonics, interrupt)?;
    let mut diagram = Campbell {
        eigenvalues: Vec::new(),
        whirl: Vec::new(),
        lines: tracker.lines.clone(),
        intersections: Vec::new(),
    };
    for speed in speeds {
        let here = tracker.at(*speed)?;
        tracker.advance(*speed, here, 0)?;
        diagram.eigenvalues.push(tracker.modes.iter().map(|mode| mode.eigenvalue).collect());
        diagram.whirl.push(tracker.modes.iter().map(|mode| mode.whirl).collect());
    }
    diagram.intersections = tracker.intersections;
    diagram.intersections.sort_by(|a, b| a.speed.total_cmp(&b.speed).then(a.mode.cmp(&b.mode)));
    Ok(diagram)
}

/// Where the modes have been followed to.
struct Tracker<'a> {
    cached: &'a CachedModel,
    interrupt: &'a Interrupt,
    quadratic: Quadratic,
    lines: Vec<ExcitationLine>,
    /// None before the first of the speeds.
    speed: Option<f64>,
    modes: Vec<State>,
    intersections: Vec<Intersection>,
}

/// Which state each mode becomes in a step.
struct Assignment {
    states: Vec<usize>,
    /// Whether the step leaves no doubt.
    clear: bool,
}

impl<'a> Tracker<'a> {
    fn new(
        cached: &'a CachedModel,
        speeds: &[f64],
        count: usize,
        harmonics: u32,
        interrupt: &'a Interrupt,
    ) -> Result<Self, AnalysisError> {
        let mut tracker = Self {
            cached,
            interrupt,
            quadratic: Quadratic::new(cached, 1.0)?,
            lines: lines(cached, harmonics),
            speed: None,
            modes: Vec::new(),
            intersections: Vec::new(),
        };
        if let Some(first) = speeds.first() {
            // At rest forward and backward are equal; their shapes are told apart a little way on.
            let start = speeds.get(1).map_or(*first, |second| first + APART * (second - first));
            let states = tracker.at(start)?;
            tracker.modes = states.iter().filter(|state| state.eigenvalue.im > 0.0).take(count).cloned().collect();
        }
        Ok(tracker)
    }

    fn at(&self, speed: f64) -> Result<Rc<Vec<State>>, AnalysisError> {
        self.interrupt.check()?;
        // The modes are followed with the flanks of a positive speed, from speed zero on.
        let speed = if speed == 0.0 { f64::MIN_POSITIVE } else { speed };
        let real = self.cached.real_modes(speed)?;
        let weighted = self.cached.model.mass_matrix() * &real.vectors;
        let n = real.frequencies.len();
        let state = |mode: modal::Mode| {
            let part = |part: fn(&Complex<f64>) -> f64| weighted.tr_mul(&mode.shape.map(|value| part(&value)));
            let (re, im) = (part(|value| value.re), part(|value| value.im));
            let energy = DVector::from_fn(2 * n, |i, _| {
                let eta = Complex::new(re[i % n], im[i % n]);
                if i < n {
                    eta * real.frequencies[i]
                } else if mode.eigenvalue == Complex::ZERO {
                    eta
                } else {
                    eta * mode.eigenvalue
                }
            });
            let norm = energy.norm();
            State { eigenvalue: mode.eigenvalue, whirl: mode.whirl, energy: energy.unscale(norm) }
        };
        Ok(Rc::new(modal::modes(self.cached, speed)?.into_iter().map(state).collect()))
    }

    /// Follows the modes to the states of `speed`.
    fn advance(&mut self, speed: f64, states: Rc<Vec<State>>, halved: u32) -> Result<(), AnalysisError> {
        let assignment = self.assign(&states);
        if let Some(from) = self.speed {
            if !assignment.clear && halved < HALVINGS {
                let middle = f64::midpoint(from, speed);
                let between = self.at(middle)?;
                self.advance(middle, between, halved + 1)?;
                return self.advance(speed, states, halved + 1);
            }
            for mode in 0..self.modes.len() {
                self.meet(mode, [(from, &self.modes[mode].clone()), (speed, &states[assignment.states[mode]])])?;
            }
        }
        for (mode, index) in self.modes.iter_mut().zip(assignment.states) {
            let state = &states[index];
            let unlike = states.iter().filter(|other| equal(other, state)).count() == 1;
            mode.eigenvalue = state.eigenvalue;
            mode.whirl = state.whirl;
            if unlike {
                mode.energy.clone_from(&state.energy);
            }
        }
        self.speed = Some(speed);
        Ok(())
    }

    fn assign(&self, states: &[State]) -> Assignment {
        let own: Vec<Vec<f64>> =
            self.modes.iter().map(|mode| states.iter().map(|s| alike(mode, s)).collect()).collect();
        // Of equal eigenvalues any state will do; what counts is the part of the mode in all of them.
        let shared = |mode: usize, index: usize| {
            let together = (0..states.len()).filter(|other| equal(&states[*other], &states[index]));
            together.map(|other| own[mode][other]).sum::<f64>()
        };
        let mut pairs: Vec<(f64, usize, usize)> = (0..self.modes.len())
            .flat_map(|mode| (0..states.len()).map(move |index| (mode, index)))
            .filter(|(mode, index)| own[*mode][*index] > f64::EPSILON)
            .map(|(mode, index)| (shared(mode, index) + UNMIXED * own[mode][index], mode, index))
            .collect();
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut taken, mut assigned) = (vec![false; states.len()], vec![None; self.modes.len()]);
        for (_, mode, index) in &pairs {
            if assigned[*mode].is_none() && !taken[*index] {
                (assigned[*mode], taken[*index]) = (Some(*index), true);
            }
        }
        let mut free = (0..states.len()).filter(|index| !taken[*index]);
        let found: Vec<usize> =
            assigned.iter().map(|index| index.or_else(|| free.next()).unwrap_or_default()).collect();
        let kept = found.iter().enumerate().all(|(mode, index)| shared(mode, *index) > CLEAR);
        let mixed = |a: usize, b: usize| own[a][found[b]].max(own[b][found[a]]) > UNMIXED;
        let passed = |a: usize, b: usize| {
            let gap = |a: &State, b: &State| (a.eigenvalue.im - b.eigenvalue.im) / (a.eigenvalue.im + b.eigenvalue.im);
            let (before, after) = (gap(&self.modes[a], &self.modes[b]), gap(&states[found[a]], &states[found[b]]));
            before * after < 0.0 && before.abs().min(after.abs()) > EQUAL
        };
        let count = self.modes.len();
        let clear = kept && !(0..count).any(|b| (0..b).any(|a| passed(a, b) && mixed(a, b)));
        Assignment { states: found, clear }
    }

    /// Keeps where a mode meets lines between two speeds.
    fn meet(&mut self, mode: usize, ends: [(f64, &State); 2]) -> Result<(), AnalysisError> {
        for line in 0..self.lines.len() {
            let order = self.lines[line].order;
            let above = ends.map(|(speed, state)| state.eigenvalue.im > order * speed);
            if above[0] != above[1] {
                self.interrupt.check()?;
                let met = self.intersection(order, ends, 0)?;
                let whirl = modal::whirl(self.cached, met.speed, met.eigenvalue, &met.coordinates)?;
                let OrderIntersection { speed, eigenvalue, .. } = met;
                self.intersections.push(Intersection { mode, line, speed, eigenvalue, whirl });
            }
        }
        Ok(())
    }

    /// The mode on the line ω = `order`·Ω between two speeds at which it is on either side of it.
    fn intersection(
        &self,
        order: f64,
        ends: [(f64, &State); 2],
        halved: u32,
    ) -> Result<OrderIntersection, AnalysisError> {
        let [low, high] = ends;
        let distance = ends.map(|(speed, state)| (state.eigenvalue.im - order * speed).abs());
        let part = distance[0] / (distance[0] + distance[1]);
        let nearest = if part < 0.5 { low.1 } else { high.1 };
        let start = self.start(low.0 + part * (high.0 - low.0), nearest);
        // Newton finds a mode on the line: whether it is this one, its shape tells.
        let within = |met: &OrderIntersection| {
            let slack = 1e-9 * high.0;
            met.speed >= low.0 - slack && met.speed <= high.0 + slack && {
                let known = self.energy(met);
                ends.iter().any(|(_, state)| known.dotc(&state.energy).norm_sqr() > KNOWN)
            }
        };
        if let Some(met) = self.quadratic.intersection(order, &start).filter(within) {
            return Ok(met);
        }
        if halved > 4 * HALVINGS {
            return Ok(start);
        }
        let middle = f64::midpoint(low.0, high.0);
        let states = self.at(middle)?;
        let like = |state: &State| alike(low.1, state) + alike(high.1, state);
        let found = states.iter().max_by(|a, b| like(a).total_cmp(&like(b))).unwrap_or(nearest);
        let above = |(speed, state): (f64, &State)| state.eigenvalue.im > order * speed;
        let between = (middle, found);
        let halves = if above(low) == above(between) { [between, high] } else { [low, between] };
        self.intersection(order, halves, halved + 1)
    }

    fn start(&self, speed: f64, state: &State) -> OrderIntersection {
        let n = state.energy.len() / 2;
        let coordinates = state.energy.rows(n, n).into_owned();
        let norm = coordinates.norm();
        OrderIntersection { speed, eigenvalue: state.eigenvalue, coordinates: coordinates.unscale(norm) }
    }

    fn energy(&self, met: &OrderIntersection) -> DVector<Complex<f64>> {
        let n = met.coordinates.len();
        let scale = |i: usize| if i < n { Complex::from(self.quadratic.frequency(i)) } else { met.eigenvalue };
        let energy = DVector::from_fn(2 * n, |i, _| met.coordinates[i % n] * scale(i));
        let norm = energy.norm();
        energy.unscale(norm)
    }
}

/// |yᴴy'|².
fn alike(a: &State, b: &State) -> f64 {
    a.energy.dotc(&b.energy).norm_sqr()
}

fn equal(a: &State, b: &State) -> bool {
    (a.eigenvalue - b.eigenvalue).norm() <= EQUAL * a.eigenvalue.norm()
}
