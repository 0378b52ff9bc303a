//! `_core.Model.simulate`: a run with the interpreter released, what it recorded, and the state it left.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{stack, table};
use super::errors::warn;
use super::model::PyModel;
use super::speed;
use crate::analysis::simulate::{
    self, Final, MESH_FIELDS, Method, Options, RecordPlan, RecorderState, Request, Response, round_below, sample_step,
};
use crate::analysis::{AnalysisError, small_displacement_check};
use crate::integrate::Statistics;
use crate::mesh::Geometry;
use crate::model::Model;
use crate::motion::{Energies, SOURCES};
use crate::scene::{Node, SceneError};

/// The method of a name; "rk4" may leave the linear part to the modes.
pub fn method(name: &str, linear: Option<&str>) -> Result<Method, SceneError> {
    match (Method::named(name)?, linear) {
        (method, None) => Ok(method),
        (Method::Rk4, Some("exact")) => Ok(Method::ExactRk4),
        (Method::Rk4, Some("integrated")) => Ok(Method::Rk4),
        (Method::Rk4, Some(linear)) => {
            Err(SceneError::new("linear", format!("must be \"exact\" or \"integrated\", got \"{linear}\"")))
        }
        (method, Some(_)) => {
            Err(SceneError::new("linear", format!("is a choice of \"rk4\" alone, not of \"{}\"", method.name())))
        }
    }
}

/// The smallest `rtol` that round-off leaves to a step.
const SMALLEST: f64 = 1e-13;

/// A tolerance that can be met.
pub fn attainable(py: Python<'_>, rtol: f64) -> PyResult<f64> {
    if rtol > 0.0 && rtol < SMALLEST {
        warn(py, format!("rtol: {rtol:e} is below what round-off leaves to a step; taken as {SMALLEST:e}"))?;
        return Ok(SMALLEST);
    }
    Ok(rtol)
}

/// One entry of `record`.
#[derive(FromPyObject)]
pub enum Recorded {
    Name(String),
    Node(String, f64),
    Mesh(String, String),
    Bearing(String, String, f64),
}

impl Recorded {
    fn request(self, index: usize) -> Result<Request, SceneError> {
        Ok(match self {
            Self::Name(name) => Request::Name(name),
            Self::Node(shaft, position) => Request::Node(shaft, position),
            Self::Mesh(first, second) => Request::Mesh(first, second),
            Self::Bearing(kind, shaft, position) if kind == "bearing" => Request::Bearing(shaft, position),
            Self::Bearing(kind, ..) => {
                let message = format!("must be (\"bearing\", shaft, position), got \"{kind}\"");
                return Err(SceneError::new(format!("record[{index}]"), message));
            }
        })
    }
}

/// Runs, asking Python every 50 ms whether to go on.
pub fn simulate<'py>(
    owner: &PyModel,
    py: Python<'py>,
    options: &Options,
    record: Vec<Recorded>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let requests = record.into_iter().enumerate().map(|(index, entry)| entry.request(index));
    let plan = RecordPlan::new(&owner.cached.model, &requests.collect::<Result<Vec<_>, _>>()?)?;
    let mut raised: Option<PyErr> = None;
    let mut watch = |done: f64| {
        let asked = Python::attach(|py| {
            py.check_signals()?;
            progress.as_ref().map_or(Ok(()), |progress| progress.call1(py, (done,)).map(|_| ()))
        });
        raised = asked.err();
        raised.is_none()
    };
    let outcome = py.detach(|| simulate::simulate(&owner.cached, options, &plan, &mut watch));
    match outcome {
        Ok(response) => {
            let largest = response.record.displacement.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let response = response_dict(owner, py, &plan, response)?;
            let mut told = small_displacement_check(&owner.cached.model, largest).map_or(Ok(()), |text| warn(py, text));
            if let Some(progress) = progress.filter(|_| told.is_ok()) {
                told = progress.call1(py, (1.0,)).map(|_| ());
            }
            if let Err(error) = told {
                error.value(py).setattr("partial", response)?;
                return Err(error);
            }
            Ok(response)
        }
        Err(stopped) => {
            let error = match (stopped.error, raised) {
                (AnalysisError::Interrupted(_), Some(raised)) => raised,
                (error, _) => error.into(),
            };
            if let Some(response) = stopped.response {
                error.value(py).setattr("partial", response_dict(owner, py, &plan, *response)?)?;
            }
            Err(error)
        }
    }
}

