//! Geometry of the meshes of a description.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;

use crate::mesh::Involute;
use crate::scene::{Gear, Scene, SceneDescription};

/// Gives the geometry of each mesh at rest: centre distance, m, operating pressure angle, rad, and base, tip and root radii
/// of driver and driven gear, m, negative for an internal gear.
#[pyfunction]
pub fn mesh_geometry<'py>(py: Python<'py>, description: &Bound<'_, PyAny>) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let description = SceneDescription::from_objects(&mut Depythonizer::from_object(description))?;
    let Scene { gears, meshes, .. } = Scene::new(&description)?;
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
