//! Undamped critical speeds of a small model.
//!
//! In undamped modal coordinates η, an undamped mode at the speed Ω satisfies [λ² + λΩĜ + diag(ω²)] η = 0 with Ĝ = ΦᵀGΦ. They
//! make the stiffness diagonal, so the stiff modes cause no round-off errors in the soft ones. Ω is the speed of the reference
//! shaft, rad/s.

use nalgebra::{Complex, DMatrix, DVector};

use crate::linalg::{DecompositionError, hermitian_eigen, image_of_parts, solve_complex};
use crate::modal::cache::CachedModel;
use crate::modal::lowest::ModeAtSpeed;

/// The undamped modes of one model in modal coordinates, for one sign of Ω.
#[derive(Clone, Debug)]
pub struct CriticalProblem {
    /// Undamped frequencies ω, rad/s, n entries.
    frequencies: DVector<f64>,
    /// Number of rigid-body modes.
    null: usize,
    /// Φ, n × n.
    shapes: DMatrix<f64>,
    /// Ĝ, n × n.
    gyroscopic: DMatrix<f64>,
}

impl CriticalProblem {
    /// The problem for speeds with the sign of `speed`.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be computed.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let real = cached.real_modes(speed)?;
        Ok(Self {
            frequencies: real.frequencies.clone(),
            null: real.null,
            shapes: real.vectors.clone(),
            gyroscopic: real.project(&cached.model.gyroscopic_matrix()),
        })
    }

    /// Undamped modes with the frequency ω = `order`·Ω > 0, in ascending order of |Ω|. Damping is neglected.
    ///
    /// With Ω = ω/order the problem diag(ω_j²) η = ω² (I − iĜ/order) η is Hermitian. It is solved for 1/ω²; each
    /// positive value is a critical speed. A disk with a large polar inertia can have no forward critical speed.
    ///
    /// # Errors
    /// [`DecompositionError`] if the eigenvalue iteration fails.
    pub fn critical(&self, order: f64) -> Result<Vec<ModeAtSpeed>, DecompositionError> {
        let n = self.frequencies.len();
        let inertia = DMatrix::from_fn(n, n, |i, j| {
            Complex::new(if i == j { 1.0 } else { 0.0 }, -self.gyroscopic[(i, j)] / order)
        });
        // The rows of rigid-body modes have no stiffness, so these coordinates follow from the elastic ones.
        let (null, rest) = (self.null, n - self.null);
        let rigid_body = -solve_complex(
            &inertia.view((0, 0), (null, null)).into_owned(),
            &inertia.view((0, null), (null, rest)).into_owned(),
        );
        let elastic = inertia.view((null, null), (rest, rest)) + inertia.view((null, 0), (rest, null)) * &rigid_body;
        let frequency = |i: usize| self.frequencies[null + i];
        let scaled = DMatrix::from_fn(rest, rest, |i, j| elastic[(i, j)] / Complex::from(frequency(i) * frequency(j)));
        let (values, vectors) = hermitian_eigen(&scaled)?;
        let mode = |(value, vector): (f64, DVector<Complex<f64>>)| {
            let elastic = DVector::from_fn(rest, |i, _| vector[i] / frequency(i));
            let mut coordinates = DVector::zeros(n);
            coordinates.rows_mut(0, null).copy_from(&(&rigid_body * &elastic));
            coordinates.rows_mut(null, rest).copy_from(&elastic);
            let frequency = 1.0 / value.sqrt();
            let norm = coordinates.norm();
            ModeAtSpeed {
                speed: frequency / order,
                eigenvalue: Complex::new(0.0, frequency),
                shape: image_of_parts(&coordinates.unscale(norm), |part| &self.shapes * part),
            }
        };
        // Descending 1/ω² is ascending ω. Values that are positive only by round-off are no critical speeds.
        let round_off = f64::EPSILON * values.last().copied().unwrap_or(0.0).abs();
        let columns = (0..rest).rev().map(|i| (values[i], vectors.column(i).into_owned()));
        Ok(columns.filter(|(value, _)| *value > round_off).map(mode).collect())
    }
}
