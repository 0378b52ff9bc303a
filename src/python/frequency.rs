//! Frequency-domain analyses for Python: Campbell diagrams, critical speeds, synchronous response, peaks.

use nalgebra::{Complex, DMatrix};
use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{mesh_names, stack, table};
use super::errors::{warn, warn_of_speed};
use super::handle::PyModel;
use crate::analysis::{
    self, AnalysisError, ExcitationPart, ExcitationSource, Harmonic, HarmonicForces, HarmonicSource, Kept, Threads,
    product,
};
use crate::modal;
use crate::model::Model;
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

/// Largest absolute value of the speeds, rad/s.
fn fastest(speeds: &[f64]) -> f64 {
    speeds.iter().fold(0.0, |most: f64, speed| most.max(speed.abs()))
}

/// Computes a Campbell diagram: eigenvalues (speeds, modes), excitation lines and their intersections.
pub fn campbell<'py>(
    model: &PyModel,
    py: Python<'py>,
    speeds: &PyReadonlyArray1<'py, f64>,
    count: usize,
    harmonics: u32,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let speeds = speeds.as_array().to_vec();
    warn_of_speed(py, &model.cached.model.scene, fastest(&speeds))?;
    let rows = speeds.len();
    require_campbell(rows, count.min(2 * model.model().len()))?;
    let memory = analysis::memory_of_modes(model.model(), count);
    let found = model.run(py, memory, move |cached, interrupt| {
        let threads = Threads::new(memory.threads(&cached.model, threads), count);
        analysis::campbell(cached, &speeds, count, harmonics, &threads, interrupt)
    })?;
    let modes = found.eigenvalues.first().map_or(0, Vec::len);
    let whirl = |of: &Vec<_>| of.iter().map(ToString::to_string).collect::<Vec<_>>();
    let line = |line: &analysis::ExcitationLine| match line.source {
        ExcitationSource::Shaft(shaft) => {
            ("shaft", vec![model.cached.model.scene.shafts[shaft].name.as_str()], line.harmonic)
        }
        ExcitationSource::Mesh(mesh) => ("mesh", model.cached.model.gear_names(mesh).to_vec(), line.harmonic),
    };
    let intersections = &found.intersections;
    let list = |of: fn(&analysis::Intersection) -> usize| intersections.iter().map(of).collect::<Vec<_>>();
    let dict = PyDict::new(py);
    dict.set_item("eigenvalues", table(py, found.eigenvalues.concat(), rows, modes)?)?;
    dict.set_item("whirl", found.whirl.iter().map(whirl).collect::<Vec<_>>())?;
    dict.set_item("lines", found.lines.iter().map(line).collect::<Vec<_>>())?;
    dict.set_item("orders", found.lines.iter().map(|line| line.order).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("intersection_modes", list(|intersection| intersection.mode))?;
    dict.set_item("intersection_lines", list(|intersection| intersection.line))?;
    let at: Vec<_> = intersections.iter().map(|intersection| intersection.speed).collect();
    let eigenvalues: Vec<_> = intersections.iter().map(|intersection| intersection.eigenvalue).collect();
    dict.set_item("intersection_speeds", at.into_pyarray(py))?;
    dict.set_item("intersection_eigenvalues", eigenvalues.into_pyarray(py))?;
    dict.set_item(
        "intersection_whirl",
        intersections.iter().map(|intersection| intersection.whirl.to_string()).collect::<Vec<_>>(),
    )?;
    let residuals: Vec<_> = intersections.iter().map(|intersection| intersection.residual).collect();
    dict.set_item("intersection_residuals", residuals.into_pyarray(py))?;
    let thresholds: Vec<_> = found.thresholds.iter().map(threshold).collect();
    dict.set_item("thresholds", thresholds)?;
    Ok(dict)
}

/// Mode, speed [rad/s], frequency [rad/s] and whirl of a stability threshold, whether the mode is unstable above it, and the
/// residual.
fn threshold(found: &analysis::Threshold) -> (usize, f64, f64, String, bool, f64) {
    let whirl = found.whirl.to_string();
    (found.mode, found.speed, found.eigenvalue.im, whirl, found.is_unstable_above, found.residual)
}

/// Names of the types of motion of modes.
#[pyfunction]
pub fn whirl_classes() -> Vec<&'static str> {
    modal::Whirl::NAMES.to_vec()
}

