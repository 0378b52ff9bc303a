//! Loads of a run at a changing speed, beside those of the connections.
//!
//! The linear motion is that at one reference speed Ω_ref. What the speed changes acts as loads on it:
//!
//! - the gyroscopic difference −(Ω − Ω_ref) G q̇, as a few couplings between two scalars of the velocities
//!   ([`crate::modal::gyroscopic_pairs`]);
//! - bow and unbalance, with the exact angle of the shaft: Re e^{iϑ} and Im e^{iϑ} for a bow, and the same of
//!   (Ω_s² − iΩ̇_s) e^{iϑ} for an unbalance. There is no synchronous motion.
//!
//! The gyroscopic loads depend on the motion: they take part in the solution of the stage equations and in the error
//! estimate. Their scalars follow those of the connections in the interface state. Speed-dependent bearings are
//! connections.

use num_complex::Complex64;

use super::interface_maps::InterfaceMaps;
use crate::modal::{GyroscopicPair, ModalStateSpace};
use crate::model::{Excitation, Model, ShaftModel};
use crate::motion::{EquationOfMotion, RotationState};

/// What the loads of a changing speed are made of.
#[derive(Clone, Debug)]
pub struct SpeedChange {
    /// Speed of the reference shaft in the linear motion, rad/s.
    pub reference_speed: f64,
    /// The gyroscopic couplings.
    pub pairs: Vec<GyroscopicPair>,
    /// Rotation of the reference shaft within the longest step, rad; infinite for fixed steps.
    pub longest_rotation: f64,
}

/// The loads of a changing speed.
#[derive(Clone, Debug)]
pub(super) struct ChangingSpeedLoads {
    /// Speed of the reference shaft in the linear motion, rad/s.
    reference_speed: f64,
    /// Rotation of the reference shaft within the longest step, rad.
    longest_rotation: f64,
    /// Number of gyroscopic couplings.
    pairs: usize,
    sources: Vec<Source>,
}

/// A shaft with bow or unbalance.
#[derive(Clone, Debug)]
struct Source {
    /// Ratio of its speed to that of the reference shaft.
    ratio: f64,
    /// e^{iϑ} at the origin of the elapsed time.
    at_origin: Complex64,
    has_bow: bool,
    has_unbalance: bool,
}

impl Source {
    fn new(shaft: &ShaftModel, at_origin: Complex64) -> Self {
        Self {
            ratio: shaft.ratio,
            at_origin,
            has_bow: shaft.excitations.iter().any(|excitation| excitation.steady_amplitude() != Complex64::ZERO),
            has_unbalance: shaft.excitations.iter().any(|excitation| excitation.unbalance != Complex64::ZERO),
        }
    }

    /// Number of loads.
    fn loads(&self) -> usize {
        2 * (usize::from(self.has_bow) + usize::from(self.has_unbalance))
    }
}

impl ChangingSpeedLoads {
    /// Creates the loads and adds their rows and columns to the maps. Columns follow those of the connections: first the
    /// loads that depend on the motion, which the maps count with the mesh loads, then bow and unbalance.
    pub fn new(
        motion: &EquationOfMotion<'_>,
        linear: &ModalStateSpace,
        change: &SpeedChange,
        maps: &mut InterfaceMaps,
    ) -> Self {
        let model = motion.model();
        let mut columns = Vec::new();
        for vector in change.pairs.iter().flat_map(|pair| &pair.vectors) {
            let entries: Vec<(usize, f64)> = vector.iter().copied().enumerate().collect();
            maps.rows.push(linear.row(&entries, true));
            columns.push(linear.column(&entries));
        }
        let at = maps.meshes;
        maps.meshes += columns.len();
        let sources = sources(model, motion, linear, &mut columns);
        maps.columns.splice(at..at, columns);
        Self {
            reference_speed: change.reference_speed,
            longest_rotation: change.longest_rotation,
            pairs: change.pairs.len(),
            sources,
        }
    }

    /// Number of interface scalars.
    pub fn scalars(&self) -> usize {
        2 * self.pairs
    }

    /// Number of loads that depend on the motion.
    pub fn coupled(&self) -> usize {
        2 * self.pairs
    }

    /// Number of all loads.
    pub fn load_count(&self) -> usize {
        self.coupled() + self.sources.iter().map(Source::loads).sum::<usize>()
    }

    /// Longest step at a speed of the reference shaft, s.
    pub fn longest_step(&self, speed: f64) -> f64 {
        self.longest_rotation / speed.abs()
    }

    /// Writes the loads at the interface scalars `u`, with the reference shaft at an instant.
    pub fn load(&self, shaft: &RotationState, u: &[f64], loads: &mut [f64]) {
        let (pair_loads, mut rest) = loads.split_at_mut(2 * self.pairs);
        let difference = shaft.speed - self.reference_speed;
        for (scalars, load) in u.chunks_exact(2).zip(pair_loads.chunks_exact_mut(2)) {
            load[0] = difference * scalars[1];
            load[1] = -difference * scalars[0];
        }
        for source in &self.sources {
            let phasor = source.at_origin * Complex64::from_polar(1.0, source.ratio * shaft.angle);
            if source.has_bow {
                let (own, others) = rest.split_at_mut(2);
                own.copy_from_slice(&[phasor.re, phasor.im]);
                rest = others;
            }
            if source.has_unbalance {
                let (own, others) = rest.split_at_mut(2);
                let spin = source.ratio * shaft.speed;
                let force = phasor * Complex64::new(spin * spin, -source.ratio * shaft.acceleration);
                own.copy_from_slice(&[force.re, force.im]);
                rest = others;
            }
        }
    }
}

/// The shafts with bow or unbalance. Appends the columns of their loads: those at ϑ = 0 and at ϑ = π/2 of bow and unbalance.
fn sources(
    model: &Model,
    motion: &EquationOfMotion<'_>,
    linear: &ModalStateSpace,
    columns: &mut Vec<Vec<f64>>,
) -> Vec<Source> {
    let mut sources = Vec::new();
    for (index, shaft) in model.shafts.iter().enumerate() {
        let source = Source::new(shaft, motion.phasor(index, 0.0));
        let mut push = |amplitude: fn(&Excitation) -> Complex64| {
            let (mut cosine, mut sine) = (Vec::new(), Vec::new());
            for excitation in &shaft.excitations {
                let (at, amplitude) = (excitation.index, amplitude(excitation));
                cosine.extend([(at, amplitude.re), (at + 1, amplitude.im)]);
                sine.extend([(at, -amplitude.im), (at + 1, amplitude.re)]);
            }
            columns.extend([linear.column(&cosine), linear.column(&sine)]);
        };
        if source.has_bow {
            push(Excitation::steady_amplitude);
        }
        if source.has_unbalance {
            push(|excitation| excitation.unbalance);
        }
        if source.loads() > 0 {
            sources.push(source);
        }
    }
    sources
}
