//! The lowest eigenvalues of a large model, in time proportional to n: shift-invert Arnoldi method with a count.
//!
//! A Krylov space of the inverse at a small shift ([`super::shift_invert`], [`super::critical`]) finds the eigenvalues of
//! smallest magnitude. Rigid-body modes are known and left out of the space.
//!
//! An Arnoldi method may miss one of several equal eigenvalues. The eigenvalues in a disk |λ| < R that contains the wanted ones
//! are therefore counted. As long as one is missing, the space is extended.

use nalgebra::Complex;
use num_complex::Complex64;

use super::selection::{ModeSelection, ascending};
use super::shift_invert::{Eigenpair, FirstOrderInverse, Problem};
use crate::linalg::{DecompositionError, Krylov, MAX_BACKWARD_ERROR, Operator, RitzPair, matrix_of_columns};
use crate::modal::undamped::{RealModes, ShiftInverse, UndampedInverse};
use crate::numerics::ROOT_OF_ROUND_OFF;

/// Relative residual of an accurate mode. The error of an eigenvalue is proportional to it, to its square for a symmetric operator.
const ACCURATE: f64 = 1e-12;
/// Relative residual below which an approximation is used to count the eigenvalues.
const RECOGNISED: f64 = 1e-7;
/// Smallest relative distance of two magnitudes between which the radius of the count lies: the modes of both planes of a shaft stay
/// together.
pub(super) const GAP: f64 = 1e-3;
/// Largest ratio of two magnitudes between which the radius of the count lies, if the larger one is an estimate.
const FURTHEST: f64 = 1.5;
/// An eigenvalue below this fraction of the shift is the velocity of a rigid-body mode.
const ZERO: f64 = 1e-7;
/// Smallest ratio to the radius of the count of a less accurate approximation that represents eigenvalues outside in it.
const OUTSIDE: f64 = 1.2;
/// Steps in which one more eigenvalue becomes accurate, where most have done so.
const STEPS_PER_EIGENVALUE: f64 = 1.25;
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
    let pairs = if problem.undamped {
        let most = most_steps::<UndampedInverse<'_>>(elastic);
        let found = elastic_modes(problem, elastic, most, false, &|found| found.len() >= elastic)?;
        found.map(|found| undamped_pairs(&found.modes))
    } else {
        let search = Search {
            count: elastic,
            takes_further: false,
            most_steps: most_steps::<FirstOrderInverse<'_, '_>>(elastic),
            is_wanted: &|value| selection.contains(problem.model, problem.speed, value),
            is_enough: &|found| found.len() >= elastic,
            missing: &|known, radius| problem.missing_in_disk(known, radius),
        };
        let operator = FirstOrderInverse::new(problem)?;
        let eigenvalue = |value: Complex64| elastic_value(problem, problem.shift + 1.0 / value);
        let found = search.run(Krylov::new(&operator, problem.rigid_states()), eigenvalue)?;
        found.map(|found| damped_modes(problem, &found, elastic))
    };
    let rigid = problem.rigid_body_modes().filter(|_| selection == ModeSelection::All);
    Ok(pairs.map(|pairs| Eigenpair::lowest(rigid.chain(pairs.into_iter().take(elastic)).collect(), count)))
}

/// Eigenvalues and shapes of undamped modes.
fn undamped_pairs(modes: &RealModes) -> Vec<Eigenpair> {
    let shapes = modes.vectors.column_iter().map(|column| column.map(Complex::from));
    let values = modes.frequencies.iter().map(|frequency| Complex64::new(0.0, *frequency));
    values.zip(shapes).map(|(value, shape)| Eigenpair { value, shape }).collect()
}

/// An eigenvalue that is not that of a rigid-body mode.
fn elastic_value(problem: &Problem<'_>, value: Complex64) -> Option<Complex64> {
    (problem.null.ncols() == 0 || value.norm() > ZERO * problem.shift).then_some(value)
}

