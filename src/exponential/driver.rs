//! The loop over steps: levels chosen by error, steps that divide their time, and changes of law.

use super::Outcome;
use super::output::{Course, Output};
use super::sample::Sample;
use super::shift::POINTS;
use super::step::Stepper;
use crate::integrate::{Halt, Halted, Observer, PATIENCE, State, Statistics, System as _};

/// Ticks: the time of a run is a whole number of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// The longest step, s.
    pub longest: f64,
    /// How often it is halved at most: a tick is longest·2^−finest.
    pub finest: usize,
    /// How often it is halved for an event: what is left to it, no mode turns by a radian in.
    pub event: usize,
    /// How often it is halved at least unless all flanks that may part are firmly pressed.
    pub parting: usize,
}

impl Clock {
    /// A tick, s.
    pub fn tick(&self) -> f64 {
        self.longest * 0.5_f64.powi(self.finest as i32)
    }
}

/// How the length of a step is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
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

/// A longer step is tried where its error is foretold to be below this part of the tolerance.
const SAFETY: f64 = 0.5;
/// Loads are found to this part of the tolerance.
const SOLVED: f64 = 0.02;
/// Loads of fixed steps are found to this part of the motion.
const TIGHT: f64 = 1e-13;
/// A change of law is found to this part of its step.
const RESOLUTION: f64 = 1e-12;
/// How much wider it is looked for around where it was foretold, after that has missed.
const WIDER: f64 = 64.0;
/// It has been found where the motion itself moves it by no more than this part.
const SAME: f64 = 1e-9;
/// It is moved by no more than this part.
const NEAR: f64 = 0.05;
/// How often it is looked for.
const REFINEMENTS: usize = 6;
/// Changes of law at one tick before a step is taken as it is: grazing contacts would change them for ever.
const PATIENCE_AT_ONCE: u32 = 8;

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

/// Where the law changes within a step: after so many whole ticks, at which elapsed time.
#[derive(Clone, Copy, Debug)]
struct Change {
    ticks: u64,
    at: f64,
}

