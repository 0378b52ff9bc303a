//! A mode at one speed, with its inner product in the energy.

use nalgebra::{Complex, DVector};

use crate::linalg::{Sparse, image_of_parts};
use crate::modal::{Mode, Residual, Whirl};
use crate::model::Model;

/// Matrices of the inner product.
pub(super) struct Energy {
    /// Symmetric part of K.
    stiffness: Sparse,
    mass: Sparse,
}

impl Energy {
    /// The matrices of a model with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    pub fn new(model: &Model, speed: f64) -> Self {
        Self { stiffness: model.sparse_symmetric_stiffness(speed), mass: model.sparse_mass() }
    }
}

/// One mode at one speed: its eigenvalue λ and y = (φ, λφ) of unit norm. All vectors have n entries in the order of the
/// core.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// λ, rad/s.
    pub eigenvalue: Complex<f64>,
    /// Direction of whirl.
    pub whirl: Whirl,
    /// Residual of the mode.
    pub residual: Residual,
    /// φ, divided by the norm of y; zero for a rigid-body mode.
    position: DVector<Complex<f64>>,
    /// λφ, divided by the norm of y; φ for a rigid-body mode.
    velocity: DVector<Complex<f64>>,
    /// K times `position`.
    force: DVector<Complex<f64>>,
    /// M times `velocity`.
    momentum: DVector<Complex<f64>>,
}

impl State {
    /// A mode with its inner product.
    pub fn new(energy: &Energy, mode: Mode) -> Self {
        let Mode { eigenvalue, shape, whirl, residual } = mode;
        let is_rigid = eigenvalue == Complex::ZERO;
        let velocity = if is_rigid { shape.clone() } else { &shape * eigenvalue };
        let position = if is_rigid { DVector::zeros(shape.len()) } else { shape };
        let image = |matrix: &Sparse, x: &DVector<Complex<f64>>| {
            image_of_parts(x, |part| {
                let mut image = DVector::zeros(part.len());
                matrix.multiply_add(1.0, part.as_slice(), image.as_mut_slice());
                image
            })
        };
        let (force, momentum) = (image(&energy.stiffness, &position), image(&energy.mass, &velocity));
        let norm = (position.dotc(&force).re + velocity.dotc(&momentum).re).max(f64::MIN_POSITIVE).sqrt();
        let [position, velocity, force, momentum] =
            [position, velocity, force, momentum].map(|vector| vector.unscale(norm));
        Self { eigenvalue, whirl, residual, position, velocity, force, momentum }
    }

    /// Mode shape φ with φᴴMφ = 1.
    pub fn shape(&self) -> DVector<Complex<f64>> {
        self.velocity.unscale(self.velocity.dotc(&self.momentum).re.sqrt())
    }

    /// Inner product yᴴy' of two modes.
    pub fn product(&self, other: &Self) -> Complex<f64> {
        self.position.dotc(&other.force) + self.velocity.dotc(&other.momentum)
    }

    /// Correlation |yᴴy'|² of two modes.
    pub fn correlation(&self, other: &Self) -> f64 {
        self.product(other).norm_sqr()
    }
}
