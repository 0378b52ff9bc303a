//! The final state of a run and its checkpoint, as Python dictionaries of plain entries and NumPy arrays.
//!
//! Every entry is checked when it is read: it may come from a damaged file or from a dictionary that a user wrote.

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pythonize::pythonize;
use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize};

use super::entries::{self, any_number, count, counts, finite, list, not_negative, numbers, text};
use super::speed::SpeedEntries;
use crate::analysis::simulate::{Checkpoint, Final, Margins, Method, RecorderState, StepSetting};
use crate::integrate::{State, Statistics};
use crate::mesh::Geometry;
use crate::motion::{Anchor, DoubleDouble, SourceTerms, Speed};
use crate::scene::SceneError;

/// Plain entries of a final state. The dictionary also holds the arrays `contact_modes`, `memory` and `state`.
#[derive(Serialize, Deserialize)]
struct FinalEntries {
    /// Name of the method.
    #[serde(deserialize_with = "text")]
    method: String,
    /// Time at which the run ended, s.
    #[serde(deserialize_with = "finite")]
    time: f64,
    /// Time at which the run, or the first run that it continues, began, s.
    #[serde(deserialize_with = "finite")]
    origin: f64,
    /// Speed of the reference shaft, rad/s.
    speed: SpeedEntries,
    /// A time, s, and the angle of the reference shaft at that time as the sum of two numbers, rad.
    #[serde(deserialize_with = "anchor", serialize_with = "list")]
    anchor: [f64; 3],
    /// "live" or "frozen".
    #[serde(deserialize_with = "text")]
    geometry: String,
    /// The fixed step, s, or the tolerance, as [`Final::setting`].
    #[serde(deserialize_with = "finite")]
    setting: f64,
    /// Number of steps since the origin.
    #[serde(deserialize_with = "count")]
    count: u64,
    /// Time of the state since the origin, s.
    #[serde(deserialize_with = "not_negative")]
    elapsed: f64,
    /// As [`State::time_offset`], s.
    #[serde(deserialize_with = "finite")]
    carry: f64,
    /// Length of the step to try next, s.
    #[serde(deserialize_with = "not_negative")]
    next_step: f64,
    /// Scaled error of the last step. The step controller accepts every value and limits its effect.
    #[serde(deserialize_with = "any_number")]
    previous_error: f64,
}

/// What a run needs in addition to its final state to go on after an interruption.
#[derive(Serialize, Deserialize)]
struct CheckpointEntries {
    /// Numbers of steps, rejected steps, evaluations, events and steps at the stability limit.
    #[serde(deserialize_with = "counts", serialize_with = "list")]
    counts: [u64; 5],
    /// Lengths of the shortest and the longest step, s.
    #[serde(deserialize_with = "numbers", serialize_with = "list")]
    steps: [f64; 2],
    /// Number of events recorded.
    #[serde(deserialize_with = "count")]
    events: u64,
    /// For each mesh None, or a time, s, contact ratio − 1, tip clearance, m, and involute clearance, m.
    #[serde(deserialize_with = "margins")]
    margins: Vec<Option<Vec<f64>>>,
    /// Work of each energy source since the start, J.
    #[serde(deserialize_with = "works", serialize_with = "list")]
    works: [f64; 6],
    /// Time since the origin up to which the work is integrated, s.
    #[serde(deserialize_with = "not_negative")]
    until: f64,
}

fn anchor<'de, D: Deserializer<'de>>(source: D) -> Result<[f64; 3], D::Error> {
    let anchor = numbers(source).ok().filter(|all: &[f64; 3]| all.iter().all(|x| x.is_finite()));
    anchor.ok_or_else(|| D::Error::custom("must be a time and an angle in two parts, all finite"))
}

fn margins<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<Option<Vec<f64>>>, D::Error> {
    let margins = Vec::<Option<Vec<f64>>>::deserialize(source).ok();
    let margins = margins
        .filter(|margins| margins.iter().flatten().all(|margins| margins.len() == 4))
        .ok_or_else(|| D::Error::custom("must be None or 4 numbers for each mesh"))?;
    if margins.iter().flatten().any(|margins| !margins[0].is_finite()) {
        return Err(D::Error::custom("must have finite times"));
    }
    Ok(margins)
}

fn works<'de, D: Deserializer<'de>>(source: D) -> Result<[f64; 6], D::Error> {
    let works: [f64; 6] = numbers(source)?;
    if works.iter().any(|work| work.is_nan()) { Err(D::Error::custom("must not be NaN")) } else { Ok(works) }
}

/// Finds a mesh geometry by name.
pub fn mesh_geometry(name: &str) -> Result<Geometry, SceneError> {
    match name {
        "live" => Ok(Geometry::Live),
        "frozen" => Ok(Geometry::Frozen),
        _ => Err(SceneError::new("geometry", format!("must be \"live\" or \"frozen\", got \"{name}\""))),
    }
}

/// Writes the final state of a run.
pub fn write_final<'py>(py: Python<'py>, last: &Final) -> PyResult<Bound<'py, PyAny>> {
    let state = &last.state;
    let entries = FinalEntries {
        method: last.method.name().to_owned(),
        time: last.time,
        origin: last.origin,
        speed: (&last.speed).into(),
        anchor: [last.anchor.time, last.anchor.angle.high, last.anchor.angle.low],
        geometry: if last.geometry == Geometry::Live { "live" } else { "frozen" }.to_owned(),
        setting: last.setting.number(last.method),
        count: state.count,
        elapsed: state.elapsed,
        carry: state.time_offset(),
        next_step: state.next_step,
        previous_error: state.previous_error,
    };
    let dict = pythonize(py, &entries)?;
    dict.set_item("contact_modes", PyArray1::from_slice(py, &state.contact_modes))?;
    dict.set_item("memory", PyArray1::from_slice(py, &state.method_numbers()))?;
    dict.set_item("state", PyArray1::from_slice(py, &state.y))?;
    Ok(dict)
}

