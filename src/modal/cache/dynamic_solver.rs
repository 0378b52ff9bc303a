//! Linear response of a model to harmonic forces at any frequency and speed, in time proportional to n:
//!
//! ```text
//! S(ω, Ω) x = f,    S = λ²M + λ(C + D + ΩG) + K + i sgn(ω) H,    λ = iω
//! ```
//!
//! with the structural damping H ([`StructuralDamping`]).
//!
//! Without modal damping D, S is a sparse matrix, whose factors give the solution. With D, they are
//! those of a sparse matrix P close to S ([`ModalDamping`]): with the same damping for a motion of the frequency |λ|. In an
//! undamped mode of the frequency ω_j, P⁻¹S = I − E with |E| = ζ(ω_j − ω)²/|ω_j² − ω² + iζ(ω_j² + ω²)| at most, which is zero at
//! resonance and ζ at any other frequency. Conjugate residuals therefore converge in few iterations, whose number does not
//! depend on n.

use std::sync::{Arc, OnceLock};

use nalgebra::DVector;
use num_complex::Complex64;

use crate::linalg::{
    CoupledFactors, DecompositionError, LeastResidual, MAX_BACKWARD_ERROR, Side, Singular, Sparse, conjugate_residuals,
};
use crate::modal::undamped::{ModalDamping, Pins, null_motions};
use crate::model::{Model, StructuralDamping, Weights};

/// Which forces the equations of motion contain.
#[derive(Clone, Copy, Debug)]
pub enum EquationForces<'m> {
    /// All, with modal damping if it is given.
    All(Option<&'m ModalDamping>),
    /// Without damping and without circulatory forces.
    Undamped,
}

/// The point at which a dynamic stiffness is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicKey {
    /// Speed Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Frequency ω of the force, rad/s: for bow and unbalance, the spin of their shaft.
    pub spin: f64,
    /// Speed of the reference shaft that determines the flanks in contact, rad/s.
    pub flank_speed: f64,
}

/// Response to a harmonic force.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Phasors, n entries in the order of the core, m and rad.
    pub phasors: DVector<Complex64>,
    /// Number of products with P⁻¹S; zero without modal damping.
    pub products: usize,
    /// The componentwise backward error max |f − S x|/(|S||x| + |f|); with modal damping ‖P⁻¹(f − S x)‖/‖P⁻¹f‖ in the norm of
    /// |λ|²M + K, with the symmetric part of K.
    pub residual: f64,
}

/// Factors for the responses of one model at one point to any number of forces.
#[derive(Debug)]
pub struct DynamicStiffnessSolver {
    at: DynamicKey,
    factors: CoupledFactors,
    /// Springs on the null motions, which a frequency of zero needs.
    pins: Pins,
    modal: Option<Arc<ModalDamping>>,
    /// Entries (row, column, value) of structural damping, if modal damping acts as well.
    structural: Vec<(usize, usize, Complex64)>,
    /// Kᵀ and (C + ΩG)ᵀ, which solutions with Sᵀ and modal damping need.
    transposed: Arc<OnceLock<[Sparse; 2]>>,
}

impl DynamicStiffnessSolver {
    /// The factors at a point, with modal damping if it is given.
    ///
    /// # Errors
    /// [`DecompositionError`] if the null motions cannot be found. The inner error means that the matrix is singular.
    pub fn new(
        model: &Model,
        at: DynamicKey,
        modal: Option<Arc<ModalDamping>>,
    ) -> Result<Result<Self, Singular>, DecompositionError> {
        let DynamicKey { speed, spin, flank_speed } = at;
        let pins = if spin == 0.0 { Pins::new(model, &null_motions(model, flank_speed)?) } else { Pins::default() };
        // Modal damping has no force without velocity.
        let modal = modal.filter(|_| spin != 0.0);
        let is_lossy = modal.is_some() && model.has_structural_damping();
        let damping = StructuralDamping { frequency: spin, speed };
        let structural = if is_lossy { model.structural_entries(damping, flank_speed) } else { Vec::new() };
        let mut weights = Weights::harmonic(spin, speed);
        if let Some(modal) = &modal {
            weights = modal.banded(Complex64::new(0.0, spin), weights);
        }
        let mut matrix = model.dynamic_stiffness(&weights, flank_speed);
        pins.add_to(model, &mut matrix);
        let factors = matrix.factor();
        Ok(factors.map(|factors| Self { at, factors, pins, modal, structural, transposed: Arc::default() }))
    }

    /// The solver with transposed matrices that it shares with those of other frequencies.
    pub(super) fn sharing(self, transposed: Arc<OnceLock<[Sparse; 2]>>) -> Self {
        Self { transposed, ..self }
    }

