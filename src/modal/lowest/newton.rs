//! One mode by Newton's method, at a speed or on a line of the Campbell diagram, Im λ = order·Ω: from the sparse matrices of the
//! shafts, or in the space of [`super::mode_space`].

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use crate::linalg::{Side, Singular, solve};
use crate::modal::undamped::ModalDamping;
use crate::model::{Model, Weights};
use crate::numerics::ROOT_OF_ROUND_OFF;

/// Newton's method converges quadratically, and with modal damping by the damping ratio in each iteration; if it needs more
/// iterations, it diverges.
const MAX_ITERATIONS: usize = 20;
/// Error of φ, λ and Ω, relative to each, at which iteration stops.
const CONVERGED: f64 = 1e-9;

/// A mode and the speed at which it is one.
#[derive(Clone, Debug)]
pub struct ModeAtSpeed {
    /// Speed Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Eigenvalue λ, rad/s.
    pub eigenvalue: Complex<f64>,
    /// Mode shape φ with φᴴMφ = 1, n entries in the order of the core.
    pub shape: DVector<Complex<f64>>,
}

/// What Newton's method changes besides the shape and Re λ.
#[derive(Clone, Copy, Debug)]
pub enum Unknown {
    /// The frequency Im λ, at the given speed.
    Frequency,
    /// The speed Ω, with Im λ = order·Ω for this order. Matrices must not depend on the speed.
    Speed(f64),
}

/// Changes in one iteration.
pub(super) struct Change {
    pub shape: DVector<Complex64>,
    /// Change of Re λ, rad/s.
    decay: f64,
    /// Change of the further unknown, rad/s.
    further: f64,
}

/// Forces of a motion φ with λ at a speed Ω.
pub(super) struct Forces {
    /// Mφ.
    pub inertia: DVector<Complex64>,
    /// (C + ΩG)φ.
    pub rate: DVector<Complex64>,
    /// Gφ.
    pub gyroscopic: DVector<Complex64>,
    /// S(λ)φ.
    pub residual: DVector<Complex64>,
}

/// The equations of motion S(λ)φ = 0 in some coordinates.
pub(super) trait Equations {
    /// Forces of a motion.
    fn forces(&self, at: &ModeAtSpeed) -> Forces;

    /// S(λ)⁻¹ times the columns of `right`, with a matrix close to S(λ) if that is enough for convergence.
    fn solve(&self, at: &ModeAtSpeed, right: DMatrix<Complex64>) -> Result<DMatrix<Complex64>, Singular>;

    /// φᴴMφ.
    fn kinetic_form(&self, shape: &DVector<Complex64>) -> f64;

    /// Whether [`Self::solve`] takes S(λ) itself, so that convergence is quadratic.
    fn is_exact(&self) -> bool;

    /// One iteration of Newton's method.
    ///
    /// It solves S Δφ = −Sφ − (∂S/∂Re λ φ) ΔRe λ − (∂S/∂p φ) Δp with φᴴMΔφ = 0 and the further unknown p: the
    /// bordered system of Spence and Poulton (J. Comput. Phys. 204, 2005).
    fn step(&self, unknown: Unknown, at: &ModeAtSpeed) -> Result<Change, Singular> {
        let Forces { inertia, rate, gyroscopic, residual } = self.forces(at);
        let by_decay = &inertia * (2.0 * at.eigenvalue) + rate;
        let columns = match unknown {
            Unknown::Frequency => vec![by_decay, residual],
            Unknown::Speed(_) => vec![by_decay, residual, gyroscopic * at.eigenvalue],
        };
        let solved = self.solve(at, DMatrix::from_columns(&columns))?;
        let (by_decay, residual) = (solved.column(0), solved.column(1));
        let by_further = match unknown {
            Unknown::Frequency => by_decay * Complex64::I,
            Unknown::Speed(order) => by_decay * Complex64::new(0.0, order) + solved.column(2),
        };
        let of = |column: &DVector<Complex64>| inertia.dotc(column);
        let (decay, further) = (inertia.dotc(&by_decay), of(&by_further));
        let constant = inertia.dotc(&residual);
        let borders = DMatrix::from_row_slice(2, 2, &[decay.re, further.re, decay.im, further.im]);
        let change = solve(&borders, &DMatrix::from_row_slice(2, 1, &[-constant.re, -constant.im]));
        let (decay, further) = (change[(0, 0)], change[(1, 0)]);
        let shape = -(residual + by_decay * Complex64::from(decay) + by_further * Complex64::from(further));
        Ok(Change { shape, decay, further })
    }
}

/// Mode near `start` at its speed, which oscillates if `start` does, with the flanks in contact there; `None` if the iteration does not converge.
pub fn mode_near(model: &Model, modal: Option<&ModalDamping>, start: &ModeAtSpeed) -> Option<ModeAtSpeed> {
    newton(&FullEquations { model, modal }, Unknown::Frequency, start.clone())
}

