//! Frequency-domain analyses for Python: Campbell diagrams, critical speeds, synchronous response, peaks.

use std::f64::consts::TAU;

use nalgebra::Complex;
use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{mesh_names, stack, table};
use super::errors::{warn, warn_of_speed};
use super::handle::PyModel;
use crate::analysis::{
    self, AnalysisError, ExcitationPart, ExcitationSource, Harmonic, HarmonicForces, HarmonicSource, Interrupt, Kept,
    ResponsePoint, Threads, product,
};
use crate::modal::{self, CachedModel};
use crate::model::{Model, ShaftModel};
use crate::numerics::Sample;
use crate::scene::{EntryPath, Node, Scene, SceneDescription, SceneError, description, range_with_rpm, with_rpm};

/// Speed (rad/s), whirl, residual and number of the line of a critical speed.
pub type CriticalRow = (f64, String, f64, usize);
/// N_c (rad/s), amplitude (m), N₁ and N₂ (rad/s) of a peak, and whether the motion is stable there.
pub type PeakRow = (f64, f64, f64, f64, bool);

/// Copies speeds; each must be finite.
pub fn finite_speeds(speeds: &PyReadonlyArray1<'_, f64>) -> Result<Vec<f64>, SceneError> {
    let speeds = speeds.as_array().to_vec();
    for (index, speed) in speeds.iter().enumerate() {
        EntryPath::entry("speeds", index).finite(*speed)?;
    }
    Ok(speeds)
}

/// Reads the harmonic sources of a model.
pub fn harmonic_sources(model: &Model, given: &Bound<'_, PyAny>) -> PyResult<Vec<HarmonicSource>> {
    let given: Vec<description::Source> = pythonize::depythonize(given)?;
    let source = |(index, given): (usize, &description::Source)| HarmonicSource::new(model, given, index);
    Ok(given.iter().enumerate().map(source).collect::<Result<_, _>>()?)
}

/// Largest absolute value of the speeds, rad/s.
fn fastest(speeds: &[f64]) -> f64 {
    speeds.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()))
}

/// The fields of an `ExcitationLine` of Python.
#[derive(IntoPyObject)]
struct LineRow<'a> {
    kind: &'static str,
    source: LineSource<'a>,
    harmonic: u32,
    order: f64,
}

/// The name of a shaft, or of the two gears of a mesh.
#[derive(IntoPyObject)]
enum LineSource<'a> {
    #[pyo3(transparent)]
    Shaft(&'a str),
    Mesh(&'a str, &'a str),
}

impl<'a> LineRow<'a> {
    fn new(model: &'a Model, line: &analysis::ExcitationLine) -> Self {
        let (kind, source) = match line.source {
            ExcitationSource::Shaft(shaft) => ("shaft", LineSource::Shaft(&model.scene.shafts[shaft].name)),
            ExcitationSource::Mesh(mesh) => {
                let [driver, driven] = model.gear_names(mesh);
                ("mesh", LineSource::Mesh(driver, driven))
            }
        };
        Self { kind, source, harmonic: line.harmonic, order: line.order }
    }
}

/// The fields of an `Intersection` of Python; of its line the index.
#[derive(IntoPyObject)]
struct IntersectionRow {
    mode: usize,
    line: usize,
    speed: f64,
    frequency_hz: f64,
    damping_ratio: f64,
    whirl: String,
    residual: f64,
}

impl IntersectionRow {
    fn new(found: &analysis::Intersection) -> Self {
        Self {
            mode: found.mode,
            line: found.line,
            speed: found.speed,
            frequency_hz: found.eigenvalue.im / TAU,
            damping_ratio: modal::damping_ratio(found.eigenvalue),
            whirl: found.whirl.to_string(),
            residual: found.residual,
        }
    }
}

/// The fields of a `StabilityThreshold` of Python.
#[derive(IntoPyObject)]
struct ThresholdRow {
    mode: usize,
    speed: f64,
    frequency_hz: f64,
    whirl: String,
    above: &'static str,
    residual: f64,
}

impl ThresholdRow {
    fn new(found: &analysis::Threshold) -> Self {
        Self {
            mode: found.mode,
            speed: found.speed,
            frequency_hz: found.eigenvalue.im / TAU,
            whirl: found.whirl.to_string(),
            above: if found.is_unstable_above { "unstable" } else { "stable" },
            residual: found.residual,
        }
    }
}

