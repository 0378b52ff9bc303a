//! The damped problem in undamped modes as it depends on frequency and speed at once.
//!
//! ```text
//! P(λ, Ω) η = [λ² + λ (D + ΩĜ) + diag(ω²) + N] η = 0,      D = ΦᵀCΦ,  Ĝ = ΦᵀGΦ,  N = Φᵀ K_skew Φ
//! ```
//!
//! In these coordinates the stiff modes stand on the diagonal and take no digits from the soft ones.

use nalgebra::{Complex, DMatrix, DVector};

use super::CachedModel;
use super::damped::project;
use crate::linalg::{DecompositionError, hermitian_eigen, solve, solve_complex};

/// Newton converges quadratically: more iterations mean that it does not.
const ITERATIONS: usize = 20;
/// RelativeMotion change of λ and Ω at which they stand.
const CONVERGED: f64 = 1e-13;

/// P(λ, Ω) of one basis, for one sign of Ω.
#[derive(Clone, Debug)]
pub struct Quadratic {
    frequencies: DVector<f64>,
    null: usize,
    skew: DMatrix<f64>,
    damping: DMatrix<f64>,
    gyroscopic: DMatrix<f64>,
}

/// A mode whose frequency is a given multiple of the speed.
#[derive(Clone, Debug)]
pub struct OnLine {
    /// Ω of the reference shaft, rad/s.
    pub speed: f64,
    /// λ, rad/s: its imaginary part is the order times Ω.
    pub eigenvalue: Complex<f64>,
    /// η of undamped modes, of unit length.
    pub coordinates: DVector<Complex<f64>>,
}

impl Quadratic {
    /// P at speeds of the sign of `speed`.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let real = cached.real_modes(speed)?;
        let supports = cached.model.support_stiffness_matrix();
        Ok(Self {
            frequencies: real.frequencies.clone(),
            null: real.null,
            skew: project(real, &((&supports - supports.transpose()) / 2.0)),
            damping: project(real, &cached.damping_matrix(speed)?),
            gyroscopic: project(real, &cached.model.gyroscopic_matrix()),
        })
    }

    /// ω of undamped mode `index`, rad/s.
    pub fn frequency(&self, index: usize) -> f64 {
        self.frequencies[index]
    }

    /// The mode with Im λ = `order`·Ω near `start`, by Newton on (η, Re λ, Ω); none where that does not converge.
    ///
    /// P is complex and its unknowns are η and two real numbers: −P η⁺ = (∂P/∂Re λ η) δ + (∂P/∂Ω η) ΔΩ with cᴴη⁺ = 1,
    /// the bordered system of Spence and Poulton (J. Comput. Phys. 204, 2005) with the line eliminated.
    pub fn on_line(&self, order: f64, start: &OnLine) -> Option<OnLine> {
        let mut at = start.clone();
        at.eigenvalue.im = order * at.speed;
        for _ in 0..ITERATIONS {
            let anchor = at.coordinates.adjoint();
            let by_decay = self.slope(&at);
            let gyroscopic = complex(&self.gyroscopic) * &at.coordinates * at.eigenvalue;
            let by_speed = &by_decay * Complex::new(0.0, order) + gyroscopic;
            let solved = solve_complex(&self.matrix(&at), &DMatrix::from_columns(&[by_decay, by_speed]));
            let [u, w] = [0, 1].map(|column| (&anchor * solved.column(column))[(0, 0)]);
            let borders = DMatrix::from_row_slice(2, 2, &[u.re, w.re, u.im, w.im]);
            let change = solve(&borders, &DMatrix::from_row_slice(2, 1, &[-1.0, 0.0]));
            let (decay, speed) = (change[(0, 0)], change[(1, 0)]);
            let next = solved.column(0) * Complex::from(-decay) + solved.column(1) * Complex::from(-speed);
            at.speed += speed;
            at.eigenvalue = Complex::new(at.eigenvalue.re + decay, order * at.speed);
            let norm = next.norm();
            if !(norm.is_finite() && norm > 0.0 && at.eigenvalue.is_finite()) {
                return None;
            }
            at.coordinates = next.unscale(norm);
            if decay.abs() <= CONVERGED * at.eigenvalue.norm() && speed.abs() <= CONVERGED * at.speed.abs() {
                return Some(at);
            }
        }
        None
    }

    /// Undamped modes whose frequency is `order`·Ω with Ω > 0, ascending; damping is left out.
    ///
    /// With Ω = ω/`order` nothing but ω² is unknown: diag(ω_j²) η = ω² (1 − iĜ/`order`) η, Hermitian. It is solved for
    /// 1/ω², whose positive values are the critical speeds; a disk that is flat enough has none forward.
    ///
    /// # Errors
    /// [`DecompositionError`] if the eigenvalue iteration fails.
    pub fn critical(&self, order: f64) -> Result<Vec<OnLine>, DecompositionError> {
        let n = self.frequencies.len();
        let inertia = DMatrix::from_fn(n, n, |i, j| {
            Complex::new(if i == j { 1.0 } else { 0.0 }, -self.gyroscopic[(i, j)] / order)
        });
        // What null motions do follows from the others: their rows have no stiffness.
        let (null, rest) = (self.null, n - self.null);
        let following = -solve_complex(
            &inertia.view((0, 0), (null, null)).into_owned(),
            &inertia.view((0, null), (null, rest)).into_owned(),
        );
        let elastic = inertia.view((null, null), (rest, rest)) + inertia.view((null, 0), (rest, null)) * &following;
        let frequency = |i: usize| self.frequencies[null + i];
        let scaled = DMatrix::from_fn(rest, rest, |i, j| elastic[(i, j)] / Complex::from(frequency(i) * frequency(j)));
        let (values, vectors) = hermitian_eigen(&scaled)?;
        let mode = |(value, vector): (f64, DVector<Complex<f64>>)| {
            let held = DVector::from_fn(rest, |i, _| vector[i] / frequency(i));
            let mut coordinates = DVector::zeros(n);
            coordinates.rows_mut(0, null).copy_from(&(&following * &held));
            coordinates.rows_mut(null, rest).copy_from(&held);
            let frequency = 1.0 / value.sqrt();
            let norm = coordinates.norm();
            OnLine {
                speed: frequency / order,
                eigenvalue: Complex::new(0.0, frequency),
                coordinates: coordinates.unscale(norm),
            }
        };
        // Descending 1/ω² is ascending ω; what is not positive beyond round-off is no critical speed.
        let nothing = f64::EPSILON * values.last().copied().unwrap_or(0.0).abs();
        let columns = (0..rest).rev().map(|i| (values[i], vectors.column(i).into_owned()));
        Ok(columns.filter(|(value, _)| *value > nothing).map(mode).collect())
    }

    fn matrix(&self, at: &OnLine) -> DMatrix<Complex<f64>> {
        let n = self.frequencies.len();
        let lambda = at.eigenvalue;
        DMatrix::from_fn(n, n, |i, j| {
            let own = if i == j { lambda * lambda + self.frequencies[i].powi(2) } else { Complex::from(0.0) };
            own + lambda * (self.damping[(i, j)] + at.speed * self.gyroscopic[(i, j)]) + self.skew[(i, j)]
        })
    }

    /// ∂P/∂λ η.
    fn slope(&self, at: &OnLine) -> DVector<Complex<f64>> {
        let rate = complex(&(&self.damping + &self.gyroscopic * at.speed));
        &at.coordinates * (at.eigenvalue * 2.0) + rate * &at.coordinates
    }
}

fn complex(matrix: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    matrix.map(Complex::from)
}
