//! Residual of a mode: the force S(λ)φ that its eigenvalue λ and its shape φ leave in the equations of motion.
//!
//! ```text
//! residual = ‖S(λ) φ‖₋/‖φ‖₊,   ‖f‖₋² = fᴴ(K + s²M)⁻¹f,   ‖φ‖₊² = φᴴ(K + s²M)φ,   s ≈ |λ|,
//! ```
//!
//! with the symmetric part of K. Both norms are energies, so that displacements and rotations, bending and twist count by
//! the same unit, and stiff coordinates do not hide soft ones. K + s²M is positive definite: only S(λ)φ = 0 has the residual
//! zero. A relative error δ of the eigenvalue or of the shape causes a residual of about δ (backward error in an energy norm;
//! Tisseur, Linear Algebra Appl. 309, 2000). Round-off ε of the shape causes εω_max/|λ|, where ‖S(λ)φ‖ without
//! weights has ε(ω_max/|λ|)².

use nalgebra::DVector;
use num_complex::Complex64;

use crate::linalg::{DecompositionError, Side};
use crate::modal::cache::{CachedModel, EquationForces, dynamic_force};
use crate::modal::undamped::{ShiftInverse, SpectralRange};
use crate::model::Model;

/// Largest residual of a mode without round-off. Iterations end with at most 1e-5, also between overdamped modes of oil films;
/// a wrong shape has 0.01 to 1.
const MAX_RESIDUAL: f64 = 1e-4;
/// Smallest shift s, relative to ω_max, where K + s²M has no factors with s ≈ |λ|: s²M is then above the round-off of K.
const LEAST_SHIFT: f64 = 1e-6;
/// Largest residual from round-off, in units of εω_max/|λ|.
const ROUND_OFF: f64 = 100.0;
/// Largest residual of a mode of a list with any round-off: no digit is certain beyond it. An intersection close to standstill
/// has the frequency zero up to round-off.
pub(super) const LARGEST_RESIDUAL: f64 = 0.1;
/// Largest ratio of the shift s and |λ|, and of |λ| and s: modes within it share the factors of K + s²M.
const SHARED: f64 = 8.0;

/// Residual of a mode and its limit, both relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Residual.
    pub value: f64,
    /// Largest residual of an accurate mode.
    pub limit: f64,
}

impl Residual {
    /// Whether the mode satisfies the equations of motion; false for a residual that is not a number.
    pub fn is_accurate(&self) -> bool {
        self.value <= self.limit
    }

    /// The larger one of this residual and another condition of the same limit, such as Re λ = 0.
    pub fn with(self, condition: f64) -> Self {
        // `f64::max` would ignore NaN.
        Self { value: if condition <= self.value { self.value } else { condition }, ..self }
    }
}

/// Residuals of modes of one model at one speed.
pub struct Residuals<'m> {
    model: &'m Model,
    /// Speed of the reference shaft, rad/s. Another one needs the same model, with the same flanks in contact.
    pub speed: f64,
    forces: EquationForces<'m>,
    /// s of a rigid-body mode, rad/s: the lowest frequency above zero.
    slowest: f64,
    /// Highest undamped frequency ω_max, rad/s.
    fastest: f64,
    /// Factors of K + s²M of the previous mode.
    inverse: Option<ShiftInverse<'m>>,
}

impl<'m> Residuals<'m> {
    /// Residuals with the loaded tooth flanks of `speed` (reference shaft, rad/s). The range of the undamped frequencies may be
    /// that of a similar model.
    pub fn new(model: &'m Model, range: &SpectralRange, speed: f64, forces: EquationForces<'m>) -> Self {
        let fastest = if range.fastest > 0.0 { range.fastest } else { 1.0 };
        let slowest = range.slowest.filter(|slowest| *slowest > 0.0).unwrap_or(fastest);
        Self { model, speed, forces, slowest, fastest, inverse: None }
    }

    /// Residual of the mode with λ = `eigenvalue`, rad/s, and the shape φ = `shape`, n entries in the order of
    /// the core.
    ///
    /// # Errors
    /// [`DecompositionError`] if K + s²M has no factors.
    pub fn of(&mut self, eigenvalue: Complex64, shape: &DVector<Complex64>) -> Result<Residual, DecompositionError> {
        let mut force = dynamic_force(self.model, [self.speed; 2], eigenvalue, shape, self.forces);
        if matches!(self.forces, EquationForces::All(_)) {
            self.model.add_structural_force(eigenvalue, self.speed, shape, &mut force);
        }
        let size = if eigenvalue == Complex64::ZERO { self.slowest } else { eigenvalue.norm() };
        let inverse = match self.inverse.take() {
            Some(known) if known.shift <= SHARED * size && size <= SHARED * known.shift => known,
            _ => ShiftInverse::new(self.model, self.speed, size)
                .or_else(|_| ShiftInverse::new(self.model, self.speed, size.max(LEAST_SHIFT * self.fastest)))?,
        };
        let (solved, _) = self.model.solve(&inverse.factors, Side::Right, None, force.as_slice())?;
        let shift = inverse.shift;
        self.inverse = Some(inverse);
        let part = |of: fn(&Complex64) -> f64| {
            let values = shape.map(|value| of(&value));
            self.model.elastic_form(values.as_slice(), |mesh| self.model.sigma(mesh, self.speed))
        };
        let energy =
            part(|value| value.re) + part(|value| value.im) + shift * shift * self.model.complex_kinetic_form(shape);
        let round_off = ROUND_OFF * f64::EPSILON * self.fastest / size;
        Ok(Residual { value: (force.dotc(&solved).norm() / energy).sqrt(), limit: MAX_RESIDUAL.max(round_off) })
    }
}

/// Residual of one mode with λ = `eigenvalue`, rad/s, and the shape φ = `shape`, n entries in the order of the core.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub fn residual(
    cached: &CachedModel,
    speed: f64,
    eigenvalue: Complex64,
    shape: &DVector<Complex64>,
    forces: EquationForces<'_>,
) -> Result<Residual, DecompositionError> {
    Residuals::new(&cached.model, cached.spectral_range(speed)?, speed, forces).of(eigenvalue, shape)
}
