//! The state that a run begins with.

use nalgebra::{Complex, DMatrix, DVector};

use super::super::synchronous::{motion, with_flanks};
use super::super::{AnalysisError, Spectrum, equilibrium};
use super::{Final, Initial, Options, explain};
use crate::integrate::tableau::DORMAND_PRINCE;
use crate::integrate::{
    FirstOrderSystem as _, Halt, Observer, RungeKutta, State, Statistics, StepControl, Trajectory, run,
};
use crate::mesh::Geometry;
use crate::modal::CachedModel;
use crate::model::DofKind;
use crate::motion::{Anchor, EquationOfMotion, ShaftRotation};
use crate::scene::{SceneError, Shaft, eccentricity, implausible_unbalance};

/// A tolerance is relative to no less than this part of the energy norm of the equilibrium: what round-off leaves of it.
const FLOOR: f64 = 1e-9;

/// From the last whole step of a run to its end, the fastest motion turns by no more radians than this. Steps of the
/// exponential method are a tenth of a period of the slowest motion or as long as asked for, so that the limit is wide;
/// it keeps an invalid state from being followed for ever.
const MOST_CATCHING_UP: f64 = 1e12;

/// Where and how a run begins.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// How the reference shaft turns; elapsed time counts from its origin.
    pub course: ShaftRotation,
    /// The equilibrium that deviations are measured from.
    pub equilibrium: DVector<f64>,
    /// The smallest energy norm that a tolerance is relative to.
    pub floor: f64,
    /// The state.
    pub state: State,
    /// Whether a run with the same method and setting left it.
    pub resumes: bool,
}

