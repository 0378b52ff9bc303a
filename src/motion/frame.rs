//! Motion in frames that turn with a carrier: its forces, and how it is seen from the ground.
//!
//! Seen from the ground, a displacement p in the frame has the velocity (ṗ + iΩ_c p) e^{iϑ_c} and the acceleration
//! (p̈ + 2iΩ_c ṗ − Ω_c² p) e^{iϑ_c}. Energies are those of the motion relative to the frame: the forces of a frame are external
//! ones, whose power the drive of the carrier supplies.

use nalgebra::DVector;
use num_complex::Complex64;

use crate::linalg::Sparse;
use crate::model::{Add, Model};

/// Forces that a motion has in frames that turn: stiffness · q and rate · q̇ are subtracted from the other forces.
#[derive(Clone, Debug)]
pub struct FrameForces {
    /// −Ω_c² M + Ω_c Ω_s G + iΩ_c C, N/m.
    pub stiffness: Sparse,
    /// 2iΩ_c M, N s/m.
    pub rate: Sparse,
    /// Centrifugal forces on planets, n entries, N and N m.
    pub centrifugal: DVector<f64>,
}

impl FrameForces {
    /// The forces of a model at a speed of the reference shaft, rad/s; none without frames that turn.
    pub fn new(model: &Model, speed: f64) -> Option<Self> {
        let sparse = |visit: &dyn Fn(Add<'_>)| {
            let mut entries = Vec::new();
            visit(&mut |row, column, value| entries.push((row, column, value)));
            Sparse::new(model.len(), entries)
        };
        model.scene.has_turning_frame().then(|| {
            let mut centrifugal = DVector::zeros(model.len());
            model.add_centrifugal_forces(speed, &mut centrifugal);
            Self {
                stiffness: sparse(&|add| model.visit_frames(speed, add)),
                rate: sparse(&|add| model.visit_coriolis(&mut |row, column, value| add(row, column, speed * value))),
                centrifugal,
            }
        })
    }

    /// Power of the centrifugal forces and of the other forces that depend on the displacements, W. Coriolis forces have none.
    pub fn power(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut power: f64 = self.centrifugal.iter().zip(v).map(|(force, rate)| force * rate).sum();
        self.stiffness.for_each(|row, column, value| power -= v[row] * value * q[column]);
        power
    }
}

/// The frame of a lateral motion at an instant.
#[derive(Clone, Copy, Debug)]
pub struct TurningFrame {
    /// Phasor e^{iϑ} of its angle.
    pub phasor: Complex64,
    /// Its speed, rad/s.
    pub speed: f64,
}

impl TurningFrame {
    /// The vector over (y, z), such as a displacement or a force, seen from the ground.
    pub fn turned(&self, [v, w]: [f64; 2]) -> [f64; 2] {
        let turned = self.phasor * Complex64::new(v, w);
        [turned.re, turned.im]
    }

    /// The velocity seen from the ground of a displacement with this rate in the frame.
    pub fn velocity(&self, [v, w]: [f64; 2], rate: [f64; 2]) -> [f64; 2] {
        self.turned([rate[0] - self.speed * w, rate[1] + self.speed * v])
    }

    /// The acceleration seen from the ground of a displacement with this rate and acceleration in the frame.
    pub fn acceleration(&self, [v, w]: [f64; 2], rate: [f64; 2], acceleration: [f64; 2]) -> [f64; 2] {
        let (speed, square) = (2.0 * self.speed, self.speed * self.speed);
        self.turned([acceleration[0] - speed * rate[1] - square * v, acceleration[1] + speed * rate[0] - square * w])
    }
}