/// Names of the types of motion of modes.
#[pyfunction]
pub fn whirl_classes() -> Vec<&'static str> {
    modal::Whirl::NAMES.to_vec()
}

#[pymethods]
impl PyModel {
    /// Computes a Campbell diagram: eigenvalues (speeds, modes), excitation lines and their intersections.
    fn campbell<'py>(
        &self,
        py: Python<'py>,
        speeds: PyReadonlyArray1<'py, f64>,
        count: usize,
        harmonics: u32,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let speeds = speeds.as_array().to_vec();
        warn_of_speed(py, &self.model().scene, fastest(&speeds))?;
        let rows = speeds.len();
        require_campbell(rows, count.min(2 * self.model().len()))?;
        let memory = analysis::memory_of_modes(self.model(), count);
        let found = self.run(py, memory, move |cached, interrupt| {
            let threads = Threads::new(memory.threads(&cached.model, threads), count);
            analysis::campbell(cached, &speeds, count, harmonics, &threads, interrupt)
        })?;
        let modes = found.eigenvalues.first().map_or(0, Vec::len);
        let whirl = |of: &Vec<_>| of.iter().map(ToString::to_string).collect::<Vec<_>>();
        let dict = PyDict::new(py);
        dict.set_item("eigenvalues", table(py, found.eigenvalues.concat(), rows, modes)?)?;
        dict.set_item("whirl", found.whirl.iter().map(whirl).collect::<Vec<_>>())?;
        let lines = found.lines.iter().map(|line| LineRow::new(self.model(), line));
        dict.set_item("lines", lines.collect::<Vec<_>>())?;
        dict.set_item("intersections", found.intersections.iter().map(IntersectionRow::new).collect::<Vec<_>>())?;
        dict.set_item("thresholds", found.thresholds.iter().map(ThresholdRow::new).collect::<Vec<_>>())?;
        Ok(dict)
    }

    /// Computes undamped critical speeds, rad/s, with the direction of whirl.
    #[pyo3(signature = (order, count=None))]
    fn critical_speeds(&self, py: Python<'_>, order: f64, count: Option<usize>) -> PyResult<Vec<(f64, String)>> {
        let count = count.unwrap_or(usize::MAX);
        let memory = analysis::memory_of_critical_speeds(self.model(), count);
        let found =
            self.run(py, memory, move |cached, interrupt| analysis::critical_speeds(cached, order, count, interrupt))?;
        Ok(found.iter().map(|critical| (critical.speed, critical.whirl.to_string())).collect())
    }

    /// Computes undamped critical speeds against the stiffness of every bearing, N/m: one list for each stiffness.
    fn critical_speed_map(
        &self,
        py: Python<'_>,
        stiffnesses: PyReadonlyArray1<'_, f64>,
        order: f64,
        count: Option<usize>,
        threads: usize,
    ) -> PyResult<Vec<Vec<CriticalRow>>> {
        let (stiffnesses, count) = (stiffnesses.as_array().to_vec(), count.unwrap_or(usize::MAX));
        let memory = analysis::memory_of_critical_speeds(self.model(), count);
        let Some(largest) = stiffnesses.iter().copied().reduce(f64::max) else {
            return Ok(Vec::new());
        };
        let with = |description: &SceneDescription, stiffness: f64| {
            let bearings = description.bearings.iter().map(|bearing| bearing.with_stiffness(stiffness)).collect();
            SceneDescription { bearings, ..description.clone() }
        };
        // The stiffest bearings need the finest elements. Equal elements make the shapes of all stiffnesses comparable.
        let given = with(&self.description, largest);
        let found = self.run(py, memory, move |cached, interrupt| {
            let description = analysis::resolve(&given, None, interrupt)?.description;
            let threads = Threads::new(memory.threads(&cached.model, threads), stiffnesses.len());
            let at = |stiffness: f64| Ok(Model::new(Scene::new(&with(&description, stiffness))?)?);
            analysis::critical_speed_map(at, &stiffnesses, order, count, &threads, interrupt)
        })?;
        let row = |point: &analysis::CriticalPoint| {
            (point.critical.speed, point.critical.whirl.to_string(), point.critical.residual, point.line)
        };
        Ok(found.iter().map(|points| points.iter().map(row).collect()).collect())
    }

    /// Computes the synchronous response: phasors (speeds, shafts, n), bearing forces and the bow of every shaft.
    fn synchronous<'py>(
        &self,
        py: Python<'py>,
        speeds: PyReadonlyArray1<'_, f64>,
        excitation: &str,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (speeds, part) =
            (finite_speeds(&speeds)?, ExcitationPart::named(excitation, &EntryPath::root("excitation"))?);
        let assembled = self.model();
        let sources: Vec<_> = (0..assembled.shafts.len()).map(|shaft| HarmonicSource::Shaft { shaft, part }).collect();
        let ratios: Vec<f64> = assembled.shafts.iter().map(ShaftModel::ratio_in_frame).collect();
        let lines = ratios.iter().map(|ratio| speeds.iter().map(|speed| ratio * speed).collect()).collect();
        let request = ResponseRequest { argument: "speeds", speeds: speeds.clone(), lines, sources };
        let (table, unstable) = request.run(self, py, threads, move |cached, table, threads, interrupt| {
            let peaks = local_maxima(&table.largest);
            match analysis::unstable_ranges(cached, &speeds, &peaks, threads, interrupt) {
                Err(AnalysisError::Interrupted) => Err(AnalysisError::Interrupted),
                unstable => Ok(unstable),
            }
        })?;
        for (index, largest) in table.largest.iter().enumerate() {
            if let Some(text) = analysis::small_displacement_check(assembled, *largest) {
                warn(py, format!("speeds[{index}]: {text}"))?;
            }
        }
        if let Some(text) = instability_warning(unstable) {
            warn(py, text)?;
        }
        let dict = table.into_dict(self, py)?;
        let bow: Vec<Complex<f64>> = assembled.numbering.to_user_order(analysis::bow(assembled).as_slice());
        dict.set_item("bow", bow.into_pyarray(py))?;
        Ok(dict)
    }

    /// Computes the response to harmonic sources at pairs of a frequency and a speed: phasors (pairs, sources, n), bearing
    /// forces and mesh forces.
    fn frequency_response<'py>(
        &self,
        py: Python<'py>,
        frequencies: PyReadonlyArray1<'_, f64>,
        speeds: PyReadonlyArray1<'_, f64>,
        sources: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (frequencies, speeds) = (frequencies.as_array().to_vec(), finite_speeds(&speeds)?);
        for (index, frequency) in frequencies.iter().enumerate() {
            EntryPath::entry("frequencies", index).finite(*frequency)?;
        }
        let sources = harmonic_sources(self.model(), sources)?;
        let request = ResponseRequest { argument: "frequencies", speeds, lines: vec![frequencies], sources };
        request.run(self, py, threads, |_, _, _, _| Ok(()))?.0.into_dict(self, py)
    }

    /// Computes (N_c, amplitude, N₁, N₂, whether the motion is stable) of every peak. `samples` are pairs of a speed, rad/s, and the
    /// major semi-axis of the orbit there, m. N₁ or N₂ is NaN if it lies outside the speed range.
    fn peaks(
        &self,
        py: Python<'_>,
        samples: Vec<(f64, f64)>,
        index: usize,
        source: usize,
        excitation: &str,
        slow_roll: Option<f64>,
    ) -> PyResult<Vec<PeakRow>> {
        let part = ExcitationPart::named(excitation, &EntryPath::root("excitation"))?;
        let samples: Vec<Sample> = samples.iter().map(|(at, value)| Sample { at: *at, value: *value }).collect();
        let index = self.model().numbering.dofs()[index].index;
        let probe = analysis::Probe { index, source, part, slow_roll };
        require_peaks(samples.len())?;
        let memory = analysis::memory_of_responses(self.model());
        let found =
            self.run(py, memory, move |cached, interrupt| analysis::peaks(cached, probe, &samples, interrupt))?;
        let open = f64::NAN;
        let row = |peak: &analysis::Peak| {
            (peak.speed, peak.amplitude, peak.lower.unwrap_or(open), peak.upper.unwrap_or(open), peak.is_stable)
        };
        Ok(found.iter().map(row).collect())
    }
}

