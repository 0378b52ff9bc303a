//! Whether any element of a model can feed energy into its motion.

use super::{Model, Support};
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::Matrix2;

impl Model {
    /// Whether no element can feed energy into the motion at a constant speed of the reference shaft, rad/s, so that every
    /// linear motion is stable. The model is that at this speed.
    ///
    /// The energy changes by −u̇ᵀCu̇ and the work of the skew part of K, to which internal and structural damping of shafts contribute; gyroscopic
    /// forces do no work. Shafts, meshes and modal damping have symmetric, positive semidefinite matrices. It remains to check the bearings, the links, and the torques
    /// over the speed (Ziegler, Principles of Structural Stability, 1968).
    pub fn is_dissipative(&self, speed: f64) -> bool {
        let elements = self.supports.iter().chain(self.links.iter().map(|link| &link.local));
        !self.needs_speed()
            && self.circulation.is_none_or(|circulation| circulation == 0.0)
            && !self.shafts.iter().any(|shaft| shaft.structural.is_some() && shaft.ratio * speed != 0.0)
            && elements.into_iter().all(is_passive)
            && self.loads.iter().all(|load| load.linear(speed).damping[(0, 0)] >= 0.0)
    }
}

/// Whether a stiffness is symmetric and positive semidefinite, and the symmetric part of the damping is positive semidefinite.
fn is_passive(element: &Support) -> bool {
    let stiffness = &element.stiffness;
    let skew = (stiffness[0][1] - stiffness[1][0]).abs();
    skew <= EQUALITY_TOLERANCE * norm(stiffness) && is_semidefinite(stiffness) && is_semidefinite(&element.damping)
}

/// Whether (A + Aᵀ)/2 is positive semidefinite, apart from round-off.
fn is_semidefinite(matrix: &Matrix2) -> bool {
    let [[a, b], [c, d]] = *matrix;
    let lowest = a / 2.0 + d / 2.0 - (a / 2.0 - d / 2.0).hypot(b / 2.0 + c / 2.0);
    lowest >= -EQUALITY_TOLERANCE * norm(matrix)
}

/// Frobenius norm.
fn norm(matrix: &Matrix2) -> f64 {
    matrix.as_flattened().iter().fold(0.0_f64, |norm, value| norm.hypot(*value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_symmetric_stiffness_and_nonnegative_damping_are_passive() {
        let passive = |stiffness, damping| is_passive(&Support::new(0, stiffness, damping));
        let (isotropic, none) = ([[2e7, 0.0], [0.0, 2e7]], [[0.0; 2]; 2]);
        assert!(passive(isotropic, none));
        assert!(passive([[2e7, 1e6], [1e6, 3e7]], [[1e3, 0.0], [0.0, 0.0]]));
        // Damping that couples the directions with opposite signs does no work.
        assert!(passive(isotropic, [[1e3, 5e3], [-5e3, 1e3]]));
        assert!(!passive([[2e7, 1.0], [-1.0, 2e7]], none));
        assert!(!passive([[1e7, 2e7], [2e7, 1e7]], none));
        assert!(!passive(isotropic, [[1e3, 2e3], [2e3, 1e3]]));
    }
}
