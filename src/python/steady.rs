//! `_core.Model.steady_state` and `multipliers`: run without the interpreter lock.

use std::sync::Arc;

use nalgebra::Complex;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use serde::Serialize;

use super::background;
use super::errors::warn;
use super::handle::PyModel;
use super::options::RecordEntry;
use super::response::response_dict;
use crate::analysis::simulate::{Options, RecordPlan};
use crate::analysis::{AnalysisError, small_displacement_check, steady};
use crate::model::Model;
use crate::scene::SceneError;

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

/// Finds the steady state with the period `options.duration` and records a number of samples.
///
/// # Errors
/// The reason for which there is none, or Ctrl-C.
pub fn steady_state<'py>(
    owner: &PyModel,
    py: Python<'py>,
    (options, samples): (Options, usize),
    record: Vec<RecordEntry>,
    progress: Option<&Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyAny>)> {
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

/// Finds the multipliers of a steady state.
///
/// # Errors
/// The reason for which the runs end early, or Ctrl-C.
pub fn multipliers<'py>(
    owner: &PyModel,
    py: Python<'py>,
    (options, smallest): (Options, f64),
    record: Vec<RecordEntry>,
    progress: Option<&Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray1<Complex<f64>>>> {
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
pub fn period_map<'py>(
    owner: &PyModel,
    py: Python<'py>,
    options: Options,
    (record, samples): (Vec<RecordEntry>, usize),
    states: &PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Option<Bound<'py, PyDict>>)> {
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
pub fn in_user_order(model: &Model, state: &[f64]) -> Result<Vec<f64>, SceneError> {
    if state.len() != 2 * model.len() {
        return Err(SceneError::new("state", "is of a system with other nodes"));
    }
    Ok(by_halves(state, |q| model.numbering.to_user_order(q)))
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
