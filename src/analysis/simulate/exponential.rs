//! Runs of the exponential method: its clock and its tables.

use std::f64::consts::TAU;

use super::super::AnalysisError;
use super::Options;
use super::initial::Start;
use super::modal_setup::{ModalSetup, enter, leave};
use crate::exponential::{
    LevelControl, NonlinearLoads, PropagatorCache, QuadratureRule, Stepper, TimeGrid, run as integrate,
};
use crate::integrate::{Halted, Observer, State, Statistics};
use crate::mesh::GearMesh;
use crate::modal::{CachedModel, Form, ModalStateSpace, WORST};
use crate::model::Model;
use crate::scene::SceneError;

/// Steps in a cycle of teeth whose force depends on where they are, of a revolution, or of the slowest mode, at least.
const STEPS_A_CYCLE: f64 = 8.0;
/// Steps in a cycle of teeth that only come and go.
const STEPS_A_PAIR: f64 = 2.0;
/// Steps in a revolution where bow and unbalance act as loads.
const STEPS_A_RESONANT_TURN: f64 = 64.0;
/// The radians that the fastest mode turns in the shortest step that events use, at most.
const TICK: f64 = 0.8;
/// How often the longest step is halved for an event, at least and at most.
const EVENT: [f64; 2] = [4.0, 30.0];
/// Fixed steps meet events to this part of the motion.
const EXACT: f64 = 1e-12;
/// How often it can be halved further, for accuracy.
const FURTHER: usize = 12;
/// The same where a step is a matrix.
const FURTHER_DENSE: usize = 4;
/// Samples in the shortest period among shafts and teeth.
const SAMPLES: f64 = 20.0;
/// Steps of ETDRK4 in such a period, unless a step is asked for.
const STEPS_A_SWING: f64 = 40.0;
/// Steps of ETDRK4 are this part of the longest, unless one is asked for.
const EXPLICIT: f64 = 0.1;
/// Ticks are counted in 64 bits; one is left for the last step.
const MOST_TICKS: f64 = 9.2e18;
/// Gauss nodes of a step.
const STAGES: usize = 3;

/// Runs from `start` to `end` (elapsed time); the state that it leaves, and why it stopped early, if it did.
pub(super) fn run(
    cached: &CachedModel,
    options: &Options,
    coordinates: ModalSetup<'_>,
    start: &Start,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(State, Result<(), Halted>), AnalysisError> {
    let ModalSetup { linear, field, maps, mut output } = coordinates;
    if options.is_explicit() && linear.condition > WORST {
        let message = format!(
            "\"exact\" needs modes that are not parallel, and their condition number is {:.1e}; take method=\"exponential\"",
            linear.condition
        );
        return Err(SceneError::new("linear", message).into());
    }
    let time_grid = time_grid(cached, options, &linear, &field)?;
    if end / time_grid.tick() > MOST_TICKS {
        let longest = time_grid.longest;
        let message =
            format!("{end:e} s are more steps of at most {longest:e} s than can be counted; take a shorter run");
        return Err(SceneError::new("duration", message).into());
    }
    let rule = if options.is_explicit() {
        QuadratureRule::explicit()
    } else {
        QuadratureRule::gauss(options.stages.unwrap_or(STAGES))
    };
    let table = PropagatorCache::new(&linear, rule, maps, time_grid, field.spins());
    let mut state = enter(cached, &linear, &field, start);
    let mut stepper = Stepper::new(field, table);
    let control = match options.step {
        None if !options.is_explicit() => LevelControl::Adaptive { rtol: options.tolerance(), floor: start.floor },
        _ => LevelControl::Fixed,
    };
    let outcome = integrate((&mut stepper, &mut output), control, &mut state, end, observer, statistics);
    Ok((leave(state, &linear, &stepper.field), outcome))
}

/// The clock of a run: the step that was asked for, or a round number that resolves what is prescribed.
fn time_grid(
    cached: &CachedModel,
    options: &Options,
    linear: &ModalStateSpace,
    field: &NonlinearLoads<'_>,
) -> Result<TimeGrid, AnalysisError> {
    let swing = field.motion.fastest_swing();
    let longest = match options.step {
        Some(step) => step,
        None => {
            let model = &cached.model;
            let slowest = cached.real_modes(options.fastest())?.frequencies.iter().copied().find(|value| *value > 0.0);
            let resonant = if field.is_resonant() { STEPS_A_RESONANT_TURN / STEPS_A_CYCLE } else { 1.0 };
            let speed = options.fastest().abs();
            let turning = model.fastest_turn() * speed * resonant;
            let travelling = model.fastest_teeth_of(GearMesh::depends_on_tooth_position) * speed;
            let engaging = model.fastest_teeth_of(GearMesh::switches) * speed * STEPS_A_PAIR / STEPS_A_CYCLE;
            let fastest = turning.max(travelling).max(engaging).max(slowest.unwrap_or(1.0));
            let mut most = TAU / (STEPS_A_CYCLE * fastest);
            if options.is_explicit() {
                most *= EXPLICIT;
                if field.motion.parts() {
                    most = most.min(TAU / (STEPS_A_SWING * swing));
                }
            }
            // Halved so many times, it is what responses are recorded at unless they are asked for otherwise.
            let sample = sample_step(model, speed);
            if sample.is_finite() {
                sample * 2.0_f64.powi((most / sample).log2().floor() as i32)
            } else {
                round_below(most)
            }
        }
    };
    let [least, most] = EVENT;
    // What an event leaves of its jump over the rest τ of a short step is some (ω τ)³/20 of it, ω that of the teeth.
    let tolerance = if options.step.is_some() { EXACT } else { options.tolerance() };
    let fine = swing / (2.0 * tolerance).cbrt();
    let event = (longest * (linear.radius / TICK).max(fine)).log2().ceil().clamp(least, most) as usize;
    // A step that is a matrix takes long to make.
    let further = if matches!(linear.form, Form::Dense(_)) { FURTHER_DENSE } else { FURTHER };
    Ok(TimeGrid { longest, finest: event + further, event })
}

/// A twentieth of the shortest period among shafts and teeth, as a round number; infinite at rest.
pub fn sample_step(model: &Model, speed: f64) -> f64 {
    let fastest = model.fastest_turn().max(model.fastest_teeth()) * speed.abs();
    round_below(TAU / (fastest * SAMPLES))
}

/// The largest of 1, 2 and 5 times a power of ten that is not above `value`: steps then meet the times that people ask
/// for. Zero stays zero, and infinity what it is.
pub fn round_below(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return value;
    }
    let power = value.log10().floor();
    // 10⁻ⁿ as a quotient: a power with a negative exponent is a bit off.
    let scaled = |digit: f64| {
        if power < 0.0 { digit / 10.0_f64.powi(-power as i32) } else { digit * 10.0_f64.powi(power as i32) }
    };
    [5.0, 2.0, 1.0].into_iter().map(scaled).find(|candidate| *candidate <= value).unwrap_or_else(|| scaled(1.0))
}

#[cfg(test)]
mod tests {
    use super::round_below;

    #[test]
    fn steps_are_round() {
        for (given, round) in [(3.14e-4, 2e-4), (9.9e-3, 5e-3), (1e-6, 1e-6), (7.0, 5.0), (1.2, 1.0), (25.0, 20.0)] {
            assert_eq!(round_below(given), round);
        }
    }
}
