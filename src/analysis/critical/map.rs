//! Critical speeds against the bearing stiffness, as lines of the same mode.
//!
//! The modes x at the critical speeds of one model are orthogonal in B = M − iG/order, which does not depend on the
//! stiffness of the bearings: xᴴBx' = 0 and xᴴBx = 1. Modes at two stiffnesses are therefore assigned by |xᴴBx'|², in the same
//! way as those of a Campbell diagram at two speeds. The step of the stiffness is halved where the assignment is not clear.
//!
//! The modes X at both ends of a step span a space with few dimensions, in which those between are found: XᴴKX y = ω² XᴴBX y.
//! They only decide which modes at the end continue which at the beginning. Rigid-body motions N need no place in the space: every
//! mode satisfies NᴴBx = 0.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::super::assignment::{Assignment, equal};
use super::{Critical, modes, named, named_with, sense_of};
use crate::analysis::modes::{FURTHER_MODES, uses_bands};
use crate::analysis::{AnalysisError, Interrupt, Threads};
use crate::linalg::{combination, hermitian_eigen, products};
use crate::modal::{
    CachedModel, CriticalInverse, CriticalSpace, EquationForces, ModeAtSpeed, ReducedMode, Residuals, SpectralRange,
    add_stiffness_change, reduced_modes,
};
use crate::model::Model;
use crate::numerics::{ROOT_OF_ROUND_OFF, ROUND_OFF};

/// Largest number of times that a step of the stiffness is halved.
const MAX_HALVINGS: u32 = 6;
/// Number of the lowest lines for which steps are halved.
const DECIDING_LINES: usize = 16;
/// Smallest correlation of a line with its continuation: less than half of it belongs to another mode.
const MIN_CONTINUATION: f64 = 0.5;

/// A critical speed on a line of the map.
#[derive(Clone, Copy, Debug)]
pub struct CriticalPoint {
    /// The critical speed.
    pub critical: Critical,
    /// Number of its line.
    pub line: usize,
}

/// A mode at a critical speed, in all coordinates or in those of a [`StepSpace`].
#[derive(Clone)]
struct Found {
    /// λ, rad/s.
    eigenvalue: Complex64,
    /// x with |xᴴBx| = 1, n entries in the order of the core.
    shape: DVector<Complex64>,
    /// B x, n entries.
    momentum: DVector<Complex64>,
}

/// The lowest `count` critical speeds at each of the `stiffnesses`, N/m, in ascending order; `at` gives the model of a stiffness,
/// with the same coordinates for all of them.
///
/// # Errors
/// [`AnalysisError`] if `order` is zero or not finite, a stiffness is invalid, a decomposition fails, a mode does not satisfy the
/// equations of motion, or `interrupt` requests a stop.
pub fn critical_speed_map(
    at: impl Fn(f64) -> Result<Model, AnalysisError> + Sync,
    stiffnesses: &[f64],
    order: f64,
    count: usize,
    threads: &Threads,
    interrupt: &Interrupt,
) -> Result<Vec<Vec<CriticalPoint>>, AnalysisError> {
    let sense = sense_of(order)?;
    let model = |stiffness: &f64| {
        interrupt.check()?;
        // Without damping, the internal damping of a shaft has no circulatory forces either.
        let model = at(*stiffness)?;
        model
            .scene
            .refuse_turning_frame("critical speed map; campbell() intersects modes with the lines of unbalance")?;
        Ok::<_, AnalysisError>(CachedModel::new(if model.needs_speed() { model.with_tables_at(0.0)? } else { model }))
    };
    let mut models = threads.map(stiffnesses, model)?;
    if let Some((first, others)) = models.split_first_mut() {
        others.iter_mut().for_each(|other| other.model.share_order(&first.model));
    }
    let Some(first) = models.first() else { return Ok(Vec::new()) };
    let range = first.spectral_range(sense)?.clone();
    let found = Search { stiffnesses, models: &models, range: &range, order, count, interrupt }.run(threads)?;
    let mut lines = Lines { count, alive: Vec::new(), started: 0 };
    let mut map = Vec::new();
    let mut previous: Option<(f64, &CachedModel, &[Found])> = None;
    for ((stiffness, cached), (critical, found)) in stiffnesses.iter().zip(&models).zip(&found) {
        let step = previous.map(|(from, before, known)| Step {
            ends: [from, *stiffness],
            models: [&before.model, &cached.model],
            known: known.iter().chain(found).collect(),
            sense,
        });
        lines.advance(step.as_ref(), found)?;
        previous = Some((*stiffness, cached, found));
        let point =
            |(critical, (line, _)): (&Critical, &(usize, Found))| CriticalPoint { critical: *critical, line: *line };
        map.push(critical.iter().zip(&lines.alive).map(point).collect());
    }
    Ok(map)
}

