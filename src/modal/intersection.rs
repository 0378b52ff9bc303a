//! Modes on a line of the Campbell diagram, Im λ = order·Ω, from the band matrices of the shafts.

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use crate::linalg::{Singular, solve};
use crate::model::{Model, Weights};

/// Newton's method converges quadratically; if it needs more iterations, it diverges.
const MAX_ITERATIONS: usize = 20;
/// Change of φ, λ and Ω, relative to each, after which the error of the next iterate, its square, is below round-off.
const CONVERGED: f64 = 1e-9;
/// Relative change of λ and Ω below which changes that no longer decrease are due to round-off in stiff scenes.
const STALLED: f64 = 1e-8;

/// A mode whose frequency is a multiple (order) of the speed, Im λ = order·Ω: its intersection with the line of this
/// order in the Campbell diagram.
#[derive(Clone, Debug)]
pub struct OrderIntersection {
    /// Speed Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// Eigenvalue λ, rad/s.
    pub eigenvalue: Complex<f64>,
    /// Mode shape φ with φᴴMφ = 1, n entries in the order of the core.
    pub shape: DVector<Complex<f64>>,
}

/// Mode with Im λ = `order`·Ω near `start`, by Newton's method for φ, Re λ and Ω, with the flanks in contact at positive
/// speeds; `None` if it does not converge.
///
/// Each iteration solves S Δφ = −Sφ − (∂S/∂Re λ φ) ΔRe λ − (∂S/∂Ω φ) ΔΩ with φᴴMΔφ = 0, where Im λ = order·Ω: the
/// bordered system of Spence and Poulton (J. Comput. Phys. 204, 2005). The residual Sφ comes from the strains, so that the
/// stiff modes cause no round-off in the soft ones.
pub fn intersection(model: &Model, order: f64, start: &OrderIntersection) -> Option<OrderIntersection> {
    let mut at = start.clone();
    at.eigenvalue.im = order * at.speed;
    let (mut previous, mut is_close) = (f64::INFINITY, false);
    for _ in 0..MAX_ITERATIONS {
        let (shape, decay, speed) = newton_step(model, order, &at).ok()?;
        let of_values = (decay.abs() / at.eigenvalue.norm()).max(speed.abs() / at.speed.abs());
        let change = of_values.max(model.complex_kinetic_form(&shape).sqrt());
        // At the root, S is singular to round-off, and a further step would spoil φ.
        if is_close && change >= previous / 2.0 {
            return Some(at);
        }
        at.shape += shape;
        let size = model.complex_kinetic_form(&at.shape).sqrt();
        at.shape.unscale_mut(size);
        at.speed += speed;
        at.eigenvalue = Complex::new(at.eigenvalue.re + decay, order * at.speed);
        if !(change.is_finite() && size.is_finite() && size > 0.0 && at.speed > 0.0) {
            return None;
        }
        if change <= CONVERGED {
            return Some(at);
        }
        (previous, is_close) = (change, of_values <= STALLED);
    }
    None
}

/// Changes of φ, Re λ and Ω.
fn newton_step(model: &Model, order: f64, at: &OrderIntersection) -> Result<(DVector<Complex64>, f64, f64), Singular> {
    let (lambda, phi) = (at.eigenvalue, &at.shape);
    let [inertia, damping, gyroscopic] = [
        model.product(phi, |x, out| model.multiply_mass(x, out)),
        model.product(phi, |x, out| model.multiply_damping(at.speed, x, out)),
        model.product(phi, |x, out| model.multiply_gyroscopic(x, out)),
    ];
    let elastic = model.product(phi, |x, out| model.multiply_stiffness(at.speed, false, x, out));
    let rate = &damping + &gyroscopic * Complex64::from(at.speed);
    let residual = elastic + &rate * lambda + &inertia * (lambda * lambda);
    let by_decay = &inertia * (2.0 * lambda) + rate;
    let by_speed = &by_decay * Complex64::new(0.0, order) + gyroscopic * lambda;
    let sense = if lambda.re < 0.0 { -1.0 } else { 1.0 };
    let factors = model.dynamic_stiffness(&Weights::dynamic(lambda, at.speed), at.speed).factor(sense)?;
    let [by_decay, by_speed, residual] = [by_decay, by_speed, residual].map(|right| {
        let mut x = model.to_circular(right.as_slice());
        factors.solve_once(&mut x);
        DVector::from_vec(model.from_circular(&x))
    });
    let [decay, speed, constant] = [&by_decay, &by_speed, &residual].map(|column| inertia.dotc(column));
    let borders = DMatrix::from_row_slice(2, 2, &[decay.re, speed.re, decay.im, speed.im]);
    let change = solve(&borders, &DMatrix::from_row_slice(2, 1, &[-constant.re, -constant.im]));
    let (decay, speed) = (change[(0, 0)], change[(1, 0)]);
    let shape = -(residual + by_decay * Complex64::from(decay) + by_speed * Complex64::from(speed));
    Ok((shape, decay, speed))
}