/// Undamped modes of a model.
#[derive(Debug)]
pub struct UndampedSpace {
    /// The lowest ones, which may be followed by approximations in the Krylov space of their search.
    pub modes: RealModes,
    /// Highest frequency of an accurate mode, rad/s; no mode below it is missing.
    pub highest: f64,
}

/// The lowest modes of an undamped problem, about `count` of them, until `is_enough` holds for their frequencies, rad/s, rigid-body
/// modes included; `None` after this number of steps. `approximates` asks for all approximations of the space as well.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub(in crate::modal) fn undamped_modes(
    problem: &Problem<'_>,
    count: usize,
    most_steps: usize,
    approximates: bool,
    is_enough: impl Fn(&[f64]) -> bool,
) -> Result<Option<UndampedSpace>, DecompositionError> {
    let null = problem.null.ncols();
    let is_enough = |found: &[Complex64]| {
        let rigid = std::iter::repeat_n(0.0, null);
        is_enough(&rigid.chain(found.iter().map(|value| value.im)).collect::<Vec<_>>())
    };
    let Some(elastic) = elastic_modes(problem, count.saturating_sub(null), most_steps, approximates, &is_enough)?
    else {
        return Ok(None);
    };
    let rigid = problem.null.column_iter();
    let columns: Vec<_> = rigid.chain(elastic.modes.vectors.column_iter()).collect();
    let vectors = matrix_of_columns(problem.model.len(), &columns);
    let modes = RealModes::of_shapes(problem.model, problem.speed, vectors, null);
    Ok(Some(UndampedSpace { modes, ..elastic }))
}

/// The lowest elastic modes of an undamped problem, about `count` of them, until `is_enough` holds for their eigenvalues.
fn elastic_modes(
    problem: &Problem<'_>,
    count: usize,
    most_steps: usize,
    approximates: bool,
    is_enough: &dyn Fn(&[Complex64]) -> bool,
) -> Result<Option<UndampedSpace>, DecompositionError> {
    let search = Search {
        count,
        takes_further: true,
        most_steps,
        is_wanted: &|_| true,
        is_enough,
        missing: &|known, radius| problem.missing_in_disk(known, radius),
    };
    let locked = problem.null.column_iter().map(|column| column.iter().copied().collect());
    let inverse = ShiftInverse::new(problem.model, problem.speed, problem.shift)?;
    let operator = UndampedInverse { inverse, mass: &problem.mass };
    let square = |value: Complex64| 1.0 / value.re - problem.shift * problem.shift;
    let eigenvalue = |value| elastic_value(problem, Complex64::new(0.0, square(value).max(0.0).sqrt()));
    let Some(Spectrum { space, found, others, radius }) = search.run(Krylov::new(&operator, locked), eigenvalue)?
    else {
        return Ok(None);
    };
    let accurate = found.iter().filter(|found| found.value.im < radius);
    let highest = accurate.clone().next_back().map_or(0.0, |last| last.value.im);
    let further = found.iter().filter(|found| found.value.im >= radius).chain(&others);
    let chosen = accurate.chain(further.filter(|_| approximates));
    let columns: Vec<_> = chosen.map(|found| space.vector(&found.pair).map(|entry| entry.re)).collect();
    let vectors = matrix_of_columns(problem.model.len(), &columns);
    let modes = RealModes::of_shapes(problem.model, problem.speed, vectors, 0);
    Ok(Some(UndampedSpace { modes, highest }))
}

/// An approximation of an eigenvalue.
pub(super) struct Found {
    /// λ with Im λ ≥ 0, rad/s.
    pub value: Complex64,
    /// The vector, with its relative residual.
    pub pair: RitzPair,
    /// Whether the mode is wanted.
    is_wanted: bool,
}

impl Found {
    fn is_accurate<T: Operator>(&self) -> bool {
        self.pair.residual <= if T::SYMMETRIC { ROOT_OF_ROUND_OFF } else { ACCURATE }
    }
}