/// Responses to harmonic sources over a list of speeds or frequencies.
struct ResponseRequest {
    /// Name of the list.
    argument: &'static str,
    /// Speed of the reference shaft at each entry, rad/s.
    speeds: Vec<f64>,
    /// Frequency at each entry, rad/s: one list for all sources, or one for each.
    lines: Vec<Vec<f64>>,
    sources: Vec<HarmonicSource>,
}

impl ResponseRequest {
    /// The responses, and what `then` finds in the same task.
    fn run<T: Send + 'static>(
        self,
        model: &PyModel,
        py: Python<'_>,
        threads: usize,
        then: impl FnOnce(&CachedModel, &HarmonicTable, &Threads, &Interrupt) -> Result<T, AnalysisError> + Send + 'static,
    ) -> PyResult<(HarmonicTable, T)> {
        let assembled = model.model();
        let memory = analysis::memory_of_responses(assembled);
        let fastest = fastest(&self.speeds);
        model.warn_of_ill_conditioning(py, model.representative_speed(fastest), memory)?;
        warn_of_speed(py, &assembled.scene, fastest)?;
        let mut table = HarmonicTable::new(assembled, self.argument, self.speeds.len(), self.sources.len())?;
        model.run(py, memory, move |cached, interrupt| {
            let threads = Threads::new(memory.threads(&cached.model, threads), self.speeds.len());
            let responses =
                analysis::FrequencyResponses::new(cached, self.argument, self.lines.iter().flatten().copied());
            let shared = self.sources.len() / self.lines.len().max(1);
            let points: Vec<_> = self
                .speeds
                .iter()
                .enumerate()
                .flat_map(|(index, speed)| {
                    let sources = self.sources.chunks(shared.max(1));
                    self.lines.iter().zip(sources).map(move |(line, sources)| ResponsePoint {
                        index,
                        at: Harmonic { frequency: line[index], speed: *speed },
                        sources,
                    })
                })
                .collect();
            responses.each(&points, &threads, interrupt, |point, at, found| table.add(at, point, found))?;
            let found = then(cached, &table, &threads, interrupt)?;
            Ok::<_, AnalysisError>((table, found))
        })
    }
}

