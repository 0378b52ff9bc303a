//! Contact changes within a step: location of the instant, and the jump of the loads.
//!
//! This locator differs from `integrate::RungeKuttaEventLocator`, which bisects on the polynomial through both ends of a short step and
//! repeats the step up to the change. Steps of the exponential method are long and end at units of the time grid only:
//! the search starts from the margins of the flanks, the polynomial is corrected by its difference to the motion, and
//! the new contact mode acts from the change on through a jump of the loads.

use super::contact_monitor::{CandidateEvent, ContactMonitor};
use super::context::StepInstant;
use super::jump::POINTS;
use super::step::{DefectScratch, Stepper};
use super::substep::SubstepSampler;
use super::trajectory::CompletedStep;
use crate::integrate::{FirstOrderSystem as _, Halt, State, Statistics};
use crate::numerics::bisect;

/// The instant is located to this fraction of the step.
const RESOLUTION: f64 = 1e-12;
/// Factor by which the bracket around a predicted instant widens after it has missed the change.
const WIDENING: f64 = 64.0;
/// Half width of the bracket, as a fraction of the step, above which bisection takes over.
const MAX_BRACKET: f64 = 0.05;
/// A correction of the polynomial may move the instant by this fraction of the step.
const MAX_SHIFT: f64 = 0.05;
/// The instant is final if a correction moves it by no more than this fraction of the step.
const FINAL_SHIFT: f64 = 1e-9;
/// Points, as fractions of the rest of the step, at which the motion after the previous change is evaluated.
const POINTS_AFTER_CHANGE: [f64; 5] = [1e-4, 1e-3, 1e-2, 0.1, 0.5];
/// Largest number of corrections of the polynomial.
const MAX_CORRECTIONS: usize = 6;

/// A contact change within a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactChange {
    /// Whole units from the beginning of the step to the last unit before the change.
    pub units: u64,
    /// Elapsed time of the change, s.
    pub at: f64,
}

/// Locates contact changes within a completed step.
pub(super) struct ExponentialEventLocator {
    /// Contact modes at the fraction of the step that was evaluated last, as integer codes.
    pub new_contact_modes: Vec<i64>,
    /// Contact modes after the change that was located last.
    modes_after_change: Vec<i64>,
    /// For each connection whether its flank contact is unchanged over the step; empty if no flanks can separate.
    pub unchanged: Vec<bool>,
    /// Interface state minus its polynomial, near the change.
    interpolation_error: Vec<f64>,
    monitor: ContactMonitor,
    /// Scratch: an interface state and loads.
    interface_state: Vec<f64>,
    loads: Vec<f64>,
    /// Scratch: positions of the ends of the paths of contact, in tooth pairs, with the first or last pair in contact, at
    /// both ends of the bracket.
    path_ends: [Vec<(f64, i64)>; 2],
    /// Scratch: old loads minus new loads over the time from the unit to the change.
    jumps: [Vec<f64>; POINTS],
}

