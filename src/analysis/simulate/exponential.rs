//! Runs of the exponential method: the time grid, whose longest step resolves the rotation of shafts and teeth, and the
//! propagators.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::super::AnalysisError;
use super::Options;
use super::initial::Start;
use super::modal_setup::{ModalSetup, in_modal_coordinates, in_physical_coordinates};
use super::ramp::linear_model;
use super::run_cache::RunModel;
use crate::exponential::{
    InterfaceMaps, LevelControl, Loads, PropagatorCache, PropagatorKey, QuadratureRule, Stepper, TimeGrid,
    run as integrate,
};
use crate::integrate::{Halted, Observer, State, Statistics};
use crate::mesh::GearMesh;
use crate::modal::{CachedModel, ModalStateSpace};
use crate::model::Model;
use crate::motion::Speed;
use crate::scene::{LoadLaw, SceneError};

/// Smallest number of steps per revolution, per period of the slowest mode, and per tooth whose force depends on its
/// position.
const STEPS_PER_CYCLE: f64 = 8.0;
/// Smallest number of steps per tooth whose stiffness is constant while it is engaged.
const STEPS_PER_TOOTH: f64 = 2.0;
/// Steps per revolution where bow and unbalance act as loads, in multiples of [`STEPS_PER_CYCLE`].
const RESONANT_FACTOR: f64 = 8.0;
/// Largest number of intervals of a time series in one step, so that no step misses a pulse.
const MAX_SERIES_INTERVALS: f64 = 4.0;
/// Largest rotation of the fastest mode within the shortest substep, rad.
const MAX_SUBSTEP_ROTATION: f64 = 0.8;
/// Smallest and largest number of halvings from the longest step to the shortest substep.
const SUBSTEP_HALVINGS: [f64; 2] = [4.0, 30.0];
/// Number of further halvings that the error control can use.
const FURTHER_HALVINGS: usize = 12;
/// Output samples in the shortest period among shafts and teeth.
const SAMPLES_PER_PERIOD: f64 = 20.0;
/// Default number of ETDRK4 steps per period on the mesh stiffness, where flanks can separate.
const STEPS_PER_MESH_PERIOD: f64 = 40.0;
/// Default step of ETDRK4, as a fraction of the longest step.
const EXPLICIT_FRACTION: f64 = 0.1;
/// Units are counted in 64 bits, of which one bit is reserved for the last step.
const MAX_UNITS: f64 = 9.2e18;
/// Default number of stages.
const DEFAULT_STAGES: usize = 3;

