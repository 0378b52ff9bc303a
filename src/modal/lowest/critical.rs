//! The lowest undamped critical speeds, in time proportional to n.
//!
//! An undamped mode with λ = iω, ω = order·Ω, satisfies K x = −λ² B x with B = M − iG/order. The operator K⁻¹B is Hermitian in
//! the inner product xᴴKy; its eigenvalues −1/λ² of largest magnitude belong to the lowest critical speeds ([`super::arnoldi`]),
//! or to real λ, which are none. Null motions N have no stiffness: every x satisfies NᴴBx = 0, and springs ([`Pins`]) make K
//! regular.
//!
//! The inertia of K − σB counts the critical speeds with 0 < ω² < σ where K is positive semidefinite: with K > 0, K − σB is
//! congruent to I − σA, whose eigenvalues are 1 − σ/σ_j. [`super::contour`] counts otherwise: the zeros σ of det(K − σB).

use std::cell::OnceCell;

use nalgebra::{Cholesky, Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::arnoldi::{GAP, Search, Spectrum, first_steps, further_steps, most_steps};
use super::contour::{self, Known};
use super::newton::ModeAtSpeed;
use crate::connection::Row;
use crate::linalg::{
    CoupledFactors, DecompositionError, Krylov, MAX_BACKWARD_ERROR, Operator, Side, hermitian_eigen, solve_complex,
};
use crate::modal::undamped::{Pins, null_motions};
use crate::model::{Model, Support, Weights};

/// Largest ratio of the steps of a space for all stiffnesses to those for one of them. Most machines need less than twice as many; beyond
/// it, searches of their own are as cheap.
const MAX_GROWTH: usize = 3;

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
    Ok(inverse.search(Krylov::new(&inverse, []), count)?.map(|spectrum| inverse.lowest(&spectrum, count)))
}

/// A space of displacements for the critical speeds of models that differ in the stiffness of their bearings.
///
/// It is the Krylov space of K⁻¹B of one of the models, whose start vectors contain the displacements K⁻¹e by unit forces e of the
/// bearings. The modes of another model satisfy x = −(K − ω²B)⁻¹ΔK x, and the space contains the moments of this response
/// (Grimme 1997, Krylov projection methods for model reduction). Its basis V is orthonormal in K, so that VᴴKV + VᴴΔKV and
/// VᴴBV cost a few operations at each further stiffness.
pub struct CriticalSpace<'a, 'm> {
    space: Krylov<'a, CriticalInverse<'m>>,
    /// Largest number of steps.
    most: usize,
}

impl<'a, 'm> CriticalSpace<'a, 'm> {
    /// The space of a model for others whose stiffness differs at the bearings where that of `other` does, with the `count` lowest modes
    /// of the model; `None` if it has fewer, they cannot be told apart, or the bearings alone would fill the space.
    ///
    /// # Errors
    /// [`DecompositionError`] if a linear system has no accurate solution, or an eigenvalue iteration fails.
    pub fn new(
        inverse: &'a CriticalInverse<'m>,
        other: &Model,
        count: usize,
    ) -> Result<Option<(Self, Vec<ModeAtSpeed>)>, DecompositionError> {
        let changes = StiffnessChange::all(inverse.model, other);
        let loads: Vec<&Row> = changes.iter().flat_map(|change| &change.rows).collect();
        if loads.len() > first_steps::<CriticalInverse<'m>>(count) {
            return Ok(None);
        }
        let mut space = Krylov::new(inverse, []);
        for load in loads {
            let mut force = vec![Complex64::ZERO; other.len()];
            load.iter().for_each(|(index, coefficient)| force[*index] += Complex64::from(*coefficient));
            space.add_vector(inverse.displacement(&force)?);
        }
        let found = inverse.search(space, count)?;
        Ok(found.map(|spectrum| {
            let modes = inverse.lowest(&spectrum, count);
            (Self { most: MAX_GROWTH * spectrum.space.steps(), space: spectrum.space }, modes)
        }))
    }

    /// Extends the space, unless it is large already.
    ///
    /// # Errors
    /// [`DecompositionError`] if a linear system has no accurate solution.
    pub fn extend(&mut self) -> Result<bool, DecompositionError> {
        let before = self.space.steps();
        let target = (before + further_steps(before)).min(self.most);
        while self.space.steps() < target && !self.space.is_complete() {
            self.space.step()?;
        }
        Ok(self.space.steps() > before)
    }

    /// Approximations of the `count` lowest modes of another model, by ascending speed; `None` if the space has fewer.
    ///
    /// # Errors
    /// [`DecompositionError`] if an eigenvalue iteration fails.
    pub fn modes(&self, other: &Model, count: usize) -> Result<Option<Vec<ReducedMode>>, DecompositionError> {
        let mut stiffness = DMatrix::identity(self.space.steps(), self.space.steps());
        add_stiffness_change([self.space.operator().model, other], self.space.basis(), &mut stiffness);
        Ok(reduced_modes(stiffness, &self.space.projected(), count)?.filter(|modes| modes.len() == count))
    }

    /// The mode of another model with these coordinates.
    pub fn mode(&self, other: &CriticalInverse<'_>, reduced: &ReducedMode) -> ModeAtSpeed {
        other.mode(self.space.combination(reduced.coordinates.as_slice(), other.model.len()).into())
    }
}

