//! The lowest undamped critical speeds, in time proportional to n: Lanczos method with a count.
//!
//! An undamped mode with the frequency ω = order·Ω satisfies K x = ω² B x with B = M − iG/order. The operator K⁻¹B is
//! Hermitian in the inner product xᴴKy; its largest eigenvalues 1/ω² belong to the lowest critical speeds. Null motions N
//! have no stiffness: every x satisfies NᴴBx = 0, and springs ([`Pins`]) make K regular.
//!
//! The inertia of K − σB counts the critical speeds with 0 < σ < ω² where K is positive semidefinite: with K > 0, K − σB is
//! congruent to I − σA, whose eigenvalues are 1 − σ/σ_j. [`super::contour`] counts them otherwise: the zeros of det(K − σB).

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::contour::{self, Contour, Known};
use super::intersection::ModeAtSpeed;
use crate::linalg::{CoupledFactors, DecompositionError, Krylov, Operator, RitzPair, solve_complex};
use crate::modal::undamped::{Pins, null_motions};
use crate::model::{Model, Support, Weights};

/// Speed of the reference shaft at which critical speeds have their loaded flanks and, where no table has another lowest speed, the
/// equilibrium of rolling bearings, rad/s: both depend on the direction of rotation only.
pub const FORWARD: f64 = 1.0;
/// Relative residual of an accurate mode, and of one that is recognised.
const ACCURATE: f64 = 1e-12;
const RECOGNISED: f64 = 1e-7;
/// Smallest relative distance of two values of σ between which the count ends.
const GAP: f64 = 1e-4;
/// The count begins at this fraction of the lowest σ: the Lanczos method finds every lower one first.
const LOWEST: f64 = 1e-2;
/// Number of times that start vectors are added for missing modes.
const MAX_RESTARTS: usize = 4;

/// The `count` lowest speeds Ω > 0 at which an undamped mode has the frequency `order`·Ω, ascending; `None` if the model has
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
    let mut space = Krylov::new(&inverse, []);
    // Forward and backward modes, or equal shafts, may have equal critical speeds.
    for _ in 0..2 {
        space.add_start()?;
    }
    let mut target = 3 * count + 20;
    let most = 6 * target + 60;
    let mut restarts = 0;
    loop {
        while space.steps() < target && !space.is_complete() {
            space.step()?;
        }
        let mut found: Vec<RitzPair> = space.ritz_pairs()?;
        found.retain(|pair| pair.value.re > 0.0 && pair.residual <= RECOGNISED);
        found.sort_by(|a, b| b.value.re.total_cmp(&a.value.re));
        let steps = space.steps();
        let Some((number, limit)) = boundary(&found, count) else {
            if space.is_complete() || steps >= most {
                return Ok(None);
            }
            target = steps + (steps / 4).max(8);
            continue;
        };
        match inverse.missing(&found, limit) {
            Some(0) => {
                let mut modes: Vec<_> = found[..number].iter().map(|pair| inverse.mode(space.vector(pair))).collect();
                modes.sort_by(|a, b| a.speed.total_cmp(&b.speed));
                modes.truncate(count);
                return Ok(Some(modes));
            }
            Some(missing) if missing > 0 && restarts < MAX_RESTARTS => {
                restarts += 1;
                space.add_start()?;
                space.add_start()?;
                target = steps + 2 * count + 20;
            }
            _ => return Ok(None),
        }
    }
}

/// Number of accurate values, at least `count`, up to a gap, and σ within this gap.
fn boundary(found: &[RitzPair], count: usize) -> Option<(usize, f64)> {
    let accurate = found.iter().take_while(|pair| pair.residual <= ACCURATE).count();
    (count.max(1)..accurate).find_map(|number| {
        let (below, above) = (1.0 / found[number - 1].value.re, 1.0 / found[number].value.re);
        (above > (1.0 + GAP) * below).then(|| (number, f64::midpoint(below, above)))
    })
}

/// K⁻¹B on the vectors with NᴴBx = 0.
struct CriticalInverse<'m> {
    model: &'m Model,
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
        let null = null_motions(model, FORWARD)?;
        let pins = Pins::new(model, &null);
        let mut matrix = model.dynamic_stiffness(&weights(Complex64::ZERO, order), FORWARD);
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

    /// Number of critical speeds with σ < `limit` that are not found.
    fn missing(&self, found: &[RitzPair], limit: f64) -> Option<i64> {
        if is_semidefinite(self.model, FORWARD) {
            let matrix = self.model.dynamic_stiffness(&weights(Complex64::from(limit), self.order), FORWARD);
            let known = self.positive_null + found.iter().filter(|pair| 1.0 / pair.value.re < limit).count();
            if let Some(negative) = matrix.negative_eigenvalues() {
                return Some(negative as i64 - known as i64);
            }
        }
        let values: Vec<Complex64> = found.iter().map(|pair| 1.0 / Complex64::from(pair.value.re)).collect();
        let lowest = LOWEST * values.first().map_or(limit, |value| value.re);
        let at = |size: f64, angle: f64| Complex64::new(size.ln(), angle);
        let quarter = std::f64::consts::FRAC_PI_2;
        let contour = Contour(vec![at(limit, 0.0), at(limit, quarter), at(lowest, quarter), at(lowest, 0.0)]);
        let determinant = |sigma: Complex64| {
            let matrix = self.model.dynamic_stiffness(&weights(sigma, self.order), FORWARD);
            matrix.determinant(-1.0).ok()
        };
        contour::missing(determinant, &Known { zeros: 0, values }, &contour)
    }

    /// The critical speed of a vector, from its Rayleigh quotient.
    fn mode(&self, mut shape: DVector<Complex64>) -> ModeAtSpeed {
        self.without_null(&mut shape);
        let part = |part: fn(&Complex64) -> f64| {
            self.model.elastic_form(shape.map(|value| part(&value)).as_slice(), |mesh| self.model.sigma(mesh, FORWARD))
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
        let mut image = self.model.to_circular(self.inertia(&x).as_slice());
        self.factors.solve(&mut image)?;
        let mut image = DVector::from_vec(self.model.from_circular(&image));
        self.without_null(&mut image);
        Ok(image.as_slice().to_vec())
    }

    fn weigh(&self, x: &[Complex64]) -> Vec<Complex64> {
        let x = DVector::from_column_slice(x);
        self.model.product(&x, |x, out| self.model.multiply_stiffness(FORWARD, true, x, out)).as_slice().to_vec()
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
