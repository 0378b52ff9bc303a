//! Parts on their own: coefficients of one journal bearing or rolling bearing, geometry of the meshes of a description.

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;

use super::convert::{plain, table};
use super::errors::caught;
use crate::analysis::AnalysisError;
use crate::bearing_force::{BearingForce, Uncarried};
use crate::film::{Film, PadFilm, TiltingPads, pad_films};
use crate::rolling::{Ring, RollingElements};
use crate::scene::description::{BearingCoefficient, Support};
use crate::scene::{self, EntryPath, Nonlinear, SceneDescription, SceneError, Squeeze, outside_frequencies};

/// Gives the coefficient of a table at a frequency, rad/s, in plain form: a table over the speed, or a matrix.
#[pyfunction]
pub fn table_at_frequency<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyAny>,
    frequency: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let given: BearingCoefficient = pythonize::depythonize(table)?;
    let found = scene::BearingCoefficient::of_description(&given)?;
    let place = EntryPath::root("frequency");
    place.finite(frequency)?;
    if let Some(range) = found.excludes_frequency(frequency) {
        return Err(place.error(outside_frequencies(range, frequency)).into());
    }
    plain(py, &found.at_frequency(frequency).description())
}

/// Computes displacement (2,), stiffness and damping (2, 2) of a journal bearing under a static load over (y, z), N, at a
/// spin, rad/s; tilting pads are eliminated at a frequency, rad/s, by default that of the rotation.
#[pyfunction]
#[pyo3(signature = (bearing, load, speed, frequency=None))]
pub fn film_coefficients<'py>(
    py: Python<'py>,
    bearing: &Bound<'_, PyAny>,
    load: [f64; 2],
    speed: f64,
    frequency: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let given = SceneDescription::bearing_from_objects(&mut Depythonizer::from_object(bearing))?;
    let (Nonlinear::Journal(journal), _) = scene::bearing(&given)? else {
        return Err(SceneError::new("bearing", "is no journal bearing").into());
    };
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
    let frequency =
        frequency.map(|value| EntryPath::root("frequency").non_negative(value)).transpose()?.unwrap_or(speed);
    let carried = || match TiltingPads::new(&journal, speed) {
        Some(pads) => pads.carrying(load, speed, frequency),
        None => Film::new(&journal, speed).carrying(load, speed),
    };
    let (displacement, film) = py.detach(|| caught(carried))?.map_err(|cause| uncarried(cause, load, Some(speed)))?;
    let dict = coefficients(py, displacement, &film)?;
    let films = py.detach(|| caught(|| pad_films(&journal, displacement, speed)))?;
    let pad = |film: PadFilm| {
        let pad = PyDict::new(py);
        pad.set_item("angles", film.angles.into_pyarray(py))?;
        pad.set_item("thickness", film.thickness.into_pyarray(py))?;
        pad.set_item("pressure", film.pressure.into_pyarray(py))?;
        pad.set_item("pivot", film.pivot)?;
        Ok(pad)
    };
    dict.set_item("pads", films.into_iter().map(pad).collect::<PyResult<Vec<_>>>()?)?;
    Ok(dict)
}

/// Computes the force over (y, z), N, of a ring on its squeeze film at a displacement, m, and a velocity, m/s.
#[pyfunction]
pub fn squeeze_force(
    py: Python<'_>,
    support: &Bound<'_, PyAny>,
    displacement: [f64; 2],
    velocity: [f64; 2],
) -> PyResult<[f64; 2]> {
    let given: Support = pythonize::depythonize(support)?;
    let at = EntryPath::root("support");
    let film = Squeeze::new(&given, &at)?.ok_or_else(|| at.error("is no squeeze film"))?;
    let film = Film::of_squeeze(&film);
    if displacement.iter().chain(&velocity).any(|value| !value.is_finite()) || film.nearness(displacement) >= 1.0 {
        return Err(SceneError::new("eccentricity_ratio", "must be finite and below 1").into());
    }
    py.detach(|| caught(|| film.at(displacement, velocity, 0.0).force))
}

/// Computes displacement (2,), stiffness and damping (2, 2) of a rolling bearing under a static load over (y, z), N, at an
/// angle of the cage, rad, or averaged over the angles of the cage; with the contact force of each element, N (at the angle 0
/// for the average), the stiffness of one element and the speed of the cage over that of the shaft.
#[pyfunction]
#[pyo3(signature = (bearing, load, cage=None))]
pub fn rolling_coefficients<'py>(
    py: Python<'py>,
    bearing: &Bound<'_, PyAny>,
    load: [f64; 2],
    cage: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let given = SceneDescription::bearing_from_objects(&mut Depythonizer::from_object(bearing))?;
    let (Nonlinear::Rolling(rolling), damping) = scene::bearing(&given)? else {
        return Err(SceneError::new("bearing", "is no rolling bearing").into());
    };
    let load_at = EntryPath::root("load");
    load_at.finite(load[0])?;
    load_at.finite(load[1])?;
    let elements = RollingElements::new(&rolling, damping);
    let cage = cage.map(|cage| EntryPath::root("cage_angle").finite(cage)).transpose()?;
    let (displacement, found) =
        caught(|| elements.carrying(load, cage))?.map_err(|cause| uncarried(cause, load, None))?;
    let dict = coefficients(py, displacement, &found)?;
    dict.set_item("contact_forces", elements.contact_forces(displacement, cage.unwrap_or(0.0)).collect::<Vec<_>>())?;
    dict.set_item("elements", rolling.elements)?;
    dict.set_item("hertz_stiffness", rolling.hertz_stiffness)?;
    dict.set_item("cage_ratio", elements.cage_ratio)?;
    Ok(dict)
}