/// Modes at a stiffness, and its critical speeds on the map.
type FoundAt = (Vec<Critical>, Vec<Found>);

/// The search for the modes at all stiffnesses.
struct Search<'a> {
    stiffnesses: &'a [f64],
    models: &'a [CachedModel],
    range: &'a SpectralRange,
    order: f64,
    /// Number of critical speeds at each stiffness.
    count: usize,
    interrupt: &'a Interrupt,
}

impl Search<'_> {
    /// The modes at each stiffness: in one space where that is possible, otherwise by searches of their own.
    fn run(&self, threads: &Threads) -> Result<Vec<FoundAt>, AnalysisError> {
        let mut known = self.in_one_space()?;
        let lacking: Vec<usize> = (0..known.len()).filter(|index| known[*index].is_none()).collect();
        let searched = threads.map(&lacking, |index| {
            self.interrupt.check()?;
            let cached = &self.models[*index];
            let modes = modes(cached, self.order, self.wanted())?;
            let critical = named(&cached.model, self.range, &modes[..self.count.min(modes.len())], self.interrupt)?;
            Ok::<_, AnalysisError>(self.found(&cached.model, critical, modes))
        })?;
        for (index, found) in lacking.into_iter().zip(searched) {
            known[index] = Some(found);
        }
        Ok(known.into_iter().flatten().collect())
    }

    /// Number of modes at each stiffness.
    fn wanted(&self) -> usize {
        self.count.saturating_add(FURTHER_MODES)
    }

    fn found(&self, model: &Model, critical: Vec<Critical>, modes: Vec<ModeAtSpeed>) -> FoundAt {
        (critical, modes.into_iter().map(|mode| Found::new(model, self.order, mode)).collect())
    }

    /// The modes at the stiffnesses above zero from one space: that of the lowest one, extended where a residual or the number
    /// of modes at another stiffness asks for it; `None` where the space does not contain them.
    fn in_one_space(&self) -> Result<Vec<Option<FoundAt>>, AnalysisError> {
        let mut known: Vec<Option<FoundAt>> = self.models.iter().map(|_| None).collect();
        let mut rising: Vec<usize> = (0..known.len()).filter(|index| self.stiffnesses[*index] > 0.0).collect();
        rising.sort_by(|a, b| self.stiffnesses[*a].total_cmp(&self.stiffnesses[*b]));
        let (Some((first, others)), Some(last)) = (rising.split_first(), rising.last()) else { return Ok(known) };
        let model = |index: usize| &self.models[index].model;
        if others.is_empty() || !uses_bands(model(*first), self.wanted()) {
            return Ok(known);
        }
        let inverse = CriticalInverse::new(model(*first), self.order)?;
        let Some((mut space, modes)) = CriticalSpace::new(&inverse, model(*last), self.wanted())? else {
            return Ok(known);
        };
        let critical = named(model(*first), self.range, &modes[..self.count.min(modes.len())], self.interrupt)?;
        known[*first] = Some(self.found(model(*first), critical, modes));
        for index in others {
            let other = CriticalInverse::new(model(*index), self.order)?;
            loop {
                self.interrupt.check()?;
                if let Some(reduced) = space.modes(model(*index), self.wanted())? {
                    let mode = |reduced: &ReducedMode| space.mode(&other, reduced);
                    // The highest modes converge last.
                    let lowest = reduced[..self.count].iter().rev().map(mode);
                    if let Some((critical, mut found)) = self.accurate(model(*index), lowest)?
                        && other.are_lowest(&reduced, self.count)
                    {
                        let further = reduced[self.count..].iter().map(mode);
                        found.extend(further.map(|mode| Found::new(model(*index), self.order, mode)));
                        known[*index] = Some((critical, found));
                        break;
                    }
                }
                if !space.extend()? {
                    break;
                }
            }
        }
        Ok(known)
    }

    /// The critical speeds of modes given by descending speed, and these modes, in ascending order; `None` if a residual is too large.
    /// The error of a speed is proportional to the square of the residual, and is then round-off.
    fn accurate(
        &self,
        model: &Model,
        descending: impl Iterator<Item = ModeAtSpeed>,
    ) -> Result<Option<FoundAt>, AnalysisError> {
        let mut residuals = Residuals::new(model, self.range, self.order, EquationForces::Undamped);
        let mut known = Vec::with_capacity(self.count);
        for mode in descending {
            let (found, residual) = named_with(&mut residuals, model, &mode)?;
            if residual.value.is_nan() || residual.value > ROOT_OF_ROUND_OFF {
                return Ok(None);
            }
            known.push((found, Found::new(model, self.order, mode)));
        }
        known.sort_by(|(a, _), (b, _)| a.speed.abs().total_cmp(&b.speed.abs()));
        Ok(Some(known.into_iter().unzip()))
    }
}

