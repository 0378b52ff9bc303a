//! `_core.Model`: a checked and assembled system.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Complex;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::{Depythonizer, pythonize};

use super::convert::{outside_matrix, outside_vector, table};
use super::errors::{warn, warn_of_speed};
use super::{background, frequency, simulate, state};
use crate::analysis::{self, AnalysisError, Dense, Interrupt};
use crate::mesh::Geometry;
use crate::modal::{self, CachedModel};
use crate::model::Model;
use crate::scene::{EntryPath, Node, Scene, SceneDescription, SceneError, nearest};

/// A checked and assembled system.
#[pyclass(name = "Model", module = "gearbow._core", frozen)]
pub struct PyModel {
    system: SceneDescription,
    /// Shared with the threads that analyse it.
    pub(super) cached: Arc<CachedModel>,
    /// Whether it was said that round-off takes digits.
    warned: AtomicBool,
}

/// A gear or disk, or a shaft and a position on it.
#[derive(FromPyObject)]
enum At {
    Body(String),
    Position(String, f64),
}

impl PyModel {
    fn build(system: SceneDescription) -> Result<Self, SceneError> {
        let model = Model::new(Scene::new(&system)?)?;
        Ok(Self { system, cached: Arc::new(CachedModel::new(model)), warned: AtomicBool::new(false) })
    }

    fn model(&self) -> &Model {
        &self.cached.model
    }

    /// Runs an analysis that Ctrl-C ends, if its matrices fit into memory.
    pub(super) fn run<T, E>(
        &self,
        py: Python<'_>,
        dense: Dense,
        work: impl FnOnce(&CachedModel, &Interrupt) -> Result<T, E> + Send + 'static,
    ) -> PyResult<T>
    where
        T: Send + 'static,
        E: Send + 'static,
        PyErr: From<E>,
    {
        dense.require(self.model())?;
        let cached = Arc::clone(&self.cached);
        let (result, raised) = background::run(py, None, move |interrupt, _| work(&cached, interrupt))?;
        raised.map_or(Ok(()), Err)?;
        Ok(result?)
    }

    /// Warns once of digits that round-off takes, before an analysis that needs the matrices of `dense`.
    pub(super) fn warn_of_ill_conditioning(&self, py: Python<'_>, speed: f64, dense: Dense) -> PyResult<()> {
        let found = self.run(py, dense, move |cached, _| analysis::ill_conditioning(cached, speed))?;
        match found {
            Some(text) if !self.warned.swap(true, Ordering::Relaxed) => warn(py, text),
            _ => Ok(()),
        }
    }

    /// The speed at which a warning of ill-conditioning is judged: zero, or one that the tables of bearings contain.
    pub(super) fn representative_speed(&self, fastest: f64) -> f64 {
        if self.model().bearings.is_empty() { 0.0 } else { fastest }
    }

    pub(super) fn place(&self, node: Node) -> (&str, f64) {
        let shaft = &self.model().scene.shafts[node.shaft];
        (&shaft.name, shaft.nodes[node.node])
    }
}

/// The geometry of this name.
pub(super) fn geometry(name: &str) -> Result<Geometry, SceneError> {
    match name {
        "live" => Ok(Geometry::Live),
        "frozen" => Ok(Geometry::Frozen),
        _ => Err(SceneError::new("geometry", format!("must be \"live\" or \"frozen\", got \"{name}\""))),
    }
}

