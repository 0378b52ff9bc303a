//! The initial state of a run.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix, DVector};

use super::super::equilibrium::{equilibrium, equilibrium_with_flanks};
use super::super::synchronous::{motion, response_to, synchronous_of};
use super::super::{AnalysisError, ExcitationPart, Spectrum};
use super::heartbeat::Waiting;
use super::run_cache::{Amplitudes, RunModel, SynchronousKey};
use super::{Final, Initial, Options, explain};
use crate::integrate::tableau::DORMAND_PRINCE;
use crate::integrate::{RungeKutta, State, Statistics, StepControl, run};
use crate::modal::{CachedModel, EquilibriumSpeeds, Highest};
use crate::model::{Model, ShaftModel};
use crate::motion::{Anchor, EquationOfMotion, RotatingLoad, ShaftRotation};
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::{SceneError, Shaft, eccentricity, implausible_unbalance};

/// Largest rotation of the fastest mode from the last whole step of a run to its end, rad. Steps of the exponential method
/// can contain many periods of the fastest mode, so that the limit is wide. It rejects an invalid state whose end would
/// never be reached.
const MAX_REMAINING_ROTATION: f64 = 1e12;

/// Initial conditions of a run.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// Rotation of the reference shaft. Elapsed time counts from its origin.
    pub rotation: ShaftRotation,
    /// Displacements of the equilibrium, from which deviations are measured.
    pub equilibrium: DVector<f64>,
    /// Smallest energy norm that a tolerance is relative to.
    pub floor: f64,
    /// The initial state.
    pub state: State,
    /// Whether a run with the same method and setting left the state.
    pub resumes: bool,
}

impl Start {
    /// Whether a run left the state that had fewer modes than the model has coordinates, and this run continues it.
    pub fn is_reduced(&self, model: &Model) -> bool {
        self.resumes && (1..2 * model.len()).contains(&self.state.modal.len())
    }

    /// Initial conditions with which the run could begin at another time, s: the same displacements and velocities if they
    /// do not rotate, and otherwise synchronous motion, if there is one.
    pub fn moved(&self, cached: &RunModel<'_>, options: &Options, time: f64) -> Self {
        let rotation = ShaftRotation { origin: time, ..self.rotation.clone() };
        let moving = match options.initial {
            Initial::Rest | Initial::Static => None,
            Initial::Synchronous | Initial::Continue(_) => {
                synchronous(cached, options, &self.equilibrium, &rotation).ok()
            }
        };
        let y = moving.unwrap_or_else(|| self.state.y.clone());
        let state = State { elapsed: time - self.rotation.origin, ..State::new(y) };
        Self { state, resumes: false, ..self.clone() }
    }
}

/// Displacements of the equilibrium, initial state, and rotation of the reference shaft.
type Beginning = (DVector<f64>, State, ShaftRotation);

