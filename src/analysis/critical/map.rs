//! Critical speeds against the bearing stiffness, as lines of the same mode.
//!
//! The modes x at the critical speeds of one model are orthogonal in B = M − iG/order, which does not depend on the
//! stiffness of the bearings: xᴴBx' = 0 and xᴴBx = 1. Modes at two stiffnesses are therefore assigned by |xᴴBx'|², in the same
//! way as those of a Campbell diagram at two speeds. The step of the stiffness is halved where the assignment is not clear.
//!
//! The modes X at both ends of a step span a space with few dimensions, in which those between are found: XᴴKX y = ω² XᴴBX y.
//! They only decide which modes at the end continue which at the beginning. Rigid-body motions N need no place in the space: every
//! mode satisfies NᴴBx = 0.

use std::cell::OnceCell;

use nalgebra::{Cholesky, DMatrix, DVector};
use num_complex::Complex64;

use super::super::assignment::{Assignment, equal};
use super::{Critical, modes, named, sense_of};
use crate::analysis::modes::FURTHER_MODES;
use crate::analysis::{AnalysisError, Interrupt, Threads};
use crate::linalg::hermitian_eigen;
use crate::modal::{CachedModel, ModeAtSpeed};
use crate::model::Model;
use crate::numerics::ROUND_OFF;

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

/// A mode at a critical speed.
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
    let models = threads.map(stiffnesses, model)?;
    let Some(first) = models.first() else { return Ok(Vec::new()) };
    let range = first.spectral_range(sense)?.clone();
    // The modes at each stiffness, and the critical speeds of the map.
    let found = threads.map(&models, |cached| {
        interrupt.check()?;
        let found = modes(cached, order, count.saturating_add(FURTHER_MODES))?;
        let critical = named(&cached.model, &range, &found[..count.min(found.len())], interrupt)?;
        let found: Vec<_> = found.into_iter().map(|met| Found::new(&cached.model, order, met)).collect();
        Ok((critical, found))
    })?;
    let mut lines = Lines { count, alive: Vec::new(), started: 0 };
    let mut map = Vec::new();
    let mut previous: Option<(f64, &CachedModel, &[Found])> = None;
    for ((stiffness, cached), (critical, found)) in stiffnesses.iter().zip(&models).zip(&found) {
        let step = previous.map(|(from, before, known)| Step {
            ends: [from, *stiffness],
            models: [&before.model, &cached.model],
            known: known.iter().chain(found).collect(),
            sense,
            space: OnceCell::new(),
        });
        lines.advance(step.as_ref().map(|step| (step, step.ends)), found, 0)?;
        previous = Some((*stiffness, cached, found));
        let point =
            |(critical, (line, _)): (&Critical, &(usize, Found))| CriticalPoint { critical: *critical, line: *line };
        map.push(critical.iter().zip(&lines.alive).map(point).collect());
    }
    Ok(map)
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
    space: OnceCell<StepSpace>,
}

/// A basis V of the space of the modes at both ends of a step, with k ≤ m vectors V = XT of the m modes X.
struct StepSpace {
    /// T, m × k.
    combinations: DMatrix<Complex64>,
    /// VᴴKV at both ends, k × k.
    stiffness: [DMatrix<Complex64>; 2],
    /// VᴴBV, k × k.
    inertia: DMatrix<Complex64>,
}

