//! The loop over steps.
//!
//! Steps do not know of output times: what is asked for is interpolated, and the last step runs past the end. The
//! state that is kept is the one before it, so a run that continues takes that step again, and a run in two parts is
//! the same, bit for bit, as a run in one.

use super::controller::SHORTEST;
use super::{Adaptive, FirstOrderSystem, Halt, Observer, RungeKutta, Span, Statistics, StepControl};

/// Steps between two questions to the observer whether to go on.
pub const CHECK_INTERVAL: u64 = 64;

/// Where an integration stands.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Steps since the origin, where the step is fixed.
    pub count: u64,
    /// Elapsed time since the origin, s.
    pub elapsed: f64,
    /// What the sum `elapsed` has lost to round-off; where time counts in ticks, how long after this one the law that
    /// holds came to hold.
    pub carry: f64,
    /// The step to try next, s; zero before the first.
    pub next_step: f64,
    /// Scaled error of the step before.
    pub previous_error: f64,
    /// The laws that hold, as numbers of the system's own; empty before the first step.
    pub contact_modes: Vec<i64>,
    /// Displacements, then velocities; coordinates of its own where a method has them.
    pub y: Vec<f64>,
    /// What a method remembers of the step before.
    pub memory: Vec<f64>,
}

impl State {
    /// The beginning of a run.
    pub fn new(y: Vec<f64>) -> Self {
        Self {
            count: 0,
            elapsed: 0.0,
            carry: 0.0,
            next_step: 0.0,
            previous_error: 1.0,
            contact_modes: Vec::new(),
            y,
            memory: Vec::new(),
        }
    }
}

/// A run that stopped early: why, and at which elapsed time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halted {
    /// Why.
    pub halt: Halt,
    /// When, s.
    pub elapsed: f64,
}

/// Adopts the laws found for the steps to come; the derivative that stands is of the law before.
fn adopt<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    state: &mut State,
    found: &[i64],
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halt> {
    state.contact_modes.clear();
    state.contact_modes.extend_from_slice(found);
    system.set_contact_modes(found);
    observer.switched(state.elapsed, &mut |q, v| system.physical(state.elapsed, &state.y, q, v), found);
    statistics.evaluations += 1;
    statistics.events += 1;
    method.begin(system, state.elapsed, &state.y)
}

/// Where in a step the law changes.
#[derive(Clone, Copy, Debug)]
enum ChangeLocation {
    /// At its beginning: the law is adopted and the step taken anew.
    AtOnce,
    /// After this part of it, s: the step ends there.
    Within(f64),
    /// At its end.
    AtEnd,
}

/// Changes of law within a step.
///
/// The law is frozen over a step. Where another one holds at its end, the instant of the change is found on the
/// interpolated motion, the step is taken again up to there, and the new law is adopted as it was found: the state at
/// the instant itself may, by round-off, still be on either side.
struct ContactEventLocator {
    found: Vec<i64>,
    trial: Vec<f64>,
}

/// Where within a step the laws are looked at.
const WITHIN: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// An instant is found to this part of its step.
const RESOLUTION: f64 = 1e-13;
/// A change within this part of the step from its beginning or its end happens there: no step is shorter.
const NOTHING: f64 = 1e-9;
/// ContactMode adopted at one instant before a step is taken as it is: grazing contacts would change them for ever.
const MAX_CHANGES_AT_ONCE: u32 = 8;

impl ContactEventLocator {
    fn new(system: &mut impl FirstOrderSystem, state: &mut State) -> Result<Option<Self>, Halt> {
        if system.switching().is_none() {
            return Ok(None);
        }
        if state.contact_modes.is_empty() {
            system.contact_modes_at(state.elapsed, &state.y, &mut state.contact_modes)?;
        }
        system.set_contact_modes(&state.contact_modes);
        Ok(Some(Self { found: state.contact_modes.clone(), trial: vec![0.0; state.y.len()] }))
    }

    /// The first change of law within a step; the new laws are left in `found`.
    fn locate<const S: usize>(
        &mut self,
        system: &mut impl FirstOrderSystem,
        method: &RungeKutta<S>,
        state: &State,
        taken: &Taken,
    ) -> Result<Option<ChangeLocation>, Halt> {
        let derivatives = method.derivatives();
        let span = Span {
            start: state.elapsed,
            step: taken.step,
            before: (&state.y, derivatives.0),
            after: (method.end(), derivatives.1),
        };
        // Within the step first: flanks may part and meet again before its end.
        let mut high = None;
        for part in WITHIN {
            if self.changed(system, state, &span, part)? {
                high = Some(part);
                break;
            }
        }
        let Some(mut high) = high else {
            return Ok(None);
        };
        let mut low = 0.0;
        while high - low > RESOLUTION {
            let middle = (low + high) / 2.0;
            if self.changed(system, state, &span, middle)? { high = middle } else { low = middle }
        }
        self.changed(system, state, &span, high)?;
        Ok(Some(match high {
            high if high <= NOTHING => ChangeLocation::AtOnce,
            high if high >= 1.0 - NOTHING => ChangeLocation::AtEnd,
            high => ChangeLocation::Within(high * taken.step),
        }))
    }

    /// Whether other laws hold at a part of a step; they are left in `found`.
    fn changed(
        &mut self,
        system: &mut impl FirstOrderSystem,
        state: &State,
        span: &Span<'_>,
        part: f64,
    ) -> Result<bool, Halt> {
        let elapsed = if part < 1.0 { span.start + part * span.step } else { span.start + span.step };
        system.within(span, elapsed, &mut self.trial);
        system.contact_modes_at(elapsed, &self.trial, &mut self.found)?;
        Ok(self.found != state.contact_modes)
    }
}

