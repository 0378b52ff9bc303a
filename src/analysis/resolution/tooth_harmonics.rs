//! The response at a constant speed to the harmonics of the tooth frequency, and the error that the elements leave in it.
//!
//! The teeth of a mesh with the stiffness k(t) and the transmission error e(t) excite the force k(t)(δ − e(t)) − k̄δ at the
//! static deflection δ. A mode with the deflection g of the mesh responds to a harmonic of the force, P at the frequency Ω,
//! with the amplitude −gP/(ω² − Ω² + icΩ). Elements change ω, but not the flexibility g²/ω²: displacements of nodes under
//! static forces at nodes are exact. The response is linear: a strong variation of the stiffness
//! also excites the modes of its phases (`super::contact_phases`).

use num_complex::Complex64;

use super::excited_modes::{damping, dot, elastic_modes, energy, examined_modes};
use super::{Candidate, SAFETY, Search, TIME};
use crate::linalg::DecompositionError;
use crate::modal::CachedModel;
use crate::model::Model;

/// Largest number of harmonics of a tooth frequency, and number of samples of a tooth cycle.
const MAX_HARMONICS: usize = 128;
const SAMPLES: usize = 512;
/// Smallest unit of an error, as a part of the mean of the signal; `gearbow.accuracy.scale` has the same value and its reason.
const SHARE_OF_MEAN: f64 = 0.02;

/// A natural frequency without and with the error of the elements.
struct ShiftedMode<'a> {
    /// Without the error, rad/s.
    exact: f64,
    /// With the error, rad/s.
    given: f64,
    /// Damping φᵀCφ, 1/s.
    damping: f64,
    /// Deflection of each mesh, m.
    deflections: Vec<f64>,
    /// Mode shape.
    shape: &'a [f64],
    /// Work of the static load on the mode over ω²: its amplitude in the equilibrium.
    equilibrium: f64,
}

/// A mesh force, or the lateral displacement of a gear.
struct Signal {
    /// Index of the mesh; none for a displacement.
    mesh: Option<usize>,
    /// Factor between amplitudes of the modes and the signal, for each of its components and each mode.
    rows: Vec<Vec<f64>>,
    /// Mean square that does not follow from the teeth: that of a bow which rotates.
    steady: f64,
    /// Sums of the squares of the amplitudes of difference and response.
    sums: [f64; 2],
}

/// Expected error of the worst signal at a speed of the reference shaft, rad/s: RMS of the difference over RMS of the
/// variation, or over a share of the mean if this is larger.
///
/// # Errors
/// [`DecompositionError`] if the modes cannot be computed.
pub(super) fn harmonics_error(
    search: &Search<'_>,
    cached: &CachedModel,
    elements: &Candidate,
    speed: f64,
) -> Result<f64, DecompositionError> {
    let model = &cached.model;
    if speed == 0.0 || model.meshes.is_empty() {
        return Ok(0.0);
    }
    let real = examined_modes(cached)?;
    let modes: Vec<ShiftedMode<'_>> = elastic_modes(&real)
        .into_iter()
        .map(|(frequency, shape)| {
            let energy = energy(model, frequency, shape);
            let error = search.frequency_error(frequency, &energy, &elements.lengths, &elements.degrees);
            let meshes = model.meshes.iter().enumerate();
            ShiftedMode {
                exact: frequency / (1.0 + error),
                given: frequency,
                // A resonance without damping grows for the time T, as one with this damping.
                damping: damping(model, frequency, shape).max(2.0 / TIME),
                deflections: meshes.map(|(i, mesh)| mesh.deflection_at_rest(model.sigma(i, 0.0), shape)).collect(),
                shape,
                equilibrium: dot(model.constant_load.as_slice(), shape) / frequency.powi(2),
            }
        })
        .collect();
    let mut signals = signals(model, &modes);
    for mesh in 0..model.meshes.len() {
        add_harmonics(model, mesh, &modes, speed, &mut signals);
    }
    let error = |signal: &Signal| {
        let mean = |row: &Vec<f64>| row.iter().zip(&modes).map(|(factor, mode)| factor * mode.equilibrium).sum::<f64>();
        let mean: f64 = signal.rows.iter().map(|row| mean(row).powi(2)).sum();
        let [difference, response] = signal.sums.map(|sum| sum / 2.0);
        let unit = (response + signal.steady).max(SHARE_OF_MEAN * SHARE_OF_MEAN * mean);
        let weight = if signal.mesh.is_some() { 1.0 } else { search.weight };
        weight * (difference / unit.max(f64::MIN_POSITIVE)).sqrt()
    };
    Ok(SAFETY * signals.iter().map(error).fold(0.0, f64::max))
}

