//! The gyroscopic matrix G as a sum of a few couplings between two scalars of the velocities.
//!
//! In mass-normalised modes G becomes the skew matrix Γ = ΦᵀGΦ. A skew matrix has pairs of equal singular values σ with
//! orthonormal vectors u and v, and
//!
//! ```text
//! Γ = Σ σ (v uᵀ − u vᵀ),     Γu = σv,  Γv = −σu.
//! ```
//!
//! A motion of low frequency hardly moves modes of high frequency, and loads on them cause small displacements. With the
//! weights w_k = min(1, ω_c/ω_k), the singular values of WΓW decrease fast, and the couplings of the largest ones
//! represent Γ where it matters. Every coupling is skew, so that the sum of any number of them does no work.

use nalgebra::{DMatrix, DVector};

use super::real::RealModes;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::model::Model;

/// An eigenvector that lies in the chosen pairs up to this remainder belongs to them.
const CHOSEN: f64 = 0.1;

/// One coupling: the forces −(e_v (e_u·q̇) − e_u (e_v·q̇)) per unit speed of the reference shaft.
#[derive(Clone, Debug)]
pub struct GyroscopicPair {
    /// Vectors e_u and e_v over the displacements, n entries each.
    pub vectors: [DVector<f64>; 2],
}

/// The couplings of G with a weighted singular value above `smallest`, kg m² in mass-normalised modes; `corner` is the
/// angular frequency ω_c up to which all modes have the weight one, rad/s.
///
/// # Errors
/// [`DecompositionError`] if the eigensolver fails.
pub fn gyroscopic_pairs(
    model: &Model,
    real: &RealModes,
    corner: f64,
    smallest: f64,
) -> Result<Vec<GyroscopicPair>, DecompositionError> {
    let n = real.frequencies.len();
    let weights = real.frequencies.map(|frequency| if frequency > corner { corner / frequency } else { 1.0 });
    let mut skew = real.project(&model.gyroscopic_matrix());
    for ((row, column), entry) in (0..n * n).map(|at| (at % n, at / n)).zip(skew.iter_mut()) {
        *entry *= weights[row] * weights[column];
    }
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
    let pair = |vectors: &[DVector<f64>]| {
        let strength = vectors[1].dot(&(&skew * &vectors[0])).max(0.0).sqrt();
        let physical = |vector: &DVector<f64>| &weighted * vector.component_div(&weights) * strength;
        GyroscopicPair { vectors: [physical(&vectors[0]), physical(&vectors[1])] }
    };
    Ok(chosen.chunks_exact(2).map(pair).collect())
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
