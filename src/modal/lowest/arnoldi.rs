//! The damped modes of lowest frequency, in time proportional to n: shift-invert Arnoldi method with a count.
//!
//! A Krylov space of the inverse at a small shift ([`super::shift_invert`]) finds the eigenvalues of smallest magnitude.
//! Rigid-body modes are known and left out of the space. Strongly damped eigenvalues may be far from the origin and still
//! have a low frequency; they are found at further shifts on the real axis, or by [`super::lowest_damped()`] with
//! cross-coupled stiffness.
//!
//! A search for vibrations leaves out overdamped motions, of which internal damping and oil films cause many: outside of the
//! disk, it counts the eigenvalues next to the real axis only where |Im λ|/|λ| is above [`super::shift_invert::MIN_OSCILLATION`].
//!
//! An Arnoldi method may miss one of several equal eigenvalues. [`super::contour`] counts the eigenvalues with |λ| below a
//! radius R and those with a damping ratio above one half, unless [`super::bound`] excludes these. As long as one is
//! missing, the spaces are extended. Every other eigenvalue has |Im λ| > R sin 60°, so that all eigenvalues of lower
//! frequency are known.

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::contour::{Annulus, SECTOR};
use super::shift_invert::{Eigenpair, FirstOrderInverse, Inverse, Problem, oscillates};
use crate::linalg::{DecompositionError, Krylov, RitzPair};
use crate::modal::undamped::{RealModes, ShiftInverse};

/// Relative residual of an accurate mode.
const ACCURATE: f64 = 1e-12;
/// Relative residual below which an approximation is used to count the eigenvalues.
const RECOGNISED: f64 = 1e-7;
/// Smallest relative distance of two magnitudes between which the radius of the count lies.
const GAP: f64 = 1e-4;
/// Largest ratio of two magnitudes between which the radius of the count lies, if the larger one is an estimate.
const FURTHEST: f64 = 1.5;
/// Relative distance of approximations of one eigenvalue from two spaces.
const SAME: f64 = 1e-6;
/// An imaginary part below this fraction of an eigenvalue is round-off.
const REAL: f64 = 1e-11;
/// An eigenvalue below this fraction of the shift is the velocity of a rigid-body mode.
const ZERO: f64 = 1e-7;
/// Number of times that the spaces are extended for missing eigenvalues.
const MAX_RESTARTS: usize = 6;
/// Largest number of steps at a further shift beyond the number of dampers, and steps between two checks.
const FURTHER_STEPS: usize = 60;
const CHECK_INTERVAL: usize = 12;
/// Number of strongly damped eigenvalues up to which they are sought one by one.
const MAX_MISSING: i64 = 120;

/// The `count` modes of lowest |Im λ| of a problem, rigid-body modes first; `None` if too many
/// overdamped modes have to be told apart from them.
///
/// # Errors
/// [`DecompositionError`] if a linear system has no accurate solution, or an eigenvalue iteration fails.
pub fn lowest(problem: &Problem<'_>, count: usize) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let elastic = count.saturating_sub(problem.null.ncols());
    if problem.undamped {
        return lowest_undamped(problem, count);
    }
    let operator = |shift: f64| FirstOrderInverse::new(problem, shift);
    let locked = problem.rigid_states().collect();
    Search { problem, count, elastic, locked, vibrating: false }.run(operator)
}

/// The `count` vibrations of lowest |Im λ| of a problem with damping; `None` if they cannot be told apart from other motions.
///
/// # Errors
/// As [`lowest`].
pub fn lowest_vibrations(problem: &Problem<'_>, count: usize) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let operator = |shift: f64| FirstOrderInverse::new(problem, shift);
    let locked = problem.rigid_states().collect();
    Search { problem, count, elastic: count, locked, vibrating: true }.run(operator)
}

