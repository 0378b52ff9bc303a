//! The loop over Runge–Kutta steps.
//!
//! Steps do not depend on output times: outputs are interpolated, and the last step ends after the end of the run. The
//! state that is kept is the one before that step. A continued run takes the step again, so that a run in two parts is
//! identical to a run in one part, bit by bit.

use super::controller::MIN_STEP_FRACTION;
use super::event_locator::{ChangeLocation, MAX_CHANGES_AT_ONE_TIME, RungeKuttaEventLocator};
use super::{
    Adaptive, FirstOrderSystem, Halt, MethodState, Observer, RungeKutta, Span, State, Statistics, StepControl, StepEnd,
    StepInterval,
};

/// Number of steps between two questions to the observer whether to continue.
pub const CHECK_INTERVAL: u64 = 64;

/// A run that stopped early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halted {
    /// The reason.
    pub halt: Halt,
    /// Elapsed time at which it stopped, s.
    pub elapsed: f64,
}

/// An elapsed time and its compensation, s (compensated summation).
#[derive(Clone, Copy, Debug)]
struct CompensatedTime {
    elapsed: f64,
    compensation: f64,
}

/// A step that meets the tolerance, and what follows from it. The state after it is `RungeKutta::end`.
#[derive(Clone, Copy, Debug)]
struct AcceptedStep {
    /// Length, s.
    step: f64,
    /// Elapsed time after the step and the compensation of its round-off, s.
    end: CompensatedTime,
    /// Length of the step to try next, s.
    next_step: f64,
    /// Error in multiples of the tolerance.
    error: f64,
    /// Whether the stability limit sets the length.
    at_limit: bool,
}

/// Integrates from `state` to `end` (elapsed time, s) and up to all instants for which the observer asks.
///
/// # Errors
/// [`Halted`]. `state` is then the last valid one.
pub fn run<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    control: &StepControl,
    state: &mut State,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halted> {
    let outcome = take_steps(system, method, control, state, end, observer, statistics);
    outcome.map_err(|halt| Halted { halt, elapsed: state.elapsed })
}

fn take_steps<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    control: &StepControl,
    state: &mut State,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halt> {
    let mut locator = RungeKuttaEventLocator::new(system, state)?;
    observer.switched(state.elapsed, &mut |q, v| system.physical(state.elapsed, &state.y, q, v), &state.contact_modes);
    method.begin(system, state.elapsed, &state.y)?;
    statistics.begin(1);
    let (mut checks, mut changes_at_this_time) = (0, 0);
    while state.elapsed < end || observer.next().is_some() {
        // A run does not stop between two changes at one instant, because their count is not part of the state.
        checks += u64::from(changes_at_this_time == 0);
        if changes_at_this_time == 0 && checks % CHECK_INTERVAL == 1 && !observer.continues(state.elapsed) {
            return Err(Halt::Interrupted);
        }
        let mut accepted = take_step(system, method, control, state, statistics)?;
        let change = match &mut locator {
            Some(locator) if changes_at_this_time < MAX_CHANGES_AT_ONE_TIME => {
                locator.locate(system, state, &span(method, state, accepted.step))?
            }
            _ => None,
        };
        let new_contact_modes = locator.as_ref().map_or(&[][..], |locator| &locator.new_contact_modes);
        match change {
            Some(ChangeLocation::AtBeginning) => {
                changes_at_this_time += 1;
                adopt(system, method, state, new_contact_modes, observer, statistics)?;
                continue;
            }
            Some(ChangeLocation::Within(step)) => {
                accepted.step = step;
                accepted.end = advanced(state, step);
                method.step(
                    system,
                    StepInterval { begin: state.elapsed, end: accepted.end.elapsed, length: step },
                    &state.y,
                )?;
                statistics.evaluations += S as u64 - 1;
            }
            Some(ChangeLocation::AtEnd) | None => {}
        }
        changes_at_this_time = 0;
        if observer.sees_every_step() || observer.next().is_some_and(|next| next <= accepted.end.elapsed) {
            let mut trajectory = system.trajectory(span(method, state, accepted.step));
            observer.observe(&mut trajectory, accepted.end.elapsed)?;
        }
        if accepted.end.elapsed > end {
            break;
        }
        commit(method, state, &accepted, matches!(change, Some(ChangeLocation::Within(_))), statistics);
        if change.is_some() {
            adopt(system, method, state, new_contact_modes, observer, statistics)?;
        }
    }
    Ok(())
}

