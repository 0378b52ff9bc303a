//! Coefficients of one journal bearing.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;

use super::convert::table;
use crate::film::Film;
use crate::scene::{EntryPath, SceneDescription, SceneError, journal};

/// Computes displacement (2,), stiffness and damping (2, 2) of a journal bearing under a static load over (y, z), N, at a
/// spin, rad/s.
#[pyfunction]
pub fn film_coefficients<'py>(
    py: Python<'py>,
    bearing: &Bound<'_, PyAny>,
    load: [f64; 2],
    speed: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let given = SceneDescription::bearing_from_objects(&mut Depythonizer::from_object(bearing))?;
    let journal = journal(&given)?;
    let (load_at, speed_at) = (EntryPath::root("load"), EntryPath::root("speed"));
    load_at.finite(load[0])?;
    load_at.finite(load[1])?;
    if load == [0.0; 2] {
        return Err(load_at.error("must not be 0: an unloaded film has no stiffness and the shaft whirls").into());
    }
    if speed_at.finite(speed)? == 0.0 {
        return Err(speed_at.error("must not be 0: a film carries no load at standstill; give a speed [rad/s]").into());
    }
    if speed < 0.0 {
        let message = format!(
            "must be positive, got {speed}; a reversed journal has the coefficients of {} rad/s with the opposite sign of the cross terms",
            -speed
        );
        return Err(speed_at.error(message).into());
    }
    let (displacement, film) = py
        .detach(|| Film::new(&journal).carrying(load, speed))
        .ok_or_else(|| touching(load[0].hypot(load[1]), speed))?;
    let dict = PyDict::new(py);
    dict.set_item("displacement", displacement.to_vec())?;
    dict.set_item("stiffness", table(py, film.stiffness.as_flattened().to_vec(), 2, 2)?)?;
    dict.set_item("damping", table(py, film.damping.as_flattened().to_vec(), 2, 2)?)?;
    Ok(dict)
}

fn touching(load: f64, speed: f64) -> SceneError {
    let message = format!(
        "the journal touches the bearing at {load} N and {speed} rad/s; raise the speed, the viscosity or the length, or reduce the clearance or the load"
    );
    SceneError::new("load", message)
}
