//! The lowest modes of a large model, in time proportional to n: shift-invert Arnoldi method with a count.
//!
//! A Krylov space of the inverse at a small shift ([`super::shift_invert`]) finds the eigenvalues of smallest magnitude.
//! Rigid-body modes are known and left out of the space.
//!
//! An Arnoldi method may miss one of several equal eigenvalues. [`super::contour`] therefore counts the eigenvalues in a disk
//! |λ| < R that contains the wanted ones. As long as one is missing, the space is extended.

use nalgebra::{Complex, DVector};
use num_complex::Complex64;

use super::selection::{ModeSelection, ascending};
use super::shift_invert::{Eigenpair, FirstOrderInverse, Inverse, Problem};
use crate::linalg::{DecompositionError, Krylov, RitzPair, matrix_of_columns};
use crate::modal::undamped::{RealModes, ShiftInverse};

/// Relative residual of an accurate mode.
const ACCURATE: f64 = 1e-12;
/// Relative residual below which an approximation is used to count the eigenvalues.
const RECOGNISED: f64 = 1e-7;
/// Smallest relative distance of two magnitudes between which the radius of the count lies.
const GAP: f64 = 1e-4;
/// Largest ratio of two magnitudes between which the radius of the count lies, if the larger one is an estimate.
const FURTHEST: f64 = 1.5;
/// An imaginary part below this fraction of an eigenvalue is round-off.
const REAL: f64 = 1e-11;
/// An eigenvalue below this fraction of the shift is the velocity of a rigid-body mode.
const ZERO: f64 = 1e-7;
/// Number of times that the space is extended for missing eigenvalues.
const MAX_RESTARTS: usize = 6;

/// The `count` lowest modes of a problem, or the `count` lowest vibrations; `None` if too many other motions have to be told apart
/// from them.
///
/// # Errors
/// [`DecompositionError`] if a linear system has no accurate solution, or an eigenvalue iteration fails.
pub fn lowest(
    problem: &Problem<'_>,
    count: usize,
    selection: ModeSelection,
) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let elastic = match selection {
        ModeSelection::All => count.saturating_sub(problem.null.ncols()),
        ModeSelection::Vibrations => count,
    };
    if problem.undamped {
        let locked = problem.null.column_iter().map(|column| column.iter().copied().collect()).collect();
        let operator = ShiftInverse::new(problem.model, problem.speed, problem.shift)?;
        return Search { problem, count, elastic, locked, selection }.run(&operator);
    }
    let locked = problem.rigid_states().collect();
    Search { problem, count, elastic, locked, selection }.run(&FirstOrderInverse::new(problem)?)
}

/// The `count` lowest modes of an undamped problem.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub(in crate::modal) fn undamped_modes(
    problem: &Problem<'_>,
    count: usize,
) -> Result<Option<RealModes>, DecompositionError> {
    let Some(pairs) = lowest(problem, count, ModeSelection::All)? else {
        return Ok(None);
    };
    let columns: Vec<DVector<f64>> = pairs.iter().map(|pair| pair.shape.map(|value| value.re)).collect();
    let vectors = matrix_of_columns(problem.model.len(), &columns);
    Ok(Some(RealModes::of_shapes(problem.model, problem.speed, vectors, problem.null.ncols())))
}

/// An approximation of an eigenvalue.
struct Found {
    /// λ with Im λ ≥ 0, rad/s.
    value: Complex64,
    /// The vector, with its relative residual.
    pair: RitzPair,
}

impl Found {
    fn is_accurate(&self) -> bool {
        self.pair.residual <= ACCURATE
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
    selection: ModeSelection,
}

impl Search<'_, '_> {
    /// Extends the Krylov space of `operator` until the lowest modes are accurate and none is missing.
    fn run<T: Inverse>(&self, operator: &T) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
        let mut space = Krylov::new(operator, self.locked.iter().cloned());
        let per_mode = if self.problem.undamped { 1 } else { 2 };
        // Most models need as many steps; decompositions of the projected matrix are as costly as steps.
        let mut target = 2 * per_mode * self.elastic + 24;
        let most = 6 * target + 30;
        // Two bending planes have equal modes at rest.
        for _ in 0..if self.problem.undamped { 2 } else { 1 } {
            space.add_start()?;
        }
        let mut restarts = 0;
        loop {
            while space.steps() < target && !space.is_complete() {
                space.step()?;
            }
            let (found, next) = self.recognised(&space)?;
            let steps = space.steps();
            let Some(radius) = self.radius(&found, next) else {
                if space.is_complete() || steps >= most {
                    return Ok(None);
                }
                target = steps + (steps / 8).max(8);
                continue;
            };
            if self.problem.missing_in_disk(found.iter().map(|found| found.value), radius) == Some(0) {
                return Ok(Some(self.eigenpairs(&space, &found)));
            }
            if restarts == MAX_RESTARTS {
                return Ok(None);
            }
            restarts += 1;
            // Further start vectors find further vectors of equal eigenvalues.
            space.add_start()?;
            space.add_start()?;
            target = steps + per_mode * self.elastic + 20;
        }
    }

