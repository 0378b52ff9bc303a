//! The damped modes of lowest frequency, in time proportional to n: shift-invert Arnoldi method with a count.
//!
//! The first-order form over y = (x, z), z = λx, of [λ²M + λD + K] x = 0 with D = C + ΩG is inverted at a shift s > 0:
//!
//! ```text
//! T (x, z) = (u, x + s u),    S(s) u = −M z − (D + sM) x,    λ = s + 1/θ    for an eigenvalue θ of T
//! ```
//!
//! Each step solves one system with the band matrices of the shafts. Without damping, gyroscopic and circulatory forces
//! T = (K + s²M)⁻¹M is half as large, and symmetric. The inner product is that of the energy, in which T is normal if
//! nothing damps. Rigid-body modes are known and left out of the space.
//!
//! An Arnoldi method may miss one of several equal eigenvalues. [`super::contour`] counts the eigenvalues below a frequency;
//! as long as one is missing, the space gets further start vectors.

use nalgebra::{Complex, DMatrix, DVector};
use num_complex::Complex64;

use super::contour::{self, Known, Rectangle};
use super::real::{RealModes, null_motions};
use super::spectral_range::{ShiftInverse, mass_times, solve_real};
use super::{CachedModel, SpectralRange};
use crate::linalg::{CoupledFactors, DecompositionError, Krylov, Operator, RitzPair, Sparse};
use crate::model::{Model, Weights};

/// Relative residual of an accurate mode.
const ACCURATE: f64 = 1e-12;
/// Relative residual below which an approximation is used to count the eigenvalues.
const RECOGNISED: f64 = 1e-7;
/// Smallest relative distance of two frequencies between which eigenvalues are counted.
const GAP: f64 = 1e-4;
/// An eigenvalue below this fraction of the shift is the velocity of a rigid-body mode.
const ZERO: f64 = 1e-7;
/// A smaller force of D on a rigid-body mode, relative to the largest entry of D, is round-off.
const UNCOUPLED: f64 = 1e-11;
/// Number of times that start vectors are added for missing eigenvalues.
const MAX_RESTARTS: usize = 4;
/// Largest relative difference of the Rayleigh quotient from the eigenvalue of the space.
const MAX_CORRECTION: f64 = 1e-6;

/// Eigenvalue λ with Im λ ≥ 0, rad/s, and mode shape, n entries in the order of the core.
pub(super) type Eigenpair = (Complex64, DVector<Complex64>);

/// The `count` modes of lowest |Im λ| at `speed` of the reference shaft, rad/s, rigid-body modes first; `None` if they
/// cannot be told apart from the others, as with many overdamped modes.
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
    if problem.undamped {
        let operator = ShiftInverse::new(model, speed, problem.shift)?;
        let locked = problem.null.column_iter().map(|column| column.iter().copied().collect());
        return problem.search(&operator, locked, count);
    }
    let operator = FirstOrderInverse::new(&problem)?;
    let locked = problem.rigid_states();
    problem.search(&operator, locked, count)
}

/// Matrices of the problem and its rigid-body modes.
struct Problem<'m> {
    model: &'m Model,
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    /// s, rad/s.
    shift: f64,
    /// D = C + ΩG.
    rate: Sparse,
    /// Symmetric part of K.
    stiffness: Sparse,
    /// Whether D and the skew part of K are zero.
    undamped: bool,
    /// Rigid-body modes, one per column, orthonormal in M.
    null: DMatrix<f64>,
    /// Numbers of the rigid-body modes whose velocity D does not act on.
    free: Vec<usize>,
    /// Bound of |Re λ| in terms of |Im λ|.
    reach: Reach,
}

impl<'m> Problem<'m> {
    fn new(model: &'m Model, speed: f64, range: &SpectralRange) -> Result<Self, DecompositionError> {
        let rate = model.sparse_rate(speed);
        let circulates =
            model.local_elements().any(|support| support.skew_part().as_flattened().iter().any(|k| *k != 0.0));
        let null = null_motions(model, speed)?;
        // Coordinates with unit inertia have one unit; round-off of the rigid-body modes is relative to their largest entry.
        let inertia = model.sparse_mass().diagonal();
        let scaled = |row: usize, column: usize, value: f64| value.abs() / (inertia[row] * inertia[column]).sqrt();
        let largest = rate.largest(scaled);
        let acts = |column: usize| {
            let motion: Vec<f64> = null.column(column).iter().copied().collect();
            let mut force = vec![0.0; motion.len()];
            rate.multiply_add(1.0, &motion, &mut force);
            let size = motion.iter().zip(&inertia).map(|(x, m)| x.abs() * m.sqrt()).fold(0.0, f64::max);
            force.iter().zip(&inertia).any(|(force, m)| force.abs() / m.sqrt() > UNCOUPLED * largest * size)
        };
        Ok(Self {
            shift: range.slowest.unwrap_or(range.fastest.max(1.0)),
            undamped: rate.is_zero() && !circulates,
            free: (0..null.ncols()).filter(|column| !acts(*column)).collect(),
            reach: Reach::new(model, speed, range.fastest),
            stiffness: model.sparse_symmetric_stiffness(speed),
            model,
            speed,
            rate,
            null,
        })
    }