impl ExponentialEventLocator {
    /// Allocates the locator.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let (load_count, len) = (stepper.loads().load_count(), stepper.loads().interface_len());
        Self {
            new_contact_modes: Vec::new(),
            modes_after_change: Vec::new(),
            unchanged: Vec::new(),
            interpolation_error: vec![0.0; len],
            monitor: ContactMonitor::new(&stepper.context.cache.rule, stepper.loads().connection_count()),
            interface_state: vec![0.0; len],
            loads: vec![0.0; load_count],
            path_ends: [Vec::new(), Vec::new()],
            jumps: std::array::from_fn(|_| vec![0.0; load_count]),
        }
    }

    /// Scratch for [`Stepper::defect_at`].
    pub fn scratch(&mut self) -> DefectScratch<'_> {
        DefectScratch {
            interface_state: &mut self.interface_state,
            loads: &mut self.loads,
            interpolated: &mut self.jumps[0],
        }
    }

    /// Whether a contact change is possible within the last step: not if flank contact is unchanged and tooth pairs
    /// engage smoothly.
    pub fn is_possible(&self, stepper: &Stepper<'_>) -> bool {
        stepper.sharp || self.unchanged.is_empty() || self.unchanged.contains(&false)
    }

    /// Finds the first contact change within the last step, from `pending` seconds after its beginning on. Up to there
    /// the previous contact mode held. The new modes are left in [`Self::new_contact_modes`].
    pub fn locate(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        pending: f64,
    ) -> Result<Option<ContactChange>, Halt> {
        let bracket = self.bracket(step, sampler, pending)?;
        self.interpolation_error.fill(0.0);
        let Some((begin, high)) = bracket else {
            return Ok(None);
        };
        let change = match self.correct(step, sampler, (begin, high))? {
            Some(change) => Some(change),
            // The polynomial differs from the motion by more than the motion near the change, or flanks touch at the beginning.
            None => self.bisect(step, sampler, pending, (begin, high))?,
        };
        self.interpolation_error.fill(0.0);
        let Some(change) = change else {
            return Ok(None);
        };
        self.new_contact_modes.clone_from(&self.modes_after_change);
        let time_grid = &step.stepper.context.cache.time_grid;
        let substep = time_grid.units(time_grid.substep_level(step.level));
        let substeps = time_grid.units(step.level) / substep;
        let whole = ((change * substeps as f64).floor() as u64).min(substeps);
        Ok(Some(ContactChange { units: whole * substep, at: step.time(change) }))
    }

    /// Finds two fractions of the step with the old and with a new contact mode, at the candidates and at the end.
    fn bracket(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        pending: f64,
    ) -> Result<Option<(f64, f64)>, Halt> {
        let since = step.begin + pending;
        let mut low = (pending / step.length()).min(1.0);
        self.monitor.search(step.stepper, &self.unchanged, low);
        for index in 0..=self.monitor.candidates.len() {
            let end = CandidateEvent { at: 1.0, is_minimum: false };
            let candidate = self.monitor.candidates.get(index).copied().unwrap_or(end);
            if step.time(candidate.at) <= since {
                continue;
            }
            let differs = if candidate.is_minimum {
                self.differs_on_motion(step, sampler, candidate.at)?
            } else {
                self.differs(step, candidate.at)?
            };
            if differs {
                return Ok(Some((low, candidate.at)));
            }
            low = low.max(candidate.at);
        }
        Ok(None)
    }

    /// Locates the change on the polynomial of the interface state, corrects the polynomial by its difference to the
    /// motion at the change, and repeats until the instant is final. Returns the fraction of the step, or none if the
    /// corrections do not converge or the change is at the beginning.
    fn correct(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        (begin, high): (f64, f64),
    ) -> Result<Option<f64>, Halt> {
        let mut change = self.narrow(step, (begin, high))?;
        self.keep_modes(step, change)?;
        for _ in 0..MAX_CORRECTIONS {
            if !step.stepper.loads().motion.motion_changes_contact_modes() {
                return Ok(Some(change));
            }
            // Round-off may decide on the contact modes so close to the beginning.
            if change - begin <= FINAL_SHIFT {
                return Ok(None);
            }
            self.measure_error(step, sampler, change);
            let near = ((change - MAX_SHIFT).max(begin), (change + MAX_SHIFT).min(1.0));
            if self.differs(step, near.0)? || !self.differs(step, near.1)? {
                return Ok(None);
            }
            let corrected = self.narrow(step, near)?;
            if corrected + RESOLUTION >= near.1 {
                return Ok(None);
            }
            let shift = corrected - change;
            change = corrected;
            self.keep_modes(step, change)?;
            if shift.abs() <= FINAL_SHIFT {
                return Ok(Some(change));
            }
        }
        Ok(None)
    }

    /// Bisects on the motion itself between two fractions of the step. The modes after the change are left in
    /// `modes_after_change`, and the corrected polynomial meets the motion there. None if the motion has no change.
    fn bisect(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        pending: f64,
        (mut low, mut high): (f64, f64),
    ) -> Result<Option<f64>, Halt> {
        if !self.differs_on_motion(step, sampler, high)? {
            high = 1.0;
            if !self.differs_on_motion(step, sampler, high)? {
                return Ok(None);
            }
        }
        let begin = (pending / step.length()).min(1.0);
        if low <= begin || self.differs_on_motion(step, sampler, low)? {
            match self.first_unchanged(step, sampler, (begin, &mut high))? {
                Some(unchanged) => low = unchanged,
                None => return Ok(Some(begin)),
            }
        }
        let [_, high] = bisect(low, high, RESOLUTION, |middle| self.differs_on_motion(step, sampler, middle))?;
        self.differs_on_motion(step, sampler, high)?;
        self.modes_after_change.clone_from(&self.new_contact_modes);
        Ok(Some(high))
    }

    /// Finds a fraction of the step after `begin` with the old contact modes, and moves `high` to a change after it.
    ///
    /// At the previous change, touching flanks have a deflection of round-off, and any contact mode can result. There the
    /// modes on which two instants soon after agree hold from the beginning on, and the result is none.
    fn first_unchanged(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        (begin, high): (f64, &mut f64),
    ) -> Result<Option<f64>, Halt> {
        let (mut unchanged, mut has_differed) = (None, false);
        let end = *high;
        for fraction in POINTS_AFTER_CHANGE {
            let at = begin + fraction * (end - begin);
            if !self.differs_on_motion(step, sampler, at)? {
                unchanged = Some(at);
            } else if unchanged.is_some() {
                *high = at;
                break;
            } else if has_differed && self.new_contact_modes == self.modes_after_change {
                return Ok(None);
            } else {
                has_differed = true;
                self.modes_after_change.clone_from(&self.new_contact_modes);
            }
        }
        Ok(unchanged)
    }

    /// Stores the contact modes at a fraction of the step as those after the change.
    fn keep_modes(&mut self, step: &CompletedStep<'_, '_>, part: f64) -> Result<(), Halt> {
        self.differs(step, part)?;
        self.modes_after_change.clone_from(&self.new_contact_modes);
        Ok(())
    }

    /// Narrows a bracket with the old contact mode at its lower and a new one at its upper end. Returns the upper end.
    fn narrow(&mut self, step: &CompletedStep<'_, '_>, (mut low, mut high): (f64, f64)) -> Result<f64, Halt> {
        // The ends of the path of contact move almost uniformly, so that an engagement can be predicted. The contact mode
        // is evaluated close to both sides of the prediction, further away after each miss. A change of the flanks is not
        // predicted.
        let (mut half_width, mut predicts) = (RESOLUTION / 2.0, true);
        while high - low > RESOLUTION {
            let predicted = if predicts { self.predict_engagement(step, (low, high))? } else { None };
            let Some(at) = predicted else {
                predicts = false;
                let middle = (low + high) / 2.0;
                if self.differs(step, middle)? {
                    high = middle
                } else {
                    low = middle
                }
                continue;
            };
            for probe in [at - half_width, at + half_width] {
                if low < probe && probe < high {
                    if self.differs(step, probe)? { high = probe } else { low = probe }
                }
            }
            half_width *= WIDENING;
            predicts = half_width < MAX_BRACKET;
        }
        Ok(high)
    }

    /// Predicts the fraction of the step at which the first tooth pair enters or leaves contact in a bracket, if the ends
    /// of the path of contact move uniformly.
    fn predict_engagement(
        &mut self,
        step: &CompletedStep<'_, '_>,
        (low, high): (f64, f64),
    ) -> Result<Option<f64>, Halt> {
        for (end, part) in [low, high].into_iter().enumerate() {
            self.move_to(step.stepper, part);
            let loads = step.stepper.loads();
            loads.path_ends(step.time(part), &self.interface_state, &mut self.path_ends[end])?;
        }
        let [from, to] = &self.path_ends;
        let mut first: Option<f64> = None;
        for (index, ((from, _), (to, pair))) in from.iter().zip(to).enumerate() {
            // The first pair in contact is the smallest integer not below the begin of the path, the last pair the largest
            // integer not above its end.
            let (new_pair, crossed) = match (index % 2 == 0, to > from) {
                (true, true) => (to.ceil(), 0.0),
                (true, false) => (to.ceil(), -1.0),
                (false, true) => (to.floor(), 1.0),
                (false, false) => (to.floor(), 0.0),
            };
            let pair = *pair as f64;
            if new_pair != pair {
                let at = low + (high - low) * ((pair + crossed - from) / (to - from)).clamp(0.0, 1.0);
                first = Some(first.map_or(at, |first| first.min(at)));
            }
        }
        Ok(first)
    }

    /// Interpolates the interface state at a fraction of the step, if contact modes depend on the motion.
    fn move_to(&mut self, stepper: &Stepper<'_>, part: f64) {
        if stepper.loads().motion.motion_changes_contact_modes() {
            self.interpolate(stepper, part);
        }
    }

    /// Interpolates the interface state at a fraction of the step by the corrected polynomial.
    fn interpolate(&mut self, stepper: &Stepper<'_>, part: f64) {
        stepper.interpolate(part, &mut self.interface_state);
        for (value, error) in self.interface_state.iter_mut().zip(&self.interpolation_error) {
            *value += error;
        }
    }

    /// Measures the difference between the motion and the polynomial at a fraction of the step.
    fn measure_error(&mut self, step: &CompletedStep<'_, '_>, sampler: &mut SubstepSampler, part: f64) {
        let z = step.state_at(sampler, part * step.length());
        let at = StepInstant { part, elapsed: step.time(part) };
        step.stepper.interpolation_error(at, z, &mut self.interface_state, &mut self.interpolation_error);
    }

    /// Whether the contact modes at a fraction of the step differ from those during the step.
    fn differs(&mut self, step: &CompletedStep<'_, '_>, part: f64) -> Result<bool, Halt> {
        self.move_to(step.stepper, part);
        let (loads, time) = (step.stepper.loads(), step.time(part));
        loads.contact_modes(time, &self.interface_state, &self.unchanged, &mut self.new_contact_modes)?;
        Ok(self.new_contact_modes != step.contact_modes)
    }

    /// Whether the contact modes of the motion itself differ. The polynomial is corrected there.
    fn differs_on_motion(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        part: f64,
    ) -> Result<bool, Halt> {
        self.measure_error(step, sampler, part);
        self.differs(step, part)
    }

    /// Moves the state to the last unit before a change, at the elapsed time `unit_time`, and adopts the new contact
    /// modes. They act from the change on: the state gets the effect of the old loads until then.
    pub fn apply(
        &mut self,
        stepper: &mut Stepper<'_>,
        sampler: &mut SubstepSampler,
        (level, unit_time, within): (usize, f64, f64),
        state: &mut State,
        change: ContactChange,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let step = stepper.step_length(level);
        let delay = change.at - unit_time;
        let z = sampler.state_at(stepper, level, &state.y, within);
        stepper.end_state.copy_from_slice(z);
        let (z, at) = (&stepper.end_state, StepInstant { part: within / step, elapsed: unit_time });
        stepper.interpolation_error(at, z, &mut self.interface_state, &mut self.interpolation_error);
        let part = |point: usize| (within + delay * point as f64 / (POINTS - 1) as f64) / step;
        for (point, jump) in self.jumps.iter_mut().enumerate() {
            stepper.interpolate_loads(part(point), jump);
        }
        state.contact_modes.clear();
        state.contact_modes.extend_from_slice(&self.new_contact_modes);
        stepper.context.loads.motion.set_contact_modes(&state.contact_modes);
        for point in (0..POINTS).rev() {
            self.interpolate(stepper, part(point));
            // Under the new loads, another path leads to the same motion at the change.
            let time = state.elapsed + part(point) * step;
            stepper.jumps.correct_path(&self.jumps[POINTS - 1], change.at - time, &mut self.interface_state);
            stepper.evaluate_at(time, &self.interface_state, &mut self.loads)?;
            statistics.evaluations += 1;
            for (jump, new) in self.jumps[point].iter_mut().zip(&self.loads) {
                *jump -= new;
            }
        }
        self.interpolation_error.fill(0.0);
        std::mem::swap(&mut state.y, &mut stepper.end_state);
        stepper.jumps.apply(&stepper.context, delay, &self.jumps, &mut state.y);
        Ok(())
    }
}
