//! The state that a run left, and where it was stopped, as dictionaries: every entry is checked when it is read. They
//! may come from a damaged file or from a dictionary that a user wrote.

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use super::{model, speed};
use crate::analysis::simulate::{Checkpoint, Final, Initial, Method, RecorderState, StepSetting};
use crate::integrate::{State, Statistics};
use crate::motion::{Anchor, DoubleDouble, Speed};
use crate::scene::SceneError;

/// Counters stay below this, so that what a run adds to them does not overflow 64 bits.
const COUNT_LIMIT: u64 = 1 << 63;

/// A mapping, and the name with which its errors begin.
struct Entries<'a, 'py> {
    name: &'static str,
    given: &'a Bound<'py, PyAny>,
}

impl<'py> Entries<'_, 'py> {
    fn error(&self, key: &str, message: &str) -> PyErr {
        SceneError::new(format!("{}.{key}", self.name), message).into()
    }

    fn item(&self, key: &str) -> PyResult<Bound<'py, PyAny>> {
        self.given.get_item(key).map_err(|_| {
            SceneError::new(self.name, format!("lacks \"{key}\", which the final state of a run has")).into()
        })
    }

    fn text(&self, key: &str) -> PyResult<String> {
        self.item(key)?.extract().map_err(|_| self.error(key, "must be a text"))
    }

    fn any_number(&self, key: &str) -> PyResult<f64> {
        self.item(key)?.extract().map_err(|_| self.error(key, "must be a number"))
    }

    fn number(&self, key: &str) -> PyResult<f64> {
        let value = self.any_number(key)?;
        if value.is_finite() { Ok(value) } else { Err(self.error(key, "must be finite")) }
    }

    fn not_negative(&self, key: &str) -> PyResult<f64> {
        let value = self.number(key)?;
        if value >= 0.0 { Ok(value) } else { Err(self.error(key, &format!("must not be negative, got {value:e}"))) }
    }

    /// A list of so many numbers.
    fn numbers<const N: usize>(&self, key: &str) -> PyResult<[f64; N]> {
        self.item(key)?.extract().map_err(|_| self.error(key, &format!("must be {N} numbers")))
    }

    /// A list of so many counters.
    fn counts<const N: usize>(&self, key: &str) -> PyResult<[u64; N]> {
        let counts = self.item(key)?.extract::<[u64; N]>().ok();
        counts
            .filter(|counts| counts.iter().all(|count| *count < COUNT_LIMIT))
            .ok_or_else(|| self.error(key, &format!("must be {N} whole numbers, not negative and below 2^63")))
    }

    fn count(&self, key: &str) -> PyResult<u64> {
        let count = self.item(key)?.extract::<u64>().ok().filter(|count| *count < COUNT_LIMIT);
        count.ok_or_else(|| self.error(key, "must be a whole number, not negative and below 2^63"))
    }

    fn array<T: Element + Copy>(&self, key: &str) -> PyResult<Vec<T>> {
        let values = self.item(key)?.cast_into::<PyArray1<T>>();
        let values = values.ok().and_then(|values| values.to_vec().ok());
        values.ok_or_else(|| self.error(key, "must be a contiguous array of one axis, as a run leaves it"))
    }
}

