//! The Python methods of `_core.Model`.

use nalgebra::{Complex, DMatrix, DVector};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;

use super::convert::{mesh_fields, mesh_names, outside_matrix, outside_sparse, outside_vector, plain, table};
use super::errors::warn;
use super::handle::PyModel;
use super::options::{RecordEntry, record_plan};
use super::state::mesh_geometry;
use super::{background, speed};
use crate::analysis::simulate::{round_below, sample_step};
use crate::analysis::{self, AnalysisError, Dense, ElementErrors, Kept, product};
use crate::connection::{MESH_CHANNELS, mesh_values};
use crate::mesh::MeshLoss;
use crate::modal::{self, AtSpeed, CachedModel, ModeSelection};
use crate::model::{Model, ShaftModel};
use crate::scene::{EntryPath, Node, SceneDescription, SceneError, nearest};

/// Angles at which a static equilibrium gives the contact forces of a ring. The mean of their power 9/2 has converged to 1e-6.
const CONTACT_ANGLES: usize = 720;

/// A gear or disk by name, or a shaft by name and a position on it, m.
#[derive(FromPyObject)]
enum At {
    Body(String),
    Position(String, f64),
}

/// Where on a shaft a coordinate belongs.
#[derive(IntoPyObject)]
enum Site {
    /// Position of a node, m.
    #[pyo3(transparent)]
    Node(f64),
    /// Positions of the two ends of an element, m.
    Element(f64, f64),
}

/// Refuses modes that do not fit into memory.
fn require_modes(model: &Model, count: usize) -> Result<(), SceneError> {
    let modes = count.min(2 * model.len());
    let kept = Kept {
        argument: "count",
        what: format!("the shapes of {modes} modes over {} degrees of freedom", model.len()),
        // A complex shape in the search, twice in the result and its conversion, and four vectors of a Krylov space of states.
        bytes: product(&[modes, model.len(), 160]),
        remedy: "ask for fewer modes",
    };
    kept.require()
}

/// The model at a speed and, if it is given, a frequency, both rad/s.
fn at_frequency(cached: &CachedModel, speed: f64, frequency: Option<f64>) -> Result<AtSpeed<'_>, AnalysisError> {
    Ok(match frequency {
        Some(frequency) => cached.at(speed, frequency)?,
        None => cached.at_speed(speed)?,
    })
}

#[pymethods]
impl PyModel {
    #[new]
    fn new(py: Python<'_>, description: &Bound<'_, PyAny>) -> PyResult<Self> {
        let description = SceneDescription::from_objects(&mut Depythonizer::from_object(description))?;
        // The choice of the elements needs the modes: other threads of Python continue meanwhile.
        background::result_of(py, move |interrupt| Self::build(description, interrupt))
    }

    #[staticmethod]
    fn from_toml(py: Python<'_>, text: &str) -> PyResult<Self> {
        let description = SceneDescription::from_toml(text)?;
        background::result_of(py, move |interrupt| Self::build(description, interrupt))
    }

    /// A system that differs from this one; see [`Self::build_changed`].
    fn changed(owner: &Bound<'_, Self>, description: &Bound<'_, PyAny>, is_variation: bool) -> PyResult<Self> {
        let description = SceneDescription::from_objects(&mut Depythonizer::from_object(description))?;
        let base = owner.clone().unbind();
        background::result_of(owner.py(), move |interrupt| {
            Self::build_changed(description, base.get(), is_variation, interrupt)
        })
    }

    /// Uses the modes and state-space models of another system, if the two differ in loads only; returns whether it does.
    fn share(&self, other: &Self) -> bool {
        self.share_linear_part(other)
    }

