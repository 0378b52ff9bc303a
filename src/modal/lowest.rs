//! The damped modes of lowest frequency, in time proportional to n: shift-invert Arnoldi method with a count.
//!
//! A Krylov space of the inverse at a small shift ([`super::shift_invert`]) finds the eigenvalues of smallest magnitude.
//! Rigid-body modes are known and left out of the space.
//!
//! An Arnoldi method may miss one of several equal eigenvalues. [`super::contour`] counts the eigenvalues with |λ| below a
//! radius R and those with a damping ratio above one half. As long as one with |λ| < R is missing, the space is extended. Every
//! other eigenvalue has |Im λ| > R sin 60°, so that all eigenvalues of lower frequency are known. Strongly damped eigenvalues
//! far from the origin are left to [`super::lowest_damped`].

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::CachedModel;
use super::contour::{Contour, SECTOR};
use super::real::RealModes;
use super::shift_invert::{FirstOrderInverse, Inverse, Problem};
use super::spectral_range::ShiftInverse;
use crate::linalg::{DecompositionError, Krylov, RitzPair};

/// Relative residual of an accurate mode.
const ACCURATE: f64 = 1e-12;
/// Relative residual below which an approximation is used to count the eigenvalues.
const RECOGNISED: f64 = 1e-7;
/// Smallest relative distance of two magnitudes between which the radius of the count lies.
const GAP: f64 = 1e-4;
/// An imaginary part below this fraction of an eigenvalue is round-off.
const REAL: f64 = 1e-11;
/// An eigenvalue below this fraction of the shift is the velocity of a rigid-body mode.
const ZERO: f64 = 1e-7;
/// Number of times that the spaces are extended for missing eigenvalues.
const MAX_RESTARTS: usize = 6;

/// Eigenvalue λ with Im λ ≥ 0, rad/s, and mode shape, n entries in the order of the core.
pub(super) type Eigenpair = (Complex64, DVector<Complex64>);

/// The `count` modes of lowest |Im λ| at `speed` of the reference shaft, rad/s, rigid-body modes first; `None` if too many
/// overdamped modes have to be told apart from them.
///
/// # Errors
/// [`DecompositionError`] if a linear system has no accurate solution, or an eigenvalue iteration fails.
pub(super) fn lowest(
    cached: &CachedModel,
    speed: f64,
    count: usize,
) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let model = &cached.model;
    let problem = Problem::new(model, speed, cached.spectral_range(speed)?)?;
    let elastic = count.saturating_sub(problem.null.ncols());
    if problem.undamped {
        return lowest_undamped(&problem, count);
    }
    let inverse = FirstOrderInverse::new(&problem, problem.shift)?;
    Search { problem: &problem, count, elastic, locked: problem.rigid_states().collect() }.run(&inverse)
}

/// The same for an undamped problem.
///
/// # Errors
/// As [`lowest`].
pub(super) fn lowest_undamped(
    problem: &Problem<'_>,
    count: usize,
) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let elastic = count.saturating_sub(problem.null.ncols());
    let inverse = ShiftInverse::new(problem.model, problem.speed, problem.shift)?;
    let locked = problem.null.column_iter().map(|column| column.iter().copied().collect());
    Search { problem, count, elastic, locked: locked.collect() }.run(&inverse)
}

/// An approximation of an eigenvalue.
struct Found {
    /// λ with Im λ ≥ 0, rad/s.
    value: Complex64,
    /// Relative residual in its Krylov space.
    residual: f64,
    /// Its vector in the space.
    pair: RitzPair,
}

impl Found {
    fn is_accurate(&self) -> bool {
        self.residual <= ACCURATE
    }
}

/// A search for modes.
struct Search<'p, 'm> {
    problem: &'p Problem<'m>,
    /// Number of modes.
    count: usize,
    /// Number of modes apart from rigid-body modes.
    elastic: usize,
    /// States of the rigid-body modes.
    locked: Vec<Vec<f64>>,
}