/// Takes a step whose end is finite.
fn take_step<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    control: &StepControl,
    state: &State,
    statistics: &mut Statistics,
) -> Result<AcceptedStep, Halt> {
    let accepted = match control {
        StepControl::Fixed(step) => fixed(system, method, state, *step, statistics),
        StepControl::Adaptive(adaptive) => attempt(system, method, state, adaptive, statistics),
    }?;
    if method.end().iter().sum::<f64>().is_finite() { Ok(accepted) } else { Err(Halt::Diverged) }
}

/// The last step, which began at `state` and is `step` seconds long.
fn span<'a, const S: usize>(method: &'a RungeKutta<S>, state: &'a State, step: f64) -> Span<'a> {
    let (before, after) = method.derivatives();
    let before = StepEnd { state: &state.y, derivative: before };
    let after = StepEnd { state: method.end(), derivative: after };
    Span { start: state.elapsed, step, before, after }
}

/// Takes the end of a step as the state. A step that a contact change has shortened sets no next step.
fn commit<const S: usize>(
    method: &mut RungeKutta<S>,
    state: &mut State,
    accepted: &AcceptedStep,
    is_shortened: bool,
    statistics: &mut Statistics,
) {
    method.commit(&mut state.y);
    let CompensatedTime { elapsed, compensation } = accepted.end;
    state.elapsed = elapsed;
    state.method = MethodState::RungeKutta { compensation };
    statistics.accept(accepted.step, accepted.at_limit);
    if !is_shortened {
        state.count += 1;
        state.next_step = accepted.next_step;
        state.previous_error = accepted.error;
    }
}

/// Adopts new contact modes. The first stage is evaluated again, because it belongs to the old modes.
fn adopt<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    state: &mut State,
    new_contact_modes: &[i64],
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halt> {
    state.contact_modes.clear();
    state.contact_modes.extend_from_slice(new_contact_modes);
    system.set_contact_modes(new_contact_modes);
    let mut read = |q: &mut [f64], v: &mut [f64]| system.physical(state.elapsed, &state.y, q, v);
    observer.switched(state.elapsed, &mut read, new_contact_modes);
    statistics.evaluations += 1;
    statistics.events += 1;
    method.begin(system, state.elapsed, &state.y)
}

/// Elapsed time after a step and its compensation, s (compensated summation).
fn advanced(state: &State, step: f64) -> CompensatedTime {
    let addend = step - state.method.compensation();
    let elapsed = state.elapsed + addend;
    CompensatedTime { elapsed, compensation: (elapsed - state.elapsed) - addend }
}

/// Takes a fixed step. Step i ends at (i + 1) `step`.
fn fixed<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    state: &State,
    step: f64,
    statistics: &mut Statistics,
) -> Result<AcceptedStep, Halt> {
    let end = CompensatedTime { elapsed: (state.count + 1) as f64 * step, compensation: 0.0 };
    // After a contact change within step i, the rest of that step follows.
    let is_begun = state.elapsed != state.count as f64 * step;
    let step = if is_begun { end.elapsed - state.elapsed } else { step };
    method.step(system, StepInterval { begin: state.elapsed, end: end.elapsed, length: step }, &state.y)?;
    statistics.evaluations += S as u64 - 1;
    Ok(AcceptedStep { step, end, next_step: step, error: 1.0, at_limit: false })
}

/// Tries steps until one meets the tolerance.
fn attempt<const S: usize>(
    system: &mut impl FirstOrderSystem,
    method: &mut RungeKutta<S>,
    state: &State,
    control: &Adaptive,
    statistics: &mut Statistics,
) -> Result<AcceptedStep, Halt> {
    let order = method.tableau.order;
    let mut step = if state.next_step > 0.0 { state.next_step } else { control.longest };
    let mut rejected = false;
    let before = system.size(&state.y);
    loop {
        let end = advanced(state, step);
        method.step(system, StepInterval { begin: state.elapsed, end: end.elapsed, length: step }, &state.y)?;
        statistics.evaluations += S as u64 - 1;
        let scale = before.max(system.size(method.end())).max(control.floor);
        let error = method.error(system, step);
        // A system at rest in equilibrium has neither an error nor a size.
        let error = if error > 0.0 || error.is_nan() { error / (control.rtol * scale) } else { 0.0 };
        if error <= 1.0 {
            let factor = control.grow(order, error, state.previous_error);
            // A step that grows directly after a rejection is likely to be rejected again.
            let factor = if rejected { factor.min(1.0) } else { factor };
            return Ok(AcceptedStep {
                step,
                end,
                next_step: (step * factor).min(control.longest),
                error,
                at_limit: step == control.longest,
            });
        }
        statistics.rejected += 1;
        rejected = true;
        step *= if error.is_finite() { control.shrink(order, error) } else { 0.1 };
        if step < MIN_STEP_FRACTION * control.longest {
            return Err(Halt::Diverged);
        }
    }
}
