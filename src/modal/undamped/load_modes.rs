//! Undamped modes that given loads excite, in time proportional to n: load-dependent Ritz vectors (Wilson, Yuan and
//! Dickens 1982, Earthquake Engineering and Structural Dynamics 10).
//!
//! The subspace is a Krylov space of (K + s²M)⁻¹M that begins with the displacements under the loads. It contains the modes
//! of low frequency that the loads excite. The others follow together: the first vectors contain their static displacement.

use nalgebra::DMatrix;

use super::real::{RealModes, null_motions};
use super::spectral_range::{ShiftInverse, SpectralRange, UndampedInverse};
use crate::linalg::{DecompositionError, Krylov};
use crate::model::Model;

/// Modes in the space of the displacements under `loads`, n entries each, and of the following `steps` vectors of the
/// Krylov space; with the loaded tooth flanks of `speed` (reference shaft, rad/s).
///
/// # Errors
/// [`DecompositionError`] if a linear system has no accurate solution, or the decomposition fails.
pub fn modes_of_loads(
    model: &Model,
    speed: f64,
    range: &SpectralRange,
    loads: &[Vec<f64>],
    steps: usize,
) -> Result<RealModes, DecompositionError> {
    let null = null_motions(model, speed)?;
    let inverse = ShiftInverse::new(model, speed, range.slowest.unwrap_or(range.fastest.max(1.0)))?;
    let operator = UndampedInverse { inverse, mass: &model.sparse_mass() };
    let mut space = Krylov::new(&operator, null.column_iter().map(|column| column.iter().copied().collect()));
    for load in loads {
        space.add_vector(operator.inverse.solve(load)?);
    }
    while space.steps() < steps && !space.is_complete() {
        space.step()?;
    }
    let rigid = null.as_slice().iter();
    let basis: Vec<f64> = rigid.chain(space.basis()).copied().collect();
    RealModes::in_subspace(model, speed, &DMatrix::from_vec(model.len(), basis.len() / model.len().max(1), basis))
}
