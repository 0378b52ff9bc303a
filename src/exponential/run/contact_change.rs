//! Location of contact changes within a step.
//!
//! This locator differs from `integrate::RungeKuttaEventLocator`, which bisects on the polynomial through both ends of a short step and
//! repeats the step up to the change. Steps of the exponential method are long: the search starts from the margins of the
//! flanks, and the polynomial is corrected by its difference to the motion. The motion up to the change is that of the step,
//! and the next step begins at the change.

use super::contact_monitor::{CandidateEvent, ContactMonitor};
use crate::exponential::step::{DefectScratch, StepInstant, Stepper};
use crate::exponential::within_step::{CompletedStep, SubstepSampler};
use crate::integrate::Halt;
use crate::numerics::{EQUALITY_TOLERANCE, bisect};

/// The instant is located to this fraction of the step.
const EVENT_RESOLUTION: f64 = 1e-12;
/// Factor by which the bracket around a predicted instant widens after it has missed the change.
const BRACKET_GROWTH: f64 = 64.0;
/// Largest distance of a contact change from its predicted instant, as a fraction of the step: a correction of the polynomial
/// moves the instant by at most this, and bisection takes over where the bracket around the instant is wider.
const MAX_PREDICTION_ERROR: f64 = 0.05;
/// Points, as fractions of the way to a change, at which the motion after the beginning of the step is evaluated.
const POINTS_AFTER_CHANGE: [f64; 5] = [1e-4, 1e-3, 1e-2, 0.1, 0.5];
/// Largest number of corrections of the polynomial.
const MAX_CORRECTIONS: usize = 6;

/// Fractions of a step: at the lower one the contact modes are the old ones, at the upper one they are new.
#[derive(Clone, Copy, Debug)]
struct Bracket {
    low: f64,
    high: f64,
}