/// Computes the displacements (u, v, w, B, Γ) of a rolling bearing under the forces (axial, y, z), N, with given rotations
/// (B, Γ), rad; force (5,), stiffness (5, 5), contact forces and contact angles there.
#[pyfunction]
pub fn ring_coefficients<'py>(
    py: Python<'py>,
    bearing: &Bound<'_, PyAny>,
    load: [f64; 3],
    tilt: [f64; 2],
) -> PyResult<Bound<'py, PyDict>> {
    let given = SceneDescription::bearing_from_objects(&mut Depythonizer::from_object(bearing))?;
    let (Nonlinear::Rolling(rolling), _) = scene::bearing(&given)? else {
        return Err(SceneError::new("bearing", "is no rolling bearing").into());
    };
    for (name, values) in [("load", &load[..]), ("tilt", &tilt[..])] {
        for value in values {
            EntryPath::root(name).finite(*value)?;
        }
    }
    let ([thrust, y, z], ring) = (load, Ring::new(&rolling));
    let radius = ring.radius;
    // The ring has the slopes dv/dx = Γ and dw/dx = −B times its radius.
    let carried = caught(|| ring.carrying_tilted([y, z, thrust], [radius * tilt[1], -radius * tilt[0]]))?;
    let x = carried.map_err(|cause| uncarried(cause, [thrust, y.hypot(z)], None))?;
    let found = ring.at::<true>(x, 0.0);
    // Index and factor of (u, v, w, B, Γ) in the coordinates of the ring.
    let places = [(2, 1.0), (0, 1.0), (1, 1.0), (4, -radius), (3, radius)];
    let stiffness = |(i, a): (usize, f64)| places.map(|(j, b)| a * b * found.stiffness[i][j]);
    let dict = PyDict::new(py);
    dict.set_item("displacement", places.map(|(at, factor)| x[at] / factor).to_vec())?;
    dict.set_item("force", places.map(|(at, factor)| factor * found.force[at]).to_vec())?;
    dict.set_item("stiffness", table(py, places.map(stiffness).as_flattened().to_vec(), 5, 5)?)?;
    let contacts: Vec<[f64; 2]> = ring.contacts(x, 0.0).collect();
    let column = |at: usize| contacts.iter().map(|contact| contact[at]).collect::<Vec<_>>();
    dict.set_item("contact_forces", column(0))?;
    dict.set_item("contact_angles", column(1))?;
    Ok(dict)
}

/// The estimate of the elements of a rolling bearing with a designation or boundary as a dictionary; none for another bearing.
#[pyfunction]
pub fn rolling_estimate<'py>(py: Python<'py>, bearing: &Bound<'_, PyAny>) -> PyResult<Option<Bound<'py, PyAny>>> {
    let given = SceneDescription::bearing_from_objects(&mut Depythonizer::from_object(bearing))?;
    let found = scene::estimate(&given, &EntryPath::root("bearing"))?;
    Ok(found.map(|found| pythonize::pythonize(py, &found)).transpose()?)
}

/// Displacement, stiffness and damping as a dictionary.
fn coefficients<'py>(py: Python<'py>, displacement: [f64; 2], found: &BearingForce) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("displacement", displacement.to_vec())?;
    dict.set_item("stiffness", table(py, found.stiffness.as_flattened().to_vec(), 2, 2)?)?;
    dict.set_item("damping", table(py, found.damping.as_flattened().to_vec(), 2, 2)?)?;
    Ok(dict)
}

/// The error for a load that a bearing does not carry; a film turns at a speed, rad/s.
fn uncarried(cause: Uncarried, load: [f64; 2], speed: Option<f64>) -> AnalysisError {
    let at_speed = speed.map_or_else(String::new, |speed| format!(" and {speed} rad/s"));
    let load = format!("{} N{at_speed}", load[0].hypot(load[1]));
    match cause {
        Uncarried::Touching => SceneError::new("load", format!("the journal touches the bearing at {load}; raise the speed, the viscosity or the length, or reduce the clearance or the load")).into(),
        Uncarried::Unbalanced(part) => AnalysisError::Convergence(format!("load: no displacement found at which the bearing carries {load}: {part:.1e} of the load is unbalanced")),
    }
}
