//! Runs in the coordinates of the modes at speed, and the conversion of states.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix};

use super::super::synchronous::synchronous_of;
use super::super::{AnalysisError, ExcitationPart};
use super::initial::Start;
use super::{Method, Options, ramp};
use crate::exponential::{InterfaceMaps, NonlinearLoads, OutputMap, Selection, is_resonant};
use crate::integrate::State;
use crate::modal::{CachedModel, ModalStateSpace};
use crate::motion::{EquationOfMotion, Speed};
use crate::scene::SceneError;

/// The parts of a run in modal coordinates.
pub(super) struct ModalSetup<'m> {
    /// The linear motion ż = A z.
    pub linear: Arc<ModalStateSpace>,
    /// The loads on it.
    pub nonlinear_loads: NonlinearLoads<'m>,
    /// The maps between both.
    pub maps: InterfaceMaps,
    /// The map to the recorded coordinates.
    pub output: OutputMap,
}

impl<'m> ModalSetup<'m> {
    /// Sets up a run of a motion that records a selection of coordinates.
    pub fn new(
        cached: &'m CachedModel,
        options: &Options,
        motion: EquationOfMotion<'m>,
        start: &Start,
        selection: Selection,
    ) -> Result<Self, AnalysisError> {
        let Speed::Constant(speed) = options.speed else {
            return Self::reduced(cached, options, ramp::set_up(cached, options, motion, start)?, selection);
        };
        // With separation and varying stiffness, the mean mesh stiffness is a poor approximation: the linear part then
        // contains the shafts alone.
        let linear = match options.method {
            Method::Exponential if options.modes.is_none() && motion.parts_and_varies() => {
                cached.linear_without_meshes(speed)?
            }
            _ => None,
        };
        let linear = linear.map_or_else(|| cached.linear(speed), Ok)?;
        let mut amplitudes: DMatrix<Complex<f64>> = DMatrix::zeros(cached.model.len(), cached.model.shafts.len());
        for shaft in motion.sources().filter(|shaft| !is_resonant(&linear, motion.spin(*shaft))) {
            let known = linear.synchronous(motion.spin(shaft), &motion.turning_forces(shaft));
            let amplitude =
                known.map_or_else(|| synchronous_of(cached, speed, speed, shaft, ExcitationPart::Both), Ok)?;
            amplitudes.set_column(shaft, &amplitude);
        }
        let loads = NonlinearLoads::new(motion, &linear, start.equilibrium.clone(), &amplitudes);
        let (nonlinear_loads, maps) = ramp::without_overlap(cached, loads)?;
        Self::reduced(cached, options, (linear, nonlinear_loads, maps), selection)
    }

    /// Reduces linear motion and maps to the modes that the options ask for.
    fn reduced(
        cached: &CachedModel,
        options: &Options,
        (linear, nonlinear_loads, maps): ramp::Complete<'m>,
        selection: Selection,
    ) -> Result<Self, AnalysisError> {
        let (linear, maps) = match options.modes {
            Some(count) => keep_modes(cached, &linear, &nonlinear_loads, &maps, count)?,
            None => (linear, maps),
        };
        let output = OutputMap::new(&nonlinear_loads, &linear, selection);
        Ok(Self { linear, nonlinear_loads, maps, output })
    }
}

/// Reduces the linear motion and its maps to the modes that the loads excite most. The equilibrium and the synchronous
/// motion keep all modes.
fn keep_modes(
    cached: &CachedModel,
    linear: &ModalStateSpace,
    nonlinear_loads: &NonlinearLoads<'_>,
    maps: &InterfaceMaps,
    count: usize,
) -> Result<(Arc<ModalStateSpace>, InterfaceMaps), AnalysisError> {
    let constant: Vec<(usize, f64)> = cached.model.constant_load.iter().copied().enumerate().collect();
    let motion = &nonlinear_loads.motion;
    let turning = motion.sources().flat_map(|shaft| motion.turning_forces(shaft));
    let other = turning.chain([constant]).map(|load| linear.column(&load));
    // Modes are not chosen for the loads by which a changing speed couples them.
    let acting = maps.columns[..maps.scalars].iter().chain(&maps.columns[maps.meshes..]);
    let loads: Vec<Vec<f64>> = acting.cloned().chain(other).collect();
    let slots = linear.most_excited(&loads, count);
    let Some(kept) = linear.select_pairs(&slots) else {
        let message = format!("cannot be left out: they do not carry the motion, condition {:.1e}", linear.condition);
        return Err(SceneError::new("modes", message).into());
    };
    let pick = |row: &Vec<f64>| kept.select_entries(row, &slots);
    let [rows, columns] = [&maps.rows, &maps.columns].map(|list| list.iter().map(pick).collect());
    let maps = InterfaceMaps { rows, columns, parts: kept.parts.clone(), ..maps.clone() };
    Ok((Arc::new(kept), maps))
}

/// Converts the initial state to modal coordinates.
pub(super) fn enter(
    cached: &CachedModel,
    linear: &ModalStateSpace,
    nonlinear_loads: &NonlinearLoads<'_>,
    start: &Start,
) -> State {
    let mut state = start.state.clone();
    let modal = std::mem::take(&mut state.modal);
    // The stored z is used only if it gives exactly the stored displacements and velocities.
    let resumes = start.resumes
        && modal.len() == linear.len()
        && physical(linear, nonlinear_loads, state.elapsed, &modal) == state.y;
    if resumes {
        return State { y: modal, ..state };
    }
    let (reference_q, reference_v) = nonlinear_loads.reference_motion(state.elapsed);
    let half = reference_q.len();
    let minus = |given: &[f64], reference: &[f64]| -> Vec<f64> {
        given.iter().zip(reference).map(|(given, reference)| given - reference).collect()
    };
    let (q, v) = (minus(&state.y[..half], reference_q.as_slice()), minus(&state.y[half..], reference_v.as_slice()));
    let y = linear.state(&cached.model, &q, &v).as_slice().to_vec();
    // The step count starts at zero.
    State { elapsed: state.elapsed, ..State::new(y) }
}

/// Converts the final state to displacements and velocities, and keeps its modal coordinates.
pub(super) fn leave(mut state: State, linear: &ModalStateSpace, nonlinear_loads: &NonlinearLoads<'_>) -> State {
    let y = physical(linear, nonlinear_loads, state.elapsed, &state.y);
    state.modal = std::mem::replace(&mut state.y, y);
    state
}

/// Displacements and velocities of a state z.
fn physical(linear: &ModalStateSpace, nonlinear_loads: &NonlinearLoads<'_>, elapsed: f64, z: &[f64]) -> Vec<f64> {
    let (q, v) = linear.motion(z);
    let (reference_q, reference_v) = nonlinear_loads.reference_motion(elapsed);
    [(q + reference_q).as_slice(), (v + reference_v).as_slice()].concat()
}
