//! Runs in the coordinates of the modes at speed, and the conversion of states.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix};

use super::super::AnalysisError;
use super::super::synchronous::response_to;
use super::initial::Start;
use super::run_cache::{ResponseKey, RunModel};
use super::{Method, Options, ramp};
use crate::exponential::{InterfaceMaps, Loads, OutputMap, Selection, is_resonant};
use crate::integrate::State;
use crate::modal::{CachedModel, Highest, ModalStateSpace, Projected};
use crate::motion::{EquationOfMotion, RotatingLoad, Speed};

/// The parts of a run in modal coordinates.
#[derive(Clone)]
pub(super) struct ModalSetup<'m> {
    /// The linear motion ż = A z.
    pub linear: Arc<ModalStateSpace>,
    /// The loads on it.
    pub loads: Loads<'m>,
    /// The maps between both.
    pub maps: InterfaceMaps,
    /// The map to the recorded coordinates.
    pub output: OutputMap,
}

impl<'m> ModalSetup<'m> {
    /// Sets up a run of a motion that records a selection of coordinates. The linear motion is that of `subspace`, or of
    /// the complete model if there is none. The equilibrium and the synchronous motion are those of the complete model.
    pub fn new(
        cached: &'m RunModel<'_>,
        options: &Options,
        mut motion: EquationOfMotion<'m>,
        start: &Start,
        selection: Selection,
        subspace: Option<&Projected>,
    ) -> Result<Self, AnalysisError> {
        let (speed, changes) = (ramp::reference_speed(options), matches!(options.speed, Speed::Changing(_)));
        // The linear motion contains the bearings at the largest speed; slopes of torques, gyroscopic and circulatory forces at its own.
        motion.linearise_at(speed);
        let model = ramp::linear_model(cached, options)?;
        // With separation and varying stiffness, the mean mesh stiffness is a poor approximation: the linear part then
        // contains the shafts alone. Frames that turn couple these.
        let uncoupled = options.method == Method::Exponential
            && subspace.is_none()
            && options.modes.is_none()
            && !cached.model.scene.has_turning_frame()
            && motion.varying_flanks_can_separate();
        let without_meshes = if uncoupled { model.linear_without_meshes(speed)? } else { None };
        let linear = match (subspace, without_meshes) {
            (Some(subspace), _) => subspace.state_space()?,
            (None, Some(linear)) => linear,
            (None, None) => model.linear(speed)?,
        };
        // At a changing speed, bow and unbalance are loads, and no shaft is a source of synchronous motion.
        let mut amplitudes: DMatrix<Complex<f64>> = DMatrix::zeros(cached.model.len(), motion.sources().len());
        let sources: Vec<(usize, &RotatingLoad)> =
            motion.sources().iter().enumerate().filter(|(_, source)| !is_resonant(&linear, source.spin)).collect();
        if subspace.is_some() {
            let highest = Highest::Frequency(cached.model.max_speed_ratio() * speed.abs());
            for (column, source) in sources {
                amplitudes.set_column(column, &response_to(cached, speed, source, highest)?.phasors);
            }
        } else {
            let key = ResponseKey {
                linear: Arc::clone(&linear),
                spins: sources.iter().map(|(_, source)| source.spin).collect(),
                forces: sources.iter().map(|(_, source)| source.columns()).collect(),
            };
            let responses = cached.known.responses.get_or(key.clone(), || key.responses());
            for ((column, source), response) in sources.into_iter().zip(responses.iter()) {
                match response {
                    Some(found) => amplitudes.set_column(column, found),
                    None => {
                        let highest = Highest::Frequency(f64::INFINITY);
                        amplitudes.set_column(column, &response_to(cached, speed, source, highest)?.phasors);
                    }
                }
            }
        }
        let loads = Loads::new(motion, &linear, start.equilibrium.clone(), &amplitudes);
        let (mut loads, mut maps) = loads.map_err(|(mesh, overlap)| {
            let [driver, driven] = cached.model.gear_names(mesh);
            AnalysisError::overlap(driver, driven, "at the beginning", overlap)
        })?;
        if changes {
            let modes = subspace.map_or_else(|| model.real_modes(speed), |subspace| Ok(&subspace.modes))?;
            let change = ramp::speed_change(&cached.model, options, modes, selection.powers.is_some())?;
            loads.add_changing_speed(&linear, &change, &mut maps);
        }
        Ok(Self::recording(linear, loads, maps, selection))
    }

    /// The set-up of a linear motion with its loads that records a selection of coordinates.
    fn recording(linear: Arc<ModalStateSpace>, loads: Loads<'m>, maps: InterfaceMaps, selection: Selection) -> Self {
        let output = OutputMap::new(&loads, &linear, &maps, selection);
        Self { linear, loads, maps, output }
    }
}

/// Converts the initial state to modal coordinates.
pub(super) fn in_modal_coordinates(
    cached: &CachedModel,
    linear: &ModalStateSpace,
    loads: &Loads<'_>,
    start: &Start,
) -> State {
    let mut state = start.state.clone();
    let modal = std::mem::take(&mut state.modal);
    if resumes(linear, loads, start) {
        return State { y: modal, ..state };
    }
    let (reference_q, reference_v) = loads.reference_motion(state.elapsed);
    let half = reference_q.len();
    let minus = |given: &[f64], reference: &[f64]| -> Vec<f64> {
        given.iter().zip(reference).map(|(given, reference)| given - reference).collect()
    };
    let (q, v) = (minus(&state.y[..half], reference_q.as_slice()), minus(&state.y[half..], reference_v.as_slice()));
    let y = linear.state(&cached.model, &q, &v).as_slice().to_vec();
    // The step count starts at zero.
    State { elapsed: state.elapsed, ..State::new(y) }
}

/// Whether the stored z of an initial state gives exactly its displacements and velocities, so that a run continues from z.
pub(super) fn resumes(linear: &ModalStateSpace, loads: &Loads<'_>, start: &Start) -> bool {
    let State { elapsed, y, modal, .. } = &start.state;
    start.resumes && modal.len() == linear.len() && physical(linear, loads, *elapsed, modal) == *y
}

/// Converts the final state to displacements and velocities, and keeps its modal coordinates.
pub(super) fn in_physical_coordinates(mut state: State, linear: &ModalStateSpace, loads: &Loads<'_>) -> State {
    let y = physical(linear, loads, state.elapsed, &state.y);
    state.modal = std::mem::replace(&mut state.y, y);
    state
}

/// Displacements and velocities of a state z.
fn physical(linear: &ModalStateSpace, loads: &Loads<'_>, elapsed: f64, z: &[f64]) -> Vec<f64> {
    let (q, v) = linear.motion(z);
    let (reference_q, reference_v) = loads.reference_motion(elapsed);
    [(q + reference_q).as_slice(), (v + reference_v).as_slice()].concat()
}
