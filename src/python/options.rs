//! Options of a run as plain Python data: method, steps, geometry, initial state and what to record.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;

use super::entries::{self, any_number, optional_count, text};
use super::speed::SpeedEntries;
use super::state::{self, mesh_geometry};
use crate::analysis::simulate::{Initial, Method, Options, RecordPlan, Request};
use crate::model::Model;
use crate::scene::{Accuracy, SceneError};

/// Options that are numbers and texts; `RunOptions` in `gearbow._types` lists the same entries.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunOptions {
    /// Duration, s.
    #[serde(deserialize_with = "any_number")]
    pub duration: f64,
    /// Speed of the reference shaft, rad/s.
    pub speed: SpeedEntries,
    /// Name of the method.
    #[serde(deserialize_with = "text")]
    pub method: String,
    /// Fixed step, s.
    pub step: Option<f64>,
    /// Relative tolerance.
    pub rtol: Option<f64>,
    /// Stages of the exponential method.
    #[serde(deserialize_with = "optional_count")]
    pub stages: Option<usize>,
    /// Number of modes of the exponential method.
    #[serde(deserialize_with = "optional_count")]
    pub modes: Option<usize>,
    /// Accuracy level, which decides the tolerance and the number of modes where they are not given.
    pub accuracy: Option<Accuracy>,
    /// "live" or "frozen".
    #[serde(deserialize_with = "text")]
    pub geometry: String,
    /// Time at which the run begins, s.
    #[serde(deserialize_with = "any_number")]
    pub start: f64,
}

/// Total error of displacements and of mesh forces and relative tolerance of each accuracy level, from cheap to accurate.
#[pyfunction]
pub fn accuracy_levels(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let levels = PyDict::new(py);
    for level in Accuracy::ALL.map(Accuracy::level) {
        let entries = PyDict::new(py);
        entries.set_item("displacement", level.displacement)?;
        entries.set_item("mesh_force", level.mesh_force)?;
        entries.set_item("rtol", level.rtol)?;
        levels.set_item(level.name, entries)?;
    }
    Ok(levels)
}

/// Reads the initial state of a run: a name, or the `final` of another run.
pub fn read_initial(given: &Bound<'_, PyAny>) -> PyResult<Initial> {
    let Ok(name) = given.extract::<String>() else {
        return Ok(Initial::Continue(Box::new(state::read_final(given)?)));
    };
    match name.as_str() {
        "synchronous" => Ok(Initial::Synchronous),
        "static" => Ok(Initial::Static),
        "rest" => Ok(Initial::Rest),
        _ => {
            let message = format!("must be \"synchronous\", \"static\", \"rest\" or a response, got \"{name}\"");
            Err(SceneError::new("initial", message).into())
        }
    }
}

/// One entry of `record`.
#[derive(FromPyObject)]
pub enum RecordEntry {
    Name(String),
    Node(String, f64),
    Mesh(String, String),
    Bearing(String, String, f64),
}

impl RecordEntry {
    /// Converts entry `index` of the list.
    fn request(self, index: usize) -> Result<Request, SceneError> {
        Ok(match self {
            Self::Name(name) => Request::Name(name),
            Self::Node(shaft, position) => Request::OnShaft(shaft, position),
            Self::Mesh(first, second) => Request::Mesh(first, second),
            Self::Bearing(kind, shaft, position) if kind == "bearing" => Request::Bearing(shaft, position),
            Self::Bearing(kind, ..) => {
                let message = format!("must be (\"bearing\", shaft, position), got \"{kind}\"");
                return Err(SceneError::new(format!("record[{index}]"), message));
            }
        })
    }
}

/// Reads the options of a run without output times.
pub fn run_options(
    py: Python<'_>,
    initial: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Options> {
    let given: RunOptions = entries::read(options.unwrap_or(&PyDict::new(py)), "")?;
    let level = given.accuracy.map(Accuracy::level);
    Ok(Options {
        duration: given.duration,
        speed: given.speed.try_into()?,
        method: Method::named(&given.method)?,
        step: given.step,
        rtol: given.rtol.or(level.map(|level| level.rtol)),
        stages: given.stages,
        modes: given.modes,
        reduction: level.and_then(|level| level.reduction()),
        kept_modes: None,
        force_error: level.map(|level| level.mesh_force),
        initial: read_initial(initial)?,
        times: Vec::new(),
        geometry: mesh_geometry(&given.geometry)?,
        start: given.start,
        checkpoint: None,
    })
}

/// The quantities that a run of a model records.
pub fn record_plan(model: &Model, record: Vec<RecordEntry>) -> PyResult<RecordPlan> {
    let requests = record.into_iter().enumerate().map(|(index, entry)| entry.request(index));
    Ok(RecordPlan::new(model, &requests.collect::<Result<Vec<_>, _>>()?)?)
}