/// Locates contact changes within a completed step.
pub(in crate::exponential) struct ExponentialEventLocator {
    /// Contact modes at the fraction of the step that was evaluated last, as integer codes.
    pub new_contact_modes: Vec<i64>,
    /// Contact modes after the change that was located last.
    modes_after_change: Vec<i64>,
    /// For each connection whether its flank contact is unchanged over the step; empty if no flanks can separate.
    pub unchanged: Vec<bool>,
    /// Interface state minus its polynomial, near the change.
    interpolation_error: Vec<f64>,
    monitor: ContactMonitor,
    /// Scratch: an interface state, loads and interpolated loads.
    interface_state: Vec<f64>,
    loads: Vec<f64>,
    interpolated_loads: Vec<f64>,
    /// Scratch: positions of the ends of the paths of contact, in tooth pairs, with the first or last pair in contact, at
    /// both ends of the bracket.
    path_ends: [Vec<(f64, i64)>; 2],
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
            interpolated_loads: vec![0.0; load_count],
        }
    }

    /// Scratch for [`Stepper::defect_at`].
    pub fn scratch(&mut self) -> DefectScratch<'_> {
        DefectScratch {
            interface_state: &mut self.interface_state,
            loads: &mut self.loads,
            interpolated: &mut self.interpolated_loads,
        }
    }

    /// Whether a contact change is possible within the last step: not if flank contact is unchanged and tooth pairs
    /// engage smoothly.
    pub fn is_possible(&self, stepper: &Stepper<'_>) -> bool {
        stepper.sharp || self.unchanged.is_empty() || self.unchanged.contains(&false)
    }

    /// Finds the elapsed time of the first contact change within the last step, s. The new modes are left in
    /// [`Self::new_contact_modes`].
    pub fn locate(&mut self, step: &CompletedStep<'_, '_>, sampler: &mut SubstepSampler) -> Result<Option<f64>, Halt> {
        let bracket = self.bracket(step, sampler)?;
        self.interpolation_error.fill(0.0);
        let Some(bracket) = bracket else {
            return Ok(None);
        };
        let change = match self.correct(step, sampler, bracket)? {
            Some(change) => Some(change),
            // The polynomial differs from the motion by more than the motion near the change, or flanks touch at the beginning.
            None => self.bisect(step, sampler, bracket)?,
        };
        self.interpolation_error.fill(0.0);
        if change.is_some() {
            self.new_contact_modes.clone_from(&self.modes_after_change);
        }
        Ok(change.map(|change| step.time(change)))
    }

    /// Finds two fractions of the step with the old and with a new contact mode, at the candidates and at the end.
    fn bracket(&mut self, step: &CompletedStep<'_, '_>, sampler: &mut SubstepSampler) -> Result<Option<Bracket>, Halt> {
        let mut low = 0.0_f64;
        self.monitor.search(step.stepper, &self.unchanged);
        for index in 0..=self.monitor.candidates.len() {
            let end = CandidateEvent { at: 1.0, is_minimum: false };
            let candidate = self.monitor.candidates.get(index).copied().unwrap_or(end);
            if candidate.at <= 0.0 {
                continue;
            }
            let differs = if candidate.is_minimum {
                self.differs_on_motion(step, sampler, candidate.at)?
            } else {
                self.differs(step, candidate.at)?
            };
            if differs {
                return Ok(Some(Bracket { low, high: candidate.at }));
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
        bracket: Bracket,
    ) -> Result<Option<f64>, Halt> {
        let begin = bracket.low;
        let mut change = self.narrow(step, bracket)?;
        self.keep_modes(step, change)?;
        for _ in 0..MAX_CORRECTIONS {
            if !step.stepper.loads().motion.motion_changes_contact_modes() {
                return Ok(Some(change));
            }
            // Round-off may decide on the contact modes so close to the beginning.
            if change - begin <= EQUALITY_TOLERANCE {
                return Ok(None);
            }
            self.measure_error(step, sampler, change);
            let near = Bracket {
                low: (change - MAX_PREDICTION_ERROR).max(begin),
                high: (change + MAX_PREDICTION_ERROR).min(1.0),
            };
            if self.differs(step, near.low)? || !self.differs(step, near.high)? {
                return Ok(None);
            }
            let corrected = self.narrow(step, near)?;
            if corrected + EVENT_RESOLUTION >= near.high {
                return Ok(None);
            }
            let shift = corrected - change;
            change = corrected;
            self.keep_modes(step, change)?;
            if shift.abs() <= EQUALITY_TOLERANCE {
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
        Bracket { mut low, mut high }: Bracket,
    ) -> Result<Option<f64>, Halt> {
        if !self.differs_on_motion(step, sampler, high)? {
            high = 1.0;
            if !self.differs_on_motion(step, sampler, high)? {
                return Ok(None);
            }
        }
        if low <= 0.0 || self.differs_on_motion(step, sampler, low)? {
            match self.first_unchanged(step, sampler, &mut high)? {
                Some(unchanged) => low = unchanged,
                None => return Ok(Some(0.0)),
            }
        }
        let [_, high] = bisect(low, high, EVENT_RESOLUTION, |middle| self.differs_on_motion(step, sampler, middle))?;
        self.differs_on_motion(step, sampler, high)?;
        self.modes_after_change.clone_from(&self.new_contact_modes);
        Ok(Some(high))
    }

    /// Finds a fraction of the step with the old contact modes, and moves `high` to a change after it.
    ///
    /// Where a step begins at a change, touching flanks have a deflection of round-off, and any contact mode can result. There the
    /// modes on which two instants soon after agree hold from the beginning on, and the result is none.
    fn first_unchanged(
        &mut self,
        step: &CompletedStep<'_, '_>,
        sampler: &mut SubstepSampler,
        high: &mut f64,
    ) -> Result<Option<f64>, Halt> {
        let (mut unchanged, mut has_differed) = (None, false);
        let end = *high;
        for fraction in POINTS_AFTER_CHANGE {
            let at = fraction * end;
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
    fn narrow(&mut self, step: &CompletedStep<'_, '_>, Bracket { mut low, mut high }: Bracket) -> Result<f64, Halt> {
        // The ends of the path of contact move almost uniformly, so that an engagement can be predicted. The contact mode
        // is evaluated close to both sides of the prediction, further away after each miss. A change of the flanks is not
        // predicted.
        let (mut half_width, mut predicts) = (EVENT_RESOLUTION / 2.0, true);
        while high - low > EVENT_RESOLUTION {
            let predicted = if predicts { self.predict_engagement(step, Bracket { low, high })? } else { None };
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
            half_width *= BRACKET_GROWTH;
            predicts = half_width < MAX_PREDICTION_ERROR;
        }
        Ok(high)
    }

    /// Predicts the fraction of the step at which the first tooth pair enters or leaves contact in a bracket, if the ends
    /// of the path of contact move uniformly.
    fn predict_engagement(
        &mut self,
        step: &CompletedStep<'_, '_>,
        Bracket { low, high }: Bracket,
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
}