/// Symmetric part of the stiffness of a bearing in one model less that in another one.
struct StiffnessChange {
    /// Scalars of the displacements over which the bearing acts.
    rows: Vec<Row>,
    /// Change over these scalars.
    stiffness: [[f64; 2]; 2],
}

impl StiffnessChange {
    /// The changes from one model to another one with the same elements, where there are any.
    fn all(from: &Model, to: &Model) -> Vec<Self> {
        let change = |from: &Support, to: &Support| {
            let (from, to) = (from.symmetric_part, to.symmetric_part);
            let stiffness =
                std::array::from_fn(|row| std::array::from_fn(|column| to[row][column] - from[row][column]));
            (from != to).then_some(stiffness)
        };
        let supports = from.supports.iter().zip(&to.supports).filter_map(|(from, to)| {
            let rows = [from.index, from.index + 1].map(|index| vec![(index, 1.0)]).to_vec();
            Some(Self { rows, stiffness: change(from, to)? })
        });
        let links = from.links.iter().zip(&to.links).filter_map(|(from, to)| {
            Some(Self { rows: from.rows.clone(), stiffness: change(&from.local, &to.local)? })
        });
        supports.chain(links).collect()
    }
}

/// Adds VᴴΔKV to a matrix, for the change ΔK of the symmetric part of the bearing stiffness from one model to another one with the
/// same elements, and the columns V of n entries each, of which there may be more than the matrix has.
pub fn add_stiffness_change([from, to]: [&Model; 2], columns: &[Complex64], sum: &mut DMatrix<Complex64>) {
    let (size, count) = (to.len(), sum.ncols());
    for StiffnessChange { rows, stiffness } in StiffnessChange::all(from, to) {
        let deflections = |row: &Row| {
            let of = |vector: usize| row.iter().map(|(index, part)| columns[vector * size + index] * *part).sum();
            DVector::from_fn(count, |vector, _| -> Complex64 { of(vector) }).conjugate()
        };
        let rows: Vec<_> = rows.iter().map(deflections).collect();
        for (left, change) in rows.iter().zip(stiffness) {
            for (right, change) in rows.iter().zip(change) {
                sum.gerc(Complex64::from(change), left, right, Complex64::ONE);
            }
        }
    }
}

/// A mode of K y = ω²B y.
pub struct ReducedMode {
    /// ω, rad/s.
    pub frequency: f64,
    /// y, with yᴴKy = ω².
    pub coordinates: DVector<Complex64>,
}

/// The `count` lowest modes of K y = ω²B y by ascending frequency; `None` if K is not positive definite.
///
/// # Errors
/// [`DecompositionError`] if the eigenvalue iteration fails.
pub fn reduced_modes(
    stiffness: DMatrix<Complex64>,
    inertia: &DMatrix<Complex64>,
    count: usize,
) -> Result<Option<Vec<ReducedMode>>, DecompositionError> {
    let Some(factor) = Cholesky::new(stiffness) else { return Ok(None) };
    let lower = factor.l();
    let half = lower.solve_lower_triangular(inertia);
    let Some(standard) = half.and_then(|half| lower.solve_lower_triangular(&half.adjoint())) else {
        return Ok(None);
    };
    let (values, vectors) = hermitian_eigen(&standard)?;
    // Descending 1/ω² is ascending ω.
    let positive = (0..values.len()).rev().filter(|index| values[*index] > 0.0).take(count);
    let mode = |index: usize| {
        let root = values[index].sqrt();
        let coordinates = lower.ad_solve_lower_triangular(&vectors.column(index))? / Complex64::from(root);
        Some(ReducedMode { frequency: root.recip(), coordinates })
    };
    Ok(Some(positive.map_while(mode).collect()))
}

/// Modes by ascending |Ω|.
fn sorted(mut modes: Vec<ModeAtSpeed>) -> Vec<ModeAtSpeed> {
    modes.sort_by(|a, b| a.speed.abs().total_cmp(&b.speed.abs()));
    modes
}

/// K⁻¹B on the vectors with NᴴBx = 0.
pub struct CriticalInverse<'m> {
    model: &'m Model,
    /// Order, whose sign is the sense of rotation and determines the flanks in contact.
    order: f64,
    /// Springs on the null motions.
    pins: Pins,
    /// Factors of K with these springs.
    factors: OnceCell<CoupledFactors>,
    /// N, n × r.
    null: DMatrix<Complex64>,
    /// B N (NᴴBN)⁻¹, n × r.
    weighted: DMatrix<Complex64>,
    /// Number of positive eigenvalues of NᴴBN.
    positive_null: usize,
}

