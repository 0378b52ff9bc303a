//! The modes that the teeth excite: frequency, damping, amplitude, and the elastic energy in each part of the shafts.

use std::borrow::Cow;

use super::varying_loads::{VaryingLoad, varying_loads};
use crate::connection::{Connection, Row, along_row};
use crate::linalg::DecompositionError;
use crate::mesh::GearMesh;
use crate::modal::{CachedModel, RealModes};
use crate::model::{Model, RodChain, ShaftModel};
use crate::numerics::EQUALITY_TOLERANCE;

/// Step of a mesh force, relative to the static force, that its teeth excite. A pair of teeth that engages without
/// transition has the fraction 1/ε of the mean stiffness, with contact ratios ε of 1.4 to 1.8.
const ENGAGEMENT_STEP: f64 = 0.6;
/// Largest number of coordinates of a model of which all modes are examined, to choose elements and to estimate the error of
/// given ones. A larger one is examined in a Krylov space of its loads. The highest modes in this space depend on round-off: with
/// 400 for both, a change of lengths by 1e-14 changed the chosen number of coordinates of six machines, by up to 73 %. The chosen
/// elements have at most 1200 coordinates, and housings add some. All modes of 1200 coordinates take 0.3 s. Of a larger train, the
/// modes of each mesh are examined.
pub const LARGEST_TO_CHOOSE: usize = 1300;
pub const LARGEST_TO_ESTIMATE: usize = 400;
/// Numbers of vectors of the Krylov space of these modes: the smallest one, and that for each load. With them, a rotor of 20
/// disks and a train of 40 disks have the elements that all modes give.
const MIN_VECTORS: usize = 120;
const VECTORS_PER_LOAD: usize = 10;

/// A mode of the mean mesh stiffness that the loads excite.
#[derive(Clone, Debug)]
pub struct ExcitedMode {
    /// Natural frequency ω, rad/s.
    pub frequency: f64,
    /// Damping φᵀCφ, twice the rate of decay, 1/s.
    pub damping: f64,
    /// Fractions of the elastic energy in the bending, in the torsion and in the axial strain of each shaft.
    pub energy: Vec<[f64; 3]>,
}

/// A signal that a load excites.
#[derive(Clone, Debug)]
pub struct Signal {
    /// Square of the amplitude in each mode after a step of the load.
    pub squares: Vec<f64>,
    /// Mean square of its variation that the modes do not cause: that of a bow which rotates.
    pub steady: f64,
    /// Whether it is a displacement.
    pub displacement: bool,
}

impl Signal {
    fn displacement(squares: Vec<f64>) -> Self {
        Self { squares, steady: 0.0, displacement: true }
    }

    fn force(squares: Vec<f64>) -> Self {
        Self { squares, steady: 0.0, displacement: false }
    }
}

/// Signals and modes of a scene.
#[derive(Clone, Debug, Default)]
pub struct Excitation {
    /// The signals.
    pub signals: Vec<Signal>,
    /// The modes.
    pub modes: Vec<ExcitedMode>,
}

/// The response of the mesh forces and of the gears to steps of the mesh forces, of gears and disks to the loads of a run that
/// starts from rest, and of both to loads over time. Without meshes, also that of the shafts to a uniform and a linear acceleration of each shaft.
///
/// All modes are examined up to `largest` coordinates.
pub fn excitation(cached: &CachedModel, largest: usize) -> Result<Excitation, DecompositionError> {
    let model = &cached.model;
    let modes = examined_modes(cached, largest)?;
    let elastic = elastic_modes(&modes);
    let mut signals: Vec<Signal> =
        (0..model.meshes.len()).flat_map(|mesh| of_mesh_step(model, mesh, &elastic)).collect();
    signals.extend(released_loads(model).iter().flat_map(|load| of_release(model, load, &elastic)));
    signals.extend(varying_loads(model).iter().flat_map(|load| of_varying_load(model, load, &elastic)));
    if model.meshes.is_empty() {
        let square = |load: &[f64], (frequency, shape): &(f64, &[f64])| (dot(load, shape) / frequency).powi(4);
        let of_load = |load: &Vec<f64>| elastic.iter().map(|mode| square(load, mode)).collect();
        signals.extend(inertia_loads(model).iter().map(|load| Signal::displacement(of_load(load))));
    }
    let modes = elastic.iter().map(|(frequency, shape)| ExcitedMode {
        frequency: *frequency,
        damping: damping(model, *frequency, shape),
        energy: energy(model, *frequency, shape),
    });
    Ok(Excitation { modes: modes.collect(), signals })
}

/// The undamped modes of a model of up to `largest` coordinates, or those of a larger one that the loads excite.
pub(super) fn examined_modes(cached: &CachedModel, largest: usize) -> Result<Cow<'_, RealModes>, DecompositionError> {
    let model = &cached.model;
    if model.len() <= largest {
        return cached.real_modes(0.0).map(Cow::Borrowed);
    }
    let loads = loads(model);
    cached.modes_of_loads(0.0, &loads, MIN_VECTORS.max(VECTORS_PER_LOAD * loads.len())).map(Cow::Owned)
}

