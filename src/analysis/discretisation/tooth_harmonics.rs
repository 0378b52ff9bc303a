//! The response at a constant speed to the harmonics of the tooth frequency, and the error that the elements leave in it.
//!
//! The teeth of a mesh with the stiffness k(t) and the transmission error e(t) excite the force k(t)(δ − e(t)) − k̄δ at the
//! static deflection δ. A mode with the deflection g of the mesh responds to a harmonic of the force, P at the frequency Ω,
//! with the amplitude −gP/(ω² − Ω² + icΩ). Elements change ω, but not the flexibility g²/ω²: displacements of nodes under
//! static forces at nodes are exact. The response is linear: a strong variation of the stiffness also excites the modes of
//! its phases (`super::contact_phases`).
//!
//! The variation of a signal also contains the response to bow and unbalance, without gyroscopic moments.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::excited_modes::{LARGEST_TO_ESTIMATE, damping, dot, elastic_modes, energy, examined_modes};
use super::{Candidate, STEP_RESPONSE_SAFETY, Search};
use crate::linalg::DecompositionError;
use crate::modal::CachedModel;
use crate::model::{Model, ShaftModel};
use crate::scene::{COMPARED_DURATION, SHARE_OF_MEAN};

/// Largest number of harmonics of a tooth frequency, and number of samples of a tooth cycle.
const MAX_HARMONICS: usize = 128;
pub(super) const TOOTH_CYCLE_SAMPLES: usize = 512;

/// A natural frequency without and with the error of the elements.
#[derive(Debug)]
struct ShiftedMode {
    /// Without the error, rad/s.
    exact: f64,
    /// With the error, rad/s.
    given: f64,
    /// Damping φᵀCφ, 1/s.
    damping: f64,
    /// Deflection of each mesh, m.
    deflections: Vec<f64>,
    /// Forces of bow and of unbalance at the spin 1 rad/s on each shaft, N and N s².
    rotating: Vec<[Complex64; 2]>,
}

impl ShiftedMode {
    /// Amplitude under a unit force of the frequency Ω, rad/s, if the mode has the natural frequency `natural`, rad/s.
    fn amplitude(&self, natural: f64, frequency: f64) -> Complex64 {
        let ratio = (natural / self.given).powi(2);
        ratio / Complex64::new(natural * natural - frequency * frequency, self.damping * frequency)
    }
}

/// A mesh force, or the lateral displacement of a gear.
#[derive(Debug)]
struct Signal {
    /// Index of the mesh; none for a displacement.
    mesh: Option<usize>,
    /// Factor between amplitudes of the modes and the signal, for each of its components and each mode.
    rows: Vec<Vec<f64>>,
    /// Square of the mean of the signal.
    mean_square: f64,
    /// Weight of its error beside that of mesh forces.
    weight: f64,
}

/// The teeth of a mesh.
#[derive(Debug)]
struct Teeth {
    /// Tooth frequency over the speed of the reference shaft.
    order: f64,
    /// Amplitudes of the harmonics of the force that they excite, N.
    harmonics: Vec<Complex64>,
}

/// The response of a model to its teeth at any constant speed.
#[derive(Debug)]
pub(super) struct ToothResponse {
    modes: Vec<ShiftedMode>,
    signals: Vec<Signal>,
    teeth: Vec<Teeth>,
    /// Speed ratio of each shaft.
    ratios: Vec<f64>,
}

impl ToothResponse {
    /// The response of a model with these elements.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes cannot be computed.
    pub fn new(search: &Search<'_>, cached: &CachedModel, elements: &Candidate) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let real = examined_modes(cached, LARGEST_TO_ESTIMATE)?;
        let shapes = elastic_modes(&real);
        let mode = |(frequency, shape): &(f64, &[f64])| {
            let energy = energy(model, *frequency, shape);
            let shafts = elements.shafts.iter().zip(search.layouts).zip(search.automatic);
            let error = shafts.map(|((shaft, layout), index)| {
                layout.frequency_error(&shaft.lengths, shaft.elements.degree, *frequency, energy[*index])
            });
            let error = error.sum::<f64>().min(1.0);
            let meshes = model.meshes.iter().enumerate();
            ShiftedMode {
                exact: frequency / (1.0 + error),
                given: *frequency,
                // A resonance without damping grows for the time T, as one with this damping.
                damping: damping(model, *frequency, shape).max(2.0 / COMPARED_DURATION),
                deflections: meshes.map(|(i, mesh)| mesh.deflection_at_rest(model.sigma(i, 0.0), shape)).collect(),
                rotating: rotating_forces(model, shape),
            }
        };
        let modes: Vec<ShiftedMode> = shapes.iter().map(mode).collect();
        // Amplitudes of the modes in the equilibrium.
        let equilibrium: Vec<f64> = shapes
            .iter()
            .map(|(frequency, shape)| dot(model.constant_load.as_slice(), shape) / frequency.powi(2))
            .collect();
        let signal = |mesh: Option<usize>, rows: Vec<Vec<f64>>| {
            let mean_square = rows.iter().map(|row| dot(row, &equilibrium).powi(2)).sum();
            Signal { mesh, rows, mean_square, weight: if mesh.is_some() { 1.0 } else { search.weight } }
        };
        let forces = model.meshes.iter().enumerate().map(|(i, mesh)| {
            signal(Some(i), vec![modes.iter().map(|mode| mesh.stiffness * mode.deflections[i]).collect()])
        });
        let gears = model.scene.meshes.iter().flat_map(|mesh| [mesh.driver, mesh.driven]);
        let moved = gears.filter_map(|gear| {
            let v = model.numbering.translation(model.scene.gears[gear].body.node)?;
            let row = |index: usize| shapes.iter().map(|(_, shape)| shape[index]).collect();
            Some(signal(None, vec![row(v), row(v + 1)]))
        });
        let signals = forces.chain(moved).collect();
        let deflection = |mesh: usize| modes.iter().zip(&equilibrium).map(|(mode, q)| mode.deflections[mesh] * q).sum();
        let teeth = (0..model.meshes.len()).map(|mesh| teeth(model, mesh, deflection(mesh))).collect();
        let ratios = model.shafts.iter().map(|shaft| shaft.ratio).collect();
        Ok(Self { modes, signals, teeth, ratios })
    }