#[pymethods]
impl PyModel {
    #[new]
    fn new(description: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self::build(SceneDescription::from_objects(&mut Depythonizer::from_object(description))?)?)
    }

    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        Ok(Self::build(SceneDescription::from_toml(text)?)?)
    }

    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize(py, &self.system)?)
    }

    fn to_toml(&self) -> PyResult<String> {
        Ok(self.system.to_toml()?)
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model().scene.warnings.clone()
    }

    #[getter]
    fn dofs(&self) -> Vec<(String, f64, &'static str)> {
        let dofs = self.model().numbering.dofs().iter();
        dofs.map(|dof| {
            let (shaft, position) = self.place(dof.node);
            (shaft.to_owned(), position, dof.kind.name())
        })
        .collect()
    }

    #[getter]
    fn shafts(&self) -> Vec<String> {
        self.model().scene.shafts.iter().map(|shaft| shaft.name.clone()).collect()
    }

    #[getter]
    fn speed_ratios<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.model().scene.speed_ratios)
    }

    #[expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]
    fn indices(&self, at: At) -> PyResult<(Option<usize>, Option<usize>, Option<usize>)> {
        let model = self.model();
        let place = EntryPath::root("at");
        let node = match &at {
            At::Body(name) => model.scene.body(name).map(|body| body.node).ok_or_else(|| {
                let names = model.scene.bodies().map(|body| body.name.as_str());
                place.error(format!("no gear or disk is called \"{name}\"{}", nearest(name, names)))
            })?,
            At::Position(shaft, position) => {
                let index = model.scene.known_shaft(shaft, &place)?;
                let node = model.scene.shafts[index].node_at(*position);
                let none = || place.error(format!("shaft \"{shaft}\" has no node at {position} m"));
                Node { shaft: index, node: node.ok_or_else(none)? }
            }
        };
        let (translation, twist) = (model.numbering.translation(node), model.numbering.twist(node));
        let outside = |index: usize| model.numbering.dofs().iter().position(|dof| dof.index == index);
        Ok((translation.and_then(outside), translation.and_then(|v| outside(v + 1)), twist.and_then(outside)))
    }

    #[pyo3(signature = (speed=0.0))]
    fn matrices<'py>(&self, py: Python<'py>, speed: f64) -> PyResult<Bound<'py, PyDict>> {
        EntryPath::root("speed").finite(speed)?;
        // Modal damping is made of the modes.
        let dense = if self.model().scene.modal_damping > 0.0 { Dense::Undamped } else { Dense::Matrices };
        let matrices = self.run(py, dense, move |cached, _| -> Result<_, AnalysisError> {
            let cached = cached.at_speed(speed)?;
            let model = &cached.model;
            Ok([
                ("mass", model.mass_matrix()),
                ("stiffness", model.stiffness_matrix(speed)),
                ("damping", cached.damping_matrix(speed)?),
                ("gyroscopic", model.gyroscopic_matrix()),
            ])
        })?;
        let dict = PyDict::new(py);
        for (name, matrix) in matrices {
            dict.set_item(name, outside_matrix(py, &self.model().numbering, &matrix))?;
        }
        Ok(dict)
    }

    #[pyo3(signature = (speed, count=None))]
    fn modes<'py>(&self, py: Python<'py>, speed: f64, count: Option<usize>) -> PyResult<Bound<'py, PyDict>> {
        EntryPath::root("speed").finite(speed)?;
        self.warn_of_ill_conditioning(py, speed, Dense::Damped)?;
        let mut modes = self.run(py, Dense::Damped, move |cached, _| -> Result<_, AnalysisError> {
            Ok(modal::modes(&*cached.at_speed(speed)?, speed)?)
        })?;
        modes.truncate(count.unwrap_or(usize::MAX));
        let numbering = &self.model().numbering;
        let shapes: Vec<Complex<f64>> =
            modes.iter().flat_map(|mode| numbering.outside(mode.shape.as_slice())).collect();
        let list = |of: fn(&modal::Mode) -> f64| modes.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
        let eigenvalues: Vec<_> = modes.iter().map(|mode| mode.eigenvalue).collect();
        let whirl: Vec<_> = modes.iter().map(|mode| mode.whirl.to_string()).collect();
        let dict = PyDict::new(py);
        dict.set_item("eigenvalues", eigenvalues.into_pyarray(py))?;
        dict.set_item("frequencies_hz", list(modal::Mode::frequency_hz))?;
        dict.set_item("damping_ratios", list(modal::Mode::damping_ratio))?;
        dict.set_item("whirl", whirl)?;
        dict.set_item("shapes", table(py, shapes, modes.len(), numbering.len())?)?;
        Ok(dict)
    }

    #[expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]
    fn campbell<'py>(
        &self,
        py: Python<'py>,
        speeds: PyReadonlyArray1<'py, f64>,
        count: usize,
        harmonics: u32,
    ) -> PyResult<Bound<'py, PyDict>> {
        frequency::campbell(self, py, &speeds, count, harmonics)
    }

    fn critical_speeds(&self, py: Python<'_>, excitation: f64) -> PyResult<Vec<(f64, String)>> {
        frequency::critical_speeds(self, py, excitation)
    }

    #[pyo3(signature = (speeds, excitation="both"))]
    #[expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]
    fn synchronous<'py>(
        &self,
        py: Python<'py>,
        speeds: PyReadonlyArray1<'py, f64>,
        excitation: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        frequency::synchronous(self, py, &speeds, excitation)
    }

    #[expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]
    fn peaks(
        &self,
        py: Python<'_>,
        speeds: PyReadonlyArray1<'_, f64>,
        index: usize,
        source: usize,
        excitation: &str,
        slow_roll: Option<f64>,
    ) -> PyResult<Vec<(f64, f64, f64, f64)>> {
        frequency::peaks(self, py, &speeds, index, source, excitation, slow_roll)
    }

    #[pyo3(signature = (geometry="live", speed=0.0))]
    fn r#static<'py>(&self, py: Python<'py>, geometry: &str, speed: f64) -> PyResult<Bound<'py, PyDict>> {
        let geometry = self::geometry(geometry)?;
        EntryPath::root("speed").finite(speed)?;
        let at_speed = self.cached.at_speed(speed)?;
        let model = &at_speed.model;
        self.warn_of_ill_conditioning(py, speed, Dense::Undamped)?;
        let found = self.run(py, Dense::Undamped, move |cached, _| analysis::equilibrium(cached, geometry, speed))?;
        let q = found.as_slice();
        let largest = model.translations().map(|i| q[i].abs()).fold(0.0, f64::max);
        if let Some(text) = analysis::small_displacement_check(model, largest) {
            warn(py, text)?;
        }
        let rest = vec![0.0; model.len()];
        let mut fields: [Vec<f64>; 8] = Default::default();
        for (index, mesh) in model.meshes.iter().enumerate() {
            let state = mesh.state_at_rest(geometry, model.sigma(index, speed), q).map_err(|overlap| {
                let [driver, driven] = model.gear_names(index);
                AnalysisError::overlap(driver, driven, "in static equilibrium", overlap)
            })?;
            for (series, value) in fields.iter_mut().zip(analysis::simulate::fields(&state)) {
                series.push(value);
            }
        }
        let bearings = simulate::bearing_nodes(model);
        let forces: Vec<f64> = bearings.iter().flat_map(|node| model.bearing_force(*node, q, &rest)).collect();
        let dict = PyDict::new(py);
        dict.set_item("state", outside_vector(py, &model.numbering, &found))?;
        dict.set_item("meshes", simulate::mesh_names(model, 0..model.meshes.len()))?;
        dict.set_item("mesh", simulate::mesh_fields(py, fields, 1, model.meshes.len(), true)?)?;
        dict.set_item("bearings", bearings.iter().map(|node| self.place(*node)).collect::<Vec<_>>())?;
        dict.set_item("bearing_force", table(py, forces, bearings.len(), 2)?)?;
        Ok(dict)
    }

    fn default_output_step(&self, duration: f64, speed: &Bound<'_, PyAny>, start: f64) -> PyResult<f64> {
        let fastest = super::speed::speed(speed)?.fastest(start, start + duration);
        Ok(simulate::default_output_step(self.model(), duration, fastest))
    }

    #[pyo3(signature = (duration, speed, *, method, linear, step, rtol, stages, modes, initial, times, record, geometry, start, progress, checkpoint))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        duration: f64,
        speed: &Bound<'py, PyAny>,
        method: &str,
        linear: Option<&str>,
        step: Option<f64>,
        rtol: Option<f64>,
        stages: Option<usize>,
        modes: Option<usize>,
        initial: &Bound<'py, PyAny>,
        times: PyReadonlyArray1<'py, f64>,
        record: Vec<simulate::Recorded>,
        geometry: &str,
        start: f64,
        progress: Option<Py<PyAny>>,
        checkpoint: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let options = analysis::simulate::Options {
            duration,
            speed: super::speed::speed(speed)?,
            method: simulate::method(method, linear)?,
            step,
            rtol,
            stages,
            modes,
            initial: state::initial(initial)?,
            times: times.as_array().to_vec(),
            geometry: self::geometry(geometry)?,
            start,
            checkpoint: checkpoint.map(state::checkpoint).transpose()?,
        };
        if let Some(text) = options.unattainable() {
            warn(py, text)?;
        }
        self.warn_of_ill_conditioning(
            py,
            self.representative_speed(options.fastest()),
            options.dense(&self.cached.model),
        )?;
        warn_of_speed(py, &self.model().scene, options.fastest())?;
        simulate::simulate(self, py, options, record, progress.as_ref())
    }
}