/// Frequencies, rad/s, and shapes of the modes that have one.
pub(super) fn elastic_modes(modes: &RealModes) -> Vec<(f64, &[f64])> {
    let n = modes.vectors.nrows();
    let elastic = (modes.null..modes.frequencies.len()).filter(|column| modes.frequencies[*column] > 0.0);
    elastic.map(|column| (modes.frequencies[column], &modes.vectors.as_slice()[column * n..][..n])).collect()
}

/// Fractions of the elastic energy of a mode in the bending, in the torsion and in the axial strain of each shaft.
pub(super) fn energy(model: &Model, frequency: f64, shape: &[f64]) -> Vec<[f64; 3]> {
    model.shafts.iter().map(|shaft| elastic_energy(shaft, shape).map(|e| e / frequency.powi(2))).collect()
}

/// The loads that [`excitation`] counts, n entries each.
fn loads(model: &Model) -> Vec<Vec<f64>> {
    let of_row = |row: Row| {
        let mut load = vec![0.0; model.len()];
        row.iter().for_each(|(index, coefficient)| load[*index] += coefficient);
        load
    };
    let mut loads: Vec<Vec<f64>> = model
        .connections(0.0)
        .filter(Connection::is_local)
        .flat_map(|connection| connection.rows())
        .map(of_row)
        .collect();
    loads.extend(released_loads(model));
    if model.meshes.is_empty() {
        loads.extend(inertia_loads(model));
    }
    loads
}

/// The force of a mesh, and the displacements of its gears, after a step of the force.
fn of_mesh_step(model: &Model, index: usize, elastic: &[(f64, &[f64])]) -> Vec<Signal> {
    let mesh = &model.meshes[index];
    let deflections: Vec<f64> =
        elastic.iter().map(|(_, shape)| mesh.deflection_at_rest(model.sigma(index, 0.0), shape)).collect();
    let modes = || elastic.iter().zip(&deflections);
    let load = model.constant_load.as_slice();
    let static_deflection: f64 = modes().map(|((w, shape), value)| value * dot(load, shape) / (w * w)).sum();
    let step = ENGAGEMENT_STEP * mesh.stiffness * static_deflection;
    let mut signals = vec![Signal::force(modes().map(|((w, _), value)| (value / w).powi(4)).collect())];
    for gear in [model.scene.meshes[index].driver, model.scene.meshes[index].driven] {
        let node = model.scene.gears[gear].body.node;
        let Some(v) = model.numbering.translation(node) else { continue };
        let steady = model.shafts[node.shaft].bow.as_ref().map_or(0.0, |bow| bow[2 * node.node].norm_sqr());
        let square = |((w, shape), value): (&(f64, &[f64]), &f64)| {
            (shape[v].hypot(shape[v + 1]) * value * step / (w * w)).powi(2)
        };
        signals.push(Signal { steady, ..Signal::displacement(modes().map(square).collect()) });
    }
    signals
}

/// The displacements of gears and disks after a step of a load; without gears and disks, the RMS displacement of all masses.
fn of_release(model: &Model, load: &[f64], elastic: &[(f64, &[f64])]) -> Vec<Signal> {
    let amplitudes: Vec<f64> = elastic.iter().map(|(w, shape)| dot(load, shape) / (w * w)).collect();
    let moved = lateral_motion(model, elastic, &amplitudes);
    if moved.is_empty() { vec![all_masses(&amplitudes)] } else { significant(moved) }
}

/// The mesh forces, and the lateral displacements and twists of gears and disks, that a load over time causes.
fn of_varying_load(model: &Model, load: &VaryingLoad<'_>, elastic: &[(f64, &[f64])]) -> Vec<Signal> {
    let amplitude = |(w, shape): &(f64, &[f64])| {
        along_row(&load.entries, shape) * load.amplitude(*w, damping(model, *w, shape)) / (w * w)
    };
    let amplitudes: Vec<f64> = elastic.iter().map(amplitude).collect();
    let each = |scalar: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
        elastic.iter().zip(&amplitudes).map(|((_, shape), amplitude)| (scalar(shape) * amplitude).powi(2)).collect()
    };
    let meshes = model.meshes.iter().enumerate();
    let force = |(i, mesh): (usize, &GearMesh)| {
        Signal::force(each(&|shape| mesh.deflection_at_rest(model.sigma(i, 0.0), shape)))
    };
    let twisted = model.scene.bodies().filter_map(|body| model.numbering.twist(body.node));
    let twists = twisted.map(|index| Signal::displacement(each(&|shape| shape[index]))).collect();
    let kinds = [meshes.map(force).collect(), lateral_motion(model, elastic, &amplitudes), twists];
    if kinds.iter().all(Vec::is_empty) {
        return vec![all_masses(&amplitudes)];
    }
    kinds.into_iter().flat_map(significant).collect()
}

