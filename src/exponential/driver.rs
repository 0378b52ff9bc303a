//! The loop over steps: levels chosen by error, steps that divide their time, and changes of law.

use std::f64::consts::TAU;

use super::Outcome;
use super::contact_monitor::ContactMonitor;
use super::jump::POINTS;
use super::output::{OutputMap, StepTrajectory};
use super::step::Stepper;
use super::substep::SubstepSampler;
use super::time_grid::TimeGrid;
use crate::integrate::{CHECK_INTERVAL, FirstOrderSystem as _, Halt, Halted, Observer, State, Statistics};

/// How the length of a step is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelControl {
    /// The longest always.
    Fixed,
    /// As long as the error allows.
    Adaptive {
        /// Error of a step, relative to the size of the motion.
        rtol: f64,
        /// The smallest size that a tolerance is relative to.
        floor: f64,
    },
}

/// A longer step is tried where its error is foretold to be below this part of the tolerance: one that is not met costs
/// more than the shorter ones would have.
const SAFETY: f64 = 0.25;
/// Halvings at once of a step whose error is too large: of steps much shorter it says nothing.
const HALVINGS: usize = 4;
/// Loads are found to this part of the tolerance, those that are the whole of what meshes do more closely,
const SOLVED: f64 = 0.03;
const SOLVED_WHOLE: f64 = 0.01;
/// or of this tolerance, where the one asked for is looser: collocation is stable whatever its steps, loads that are
/// half found are not.
const LOOSEST: f64 = 1e-3;
/// Steps in a period of teeth that swing on their stiffness alone, while their flanks may part: the motion within a step
/// is less exact than that at its end, and flanks part and meet within steps.
const STEPS_A_SWING: f64 = 3.0;
/// Loads of fixed steps are found to this part of the motion.
const TIGHT: f64 = 1e-13;
/// Changes of law at one tick before a step is taken as it is: grazing contacts would change them for ever.
const MAX_CHANGES_AT_ONCE: u32 = 8;

/// A step that was taken.
#[derive(Clone, Copy)]
pub(super) struct Reached<'a, 'm> {
    pub stepper: &'a Stepper<'m>,
    pub level: usize,
    /// The state at its beginning.
    pub z: &'a [f64],
    /// Elapsed time at its beginning, and up to which it holds.
    pub begin: f64,
    pub end: f64,
}

