//! A bow that turns with the twist of its shaft.
//!
//! The elastic energy ½(q − q_b(ϑ + θ))ᵀK_s(q − q_b(ϑ + θ)) of a shaft whose bow turns with the twist θ beyond the prescribed
//! angle ϑ contains the product of the twist with the displacements. With the force K_s b e^{iϑ} of the bow, which the rotating
//! loads contain, and the displacement s = (K_s b)ᴴu/F along it, where F = |K_s b|, what remains is
//!
//! ```text
//! force on s:   F (e^{i(ϑ + θ)} − e^{iϑ})
//! moment on θ:  F Im(s e^{−i(ϑ + θ)}) = q_b′ᵀ K_s q
//! ```
//!
//! Both are exact in θ. The moment is that of the forces which the shaft transmits, at the offset of its centre line. It is
//! linear in the force at the equilibrium and of second order in the bow at rest, so that linear analyses do not contain it.

use super::instant::{Instant, InterfaceOptions};
use super::{Row, along_row};
use num_complex::Complex64;

/// Number of scalars.
const SCALARS: usize = 3;

/// The bow of a shaft that has torsion.
#[derive(Clone, Debug)]
pub struct TurningBow {
    /// Index of its shaft.
    pub shaft: usize,
    /// Index of the angle of the shaft in the frame of its lateral motion, in
    /// [`Model::turning_ratio`](crate::model::Model::turning_ratio).
    pub turning: usize,
    /// Size F of the force K_s b, N.
    pub force: f64,
    /// The scalars: real and imaginary part of the displacement s along the force, m, and the twist θ, rad.
    pub rows: [Row; SCALARS],
}

impl TurningBow {
    /// e^{iθ} − 1, without cancellation.
    #[inline]
    fn turned(twist: f64) -> Complex64 {
        let (half, _) = (twist / 2.0).sin_cos();
        Complex64::new(-2.0 * half * half, twist.sin())
    }

    /// Twist of the shaft, rad, for displacements q.
    pub fn twist(&self, q: &[f64]) -> f64 {
        along_row(&self.rows[2], q)
    }

    /// Indices of the coordinates from which the twist follows.
    pub fn twist_coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        self.rows[2].iter().map(|(index, _)| *index)
    }

    /// Load on the scalars at the angle ϑ of the shaft, rad: two forces, N, and a moment, N m.
    #[inline]
    fn load(&self, angle: f64, [real, imaginary, twist]: [f64; SCALARS]) -> [f64; SCALARS] {
        let phasor = Complex64::from_polar(1.0, angle);
        let change = phasor * Self::turned(twist);
        let turned = phasor + change;
        [self.force * change.re, self.force * change.im, self.force * (imaginary * turned.re - real * turned.im)]
    }

    /// Adds the load to the generalised forces at the angle ϑ of the shaft, rad, for displacements q.
    #[inline]
    pub fn apply(&self, angle: f64, q: &[f64], out: &mut [f64]) {
        let scalars = self.rows.each_ref().map(|row| along_row(row, q));
        for (row, load) in self.rows.iter().zip(self.load(angle, scalars)) {
            row.iter().for_each(|(index, coefficient)| out[*index] += coefficient * load);
        }
    }
}

/// A bow that turns with the twist in a run. It has no tangent, which would vary with the angle of the shaft and be factorised in
/// each step: its stiffness is that of the shaft times the bow over its radius of gyration, so that an iteration contracts fast.
#[derive(Clone, Debug)]
pub struct BowInterface {
    pub(super) bow: TurningBow,
    /// Scalars at the reference.
    reference: [f64; SCALARS],
    /// Mean loads at the reference over the angle of the shaft: none.
    pub(super) reference_force: [f64; SCALARS],
}

impl BowInterface {
    pub(super) fn new(bow: &TurningBow, options: InterfaceOptions<'_>) -> Self {
        let reference = bow.rows.each_ref().map(|row| along_row(row, options.reference));
        Self { bow: bow.clone(), reference, reference_force: [0.0; SCALARS] }
    }

    fn scalars(&self, u: &[f64]) -> [f64; SCALARS] {
        std::array::from_fn(|i| self.reference[i] + u[i])
    }

    #[inline]
    pub(super) fn load(&self, instant: &Instant, u: &[f64], load: &mut [f64]) {
        load.copy_from_slice(&self.bow.load(instant.phases[0].angle, self.scalars(u)));
    }
}
