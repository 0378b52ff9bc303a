//! `_core.Model.simulate`: runs without the interpreter lock and returns a partial response when a run stops early.

use std::sync::Arc;

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::background;
use super::errors::{warn, warn_of_speed};
use super::handle::PyModel;
use super::options::{RecordEntry, record_plan, run_options};
use super::response::response_dict;
use super::state::read_checkpoint;
use crate::analysis::simulate::{self, Method, Options};
use crate::analysis::{AnalysisError, contact_ratio_check, parallel_modes_check, small_displacement_check};

#[pymethods]
impl PyModel {
    /// Runs a simulation and calls `progress` with the completed fraction.
    ///
    /// # Errors
    /// The reason for which the run stopped. Its attribute `partial` is the response up to that time.
    #[pyo3(signature = (*, initial, times, record, progress, checkpoint, **options))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        initial: &Bound<'py, PyAny>,
        times: PyReadonlyArray1<'py, f64>,
        record: Vec<RecordEntry>,
        progress: Option<Py<PyAny>>,
        checkpoint: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let options = Options {
            times: times.as_array().to_vec(),
            checkpoint: checkpoint.map(read_checkpoint).transpose()?,
            ..run_options(py, initial, options)?
        };
        if let Some(text) = options.unattainable() {
            warn(py, text)?;
        }
        self.warn_of_ill_conditioning(py, self.representative_speed(options.fastest()), options.dense(self.model()))?;
        warn_of_speed(py, &self.model().scene, options.fastest())?;
        let (owner, progress) = (self, progress.as_ref());
        let plan = record_plan(owner.model(), record)?;
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
}
