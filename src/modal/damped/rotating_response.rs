//! Response to a rotating force with modal damping, in time proportional to n.
//!
//! A force that rotates with Ω has the response x of the dynamic stiffness S = T + 2iζΩ M√A, A = M⁻¹K, where T contains all
//! other forces. The matrix of modal damping is full. With rational damping of the same size instead, S becomes the band
//! matrix
//!
//! ```text
//! P = T + iζ sgn(Ω) (Ω²M + K),    P⁻¹S = I − E,    E = iζ sgn(Ω) P⁻¹ M (√A − |Ω|)².
//! ```
//!
//! In an undamped mode of frequency ω, E = iζ(ω − Ω)²/(ω² − Ω² + iζ(ω² + Ω²)), which is zero at resonance and at most ζ at any
//! other frequency. Positive damping of T makes E at most one in the norm of Ω²M + K, for any speed. Conjugate residuals
//! therefore converge in few iterations, whose number does not depend on n. [`SquareRoot`] applies √A.

use nalgebra::DVector;
use num_complex::Complex64;

use crate::linalg::{CoupledFactors, DecompositionError, Singular, Sparse, conjugate_residuals};
use crate::modal::undamped::{SpectralRange, SquareRoot};
use crate::model::{Model, Weights};

/// Relative residual, in the energy norm.
const CONVERGED: f64 = 1e-11;
/// The square root reaches so much farther than the frequencies, which an iteration finds.
const RANGE: f64 = 1.01;

/// Response to a rotating force.
pub struct Solved {
    /// Phasors, n entries in the order of the core, m and rad.
    pub phasors: DVector<Complex64>,
    /// Number of products with the operator I − E.
    pub products: usize,
    /// ‖P⁻¹(f − S x)‖/‖P⁻¹f‖ in the norm of Ω²M + K, with the symmetric part of K.
    pub residual: f64,
}

/// A model with modal damping and the loaded flanks of one direction of rotation.
pub struct RotatingResponse<'m> {
    model: &'m Model,
    /// √A.
    root: SquareRoot<'m>,
    /// K.
    stiffness: Sparse,
    /// Symmetric part of K.
    symmetric_part: Sparse,
}

impl<'m> RotatingResponse<'m> {
    /// Prepares responses at speeds with the loaded tooth flanks of `speed` (reference shaft, rad/s); `range` has the
    /// undamped frequencies.
    ///
    /// # Errors
    /// [`DecompositionError`] if a linear system has no accurate solution.
    pub fn new(model: &'m Model, speed: f64, range: &SpectralRange) -> Result<Self, DecompositionError> {
        let lowest = range.slowest.unwrap_or(range.fastest);
        Ok(Self {
            root: SquareRoot::new(model, speed, [lowest / RANGE, range.fastest * RANGE])?,
            stiffness: model.sparse_stiffness(speed),
            symmetric_part: model.sparse_symmetric_stiffness(speed),
            model,
        })
    }

    /// The response to `force`, N and N m, at the speed of the reference shaft and the spin of the force, rad/s. `None` if
    /// round-off or the iteration leaves no accurate solution.
    pub fn solve(&self, [speed, spin]: [f64; 2], force: &DVector<Complex64>) -> Option<Solved> {
        let (square, damping) = (spin * spin, Complex64::new(0.0, self.model.scene.modal_damping * spin.signum()));
        let weights = Weights {
            stiffness: 1.0 + damping,
            mass: (damping - 1.0) * square,
            gyroscopic: Complex64::new(0.0, spin * speed),
            ..Weights::harmonic(spin, speed)
        };
        let factors = self.model.dynamic_stiffness(&weights, speed).factor(spin.signum()).ok()?;
        let start = self.solve_bands(&factors, force).ok()?;
        // (I − E) x.
        let apply = |x: &DVector<Complex64>| {
            let momentum = x * Complex64::from(square) - self.root.apply(x) * Complex64::from(2.0 * spin.abs());
            let force = self.mass_times(&momentum) + product(&self.stiffness, x);
            Ok::<_, Singular>(x - self.solve_bands(&factors, &(force * damping))?)
        };
        let weigh =
            |x: &DVector<Complex64>| self.mass_times(&(x * Complex64::from(square))) + product(&self.symmetric_part, x);
        let (phasors, products) = conjugate_residuals(&start, CONVERGED, apply, weigh).ok().flatten()?;
        let norm = |x: &DVector<Complex64>| x.dotc(&weigh(x)).re.abs().sqrt();
        let size = norm(&start);
        let residual = if size == 0.0 { 0.0 } else { norm(&(&start - apply(&phasors).ok()?)) / size };
        Some(Solved { phasors, products, residual })
    }

    fn solve_bands(
        &self,
        factors: &CoupledFactors,
        force: &DVector<Complex64>,
    ) -> Result<DVector<Complex64>, Singular> {
        let mut x = self.model.to_circular(force.as_slice());
        factors.solve(&mut x)?;
        Ok(DVector::from_vec(self.model.from_circular(&x)))
    }

    fn mass_times(&self, x: &DVector<Complex64>) -> DVector<Complex64> {
        self.model.product(x, |x, out| self.model.multiply_mass(x, out))
    }
}

fn product(matrix: &Sparse, x: &DVector<Complex64>) -> DVector<Complex64> {
    let part = |of: fn(&Complex64) -> f64| {
        let mut image = DVector::zeros(x.len());
        matrix.multiply_add(1.0, x.map(|value| of(&value)).as_slice(), image.as_mut_slice());
        image
    };
    part(|value| value.re).zip_map(&part(|value| value.im), Complex64::new)
}