/// Prepares the beginning of a run.
pub(super) fn start(
    cached: &RunModel<'_>,
    options: &Options,
    spectrum: &Spectrum,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Start, AnalysisError> {
    let model = &cached.model;
    let n = model.len();
    let fastest = options.fastest();
    let zero = || DVector::zeros(n);
    let rest = || State::new(vec![0.0; 2 * n]);
    let found = equilibrium(cached, options.geometry, fastest);
    let absolute =
        ShaftRotation { speed: options.speed.clone(), anchor: Anchor::default(), origin: options.start, fastest };
    let (displacement, state, rotation) = match &options.initial {
        // A run from rest needs no equilibrium. Without one, tolerances are relative to the motion itself.
        Initial::Rest => (found.unwrap_or_else(|_| zero()), rest(), absolute),
        Initial::Continue(last) => continued(cached, options, last, spectrum, found.unwrap_or_else(|_| zero()), watch)?,
        Initial::Static => {
            let found = found?;
            let y = [equilibrium_at(cached, options, &found, options.start)?.as_slice(), zero().as_slice()].concat();
            (found, State::new(y), absolute)
        }
        Initial::Synchronous => {
            let found = found?;
            let y = synchronous(cached, options, &found, &absolute)?;
            (found, State::new(y), absolute)
        }
    };
    let norm = EquationOfMotion::elastic_norm(model, fastest, displacement.as_slice());
    let floor = (EQUALITY_TOLERANCE * norm).max(f64::MIN_POSITIVE);
    let continues =
        matches!(&options.initial, Initial::Continue(last) if last.speed == options.speed && options.resumes(last));
    let Some(checkpoint) = &options.checkpoint else {
        return Ok(Start { rotation, equilibrium: displacement, floor, state, resumes: continues });
    };
    if checkpoint.state.y.len() != 2 * n || checkpoint.recorder_state.margins.len() != model.meshes.len() {
        return Err(SceneError::new("checkpoint", "is of a run of another system").into());
    }
    Ok(Start { rotation, equilibrium: displacement, floor, state: checkpoint.state.clone(), resumes: true })
}

/// Refuses to continue a run if σ of a mesh changes, because the opposite flank would then be in contact.
fn check_flanks(cached: &CachedModel, last: &Final, fastest: f64) -> Result<(), SceneError> {
    let (model, before) = (&cached.model, last.rotation(last.origin).fastest);
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

/// Returns the initial conditions of a run that continues another one.
fn continued(
    cached: &CachedModel,
    options: &Options,
    last: &Final,
    spectrum: &Spectrum,
    displacement: DVector<f64>,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Beginning, AnalysisError> {
    let n = cached.model.len();
    if last.state.y.len() != 2 * n {
        let message = format!("has {} degrees of freedom, this system has {n}", last.state.y.len() / 2);
        return Err(SceneError::new("initial", message).into());
    }
    let rest = last.time - last.origin - last.state.elapsed;
    if rest * spectrum.radius() > MAX_REMAINING_ROTATION {
        let message = format!(
            "is {rest:e} s before the end of the run, which is longer than any step; give the final state of a run unchanged"
        );
        return Err(SceneError::new("initial.elapsed", message).into());
    }
    let (speed, fastest) = (options.speed.clone(), options.fastest());
    check_flanks(cached, last, fastest)?;
    let rotation = |origin: f64, anchor: Anchor| ShaftRotation { speed, anchor, origin, fastest };
    if options.speed != last.speed {
        let anchor = Anchor { time: last.time, angle: last.rotation(last.origin).angle(last.time) };
        Ok((displacement, State::new(complete(cached, last, watch)?), rotation(last.time, anchor)))
    } else if options.resumes(last) {
        Ok((displacement, last.state.clone(), rotation(last.origin, last.anchor)))
    } else {
        let at = last.origin + last.state.elapsed;
        Ok((displacement, State::new(last.state.y.clone()), rotation(at, last.anchor)))
    }
}

/// Displacements of the equilibrium with the bearing coefficients of the speed at a time, s; `found` is the equilibrium of
/// bearings with constant coefficients.
fn equilibrium_at(
    cached: &CachedModel,
    options: &Options,
    found: &DVector<f64>,
    time: f64,
) -> Result<DVector<f64>, AnalysisError> {
    let speeds = EquilibriumSpeeds { film: options.speed.at(time), flanks: options.fastest() };
    if cached.model.is_at_speed(speeds.film) {
        return Ok(found.clone());
    }
    equilibrium_with_flanks(cached, options.geometry, speeds)
}

/// Complex amplitudes of the synchronous motion of a key, one column for each source shaft.
fn amplitudes(cached: &CachedModel, key: SynchronousKey) -> Result<DMatrix<Complex<f64>>, AnalysisError> {
    let SynchronousKey { speed, flank_speed, uses_components } = key;
    let model = &cached.model;
    let mut amplitudes = DMatrix::zeros(model.len(), model.shafts.len());
    // A reduced run has modal damping on few modes.
    let fastest = model.max_speed_ratio() * speed.abs();
    let highest = Highest::Frequency(if uses_components { fastest } else { f64::INFINITY });
    for shaft in 0..model.shafts.len() {
        let found = synchronous_of(cached, speed, flank_speed, shaft, ExcitationPart::All, highest)?;
        amplitudes.set_column(shaft, &found.phasors);
    }
    Ok(amplitudes)
}

/// The synchronous motion of a key, which the runs of a system share.
fn synchronous_amplitudes(cached: &RunModel<'_>, key: SynchronousKey) -> Result<Amplitudes, AnalysisError> {
    cached.known.synchronous.get_or_try(key, || amplitudes(cached, key).map(Arc::new))
}

/// Displacements and velocities of the equilibrium `found` plus the linear synchronous motion at the origin of `rotation`.
fn synchronous(
    cached: &RunModel<'_>,
    options: &Options,
    found: &DVector<f64>,
    rotation: &ShaftRotation,
) -> Result<Vec<f64>, AnalysisError> {
    let time = rotation.origin;
    let speed = options.speed.at(time);
    let uses_components = options.uses_components(&cached.model);
    let flank_speed = options.fastest();
    let amplitudes = synchronous_amplitudes(cached, SynchronousKey { speed, flank_speed, uses_components })?;
    check_size(cached, &amplitudes)?;
    let ratios = cached.model.shafts.iter().map(ShaftModel::ratio_in_frame);
    let phasors: Vec<_> = ratios.map(|ratio| rotation.phasor_at_origin(ratio)).collect();
    let (mut q, mut v) = motion(cached, speed, &amplitudes, &phasors);
    for weight in RotatingLoad::weights(&cached.model, rotation) {
        let phasor = weight.phasor(0.0, None);
        let found = response_to(cached, speed, &weight, Highest::Frequency(f64::INFINITY))?.phasors;
        for (index, amplitude) in found.iter().enumerate() {
            let value = amplitude * phasor;
            q[index] += value.re;
            v[index] -= weight.spin * value.im;
        }
    }
    Ok([(equilibrium_at(cached, options, found, time)? + q).as_slice(), v.as_slice()].concat())
}

/// Refuses a synchronous motion larger than the shafts are long: its unbalance is in a wrong unit, or the speed is a
/// critical speed with too little damping.
fn check_size(cached: &CachedModel, amplitudes: &DMatrix<Complex<f64>>) -> Result<(), SceneError> {
    let model = &cached.model;
    let longest = model.scene.shafts.iter().map(Shaft::length).fold(0.0, f64::max);
    let translations = model.translations();
    let largest = translations.map(|index| amplitudes.row(index).map(|value| value.norm()).max()).fold(0.0, f64::max);
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

/// Integrates from the final state of a run, which belongs to its last whole step, to the end of the run. A run at another
/// speed continues from there.
fn complete(cached: &CachedModel, last: &Final, watch: &mut dyn FnMut(f64) -> bool) -> Result<Vec<f64>, AnalysisError> {
    let n = cached.model.len();
    let rest = (last.time - last.origin) - last.state.elapsed;
    let mut state = State::new(last.state.y.clone());
    if rest > 0.0 {
        let rotation = last.rotation(last.origin + last.state.elapsed);
        let steps = (rest * Spectrum::new(cached, rotation.fastest)?.radius()).ceil().max(1.0);
        let control = StepControl::Fixed(rest / steps);
        let motion = EquationOfMotion::along(cached, last.geometry, &rotation, DVector::zeros(n));
        let mut motion = motion.with_modal_damping(cached)?;
        let mut method = RungeKutta::new(DORMAND_PRINCE, 2 * n);
        let end = steps * (rest / steps);
        run(&mut motion, &mut method, &control, &mut state, end, &mut Waiting::new(watch), &mut Statistics::new())
            .map_err(|halted| explain(cached, &halted, rotation.origin))?;
    }
    Ok(state.y)
}