/// The mode that Newton's method finds from the approximation `at`; `None` if it does not converge.
pub(super) fn newton(equations: &impl Equations, unknown: Unknown, mut at: ModeAtSpeed) -> Option<ModeAtSpeed> {
    let (mut previous, mut is_close) = (f64::INFINITY, false);
    // A mode without oscillation has a real shape; the imaginary parts of its changes are round-off.
    let is_real = at.eigenvalue.im == 0.0;
    // Ratio of the second and the first change: the square of the error follows in each iteration, with modal damping its
    // product with the damping ratio.
    let first_rate = |change: f64| if equations.is_exact() { change.sqrt() } else { 1.0 };
    for _ in 0..MAX_ITERATIONS {
        let change = equations.step(unknown, &at).ok()?;
        let size = match unknown {
            Unknown::Frequency => at.eigenvalue.norm(),
            Unknown::Speed(_) => at.speed.abs(),
        };
        let of_values = (change.decay.abs() / at.eigenvalue.norm()).max(change.further.abs() / size);
        let largest = of_values.max(equations.kinetic_form(&change.shape).sqrt());
        // At the root, S is singular to round-off, and a further step would spoil φ.
        if is_close && largest >= previous / 2.0 {
            return Some(at);
        }
        at.shape += change.shape;
        let norm = equations.kinetic_form(&at.shape).sqrt();
        at.shape.unscale_mut(norm);
        at.eigenvalue.re += change.decay;
        match unknown {
            Unknown::Frequency => at.eigenvalue.im += change.further,
            Unknown::Speed(order) => {
                at.speed += change.further;
                at.eigenvalue.im = order * at.speed;
            }
        }
        if is_real {
            at.eigenvalue.im = 0.0;
            at.shape.iter_mut().for_each(|value| value.im = 0.0);
        }
        if !(largest.is_finite() && norm.is_finite() && norm > 0.0 && (is_real || at.eigenvalue.im > 0.0)) {
            return None;
        }
        // The next change is smaller than this one by the same factor at least; without modal damping its square follows.
        let rate = if previous.is_finite() { (largest / previous).min(1.0) } else { first_rate(largest) };
        if largest * rate <= CONVERGED {
            return Some(at);
        }
        (previous, is_close) = (largest, of_values <= ROOT_OF_ROUND_OFF);
    }
    None
}

/// The equations in the coordinates of the model, whose residual comes from the strains, so that the stiff modes cause no
/// round-off in the soft ones. With modal damping, a sparse matrix close to S(λ) solves them, and the error decreases by the damping
/// ratio in each iteration.
pub struct FullEquations<'m> {
    /// Model at a speed.
    pub model: &'m Model,
    /// Its modal damping.
    pub modal: Option<&'m ModalDamping>,
}

impl Equations for FullEquations<'_> {
    fn forces(&self, at: &ModeAtSpeed) -> Forces {
        let Self { model, modal } = *self;
        let (lambda, phi) = (at.eigenvalue, &at.shape);
        let [inertia, mut rate, gyroscopic] = [
            model.product(phi, |x, out| model.multiply_mass(x, out)),
            model.product(phi, |x, out| model.multiply_damping(at.speed, x, out)),
            model.product(phi, |x, out| model.multiply_gyroscopic(x, out)),
        ];
        if let Some(modal) = modal {
            rate += modal.product(model, phi);
        }
        rate += &gyroscopic * Complex64::from(at.speed);
        let elastic = model.product(phi, |x, out| model.multiply_stiffness(at.speed, false, x, out));
        let mut residual = elastic + &rate * lambda + &inertia * (lambda * lambda);
        model.add_structural_force(lambda, at.speed, phi, &mut residual);
        Forces { inertia, rate, gyroscopic, residual }
    }

    fn solve(&self, at: &ModeAtSpeed, mut right: DMatrix<Complex64>) -> Result<DMatrix<Complex64>, Singular> {
        let Self { model, modal } = *self;
        let weights = Weights::mode(at.eigenvalue, at.speed);
        let weights = modal.map_or(weights, |modal| modal.banded(at.eigenvalue, weights));
        let factors = model.dynamic_stiffness(&weights, at.speed).factor()?;
        for mut column in right.column_iter_mut() {
            let (x, _) = model.solve(&factors, Side::Right, None, column.as_slice())?;
            column.copy_from(&x);
        }
        Ok(right)
    }

    fn kinetic_form(&self, shape: &DVector<Complex64>) -> f64 {
        self.model.complex_kinetic_form(shape)
    }

    fn is_exact(&self) -> bool {
        self.modal.is_none()
    }
}