    /// States (x, z) of λ = 0: the positions of rigid-body modes, and the velocities on which nothing acts.
    fn rigid_states(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        let n = self.model.len();
        let state = move |column: usize, first: usize| {
            let mut state = vec![0.0; 2 * n];
            state[first..first + n].copy_from_slice(self.null.column(column).as_slice());
            state
        };
        let positions = (0..self.null.ncols()).map(move |column| state(column, 0));
        positions.chain(self.free.iter().map(move |column| state(*column, n)))
    }

    /// Extends a Krylov space until the lowest modes are accurate and none is missing.
    fn search(
        &self,
        operator: &impl Operator,
        locked: impl Iterator<Item = Vec<f64>>,
        count: usize,
    ) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
        let mut space = Krylov::new(operator, locked);
        let per_mode = if self.undamped { 1 } else { 2 };
        let mut target = per_mode * 2 * count + 16;
        let most = 6 * target + 60;
        let mut restarts = 0;
        // Two bending planes have equal modes at rest.
        for _ in 0..if self.undamped { 2 } else { 1 } {
            space.add_start()?;
        }
        loop {
            while space.steps() < target && !space.is_complete() {
                space.step()?;
            }
            let found = self.recognised(&space)?;
            let steps = space.steps();
            match self.boundary(&found, count) {
                Some(top) => match self.missing(&found, top) {
                    Some(0) => return Ok(Some(self.eigenpairs(&space, &found, count))),
                    Some(missing) if missing > 0 && restarts < MAX_RESTARTS => {
                        restarts += 1;
                        space.add_start()?;
                        space.add_start()?;
                        target = steps + per_mode * count + 20;
                    }
                    _ => return Ok(None),
                },
                None if space.is_complete() || steps >= most => return Ok(None),
                None => target = steps + (steps / 4).max(8),
            }
        }
    }

    /// Approximations of eigenvalues λ with Im λ ≥ 0 apart from rigid-body modes, in ascending order.
    fn recognised<T: Operator>(&self, space: &Krylov<'_, T>) -> Result<Vec<(Complex64, RitzPair)>, DecompositionError> {
        let eigenvalue = |pair: RitzPair| {
            let value = if self.undamped {
                Complex64::new(0.0, (1.0 / pair.value.re - self.shift * self.shift).max(0.0).sqrt())
            } else {
                self.shift + 1.0 / pair.value
            };
            (value, pair)
        };
        let elastic = |value: &Complex64| self.null.ncols() == 0 || value.norm() > ZERO * self.shift;
        let mut found: Vec<(Complex64, RitzPair)> = space
            .ritz_pairs()?
            .into_iter()
            .map(eigenvalue)
            .filter(|(value, pair)| pair.residual <= RECOGNISED && value.im >= 0.0 && elastic(value))
            .collect();
        found.sort_by(|(a, _), (b, _)| a.im.total_cmp(&b.im).then(a.norm().total_cmp(&b.norm())));
        Ok(found)
    }

    /// Frequency in a gap of the spectrum above the `count` lowest modes, if all below it are accurate.
    fn boundary(&self, found: &[(Complex64, RitzPair)], count: usize) -> Option<f64> {
        let first = count.saturating_sub(self.null.ncols());
        for next in first..found.len() {
            if next > 0 && found[next - 1].1.residual > ACCURATE {
                return None;
            }
            let (below, above) = (if next > 0 { found[next - 1].0.im } else { 0.0 }, found[next].0.im);
            if above > (1.0 + GAP) * below {
                return found[..next]
                    .iter()
                    .all(|(_, pair)| pair.residual <= ACCURATE)
                    .then(|| f64::midpoint(below, above));
            }
        }
        None
    }

    /// Number of eigenvalues with |Im λ| < `top` that are not found.
    fn missing(&self, found: &[(Complex64, RitzPair)], top: f64) -> Option<i64> {
        let zeros = self.null.ncols() + if self.undamped { self.null.ncols() } else { self.free.len() };
        let known = Known { zeros, values: found.iter().map(|(value, _)| *value).collect() };
        let determinant = |at: Complex64| {
            let sense = if at.re < 0.0 { -1.0 } else { 1.0 };
            let matrix = self.model.dynamic_stiffness(&Weights::dynamic(at, self.speed), self.speed);
            matrix.factor(sense).ok().map(|factors| factors.determinant())
        };
        contour::missing(determinant, &known, self.reach.rectangle(top))
    }

    /// Rigid-body modes, and the lowest of the found modes.
    fn eigenpairs<T: Operator>(
        &self,
        space: &Krylov<'_, T>,
        found: &[(Complex64, RitzPair)],
        count: usize,
    ) -> Vec<Eigenpair> {
        let n = self.model.len();
        let rigid: Vec<Eigenpair> =
            self.null.column_iter().map(|column| (Complex64::ZERO, column.map(Complex::from))).collect();
        let elastic = count.saturating_sub(rigid.len());
        let chosen = &found[..elastic.min(found.len())];
        let pairs: Vec<Eigenpair> = if self.undamped {
            // All approximations of one frequency are rotated together.
            let end = found[chosen.len()..].iter().take_while(|(value, _)| {
                chosen.last().is_some_and(|(last, _)| (value.im - last.im).abs() <= GAP * last.im)
            });
            let columns: Vec<_> = found[..chosen.len() + end.count()]
                .iter()
                .map(|(_, pair)| space.vector(pair).map(|entry| entry.re))
                .collect();
            let vectors = if columns.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(&columns) };
            let real = RealModes::of_shapes(self.model, self.speed, vectors, 0);
            let shapes = real.vectors.column_iter().map(|column| column.map(Complex::from));
            real.frequencies.iter().map(|frequency| Complex64::new(0.0, *frequency)).zip(shapes).collect()
        } else {
            let pair = |(value, pair): &(Complex64, RitzPair)| {
                let shape = space.vector(pair).rows(0, n).into_owned();
                let size = self.kinetic(&shape).sqrt();
                let shape = shape.unscale(size);
                (self.rayleigh(*value, &shape), shape)
            };
            chosen.iter().map(pair).collect()
        };
        let mut all: Vec<Eigenpair> = rigid.into_iter().chain(pairs).collect();
        all.truncate(count);
        all
    }

    /// φᴴMφ.
    fn kinetic(&self, shape: &DVector<Complex64>) -> f64 {
        let part = |part: fn(&Complex64) -> f64| self.model.kinetic_form(shape.map(|value| part(&value)).as_slice());
        part(|value| value.re) + part(|value| value.im)
    }

    /// The root of λ² + λ φᴴDφ + φᴴKφ next to `value`, for φᴴMφ = 1. The elastic energy of the strains has less round-off
    /// than K.
    fn rayleigh(&self, value: Complex64, shape: &DVector<Complex64>) -> Complex64 {
        let parts = [shape.map(|entry| entry.re), shape.map(|entry| entry.im)];
        let elastic =
            |part: &DVector<f64>| self.model.elastic_form(part.as_slice(), |mesh| self.model.sigma(mesh, self.speed));
        let mut stiffness = Complex64::from(elastic(&parts[0]) + elastic(&parts[1]));
        let supports = self.model.supports.iter();
        let supports = supports.map(|support| (support, [shape[support.index], shape[support.index + 1]]));
        let links = self.model.links.iter().map(|link| (&link.local, link.complex_scalars(shape.as_slice())));
        for (element, local) in supports.chain(links) {
            for (row, left) in element.skew_part().iter().zip(local) {
                for (value, right) in row.iter().zip(local) {
                    stiffness += left.conj() * right * *value;
                }
            }
        }
        let images = parts.each_ref().map(|part| {
            let mut image = DVector::zeros(part.len());
            self.rate.multiply_add(1.0, part.as_slice(), image.as_mut_slice());
            image
        });
        let rate = Complex64::new(
            parts[0].dot(&images[0]) + parts[1].dot(&images[1]),
            parts[0].dot(&images[1]) - parts[1].dot(&images[0]),
        );
        let root = (rate * rate - 4.0 * stiffness).sqrt();
        let corrected = [(-rate + root) / 2.0, (-rate - root) / 2.0].into_iter().fold(
            Complex64::new(f64::INFINITY, 0.0),
            |best, one| {
                if (one - value).norm() < (best - value).norm() { one } else { best }
            },
        );
        let near = (corrected - value).norm() <= MAX_CORRECTION * value.norm();
        if near && (value.im != 0.0) == (corrected.im > 0.0) { corrected } else { value }
    }
}

