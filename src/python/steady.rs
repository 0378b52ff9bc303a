//! `_core.steady_state`, `multipliers` and what branches need: steady states of a model, found without the interpreter lock.

use std::sync::Arc;

use nalgebra::Complex;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use pythonize::pythonize;
use serde::Serialize;

use super::background;
use super::errors::{warn, warn_of_speed};
use super::handle::PyModel;
use super::options::{RecordEntry, record_plan, run_options};
use super::response::response_dict;
use super::state::mesh_geometry;
use crate::analysis::simulate::{Options, Reduction};
use crate::analysis::steady::Wanted;
use crate::analysis::{equilibrium, small_displacement_check, steady};
use crate::mesh::Geometry;
use crate::modal::RealModes;
use crate::scene::{EntryPath, SceneError};

/// What the solution says about itself; `SteadyData` in `gearbow._types` lists the same entries.
#[derive(Serialize)]
struct SteadyEntries {
    /// Period, s; infinite without one.
    period: f64,
    /// Relative difference after one more period.
    residual: f64,
    /// Number of integrated periods.
    periods: usize,
    /// Name of the method.
    method: &'static str,
}

/// Common period of the excitation of a model at a speed, s: the given one, or that of the scene up to `longest`.
#[pyfunction]
#[pyo3(signature = (model, speed, given, longest))]
pub fn common_period(model: &Bound<'_, PyModel>, speed: f64, given: Option<f64>, longest: f64) -> PyResult<f64> {
    EntryPath::root("speed").finite(speed)?;
    let found = steady::common_period(model.get().model(), speed, given, longest);
    if found.is_err() {
        // Torques that do not balance are the more important message.
        equilibrium(&model.get().cached, Geometry::Frozen, speed)?;
    }
    Ok(found?)
}

/// Longest period of a source of excitation, s; None if nothing excites, or if a load has an unknown frequency.
#[pyfunction]
pub fn slowest_period(model: &Bound<'_, PyModel>, speed: f64) -> Option<f64> {
    steady::slowest_period(model.get().model(), speed)
}

/// Finds the steady state with the period `duration` and records a number of samples. With `slowest`, the longest period of a
/// source, s, it has no period and runs in; `duration` is then that of the record.
///
/// # Errors
/// The reason for which there is none, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, samples, record, progress, slowest, **options))]
pub fn steady_state<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    samples: usize,
    record: Vec<RecordEntry>,
    progress: Option<Py<PyAny>>,
    slowest: Option<f64>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyAny>)> {
    let (py, owner) = (model.py(), model.get());
    let options = run_options(py, initial, options)?;
    if let Some(text) = options.unattainable() {
        warn(py, text)?;
    }
    owner.warn_of_ill_conditioning(py, owner.representative_speed(options.fastest()), options.dense(owner.model()))?;
    warn_of_speed(py, &owner.model().scene, options.fastest())?;
    let plan = record_plan(owner.model(), record)?;
    plan.require_memory(owner.model(), samples)?;
    let (cached, recorded) = (Arc::clone(&owner.cached), plan.clone());
    let found = background::reported_result(py, progress.as_ref(), move |_, watch| match slowest {
        None => steady::steady_state(&cached, &options, &recorded, samples, watch),
        Some(slowest) => steady::settled_state(&cached, &options, &recorded, slowest, samples, watch),
    })?;
    let largest = found.response.record.displacement.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let entries = SteadyEntries {
        period: found.period,
        residual: found.residual,
        periods: found.periods,
        method: match (found.period.is_finite(), found.is_affine) {
            (false, _) => "quasi-periodic",
            (true, true) => "linear",
            (true, false) => "nonlinear",
        },
    };
    if let Some(text) = found.warning {
        warn(py, text)?;
    }
    let response = response_dict(owner, py, &plan, found.response)?;
    if let Some(text) = small_displacement_check(owner.model(), largest) {
        warn(py, text)?;
    }
    Ok((response, pythonize(py, &entries)?))
}

/// The modes that runs of several systems and speeds keep.
#[pyclass(name = "KeptModes", module = "gearbow._core", frozen)]
pub struct PyKeptModes {
    modes: Arc<RealModes>,
    reduction: Reduction,
}

#[pymethods]
impl PyKeptModes {
    /// Number of modes.
    #[getter]
    fn modes(&self) -> usize {
        self.reduction.modes
    }

    /// Estimated error of displacements and of mesh forces.
    #[getter]
    fn modes_error(&self) -> (f64, f64) {
        self.reduction.errors.into()
    }
}