/// Runs from `start` to `end` (elapsed time, s). Returns the final state and the reason for an early stop.
pub(super) fn run(
    cached: &RunModel<'_>,
    options: &Options,
    coordinates: ModalSetup<'_>,
    start: &Start,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(State, Result<(), Halted>), AnalysisError> {
    let ModalSetup { linear, loads, maps, mut output } = coordinates;
    let time_grid = countable_grid(cached, options, &linear, &loads, end)?;
    let propagators = propagators(cached, options, &linear, maps, time_grid, loads.spins());
    let mut state = in_modal_coordinates(cached, &linear, &loads, start);
    let mut stepper = Stepper::new(loads, propagators);
    let control = match options.step {
        None if !options.is_explicit() => {
            LevelControl::Adaptive { rtol: options.tolerance(), floor: start.floor, force_error: options.force_error }
        }
        _ => LevelControl::Fixed,
    };
    let outcome = integrate(&mut stepper, &mut output, control, &mut state, end, observer, statistics);
    Ok((in_physical_coordinates(state, &linear, stepper.loads()), outcome))
}

/// The propagators of a run, which the runs of a system share.
pub(super) fn propagators(
    cached: &RunModel<'_>,
    options: &Options,
    linear: &Arc<ModalStateSpace>,
    maps: InterfaceMaps,
    time_grid: TimeGrid,
    spins: Vec<f64>,
) -> Arc<PropagatorCache> {
    let rule = if options.is_explicit() {
        QuadratureRule::explicit()
    } else {
        QuadratureRule::gauss(options.stages.unwrap_or(DEFAULT_STAGES))
    };
    let key = Arc::new(PropagatorKey { linear: Arc::clone(linear), rule, maps, time_grid, spins });
    cached.known.propagators.get_or(Arc::clone(&key), || Arc::new(PropagatorCache::new(key)))
}

/// The time grid of a run that ends at `end` (elapsed time, s), if its units can be counted.
pub(super) fn countable_grid(
    cached: &CachedModel,
    options: &Options,
    linear: &ModalStateSpace,
    loads: &Loads<'_>,
    end: f64,
) -> Result<TimeGrid, AnalysisError> {
    let time_grid = time_grid(cached, options, linear, loads)?;
    if end / time_grid.unit() > MAX_UNITS {
        let longest = time_grid.longest;
        let message =
            format!("{end:e} s are more steps of at most {longest:e} s than can be counted; take a shorter run");
        return Err(SceneError::new("duration", message).into());
    }
    Ok(time_grid)
}

/// The time grid of a run. Its longest step is the given fixed step, or a round number that resolves the excitation.
fn time_grid(
    cached: &CachedModel,
    options: &Options,
    linear: &ModalStateSpace,
    loads: &Loads<'_>,
) -> Result<TimeGrid, AnalysisError> {
    let mesh_frequency = loads.motion.highest_mesh_frequency();
    let longest = match options.step {
        Some(step) => step,
        None => {
            let model = &cached.model;
            let slowest = linear_model(cached, options)?.spectral_range(options.fastest())?.slowest;
            let resonant = if loads.is_resonant() { RESONANT_FACTOR } else { 1.0 };
            let speed = options.fastest().abs();
            // At a changing speed, the longest step is that of the slowest speed; faster speeds use shorter ones.
            let excitation = match options.speed {
                Speed::Constant(_) => excitation_frequency(model, speed, resonant),
                Speed::Changing(_) => excitation_frequency(model, options.speed.magnitudes()[0], RESONANT_FACTOR),
            };
            let fastest = excitation.max(slowest.unwrap_or(1.0));
            let mut most = TAU / (STEPS_PER_CYCLE * fastest);
            if options.is_explicit() {
                most *= EXPLICIT_FRACTION;
                if loads.motion.flanks_can_separate() {
                    most = most.min(TAU / (STEPS_PER_MESH_PERIOD * mesh_frequency));
                }
            }
            // The default output step, doubled or halved, so that steps end at output times.
            let sample = sample_step(model, speed);
            if sample.is_finite() {
                sample * 2.0_f64.powi((most / sample).log2().floor() as i32)
            } else {
                round_below(most)
            }
        }
    };
    let [least, most] = SUBSTEP_HALVINGS;
    let substep = (longest * linear.radius / MAX_SUBSTEP_ROTATION).log2().ceil().clamp(least, most) as usize;
    Ok(TimeGrid { longest, finest: substep + FURTHER_HALVINGS, substep })
}

/// Angular frequency of shafts, teeth, rolling elements and loads at a speed, rad/s, that the longest step resolves; `turning` is the number of steps
/// per revolution in multiples of [`STEPS_PER_CYCLE`].
fn excitation_frequency(model: &Model, speed: f64, turning: f64) -> f64 {
    let speed = speed.abs();
    let turning = model.max_speed_ratio() * speed * turning;
    let travelling = model.max_mesh_order_of(GearMesh::depends_on_tooth_position) * speed;
    let engaging = model.max_mesh_order_of(GearMesh::switches) * speed * STEPS_PER_TOOTH / STEPS_PER_CYCLE;
    let loads = model.loads.iter().map(|load| match &load.law {
        LoadLaw::Turning { order, .. } => (order * load.ratio * speed).abs(),
        LoadLaw::Force([curve, _]) | LoadLaw::Torque(curve) => {
            TAU / (STEPS_PER_CYCLE * MAX_SERIES_INTERVALS * curve.mean_spacing())
        }
        LoadLaw::SpeedTorque { .. } => 0.0,
    });
    let passing = model
        .nonlinear_bearings
        .iter()
        .filter_map(|bearing| bearing.elements().map(|count| (count as f64 * bearing.ratio * speed).abs()));
    loads.chain(passing).fold(turning.max(travelling).max(engaging), f64::max)
}

/// Rotation of the reference shaft within the longest step at a changing speed, rad.
pub(super) fn rotation_of_longest_step(model: &Model) -> f64 {
    TAU / (STEPS_PER_CYCLE * excitation_frequency(model, 1.0, RESONANT_FACTOR))
}

/// The default output step, s: a twentieth of the shortest period among shafts and teeth, rounded; infinite at rest.
pub fn sample_step(model: &Model, speed: f64) -> f64 {
    let fastest = model.max_speed_ratio().max(model.max_mesh_order()) * speed.abs();
    round_below(TAU / (fastest * SAMPLES_PER_PERIOD))
}

/// The largest of 1, 2 and 5 times a power of ten that does not exceed `value`, so that steps end at round times. Values
/// that are not positive, or not finite, are returned unchanged.
pub fn round_below(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return value;
    }
    let power = value.log10().floor();
    // 10⁻ⁿ as a quotient, because a power with a negative exponent has a rounding error.
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