/// T of the first-order form.
struct FirstOrderInverse<'p, 'm> {
    problem: &'p Problem<'m>,
    factors: CoupledFactors,
}

impl<'p, 'm> FirstOrderInverse<'p, 'm> {
    fn new(problem: &'p Problem<'m>) -> Result<Self, DecompositionError> {
        let weights = Weights::dynamic(Complex64::from(problem.shift), problem.speed);
        let factors = problem.model.dynamic_stiffness(&weights, problem.speed).factor(1.0)?;
        Ok(Self { problem, factors })
    }
}

impl Operator for FirstOrderInverse<'_, '_> {
    const SYMMETRIC: bool = false;

    fn size(&self) -> usize {
        2 * self.problem.model.len()
    }

    fn apply(&self, state: &[f64]) -> Result<Vec<f64>, DecompositionError> {
        let Problem { model, shift, rate, .. } = self.problem;
        let (x, z) = state.split_at(model.len());
        let momentum: Vec<f64> = x.iter().zip(z).map(|(x, z)| -(z + shift * x)).collect();
        let mut force = mass_times(model, &momentum);
        rate.multiply_add(-1.0, x, &mut force);
        let mut image = solve_real(model, &self.factors, &force)?;
        for index in 0..model.len() {
            image.push(x[index] + shift * image[index]);
        }
        Ok(image)
    }