fn response_dict<'py>(
    owner: &PyModel,
    py: Python<'py>,
    plan: &RecordPlan,
    response: Response,
) -> PyResult<Bound<'py, PyDict>> {
    let model = &owner.cached.model;
    let record = response.record;
    let (times, points, bearings) = (record.time.len(), plan.points.len(), plan.bearings.len());
    let dict = PyDict::new(py);
    dict.set_item("time", record.time.into_pyarray(py))?;
    let place = |point: &simulate::Point| {
        let (shaft, position) = owner.place(point.node);
        (shaft.to_owned(), position, point.names.clone())
    };
    dict.set_item("points", plan.points.iter().map(place).collect::<Vec<_>>())?;
    dict.set_item("displacement", stack(py, record.displacement, times, points, 2)?)?;
    dict.set_item("twist", table(py, record.twist, times, points)?)?;
    dict.set_item("bearings", plan.bearings.iter().map(|node| owner.place(*node)).collect::<Vec<_>>())?;
    dict.set_item("bearing_force", stack(py, record.bearing_force, times, bearings, 2)?)?;
    dict.set_item("meshes", mesh_names(model, plan.meshes.iter().copied()))?;
    dict.set_item("mesh", mesh_fields(py, record.mesh, times, plan.meshes.len(), false)?)?;
    dict.set_item("energy", plan.energy.then(|| energy(&record.energy, |(energies, _)| energies.total(), py)))?;
    dict.set_item("energy_terms", plan.energy.then(|| energy_terms(&record.energy, py)).transpose()?)?;
    let event = |event: &simulate::Event| {
        let [driver, driven] = model.gear_names(event.mesh);
        (event.time, driver, driven, event.kind.name())
    };
    dict.set_item("events", record.events.iter().map(event).collect::<Vec<_>>())?;
    dict.set_item("final", final_dict(py, &response.last)?)?;
    dict.set_item("checkpoint", checkpoint_dict(py, &response.statistics, &response.recorder_state)?)?;

    let count = response.statistics;
    let statistics = PyDict::new(py);
    statistics.set_item("steps", count.steps)?;
    statistics.set_item("rejected", count.rejected)?;
    statistics.set_item("evaluations", count.evaluations)?;
    statistics.set_item("events", count.events)?;
    statistics.set_item("step_min", if count.steps > 0 { count.shortest } else { 0.0 })?;
    statistics.set_item("step_max", count.longest)?;
    statistics.set_item("omega_max", response.spectrum.omega_max)?;
    statistics.set_item("condition", response.condition.unwrap_or(f64::NAN))?;
    statistics.set_item("limited_by", response.limited_by.name())?;
    dict.set_item("statistics", statistics)?;
    Ok(dict)
}

type Balance = (Energies, [f64; 6]);

fn energy<'py>(record: &[Balance], of: impl Fn(&Balance) -> f64, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
    record.iter().map(of).collect::<Vec<_>>().into_pyarray(py)
}

fn energy_terms<'py>(record: &[Balance], py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kinetic", energy(record, |(energies, _)| energies.kinetic, py))?;
    dict.set_item("shafts", energy(record, |(energies, _)| energies.shafts, py))?;
    dict.set_item("bearings", energy(record, |(energies, _)| energies.bearings, py))?;
    dict.set_item("meshes", energy(record, |(energies, _)| energies.meshes, py))?;
    for (index, name) in SOURCES.into_iter().enumerate() {
        dict.set_item(name, energy(record, |(_, works)| works[index], py))?;
    }
    Ok(dict)
}

fn final_dict<'py>(py: Python<'py>, last: &Final) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("method", last.method.name())?;
    dict.set_item("time", last.time)?;
    dict.set_item("origin", last.origin)?;
    dict.set_item("speed", speed::plain(py, &last.speed)?)?;
    dict.set_item("anchor", [last.anchor.time, last.anchor.angle.high, last.anchor.angle.low])?;
    dict.set_item("geometry", if last.geometry == Geometry::Live { "live" } else { "frozen" })?;
    dict.set_item("setting", last.setting.number(last.method))?;
    dict.set_item("count", last.state.count)?;
    dict.set_item("elapsed", last.state.elapsed)?;
    dict.set_item("carry", last.state.time_offset())?;
    dict.set_item("next_step", last.state.next_step)?;
    dict.set_item("previous_error", last.state.previous_error)?;
    dict.set_item("contact_modes", PyArray1::from_slice(py, &last.state.contact_modes))?;
    dict.set_item("memory", PyArray1::from_slice(py, &last.state.method_numbers()))?;
    dict.set_item("state", PyArray1::from_slice(py, &last.state.y))?;
    Ok(dict)
}

/// What is needed beside the final state for the same run to go on; floats, whole numbers and lists of them.
fn checkpoint_dict<'py>(
    py: Python<'py>,
    count: &Statistics,
    recorder_state: &RecorderState,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("counts", [count.steps, count.rejected, count.evaluations, count.events, count.at_limit])?;
    dict.set_item("steps", [count.shortest, count.longest])?;
    dict.set_item("events", recorder_state.events)?;
    let margins =
        recorder_state.margins.iter().map(|margins| margins.map(|(at, [ratio, clearance])| [at, ratio, clearance]));
    dict.set_item("margins", margins.collect::<Vec<_>>())?;
    dict.set_item("works", recorder_state.works)?;
    dict.set_item("until", recorder_state.until)?;
    Ok(dict)
}

/// Names of the gears of meshes.
pub fn mesh_names(model: &Model, meshes: impl Iterator<Item = usize>) -> Vec<(&str, &str)> {
    meshes.map(|mesh| model.gear_names(mesh).into()).collect()
}

/// The fields of meshes by name, (times, meshes) each; `flat` drops the times.
pub fn mesh_fields<'py>(
    py: Python<'py>,
    fields: [Vec<f64>; 8],
    times: usize,
    meshes: usize,
    flat: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, values) in MESH_FIELDS.iter().zip(fields) {
        if flat {
            dict.set_item(name, values.into_pyarray(py))?;
        } else {
            dict.set_item(name, table(py, values, times, meshes)?)?;
        }
    }
    Ok(dict)
}

/// Nodes that carry bearings, each once.
pub fn bearing_nodes(model: &Model) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::new();
    for bearing in &model.scene.bearings {
        if !nodes.contains(&bearing.node) {
            nodes.push(bearing.node);
        }
    }
    nodes
}

/// A round number of samples in the shortest period among shafts and teeth, and at least a thousand in the run.
pub fn default_output_step(model: &Model, duration: f64, speed: f64) -> f64 {
    round_below(sample_step(model, speed).min(duration / 1000.0))
}