/// Accurate approximations in a Krylov space.
pub(super) struct Spectrum<'s, T: Operator> {
    pub space: Krylov<'s, T>,
    /// In ascending order of |λ|, with all wanted ones.
    pub found: Vec<Found>,
    /// Less accurate ones after them.
    others: Vec<Found>,
    /// None below it is missing, rad/s.
    radius: f64,
}

impl<T: Operator> Spectrum<'_, T> {
    /// The `count` lowest wanted ones.
    pub fn wanted(&self, count: usize) -> impl Iterator<Item = &Found> {
        self.found.iter().filter(|found| found.is_wanted).take(count)
    }
}

/// A search for the lowest eigenvalues.
pub(super) struct Search<'s> {
    /// Number of wanted eigenvalues, for the size of the space.
    pub count: usize,
    /// Whether further accurate ones are taken as well.
    pub takes_further: bool,
    /// Number of steps after which the search ends.
    pub most_steps: usize,
    /// Whether the lowest wanted eigenvalues, rad/s, are enough.
    pub is_enough: &'s dyn Fn(&[Complex64]) -> bool,
    /// Whether the mode of an eigenvalue λ with Im λ ≥ 0, rad/s, is wanted.
    pub is_wanted: &'s dyn Fn(Complex64) -> bool,
    /// Number of eigenvalues with |λ| below a radius, rad/s, that are missing in known values; none if it cannot be determined.
    pub missing: &'s dyn Fn(&[Complex64], f64) -> Option<i64>,
}

impl Search<'_> {
    /// Extends the space until the lowest eigenvalues are accurate and none is missing; `None` if too many others have to be told
    /// apart from them. `eigenvalue` gives λ, rad/s, for an eigenvalue of the operator, if it is one of the modes in question.
    pub fn run<'s, T: Operator>(
        &self,
        mut space: Krylov<'s, T>,
        eigenvalue: impl Fn(Complex64) -> Option<Complex64>,
    ) -> Result<Option<Spectrum<'s, T>>, DecompositionError> {
        let per_mode = if T::SYMMETRIC { 1 } else { 2 };
        let mut target = first_steps::<T>(self.count);

        // Two bending planes have equal modes at rest.
        for _ in 0..if T::SYMMETRIC { 2 } else { 1 } {
            space.add_start()?;
        }
        let mut restarts = 0;
        loop {
            while space.steps() < target && !space.is_complete() {
                space.step()?;
            }
            let [found, others] = self.recognised(&space, &eigenvalue)?;
            let next = others.first().map_or(f64::INFINITY, |next| next.value.norm());
            let steps = space.steps();
            let Some(radius) = self.radius::<T>(&found, next) else {
                if space.is_complete() || steps >= self.most_steps {
                    return Ok(None);
                }
                let accurate = found.iter().filter(|found| found.is_wanted && found.is_accurate::<T>()).count();
                let further = self.count.saturating_sub(accurate) as f64 * STEPS_PER_EIGENVALUE * per_mode as f64;
                target = steps + further_steps(steps).max(further as usize);
                continue;
            };
            let outside = others.iter().map(|found| found.value).filter(|value| value.norm() > OUTSIDE * radius);
            let known: Vec<Complex64> = found.iter().map(|found| found.value).chain(outside).collect();
            if (self.missing)(&known, radius) == Some(0) {
                return Ok(Some(Spectrum { space, found, others, radius }));
            }
            if restarts == MAX_RESTARTS {
                return Ok(None);
            }
            restarts += 1;
            // Further start vectors find further vectors of equal eigenvalues.
            space.add_start()?;
            space.add_start()?;
            target = steps + per_mode * self.count + 20;
        }
    }

    /// Approximations of eigenvalues λ with Im λ ≥ 0, in ascending order of |λ|, and the less accurate ones after them, rad/s.
    fn recognised<T: Operator>(
        &self,
        space: &Krylov<'_, T>,
        eigenvalue: impl Fn(Complex64) -> Option<Complex64>,
    ) -> Result<[Vec<Found>; 2], DecompositionError> {
        let found = |pair: RitzPair| {
            let value = without_round_off(eigenvalue(pair.value)?);
            Some(Found { value, pair, is_wanted: (self.is_wanted)(value) })
        };
        let mut all: Vec<Found> = space.ritz_pairs()?.into_iter().filter_map(found).collect();
        all.retain(|found| found.value.im >= 0.0);
        all.sort_by(|a, b| ascending(a.value, b.value));
        let last = all.iter().rposition(|found| found.pair.residual <= RECOGNISED).map_or(0, |last| last + 1);
        let others = all.split_off(last);
        all.retain(|found| found.pair.residual <= RECOGNISED);
        Ok([all, others])
    }

    /// Radius in a gap of the magnitudes, rad/s, so that the found modes below it are enough and accurate; `next` is an estimate
    /// of the magnitude that follows the found ones, rad/s.
    fn radius<T: Operator>(&self, found: &[Found], next: f64) -> Option<f64> {
        let (mut wanted, mut radius) = (Vec::new(), None);
        for (index, mode) in found.iter().enumerate().take_while(|(_, mode)| mode.is_accurate::<T>()) {
            wanted.extend(mode.is_wanted.then_some(mode.value));
            let size = mode.value.norm();
            let following = match found.get(index + 1) {
                Some(following) => following.value.norm(),
                None if radius.is_some() => break,
                None => next.min(FURTHEST * size),
            };
            if following > (1.0 + GAP) * size && (self.is_enough)(&wanted) {
                radius = Some(f64::midpoint(size, following));
                if !self.takes_further {
                    break;
                }
            }
        }
        radius
    }
}