    /// Approximations of eigenvalues λ with Im λ ≥ 0 apart from rigid-body modes, in ascending order of |λ|, and the
    /// magnitude of the next approximation, rad/s, which is less accurate.
    fn recognised<T: Inverse>(&self, space: &Krylov<'_, T>) -> Result<(Vec<Found>, f64), DecompositionError> {
        let is_elastic = |value: &Complex64| self.problem.null.ncols() == 0 || value.norm() > ZERO * self.problem.shift;
        let found = |pair: RitzPair| Found { value: without_round_off(space.operator().eigenvalue(pair.value)), pair };
        let mut all: Vec<Found> = space.ritz_pairs()?.into_iter().map(found).collect();
        all.retain(|found| found.value.im >= 0.0 && is_elastic(&found.value));
        all.sort_by(|a, b| ascending(a.value, b.value));
        let last = all.iter().rposition(|found| found.pair.residual <= RECOGNISED).map_or(0, |last| last + 1);
        let next = all.get(last).map_or(f64::INFINITY, |next| next.value.norm());
        all.truncate(last);
        all.retain(|found| found.pair.residual <= RECOGNISED);
        Ok((all, next))
    }

    /// Radius in a gap of the magnitudes, rad/s, so that the found modes below it are enough and accurate; `next` is an estimate
    /// of the magnitude that follows the found ones, rad/s.
    fn radius(&self, found: &[Found], next: f64) -> Option<f64> {
        let mut wanted = 0;
        for (index, pair) in found.iter().enumerate() {
            if !pair.is_accurate() {
                return None;
            }
            wanted += usize::from(self.is_wanted(pair.value));
            let size = pair.value.norm();
            let following = found.get(index + 1).map_or(next.min(FURTHEST * size), |following| following.value.norm());
            if wanted >= self.elastic && following > (1.0 + GAP) * size {
                return Some(f64::midpoint(size, following));
            }
        }
        None
    }

    fn is_wanted(&self, value: Complex64) -> bool {
        self.selection.contains(self.problem.model, self.problem.speed, value)
    }

    /// Rigid-body modes, and the lowest wanted ones of the found modes.
    fn eigenpairs<T: Inverse>(&self, space: &Krylov<'_, T>, found: &[Found]) -> Vec<Eigenpair> {
        let problem = self.problem;
        let mut chosen: Vec<&Found> =
            found.iter().filter(|found| self.is_wanted(found.value)).take(self.elastic).collect();
        let pairs: Vec<Eigenpair> = if problem.undamped {
            // All approximations of one frequency are rotated together.
            let highest = chosen.last().map_or(0.0, |last| (1.0 + GAP) * last.value.im);
            chosen = found.iter().take_while(|found| found.value.im <= highest).collect();
            let columns: Vec<_> =
                chosen.iter().map(|found| self.shape_of(space, &found.pair).map(|entry| entry.re)).collect();
            let vectors = matrix_of_columns(problem.model.len(), &columns);
            let real = RealModes::of_shapes(problem.model, problem.speed, vectors, 0);
            let shapes = real.vectors.column_iter().map(|column| column.map(Complex::from));
            let values = real.frequencies.iter().map(|frequency| Complex64::new(0.0, *frequency));
            values.zip(shapes).map(|(value, shape)| Eigenpair { value, shape }).collect()
        } else {
            let pair = |found: &&Found| {
                let shape = self.shape_of(space, &found.pair);
                let size = problem.model.complex_kinetic_form(&shape).sqrt();
                let shape = shape.unscale(size);
                let value = without_round_off(problem.rayleigh(found.value, &shape));
                // A real eigenvalue has no sign of zero, which would count in the order.
                Eigenpair { value: Complex64::new(value.re, value.im.abs()), shape }
            };
            chosen.iter().map(pair).collect()
        };
        let rigid = problem.rigid_body_modes().filter(|_| self.selection == ModeSelection::All);
        Eigenpair::lowest(rigid.chain(pairs.into_iter().take(self.elastic)).collect(), self.count)
    }

    /// The mode shape of an approximation. The space of states (x, λx) leaves out the positions of rigid-body modes; the
    /// part of the shape in them follows from its velocity.
    fn shape_of<T: Inverse>(&self, space: &Krylov<'_, T>, pair: &RitzPair) -> DVector<Complex64> {
        let operator = space.operator();
        let size = operator.shape_size();
        if size == operator.size() || self.problem.null.ncols() == 0 {
            return space.first_entries(pair, size);
        }
        let (state, value) = (space.vector(pair), operator.eigenvalue(pair.value));
        let mut shape = state.rows(0, size).into_owned();
        let missing = state.rows(size, size) / value - &shape;
        self.problem.add_rigid_part(&missing, &mut shape);
        shape
    }
}

/// A real eigenvalue for one whose imaginary part is round-off: it splits two equal real eigenvalues into a conjugate pair,
/// of which both count.
fn without_round_off(value: Complex64) -> Complex64 {
    if value.im.abs() <= REAL * value.norm() { Complex64::from(value.re) } else { value }
}