/// The same for an undamped problem.
///
/// # Errors
/// As [`lowest`].
pub(in crate::modal) fn lowest_undamped(
    problem: &Problem<'_>,
    count: usize,
) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let elastic = count.saturating_sub(problem.null.ncols());
    let operator = |shift: f64| ShiftInverse::new(problem.model, problem.speed, shift);
    let locked = problem.null.column_iter().map(|column| column.iter().copied().collect());
    Search { problem, count, elastic, locked: locked.collect(), vibrating: false }.run(operator)
}

/// The `count` lowest modes of an undamped problem.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub(in crate::modal) fn undamped_modes(
    problem: &Problem<'_>,
    count: usize,
) -> Result<Option<RealModes>, DecompositionError> {
    let Some(pairs) = lowest_undamped(problem, count)? else {
        return Ok(None);
    };
    let columns: Vec<DVector<f64>> = pairs.iter().map(|pair| pair.shape.map(|value| value.re)).collect();
    let vectors = DMatrix::from_columns(&columns);
    Ok(Some(RealModes::of_shapes(problem.model, problem.speed, vectors, problem.null.ncols())))
}

/// An approximation of an eigenvalue.
#[derive(Clone)]
struct Found {
    /// λ with Im λ ≥ 0, rad/s.
    value: Complex64,
    /// Relative residual in its Krylov space.
    residual: f64,
    vector: Vector,
}

/// Where the vector of an approximation is.
#[derive(Clone)]
enum Vector {
    /// In the space at the small shift.
    Base(RitzPair),
    /// The mode shape, n entries.
    Shape(DVector<Complex64>),
}

impl Found {
    fn is_accurate(&self) -> bool {
        self.residual <= ACCURATE
    }

    fn is_same(&self, other: &Self) -> bool {
        (other.value - self.value).norm() <= SAME * self.value.norm()
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
    /// Whether the modes are vibrations only.
    vibrating: bool,
}

impl Search<'_, '_> {
    /// Extends Krylov spaces until the lowest modes are accurate and none is missing; `inverse` gives the operator at a
    /// shift, rad/s.
    fn run<T: Inverse>(
        &self,
        inverse: impl Fn(f64) -> Result<T, DecompositionError>,
    ) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
        let base = inverse(self.problem.shift)?;
        let mut space = Krylov::new(&base, self.locked.iter().cloned());
        let per_mode = if self.problem.undamped { 1 } else { 2 };
        // Most models need as many steps; decompositions of the projected matrix are as costly as steps.
        let mut target = 2 * per_mode * self.elastic + 24;
        let most = 6 * target + 30;
        // Two bending planes have equal modes at rest.
        for _ in 0..if self.problem.undamped { 2 } else { 1 } {
            space.add_start()?;
        }
        let (mut further, mut annuli): (Vec<Found>, Option<Vec<Annulus>>) = (Vec::new(), None);
        let mut restarts = 0;
        loop {
            while space.steps() < target && !space.is_complete() {
                space.step()?;
            }
            let (recognised, next) = self.recognised(&space)?;
            let found = merged(recognised, &further);
            let steps = space.steps();
            let Some(radius) = self.radius(&found, next) else {
                if space.is_complete() || steps >= most {
                    return Ok(None);
                }
                target = steps + (steps / 8).max(8);
                continue;
            };
            let missing = if self.vibrating {
                self.problem.missing_vibrations(values(&found), radius)
            } else {
                self.problem.missing_lowest(values(&found), radius)
            };
            let chosen = self.chosen(&found, radius);
            if missing == Some(0) && chosen.iter().all(|found| found.is_accurate()) {
                return Ok(Some(self.eigenpairs(&space, &found, &chosen)));
            }
            if restarts == MAX_RESTARTS || missing.is_some_and(|missing| missing > MAX_MISSING) {
                return Ok(None);
            }
            restarts += 1;
            if self.problem.missing_in_disk(values(&found), radius) != Some(0) {
                // Further start vectors find further vectors of equal eigenvalues.
                space.add_start()?;
                space.add_start()?;
                target = steps + per_mode * self.elastic + 20;
                continue;
            }
            // Films of journal bearings have many strongly damped motions with cross-coupling.
            if self.problem.circulates || self.vibrating {
                return Ok(None);
            }
            let narrower = match annuli.take() {
                Some(known) => known.iter().flat_map(Annulus::halves).collect(),
                None => self.problem.annuli(radius),
            };
            annuli = Some(self.search_annuli(narrower, &found, &chosen, &mut further, &inverse)?);
        }
    }

