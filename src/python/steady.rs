//! `_core.steady_state`, `multipliers` and `period_map`: steady states of a model, found without the interpreter lock.

use std::sync::Arc;

use nalgebra::Complex;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use serde::Serialize;

use super::background;
use super::errors::{warn, warn_of_speed};
use super::handle::PyModel;
use super::options::{RecordEntry, run_options};
use super::response::response_dict;
use crate::analysis::simulate::RecordPlan;
use crate::analysis::{AnalysisError, equilibrium, small_displacement_check, steady};
use crate::mesh::Geometry;
use crate::scene::{EntryPath, SceneError};

/// States after a period, one row each, and the recorded period.
type Images<'py> = (Bound<'py, PyArray2<f64>>, Option<Bound<'py, PyDict>>);

/// What the solution says about itself; `SteadyData` in `gearbow._types` lists the same entries.
#[derive(Serialize)]
struct SteadyEntries {
    /// Period, s.
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

/// Finds the steady state with the period `duration` and records a number of samples.
///
/// # Errors
/// The reason for which there is none, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, samples, record, progress, **options))]
pub fn steady_state<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    samples: usize,
    record: Vec<RecordEntry>,
    progress: Option<Py<PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyAny>)> {
    let (py, owner) = (model.py(), model.get());
    let options = run_options(py, initial, options)?;
    if let Some(text) = options.unattainable() {
        warn(py, text)?;
    }
    owner.warn_of_ill_conditioning(py, owner.representative_speed(options.fastest()), options.dense(owner.model()))?;
    warn_of_speed(py, &owner.model().scene, options.fastest())?;
    let progress = progress.as_ref();
    let plan = record_plan(owner, record)?;
    let (cached, recorded) = (Arc::clone(&owner.cached), plan.clone());
    let (outcome, raised) = background::run(py, progress, move |_, watch| {
        steady::steady_state(&cached, &options, &recorded, samples, watch)
    })?;
    let found = finished(outcome, raised)?;
    let largest = found.response.record.displacement.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let entries = SteadyEntries {
        period: found.period,
        residual: found.residual,
        periods: found.periods,
        method: if found.is_affine { "linear" } else { "nonlinear" },
    };
    let response = response_dict(owner, py, &plan, found.response)?;
    if let Some(text) = small_displacement_check(owner.model(), largest) {
        warn(py, text)?;
    }
    Ok((response, pythonize(py, &entries)?))
}

/// Finds the multipliers of magnitude `smallest` and more of a steady state.
///
/// # Errors
/// The reason for which the runs end early, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, smallest, record, progress, **options))]
pub fn multipliers<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    smallest: f64,
    record: Vec<RecordEntry>,
    progress: Option<Py<PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyArray1<Complex<f64>>>> {
    let (py, owner) = (model.py(), model.get());
    let options = run_options(py, initial, options)?;
    let progress = progress.as_ref();
    let plan = record_plan(owner, record)?;
    let cached = Arc::clone(&owner.cached);
    let (outcome, raised) =
        background::run(py, progress, move |_, watch| steady::multipliers(&cached, &options, &plan, smallest, watch))?;
    Ok(PyArray1::from_vec(py, finished(outcome, raised)?))
}

/// States after one period and the recorded period from the first state; see [`steady::period_map`].
///
/// # Errors
/// The reason for which a run ends early, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (model, *, initial, states, samples, record, **options))]
#[expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]
pub fn period_map<'py>(
    model: &Bound<'py, PyModel>,
    initial: &Bound<'py, PyAny>,
    states: PyReadonlyArray2<'py, f64>,
    samples: usize,
    record: Vec<RecordEntry>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Images<'py>> {
    let (py, owner) = (model.py(), model.get());
    let options = run_options(py, initial, options)?;
    let numbering = &owner.model().numbering;
    let states = states.as_array();
    if states.ncols() != 2 * numbering.len() {
        return Err(SceneError::new("states", format!("must have {} columns", 2 * numbering.len())).into());
    }
    let states = states.rows().into_iter().map(|row| by_halves(&row.to_vec(), |q| numbering.in_core_order(q)));
    let states: Vec<Vec<f64>> = states.collect();
    let plan = record_plan(owner, record)?;
    let (cached, recorded) = (Arc::clone(&owner.cached), plan.clone());
    let (outcome, raised) = background::run(py, None, move |_, watch| {
        steady::period_map(&cached, &options, (&recorded, samples), &states, watch)
    })?;
    let (images, response) = finished(outcome, raised)?;
    let images: Vec<Vec<f64>> = images.iter().map(|row| by_halves(row, |q| numbering.to_user_order(q))).collect();
    let response = response.map(|response| response_dict(owner, py, &plan, response)).transpose()?;
    Ok((PyArray2::from_vec2(py, &images)?, response))
}

/// Displacements and velocities of the core in the order of the degrees of freedom that users see.
///
/// # Errors
/// [`SceneError`] for a state of another system.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]
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

fn record_plan(owner: &PyModel, record: Vec<RecordEntry>) -> PyResult<RecordPlan> {
    let requests = record.into_iter().enumerate().map(|(index, entry)| entry.request(index));
    Ok(RecordPlan::new(owner.model(), &requests.collect::<Result<Vec<_>, _>>()?)?)
}

/// The result, or the exception that Python raised meanwhile.
fn finished<T>(outcome: Result<T, AnalysisError>, raised: Option<PyErr>) -> PyResult<T> {
    match (outcome, raised) {
        (_, Some(raised)) => Err(raised),
        (outcome, None) => Ok(outcome?),
    }
}