/// Integrates from `state` until `end` (elapsed time) and all the observer asks for; `state.y` is a state z.
///
/// # Errors
/// [`Halted`]; `state` is then the last good one.
pub fn run(
    (stepper, output): (&mut Stepper<'_>, &mut Output),
    (clock, control): (&Clock, &Control),
    state: &mut State,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halted> {
    let mut driver = Driver::new(stepper, *clock, *control, state);
    let outcome = driver.run(stepper, state, end, output, observer, statistics);
    outcome.map_err(|halt| Halted { halt, elapsed: state.elapsed })
}

struct Driver {
    clock: Clock,
    control: Control,
    /// Elapsed time that ticks count from: that of the run's beginning, unless it took up a state of another clock.
    base: f64,
    sample: Sample,
    /// The level that the error asks for.
    wanted: usize,
    found: Vec<i64>,
    point: Vec<f64>,
    /// What the polynomial of the scalars is off by near a change of law.
    off: Vec<f64>,
    jumps: [Vec<f64>; POINTS],
    loads: Vec<f64>,
    /// Where the ends of the paths of contact stand, at both ends of what is searched.
    ends: [Vec<(f64, i64)>; 2],
    /// The laws at the change that was found last.
    after: Vec<i64>,
    /// Changes of law since the last tick.
    at_once: u32,
    /// Energy norm of the state.
    size: f64,
}

impl Driver {
    fn new(stepper: &Stepper<'_>, clock: Clock, control: Control, state: &mut State) -> Self {
        let continues = |base: &f64| base + state.count as f64 * clock.tick() == state.elapsed;
        if !state.memory.first().is_some_and(continues) {
            // The state of another clock: ticks count from there.
            (state.count, state.next_step) = (0, 0.0);
            state.memory = vec![state.elapsed];
        }
        let base = state.memory[0];
        // The step to try is kept as its length; a power of two of the longest.
        let wanted = if state.next_step > 0.0 { (clock.longest / state.next_step).log2().round() as usize } else { 0 };
        Self {
            clock,
            control,
            base,
            sample: Sample::new(stepper),
            wanted: wanted.min(clock.finest),
            found: Vec::new(),
            point: vec![0.0; stepper.begin.len()],
            off: vec![0.0; stepper.begin.len()],
            jumps: std::array::from_fn(|_| vec![0.0; stepper.end_load.len()]),
            loads: vec![0.0; stepper.end_load.len()],
            ends: [Vec::new(), Vec::new()],
            after: Vec::new(),
            at_once: 0,
            size: stepper.size(&state.y),
        }
    }

    fn run(
        &mut self,
        stepper: &mut Stepper<'_>,
        state: &mut State,
        end: f64,
        output: &mut Output,
        observer: &mut impl Observer,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let switches = stepper.field.motion.switching().is_some();
        let mut looks = Statistics::new();
        if switches {
            stepper.look(state.elapsed, &state.y, &mut looks)?;
            if state.laws.is_empty() {
                stepper.field.laws(state.elapsed, &stepper.begin, &mut state.laws)?;
            }
            stepper.field.motion.set_laws(&state.laws);
        }
        stepper.look(state.elapsed, &state.y, &mut looks)?;
        statistics.begin(looks.evaluations);
        let mut read = |q: &mut [f64], v: &mut [f64]| output.read(&stepper.field, state.elapsed, &state.y, q, v);
        observer.switched(state.elapsed, &mut read, &state.laws);
        let mut asked = 0;
        while state.elapsed < end || observer.next().is_some() {
            // Between two changes at one tick nothing stops: the count of them is no part of the state.
            asked += u64::from(self.at_once == 0);
            if self.at_once == 0 && asked % PATIENCE == 1 && !observer.go_on(state.elapsed) {
                return Err(Halt::Interrupted);
            }
            let (level, error) = self.attempt(stepper, state, statistics)?;
            let step = stepper.table.levels[level].step;
            let ticks = self.to_grid(state.count, level);
            let held = ticks < self.ticks(level);
            let length = if held { ticks as f64 * self.clock.tick() } else { step };
            let change =
                if switches && self.at_once < PATIENCE_AT_ONCE { self.locate(stepper, level, state)? } else { None };
            let until = change.map_or(state.elapsed + length, |change| change.at);
            if observer.sees_every_step() || observer.next().is_some_and(|next| next <= until) {
                let reached = Reached { stepper, level, z: &state.y, begin: state.elapsed, end: until };
                let mut course = Course { reached, output, sample: &mut self.sample };
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
                    statistics.accept(change.ticks as f64 * self.clock.tick(), false);
                }
                continue;
            }
            self.at_once = 0;
            if held {
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

    /// Ticks in a step.
    fn ticks(&self, level: usize) -> u64 {
        1 << (self.clock.finest - level)
    }

    /// Ticks from `count` to the grid of a level, at least one and at most a step of it.
    fn to_grid(&self, count: u64, level: usize) -> u64 {
        let ticks = self.ticks(level);
        ticks - count % ticks
    }

    /// The step to try next, s.
    fn next_step(&self) -> f64 {
        self.clock.longest * 0.5_f64.powi(self.wanted as i32)
    }

    /// Elapsed time at a tick.
    fn at(&self, tick: u64) -> f64 {
        self.base + tick as f64 * self.clock.tick()
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
        if stepper.remembers() && ticks == self.ticks(level) {
            state.memory.extend_from_slice(&stepper.loads);
            state.memory.push(stepper.table.levels[level].step);
        }
    }

    /// The level of the step to try: the one wanted on its grid, or half of that to get there. What is further off its
    /// grid, as after an event, takes the step from where it is, and of it what leads to the grid; fixed steps get there
    /// by shorter ones.
    fn begin_with(&self, count: u64) -> usize {
        let aligned = if count == 0 { 0 } else { self.clock.finest.saturating_sub(count.trailing_zeros() as usize) };
        let far = aligned > self.wanted + 1 && !matches!(self.control, Control::Fixed);
        if far { self.wanted } else { self.wanted.max(aligned) }
    }

    /// Tries steps until one meets the tolerance; its level and scaled error.
    fn attempt(
        &mut self,
        stepper: &mut Stepper<'_>,
        state: &State,
        statistics: &mut Statistics,
    ) -> Result<(usize, f64), Halt> {
        let before = self.size;
        let firm = self.clock.parting == 0 || stepper.field.is_firm(state.elapsed, &stepper.begin)?;
        let mut level = self.begin_with(state.count).max(if firm { 0 } else { self.clock.parting });
        let mut rejected = false;
        loop {
            let solved = match self.control {
                Control::Fixed => TIGHT * before,
                Control::Adaptive { rtol, floor } => SOLVED * rtol * before.max(floor),
            };
            stepper.table.reach(stepper.linear, &stepper.ports, level);
            stepper.guess(level, &state.memory[1..]);
            let end = self.at(state.count + self.ticks(level));
            let outcome = match stepper.step(level, (state.elapsed, end), &state.y, solved, statistics) {
                // Loads that are only tried may close the centres further than the motion does.
                Err(Halt::Overlap { .. }) if level < self.clock.finest => Outcome::Unsolved,
                outcome => outcome?,
            };
            if outcome == Outcome::Solved {
                let after = stepper.size(&stepper.after);
                let (error, tolerance) = match self.control {
                    Control::Fixed => (0.0, f64::INFINITY),
                    Control::Adaptive { rtol, floor } => {
                        let tolerance = rtol * before.max(after).max(floor);
                        (stepper.error(level) / tolerance, tolerance)
                    }
                };
                if !after.is_finite() {
                    return Err(Halt::Diverged);
                }
                // Flanks that might have parted within a long step are watched closely over short ones.
                if level < self.clock.parting && !stepper.is_firm(level, state.elapsed)? {
                    statistics.rejected += 1;
                    rejected = true;
                    level = self.clock.parting;
                    continue;
                }
                // The shortest step is taken as it is: at a kink no step is short enough.
                if error <= 1.0 || level == self.clock.finest {
                    self.size = after;
                    if self.wanted == level && level > 0 && !rejected {
                        let foretold = stepper.error_of_longer(level) / tolerance;
                        self.wanted -= usize::from(foretold < SAFETY);
                    }
                    return Ok((level, error));
                }
            }
            statistics.rejected += 1;
            rejected = true;
            level += 1;
            if level > self.clock.finest {
                return Err(Halt::Diverged);
            }
            if !matches!(self.control, Control::Fixed) {
                self.wanted = self.wanted.max(level);
            }
        }
    }

    /// The first change of law within the step just taken; the new laws are left in `found`.
    fn locate(&mut self, stepper: &Stepper<'_>, level: usize, state: &State) -> Result<Option<Change>, Halt> {
        let step = stepper.table.levels[level].step;
        // Up to the change that was adopted last, the old law held.
        let since = state.elapsed + state.carry;
        let nodes = &stepper.table.rule.nodes;
        let looks = nodes.iter().copied().filter(|_| stepper.field.motion.parts()).chain([1.0]);
        let mut high = None;
        let mut low: f64 = (state.carry / step).min(1.0);
        for part in looks.filter(|part| state.elapsed + part * step > since) {
            if self.changed(stepper, state, step, part)? {
                high = Some(part);
                break;
            }
            low = low.max(part);
        }
        let Some(high) = high else {
            return Ok(None);
        };
        let begin = low;
        // Between the nodes the scalars are a polynomial that may be off; by how much, the motion itself tells, and the
        // change is looked for again, near by, on what is then right at the change.
        let mut change = self.narrow(stepper, state, step, (low, high))?;
        self.keep_laws(stepper, state, step, change)?;
        for _ in 0..REFINEMENTS {
            if !stepper.field.motion.moves_laws() || change - begin <= SAME {
                break;
            }
            let z = self.sample.within(stepper, level, &state.y, change * step);
            stepper.measure_off(change, state.elapsed + change * step, z, &mut self.point, &mut self.off);
            let near = ((change - NEAR).max(begin), (change + NEAR).min(1.0));
            if self.changed(stepper, state, step, near.0)? || !self.changed(stepper, state, step, near.1)? {
                break;
            }
            let again = self.narrow(stepper, state, step, near)?;
            // Where only the end of the bracket holds, the change stays where it was found.
            let moved = again - change;
            if again + RESOLUTION >= near.1 {
                break;
            }
            change = again;
            self.keep_laws(stepper, state, step, change)?;
            if moved.abs() <= SAME {
                break;
            }
        }
        self.off.fill(0.0);
        self.found.clone_from(&self.after);
        // The last tick before it, of those that events use unless the step itself is shorter.
        let unit = self.ticks(level.max(self.clock.event));
        let units = self.ticks(level) / unit;
        let whole = ((change * units as f64).floor() as u64).min(units);
        Ok(Some(Change { ticks: whole * unit, at: state.elapsed + change * step }))
    }

    /// Keeps the laws that hold after a part of a step, on the scalars on which it was found.
    fn keep_laws(&mut self, stepper: &Stepper<'_>, state: &State, step: f64, part: f64) -> Result<(), Halt> {
        self.changed(stepper, state, step, part)?;
        self.after.clone_from(&self.found);
        Ok(())
    }

    /// The part of a step at which the law changes between two parts of it, which hold the old and the new one.
    fn narrow(
        &mut self,
        stepper: &Stepper<'_>,
        state: &State,
        step: f64,
        (mut low, mut high): (f64, f64),
    ) -> Result<f64, Halt> {
        // Teeth travel at nearly even pace, so where the next one comes or goes is nearly foretold; closely around it the
        // law is asked for, less closely where that has missed. Whether flanks press is not foretold.
        let (mut apart, mut foretold) = (RESOLUTION / 2.0, true);
        while high - low > RESOLUTION {
            let at = if foretold { self.foretell(stepper, state, step, (low, high))? } else { None };
            let Some(at) = at else {
                foretold = false;
                let middle = (low + high) / 2.0;
                if self.changed(stepper, state, step, middle)? {
                    high = middle
                } else {
                    low = middle
                }
                continue;
            };
            for probe in [at - apart, at + apart] {
                if low < probe && probe < high {
                    if self.changed(stepper, state, step, probe)? { high = probe } else { low = probe }
                }
            }
            apart *= WIDER;
            foretold = apart < NEAR;
        }
        Ok(high)
    }

    /// The part of a step at which the first pair of teeth comes or goes between two parts of it, at even pace.
    fn foretell(
        &mut self,
        stepper: &Stepper<'_>,
        state: &State,
        step: f64,
        (low, high): (f64, f64),
    ) -> Result<Option<f64>, Halt> {
        for (which, part) in [low, high].into_iter().enumerate() {
            self.move_to(stepper, part);
            stepper.field.ends(state.elapsed + part * step, &self.point, &mut self.ends[which])?;
        }
        let [from, to] = &self.ends;
        let mut first: Option<f64> = None;
        for (which, ((from, _), (to, pair))) in from.iter().zip(to).enumerate() {
            // The first pair is the least whole number not below where the path begins; the last the greatest not above
            // where it ends.
            let (found, beyond) = match (which % 2 == 0, to > from) {
                (true, true) => (to.ceil(), 0.0),
                (true, false) => (to.ceil(), -1.0),
                (false, true) => (to.floor(), 1.0),
                (false, false) => (to.floor(), 0.0),
            };
            let pair = *pair as f64;
            if found != pair {
                let at = low + (high - low) * ((pair + beyond - from) / (to - from)).clamp(0.0, 1.0);
                first = Some(first.map_or(at, |first| first.min(at)));
            }
        }
        Ok(first)
    }

    /// Scalars and rates at a part of a step, where the laws depend on the motion.
    fn move_to(&mut self, stepper: &Stepper<'_>, part: f64) {
        // Where teeth are that come and go with time alone, the motion need not be asked.
        if stepper.field.motion.moves_laws() {
            self.place(stepper, part);
        }
    }

    /// Scalars and rates at a part of a step: the polynomial, with what it is off by near a change of law.
    fn place(&mut self, stepper: &Stepper<'_>, part: f64) {
        stepper.interpolate(part, &mut self.point);
        for (point, off) in self.point.iter_mut().zip(&self.off) {
            *point += off;
        }
    }

    /// Whether other laws hold after a part of a step; they are left in `found`.
    fn changed(&mut self, stepper: &Stepper<'_>, state: &State, step: f64, part: f64) -> Result<bool, Halt> {
        self.move_to(stepper, part);
        stepper.field.laws(state.elapsed + part * step, &self.point, &mut self.found)?;
        Ok(self.found != state.laws)
    }

    /// Goes on to the last tick before a change of law, and lets the new law act from the change itself on.
    fn switch(
        &mut self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &mut State,
        change: Change,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let tick = self.clock.tick();
        let within = change.ticks as f64 * tick;
        let step = stepper.table.levels[level].step;
        let reached = self.at(state.count + change.ticks);
        let since = change.at - reached;
        let at_tick = self.sample.within(stepper, level, &state.y, within);
        stepper.after.copy_from_slice(at_tick);
        // What the polynomial of the scalars is off by there.
        stepper.measure_off(within / step, reached, &stepper.after, &mut self.point, &mut self.off);
        // What the loads change by, from the tick to the change: under the law before,
        let part = |point: usize| (within + since * point as f64 / (POINTS - 1) as f64) / step;
        for (point, jump) in self.jumps.iter_mut().enumerate() {
            stepper.loads_at(part(point), jump);
        }
        state.laws.clear();
        state.laws.extend_from_slice(&self.found);
        stepper.field.motion.set_laws(&state.laws);
        // and under the one after it.
        for point in (0..POINTS).rev() {
            self.place(stepper, part(point));
            // Under it, the motion that meets the other at the change has come another way.
            let ahead = change.at - (state.elapsed + part(point) * step);
            stepper.depart(&self.jumps[POINTS - 1], ahead, &mut self.point);
            stepper.load_at(state.elapsed + part(point) * step, &self.point, &mut self.loads)?;
            statistics.evaluations += 1;
            for (jump, new) in self.jumps[point].iter_mut().zip(&self.loads) {
                *jump -= new;
            }
        }
        self.off.fill(0.0);
        std::mem::swap(&mut state.y, &mut stepper.after);
        stepper.shift(since, &self.jumps, &mut state.y);
        state.count += change.ticks;
        state.elapsed = reached;
        state.carry = since;
        // What the step that was cut short has shown of its error holds for those to come.
        state.next_step = self.next_step();
        state.memory.truncate(1);
        statistics.events += 1;
        self.at_once = if change.ticks == 0 { self.at_once + 1 } else { 0 };
        stepper.look(state.elapsed, &state.y, statistics)?;
        self.size = stepper.size(&state.y);
        Ok(())
    }
}
