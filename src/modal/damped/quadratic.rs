//! Quadratic eigenvalue problem of the damped modes as a function of eigenvalue and speed.
//!
//! ```text
//! P(λ, Ω) η = [λ² + λ (D + ΩĜ) + diag(ω²) + N] η = 0,      D = ΦᵀCΦ,  Ĝ = ΦᵀGΦ,  N = Φᵀ K_skew Φ
//! ```
//!
//! η are undamped modal coordinates. They make the stiffness diagonal, so the stiff modes cause no round-off errors in
//! the soft ones. Ω is the speed of the reference shaft, rad/s.

use nalgebra::{Complex, DMatrix, DVector};

use crate::linalg::{DecompositionError, hermitian_eigen, solve, solve_complex};
use crate::modal::cache::CachedModel;
use crate::modal::lowest::ModeAtSpeed;

/// Newton's method converges quadratically; if it needs more iterations, it diverges.
const MAX_ITERATIONS: usize = 20;
/// Relative change of λ and Ω at which Newton's method has converged.
const CONVERGED: f64 = 1e-13;

/// The matrix function P(λ, Ω) of one model, for one sign of Ω.
#[derive(Clone, Debug)]
pub struct Quadratic {
    /// Undamped frequencies ω, rad/s, n entries.
    frequencies: DVector<f64>,
    /// Number of rigid-body modes.
    null: usize,
    /// Φ, n × n.
    shapes: DMatrix<f64>,
    /// MΦ, n × n.
    momenta: DMatrix<f64>,
    /// N, n × n, 1/s².
    skew: DMatrix<f64>,
    /// D, n × n, 1/s.
    damping: DMatrix<f64>,
    /// Ĝ, n × n.
    gyroscopic: DMatrix<f64>,
}

/// Speed, rad/s, eigenvalue, rad/s, and undamped modal coordinates of a mode.
struct Point {
    speed: f64,
    eigenvalue: Complex<f64>,
    /// η, n entries, of unit length.
    coordinates: DVector<Complex<f64>>,
}

impl Quadratic {
    /// P for speeds with the sign of `speed`.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be computed.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let real = cached.real_modes(speed)?;
        Ok(Self {
            frequencies: real.frequencies.clone(),
            null: real.null,
            shapes: real.vectors.clone(),
            momenta: cached.model.mass_times(&real.vectors),
            skew: real.project(&cached.model.skew_part_matrix()),
            damping: real.project(&cached.damping_matrix(speed)?),
            gyroscopic: real.project(&cached.model.gyroscopic_matrix()),
        })
    }

    /// Mode with Im λ = `order`·Ω near `start`, by Newton's method for η, Re λ and Ω; `None` if it does not converge.
    ///
    /// Each iteration solves −P η⁺ = (∂P/∂Re λ η) ΔRe λ + (∂P/∂Ω η) ΔΩ with cᴴη⁺ = 1, where Im λ = order·Ω: the
    /// bordered system of Spence and Poulton (J. Comput. Phys. 204, 2005).
    pub fn intersection(&self, order: f64, start: &ModeAtSpeed) -> Option<ModeAtSpeed> {
        let coordinates = map(&self.momenta.transpose(), &start.shape);
        let mut at = Point { speed: start.speed, eigenvalue: start.eigenvalue, coordinates };
        at.eigenvalue.im = order * at.speed;
        for _ in 0..MAX_ITERATIONS {
            let anchor = at.coordinates.adjoint();
            let by_decay = self.derivative(&at);
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
                let shape = map(&self.shapes, &at.coordinates);
                return Some(ModeAtSpeed { speed: at.speed, eigenvalue: at.eigenvalue, shape });
            }
        }
        None
    }

    /// Undamped modes with the frequency ω = `order`·Ω, Ω > 0, in ascending order of speed. Damping is neglected.
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
                shape: map(&self.shapes, &coordinates.unscale(norm)),
            }
        };
        // Descending 1/ω² is ascending ω. Values that are positive only by round-off are no critical speeds.
        let round_off = f64::EPSILON * values.last().copied().unwrap_or(0.0).abs();
        let columns = (0..rest).rev().map(|i| (values[i], vectors.column(i).into_owned()));
        Ok(columns.filter(|(value, _)| *value > round_off).map(mode).collect())
    }

    /// P(λ, Ω).
    fn matrix(&self, at: &Point) -> DMatrix<Complex<f64>> {
        let n = self.frequencies.len();
        let lambda = at.eigenvalue;
        DMatrix::from_fn(n, n, |i, j| {
            let diagonal = if i == j { lambda * lambda + self.frequencies[i].powi(2) } else { Complex::from(0.0) };
            diagonal + lambda * (self.damping[(i, j)] + at.speed * self.gyroscopic[(i, j)]) + self.skew[(i, j)]
        })
    }

    /// (∂P/∂λ) η.
    fn derivative(&self, at: &Point) -> DVector<Complex<f64>> {
        let rate = complex(&(&self.damping + &self.gyroscopic * at.speed));
        &at.coordinates * (at.eigenvalue * 2.0) + rate * &at.coordinates
    }
}

fn complex(matrix: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    matrix.map(Complex::from)
}

/// A x for a real matrix A.
fn map(matrix: &DMatrix<f64>, x: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let part = |part: fn(&Complex<f64>) -> f64| matrix * x.map(|value| part(&value));
    part(|value| value.re).zip_map(&part(|value| value.im), Complex::new)
}