/// The lateral displacement of each gear and disk in modes of the given amplitudes.
fn lateral_motion(model: &Model, elastic: &[(f64, &[f64])], amplitudes: &[f64]) -> Vec<Signal> {
    let bodies = model.scene.bodies().filter_map(|body| model.numbering.translation(body.node));
    let moved = bodies.map(|v| {
        let displacement = |((_, shape), amplitude): (&(f64, &[f64]), &f64)| shape[v].hypot(shape[v + 1]) * amplitude;
        Signal::displacement(elastic.iter().zip(amplitudes).map(|pair| displacement(pair).powi(2)).collect())
    });
    moved.collect()
}

/// The signals of one kind without those that are round-off beside the largest.
fn significant(mut signals: Vec<Signal>) -> Vec<Signal> {
    let size = |signal: &Signal| signal.squares.iter().sum::<f64>();
    let largest = signals.iter().map(size).fold(0.0, f64::max);
    // A smaller displacement under the same load is round-off.
    signals.retain(|signal| size(signal) > largest * EQUALITY_TOLERANCE * EQUALITY_TOLERANCE);
    signals
}

/// The RMS displacement of all masses.
fn all_masses(amplitudes: &[f64]) -> Signal {
    // The modes have unit modal mass, so that the sum of these squares is the mean weighted with the mass.
    Signal::displacement(amplitudes.iter().map(|amplitude| amplitude.powi(2)).collect())
}

/// Loads that a run releases at its start, n entries each: bow, torques and gravity of a run from rest, the bow of a run
/// from the static equilibrium, and unbalance, whose size depends on the speed.
fn released_loads(model: &Model) -> Vec<Vec<f64>> {
    let (mut bow, mut unbalance) = (vec![0.0; model.len()], vec![0.0; model.len()]);
    for excitation in model.shafts.iter().flat_map(|shaft| &shaft.excitations) {
        for (load, amplitude) in [(&mut bow, excitation.steady_amplitude()), (&mut unbalance, excitation.unbalance)] {
            load[excitation.index] += amplitude.re;
            load[excitation.index + 1] += amplitude.im;
        }
    }
    let all: Vec<f64> = bow.iter().zip(&model.constant_load).map(|(bow, constant)| bow + constant).collect();
    let acts = |load: &Vec<f64>| load.iter().any(|force| *force != 0.0);
    let has_constant = model.constant_load.iter().any(|force| *force != 0.0);
    let loads = [has_constant.then_some(all), Some(bow), Some(unbalance)];
    loads.into_iter().flatten().filter(acts).collect()
}

/// φᵀCφ of a mode, 1/s.
pub(super) fn damping(model: &Model, frequency: f64, shape: &[f64]) -> f64 {
    let meshes = model.meshes.iter().enumerate();
    let of_mesh = |(index, mesh): (usize, &GearMesh)| {
        mesh.damping * mesh.deflection_at_rest(model.sigma(index, 0.0), shape).powi(2)
    };
    model.damping_form(shape)
        + 2.0 * model.scene.modal_damping.smallest_at(frequency) * frequency
        + meshes.map(of_mesh).sum::<f64>()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Twice the elastic energy of the bending, of the torsion and of the axial strain of a shaft, J.
fn elastic_energy(shaft: &ShaftModel, q: &[f64]) -> [f64; 3] {
    let bending = shaft.bending.as_ref().map_or(0.0, |chain| chain.elastic_form::<2>(&q[chain.start..]));
    let rod = |chain: &Option<RodChain>| chain.as_ref().map_or(0.0, |chain| chain.elastic_form::<1>(&q[chain.start..]));
    [bending, rod(&shaft.twist), rod(&shaft.axial)]
}

/// Forces of inertia, n entries each, of a uniform and of a linear acceleration of each shaft along y and along z, and of
/// a uniform acceleration about x and along x.
fn inertia_loads(model: &Model) -> Vec<Vec<f64>> {
    let mut loads = Vec::new();
    for (shaft, given) in model.scene.shafts.iter().enumerate() {
        let mut push = |set: &dyn Fn(&mut [f64], usize, f64)| {
            let mut motion = vec![0.0; model.len()];
            for (node, x) in given.nodes.iter().enumerate() {
                set(&mut motion, node, *x);
            }
            let mut load = vec![0.0; model.len()];
            model.multiply_mass(&motion, &mut load);
            loads.push(load);
        };
        if let Some(start) = model.numbering.lateral(shaft) {
            for direction in 0..2 {
                push(&|motion, node, _| motion[start + 4 * node + direction] = 1.0);
                // The rotation φ of the section is the slope of u.
                push(&|motion, node, x| {
                    motion[start + 4 * node + direction] = x;
                    motion[start + 4 * node + 2 + direction] = 1.0;
                });
            }
        }
        for start in model.numbering.torsion(shaft).into_iter().chain(model.numbering.axial(shaft)) {
            push(&|motion, node, _| motion[start + node] = 1.0);
        }
    }
    loads
}