/// A step of the stiffness.
struct Step<'a> {
    /// Stiffness at the beginning and at the end, N/m.
    ends: [f64; 2],
    models: [&'a Model; 2],
    /// Modes at both ends.
    known: Vec<&'a Found>,
    /// Sense of rotation, which determines the flanks in contact.
    sense: f64,
}

/// A basis V of the space of the modes at both ends of a step, with k ≤ m vectors V = XT of the m modes X, orthonormal in the stiffness
/// K at the end.
struct StepSpace {
    /// X, n × m.
    shapes: DMatrix<Complex64>,
    /// BX, n × m.
    momenta: DMatrix<Complex64>,
    /// KX, n × m.
    forces: DMatrix<Complex64>,
    /// T, m × k.
    combinations: DMatrix<Complex64>,
    /// VᴴKV at the beginning, k × k.
    beginning: DMatrix<Complex64>,
    /// VᴴBV, k × k.
    inertia: DMatrix<Complex64>,
}

impl Step<'_> {
    fn space(&self) -> Result<StepSpace, AnalysisError> {
        let columns = |of: &dyn Fn(&Found) -> DVector<Complex64>| {
            DMatrix::from_columns(&self.known.iter().map(|mode| of(mode)).collect::<Vec<_>>())
        };
        let [from, to] = self.models;
        let multiply = |x: &[f64], out: &mut [f64]| to.multiply_stiffness(self.sense, true, x, out);
        let (shapes, momenta) = (columns(&|mode| mode.shape.clone()), columns(&|mode| mode.momentum.clone()));
        let forces = columns(&|mode| to.product(&mode.shape, multiply));
        let forms = |images: &DMatrix<Complex64>| {
            let columns = images.column_iter().map(|image| image.into_owned());
            let columns = columns.flat_map(|image| products(shapes.as_slice(), image.as_slice()));
            DMatrix::from_iterator(shapes.ncols(), shapes.ncols(), columns)
        };
        let stiffness = forms(&forces);
        let sizes = stiffness.diagonal().map(|value| value.re.max(f64::MIN_POSITIVE).sqrt());
        let scaled = DMatrix::from_fn(stiffness.nrows(), stiffness.ncols(), |row, column| {
            (stiffness[(row, column)] + stiffness[(column, row)].conj()) / (2.0 * sizes[row] * sizes[column])
        });
        let (values, vectors) = hermitian_eigen(&scaled)?;
        let kept: Vec<usize> = (0..values.len()).filter(|index| values[*index] > ROUND_OFF).collect();
        let combinations = DMatrix::from_fn(stiffness.nrows(), kept.len(), |row, column| {
            vectors[(row, kept[column])] / (sizes[row] * values[kept[column]].sqrt())
        });
        let projected = |matrix: &DMatrix<Complex64>| combinations.ad_mul(&(matrix * &combinations));
        let mut beginning = stiffness.clone();
        add_stiffness_change([to, from], shapes.as_slice(), &mut beginning);
        let (beginning, inertia) = (projected(&beginning), projected(&forms(&momenta)));
        Ok(StepSpace { shapes, momenta, forces, combinations, beginning, inertia })
    }
}