    fn description<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.description)
    }

    /// The description with the chosen numbers and degrees of elements.
    fn resolved<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.resolved.description)
    }

    /// Level, expected error, permitted error and highest frequency [rad/s] of the chosen elements.
    #[getter]
    fn choice(&self) -> Option<(&'static str, f64, f64, f64)> {
        self.resolved.choice.as_ref().map(|choice| {
            let level = choice.level.level().name;
            (level, choice.expected_error, choice.permitted_error, choice.highest_frequency)
        })
    }

    /// Whether stiffness or damping depend on the speed.
    #[getter]
    fn depends_on_speed(&self) -> bool {
        self.model().depends_on_speed()
    }

    /// Gradient of the deflection of the drive flanks of each mesh normal to the teeth, at rest, (meshes, n).
    fn mesh_gradients<'py>(&self, py: Python<'py>, speed: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let model = self.model();
        let meshes = model.meshes.len();
        let row = |mesh| model.numbering.to_user_order(&analysis::normal_gradient(model, mesh, speed));
        table(py, (0..meshes).flat_map(row).collect(), meshes, model.len())
    }

    /// Mass, kg, centre of mass, m, polar and diametral moment of inertia, kg m², of each shaft with what it carries.
    fn mass_properties(&self) -> Vec<[f64; 4]> {
        let found = analysis::mass_properties(&self.model().scene);
        found.iter().map(|shaft| [shaft.mass, shaft.centre, shaft.polar, shaft.diametral]).collect()
    }

    #[getter]
    fn has_meshes(&self) -> bool {
        !self.model().meshes.is_empty()
    }

    /// Expected error of mesh forces, or of displacements without meshes, with these elements; with a speed [rad/s], at this
    /// speed.
    #[pyo3(signature = (speed=None))]
    fn expected_error(&self, py: Python<'_>, speed: Option<f64>) -> PyResult<f64> {
        if let (Some(choice), None) = (&self.resolved.choice, speed) {
            return Ok(choice.expected_error);
        }
        if let Some(errors) = self.element_errors.get() {
            return Ok(errors.expected(speed));
        }
        let resolved = self.resolved.clone();
        let errors = self.run(py, Dense::Undamped, move |cached, _| ElementErrors::new(&resolved, cached))?;
        Ok(self.element_errors.get_or_init(|| errors).expected(speed))
    }

    fn to_toml(&self) -> PyResult<String> {
        Ok(self.description.to_toml()?)
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model().scene.warnings.clone()
    }

    #[getter]
    fn dofs(&self) -> Vec<(String, Site, String)> {
        let dofs = self.model().numbering.dofs().iter();
        dofs.map(|dof| {
            let (shaft, position) = self.place(dof.node);
            let next = Node { node: dof.node.node + 1, ..dof.node };
            let is_inside = dof.degree.is_some() && dof.node.shaft < self.model().shafts.len();
            let site = if is_inside { Site::Element(position, self.place(next).1) } else { Site::Node(position) };
            (shaft.to_owned(), site, dof.name())
        })
        .collect()
    }

    fn embed<'py>(
        &self,
        py: Python<'py>,
        coarser: &Self,
        state: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (own, coarser) = (&self.model().numbering, &coarser.model().numbering);
        let other = || SceneError::new("state", "is of a system with other nodes");
        let halves = state.as_slice()?.chunks_exact(coarser.len().max(1));
        if state.len()? != 2 * coarser.len() {
            return Err(other().into());
        }
        let embedded = halves.map(|half| own.embed(coarser, half)).collect::<Option<Vec<_>>>();
        Ok(PyArray1::from_vec(py, embedded.ok_or_else(other)?.concat()))
    }

    #[getter]
    fn shafts(&self) -> Vec<String> {
        self.model().scene.shafts.iter().map(|shaft| shaft.name.clone()).collect()
    }

    /// Speeds of the shafts relative to the frames of their lateral motion, over that of the reference shaft.
    #[getter]
    fn ratios_in_frames<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.model().shafts.iter().map(ShaftModel::ratio_in_frame))
    }

    #[getter]
    fn speed_ratios<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.model().scene.speed_ratios)
    }

    fn indices(&self, at: At) -> PyResult<(Option<usize>, Option<usize>, Option<usize>)> {
        let model = self.model();
        let place = EntryPath::root("at");
        let node = match &at {
            At::Body(name) => {
                let of_housing = || model.scene.housing_point(name).map(|(node, _)| node);
                model.scene.body(name).map(|body| body.node).or_else(of_housing).ok_or_else(|| {
                    let names = model.scene.bodies().map(|body| body.name.as_str()).chain(model.scene.housing_names());
                    place.error(format!("no gear, disk or housing is called \"{name}\"{}", nearest(name, names)))
                })?
            }
            At::Position(shaft, position) => {
                let index = model.scene.known_shaft(shaft, &place)?;
                Node { shaft: index, node: model.scene.shafts[index].require_node(*position, &place)? }
            }
        };
        let (translation, twist) = (model.numbering.translation(node), model.numbering.twist(node));
        let outside = |index: usize| model.numbering.dofs().iter().position(|dof| dof.index == index);
        Ok((translation.and_then(outside), translation.and_then(|v| outside(v + 1)), twist.and_then(outside)))
    }

    #[pyo3(signature = (speed=0.0, frequency=None))]
    fn matrices<'py>(&self, py: Python<'py>, speed: f64, frequency: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        EntryPath::root("speed").finite(speed)?;
        EntryPath::root("frequency").finite(frequency.unwrap_or(0.0))?;
        // The matrix of modal damping is a sum over the modes.
        let dense = if !self.model().scene.modal_damping.is_zero() { Dense::Undamped } else { Dense::Matrices };
        let matrices = self.run(py, dense, move |cached, _| -> Result<_, AnalysisError> {
            let cached = at_frequency(cached, speed, frequency)?;
            let model = &cached.model;
            let outside = |matrix: DMatrix<f64>| outside_matrix(&model.numbering, &matrix);
            Ok([
                ("mass", outside(model.mass_matrix())),
                ("stiffness", outside(model.stiffness_matrix(speed))),
                ("damping", outside(cached.damping_matrix(speed)?)),
                ("gyroscopic", outside(model.gyroscopic_matrix())),
            ])
        })?;
        let dict = PyDict::new(py);
        for (name, matrix) in matrices {
            dict.set_item(name, matrix.into_pyarray(py))?;
        }
        Ok(dict)
    }

    #[pyo3(signature = (speed=0.0, frequency=None))]
    fn sparse_matrices<'py>(
        &self,
        py: Python<'py>,
        speed: f64,
        frequency: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        EntryPath::root("speed").finite(speed)?;
        EntryPath::root("frequency").finite(frequency.unwrap_or(0.0))?;
        if !self.model().scene.modal_damping.is_zero() {
            let message = "must be False with modal damping, whose matrix has no zeros";
            return Err(SceneError::new("sparse", message).into());
        }
        let matrices = self.run(py, Dense::Bands, move |cached, _| -> Result<_, AnalysisError> {
            let cached = at_frequency(cached, speed, frequency)?;
            let model = &cached.model;
            Ok([
                ("mass", model.sparse_mass()),
                ("stiffness", model.sparse_stiffness(speed)),
                ("damping", model.sparse_damping(speed)),
                ("gyroscopic", model.sparse_gyroscopic()),
            ])
        })?;
        let dict = PyDict::new(py);
        for (name, matrix) in matrices {
            dict.set_item(name, outside_sparse(py, &self.model().numbering, &matrix))?;
        }
        Ok(dict)
    }

    #[pyo3(signature = (speed, count=None, vibrating=false))]
    fn modes<'py>(
        &self,
        py: Python<'py>,
        speed: f64,
        count: Option<usize>,
        vibrating: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        EntryPath::root("speed").finite(speed)?;
        let count = count.unwrap_or(usize::MAX);
        require_modes(self.model(), count)?;
        let memory = analysis::memory_of_modes(self.model(), count);
        self.warn_of_ill_conditioning(py, speed, memory)?;
        let (modes, shapes, shares) = self.run(py, memory, move |cached, _| -> Result<_, AnalysisError> {
            let selection = if vibrating { ModeSelection::Vibrations } else { ModeSelection::All };
            let modes = analysis::lowest_modes(cached, speed, count, selection)?;
            let (model, numbering) = (&cached.model, &cached.model.numbering);
            let shapes: Vec<Complex<f64>> =
                modes.iter().flat_map(|mode| numbering.to_user_order(mode.shape.as_slice())).collect();
            let shares = |mode: &modal::Mode| {
                let shares = mode.kinetic_shares(model);
                numbering.dofs().iter().map(|dof| shares[dof.index]).collect::<Vec<_>>()
            };
            let shares: Vec<f64> = modes.iter().flat_map(shares).collect();
            Ok((modes, shapes, shares))
        })?;
        let numbering = &self.model().numbering;
        let list = |of: fn(&modal::Mode) -> f64| modes.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
        let eigenvalues: Vec<_> = modes.iter().map(|mode| mode.eigenvalue).collect();
        let whirl: Vec<_> = modes.iter().map(|mode| mode.whirl.to_string()).collect();
        let dict = PyDict::new(py);
        dict.set_item("eigenvalues", eigenvalues.into_pyarray(py))?;
        dict.set_item("frequencies_hz", list(modal::Mode::frequency_hz))?;
        dict.set_item("damping_ratios", list(modal::Mode::damping_ratio))?;
        dict.set_item("whirl", whirl)?;
        dict.set_item("residuals", list(|mode| mode.residual.value))?;
        let vibrates = |mode: &modal::Mode| modal::vibrates(self.model(), speed, mode.eigenvalue);
        dict.set_item("vibrates", modes.iter().map(vibrates).collect::<Vec<_>>().into_pyarray(py))?;
        dict.set_item("shapes", table(py, shapes, modes.len(), numbering.len())?)?;
        dict.set_item("kinetic_shares", table(py, shares, modes.len(), numbering.len())?)?;
        Ok(dict)
    }

    /// The static equilibrium; or the forces at displacements `state`, with what remains unbalanced.
    #[pyo3(signature = (geometry="live", speed=0.0, state=None))]
    fn r#static<'py>(
        &self,
        py: Python<'py>,
        geometry: &str,
        speed: f64,
        state: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let geometry = mesh_geometry(geometry)?;
        EntryPath::root("speed").finite(speed)?;
        let at_speed = self.cached.at(speed, 0.0)?;
        let model = &at_speed.model;
        let dict = PyDict::new(py);
        let (found, residuals) = if let Some(state) = state {
            let q = DVector::from_vec(model.numbering.in_core_order(state.as_slice()?));
            let change = modal::EquilibriumChange::new(model, geometry, speed.into(), q.clone());
            let change = change.map_err(AnalysisError::from)?;
            let unbalanced = change.unbalanced().map_err(AnalysisError::from)?;
            dict.set_item("unbalanced", outside_vector(py, &model.numbering, &unbalanced))?;
            let moved = change.without_null_motions();
            dict.set_item("without_null_motions", outside_vector(py, &model.numbering, &moved))?;
            (q, Vec::new())
        } else {
            model.scene.refuse_turning_weight()?;
            self.warn_of_ill_conditioning(py, speed, Dense::Bands)?;
            self.run(py, Dense::Bands, move |cached, _| -> Result<_, AnalysisError> {
                let found = analysis::equilibrium(cached, geometry, speed)?;
                let residuals = analysis::equilibrium_residuals(cached, geometry, speed, &found)?;
                Ok((found, residuals))
            })?
        };
        let q = found.as_slice();
        let largest = model.translations().map(|i| q[i].abs()).fold(0.0, f64::max);
        if let Some(text) = analysis::small_displacement_check(model, largest) {
            warn(py, text)?;
        }
        let mut series: [Vec<f64>; MESH_CHANNELS.len()] = Default::default();
        for (index, mesh) in model.meshes.iter().enumerate() {
            let state = mesh.state_at_rest(geometry, model.sigma(index, speed), q).map_err(|overlap| {
                let [driver, driven] = model.gear_names(index);
                AnalysisError::overlap(driver, driven, "in static equilibrium", overlap)
            })?;
            for (values, value) in series.iter_mut().zip(mesh_values(&state)) {
                values.push(value);
            }
        }
        let bearings = model.scene.bearing_nodes();
        let forces: Vec<_> = bearings.iter().map(|node| model.static_bearing_force(*node, speed, q)).collect();
        dict.set_item("state", outside_vector(py, &model.numbering, &found))?;
        let names = model.scene.shafts.iter().map(|shaft| &shaft.name);
        let names = names.chain(model.scene.housings.iter().map(|housing| &housing.name));
        dict.set_item("residuals", names.zip(residuals).collect::<Vec<_>>())?;
        dict.set_item("meshes", mesh_names(model, 0..model.meshes.len()))?;
        dict.set_item("mesh", mesh_fields(py, series, 1, model.meshes.len(), true)?)?;
        dict.set_item("bearings", bearings.iter().map(|node| self.place(*node)).collect::<Vec<_>>())?;
        let lateral: Vec<f64> = forces.iter().flat_map(|force| force[..2].iter().copied()).collect();
        dict.set_item("bearing_force", table(py, lateral, bearings.len(), 2)?)?;
        let relative = |node: &Node| {
            let rows = model.bearing_displacement(*node).unwrap_or_default();
            rows.map(|row| row.iter().map(|(index, factor)| factor * q[*index]).sum::<f64>())
        };
        let displacements: Vec<f64> = bearings.iter().flat_map(relative).collect();
        dict.set_item("bearing_displacement", table(py, displacements, bearings.len(), 2)?)?;
        let along = forces.iter().map(|force| force[2]).collect();
        dict.set_item("axial_bearing_force", PyArray1::from_vec(py, along))?;
        let contacts = |node: &Node| {
            let mut rings = model.nonlinear_bearings_at(*node);
            let found = rings.find_map(|bearing| bearing.contact_forces(q, CONTACT_ANGLES));
            found.map(|forces| PyArray1::from_vec(py, forces))
        };
        dict.set_item("contact_forces", bearings.iter().map(contacts).collect::<Vec<_>>())?;
        Ok(dict)
    }

    /// The power that torques and drives supply at each speed, W, and (power, force, coefficient, loss) of each mesh.
    fn losses(&self, py: Python<'_>, speeds: Vec<f64>, geometry: &str) -> PyResult<Vec<(f64, Vec<[f64; 4]>)>> {
        let geometry = mesh_geometry(geometry)?;
        for (index, speed) in speeds.iter().enumerate() {
            EntryPath::root("speed").index(index).finite(*speed)?;
        }
        self.run(py, Dense::Bands, move |cached, interrupt| -> Result<_, AnalysisError> {
            let mut found = Vec::with_capacity(speeds.len());
            for speed in speeds {
                interrupt.check()?;
                let losses = analysis::losses(cached, geometry, speed)?;
                let values = |mesh: &MeshLoss| [mesh.power, mesh.force, mesh.coefficient, mesh.loss];
                found.push((losses.input, losses.meshes.iter().map(values).collect()));
            }
            Ok(found)
        })
    }

    fn default_output_step(&self, duration: f64, speed: &Bound<'_, PyAny>, start: f64) -> PyResult<f64> {
        let fastest = speed::speed(speed)?.fastest(start, start + duration);
        // At least a thousand samples in the run.
        Ok(round_below(sample_step(self.model(), fastest).min(duration / 1000.0)))
    }

    /// Memory of the record of a run with a number of times, bytes.
    fn record_bytes(&self, record: Vec<RecordEntry>, times: usize) -> PyResult<u64> {
        Ok(record_plan(self.model(), record)?.bytes(self.model(), times))
    }
}