/// Finds the modes that a period with the given options keeps; None if it keeps all modes.
///
/// # Errors
/// The reason for which the runs end early, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, record, **options))]
pub fn kept_modes(
    model: &Bound<'_, PyModel>,
    initial: &Bound<'_, PyAny>,
    record: Vec<RecordEntry>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Option<PyKeptModes>> {
    let (py, owner) = (model.py(), model.get());
    let options = run_options(py, initial, options)?;
    let plan = record_plan(owner.model(), record)?;
    let cached = Arc::clone(&owner.cached);
    let found =
        background::reported_result(py, None, move |_, watch| steady::kept_modes(&cached, &options, &plan, watch))?;
    Ok(found.map(|(modes, reduction)| PyKeptModes { modes, reduction }))
}

/// The options of a run that keeps given modes.
fn options_with_modes(
    py: Python<'_>,
    initial: &Bound<'_, PyAny>,
    kept: Option<&Bound<'_, PyKeptModes>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Options> {
    Ok(Options { kept_modes: kept.map(|kept| Arc::clone(&kept.get().modes)), ..run_options(py, initial, options)? })
}

/// Finds the multipliers of magnitude `smallest` and more of a steady state; with `only_largest`, smaller ones may be missing.
///
/// # Errors
/// The reason for which the runs end early, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, smallest, record, progress, only_largest=false, kept=None, **options))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
pub fn multipliers<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    smallest: f64,
    record: Vec<RecordEntry>,
    progress: Option<Py<PyAny>>,
    only_largest: bool,
    kept: Option<&Bound<'py, PyKeptModes>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyArray1<Complex<f64>>>> {
    let (py, owner) = (model.py(), model.get());
    let wanted = Wanted { smallest, only_largest };
    let options = options_with_modes(py, initial, kept, options)?;
    let plan = record_plan(owner.model(), record)?;
    let cached = Arc::clone(&owner.cached);
    let found = background::reported_result(py, progress.as_ref(), move |_, watch| {
        steady::multipliers(&cached, &options, &plan, wanted, watch)
    })?;
    Ok(PyArray1::from_vec(py, found))
}

/// Corrects states, one a row, by one step of the fixed-point iteration, with given step levels; see
/// [`steady::corrected_states`].
///
/// # Errors
/// The reason for which a run ends early, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, states, levels, kept=None, **options))]
pub fn corrected_states<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    states: PyReadonlyArray2<'py, f64>,
    levels: Option<Vec<u8>>,
    kept: Option<&Bound<'py, PyKeptModes>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyBytes>)> {
    let (py, owner) = (model.py(), model.get());
    let options = options_with_modes(py, initial, kept, options)?;
    let given = states.as_array();
    let states = given.rows().into_iter().map(|row| core_order(owner, &row.to_vec()));
    let states = states.collect::<PyResult<Vec<Vec<f64>>>>()?;
    let cached = Arc::clone(&owner.cached);
    let found = background::reported_result(py, None, move |_, watch| {
        steady::corrected_states(&cached, &options, &states, levels.as_deref(), watch)
    })?;
    let numbering = &owner.model().numbering;
    let rows: Vec<Vec<f64>> = found.states.iter().map(|row| by_halves(row, |q| numbering.to_user_order(q))).collect();
    Ok((PyArray2::from_vec2(py, &rows)?, PyBytes::new(py, &found.levels)))
}

/// Whether the equation of motion has constant coefficients with a mesh geometry; see [`steady::has_constant_coefficients`].
#[pyfunction]
pub fn has_constant_coefficients(model: &Bound<'_, PyModel>, geometry: &str) -> PyResult<bool> {
    Ok(steady::has_constant_coefficients(model.get().model(), mesh_geometry(geometry)?))
}

/// The initial state of a run.
///
/// # Errors
/// The reason for which there is none, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, **options))]
pub fn initial_state<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (py, owner) = (model.py(), model.get());
    let options = run_options(py, initial, options)?;
    let cached = Arc::clone(&owner.cached);
    let state = background::reported_result(py, None, move |_, watch| steady::initial_state(&cached, &options, watch))?;
    Ok(PyArray1::from_vec(py, by_halves(&state, |q| owner.model().numbering.to_user_order(q))))
}

/// Records a number of samples of the period that begins in a state.
///
/// # Errors
/// The reason for which the run ends early, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, state, samples, record, kept=None, **options))]
pub fn recorded_period<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    state: PyReadonlyArray1<'py, f64>,
    samples: usize,
    record: Vec<RecordEntry>,
    kept: Option<&Bound<'py, PyKeptModes>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (py, owner) = (model.py(), model.get());
    let options = options_with_modes(py, initial, kept, options)?;
    let state = core_order(owner, state.as_slice()?)?;
    let plan = record_plan(owner.model(), record)?;
    plan.require_memory(owner.model(), samples)?;
    let (cached, recorded) = (Arc::clone(&owner.cached), plan.clone());
    let found = background::reported_result(py, None, move |_, watch| {
        steady::recorded_period(&cached, &options, &recorded, &state, samples, watch)
    })?;
    response_dict(owner, py, &plan, found)
}

/// Displacements and velocities in the order of the core.
fn core_order(owner: &PyModel, state: &[f64]) -> PyResult<Vec<f64>> {
    let numbering = &owner.model().numbering;
    if state.len() != 2 * numbering.len() {
        return Err(SceneError::new("state", format!("must have {} entries", 2 * numbering.len())).into());
    }
    Ok(by_halves(state, |q| numbering.in_core_order(q)))
}

/// Displacements and velocities of the core in the order of the degrees of freedom that users see.
///
/// # Errors
/// [`SceneError`] for a state of another system.
#[pyfunction]
pub fn user_order<'py>(
    model: &Bound<'py, PyModel>,
    state: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (numbering, state) = (&model.get().model().numbering, state.as_slice()?);
    if state.len() != 2 * numbering.len() {
        return Err(SceneError::new("state", "is of a system with other nodes").into());
    }
    Ok(PyArray1::from_vec(model.py(), by_halves(state, |q| numbering.to_user_order(q))))
}

/// Converts displacements and velocities, the two halves of a state.
fn by_halves(state: &[f64], convert: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    state.chunks((state.len() / 2).max(1)).flat_map(convert).collect()
}