/// Number of steps before the first decomposition in a search for `count` modes, which some models need.
pub(super) fn first_steps<T: Operator>(count: usize) -> usize {
    if T::SYMMETRIC { 2 * count + 8 } else { 4 * count + 16 }
}

/// Number of steps after which a search for `count` modes ends.
pub(super) fn most_steps<T: Operator>(count: usize) -> usize {
    10 * first_steps::<T>(count)
}

/// Number of steps by which a space of so many steps is extended.
pub(super) fn further_steps(steps: usize) -> usize {
    (steps / 8).max(8)
}

/// Modes of a damped problem.
fn damped_modes(
    problem: &Problem<'_>,
    spectrum: &Spectrum<'_, FirstOrderInverse<'_, '_>>,
    count: usize,
) -> Vec<Eigenpair> {
    let size = problem.model.len();
    let pair = |found: &Found| {
        // The space of states (x, λx) leaves out the positions of rigid-body modes; the part of the shape in them follows from
        // its velocity.
        let shape = if problem.null.ncols() == 0 {
            spectrum.space.first_entries(&found.pair, size)
        } else {
            let state = spectrum.space.vector(&found.pair);
            let mut shape = state.rows(0, size).into_owned();
            let missing = state.rows(size, size) / found.value - &shape;
            problem.add_rigid_part(&missing, &mut shape);
            shape
        };
        let size = problem.model.complex_kinetic_form(&shape).sqrt();
        let shape = shape.unscale(size);
        let value = without_round_off(problem.rayleigh(found.value, &shape));
        // A real eigenvalue has no sign of zero, which would count in the order.
        Eigenpair { value: Complex64::new(value.re, value.im.abs()), shape }
    };
    spectrum.wanted(count).map(pair).collect()
}

/// A real eigenvalue for one whose imaginary part is an error of the solutions: it splits two equal real eigenvalues into a conjugate pair,
/// of which both count.
fn without_round_off(value: Complex64) -> Complex64 {
    if value.im.abs() <= MAX_BACKWARD_ERROR * value.norm() { Complex64::from(value.re) } else { value }
}