    /// Searches the annular sectors in which a found eigenvalue is missing or a chosen one is inaccurate, and adds what is
    /// found to `further`. Returns these sectors.
    fn search_annuli<T: Inverse>(
        &self,
        annuli: Vec<Annulus>,
        found: &[Found],
        chosen: &[&Found],
        further: &mut Vec<Found>,
        inverse: impl Fn(f64) -> Result<T, DecompositionError>,
    ) -> Result<Vec<Annulus>, DecompositionError> {
        let mut searched = Vec::new();
        for annulus in annuli {
            let missing = self.problem.missing(values(found), &annulus.contour());
            let is_accurate = !chosen.iter().any(|found| annulus.contains(found.value) && !found.is_accurate());
            if missing != Some(0) || !is_accurate {
                let known = weight(found.iter().filter(|found| annulus.contains(found.value)));
                let total = missing.map(|missing| missing + known);
                *further = merged(self.in_annulus(&annulus, total, &inverse)?, further);
                searched.push(annulus);
            }
        }
        Ok(searched)
    }

    /// Approximations of the `total` eigenvalues in an annular sector, from a space at a shift within it.
    fn in_annulus<T: Inverse>(
        &self,
        annulus: &Annulus,
        total: Option<i64>,
        inverse: impl Fn(f64) -> Result<T, DecompositionError>,
    ) -> Result<Vec<Found>, DecompositionError> {
        let operator = inverse(annulus.centre())?;
        let mut space = Krylov::new(&operator, self.locked.iter().cloned());
        let dampers = self.problem.damper_states();
        dampers.iter().try_for_each(|state| space.add_start_of(state))?;
        loop {
            for _ in 0..CHECK_INTERVAL {
                space.step()?;
            }
            let (mut found, _) = self.recognised(&space)?;
            found.retain(|found| annulus.contains(found.value));
            let is_end = space.steps() >= FURTHER_STEPS + dampers.len() || space.is_complete();
            let is_complete = total.is_some_and(|total| weight(found.iter()) >= total);
            if is_end || is_complete && found.iter().all(Found::is_accurate) {
                for found in &mut found {
                    if let Vector::Base(pair) = &found.vector {
                        found.vector = Vector::Shape(self.shape_of(&space, pair));
                    }
                }
                return Ok(found);
            }
        }
    }

    /// Approximations of eigenvalues λ with Im λ ≥ 0 apart from rigid-body modes, in ascending order of |λ|, and the
    /// magnitude of the next approximation, rad/s, which is less accurate.
    fn recognised<T: Inverse>(&self, space: &Krylov<'_, T>) -> Result<(Vec<Found>, f64), DecompositionError> {
        let is_elastic = |value: &Complex64| self.problem.null.ncols() == 0 || value.norm() > ZERO * self.problem.shift;
        let found = |pair: RitzPair| Found {
            value: without_round_off(space.operator().eigenvalue(pair.value)),
            residual: pair.residual,
            vector: Vector::Base(pair),
        };
        let mut all: Vec<Found> = space.ritz_pairs()?.into_iter().map(found).collect();
        all.retain(|found| found.value.im >= 0.0 && is_elastic(&found.value));
        all.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
        let last = all.iter().rposition(|found| found.residual <= RECOGNISED).map_or(0, |last| last + 1);
        let next = all.get(last).map_or(f64::INFINITY, |next| next.value.norm());
        all.truncate(last);
        all.retain(|found| found.residual <= RECOGNISED);
        Ok((all, next))
    }

