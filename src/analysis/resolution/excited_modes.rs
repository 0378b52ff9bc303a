//! The modes that the teeth excite: frequency, damping, amplitude, and the elastic energy in each part of the shafts.

use crate::linalg::DecompositionError;
use crate::modal::CachedModel;
use crate::model::{Model, ShaftModel};

/// A mode of the mean mesh stiffness that the loads excite.
#[derive(Clone, Debug)]
pub struct ExcitedMode {
    /// Natural frequency ω, rad/s.
    pub frequency: f64,
    /// Damping φᵀCφ, twice the rate of decay, 1/s.
    pub damping: f64,
    /// Amplitude of the response to a step of each load, relative to the static response.
    pub amplitudes: Vec<f64>,
    /// Fractions of the elastic energy in the bending and in the torsion of each shaft.
    pub energy: Vec<[f64; 2]>,
}

/// The modes that the loads of a scene excite: forces of the meshes along their lines of action. Without meshes, loads
/// like those of bow and unbalance: a uniform and a linear acceleration of each shaft.
pub fn excited_modes(cached: &CachedModel) -> Result<Vec<ExcitedMode>, DecompositionError> {
    let model = &cached.model;
    let modes = cached.real_modes(0.0)?;
    let inertia = if model.meshes.is_empty() { inertia_loads(model) } else { Vec::new() };
    let elastic = modes.null..modes.frequencies.len();
    let mut found: Vec<ExcitedMode> = elastic
        .filter(|column| modes.frequencies[*column] > 0.0)
        .map(|column| {
            let (frequency, shape) = (modes.frequencies[column], modes.vectors.column(column));
            let shape = shape.as_slice();
            let deflection = |index: usize| model.meshes[index].deflection_at_rest(model.sigma(index, 0.0), shape);
            let meshes = (0..model.meshes.len()).map(deflection);
            let accelerated = inertia.iter().map(|load| load.iter().zip(shape).map(|(force, q)| force * q).sum());
            let square = frequency * frequency;
            ExcitedMode {
                frequency,
                damping: model.damping_form(shape)
                    + 2.0 * model.scene.modal_damping * frequency
                    + meshes.clone().zip(&model.meshes).map(|(value, mesh)| mesh.damping * value * value).sum::<f64>(),
                amplitudes: meshes.chain(accelerated).map(|value: f64| value * value / square).collect(),
                energy: model.shafts.iter().map(|shaft| elastic_energy(shaft, shape).map(|sum| sum / square)).collect(),
            }
        })
        .collect();
    normalize(&mut found);
    Ok(found)
}

/// Divides the amplitudes of each load by their sum.
fn normalize(modes: &mut [ExcitedMode]) {
    let loads = modes.first().map_or(0, |mode| mode.amplitudes.len());
    for load in 0..loads {
        let sum: f64 = modes.iter().map(|mode| mode.amplitudes[load]).sum();
        if sum > 0.0 {
            modes.iter_mut().for_each(|mode| mode.amplitudes[load] /= sum);
        }
    }
}

/// Twice the elastic energy of the bending and of the torsion of a shaft, J.
fn elastic_energy(shaft: &ShaftModel, q: &[f64]) -> [f64; 2] {
    let bending = shaft.bending.as_ref().map_or(0.0, |chain| chain.elastic_form::<2>(&q[chain.start..]));
    let twist = shaft.twist.as_ref().map_or(0.0, |chain| chain.elastic_form::<1>(&q[chain.start..]));
    [bending, twist]
}

/// Forces of inertia, n entries each, of a uniform and of a linear acceleration of each shaft along y and along z, and of
/// a uniform angular acceleration about x.
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
        if let Some(start) = model.numbering.torsion(shaft) {
            push(&|motion, node, _| motion[start + node] = 1.0);
        }
    }
    loads
}