impl StepSpace {
    /// Approximations of the `count` lowest modes, in coordinates of the space, by ascending speed; `part` is the part of the step
    /// of the stiffness.
    fn modes(&self, part: f64, count: usize) -> Result<Vec<Found>, AnalysisError> {
        // The matrix is linear in the stiffness of the bearings.
        let mut matrix = &self.beginning * Complex64::from(1.0 - part);
        (0..matrix.nrows()).for_each(|index| matrix[(index, index)] += part);
        let Some(modes) = reduced_modes(matrix, &self.inertia, count)? else { return Ok(Vec::new()) };
        let mode = |mode: ReducedMode| Found {
            eigenvalue: Complex64::new(0.0, mode.frequency),
            momentum: &self.inertia * &mode.coordinates,
            shape: mode.coordinates,
        };
        Ok(modes.into_iter().map(mode).collect())
    }

    /// A mode in coordinates of the space.
    fn reduced(&self, mode: &Found) -> Found {
        let forces = DVector::from_vec(products(self.forces.as_slice(), mode.shape.as_slice()));
        let shape = self.combinations.ad_mul(&forces);
        Found { eigenvalue: mode.eigenvalue, momentum: &self.inertia * &shape, shape }
    }

    /// A mode of the space in all coordinates.
    fn full(&self, mode: &Found) -> Found {
        let weights = &self.combinations * &mode.shape;
        let sum = |columns: &DMatrix<Complex64>| {
            combination(columns.as_slice(), columns.nrows(), weights.as_slice(), columns.nrows()).into()
        };
        Found { eigenvalue: mode.eigenvalue, shape: sum(&self.shapes), momentum: sum(&self.momenta) }
    }
}

/// The lines up to a stiffness.
struct Lines {
    /// Number of critical speeds at each stiffness.
    count: usize,
    /// Number and mode of each line at the current stiffness, by ascending speed.
    alive: Vec<(usize, Found)>,
    /// Number of lines that have begun.
    started: usize,
}

impl Lines {
    /// Continues the lines over a step of the stiffness to the modes `found` at its end; there is none before the first stiffness.
    fn advance(&mut self, step: Option<&Step<'_>>, found: &[Found]) -> Result<(), AnalysisError> {
        let assignment = self.assignment(found);
        let Some(step) = step.filter(|_| assignment.as_ref().is_some_and(|assignment| !assignment.clear)) else {
            self.assign(found, assignment);
            return Ok(());
        };
        let space = step.space()?;
        let reduced = |(number, mode): &(usize, Found)| (*number, space.reduced(mode));
        let mut lines = Self { alive: self.alive.iter().map(reduced).collect(), ..*self };
        let found: Vec<Found> = found.iter().map(|mode| space.reduced(mode)).collect();
        lines.follow(&space, step.ends, step.ends, &found, 0)?;
        self.started = lines.started;
        self.alive = lines.alive.iter().map(|(number, mode)| (*number, space.full(mode))).collect();
        Ok(())
    }