/// Integrates from `state` until `end` (elapsed time) and all the observer asks for; `state.y` is a state z.
///
/// # Errors
/// [`Halted`]; `state` is then the last good one.
pub fn run(
    (stepper, output): (&mut Stepper<'_>, &mut OutputMap),
    control: LevelControl,
    state: &mut State,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halted> {
    let mut driver = Driver::new(stepper, control, state);
    let outcome = driver.run(stepper, state, end, output, observer, statistics);
    outcome.map_err(|halt| Halted { halt, elapsed: state.elapsed })
}

pub(super) struct Driver {
    pub(super) time_grid: TimeGrid,
    control: LevelControl,
    /// Elapsed time that ticks count from: that of the run's beginning, unless it took up a state of another clock.
    pub(super) base: f64,
    pub(super) sample: SubstepSampler,
    /// The level that the error asks for.
    wanted: usize,
    pub(super) found: Vec<i64>,
    pub(super) point: Vec<f64>,
    /// What the polynomial of the scalars is off by near a change of law.
    pub(super) off: Vec<f64>,
    pub(super) jumps: [Vec<f64>; POINTS],
    pub(super) loads: Vec<f64>,
    /// Where the ends of the paths of contact stand, at both ends of what is searched.
    pub(super) ends: [Vec<(f64, i64)>; 2],
    /// The laws at the change that was found last.
    pub(super) after: Vec<i64>,
    /// Whether the flanks of each mesh stay as they are over the step.
    pub(super) unchanged: Vec<bool>,
    /// Where they may part or meet within it.
    pub(super) contact_monitor: ContactMonitor,
    /// Changes of law since the last tick.
    pub(super) at_once: u32,
    /// Energy norm of the state.
    pub(super) size: f64,
}

impl Driver {
    fn new(stepper: &Stepper<'_>, control: LevelControl, state: &mut State) -> Self {
        let time_grid = stepper.cache.time_grid;
        let continues = |base: &f64| base + time_grid.time(state.count) == state.elapsed;
        if !state.memory.first().is_some_and(continues) {
            // The state of another clock: ticks count from there.
            (state.count, state.next_step) = (0, 0.0);
            state.memory = vec![state.elapsed];
        }
        let base = state.memory[0];
        // The step to try is kept as its length.
        let wanted = if state.next_step > 0.0 { time_grid.level_of(state.next_step) } else { 0 };
        Self {
            time_grid,
            control,
            base,
            sample: SubstepSampler::new(stepper),
            wanted,
            found: Vec::new(),
            point: vec![0.0; stepper.begin.len()],
            off: vec![0.0; stepper.begin.len()],
            jumps: std::array::from_fn(|_| vec![0.0; stepper.end_load.len()]),
            loads: vec![0.0; stepper.end_load.len()],
            ends: [Vec::new(), Vec::new()],
            after: Vec::new(),
            unchanged: Vec::new(),
            contact_monitor: ContactMonitor::new(&stepper.cache.rule, stepper.field.meshes()),
            at_once: 0,
            size: 0.0,
        }
    }

    fn run(
        &mut self,
        stepper: &mut Stepper<'_>,
        state: &mut State,
        end: f64,
        output: &mut OutputMap,
        observer: &mut impl Observer,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let switches = stepper.field.motion.switching().is_some();
        let mut looks = Statistics::new();
        if switches {
            stepper.look(state.elapsed, &state.y, &mut looks)?;
            if state.contact_modes.is_empty() {
                stepper.field.contact_modes(state.elapsed, &stepper.begin, &[], &mut state.contact_modes)?;
            }
            stepper.field.motion.set_contact_modes(&state.contact_modes);
        }
        stepper.look(state.elapsed, &state.y, &mut looks)?;
        self.size = stepper.size(&state.y);
        statistics.begin(looks.evaluations);
        let mut read = |q: &mut [f64], v: &mut [f64]| output.read(&stepper.field, state.elapsed, &state.y, q, v);
        observer.switched(state.elapsed, &mut read, &state.contact_modes);
        let mut asked = 0;
        while state.elapsed < end || observer.next().is_some() {
            // Between two changes at one tick nothing stops: the count of them is no part of the state.
            asked += u64::from(self.at_once == 0);
            if self.at_once == 0 && asked % CHECK_INTERVAL == 1 && !observer.go_on(state.elapsed) {
                return Err(Halt::Interrupted);
            }
            let (level, error) = self.attempt(stepper, state, statistics)?;
            let ticks = self.to_grid(state.count, level);
            let length = self.time_grid.time(ticks);
            let change =
                if switches && self.at_once < MAX_CHANGES_AT_ONCE { self.locate(stepper, level, state)? } else { None };
            let until = change.map_or(state.elapsed + length, |change| change.at);
            let kept = change.map_or(ticks, |change| change.ticks);
            if kept < self.time_grid.ticks(level) && self.is_off(stepper, level, state, kept, statistics)? {
                statistics.rejected += 1;
                self.wanted = level + 1;
                continue;
            }
            if observer.sees_every_step() || observer.next().is_some_and(|next| next <= until) {
                let reached = Reached { stepper, level, z: &state.y, begin: state.elapsed, end: until };
                let mut course = StepTrajectory { reached, output, sample: &mut self.sample };
                observer.observe(&mut course, until)?;
            }
            if until > end {
                break;
            }
            let at_limit = level == 0;
            if let Some(change) = change {
                // The observer may look at the change itself, under either law the same.
                let (sample, found) = (&mut self.sample, &self.found);
                let mut read = |q: &mut [f64], v: &mut [f64]| {
                    let z = sample.within(stepper, level, &state.y, change.at - state.elapsed);
                    output.read(&stepper.field, change.at, z, q, v);
                };
                observer.switched(change.at, &mut read, found);
                self.switch(stepper, level, state, change, statistics)?;
                if change.ticks > 0 {
                    statistics.accept(self.time_grid.time(change.ticks), false);
                }
                continue;
            }
            self.at_once = 0;
            if ticks < self.time_grid.ticks(level) {
                // The loads of a whole step tell the motion at the grid within it.
                let at_grid = self.sample.within(stepper, level, &state.y, length);
                stepper.after.copy_from_slice(at_grid);
                stepper.look_ahead(self.at(state.count + ticks), statistics)?;
                self.size = stepper.size(&stepper.after);
            }
            self.commit(stepper, state, level, ticks, error);
            statistics.accept(length, at_limit);
        }
        Ok(())
    }

    /// Whether the loads after so many ticks, all that is kept of a step, are not those of its polynomial to within the
    /// tolerance: that is less exact than the end of the step. From there to a change of law no mode turns by a radian.
    fn is_off(
        &mut self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &State,
        ticks: u64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let LevelControl::Adaptive { rtol, floor } = self.control else {
            return Ok(false);
        };
        if level == self.time_grid.finest || ticks == 0 {
            return Ok(false);
        }
        let within = self.time_grid.time(ticks);
        let z = self.sample.within(stepper, level, &state.y, within);
        let room = [&mut self.loads[..], &mut self.jumps[0][..]];
        let at = state.elapsed + within;
        let defect = stepper.defect_at(within / self.time_grid.step(level), at, z, &mut self.point, room)?;
        statistics.evaluations += 1;
        Ok(within * defect > rtol * self.size.max(floor))
    }

    /// Ticks from `count` to the grid of a level, at least one and at most a step of it.
    fn to_grid(&self, count: u64, level: usize) -> u64 {
        let ticks = self.time_grid.ticks(level);
        ticks - count % ticks
    }

    /// The step to try next, s.
    pub(super) fn next_step(&self) -> f64 {
        self.time_grid.step(self.wanted)
    }

    /// Elapsed time at a tick.
    pub(super) fn at(&self, tick: u64) -> f64 {
        self.base + self.time_grid.time(tick)
    }

    /// Takes the end of the step, after so many ticks of it, as the beginning of the next.
    fn commit(&mut self, stepper: &mut Stepper<'_>, state: &mut State, level: usize, ticks: u64, error: f64) {
        stepper.commit(&mut state.y);
        state.count += ticks;
        let before = state.elapsed;
        state.elapsed = self.at(state.count);
        // An event that the law's change lies ahead of counts until it is passed.
        state.carry = (before + state.carry - state.elapsed).max(0.0);
        state.previous_error = error;
        state.next_step = self.next_step();
        state.memory.truncate(1);
        if stepper.remembers() && ticks == self.time_grid.ticks(level) {
            state.memory.extend_from_slice(&stepper.evaluated_loads);
            state.memory.extend_from_slice(&stepper.nodes);
            state.memory.extend_from_slice(&stepper.tangent_solver.residual_tangent);
            state.memory.extend([self.time_grid.step(level), stepper.contraction]);
        }
    }

    /// The level of a step from `count` ticks on that is no longer than one of `level`: on its own grid, if one to half
    /// as long is. What is further off, as after an event, takes the step from where it is, and of it what leads to the
    /// grid; fixed steps get there by shorter ones.
    fn fitting(&self, count: u64, level: usize) -> usize {
        let shortest = match self.control {
            LevelControl::Fixed => self.time_grid.finest,
            LevelControl::Adaptive { .. } => (level + 1).min(self.time_grid.finest),
        };
        (level..=shortest).find(|level| count.is_multiple_of(self.time_grid.ticks(*level))).unwrap_or(level)
    }

    /// The level of the longest step that follows teeth whose flanks may part and that swing at so many rad/s.
    fn of_swing(&self, swing: f64) -> usize {
        if matches!(self.control, LevelControl::Fixed) {
            0
        } else {
            self.time_grid.level_of(TAU / (STEPS_A_SWING * swing))
        }
    }

    /// Tries steps until one meets the tolerance; its level and scaled error.
    fn attempt(
        &mut self,
        stepper: &mut Stepper<'_>,
        state: &State,
        statistics: &mut Statistics,
    ) -> Result<(usize, f64), Halt> {
        let before = self.size;
        let begin = self.wanted.max(self.of_swing(stepper.swing_at_begin()));
        let mut level = self.fitting(state.count, begin);
        let mut rejected = false;
        loop {
            let solved = match self.control {
                LevelControl::Fixed => TIGHT * before,
                LevelControl::Adaptive { rtol, floor } => {
                    let part = if stepper.cache.linear.meshed { SOLVED } else { SOLVED_WHOLE };
                    part * rtol.min(LOOSEST) * before.max(floor)
                }
            };
            stepper.guess(level, &state.memory[1..]);
            let end = self.at(state.count + self.time_grid.ticks(level));
            let outcome = match stepper.step(level, (state.elapsed, end), &state.y, solved, statistics) {
                // Loads that are only tried may close the centres further than the motion does.
                Err(Halt::Overlap { .. }) if level < self.time_grid.finest => Outcome::Unsolved,
                outcome => outcome?,
            };
            let shorter = if outcome == Outcome::Solved {
                let after = stepper.size(&stepper.after);
                let (error, tolerance) = match self.control {
                    LevelControl::Fixed => (0.0, f64::INFINITY),
                    LevelControl::Adaptive { rtol, floor } => {
                        let tolerance = rtol * before.max(after).max(floor);
                        (stepper.error(level) / tolerance, tolerance)
                    }
                };
                if !after.is_finite() {
                    return Err(Halt::Diverged);
                }
                // Teeth that turned out to swing within a long step are followed over short ones.
                let swing = stepper.settle(level, &mut self.unchanged);
                let bound = self.of_swing(swing);
                if level + 1 < bound {
                    statistics.rejected += 1;
                    rejected = true;
                    level = self.fitting(state.count, bound);
                    continue;
                }
                // The shortest step is taken as it is: at a kink no step is short enough.
                if error <= 1.0 || level == self.time_grid.finest {
                    self.size = after;
                    if self.wanted == level && level > 0 && !rejected {
                        let foretold = stepper.error_of_longer(level) / tolerance;
                        self.wanted -= usize::from(foretold < SAFETY);
                    }
                    return Ok((level, error));
                }
                // Were it smooth, the error of so much a shorter step would be what is asked for.
                let smooth = error.powf(-0.5 / stepper.cache.rule.stages() as f64);
                let shorter = self.time_grid.level_of(self.time_grid.step(level) * smooth);
                shorter.clamp(level + 1, level + HALVINGS).min(self.time_grid.finest)
            } else if level == self.time_grid.finest {
                return Err(Halt::Diverged);
            } else {
                level + 1
            };
            statistics.rejected += 1;
            rejected = true;
            if !matches!(self.control, LevelControl::Fixed) {
                self.wanted = self.wanted.max(shorter);
            }
            level = self.fitting(state.count, shorter);
        }
    }
}
