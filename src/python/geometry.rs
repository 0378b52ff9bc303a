//! What follows from a description without an assembled model: geometry of the meshes, places of the shafts, and motion at
//! any place of a shaft.

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;

use super::convert::table;
use crate::connection::Row;
use crate::mesh::Involute;
use crate::model::{Numbering, PlaceRows};
use crate::scene::{EntryPath, Gear, Scene, SceneDescription};

/// Checks a description.
fn scene(description: &Bound<'_, PyAny>) -> PyResult<Scene> {
    let description = SceneDescription::from_objects(&mut Depythonizer::from_object(description))?;
    Ok(Scene::new(&description)?)
}

/// Gives the geometry of each mesh at rest: centre distance, m, operating pressure angle, rad, and base, tip and root radii
/// of driver and driven gear, m, negative for an internal gear.
#[pyfunction]
pub fn mesh_geometry<'py>(py: Python<'py>, description: &Bound<'_, PyAny>) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let Scene { gears, meshes, .. } = scene(description)?;
    let geometry = |mesh| {
        let involute = Involute::new(mesh, &gears);
        let pair = [mesh.driver, mesh.driven].map(|gear| &gears[gear]);
        let entry = PyDict::new(py);
        entry.set_item("centre_distance", mesh.centre_distance)?;
        let signed = |of: fn(&Gear) -> f64| {
            let [a, b] = pair.map(|gear| gear.sign() * of(gear));
            (a, b)
        };
        entry.set_item("pressure_angle", (involute.base_circles().abs() / mesh.centre_distance).acos())?;
        entry.set_item("base_radii", signed(|gear| gear.base_radius))?;
        entry.set_item("tip_radii", signed(|gear| gear.tip_radius))?;
        entry.set_item("root_radii", signed(Gear::root_radius))?;
        Ok(entry)
    };
    meshes.iter().map(geometry).collect()
}

/// Gives the left end (x, y, z) of each shaft at rest, m.
#[pyfunction]
pub fn shaft_origins(description: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    Ok(scene(description)?.origins)
}

/// Takes the row of a direction, if the shaft has this motion.
type Direction = fn(&PlaceRows) -> Option<&Row>;

/// Gives the motion at positions of a shaft, m, as factors (positions, n) of all degrees of freedom, by direction.
#[pyfunction]
pub fn shaft_motion<'py>(
    py: Python<'py>,
    description: &Bound<'py, PyAny>,
    shaft: &str,
    positions: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (scene, at) = (scene(description)?, EntryPath::root("at"));
    let (index, numbering) = (scene.known_shaft(shaft, &at)?, Numbering::new(&scene));
    let found = positions.iter().map(|position| PlaceRows::on_shaft(&scene, &numbering, index, *position, &at));
    let found = found.collect::<Result<Vec<_>, _>>()?;
    let factors = |rows: Vec<&Row>, sign: f64| -> PyResult<Bound<'py, PyArray2<f64>>> {
        let dense = |row: &Row| {
            let mut inside = vec![0.0; numbering.len()];
            row.iter().for_each(|(coordinate, factor)| inside[*coordinate] = sign * factor);
            numbering.to_user_order(&inside)
        };
        table(py, rows.into_iter().flat_map(dense).collect(), found.len(), numbering.len())
    };
    let directions: [(_, Direction, _); 6] = [
        ("v", |rows| rows.displacement.as_ref().map(|[v, _]| v), 1.0),
        ("w", |rows| rows.displacement.as_ref().map(|[_, w]| w), 1.0),
        ("G", |rows| rows.rotation.as_ref().map(|[gamma, _]| gamma), 1.0),
        ("B", |rows| rows.rotation.as_ref().map(|[_, minus]| minus), -1.0),
        ("twist", |rows| rows.twist.as_ref(), 1.0),
        ("u", |rows| rows.axial.as_ref(), 1.0),
    ];
    let dict = PyDict::new(py);
    for (name, row, sign) in directions {
        if let Some(rows) = found.iter().map(row).collect() {
            dict.set_item(name, factors(rows, sign)?)?;
        }
    }
    Ok(dict)
}