impl<'m> CriticalInverse<'m> {
    /// The operator of a model whose undamped modes have the frequency `order`·Ω.
    ///
    /// # Errors
    /// [`DecompositionError`] if the null motions cannot be found.
    pub fn new(model: &'m Model, order: f64) -> Result<Self, DecompositionError> {
        let null = null_motions(model, order)?;
        let pins = Pins::new(model, &null);
        let null = null.map(Complex::from);
        let weighted = DMatrix::zeros(model.len(), null.ncols());
        let mut inverse = Self { model, order, pins, factors: OnceCell::new(), weighted, null, positive_null: 0 };
        if inverse.null.ncols() > 0 {
            let inertia_of_null: Vec<_> =
                inverse.null.column_iter().map(|column| inverse.inertia(&column.into_owned())).collect();
            let inertia_of_null = DMatrix::from_columns(&inertia_of_null);
            let small = inverse.null.adjoint() * &inertia_of_null;
            // (B N) (NᴴBN)⁻¹; NᴴBN is Hermitian.
            inverse.weighted = solve_complex(&small, &inertia_of_null.adjoint()).adjoint();
            inverse.positive_null = small.symmetric_eigenvalues().iter().filter(|value| **value > 0.0).count();
        }
        Ok(inverse)
    }

    fn factors(&self) -> Result<&CoupledFactors, DecompositionError> {
        if let Some(known) = self.factors.get() {
            return Ok(known);
        }
        let mut matrix = self.model.dynamic_stiffness(&weights(Complex64::ZERO, self.order), self.order);
        self.pins.add_to(self.model, &mut matrix);
        let factors = matrix.factor()?;
        Ok(self.factors.get_or_init(|| factors))
    }

    /// Extends `space` until it contains the `count` lowest modes; `None` if the model has fewer, or they cannot be told apart.
    fn search<'a>(
        &'a self,
        space: Krylov<'a, Self>,
        count: usize,
    ) -> Result<Option<Spectrum<'a, Self>>, DecompositionError> {
        let search = Search {
            count,
            takes_further: false,
            most_steps: most_steps::<Self>(count),
            is_wanted: &|value| value.im > 0.0,
            is_enough: &|found| found.len() >= count,
            missing: &|known, radius| self.missing(known, radius * radius),
        };
        search.run(space, |value| Some((-1.0 / value).sqrt()))
    }

    /// The `count` lowest modes of a search, by ascending |Ω|.
    fn lowest(&self, spectrum: &Spectrum<'_, Self>, count: usize) -> Vec<ModeAtSpeed> {
        let modes = spectrum.wanted(count).map(|found| self.mode(spectrum.space.vector(&found.pair)));
        sorted(modes.collect())
    }

    /// B x.
    fn inertia(&self, x: &DVector<Complex64>) -> DVector<Complex64> {
        let mass = self.model.product(x, |x, out| self.model.multiply_mass(x, out));
        let gyroscopic = self.model.product(x, |x, out| self.model.multiply_gyroscopic(x, out));
        mass - gyroscopic * Complex64::new(0.0, 1.0 / self.order)
    }

    /// The displacement K⁻¹f by a force f, with NᴴBx = 0.
    fn displacement(&self, force: &[Complex64]) -> Result<Vec<Complex64>, DecompositionError> {
        let (mut image, _) = self.model.solve(self.factors()?, Side::Right, Some(MAX_BACKWARD_ERROR), force)?;
        self.without_null(&mut image);
        Ok(image.as_slice().to_vec())
    }

    /// x − N (NᴴBN)⁻¹ NᴴBx.
    fn without_null(&self, x: &mut DVector<Complex64>) {
        let parts = self.weighted.ad_mul(&*x);
        *x -= &self.null * parts;
    }

    /// Whether the `count` lowest of `modes`, by ascending frequency, are those of the model: none of them is missing.
    pub fn are_lowest(&self, modes: &[ReducedMode], count: usize) -> bool {
        let frequency = |index: usize| modes[index].frequency;
        let gap = (count.max(1)..modes.len()).find(|index| frequency(*index) > (1.0 + GAP) * frequency(index - 1));
        let Some(gap) = gap.filter(|_| is_semidefinite(self.model, self.order)) else { return false };
        let values: Vec<_> = modes[..gap].iter().map(|mode| Complex64::new(0.0, mode.frequency)).collect();
        self.missing(&values, f64::midpoint(frequency(gap - 1), frequency(gap)).powi(2)) == Some(0)
    }

    /// Number of eigenvalues σ = −λ² with |σ| < `limit`, rad²/s², that are missing in those of `found`, λ in rad/s; where K is positive
    /// semidefinite, of those with σ > 0.
    fn missing(&self, found: &[Complex64], limit: f64) -> Option<i64> {
        let values: Vec<Complex64> = found.iter().map(|value| Complex64::from(-(value * value).re)).collect();
        if is_semidefinite(self.model, self.order) {
            let matrix = self.model.dynamic_stiffness(&weights(Complex64::from(limit), self.order), self.order);
            let below = values.iter().filter(|value| (0.0..limit).contains(&value.re)).count();
            if let Some(negative) = matrix.negative_eigenvalues() {
                return Some(negative as i64 - (self.positive_null + below) as i64);
            }
        }
        let determinant = |sigma: Complex64| {
            let matrix = self.model.dynamic_stiffness(&weights(sigma, self.order), self.order);
            matrix.determinant().ok()
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
        self.displacement(self.inertia(&x).as_slice())
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