/// The force of every mesh and the displacements of its gears.
fn signals(model: &Model, modes: &[ShiftedMode<'_>]) -> Vec<Signal> {
    let forces = model.meshes.iter().enumerate().map(|(i, mesh)| {
        let row = modes.iter().map(|mode| mesh.stiffness * mode.deflections[i]).collect();
        Signal { mesh: Some(i), rows: vec![row], steady: 0.0, sums: [0.0; 2] }
    });
    let gears = model.scene.meshes.iter().flat_map(|mesh| [mesh.driver, mesh.driven]);
    let moved = gears.filter_map(|gear| {
        let node = model.scene.gears[gear].body.node;
        let v = model.numbering.translation(node)?;
        let row = |index: usize| modes.iter().map(|mode| mode.shape[index]).collect();
        let steady = model.shafts[node.shaft].bow.as_ref().map_or(0.0, |bow| bow[2 * node.node].norm_sqr());
        Some(Signal { mesh: None, rows: vec![row(v), row(v + 1)], steady, sums: [0.0; 2] })
    });
    forces.chain(moved).collect()
}

/// Adds the response of the signals to the teeth of a mesh.
fn add_harmonics(model: &Model, mesh: usize, modes: &[ShiftedMode<'_>], speed: f64, signals: &mut [Signal]) {
    let driver = &model.scene.gears[model.scene.meshes[mesh].driver];
    let spin = speed * model.scene.speed_ratios[driver.body.node.shaft];
    let tooth_frequency = f64::from(driver.teeth) * spin.abs();
    let highest = modes.iter().map(|mode| mode.given).fold(0.0, f64::max);
    let count = ((highest / tooth_frequency) as usize).clamp(1, MAX_HARMONICS);
    for (i, force) in harmonics(model, mesh, modes, count).into_iter().enumerate() {
        let frequency = (i + 1) as f64 * tooth_frequency;
        let amplitudes: Vec<[Complex64; 2]> = modes
            .iter()
            .map(|mode| {
                let flexible = -force * mode.deflections[mesh] / mode.given.powi(2);
                let amplitude = |natural: f64| {
                    let square = natural * natural;
                    flexible * square / Complex64::new(square - frequency * frequency, mode.damping * frequency)
                };
                let exact = amplitude(mode.exact);
                [amplitude(mode.given) - exact, exact]
            })
            .collect();
        for signal in signals.iter_mut() {
            for row in &signal.rows {
                let direct = if signal.mesh == Some(mesh) { force } else { Complex64::ZERO };
                let mut sum = [Complex64::ZERO, direct];
                for (factor, amplitude) in row.iter().zip(&amplitudes) {
                    sum[0] += amplitude[0] * *factor;
                    sum[1] += amplitude[1] * *factor;
                }
                signal.sums[0] += sum[0].norm_sqr();
                signal.sums[1] += sum[1].norm_sqr();
            }
        }
    }
}

/// Amplitudes of the harmonics 1 to `count` of the force that the teeth of a mesh excite at the static deflection, N.
fn harmonics(model: &Model, index: usize, modes: &[ShiftedMode<'_>], count: usize) -> Vec<Complex64> {
    let mesh = &model.meshes[index];
    let deflection: f64 = modes.iter().map(|mode| mode.deflections[index] * mode.equilibrium).sum();
    let cycle = mesh.tooth_cycle(model.sigma(index, 0.0), SAMPLES);
    let force: Vec<f64> = cycle.iter().map(|teeth| teeth.stiffness * (deflection - teeth.error)).collect();
    let turn = std::f64::consts::TAU / SAMPLES as f64;
    let phasors: Vec<Complex64> = (0..SAMPLES).map(|i| Complex64::cis(-turn * i as f64)).collect();
    let harmonic = |order: usize| -> Complex64 {
        let terms = force.iter().enumerate().map(|(i, force)| phasors[i * order % SAMPLES] * *force);
        terms.sum::<Complex64>() * (2.0 / SAMPLES as f64)
    };
    (1..=count).map(harmonic).collect()
}