impl Step<'_> {
    fn space(&self) -> Result<&StepSpace, AnalysisError> {
        if let Some(known) = self.space.get() {
            return Ok(known);
        }
        let products = |images: &[DVector<Complex64>]| {
            DMatrix::from_fn(images.len(), images.len(), |row, column| self.known[row].shape.dotc(&images[column]))
        };
        let stiffness = self.models.map(|model| {
            let image =
                |mode: &&Found| model.product(&mode.shape, |x, out| model.multiply_stiffness(self.sense, true, x, out));
            products(&self.known.iter().map(image).collect::<Vec<_>>())
        });
        let momenta: Vec<_> = self.known.iter().map(|mode| mode.momentum.clone()).collect();
        // V is orthonormal in the sum of both stiffness matrices.
        let sum = &stiffness[0] + &stiffness[1];
        let sizes = sum.diagonal().map(|value| value.re.max(f64::MIN_POSITIVE).sqrt());
        let scaled = DMatrix::from_fn(sum.nrows(), sum.ncols(), |row, column| {
            (sum[(row, column)] + sum[(column, row)].conj()) / (2.0 * sizes[row] * sizes[column])
        });
        let (values, vectors) = hermitian_eigen(&scaled)?;
        let kept: Vec<usize> = (0..values.len()).filter(|index| values[*index] > ROUND_OFF).collect();
        let combinations = DMatrix::from_fn(sum.nrows(), kept.len(), |row, column| {
            vectors[(row, kept[column])] / (sizes[row] * values[kept[column]].sqrt())
        });
        let projected = |matrix: &DMatrix<Complex64>| combinations.ad_mul(&(matrix * &combinations));
        let space = StepSpace {
            stiffness: stiffness.each_ref().map(projected),
            inertia: projected(&products(&momenta)),
            combinations,
        };
        Ok(self.space.get_or_init(|| space))
    }

    /// Approximations of the `count` lowest modes at a stiffness between the ends, N/m, by ascending speed.
    fn modes(&self, stiffness: f64, count: usize) -> Result<Vec<Found>, AnalysisError> {
        let StepSpace { combinations, stiffness: ends, inertia } = self.space()?;
        let [from, to] = self.ends;
        // The matrix is linear in the stiffness of the bearings.
        let part = Complex64::from((stiffness - from) / (to - from));
        let matrix = &ends[0] * (1.0 - part) + &ends[1] * part;
        let Some(factor) = Cholesky::new(matrix) else { return Ok(Vec::new()) };
        let lower = factor.l();
        let half = lower.solve_lower_triangular(inertia);
        let Some(standard) = half.and_then(|half| lower.solve_lower_triangular(&half.adjoint())) else {
            return Ok(Vec::new());
        };
        let (values, vectors) = hermitian_eigen(&standard)?;
        // Descending 1/ω² is ascending ω.
        let positive = (0..values.len()).rev().filter(|index| values[*index] > 0.0).take(count);
        let mode = |index: usize| {
            let coordinates =
                lower.ad_solve_lower_triangular(&vectors.column(index))? / Complex64::from(values[index].sqrt());
            let weights = combinations * coordinates;
            let sum = |of: fn(&Found) -> &DVector<Complex64>| {
                let mut sum = DVector::zeros(self.models[0].len());
                self.known.iter().zip(&weights).for_each(|(mode, weight)| sum.axpy(*weight, of(mode), Complex64::ONE));
                sum
            };
            let frequency = values[index].sqrt().recip();
            Some(Found {
                eigenvalue: Complex64::new(0.0, frequency),
                shape: sum(|mode| &mode.shape),
                momentum: sum(|mode| &mode.momentum),
            })
        };
        Ok(positive.map_while(mode).collect())
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
    /// Continues the lines over a part of a step, between two stiffnesses, N/m, to the modes `found` at its end; there is none
    /// before the first stiffness.
    fn advance(
        &mut self,
        part: Option<(&Step<'_>, [f64; 2])>,
        found: &[Found],
        halved: u32,
    ) -> Result<(), AnalysisError> {
        let correlations: Vec<Vec<f64>> =
            self.alive.iter().map(|(_, line)| found.iter().map(|mode| line.correlation(mode)).collect()).collect();
        let before: Vec<Complex64> = self.alive.iter().map(|(_, line)| line.eigenvalue).collect();
        let after: Vec<Complex64> = found.iter().map(|mode| mode.eigenvalue).collect();
        let mut numbers = vec![None; found.len()];
        if !found.is_empty() {
            // The last modes may leave the computed ones.
            let deciding = DECIDING_LINES.min(self.count).min(found.len());
            let common = |a: usize, b: usize| self.alive[a].1.correlation(&self.alive[b].1);
            let assignment = Assignment::new(&correlations, common, &before, &after, deciding);
            if let Some((step, [from, to])) = part
                && !assignment.clear
                && halved < MAX_HALVINGS
            {
                let middle = if from > 0.0 && to > 0.0 { from.sqrt() * to.sqrt() } else { f64::midpoint(from, to) };
                let between = step.modes(middle, self.count.saturating_add(FURTHER_MODES))?;
                self.advance(Some((step, [from, middle])), &between, halved + 1)?;
                return self.advance(Some((step, [middle, to])), found, halved + 1);
            }
            for ((line, index), kept) in self.alive.iter().zip(&assignment.states).zip(&assignment.kept) {
                if *kept > MIN_CONTINUATION {
                    numbers[*index] = Some(line);
                }
            }
        }
        let mut alive = Vec::new();
        for (mode, line) in found.iter().zip(numbers) {
            let distinct = after.iter().filter(|value| equal(**value, mode.eigenvalue)).count() == 1;
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
        Ok(())
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