impl Search<'_, '_> {
    /// Extends a Krylov space until the lowest modes are accurate and none is missing.
    fn run<T: Inverse>(&self, inverse: &T) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
        let mut space = Krylov::new(inverse, self.locked.iter().cloned());
        let per_mode = if self.problem.undamped { 1 } else { 2 };
        // Most models need as many steps; decompositions of the projected matrix are as costly as steps.
        let mut target = 3 * per_mode * self.elastic + 28;
        let most = 4 * target + 60;
        // Two bending planes have equal modes at rest.
        for _ in 0..if self.problem.undamped { 2 } else { 1 } {
            space.add_start()?;
        }
        let mut restarts = 0;
        loop {
            while space.steps() < target && !space.is_complete() {
                space.step()?;
            }
            let found = self.recognised(&space)?;
            let steps = space.steps();
            let Some(radius) = self.radius(&found) else {
                if space.is_complete() || steps >= most {
                    return Ok(None);
                }
                target = steps + (steps / 8).max(8);
                continue;
            };
            let chosen = self.chosen(&found, radius);
            let is_accurate = chosen.iter().all(|found| found.is_accurate());
            if is_accurate && self.missing(&found, &self.problem.contour(radius)) == Some(0) {
                return Ok(Some(self.eigenpairs(&space, &found, &chosen)));
            }
            if restarts == MAX_RESTARTS || self.missing(&found, &Contour::of_disk(radius)) == Some(0) {
                return Ok(None);
            }
            restarts += 1;
            // Further start vectors find further vectors of equal eigenvalues.
            space.add_start()?;
            space.add_start()?;
            target = steps + per_mode * self.elastic + 20;
        }
    }

    /// Number of eigenvalues inside of a contour that are not found.
    fn missing(&self, found: &[Found], contour: &Contour) -> Option<i64> {
        self.problem.missing(found.iter().map(|found| found.value), contour)
    }

    /// Approximations of eigenvalues λ with Im λ ≥ 0 apart from rigid-body modes, in ascending order of |λ|.
    fn recognised<T: Inverse>(&self, space: &Krylov<'_, T>) -> Result<Vec<Found>, DecompositionError> {
        let is_elastic = |value: &Complex64| self.problem.null.ncols() == 0 || value.norm() > ZERO * self.problem.shift;
        let found = |pair: RitzPair| Found {
            value: without_round_off(space.operator().eigenvalue(pair.value)),
            residual: pair.residual,
            pair,
        };
        let mut all: Vec<Found> = space.ritz_pairs()?.into_iter().map(found).collect();
        all.retain(|found| found.residual <= RECOGNISED && found.value.im >= 0.0 && is_elastic(&found.value));
        all.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
        Ok(all)
    }

    /// Radius in a gap of the magnitudes, rad/s, so that the found modes of lower frequency are enough and all below it are
    /// accurate.
    fn radius(&self, found: &[Found]) -> Option<f64> {
        for (index, pair) in found.windows(2).enumerate() {
            if !pair[0].is_accurate() {
                return None;
            }
            let radius = f64::midpoint(pair[0].value.norm(), pair[1].value.norm());
            let is_gap = pair[1].value.norm() > (1.0 + GAP) * pair[0].value.norm();
            if is_gap && index + 1 >= self.elastic && self.below(found, radius).count() >= self.elastic {
                return Some(radius);
            }
        }
        None
    }

    /// Found modes of lower frequency than every mode outside of the count with a radius, rad/s.
    fn below<'f>(&self, found: &'f [Found], radius: f64) -> impl Iterator<Item = &'f Found> {
        let top = if self.problem.undamped { radius } else { radius * SECTOR.sin() };
        found.iter().filter(move |found| found.value.im < top)
    }

    /// The modes of lowest frequency.
    fn chosen<'f>(&self, found: &'f [Found], radius: f64) -> Vec<&'f Found> {
        let mut below: Vec<&Found> = self.below(found, radius).collect();
        below.sort_by(|a, b| a.value.im.total_cmp(&b.value.im).then(a.value.norm().total_cmp(&b.value.norm())));
        below.truncate(self.elastic);
        below
    }

    /// Rigid-body modes, and the chosen ones of the found modes.
    fn eigenpairs<T: Inverse>(&self, space: &Krylov<'_, T>, found: &[Found], chosen: &[&Found]) -> Vec<Eigenpair> {
        let problem = self.problem;
        let shape = |found: &Found| space.operator().shape(space.vector(&found.pair));
        let pairs: Vec<Eigenpair> = if problem.undamped {
            // All approximations of one frequency are rotated together.
            let highest = chosen.last().map_or(0.0, |last| (1.0 + GAP) * last.value.im);
            let together = found.iter().take_while(|found| found.value.im <= highest);
            let columns: Vec<_> = together.map(|found| shape(found).map(|entry| entry.re)).collect();
            let none = || DMatrix::zeros(problem.model.len(), 0);
            let vectors = if columns.is_empty() { none() } else { DMatrix::from_columns(&columns) };
            let real = RealModes::of_shapes(problem.model, problem.speed, vectors, 0);
            let shapes = real.vectors.column_iter().map(|column| column.map(Complex::from));
            real.frequencies.iter().map(|frequency| Complex64::new(0.0, *frequency)).zip(shapes).collect()
        } else {
            let pair = |found: &&Found| {
                let shape = shape(found);
                let size = problem.model.complex_kinetic_form(&shape).sqrt();
                let shape = shape.unscale(size);
                let value = without_round_off(problem.rayleigh(found.value, &shape));
                // A real eigenvalue has no sign of zero, which would count in the order.
                (Complex64::new(value.re, value.im.abs()), shape)
            };
            chosen.iter().map(pair).collect()
        };
        let rigid = problem.null.column_iter().map(|column| (Complex64::ZERO, column.map(Complex::from)));
        let mut all: Vec<Eigenpair> = rigid.chain(pairs.into_iter().take(self.elastic)).collect();
        all.sort_by(|(a, _), (b, _)| a.im.total_cmp(&b.im).then(a.norm().total_cmp(&b.norm())));
        all.truncate(self.count);
        all
    }
}

/// A real eigenvalue for one whose imaginary part is round-off: it splits two equal real eigenvalues into a conjugate pair,
/// of which both count.
fn without_round_off(value: Complex64) -> Complex64 {
    if value.im.abs() <= REAL * value.norm() { Complex64::from(value.re) } else { value }
}