/// The beginning of a run: a name, or the `final` of another run.
pub fn initial(given: &Bound<'_, PyAny>) -> PyResult<Initial> {
    let Ok(name) = given.extract::<String>() else {
        return Ok(Initial::Continue(Box::new(last(given)?)));
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

/// The `final` of a run.
fn last(given: &Bound<'_, PyAny>) -> PyResult<Final> {
    let given = Entries { name: "initial", given };
    let y: Vec<f64> = given.array("state")?;
    if let Some(index) = y.iter().position(|value| !value.is_finite()) {
        return Err(SceneError::new(format!("initial.state[{index}]"), "must be finite").into());
    }
    let anchor = given.numbers::<3>("anchor").ok().filter(|all| all.iter().all(|x| x.is_finite()));
    let Some([time, high, low]) = anchor else {
        return Err(given.error("anchor", "must be a time and an angle in two parts, all finite"));
    };
    // Without it the run begins anew from the state.
    let memory = if given.given.contains("memory").unwrap_or(false) { given.array("memory")? } else { Vec::new() };
    let mut state = State {
        count: given.count("count")?,
        elapsed: given.not_negative("elapsed")?,
        next_step: given.not_negative("next_step")?,
        // The controller takes any number: it limits what follows from it.
        previous_error: given.any_number("previous_error")?,
        contact_modes: given.array("contact_modes")?,
        ..State::new(y)
    };
    state.set_method(given.number("carry")?, &memory);
    let method = Method::named(&given.text("method")?)?;
    let last = Final {
        method,
        time: given.number("time")?,
        origin: given.number("origin")?,
        speed: speed::speed(&given.item("speed")?)?,
        anchor: Anchor { time, angle: DoubleDouble { high, low } },
        geometry: model::geometry(&given.text("geometry")?)?,
        setting: StepSetting::from_number(given.number("setting")?, method),
        state,
    };
    if matches!(last.speed, Speed::Constant(speed) if !speed.is_finite()) {
        return Err(given.error("speed", "must be finite"));
    }
    // A run leaves the state at its last whole step, which is not after its end; time is rounded where it is large.
    let (span, slack) = (last.time - last.origin, 16.0 * f64::EPSILON * (last.time.abs() + last.origin.abs()));
    if !(last.state.elapsed <= span + slack) {
        let message = format!("must not be after the end of the run, {span:e} s, got {:e} s", last.state.elapsed);
        return Err(given.error("elapsed", &message));
    }
    if !(last.state.time_offset().abs() <= span + slack) {
        let message = format!("must not be longer than the run, {span:e} s, got {:e} s", last.state.time_offset());
        return Err(given.error("carry", &message));
    }
    Ok(last)
}

/// Where a run was stopped: the `final` and the `checkpoint` of what it had computed.
pub fn checkpoint((state, seen): (Bound<'_, PyAny>, Bound<'_, PyAny>)) -> PyResult<Box<Checkpoint>> {
    let state = last(&state)?.state;
    let given = Entries { name: "checkpoint", given: &seen };
    let [steps, rejected, evaluations, events, at_limit] = given.counts("counts")?;
    let [shortest, longest] = given.numbers("steps")?;
    let margins = given.item("margins")?.extract::<Vec<Option<[f64; 3]>>>();
    let margins = margins.map_err(|_| given.error("margins", "must be nothing or 3 numbers for each mesh"))?;
    if margins.iter().flatten().any(|[at, ..]| !at.is_finite()) {
        return Err(given.error("margins", "must have finite times"));
    }
    let works: [f64; 6] = given.numbers("works")?;
    if works.iter().any(|work| work.is_nan()) {
        return Err(given.error("works", "must be numbers"));
    }
    Ok(Box::new(Checkpoint {
        state,
        statistics: Statistics { steps, rejected, evaluations, events, at_limit, shortest, longest },
        recorder_state: RecorderState {
            events: usize::try_from(given.count("events")?).map_err(|_| given.error("events", "is too large"))?,
            margins: margins
                .into_iter()
                .map(|seen| seen.map(|[at, ratio, clearance]| (at, [ratio, clearance])))
                .collect(),
            works,
            until: given.number("until")?,
        },
    }))
}

/// Checks the final state of a run, and where it was stopped, without a model.
#[pyfunction]
#[pyo3(signature = (last, checkpoint=None))]
pub fn check_final(last: Bound<'_, PyAny>, checkpoint: Option<Bound<'_, PyAny>>) -> PyResult<()> {
    match checkpoint {
        Some(seen) => self::checkpoint((last, seen)).map(|_| ()),
        None => self::last(&last).map(|_| ()),
    }
}