    /// Expected error of the worst signal at a speed of the reference shaft, rad/s: RMS of the difference over RMS of the
    /// variation, or over a share of the mean if this is larger.
    pub fn error(&self, speed: f64) -> f64 {
        let (mut differences, mut squares) = (vec![0.0; self.signals.len()], self.rotating_squares(speed));
        for (mesh, teeth) in self.teeth.iter().enumerate() {
            let tooth_frequency = teeth.order * speed.abs();
            let highest = self.modes.iter().map(|mode| mode.given).fold(0.0, f64::max);
            let count = ((highest / tooth_frequency) as usize).clamp(1, MAX_HARMONICS);
            for (i, force) in teeth.harmonics.iter().take(count).enumerate() {
                let frequency = (i + 1) as f64 * tooth_frequency;
                let amplitudes: Vec<[Complex64; 2]> =
                    self.modes.iter().map(|mode| self.amplitudes(mode, mesh, *force, frequency)).collect();
                for (index, signal) in self.signals.iter().enumerate() {
                    let direct = if signal.mesh == Some(mesh) { *force } else { Complex64::ZERO };
                    for row in &signal.rows {
                        let mut sum = [Complex64::ZERO, direct];
                        for (factor, amplitude) in row.iter().zip(&amplitudes) {
                            sum[0] += amplitude[0] * *factor;
                            sum[1] += amplitude[1] * *factor;
                        }
                        differences[index] += sum[0].norm_sqr() / 2.0;
                        squares[index] += sum[1].norm_sqr() / 2.0;
                    }
                }
            }
        }
        let errors = self.signals.iter().zip(differences).zip(squares).map(|((signal, difference), square)| {
            let unit = f64::max(square, SHARE_OF_MEAN * SHARE_OF_MEAN * signal.mean_square);
            signal.weight * (difference / unit.max(f64::MIN_POSITIVE)).sqrt()
        });
        STEP_RESPONSE_SAFETY * errors.fold(0.0, f64::max)
    }

    /// Amplitude of a mode under a harmonic of a mesh: its difference due to the elements, and the exact one.
    fn amplitudes(&self, mode: &ShiftedMode, mesh: usize, force: Complex64, frequency: f64) -> [Complex64; 2] {
        let force = -force * mode.deflections[mesh];
        let exact = force * mode.amplitude(mode.exact, frequency);
        [force * mode.amplitude(mode.given, frequency) - exact, exact]
    }

    /// Mean square of each signal in the response to bow and unbalance.
    fn rotating_squares(&self, speed: f64) -> Vec<f64> {
        let mut squares = vec![0.0; self.signals.len()];
        for (shaft, ratio) in self.ratios.iter().enumerate() {
            let spin = ratio * speed;
            let amplitude = |mode: &ShiftedMode| {
                let [bow, unbalance] = mode.rotating[shaft];
                (bow + unbalance * (spin * spin)) * mode.amplitude(mode.given, spin)
            };
            let amplitudes: Vec<Complex64> = self.modes.iter().map(amplitude).collect();
            for (square, signal) in squares.iter_mut().zip(&self.signals) {
                for row in &signal.rows {
                    let sum: Complex64 =
                        row.iter().zip(&amplitudes).map(|(factor, amplitude)| amplitude * *factor).sum();
                    *square += sum.norm_sqr() / 2.0;
                }
            }
        }
        squares
    }
}

/// Work of the rotating forces of bow and of unbalance at the spin 1 rad/s of each shaft on a mode.
fn rotating_forces(model: &Model, shape: &[f64]) -> Vec<[Complex64; 2]> {
    let shaft = |shaft: &ShaftModel| {
        let mut sums = [Complex64::ZERO; 2];
        for excitation in &shaft.excitations {
            // The force is Re(a e^{iϑ}) along y and Im(a e^{iϑ}) along z.
            let motion = Complex64::new(shape[excitation.index], -shape[excitation.index + 1]);
            sums[0] += excitation.steady_amplitude() * motion;
            sums[1] += excitation.unbalance * motion;
        }
        sums
    };
    model.shafts.iter().map(shaft).collect()
}

/// The force that the teeth of a mesh excite at a static deflection, m.
fn teeth(model: &Model, index: usize, deflection: f64) -> Teeth {
    let cycle = model.meshes[index].tooth_cycle(model.sigma(index, 0.0), TOOTH_CYCLE_SAMPLES);
    let force: Vec<f64> = cycle.iter().map(|teeth| teeth.stiffness * (deflection - teeth.error)).collect();
    let phasors: Vec<Complex64> =
        (0..TOOTH_CYCLE_SAMPLES).map(|i| Complex64::cis(-TAU * i as f64 / TOOTH_CYCLE_SAMPLES as f64)).collect();
    let harmonic = |order: usize| -> Complex64 {
        let terms = force.iter().enumerate().map(|(i, force)| phasors[i * order % TOOTH_CYCLE_SAMPLES] * *force);
        terms.sum::<Complex64>() * (2.0 / TOOTH_CYCLE_SAMPLES as f64)
    };
    Teeth {
        order: model.scene.mesh_order(&model.scene.meshes[index]),
        harmonics: (1..=MAX_HARMONICS).map(harmonic).collect(),
    }
}