    /// The solution for `force`, N and N m, with the same model: its response, or that with Sᵀ; without modal damping to a
    /// backward error, or to round-off if it is zero.
    ///
    /// # Errors
    /// [`Singular`] if round-off or the iteration leaves no accurate solution.
    pub fn solve(
        &self,
        model: &Model,
        side: Side,
        tolerance: f64,
        force: &DVector<Complex64>,
    ) -> Result<Solved, Singular> {
        match &self.modal {
            Some(modal) => self.iterate(model, side, modal, force),
            None => {
                let (mut phasors, residual) = model.solve(&self.factors, side, Some(tolerance), force.as_slice())?;
                self.pins.remove_null_motions(&mut phasors);
                Ok(Solved { phasors, products: 0, residual })
            }
        }
    }

    /// The same with modal damping.
    fn iterate(
        &self,
        model: &Model,
        side: Side,
        modal: &ModalDamping,
        force: &DVector<Complex64>,
    ) -> Result<Solved, Singular> {
        let DynamicKey { speed, spin, flank_speed } = self.at;
        let eigenvalue = Complex64::new(0.0, spin);
        let solve =
            |force: &DVector<Complex64>| model.solve(&self.factors, side, None, force.as_slice()).map(|(x, _)| x);
        let sparse = |matrix: &Sparse, x: &DVector<Complex64>| {
            model.product(x, |x, out| {
                out.fill(0.0);
                matrix.multiply_add(1.0, x, out);
            })
        };
        let matrices = || [model.sparse_stiffness(flank_speed), model.sparse_rate(speed)].map(|part| part.transposed());
        let transposed = (side == Side::Left).then(|| self.transposed.get_or_init(matrices));
        // P⁻¹S x.
        let apply = |x: &DVector<Complex64>| {
            let mut force = match transposed {
                None => {
                    let forces = EquationForces::All(Some(modal));
                    dynamic_force(model, [speed, flank_speed], eigenvalue, x, forces)
                }
                Some([stiffness, rate]) => {
                    let inertia = model.product(x, |x, out| model.multiply_mass(x, out));
                    let rate = sparse(rate, x) + modal.product(model, x);
                    sparse(stiffness, x) + rate * eigenvalue + inertia * (eigenvalue * eigenvalue)
                }
            };
            for (row, column, value) in &self.structural {
                let (row, column) = if side == Side::Left { (*column, *row) } else { (*row, *column) };
                force[row] += value * x[column];
            }
            solve(&force)
        };
        let weigh = |x: &DVector<Complex64>| {
            let inertia =
                model.product(x, |x, out| model.multiply_mass(x, out)) * Complex64::from(eigenvalue.norm_sqr());
            inertia + model.product(x, |x, out| model.multiply_stiffness(flank_speed, true, x, out))
        };
        let start = solve(force)?;
        let LeastResidual { x: phasors, products, is_converged } =
            conjugate_residuals(&start, MAX_BACKWARD_ERROR, apply, weigh)?;
        if !is_converged {
            return Err(Singular);
        }
        let norm = |x: &DVector<Complex64>| x.dotc(&weigh(x)).re.abs().sqrt();
        let size = norm(&start);
        let residual = if size == 0.0 { 0.0 } else { norm(&(&start - apply(&phasors)?)) / size };
        Ok(Solved { phasors, products, residual })
    }
}

/// The force S(λ)φ at the speed Ω, with the flanks in contact at `flank_speed` (reference shaft, rad/s), n
/// entries. Elastic forces come from strains, so that stiff elements cause no round-off in soft motions.
pub fn dynamic_force(
    model: &Model,
    [speed, flank_speed]: [f64; 2],
    eigenvalue: Complex64,
    shape: &DVector<Complex64>,
    forces: EquationForces<'_>,
) -> DVector<Complex64> {
    let is_undamped = matches!(forces, EquationForces::Undamped);
    let mass = model.product(shape, |x, out| model.multiply_mass(x, out));
    let elastic = model.product(shape, |x, out| model.multiply_stiffness(flank_speed, is_undamped, x, out));
    let mut rate = model.product(shape, |x, out| model.multiply_gyroscopic(x, out)) * Complex64::from(speed);
    if let EquationForces::All(modal) = forces {
        rate += model.product(shape, |x, out| model.multiply_damping(flank_speed, x, out));
        if let Some(modal) = modal {
            rate += modal.product(model, shape);
        }
    }
    elastic + rate * eigenvalue + mass * (eigenvalue * eigenvalue)
}
