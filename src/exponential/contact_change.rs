//! Changes of law: found on the motion within a step, and adopted at the instant at which they happen.

use super::contact_monitor::CandidateEvent;
use super::driver::Driver;
use super::jump::POINTS;
use super::step::Stepper;
use crate::integrate::{FirstOrderSystem as _, Halt, State, Statistics};

/// A change of law is found to this part of its step.
const RESOLUTION: f64 = 1e-12;
/// How much wider it is looked for around where it was foretold, after that has missed.
const WIDER: f64 = 64.0;
/// It has been found where the motion itself moves it by no more than this part.
const SAME: f64 = 1e-9;
/// It is moved by no more than this part.
const NEAR: f64 = 0.05;
/// Where the law of the motion itself is evaluated after the last change, as parts of the rest of the step.
const AFTER: [f64; 5] = [1e-4, 1e-3, 1e-2, 0.1, 0.5];
/// How often it is looked for.
const REFINEMENTS: usize = 6;

/// Where the law changes within a step: after so many whole ticks, at which elapsed time.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactChange {
    pub ticks: u64,
    pub at: f64,
}

impl Driver {
    /// The first change of law within the step just taken; the new laws are left in `found`.
    pub(super) fn locate(
        &mut self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &State,
    ) -> Result<Option<ContactChange>, Halt> {
        // Flanks that stay as they are change no law, and teeth that come and go smoothly none either.
        if !stepper.sharp && !self.unchanged.is_empty() && !self.unchanged.contains(&false) {
            return Ok(None);
        }
        if stepper.field.motion.motion_changes_contact_modes() {
            stepper.refresh(level);
        }
        let step = stepper.cache.time_grid.step(level);
        // Up to the change that was adopted last, the old law held.
        let since = state.elapsed + state.carry;
        self.contact_monitor.search(stepper, &self.unchanged);
        let (mut low, mut high): (f64, _) = ((state.carry / step).min(1.0), None);
        for index in 0..=self.contact_monitor.candidates.len() {
            // What comes and goes without a suspect has at the end.
            let candidate = self
                .contact_monitor
                .candidates
                .get(index)
                .copied()
                .unwrap_or(CandidateEvent { at: 1.0, phasors: false });
            if state.elapsed + candidate.at * step <= since {
                continue;
            }
            let changed = if candidate.phasors {
                self.changed_truly(stepper, level, state, candidate.at)?
            } else {
                self.changed(stepper, state, step, candidate.at)?
            };
            if changed {
                high = Some(candidate.at);
                break;
            }
            low = low.max(candidate.at);
        }
        self.off.fill(0.0);
        let Some(high) = high else {
            return Ok(None);
        };
        let begin = low;
        // Between the nodes the scalars are a polynomial that may be off; by how much, the motion itself tells, and the
        // change is looked for again, near by, on what is then right at the change.
        let mut change = self.narrow(stepper, state, step, (low, high))?;
        self.keep_contact_modes(stepper, state, step, change)?;
        let mut is_found = false;
        for _ in 0..REFINEMENTS {
            is_found = !stepper.field.motion.motion_changes_contact_modes() || change - begin <= SAME;
            if is_found {
                break;
            }
            let z = self.sample.within(stepper, level, &state.y, change * step);
            stepper.measure_off(change, state.elapsed + change * step, z, &mut self.point, &mut self.off);
            let near = ((change - NEAR).max(begin), (change + NEAR).min(1.0));
            if self.changed(stepper, state, step, near.0)? || !self.changed(stepper, state, step, near.1)? {
                break;
            }
            let again = self.narrow(stepper, state, step, near)?;
            if again + RESOLUTION >= near.1 {
                break;
            }
            let moved = again - change;
            change = again;
            self.keep_contact_modes(stepper, state, step, change)?;
            is_found = moved.abs() <= SAME;
            if is_found {
                break;
            }
        }
        if !is_found {
            // The polynomial is off by more than the scalars move near the change: only the motion itself tells.
            let Some(found) = self.bisect(stepper, level, state, (begin, high))? else {
                self.off.fill(0.0);
                return Ok(None);
            };
            change = found;
        }
        self.off.fill(0.0);
        self.found.clone_from(&self.after);
        // The last tick before it, of those that events use unless the step itself is shorter.
        let unit = self.time_grid.ticks(self.time_grid.part(level));
        let units = self.time_grid.ticks(level) / unit;
        let whole = ((change * units as f64).floor() as u64).min(units);
        Ok(Some(ContactChange { ticks: whole * unit, at: state.elapsed + change * step }))
    }

