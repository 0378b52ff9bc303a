//! The lowest undamped critical speeds, in time proportional to n.
//!
//! An undamped mode with λ = iω, ω = order·Ω, satisfies K x = −λ² B x with B = M − iG/order. The operator K⁻¹B is Hermitian in
//! the inner product xᴴKy; its eigenvalues −1/λ² of largest magnitude belong to the lowest critical speeds ([`super::arnoldi`]),
//! or to real λ, which are none. Null motions N have no stiffness: every x satisfies NᴴBx = 0, and springs ([`Pins`]) make K
//! regular.
//!
//! The inertia of K − σB counts the critical speeds with 0 < ω² < σ where K is positive semidefinite: with K > 0, K − σB is
//! congruent to I − σA, whose eigenvalues are 1 − σ/σ_j. [`super::contour`] counts otherwise: the zeros σ of det(K − σB).

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::arnoldi::{Found, Search};
use super::contour::{self, Known};
use super::newton::ModeAtSpeed;
use crate::linalg::{CoupledFactors, DecompositionError, Krylov, Operator, Side, solve_complex};
use crate::modal::undamped::{Pins, null_motions};
use crate::model::{Model, Support, Weights};

/// The `count` speeds Ω nearest to zero at which an undamped mode has the frequency `order`·Ω > 0, by ascending |Ω|; `None` if the model has
/// fewer, or they cannot be told apart.
///
/// # Errors
/// [`DecompositionError`] if a linear system has no accurate solution, or an eigenvalue iteration fails.
pub fn lowest_critical(
    model: &Model,
    order: f64,
    count: usize,
) -> Result<Option<Vec<ModeAtSpeed>>, DecompositionError> {
    let inverse = CriticalInverse::new(model, order)?;
    let search = Search {
        count,
        is_wanted: &|value| value.im > 0.0,
        missing: &|found, radius| inverse.missing(found, radius * radius),
    };
    let found = search.run(Krylov::new(&inverse, []), |value| Some((-1.0 / value).sqrt()))?;
    Ok(found.map(|spectrum| {
        let modes = spectrum.wanted(count).map(|found| inverse.mode(spectrum.space.vector(&found.pair)));
        let mut modes: Vec<_> = modes.collect();
        modes.sort_by(|a, b| a.speed.abs().total_cmp(&b.speed.abs()));
        modes
    }))
}

/// K⁻¹B on the vectors with NᴴBx = 0.
struct CriticalInverse<'m> {
    model: &'m Model,
    /// Order, whose sign is the sense of rotation and determines the flanks in contact.
    order: f64,
    /// Factors of K with springs on the null motions.
    factors: CoupledFactors,
    /// N, n × r.
    null: DMatrix<Complex64>,
    /// B N (NᴴBN)⁻¹, n × r.
    weighted: DMatrix<Complex64>,
    /// Number of positive eigenvalues of NᴴBN.
    positive_null: usize,
}

impl<'m> CriticalInverse<'m> {
    fn new(model: &'m Model, order: f64) -> Result<Self, DecompositionError> {
        let null = null_motions(model, order)?;
        let pins = Pins::new(model, &null);
        let mut matrix = model.dynamic_stiffness(&weights(Complex64::ZERO, order), order);
        pins.add_to(model, &mut matrix);
        let factors = matrix.factor(1.0)?;
        let null = null.map(Complex::from);
        let weighted = DMatrix::zeros(model.len(), null.ncols());
        let mut inverse = Self { model, order, factors, weighted, null, positive_null: 0 };
        if inverse.null.ncols() > 0 {
            let images: Vec<_> =
                inverse.null.column_iter().map(|column| inverse.inertia(&column.into_owned())).collect();
            let images = DMatrix::from_columns(&images);
            let small = inverse.null.adjoint() * &images;
            // (B N) (NᴴBN)⁻¹; NᴴBN is Hermitian.
            inverse.weighted = solve_complex(&small, &images.adjoint()).adjoint();
            inverse.positive_null = small.symmetric_eigenvalues().iter().filter(|value| **value > 0.0).count();
        }
        Ok(inverse)
    }

