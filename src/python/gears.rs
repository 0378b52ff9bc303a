//! Geometry of the meshes of a description.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;

use crate::mesh::Involute;
use crate::scene::{Scene, SceneDescription};

/// Gives the geometry of each mesh at rest: centre distance, m, operating pressure angle, rad, and base, tip and root radii
/// of driver and driven gear, m.
#[pyfunction]
pub fn mesh_geometry<'py>(py: Python<'py>, description: &Bound<'_, PyAny>) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let description = SceneDescription::from_objects(&mut Depythonizer::from_object(description))?;
    let Scene { gears, meshes, .. } = Scene::new(&description)?;
    let geometry = |mesh| {
        let involute = Involute::new(mesh, &gears);
        let pair = [mesh.driver, mesh.driven].map(|gear| &gears[gear]);
        let entry = PyDict::new(py);
        entry.set_item("centre_distance", mesh.centre_distance)?;
        entry.set_item("pressure_angle", involute.pressure_angle_at_rest())?;
        entry.set_item("base_radii", (involute.base_radius[0], involute.base_radius[1]))?;
        entry.set_item("tip_radii", (pair[0].tip_radius, pair[1].tip_radius))?;
        entry.set_item("root_radii", (pair[0].root_radius(), pair[1].root_radius()))?;
        Ok(entry)
    };
    meshes.iter().map(geometry).collect()
}