/// The beginning that the options ask for.
pub(super) fn start(
    cached: &CachedModel,
    options: &Options,
    spectrum: &Spectrum,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Start, AnalysisError> {
    let model = &cached.model;
    let n = model.len();
    let fastest = options.fastest();
    let found = equilibrium(cached, options.geometry, fastest);
    // Bearings have the coefficients of the speed at which the run begins.
    let begin = |found: &DVector<f64>| match cached.model.bearings.is_empty() {
        true => Ok(found.clone()),
        false => equilibrium(&*cached.at_speed(options.speed.at(options.start))?, options.geometry, fastest),
    };
    let zero = || DVector::zeros(n);
    let course = |origin: f64, anchor: Anchor| ShaftRotation { speed: options.speed.clone(), anchor, origin, fastest };
    let absolute = course(options.start, Anchor::default());
    let (displacement, state, course) = match &options.initial {
        // From rest a scene may move that has no equilibrium; tolerances are then relative to the motion itself.
        Initial::Rest => (found.unwrap_or_else(|_| zero()), State::new(vec![0.0; 2 * n]), absolute),
        Initial::Continue(last) => {
            if last.state.y.len() != 2 * n {
                let message = format!("has {} degrees of freedom, this system has {n}", last.state.y.len() / 2);
                return Err(SceneError::new("initial", message).into());
            }
            let rest = last.time - last.origin - last.state.elapsed;
            if rest * spectrum.radius() > MOST_CATCHING_UP {
                let message = format!("is {rest:e} s before the end of the run, which no step is as long as");
                return Err(SceneError::new("initial.elapsed", message).into());
            }
            check_flanks(cached, last, fastest)?;
            let displacement = found.unwrap_or_else(|_| zero());
            if options.speed != last.speed {
                let anchor = Anchor { time: last.time, angle: last.course(last.origin).angle(last.time) };
                (displacement, State::new(arrive(cached, last, watch)?), course(last.time, anchor))
            } else if options.resumes(last) {
                (displacement, last.state.clone(), course(last.origin, last.anchor))
            } else {
                let at = last.origin + last.state.elapsed;
                (displacement, State::new(last.state.y.clone()), course(at, last.anchor))
            }
        }
        Initial::Static => {
            let found = found?;
            let y = [begin(&found)?.as_slice(), zero().as_slice()].concat();
            (found, State::new(y), absolute)
        }
        Initial::Synchronous => {
            let (found, speed) = (found?, options.speed.at(options.start));
            let amplitudes = with_flanks(cached, speed, fastest)?;
            check_size(cached, &amplitudes)?;
            let turns: Vec<_> = model.shafts.iter().map(|shaft| absolute.phasor_at_origin(shaft.ratio)).collect();
            let (q, v) = motion(cached, speed, &amplitudes, &turns);
            let y = [(begin(&found)? + q).as_slice(), v.as_slice()].concat();
            (found, State::new(y), absolute)
        }
    };
    let mut norm = EquationOfMotion::along(cached, Geometry::Frozen, &course, zero())?;
    let whole = [displacement.as_slice(), zero().as_slice()].concat();
    let floor = FLOOR * norm.norm(&whole);
    let floor = floor.max(f64::MIN_POSITIVE);
    let continues =
        matches!(&options.initial, Initial::Continue(last) if last.speed == options.speed && options.resumes(last));
    let Some(checkpoint) = &options.checkpoint else {
        return Ok(Start { course, equilibrium: displacement, floor, state, resumes: continues });
    };
    if checkpoint.state.y.len() != 2 * n || checkpoint.recorder_state.margins.len() != model.meshes.len() {
        return Err(SceneError::new("checkpoint", "is of a run of another system").into());
    }
    Ok(Start { course, equilibrium: displacement, floor, state: checkpoint.state.clone(), resumes: true })
}

/// A run continues with the flanks that pressed before: σ of no mesh may change, as backlash lies on the other side then.
fn check_flanks(cached: &CachedModel, last: &Final, fastest: f64) -> Result<(), SceneError> {
    let (model, before) = (&cached.model, last.course(last.origin).fastest);
    let changes = |mesh: &usize| model.sigma(*mesh, before) != model.sigma(*mesh, fastest);
    let Some(mesh) = (0..model.meshes.len()).find(changes) else {
        return Ok(());
    };
    let [driver, driven] = model.gear_names(mesh);
    let message = format!(
        "ran at {before} rad/s and cannot continue at {fastest} rad/s: the teeth of \"{driver}\" and \"{driven}\" would change their flanks (at speed 0 they follow the torque); start from \"static\" or \"synchronous\""
    );
    Err(SceneError::new("initial", message))
}

/// A linear synchronous motion as long as the shafts is that of an unbalance in wrong units, or of a critical speed with
/// too little damping.
fn check_size(cached: &CachedModel, amplitudes: &DMatrix<Complex<f64>>) -> Result<(), SceneError> {
    let model = &cached.model;
    let longest = model.scene.shafts.iter().map(Shaft::length).fold(0.0, f64::max);
    let translations = model.numbering.dofs().iter().filter(|dof| matches!(dof.kind, DofKind::V | DofKind::W));
    let largest = translations.map(|dof| amplitudes.row(dof.index).map(|value| value.norm()).max()).fold(0.0, f64::max);
    if largest < longest {
        return Ok(());
    }
    if let Some(body) = model.scene.bodies().find(|body| implausible_unbalance(&model.scene, body)) {
        let message = format!(
            "the synchronous motion would be {largest:.1e} m, because the unbalance of \"{}\" is {:.4e} kg m, an eccentricity of {:.1e} m; is it in g mm?",
            body.name,
            body.unbalance.norm(),
            eccentricity(&model.scene, body)
        );
        return Err(SceneError::new("initial", message));
    }
    let message = format!(
        "the synchronous motion would be {largest:.1e} m: this speed is a critical speed with too little damping; add damping, change the speed, or start from \"static\" or \"rest\""
    );
    Err(SceneError::new("initial", message))
}

/// The state of a run at its end, for one that goes on at another speed from there: what a run leaves is the state at
/// its last whole step.
fn arrive(cached: &CachedModel, last: &Final, watch: &mut dyn FnMut(f64) -> bool) -> Result<Vec<f64>, AnalysisError> {
    let n = cached.model.len();
    let rest = (last.time - last.origin) - last.state.elapsed;
    let mut state = State::new(last.state.y.clone());
    if rest > 0.0 {
        let course = last.course(last.origin + last.state.elapsed);
        let steps = (rest * Spectrum::new(cached, course.fastest)?.radius()).ceil().max(1.0);
        let control = StepControl::Fixed(rest / steps);
        let mut motion = EquationOfMotion::along(cached, last.geometry, &course, DVector::zeros(n))?;
        let mut method = RungeKutta::new(DORMAND_PRINCE, 2 * n);
        let end = steps * (rest / steps);
        run(&mut motion, &mut method, &control, &mut state, end, &mut Underway(watch), &mut Statistics::new())
            .map_err(|halted| explain(cached, &halted, course.origin))?;
    }
    Ok(state.y)
}

/// Asks whether to go on, and sees nothing.
struct Underway<'a>(&'a mut dyn FnMut(f64) -> bool);

impl Observer for Underway<'_> {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _motion: &mut impl Trajectory, _end: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn go_on(&mut self, _elapsed: f64) -> bool {
        (self.0)(0.0)
    }
}
