//! Loads that rotate with a shaft: bow, unbalance and forces that turn with it. Every method takes them from here. In a frame that
//! turns, ϑ is the angle of the shaft relative to this frame, and Ω_s still its speed.
//!
//! At a constant speed, one load of a shaft has the force Re(a e^{iϑ}) along v and Im(a e^{iϑ}) along w at each node,
//! where a = K_s b + F + U Ω_s². At a changing speed a shaft has up to two loads: a = K_s b + F with the phasor e^{iϑ}, and
//! a = U with the phasor (Ω_s² − iΩ̇_s) e^{iϑ}.

use num_complex::Complex64;

use super::{RotationState, ShaftRotation};
use crate::connection::Row;
use crate::model::{Excitation, Model};

/// How the amplitude of a rotating load follows the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scaling {
    /// It is constant.
    Constant,
    /// It is proportional to Ω_s² − iΩ̇_s.
    Unbalance,
}

/// A load that rotates with a shaft.
#[derive(Clone, Debug)]
pub struct RotatingLoad {
    /// Index of the shaft; of a weight, that of the carrier.
    pub shaft: usize,
    /// Signed speed of the shaft relative to the frame of its lateral motion, rad/s; the largest one of the run if it changes.
    pub spin: f64,
    /// Ratio of this speed to that of the reference shaft.
    ratio: f64,
    /// Phasor e^{iϑ} of the shaft in this frame at elapsed time zero.
    at_origin: Complex64,
    scaling: Scaling,
    /// Whether it is the weight in a frame that turns, in which its direction turns backwards.
    pub is_weight: bool,
    /// Amplitudes a, N or N m (kg m of an unbalance at a changing speed), each with the index of its coordinate along v;
    /// that along w has the next index.
    amplitudes: Vec<(usize, Complex64)>,
}

impl RotatingLoad {
    /// The rotating loads at a constant speed: one for each shaft that has some, and the weight in each frame that turns.
    /// `spins` [rad/s] and `at_origin` (phasors at elapsed time zero) have the order of [`Model::turning_ratio`].
    pub(super) fn at_constant_speed(
        model: &Model,
        rotation: &ShaftRotation,
        spins: &[f64],
        at_origin: &[Complex64],
    ) -> Vec<Self> {
        let amplitude = |excitation: &Excitation, spin: f64| excitation.amplitude(spin, 0.0);
        let shafts = 0..model.shafts.len();
        let loads = shafts.map(|shaft| Self::new(model, shaft, Scaling::Constant, spins, at_origin, amplitude));
        loads.filter(|load| !load.amplitudes.is_empty()).chain(Self::weights(model, rotation)).collect()
    }

    /// The weight in each frame that turns, at a constant speed; none without gravity across the shafts.
    pub fn weights(model: &Model, rotation: &ShaftRotation) -> Vec<Self> {
        let weight = |carrier: usize| {
            let ratio = model.shafts[carrier].ratio;
            Self {
                shaft: carrier,
                spin: -ratio * rotation.fastest,
                ratio: -ratio,
                at_origin: rotation.phasor_at_origin(ratio).conj(),
                scaling: Scaling::Constant,
                is_weight: true,
                amplitudes: model.weight_in_frame(carrier),
            }
        };
        let weights = model.scene.carriers().into_iter().map(weight);
        weights.filter(|load| !load.amplitudes.is_empty()).collect()
    }

    /// The rotating loads of all shafts at a changing speed: for each shaft that of bow and turning forces, and that of
    /// unbalance.
    pub(super) fn at_changing_speed(model: &Model, spins: &[f64], at_origin: &[Complex64]) -> Vec<Self> {
        let steady = |excitation: &Excitation, _: f64| excitation.steady_amplitude();
        let unbalance = |excitation: &Excitation, _: f64| excitation.unbalance;
        let loads = (0..model.shafts.len()).flat_map(|shaft| {
            [
                Self::new(model, shaft, Scaling::Constant, spins, at_origin, steady),
                Self::new(model, shaft, Scaling::Unbalance, spins, at_origin, unbalance),
            ]
        });
        let acts = |load: &Self| load.amplitudes.iter().any(|(_, amplitude)| *amplitude != Complex64::ZERO);
        loads.filter(acts).collect()
    }

    fn new(
        model: &Model,
        shaft: usize,
        scaling: Scaling,
        spins: &[f64],
        at_origin: &[Complex64],
        amplitude: impl Fn(&Excitation, f64) -> Complex64,
    ) -> Self {
        let excitations = model.shafts[shaft].excitations.iter();
        let amplitudes =
            excitations.map(|excitation| (excitation.index, amplitude(excitation, spins[shaft]))).collect();
        let turning = model.in_frame(shaft);
        let (spin, ratio, at_origin) = (spins[turning], model.turning_ratio(turning), at_origin[turning]);
        Self { shaft, spin, ratio, at_origin, scaling, is_weight: false, amplitudes }
    }

    /// The columns of the load over the coordinates, as entries (index, force): the factors of real and imaginary part of
    /// [`Self::phasor`].
    pub fn columns(&self) -> [Row; 2] {
        let (mut real, mut imaginary) = (Row::new(), Row::new());
        for (index, amplitude) in &self.amplitudes {
            real.extend([(*index, amplitude.re), (*index + 1, amplitude.im)]);
            imaginary.extend([(*index, -amplitude.im), (*index + 1, amplitude.re)]);
        }
        [real, imaginary]
    }

    /// The phasor of the load: e^{iϑ} with the angle ϑ of the shaft, rad. At a changing speed, an unbalance has the phasor
    /// (Ω_s² − iΩ̇_s) e^{iϑ} with the speed Ω_s, rad/s, of the shaft. `reference` is the rotation of the reference shaft at this
    /// instant if the speed changes.
    #[inline]
    pub fn phasor(&self, elapsed: f64, reference: Option<&RotationState>) -> Complex64 {
        let angle = reference.map_or(self.spin * elapsed, |shaft| self.ratio * shaft.angle);
        let phasor = self.at_origin * Complex64::from_polar(1.0, angle);
        match (self.scaling, reference) {
            (Scaling::Unbalance, Some(shaft)) => {
                let spin = self.ratio * shaft.speed;
                phasor * Complex64::new(spin * spin, -self.ratio * shaft.acceleration)
            }
            _ => phasor,
        }
    }

    /// Power of the load at a phasor, W, for velocities v.
    pub(super) fn power(&self, phasor: Complex64, v: &[f64]) -> f64 {
        let force = |(index, amplitude): &(usize, Complex64)| {
            let force = amplitude * phasor;
            force.re * v[*index] + force.im * v[*index + 1]
        };
        self.amplitudes.iter().map(force).sum()
    }

    /// Adds the load at a phasor to the generalised forces.
    #[inline]
    pub(super) fn apply(&self, phasor: Complex64, force: &mut [f64]) {
        for (index, amplitude) in &self.amplitudes {
            force[*index] += amplitude.re * phasor.re - amplitude.im * phasor.im;
            force[*index + 1] += amplitude.re * phasor.im + amplitude.im * phasor.re;
        }
    }
}