/// Responses to harmonic sources in the form of the result: arrays adopt the lists without copies.
struct HarmonicTable {
    /// Number of the speeds or frequencies, and of the sources.
    rows: usize,
    sources: usize,
    bearings: Vec<Node>,
    /// Phasors (rows, sources, n), m and rad, in the order of the degrees of freedom that users see.
    phasors: Vec<Complex<f64>>,
    /// Bearing forces (rows, sources, 2 bearings), N.
    bearing_force: Vec<Complex<f64>>,
    /// Displacements of shafts relative to what bearings stand on (rows, sources, 2 bearings), m.
    bearing_displacement: Vec<Complex<f64>>,
    /// Mesh forces (rows, sources, meshes), N.
    mesh_force: Vec<Complex<f64>>,
    /// Largest residual over the sources at each row.
    residuals: Vec<f64>,
    /// Largest displacement of a node along y or z over the sources at each row, m.
    largest: Vec<f64>,
}

impl HarmonicTable {
    /// Room for the responses over a list called `argument`.
    fn new(model: &Model, argument: &'static str, rows: usize, sources: usize) -> Result<Self, SceneError> {
        let bearings = model.scene.bearing_nodes();
        let values = model.len() + 4 * bearings.len() + model.meshes.len();
        let kept = Kept {
            argument,
            what: format!("the response at {rows} {argument} to {sources} sources"),
            bytes: product(&[rows, sources, values, size_of::<Complex<f64>>()]),
            remedy: if argument == "speeds" {
                "give fewer speeds at a time"
            } else {
                "give fewer frequencies at a time"
            },
        };
        kept.require()?;
        let room = |values: usize| kept.room(rows * sources * values);
        Ok(Self {
            rows,
            sources,
            phasors: room(model.len())?,
            bearing_force: room(2 * bearings.len())?,
            bearing_displacement: room(2 * bearings.len())?,
            mesh_force: room(model.meshes.len())?,
            residuals: vec![0.0; rows],
            largest: vec![0.0; rows],
            bearings,
        })
    }