    /// B x.
    fn inertia(&self, x: &DVector<Complex64>) -> DVector<Complex64> {
        let mass = self.model.product(x, |x, out| self.model.multiply_mass(x, out));
        let gyroscopic = self.model.product(x, |x, out| self.model.multiply_gyroscopic(x, out));
        mass - gyroscopic * Complex64::new(0.0, 1.0 / self.order)
    }

    /// x − N (NᴴBN)⁻¹ NᴴBx.
    fn without_null(&self, x: &mut DVector<Complex64>) {
        let parts = self.weighted.ad_mul(&*x);
        *x -= &self.null * parts;
    }

    /// Number of eigenvalues σ = −λ² with |σ| < `limit`, rad²/s², that are missing in `found`; where K is positive semidefinite, of
    /// those with σ > 0.
    fn missing(&self, found: &[Found], limit: f64) -> Option<i64> {
        let values: Vec<Complex64> =
            found.iter().map(|found| Complex64::from(-(found.value * found.value).re)).collect();
        if is_semidefinite(self.model, self.order) {
            let matrix = self.model.dynamic_stiffness(&weights(Complex64::from(limit), self.order), self.order);
            let below = values.iter().filter(|value| (0.0..limit).contains(&value.re)).count();
            if let Some(negative) = matrix.negative_eigenvalues() {
                return Some(negative as i64 - (self.positive_null + below) as i64);
            }
        }
        let determinant = |sigma: Complex64| {
            let matrix = self.model.dynamic_stiffness(&weights(sigma, self.order), self.order);
            matrix.determinant(-1.0).ok()
        };
        contour::missing_in_disk(determinant, &Known { zeros: self.null.ncols(), values }, limit)
    }

    /// The critical speed of a vector, from its Rayleigh quotient.
    fn mode(&self, mut shape: DVector<Complex64>) -> ModeAtSpeed {
        self.without_null(&mut shape);
        let part = |part: fn(&Complex64) -> f64| {
            self.model
                .elastic_form(shape.map(|value| part(&value)).as_slice(), |mesh| self.model.sigma(mesh, self.order))
        };
        let elastic = part(|value| value.re) + part(|value| value.im);
        let frequency = (elastic / shape.dotc(&self.inertia(&shape)).re).sqrt();
        let size = self.model.complex_kinetic_form(&shape).sqrt();
        ModeAtSpeed {
            speed: frequency / self.order,
            eigenvalue: Complex64::new(0.0, frequency),
            shape: shape.unscale(size),
        }
    }
}

/// Weights of K − σB, with the symmetric part of the bearing stiffness.
fn weights(sigma: Complex64, order: f64) -> Weights {
    Weights {
        structural: None,
        stiffness: Complex64::ONE,
        damping: Complex64::ZERO,
        mass: -sigma,
        gyroscopic: sigma * Complex64::new(0.0, 1.0 / order),
        symmetric: true,
    }
}

impl Operator for CriticalInverse<'_> {
    type Scalar = Complex64;
    const SYMMETRIC: bool = true;

    fn size(&self) -> usize {
        self.model.len()
    }

    fn apply(&self, x: &[Complex64]) -> Result<Vec<Complex64>, DecompositionError> {
        let mut x = DVector::from_column_slice(x);
        self.without_null(&mut x);
        let force = self.inertia(&x);
        let (mut image, _) = self.model.solve(&self.factors, Side::Right, Some(0.0), force.as_slice())?;
        self.without_null(&mut image);
        Ok(image.as_slice().to_vec())
    }

    fn weigh(&self, x: &[Complex64]) -> Vec<Complex64> {
        let x = DVector::from_column_slice(x);
        self.model.product(&x, |x, out| self.model.multiply_stiffness(self.order, true, x, out)).as_slice().to_vec()
    }
}

/// Whether the symmetric part of the stiffness of every bearing, link and connection is positive semidefinite.
fn is_semidefinite(model: &Model, speed: f64) -> bool {
    let is_stable = |local: &Support| {
        let [[a, b], [_, d]] = local.symmetric_part;
        a >= 0.0 && d >= 0.0 && a * d >= b * b
    };
    let mut connections = model.connections(speed).map(|connection| connection.linear(speed).stiffness);
    model.local_elements().all(is_stable)
        && connections.all(|stiffness| (&stiffness + stiffness.transpose()).symmetric_eigenvalues().min() >= 0.0)
}