    /// The part of a step at which the law changes between two parts of it, or before, on the motion itself; the laws
    /// after it are left in `after`, and the polynomial meets the motion there. None if the motion keeps the law.
    ///
    /// At the beginning, touching flanks have a deflection of round-off, which shows any law. There the law counts on
    /// which two instants soon after agree; it holds from the beginning on.
    fn bisect(
        &mut self,
        stepper: &Stepper<'_>,
        level: usize,
        state: &State,
        (mut low, mut high): (f64, f64),
    ) -> Result<Option<f64>, Halt> {
        let step = stepper.cache.time_grid.step(level);
        if !self.changed_truly(stepper, level, state, high)? {
            high = 1.0;
            if !self.changed_truly(stepper, level, state, high)? {
                return Ok(None);
            }
        }
        if self.changed_truly(stepper, level, state, low)? {
            let begin = (state.carry / step).min(1.0);
            let (mut unchanged, mut seen) = (None, false);
            for part in AFTER {
                let at = begin + part * (high - begin);
                if !self.changed_truly(stepper, level, state, at)? {
                    unchanged = Some(at);
                } else if unchanged.is_some() {
                    high = at;
                    break;
                } else if seen && self.found == self.after {
                    return Ok(Some(begin));
                } else {
                    seen = true;
                    self.after.clone_from(&self.found);
                }
            }
            let Some(at) = unchanged else {
                return Ok(Some(begin));
            };
            low = at;
        }
        while high - low > RESOLUTION {
            let middle = (low + high) / 2.0;
            if self.changed_truly(stepper, level, state, middle)? { high = middle } else { low = middle }
        }
        self.changed_truly(stepper, level, state, high)?;
        self.after.clone_from(&self.found);
        Ok(Some(high))
    }

    /// Keeps the laws that hold after a part of a step, on the scalars on which it was found.
    fn keep_contact_modes(&mut self, stepper: &Stepper<'_>, state: &State, step: f64, part: f64) -> Result<(), Halt> {
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
        if stepper.field.motion.motion_changes_contact_modes() {
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
        stepper.field.contact_modes(state.elapsed + part * step, &self.point, &self.unchanged, &mut self.found)?;
        Ok(self.found != state.contact_modes)
    }

    /// The same on the motion itself; what the polynomial is off by there is kept.
    fn changed_truly(&mut self, stepper: &Stepper<'_>, level: usize, state: &State, part: f64) -> Result<bool, Halt> {
        let step = stepper.cache.time_grid.step(level);
        let z = self.sample.within(stepper, level, &state.y, part * step);
        stepper.measure_off(part, state.elapsed + part * step, z, &mut self.point, &mut self.off);
        self.changed(stepper, state, step, part)
    }

    /// Goes on to the last tick before a change of law, and lets the new law act from the change itself on.
    pub(super) fn switch(
        &mut self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &mut State,
        change: ContactChange,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        stepper.refresh(level);
        let within = self.time_grid.time(change.ticks);
        let step = stepper.cache.time_grid.step(level);
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
        state.contact_modes.clear();
        state.contact_modes.extend_from_slice(&self.found);
        stepper.field.motion.set_contact_modes(&state.contact_modes);
        // and under the one after it.
        for point in (0..POINTS).rev() {
            self.place(stepper, part(point));
            // Under it, the motion that meets the other at the change has come another way.
            let ahead = change.at - (state.elapsed + part(point) * step);
            stepper.path_correction(&self.jumps[POINTS - 1], ahead, &mut self.point);
            stepper.load_at(state.elapsed + part(point) * step, &self.point, &mut self.loads)?;
            statistics.evaluations += 1;
            for (jump, new) in self.jumps[point].iter_mut().zip(&self.loads) {
                *jump -= new;
            }
        }
        self.off.fill(0.0);
        std::mem::swap(&mut state.y, &mut stepper.after);
        stepper.apply_jump(since, &self.jumps, &mut state.y);
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
