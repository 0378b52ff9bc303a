//! Runs in the coordinates of the modes at speed: states to and from them.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix};

use super::super::synchronous::synchronous_of;
use super::super::{AnalysisError, ExcitationPart};
use super::initial::Start;
use super::{Method, Options};
use crate::exponential::{InterfaceMaps, NonlinearLoads, OutputMap, Selection, is_resonant};
use crate::integrate::State;
use crate::modal::{CachedModel, ModalStateSpace};
use crate::motion::{EquationOfMotion, Speed};
use crate::scene::SceneError;

/// What a run in the coordinates of the modes is made of.
pub(super) struct ModalSetup<'m> {
    pub linear: Arc<ModalStateSpace>,
    pub field: NonlinearLoads<'m>,
    pub maps: InterfaceMaps,
    pub output: OutputMap,
}

impl<'m> ModalSetup<'m> {
    /// The coordinates of a motion, for a run that looks at a selection of it.
    pub fn new(
        cached: &'m CachedModel,
        options: &Options,
        motion: EquationOfMotion<'m>,
        start: &Start,
        selection: Selection,
    ) -> Result<Self, AnalysisError> {
        let Speed::Constant(speed) = options.speed else {
            let message = format!(
                "\"{}\" needs a constant speed, whose modes carry the motion; use \"rk45\" or \"rk4\"",
                options.method.name()
            );
            return Err(SceneError::new("method", message).into());
        };
        // Teeth that part and whose stiffness varies leave little of the mean mesh for the linear motion to be exact about.
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
        let field = NonlinearLoads::new(motion, &linear, start.equilibrium.clone(), &amplitudes);
        let (field, maps) = field.map_err(|(mesh, overlap)| {
            let [driver, driven] = cached.model.gear_names(mesh);
            AnalysisError::overlap(driver, driven, "at the beginning", overlap)
        })?;
        let (linear, maps) = match options.modes {
            Some(count) => keeping(cached, &linear, &field, &maps, count)?,
            None => (linear, maps),
        };
        let output = OutputMap::new(&field, &linear, selection);
        Ok(Self { linear, field, maps, output })
    }
}

/// The linear motion of the modes that the loads of a scene move most, and its ports. What is carried beside it, the
/// equilibrium and the synchronous motion, is that of all modes.
fn keeping(
    cached: &CachedModel,
    linear: &ModalStateSpace,
    field: &NonlinearLoads<'_>,
    maps: &InterfaceMaps,
    count: usize,
) -> Result<(Arc<ModalStateSpace>, InterfaceMaps), AnalysisError> {
    let constant: Vec<(usize, f64)> = cached.model.constant_load.iter().copied().enumerate().collect();
    let turning = field.motion.sources().flat_map(|shaft| field.motion.turning_forces(shaft));
    let other = turning.chain([constant]).map(|load| linear.column(&load));
    let loads: Vec<Vec<f64>> = maps.columns.iter().cloned().chain(other).collect();
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

/// The state that a run begins with, in coordinates of the modes.
pub(super) fn enter(
    cached: &CachedModel,
    linear: &ModalStateSpace,
    field: &NonlinearLoads<'_>,
    start: &Start,
) -> State {
    let mut state = start.state.clone();
    let own = linear.len();
    // The coordinates that a run left are taken up if they stand for the state beside them, to the last bit.
    let resumes = start.resumes
        && state.memory.len() >= own
        && physical(linear, field, state.elapsed, &state.memory[..own]) == state.y;
    if resumes {
        let memory = state.memory.split_off(own);
        state.y = std::mem::replace(&mut state.memory, memory);
    } else {
        let (q, v) = field.carried(state.elapsed);
        let half = q.len();
        let less = |given: &[f64], carried: &[f64]| -> Vec<f64> {
            given.iter().zip(carried).map(|(given, carried)| given - carried).collect()
        };
        let (q, v) = (less(&state.y[..half], q.as_slice()), less(&state.y[half..], v.as_slice()));
        let y = linear.state(&cached.model, &q, &v).as_slice().to_vec();
        // Steps count anew from here.
        state = State { elapsed: state.elapsed, ..State::new(y) };
    }
    state
}

/// A state in displacements and velocities, the coordinates of the modes in its memory.
pub(super) fn leave(mut state: State, linear: &ModalStateSpace, field: &NonlinearLoads<'_>) -> State {
    let y = physical(linear, field, state.elapsed, &state.y);
    let z = std::mem::replace(&mut state.y, y);
    state.memory = [z, state.memory].concat();
    state
}

/// Displacements and velocities of a state z.
fn physical(linear: &ModalStateSpace, field: &NonlinearLoads<'_>, elapsed: f64, z: &[f64]) -> Vec<f64> {
    let (q, v) = linear.motion(z);
    let (carried_q, carried_v) = field.carried(elapsed);
    [(q + carried_q).as_slice(), (v + carried_v).as_slice()].concat()
}