    /// Radius in a gap of the magnitudes, rad/s, so that the found modes of lower frequency are enough and all below it are
    /// accurate; `next` is an estimate of the magnitude that follows the found ones, rad/s.
    fn radius(&self, found: &[Found], next: f64) -> Option<f64> {
        for (index, pair) in found.iter().enumerate() {
            if !pair.is_accurate() {
                return None;
            }
            let size = pair.value.norm();
            let following = found.get(index + 1).map_or(next.min(FURTHEST * size), |following| following.value.norm());
            let radius = f64::midpoint(size, following);
            let is_gap = following > (1.0 + GAP) * size;
            if is_gap && index + 1 >= self.elastic && self.below(found, radius).count() >= self.elastic {
                return Some(radius);
            }
        }
        None
    }

    /// Found modes of lower frequency than every mode outside of the count with a radius, rad/s.
    fn below<'f>(&self, found: &'f [Found], radius: f64) -> impl Iterator<Item = &'f Found> {
        let sine = |ratio: f64| (1.0 - ratio * ratio).sqrt();
        let top = radius * self.problem.largest_ratio_above(radius).map_or(SECTOR.sin(), sine);
        let is_wanted = |value: Complex64| !self.vibrating || oscillates(value);
        found.iter().filter(move |found| found.value.im < top && is_wanted(found.value))
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
        let shape = |found: &Found| match &found.vector {
            Vector::Base(pair) => self.shape_of(space, pair),
            Vector::Shape(shape) => shape.clone(),
        };
        let pairs: Vec<Eigenpair> = if problem.undamped {
            // All approximations of one frequency are rotated together.
            let highest = chosen.last().map_or(0.0, |last| (1.0 + GAP) * last.value.im);
            let together = found.iter().take_while(|found| found.value.im <= highest);
            let columns: Vec<_> = together.map(|found| shape(found).map(|entry| entry.re)).collect();
            let none = || DMatrix::zeros(problem.model.len(), 0);
            let vectors = if columns.is_empty() { none() } else { DMatrix::from_columns(&columns) };
            let real = RealModes::of_shapes(problem.model, problem.speed, vectors, 0);
            let shapes = real.vectors.column_iter().map(|column| column.map(Complex::from));
            let values = real.frequencies.iter().map(|frequency| Complex64::new(0.0, *frequency));
            values.zip(shapes).map(|(value, shape)| Eigenpair { value, shape }).collect()
        } else {
            let pair = |found: &&Found| {
                let shape = shape(found);
                let size = problem.model.complex_kinetic_form(&shape).sqrt();
                let shape = shape.unscale(size);
                let value = without_round_off(problem.rayleigh(found.value, &shape));
                // A real eigenvalue has no sign of zero, which would count in the order.
                Eigenpair { value: Complex64::new(value.re, value.im.abs()), shape }
            };
            chosen.iter().map(pair).collect()
        };
        let rigid = problem.rigid_body_modes().filter(|_| !self.vibrating);
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

/// Number of eigenvalues: two of each conjugate pair.
fn weight<'f>(found: impl Iterator<Item = &'f Found>) -> i64 {
    found.map(|found| if found.value.im == 0.0 { 1 } else { 2 }).sum()
}

fn values(found: &[Found]) -> impl Iterator<Item = Complex64> + Clone + '_ {
    found.iter().map(|found| found.value)
}

/// The approximations of two spaces in ascending order of |λ|: each eigenvalue as often as in the space that has more of it,
/// and with the smaller residual.
fn merged(first: Vec<Found>, second: &[Found]) -> Vec<Found> {
    let mut all = first;
    let earlier = all.len();
    for (index, found) in second.iter().enumerate() {
        let before = second[..index].iter().filter(|other| found.is_same(other)).count();
        match (0..earlier).filter(|other| found.is_same(&all[*other])).nth(before) {
            None => all.push(found.clone()),
            Some(known) if all[known].residual > found.residual => all[known] = found.clone(),
            Some(_) => {}
        }
    }
    all.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
    all
}
