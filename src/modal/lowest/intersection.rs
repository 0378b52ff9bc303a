//! One mode by Newton's method, from the band matrices of the shafts: at a speed, or on a line of the Campbell diagram,
//! Im λ = order·Ω.

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use crate::linalg::{Side, Singular, solve};
use crate::modal::undamped::ModalDamping;
use crate::model::{Model, Weights};

/// Newton's method converges quadratically, and with modal damping by the damping ratio in each iteration; if it needs more
/// iterations, it diverges.
const MAX_ITERATIONS: usize = 20;
/// Error of φ, λ and Ω, relative to each, at which iteration stops.
const CONVERGED: f64 = 1e-9;
/// Relative change of λ and Ω below which changes that no longer decrease are due to round-off in stiff scenes.
const STALLED: f64 = 1e-8;

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
enum Unknown {
    /// The frequency Im λ, at the given speed.
    Frequency,
    /// The speed Ω, with Im λ = order·Ω for this order.
    Speed(f64),
}

/// Mode with Im λ = `order`·Ω near `start`, its intersection with the line of this order in the Campbell diagram, with the
/// flanks in contact at positive speeds; `None` if the iteration does not converge. Matrices must not depend on the speed.
pub fn intersection(
    model: &Model,
    modal: Option<&ModalDamping>,
    order: f64,
    start: &ModeAtSpeed,
) -> Option<ModeAtSpeed> {
    let mut at = start.clone();
    at.eigenvalue.im = order * at.speed;
    newton(model, modal, Unknown::Speed(order), at)
}

/// Mode near `start` at its speed, which oscillates if `start` does, with the flanks in contact there; `None` if the iteration does not converge.
pub fn mode_near(model: &Model, modal: Option<&ModalDamping>, start: &ModeAtSpeed) -> Option<ModeAtSpeed> {
    newton(model, modal, Unknown::Frequency, start.clone())
}

/// A mode, from the approximation `at`, by Newton's method.
///
/// Each iteration solves S Δφ = −Sφ − (∂S/∂Re λ φ) ΔRe λ − (∂S/∂p φ) Δp with φᴴMΔφ = 0 and the further unknown p: the
/// bordered system of Spence and Poulton (J. Comput. Phys. 204, 2005). The residual Sφ comes from the strains, so that the
/// stiff modes cause no round-off in the soft ones. With modal damping, S is a band matrix close to the dynamic stiffness, and
/// the error decreases by the damping ratio in each iteration.
fn newton(model: &Model, modal: Option<&ModalDamping>, unknown: Unknown, mut at: ModeAtSpeed) -> Option<ModeAtSpeed> {
    let (mut previous, mut is_close) = (f64::INFINITY, false);
    // A mode without oscillation has a real shape; the imaginary parts of its changes are round-off.
    let is_real = at.eigenvalue.im == 0.0;
    // Ratio of the second and the first change: the square of the error follows in each iteration, with modal damping its
    // product with the damping ratio.
    let first_rate = |change: f64| if modal.is_none() { change.sqrt() } else { 1.0 };
    for _ in 0..MAX_ITERATIONS {
        let change = newton_step(model, modal, unknown, &at).ok()?;
        let size = match unknown {
            Unknown::Frequency => at.eigenvalue.norm(),
            Unknown::Speed(_) => at.speed.abs(),
        };
        let of_values = (change.decay.abs() / at.eigenvalue.norm()).max(change.further.abs() / size);
        let largest = of_values.max(model.complex_kinetic_form(&change.shape).sqrt());
        // At the root, S is singular to round-off, and a further step would spoil φ.
        if is_close && largest >= previous / 2.0 {
            return Some(at);
        }
        at.shape += change.shape;
        let norm = model.complex_kinetic_form(&at.shape).sqrt();
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
        (previous, is_close) = (largest, of_values <= STALLED);
    }
    None
}

/// Changes in one iteration.
struct Change {
    shape: DVector<Complex64>,
    /// Change of Re λ, rad/s.
    decay: f64,
    /// Change of the further unknown, rad/s.
    further: f64,
}

/// One iteration of Newton's method.
fn newton_step(
    model: &Model,
    modal: Option<&ModalDamping>,
    unknown: Unknown,
    at: &ModeAtSpeed,
) -> Result<Change, Singular> {
    let (lambda, phi) = (at.eigenvalue, &at.shape);
    let [inertia, mut damping, gyroscopic] = [
        model.product(phi, |x, out| model.multiply_mass(x, out)),
        model.product(phi, |x, out| model.multiply_damping(at.speed, x, out)),
        model.product(phi, |x, out| model.multiply_gyroscopic(x, out)),
    ];
    if let Some(modal) = modal {
        damping += modal.product(model, phi);
    }
    let elastic = model.product(phi, |x, out| model.multiply_stiffness(at.speed, false, x, out));
    let rate = &damping + &gyroscopic * Complex64::from(at.speed);
    let residual = elastic + &rate * lambda + &inertia * (lambda * lambda);
    let by_decay = &inertia * (2.0 * lambda) + rate;
    let sense = if lambda.re < 0.0 { -1.0 } else { 1.0 };
    let weights = Weights::dynamic(lambda, at.speed);
    let weights = modal.map_or(weights, |modal| modal.banded(lambda, weights));
    let factors = model.dynamic_stiffness(&weights, at.speed).factor(sense)?;
    let solved = |right: &DVector<Complex64>| {
        let mut x = model.to_circular(right.as_slice());
        factors.solve_once(Side::Right, &mut x);
        DVector::from_vec(model.from_circular(&x))
    };
    let [by_decay, residual] = [&by_decay, &residual].map(solved);
    let by_further = match unknown {
        Unknown::Frequency => &by_decay * Complex64::I,
        Unknown::Speed(order) => &by_decay * Complex64::new(0.0, order) + solved(&(gyroscopic * lambda)),
    };
    let [decay, further, constant] = [&by_decay, &by_further, &residual].map(|column| inertia.dotc(column));
    let borders = DMatrix::from_row_slice(2, 2, &[decay.re, further.re, decay.im, further.im]);
    let change = solve(&borders, &DMatrix::from_row_slice(2, 1, &[-constant.re, -constant.im]));
    let (decay, further) = (change[(0, 0)], change[(1, 0)]);
    let shape = -(residual + by_decay * Complex64::from(decay) + by_further * Complex64::from(further));
    Ok(Change { shape, decay, further })
}