/// Reads the final state of a run.
///
/// # Errors
/// A `SceneError` that begins with `initial` and the entry.
pub fn read_final(given: &Bound<'_, PyAny>) -> PyResult<Final> {
    let error = |key: &str, message: String| SceneError::new(format!("initial.{key}"), message);
    let y: Vec<f64> = array(given, "state")?;
    if let Some(index) = y.iter().position(|value| !value.is_finite()) {
        return Err(error(&format!("state[{index}]"), "must be finite".to_owned()).into());
    }
    let entries: FinalEntries = entries::read(given, "initial")?;
    let speed: Speed = entries.speed.try_into()?;
    if matches!(speed, Speed::Constant(speed) if !speed.is_finite()) {
        return Err(error("speed", "must be finite".to_owned()).into());
    }
    let [time, high, low] = entries.anchor;
    // Without the memory of the method, the run starts again from the state.
    let memory: Vec<f64> = if given.contains("memory").unwrap_or(false) { array(given, "memory")? } else { Vec::new() };
    let mut state = State {
        count: entries.count,
        elapsed: entries.elapsed,
        next_step: entries.next_step,
        previous_error: entries.previous_error,
        contact_modes: array(given, "contact_modes")?,
        ..State::new(y)
    };
    state.set_method(entries.carry, &memory);
    let method = Method::named(&entries.method)?;
    let last = Final {
        method,
        time: entries.time,
        origin: entries.origin,
        speed,
        anchor: Anchor { time, angle: DoubleDouble { high, low } },
        geometry: mesh_geometry(&entries.geometry)?,
        setting: StepSetting::from_number(entries.setting, method),
        state,
    };
    // The state belongs to the last whole step, which lies before the end of the run. The limit allows for the
    // rounding of large times.
    let span = last.time - last.origin;
    let limit = span + 16.0 * f64::EPSILON * (last.time.abs() + last.origin.abs());
    if limit.is_nan() || last.state.elapsed > limit {
        let message = format!("must not be after the end of the run, {span:e} s, got {:e} s", last.state.elapsed);
        return Err(error("elapsed", message).into());
    }
    if last.state.time_offset().abs() > limit {
        let message = format!("must not be longer than the run, {span:e} s, got {:e} s", last.state.time_offset());
        return Err(error("carry", message).into());
    }
    Ok(last)
}

fn array<T: Element + Copy>(given: &Bound<'_, PyAny>, key: &str) -> PyResult<Vec<T>> {
    let missing = |_| SceneError::new("initial", format!("lacks the entry \"{key}\""));
    let values = given.get_item(key).map_err(missing)?.cast_into::<PyArray1<T>>();
    let values = values.ok().and_then(|values| values.to_vec().ok());
    let message = "must be a contiguous array of one axis and of the type that a run returns";
    Ok(values.ok_or_else(|| SceneError::new(format!("initial.{key}"), message))?)
}

/// Writes what a run needs in addition to its final state to go on.
pub fn write_checkpoint<'py>(
    py: Python<'py>,
    count: &Statistics,
    recorder_state: &RecorderState,
) -> PyResult<Bound<'py, PyAny>> {
    let margins = recorder_state.margins.iter();
    let entries = CheckpointEntries {
        counts: [count.steps, count.rejected, count.evaluations, count.events, count.at_limit],
        steps: [count.shortest, count.longest],
        events: recorder_state.events as u64,
        margins: margins
            .map(|margins| {
                margins.map(|at| vec![at.elapsed, at.contact_ratio, at.tip_clearance, at.involute_clearance])
            })
            .collect(),
        works: recorder_state.works.values(),
        until: recorder_state.until,
    };
    Ok(pythonize(py, &entries)?)
}

/// Reads a checkpoint from the final state and the additional entries.
pub fn read_checkpoint((state, given): (Bound<'_, PyAny>, Bound<'_, PyAny>)) -> PyResult<Box<Checkpoint>> {
    let state = read_final(&state)?.state;
    let entries: CheckpointEntries = entries::read(&given, "checkpoint")?;
    let [steps, rejected, evaluations, events, at_limit] = entries.counts;
    let [shortest, longest] = entries.steps;
    let too_large = |_| SceneError::new("checkpoint.events", "is too large");
    let margins = |row: Vec<f64>| Margins {
        elapsed: row[0],
        contact_ratio: row[1],
        tip_clearance: row[2],
        involute_clearance: row[3],
    };
    Ok(Box::new(Checkpoint {
        state,
        statistics: Statistics { steps, rejected, evaluations, events, at_limit, shortest, longest },
        recorder_state: RecorderState {
            events: usize::try_from(entries.events).map_err(too_large)?,
            margins: entries.margins.into_iter().map(|row| row.map(margins)).collect(),
            works: SourceTerms::from_values(entries.works),
            until: entries.until,
        },
    }))
}

/// Checks the final state of a run, and its checkpoint if there is one, without a model.
#[pyfunction]
#[pyo3(signature = (last, checkpoint=None))]
pub fn check_final(last: Bound<'_, PyAny>, checkpoint: Option<Bound<'_, PyAny>>) -> PyResult<()> {
    match checkpoint {
        Some(given) => read_checkpoint((last, given)).map(|_| ()),
        None => read_final(&last).map(|_| ()),
    }
}