/// What a step made of its state, apart from y.
#[derive(Clone, Copy, Debug)]
struct Taken {
    step: f64,
    /// Elapsed time and its carry after the step.
    after: (f64, f64),
    next_step: f64,
    error: f64,
    at_limit: bool,
}

/// Integrates from `state` until `end` (elapsed time) and all the observer asks for.
///
/// # Errors
/// [`Halted`]; `state` is then the last good one.
pub fn run<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    control: &StepControl,
    state: &mut State,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halted> {
    let at = |elapsed: f64| move |halt: Halt| Halted { halt, elapsed };
    let mut events = ContactEventLocator::new(system, state).map_err(at(state.elapsed))?;
    observer.switched(state.elapsed, &mut |q, v| system.physical(state.elapsed, &state.y, q, v), &state.contact_modes);
    method.begin(system, state.elapsed, &state.y).map_err(at(state.elapsed))?;
    statistics.begin(1);
    let (mut asked, mut adopted) = (0, 0);
    while state.elapsed < end || observer.next().is_some() {
        // Between two laws adopted at one instant nothing stops: the count of them is no part of the state.
        asked += u64::from(adopted == 0);
        if adopted == 0 && asked % CHECK_INTERVAL == 1 && !observer.go_on(state.elapsed) {
            return Err(at(state.elapsed)(Halt::Interrupted));
        }
        let taken = match control {
            StepControl::Fixed(step) => fixed(system, method, state, *step, statistics),
            StepControl::Adaptive(adaptive) => attempt(system, method, state, adaptive, statistics),
        };
        let mut taken = taken.map_err(at(state.elapsed))?;
        if !method.end().iter().sum::<f64>().is_finite() {
            return Err(at(state.elapsed)(Halt::Diverged));
        }
        let change = match &mut events {
            Some(events) if adopted < MAX_CHANGES_AT_ONCE => {
                events.locate(system, method, state, &taken).map_err(at(state.elapsed))?
            }
            _ => None,
        };
        if let (Some(events), Some(ChangeLocation::AtOnce)) = (&events, change) {
            adopted += 1;
            adopt(system, method, state, &events.found, observer, statistics).map_err(at(state.elapsed))?;
            continue;
        }
        adopted = 0;
        if let Some(ChangeLocation::Within(step)) = change {
            taken.step = step;
            taken.after = advanced(state, step);
            let span = (state.elapsed, taken.after.0);
            method.step(system, span, &state.y, step).map_err(at(state.elapsed))?;
            statistics.evaluations += S as u64 - 1;
        }
        let after = taken.after;
        let derivatives = method.derivatives();
        let span = Span {
            start: state.elapsed,
            step: taken.step,
            before: (&state.y, derivatives.0),
            after: (method.end(), derivatives.1),
        };
        if observer.sees_every_step() || observer.next().is_some_and(|next| next <= after.0) {
            observer.observe(&mut system.trajectory(span), after.0).map_err(at(state.elapsed))?;
        }
        if after.0 > end {
            break;
        }
        method.commit(&mut state.y);
        (state.elapsed, state.carry) = after;
        statistics.accept(taken.step, taken.at_limit);
        if !matches!(change, Some(ChangeLocation::Within(_))) {
            // The step to try after an event is that from before it.
            state.count += 1;
            state.next_step = taken.next_step;
            state.previous_error = taken.error;
        }
        if let (Some(events), Some(_)) = (&events, change) {
            adopt(system, method, state, &events.found, observer, statistics).map_err(at(state.elapsed))?;
        }
    }
    Ok(())
}

/// Elapsed time and its carry after a step: a compensated sum.
fn advanced(state: &State, step: f64) -> (f64, f64) {
    let addend = step - state.carry;
    let sum = state.elapsed + addend;
    (sum, (sum - state.elapsed) - addend)
}

fn fixed<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    state: &State,
    step: f64,
    statistics: &mut Statistics,
) -> Result<Taken, Halt> {
    let after = ((state.count + 1) as f64 * step, 0.0);
    // An event has ended a step within this one: what is left of it comes next.
    let begun = state.elapsed != state.count as f64 * step;
    let step = if begun { after.0 - state.elapsed } else { step };
    method.step(system, (state.elapsed, after.0), &state.y, step)?;
    statistics.evaluations += S as u64 - 1;
    Ok(Taken { step, after, next_step: step, error: 1.0, at_limit: false })
}

/// Tries steps until one meets the tolerance.
fn attempt<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    state: &State,
    control: &Adaptive,
    statistics: &mut Statistics,
) -> Result<Taken, Halt> {
    let order = method.tableau.order;
    let mut step = if state.next_step > 0.0 { state.next_step } else { control.longest };
    let mut rejected = false;
    let before = system.size(&state.y);
    loop {
        let after = advanced(state, step);
        method.step(system, (state.elapsed, after.0), &state.y, step)?;
        statistics.evaluations += S as u64 - 1;
        let scale = before.max(system.size(method.end())).max(control.floor);
        let error = method.error(system, step);
        // A scene at rest in equilibrium has neither error nor size.
        let error = if error > 0.0 || error.is_nan() { error / (control.rtol * scale) } else { 0.0 };
        if error <= 1.0 {
            let factor = control.grow(order, error, state.previous_error);
            // Growing right after a rejection would only be rejected again.
            let factor = if rejected { factor.min(1.0) } else { factor };
            return Ok(Taken {
                step,
                after,
                next_step: (step * factor).min(control.longest),
                error,
                at_limit: step == control.longest,
            });
        }
        statistics.rejected += 1;
        rejected = true;
        step *= if error.is_finite() { control.shrink(order, error) } else { 0.1 };
        if step < SHORTEST * control.longest {
            return Err(Halt::Diverged);
        }
    }
}
