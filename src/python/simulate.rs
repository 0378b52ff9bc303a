//! `_core.Model.simulate`: runs without the interpreter lock and returns a partial response when a run stops early.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::background;
use super::errors::warn;
use super::handle::PyModel;
use super::options::RecordEntry;
use super::response::response_dict;
use crate::analysis::simulate::{self, Method, Options, RecordPlan};
use crate::analysis::{AnalysisError, contact_ratio_check, parallel_modes_check, small_displacement_check};

/// Runs a simulation and calls `progress` with the completed fraction.
///
/// # Errors
/// The reason for which the run stopped. Its attribute `partial` is the response up to that time.
pub fn simulate<'py>(
    owner: &PyModel,
    py: Python<'py>,
    options: Options,
    record: Vec<RecordEntry>,
    progress: Option<&Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let requests = record.into_iter().enumerate().map(|(index, entry)| entry.request(index));
    let plan = RecordPlan::new(owner.model(), &requests.collect::<Result<Vec<_>, _>>()?)?;
    plan.require_memory(owner.model(), options.times.len())?;
    let cached = Arc::clone(&owner.cached);
    let is_exponential = options.method == Method::Exponential;
    let ((outcome, plan), raised) = background::run(py, progress, move |_, watch| {
        let outcome = simulate::simulate(&cached, &options, &plan, watch);
        (outcome, plan)
    })?;
    match outcome {
        Ok(response) => {
            let largest = response.record.displacement.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let parallel = parallel_modes_check(response.condition).filter(|_| is_exponential);
            let texts = small_displacement_check(owner.model(), largest).into_iter().chain(parallel);
            let texts: Vec<_> = texts.chain(contact_ratio_check(owner.model(), &response.record.events)).collect();
            let response = response_dict(owner, py, &plan, response)?;
            // Python may raise after the last report.
            let mut reported = raised.map_or(Ok(()), Err);
            for text in texts {
                reported = reported.and_then(|()| warn(py, text));
            }
            if let Some(progress) = progress.filter(|_| reported.is_ok()) {
                reported = progress.call1(py, (1.0,)).map(|_| ());
            }
            if let Err(error) = reported {
                error.value(py).setattr("partial", response)?;
                return Err(error);
            }
            Ok(response)
        }
        Err(stopped) => {
            let error = match (stopped.error, raised) {
                (AnalysisError::Interrupted, Some(raised)) => raised,
                (error, _) => error.into(),
            };
            if let Some(response) = stopped.response {
                error.value(py).setattr("partial", response_dict(owner, py, &plan, *response)?)?;
            }
            Err(error)
        }
    }
}
