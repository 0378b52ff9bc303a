//! The forces in proportion to the speed, as sums of a few couplings between two scalars of the motion.
//!
//! Gyroscopic moments −ΩGq̇ act on velocities, the circulatory forces −ΩNq of internal damping on displacements. In
//! mass-normalised modes, G and N become skew matrices Γ = ΦᵀGΦ and ΦᵀNΦ. A skew matrix has pairs of equal singular values
//! σ with orthonormal vectors u and v, and
//!
//! ```text
//! Γ = Σ σ (v uᵀ − u vᵀ),     Γu = σv,  Γv = −σu.
//! ```
//!
//! A motion of low frequency hardly moves modes of high frequency, and loads on them cause small displacements. With a
//! diagonal W of the weights w_k = min(1, ω_c/ω_k)ᵖ, the singular values of WΓW decrease fast, and the couplings of the
//! largest ones represent Γ where it matters. p is 1 for velocities. It is 2 for displacements: N couples modes in
//! proportion to their frequencies, and the response of a mode to a slow load is that load over ω_k².
//!
//! Every gyroscopic coupling is skew, so that the sum of any number of them does no work. Circulatory couplings do work, also
//! on modes that hardly move: an energy balance needs all of them. With p = 1 they have similar singular values, because the
//! damping βK_s acts on the energy norm of every mode alike.

use nalgebra::{DMatrix, DVector};

use super::real::RealModes;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::model::Model;
use crate::numerics::ROOT_OF_ROUND_OFF;

/// An eigenvector that lies in the chosen pairs up to this remainder belongs to them.
const CHOSEN: f64 = 0.1;

/// What a coupling acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoupledMotion {
    /// The velocities q̇, as gyroscopic moments do.
    Velocities,
    /// The displacements q, as the circulatory forces of internal damping do.
    Displacements,
}

/// One coupling: the forces −(e_v (e_u·x) − e_u (e_v·x)) per unit speed of the reference shaft, with the velocities or
/// displacements x.
#[derive(Clone, Debug)]
pub struct SpeedCoupling {
    /// Vectors e_u and e_v over the displacements, n entries each.
    pub vectors: [DVector<f64>; 2],
    /// What x is.
    pub motion: CoupledMotion,
}

/// Which couplings are chosen.
#[derive(Clone, Copy, Debug)]
pub struct CouplingChoice {
    /// Angular frequency ω_c up to which all modes have the weight one, rad/s.
    pub corner: f64,
    /// Smallest acceleration of a coupling at the frequency ω_c, relative to that of the motion and per unit of the speed, s.
    pub smallest: f64,
    /// Whether all circulatory couplings are chosen.
    pub all_circulatory: bool,
}

/// The chosen couplings of G and N.
///
/// # Errors
/// [`DecompositionError`] if the eigensolver fails.
pub fn speed_couplings(
    model: &Model,
    real: &RealModes,
    choice: CouplingChoice,
) -> Result<Vec<SpeedCoupling>, DecompositionError> {
    let CouplingChoice { corner, smallest, all_circulatory } = choice;
    let weights = real.frequencies.map(|frequency| if frequency > corner { corner / frequency } else { 1.0 });
    let gyroscopic = Skew { matrix: real.project(&model.gyroscopic_matrix()), motion: CoupledMotion::Velocities };
    let mut couplings = gyroscopic.couplings(model, real, &weights, smallest * corner)?;
    if model.has_internal_damping() {
        let matrix = real.project_sparse(&model.sparse_circulation());
        let circulatory = Skew { matrix, motion: CoupledMotion::Displacements };
        couplings.extend(if all_circulatory {
            circulatory.couplings(model, real, &weights, 0.0)?
        } else {
            let squares = weights.component_mul(&weights);
            circulatory.couplings(model, real, &squares, smallest * corner * corner)?
        });
    }
    Ok(couplings)
}

/// A skew matrix in mass-normalised modes, and what it acts on.
struct Skew {
    matrix: DMatrix<f64>,
    motion: CoupledMotion,
}

impl Skew {
    /// The couplings with a weighted singular value above `smallest`; all of them if it is zero.
    fn couplings(
        self,
        model: &Model,
        real: &RealModes,
        weights: &DVector<f64>,
        smallest: f64,
    ) -> Result<Vec<SpeedCoupling>, DecompositionError> {
        let (n, motion, mut skew) = (real.frequencies.len(), self.motion, self.matrix);
        for ((row, column), entry) in (0..n * n).map(|at| (at % n, at / n)).zip(skew.iter_mut()) {
            *entry *= weights[row] * weights[column];
        }
        let smallest = if smallest == 0.0 { ROOT_OF_ROUND_OFF * skew.amax() } else { smallest };
        // The eigenvalues of −Γ² = ΓᵀΓ are σ², each of them twice.
        let square = skew.tr_mul(&skew);
        let eigen = symmetric_pencil(&square, &DMatrix::identity(n, n), &DMatrix::zeros(n, 0))?;
        let mut chosen: Vec<DVector<f64>> = Vec::new();
        for column in (0..n).rev().take_while(|column| eigen.values[*column] > smallest * smallest) {
            let first = outside(eigen.vectors.column(column).into_owned(), &chosen);
            if first.norm() < CHOSEN {
                continue;
            }
            chosen.push(first.normalize());
            let second = outside(&skew * &chosen[chosen.len() - 1], &chosen);
            chosen.push(second.normalize());
        }
        let weighted = model.mass_times(&real.vectors);
        let coupling = |vectors: &[DVector<f64>]| {
            let strength = vectors[1].dot(&(&skew * &vectors[0])).max(0.0).sqrt();
            let physical = |vector: &DVector<f64>| &weighted * vector.component_div(weights) * strength;
            SpeedCoupling { vectors: [physical(&vectors[0]), physical(&vectors[1])], motion }
        };
        Ok(chosen.chunks_exact(2).map(coupling).collect())
    }
}

/// The part of a vector that is orthogonal to the `chosen` orthonormal vectors.
fn outside(mut vector: DVector<f64>, chosen: &[DVector<f64>]) -> DVector<f64> {
    // The second pass removes the round-off of the first.
    for _ in 0..2 {
        for direction in chosen {
            let part = vector.dot(direction);
            vector.axpy(-part, direction, 1.0);
        }
    }
    vector
}