    /// The inner product is xᵀ(K + s²M)x' + zᵀMz', with the symmetric part of K.
    fn weigh(&self, state: &[f64]) -> Vec<f64> {
        let Problem { model, shift, stiffness, .. } = self.problem;
        let (x, z) = state.split_at(model.len());
        let mut weighted = mass_times(model, x);
        weighted.iter_mut().for_each(|value| *value *= shift * shift);
        stiffness.multiply_add(1.0, x, &mut weighted);
        weighted.extend(mass_times(model, z));
        weighted
    }
}

/// Bound of |Re λ| of all eigenvalues with a given |Im λ|.
///
/// With λ = a + ib and xᴴMx = 1, the real part of xᴴS(λ)x = 0 is a² + a c = b² + bΩg − k, so that
/// |a| ≤ c + √(b² + b|Ω|g + κ), where c, g and κ bound the damping, the gyroscopic matrix and the skew part of the stiffness
/// relative to the mass.
struct Reach {
    damping: f64,
    gyroscopic: f64,
    circulatory: f64,
    /// Whether every eigenvalue has Re λ ≤ 0.
    stable: bool,
}

impl Reach {
    fn new(model: &Model, speed: f64, fastest: f64) -> Self {
        let [alpha, beta] = model.scene.rayleigh;
        let mut reach = Self {
            damping: alpha.abs() + beta.abs() * fastest * fastest,
            gyroscopic: 0.0,
            circulatory: 0.0,
            stable: alpha >= 0.0 && beta >= 0.0,
        };
        // The trace of M⁻¹C bounds the largest eigenvalue.
        let mobility = |row: &[(usize, f64)]| {
            let mut column = vec![0.0; model.len()];
            row.iter().for_each(|(index, coefficient)| column[*index] += coefficient);
            model.solve_mass(&mut column);
            row.iter().map(|(index, coefficient)| coefficient * column[*index]).sum::<f64>()
        };
        let supports = model.supports.iter().map(|support| (2.0 * mobility(&[(support.index, 1.0)]), support));
        let links = model.links.iter();
        let links = links.map(|link| (link.rows.iter().map(|row| mobility(row)).sum::<f64>(), &link.local));
        for (mobility, support) in supports.chain(links) {
            let [[a, b], [c, d]] = support.damping;
            reach.damping += mobility * a.hypot(b).hypot(c.hypot(d));
            reach.circulatory += mobility * support.skew_part().as_flattened().iter().fold(0.0_f64, |n, k| n.hypot(*k));
            reach.stable &= a >= 0.0 && d >= 0.0 && a * d >= (b + c) * (b + c) / 4.0;
        }
        for connection in model.connections(speed) {
            let damping = connection.linear(speed).damping;
            let mobility: f64 = connection.rows().iter().map(|row| mobility(row)).sum();
            reach.damping += mobility * damping.norm();
            reach.stable &= damping.amax() == 0.0 || damping.nrows() == 1 && damping[(0, 0)] >= 0.0;
        }
        reach.stable &= reach.circulatory == 0.0;
        // Polar over diametral inertia is at most two, apart from bodies whose data say otherwise.
        let ratio = |body: &crate::scene::Body| body.polar_inertia / body.diametral_inertia;
        let ratios = model.scene.bodies().map(ratio).filter(|ratio| ratio.is_finite());
        reach.gyroscopic = ratios.fold(2.0, f64::max) * model.max_speed_ratio() * speed.abs();
        reach
    }

    fn rectangle(&self, top: f64) -> Rectangle {
        let left = 1.5 * (self.damping + (top * top + top * self.gyroscopic + self.circulatory).sqrt());
        Rectangle { left, right: if self.stable { top / 4.0 } else { left }, top }
    }
}