    /// Adds the responses of a model at a point.
    fn add(&mut self, model: &Model, point: &ResponsePoint<'_>, found: &[Option<analysis::SourceResponse>]) {
        let zeros = |count: usize| std::iter::repeat_n(Complex::ZERO, count);
        for (source, response) in point.sources.iter().zip(found) {
            let Some(response) = response else {
                self.phasors.extend(zeros(model.len()));
                self.bearing_force.extend(zeros(2 * self.bearings.len()));
                self.bearing_displacement.extend(zeros(2 * self.bearings.len()));
                self.mesh_force.extend(zeros(model.meshes.len()));
                continue;
            };
            let phasors = response.phasors.as_slice();
            self.residuals[point.index] = self.residuals[point.index].max(response.residual);
            let largest = model.translations().map(|i| phasors[i].norm()).fold(0.0, f64::max);
            self.largest[point.index] = self.largest[point.index].max(largest);
            self.phasors.extend(model.numbering.to_user_order(phasors));
            let forces = HarmonicForces { model, at: point.at, source: Some(source), phasors };
            self.bearing_force.extend(self.bearings.iter().flat_map(|node| forces.bearing(*node)));
            self.bearing_displacement.extend(self.bearings.iter().flat_map(|node| forces.in_bearing(*node)));
            self.mesh_force.extend(forces.meshes());
        }
    }

    fn into_dict<'py>(self, model: &PyModel, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (assembled, rows, sources) = (model.model(), self.rows, self.sources);
        let (directions, meshes) = (2 * self.bearings.len(), assembled.meshes.len());
        let dict = PyDict::new(py);
        dict.set_item("phasors", stack(py, self.phasors, rows, sources, assembled.len())?)?;
        dict.set_item("bearing_force", stack(py, self.bearing_force, rows, sources, directions)?)?;
        let moved = stack(py, self.bearing_displacement, rows, sources, directions)?;
        dict.set_item("bearing_displacement", moved)?;
        dict.set_item("mesh_force", stack(py, self.mesh_force, rows, sources, meshes)?)?;
        dict.set_item("residuals", self.residuals.into_pyarray(py))?;
        dict.set_item("bearings", self.bearings.iter().map(|node| model.place(*node)).collect::<Vec<_>>())?;
        dict.set_item("meshes", mesh_names(assembled, 0..meshes))?;
        Ok(dict)
    }
}

/// Refuses speeds whose synchronous responses at one place do not fit into memory.
fn require_peaks(speeds: usize) -> Result<(), SceneError> {
    let kept = Kept {
        argument: "speeds",
        what: format!("the amplitudes at {speeds} speeds"),
        // The speeds of both directions of rotation, and the size of the response.
        bytes: product(&[speeds, 2, size_of::<Complex<f64>>()]),
        remedy: "give fewer speeds at a time",
    };
    kept.require()
}

/// Refuses a Campbell diagram that does not fit into memory.
fn require_campbell(speeds: usize, modes: usize) -> Result<(), SceneError> {
    let kept = Kept {
        argument: "speeds",
        what: format!("{modes} eigenvalues at {speeds} speeds"),
        // A complex eigenvalue in the search and in the result, and the text of the whirl in Rust and in Python.
        bytes: product(&[speeds, modes, 256]),
        remedy: "give fewer speeds at a time, or a smaller count",
    };
    kept.require()
}

/// Indices of the values that are larger than their neighbours: at most eight, those with the largest values.
fn local_maxima(values: &[f64]) -> Vec<usize> {
    let is_maximum = |at: &usize| values[*at] > values[at - 1] && values[*at] >= values[at + 1];
    let mut found: Vec<usize> = (1..values.len().saturating_sub(1)).filter(is_maximum).collect();
    found.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    found.truncate(8);
    found
}

/// Text of the warning of ranges of speeds, rad/s, in which the motion is unstable; none without such ranges.
fn instability_warning(ranges: Result<Vec<[f64; 2]>, AnalysisError>) -> Option<String> {
    let ranges = match ranges {
        Ok(ranges) if ranges.is_empty() => return None,
        Ok(ranges) => ranges,
        Err(error) => return Some(format!("speeds: whether the motion is stable could not be found: {error}")),
    };
    let range = |[low, high]: &[f64; 2]| {
        if low == high { format!("at {}", with_rpm(*low)) } else { format!("from {}", range_with_rpm([*low, *high])) }
    };
    let ranges: Vec<String> = ranges.iter().map(range).collect();
    Some(format!(
        "speeds: the motion is unstable {}: a mode has negative damping, and grows until something else limits it, so that the steady response given there does not occur; find the threshold with campbell(speeds).thresholds, and stay below it or add damping",
        ranges.join(", ")
    ))
}