    /// Continues the lines over a part of a step, between two stiffnesses, N/m, to the modes `found` at its end, all in coordinates
    /// of the space of the step between the stiffnesses `ends`.
    fn follow(
        &mut self,
        space: &StepSpace,
        ends: [f64; 2],
        [from, to]: [f64; 2],
        found: &[Found],
        halved: u32,
    ) -> Result<(), AnalysisError> {
        let assignment = self.assignment(found);
        if halved < MAX_HALVINGS && assignment.as_ref().is_some_and(|assignment| !assignment.clear) {
            let middle = if from > 0.0 && to > 0.0 { from.sqrt() * to.sqrt() } else { f64::midpoint(from, to) };
            let part = (middle - ends[0]) / (ends[1] - ends[0]);
            let between = space.modes(part, self.count.saturating_add(FURTHER_MODES))?;
            self.follow(space, ends, [from, middle], &between, halved + 1)?;
            return self.follow(space, ends, [middle, to], found, halved + 1);
        }
        self.assign(found, assignment);
        Ok(())
    }

    /// Which of the modes `found` continue which lines; `None` without modes.
    fn assignment(&self, found: &[Found]) -> Option<Assignment> {
        if found.is_empty() {
            return None;
        }
        let correlations: Vec<Vec<f64>> =
            self.alive.iter().map(|(_, line)| found.iter().map(|mode| line.correlation(mode)).collect()).collect();
        let before: Vec<Complex64> = self.alive.iter().map(|(_, line)| line.eigenvalue).collect();
        let after: Vec<Complex64> = found.iter().map(|mode| mode.eigenvalue).collect();
        // The last modes may leave the computed ones.
        let deciding = DECIDING_LINES.min(self.count).min(found.len());
        let common = |a: usize, b: usize| self.alive[a].1.correlation(&self.alive[b].1);
        Some(Assignment::new(&correlations, common, &before, &after, deciding))
    }

    /// Continues the lines to the modes `found`; others begin.
    fn assign(&mut self, found: &[Found], assignment: Option<Assignment>) {
        let mut numbers = vec![None; found.len()];
        if let Some(assignment) = &assignment {
            for ((line, index), kept) in self.alive.iter().zip(&assignment.states).zip(&assignment.kept) {
                if *kept > MIN_CONTINUATION {
                    numbers[*index] = Some(line);
                }
            }
        }
        let mut alive = Vec::new();
        for (mode, line) in found.iter().zip(numbers) {
            let distinct = found.iter().filter(|other| equal(other.eigenvalue, mode.eigenvalue)).count() == 1;
            alive.push(match line {
                // The shapes of equal critical speeds may be any combination.
                Some((number, known)) if !distinct => (*number, Found { eigenvalue: mode.eigenvalue, ..known.clone() }),
                Some((number, _)) => (*number, mode.clone()),
                None => {
                    self.started += 1;
                    (self.started - 1, mode.clone())
                }
            });
        }
        self.alive = alive;
    }
}

impl Found {
    fn new(model: &Model, order: f64, met: ModeAtSpeed) -> Self {
        let mass = model.product(&met.shape, |x, out| model.multiply_mass(x, out));
        let gyroscopic = model.product(&met.shape, |x, out| model.multiply_gyroscopic(x, out));
        let momentum = mass - gyroscopic * Complex64::new(0.0, 1.0 / order);
        let size = met.shape.dotc(&momentum).norm().max(f64::MIN_POSITIVE).sqrt();
        Self { eigenvalue: met.eigenvalue, shape: met.shape.unscale(size), momentum: momentum.unscale(size) }
    }

    /// |xᴴBx'|².
    fn correlation(&self, other: &Self) -> f64 {
        self.shape.dotc(&other.momentum).norm_sqr()
    }
}