/// Computes undamped critical speeds, rad/s, with the direction of whirl.
pub fn critical_speeds(
    model: &PyModel,
    py: Python<'_>,
    order: f64,
    count: Option<usize>,
) -> PyResult<Vec<(f64, String)>> {
    let count = count.unwrap_or(usize::MAX);
    let memory = analysis::memory_of_critical_speeds(model.model(), count);
    let found =
        model.run(py, memory, move |cached, interrupt| analysis::critical_speeds(cached, order, count, interrupt))?;
    Ok(found.iter().map(|critical| (critical.speed, critical.whirl.to_string())).collect())
}

/// Computes undamped critical speeds against the stiffness of every bearing, N/m: one list for each stiffness.
pub fn critical_speed_map(
    model: &PyModel,
    py: Python<'_>,
    stiffnesses: &PyReadonlyArray1<'_, f64>,
    order: f64,
    count: Option<usize>,
    threads: usize,
) -> PyResult<Vec<Vec<CriticalRow>>> {
    let (stiffnesses, count) = (stiffnesses.as_array().to_vec(), count.unwrap_or(usize::MAX));
    let memory = analysis::memory_of_critical_speeds(model.model(), count);
    let Some(largest) = stiffnesses.iter().copied().reduce(f64::max) else {
        return Ok(Vec::new());
    };
    let with = |description: &SceneDescription, stiffness: f64| {
        let bearings = description.bearings.iter().map(|bearing| bearing.with_stiffness(stiffness)).collect();
        SceneDescription { bearings, ..description.clone() }
    };
    // The stiffest bearings need the finest elements. Equal elements make the shapes of all stiffnesses comparable.
    let given = with(&model.description, largest);
    let found = model.run(py, memory, move |cached, interrupt| {
        let description = analysis::resolve(&given, interrupt)?.description;
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
pub fn synchronous<'py>(
    model: &PyModel,
    py: Python<'py>,
    speeds: &PyReadonlyArray1<'_, f64>,
    excitation: &str,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (speeds, part) = (finite_speeds(speeds)?, ExcitationPart::named(excitation, &EntryPath::root("excitation"))?);
    let memory = analysis::memory_of_responses(model.model());
    model.warn_of_ill_conditioning(py, model.representative_speed(fastest(&speeds)), memory)?;
    warn_of_speed(py, &model.cached.model.scene, fastest(&speeds))?;
    let assembled = &model.cached.model;
    let bearings = assembled.scene.bearing_nodes();
    let (rows, shafts, directions) = (speeds.len(), assembled.shafts.len(), 2 * bearings.len());
    let kept = amplitudes_kept(rows, shafts * (assembled.len() + directions));
    kept.require()?;
    let (amplitudes, forces) = (kept.room(rows * shafts * assembled.len())?, kept.room(rows * shafts * directions)?);
    let nodes = bearings.clone();
    let found = model.run(py, memory, move |cached, interrupt| {
        let mut found =
            ResponseTable { amplitudes, forces, residuals: Vec::new(), largest: Vec::new(), unstable: Ok(Vec::new()) };
        let threads = Threads::new(memory.threads(&cached.model, threads), speeds.len());
        let responses = analysis::Responses::new(cached, &speeds);
        responses.each(&speeds, part, &threads, interrupt, |speed, at_speed, response| {
            found.add(at_speed, speed, response, &nodes);
        })?;
        let peaks = local_maxima(&found.largest);
        found.unstable = match analysis::unstable_ranges(cached, &speeds, &peaks, &threads, interrupt) {
            Err(AnalysisError::Interrupted) => return Err(AnalysisError::Interrupted),
            unstable => unstable,
        };
        Ok(found)
    })?;
    for (index, largest) in found.largest.into_iter().enumerate() {
        if let Some(text) = analysis::small_displacement_check(assembled, largest) {
            warn(py, format!("speeds[{index}]: {text}"))?;
        }
    }
    if let Some(text) = instability_warning(found.unstable) {
        warn(py, text)?;
    }
    let dict = PyDict::new(py);
    dict.set_item("amplitudes", stack(py, found.amplitudes, rows, shafts, assembled.len())?)?;
    dict.set_item("bearing_force", stack(py, found.forces, rows, shafts, directions)?)?;
    dict.set_item("residuals", found.residuals.into_pyarray(py))?;
    dict.set_item("bearings", bearings.iter().map(|node| model.place(*node)).collect::<Vec<_>>())?;
    let bow: Vec<Complex<f64>> = assembled.numbering.to_user_order(analysis::bow(assembled).as_slice());
    dict.set_item("bow", bow.into_pyarray(py))?;
    Ok(dict)
}

/// The responses at several speeds, in the form of the result: arrays adopt the lists without copies.
struct ResponseTable {
    /// Amplitudes (speeds, shafts, n), m and rad, in the order of the degrees of freedom that users see.
    amplitudes: Vec<Complex<f64>>,
    /// Bearing forces (speeds, shafts, 2 bearings), N.
    forces: Vec<Complex<f64>>,
    /// Residual at each speed.
    residuals: Vec<f64>,
    /// Largest displacement at each speed, m.
    largest: Vec<f64>,
    /// Ranges of unstable speeds, rad/s.
    unstable: Result<Vec<[f64; 2]>, AnalysisError>,
}

impl ResponseTable {
    /// Adds the amplitudes of the model at a speed, rad/s: one column for each shaft, in the order of the core.
    fn add(&mut self, model: &Model, speed: f64, response: &analysis::Response, bearings: &[Node]) {
        let sources = &response.amplitudes;
        self.residuals.push(response.residual);
        self.largest.push(largest_displacement(model, sources));
        for (column, shaft) in sources.column_iter().zip(&model.shafts) {
            let phasors = column.as_slice();
            self.amplitudes.extend(model.numbering.to_user_order(phasors));
            let at = Harmonic { frequency: shaft.ratio * speed, speed };
            let forces = HarmonicForces { model, at, source: None, phasors };
            self.forces.extend(bearings.iter().flat_map(|node| forces.bearing(*node)));
        }
    }
}

/// Memory of `values` complex amplitudes at each of a number of speeds.
fn amplitudes_kept(speeds: usize, values: usize) -> Kept<'static> {
    Kept {
        argument: "speeds",
        what: format!("the amplitudes at {speeds} speeds"),
        bytes: product(&[speeds, values, size_of::<Complex<f64>>()]),
        remedy: "give fewer speeds at a time",
    }
}

/// Refuses a Campbell diagram that does not fit into memory.
fn require_campbell(speeds: usize, modes: usize) -> Result<(), SceneError> {
    // A complex eigenvalue in the search and in the result, and the text of the whirl in Rust and in Python.
    const BYTES: usize = 256;
    let kept = Kept {
        argument: "speeds",
        what: format!("{modes} eigenvalues at {speeds} speeds"),
        bytes: product(&[speeds, modes, BYTES]),
        remedy: "give fewer speeds at a time, or a smaller count",
    };
    kept.require()
}

/// Largest magnitude of the displacements of nodes along y and z, m.
fn largest_displacement(model: &Model, amplitudes: &DMatrix<Complex<f64>>) -> f64 {
    model.translations().map(|i| amplitudes.row(i).camax()).fold(0.0, f64::max)
}

/// Indices of the values that are larger than their neighbours: at most eight, those with the largest values.
fn local_maxima(values: &[f64]) -> Vec<usize> {
    const MOST: usize = 8;
    let is_maximum = |at: &usize| values[*at] > values[at - 1] && values[*at] >= values[at + 1];
    let mut found: Vec<usize> = (1..values.len().saturating_sub(1)).filter(is_maximum).collect();
    found.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    found.truncate(MOST);
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

/// Computes (N_c, amplitude, N₁, N₂, whether the motion is stable) of every peak. N₁ or N₂ is NaN if it lies outside the
/// speed range.
pub fn peaks(
    model: &PyModel,
    py: Python<'_>,
    speeds: &PyReadonlyArray1<'_, f64>,
    index: usize,
    source: usize,
    excitation: &str,
    slow_roll: Option<f64>,
) -> PyResult<Vec<PeakRow>> {
    let (speeds, part) = (finite_speeds(speeds)?, ExcitationPart::named(excitation, &EntryPath::root("excitation"))?);
    let index = model.cached.model.numbering.dofs()[index].index;
    let probe = analysis::Probe { index, source, part, slow_roll };
    // The speeds of both directions of rotation, and the size of the response.
    amplitudes_kept(speeds.len(), 2).require()?;
    let memory = analysis::memory_of_responses(model.model());
    let found = model.run(py, memory, move |cached, interrupt| analysis::peaks(cached, probe, &speeds, interrupt))?;
    let open = f64::NAN;
    let row = |peak: &analysis::Peak| {
        (peak.speed, peak.amplitude, peak.lower.unwrap_or(open), peak.upper.unwrap_or(open), peak.is_stable)
    };
    Ok(found.iter().map(row).collect())
}

/// Computes the response to harmonic sources at pairs of a frequency and a speed: phasors (pairs, sources, n), bearing
/// forces and mesh forces.
pub fn frequency_response<'py>(
    model: &PyModel,
    py: Python<'py>,
    frequencies: &PyReadonlyArray1<'_, f64>,
    speeds: &PyReadonlyArray1<'_, f64>,
    sources: &[description::Source],
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (frequencies, speeds) = (frequencies.as_array().to_vec(), finite_speeds(speeds)?);
    for (index, frequency) in frequencies.iter().enumerate() {
        EntryPath::entry("frequencies", index).finite(*frequency)?;
    }
    let assembled = model.model();
    let source = |(index, given): (usize, &description::Source)| HarmonicSource::new(assembled, given, index);
    let sources = sources.iter().enumerate().map(source).collect::<Result<Vec<_>, _>>()?;
    let memory = analysis::memory_of_responses(assembled);
    model.warn_of_ill_conditioning(py, model.representative_speed(fastest(&speeds)), memory)?;
    warn_of_speed(py, &assembled.scene, fastest(&speeds))?;
    let bearings = assembled.scene.bearing_nodes();
    let (rows, meshes, directions) = (frequencies.len(), assembled.meshes.len(), 2 * bearings.len());
    let count = sources.len();
    let kept = Kept {
        argument: "frequencies",
        what: format!("the response at {rows} frequencies to {count} sources"),
        bytes: product(&[rows, count, assembled.len() + directions + meshes, size_of::<Complex<f64>>()]),
        remedy: "give fewer frequencies at a time",
    };
    kept.require()?;
    let room = |values: usize| kept.room(rows * count * values);
    let mut table = HarmonicTable {
        phasors: room(assembled.len())?,
        bearing_force: room(directions)?,
        mesh_force: room(meshes)?,
        residuals: Vec::with_capacity(rows),
    };
    let nodes = bearings.clone();
    let table = model.run(py, memory, move |cached, interrupt| {
        let threads = Threads::new(memory.threads(&cached.model, threads), frequencies.len());
        let responses = analysis::FrequencyResponses::new(cached, &sources, &frequencies);
        let point = |(frequency, speed): (&f64, &f64)| Harmonic { frequency: *frequency, speed: *speed };
        let points: Vec<_> = frequencies.iter().zip(&speeds).map(point).collect();
        responses.each(&points, &threads, interrupt, |at, at_speed, found| {
            table.add(at_speed, at, &sources, found, &nodes);
        })?;
        Ok::<_, AnalysisError>(table)
    })?;
    let dict = PyDict::new(py);
    dict.set_item("phasors", stack(py, table.phasors, rows, count, assembled.len())?)?;
    dict.set_item("bearing_force", stack(py, table.bearing_force, rows, count, directions)?)?;
    dict.set_item("mesh_force", stack(py, table.mesh_force, rows, count, meshes)?)?;
    dict.set_item("residuals", table.residuals.into_pyarray(py))?;
    dict.set_item("bearings", bearings.iter().map(|node| model.place(*node)).collect::<Vec<_>>())?;
    dict.set_item("meshes", mesh_names(assembled, 0..meshes))?;
    Ok(dict)
}

/// Responses to harmonic sources in the form of the result.
struct HarmonicTable {
    /// Phasors (pairs, sources, n), m and rad, in the order of the degrees of freedom that users see.
    phasors: Vec<Complex<f64>>,
    /// Bearing forces (pairs, sources, 2 bearings), N.
    bearing_force: Vec<Complex<f64>>,
    /// Mesh forces (pairs, sources, meshes), N.
    mesh_force: Vec<Complex<f64>>,
    /// Largest residual over the sources at each pair.
    residuals: Vec<f64>,
}

impl HarmonicTable {
    /// Adds the responses at a frequency and speed.
    fn add(
        &mut self,
        model: &Model,
        at: Harmonic,
        sources: &[HarmonicSource],
        found: &[analysis::SourceResponse],
        bearings: &[Node],
    ) {
        self.residuals.push(found.iter().map(|response| response.residual).fold(0.0, f64::max));
        for (source, response) in sources.iter().zip(found) {
            let phasors = response.phasors.as_slice();
            self.phasors.extend(model.numbering.to_user_order(phasors));
            let forces = HarmonicForces { model, at, source: Some(source), phasors };
            self.bearing_force.extend(bearings.iter().flat_map(|node| forces.bearing(*node)));
            self.mesh_force.extend(forces.meshes());
        }
    }
}
