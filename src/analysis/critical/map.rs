//! Critical speeds against the bearing stiffness, as lines of the same mode.
//!
//! The modes x at the critical speeds of one model are orthogonal in B = M − iG/order, which does not depend on the
//! stiffness of the bearings: xᴴBx' = 0 and xᴴBx = 1. Modes at two stiffnesses are therefore assigned by |xᴴBx'|², in the same
//! way as those of a Campbell diagram at two speeds. The step of the stiffness is halved where the assignment is not clear.

use nalgebra::DVector;
use num_complex::Complex64;

use super::super::assignment::{Assignment, equal};
use super::{Critical, modes, named};
use crate::analysis::{AnalysisError, Interrupt, Threads};
use crate::modal::{CachedModel, ModeAtSpeed};
use crate::model::Model;
use crate::scene::EntryPath;

/// Largest number of times that a step of the stiffness is halved.
const MAX_HALVINGS: u32 = 6;
/// Number of the lowest lines for which steps are halved.
const DECIDING_LINES: usize = 16;
/// Number of modes that are computed beyond those of the map.
const FURTHER_MODES: usize = 4;
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
    /// Speed and eigenvalue.
    met: ModeAtSpeed,
    /// x with |xᴴBx| = 1, n entries in the order of the core.
    shape: DVector<Complex64>,
    /// B x, n entries.
    momentum: DVector<Complex64>,
}

/// The lowest `count` critical speeds at each of the `stiffnesses`, N/m, in ascending order; `at` gives the model of a stiffness,
/// with the same coordinates for all of them.
///
/// # Errors
/// [`AnalysisError`] if `order` is not positive, a stiffness is invalid, a decomposition fails, a mode does not satisfy the
/// equations of motion, or `interrupt` requests a stop.
pub fn critical_speed_map(
    at: impl Fn(f64) -> Result<Model, AnalysisError> + Sync,
    stiffnesses: &[f64],
    order: f64,
    count: usize,
    threads: &Threads,
    interrupt: &Interrupt,
) -> Result<Vec<Vec<CriticalPoint>>, AnalysisError> {
    EntryPath::root("order").positive(order)?;
    let problem = MapProblem { at, order, count, interrupt };
    // The modes at each stiffness, and the critical speeds of the map.
    let found = threads.map(stiffnesses, |stiffness| {
        let (cached, found) = problem.modes(*stiffness)?;
        let named = found.iter().take(count).map(|met| named(&cached, &met.met, interrupt));
        Ok((named.collect::<Result<Vec<_>, _>>()?, found))
    })?;
    let mut lines = Lines { problem: &problem, alive: Vec::new(), started: 0 };
    let mut map = Vec::new();
    let mut previous = None;
    for (stiffness, (critical, found)) in stiffnesses.iter().zip(found) {
        lines.advance(previous, *stiffness, &found, 0)?;
        previous = Some(*stiffness);
        let point = |(critical, (line, _)): (Critical, &(usize, Found))| CriticalPoint { critical, line: *line };
        map.push(critical.into_iter().zip(&lines.alive).map(point).collect());
    }
    Ok(map)
}

/// What is the same at all stiffnesses.
struct MapProblem<'a, F> {
    at: F,
    order: f64,
    /// Number of critical speeds at each stiffness.
    count: usize,
    interrupt: &'a Interrupt,
}

impl<F: Fn(f64) -> Result<Model, AnalysisError>> MapProblem<'_, F> {
    /// The model at a stiffness, N/m, and its modes by ascending speed.
    fn modes(&self, stiffness: f64) -> Result<(CachedModel, Vec<Found>), AnalysisError> {
        self.interrupt.check()?;
        // Without damping, the internal damping of a shaft has no circulatory forces either.
        let model = (self.at)(stiffness)?;
        let cached = CachedModel::new(if model.needs_speed() { model.with_tables_at(0.0)? } else { model });
        let found = modes(&cached, self.order, self.count.saturating_add(FURTHER_MODES))?;
        let found = found.into_iter().map(|met| Found::new(&cached.model, self.order, met)).collect();
        Ok((cached, found))
    }
}

/// The lines up to a stiffness.
struct Lines<'a, F> {
    problem: &'a MapProblem<'a, F>,
    /// Number and mode of each line at the current stiffness, by ascending speed.
    alive: Vec<(usize, Found)>,
    /// Number of lines that have begun.
    started: usize,
}

impl<F: Fn(f64) -> Result<Model, AnalysisError>> Lines<'_, F> {
    /// Continues the lines to the modes at a stiffness; `from` is the stiffness of the lines, both N/m.
    fn advance(
        &mut self,
        from: Option<f64>,
        stiffness: f64,
        found: &[Found],
        halved: u32,
    ) -> Result<(), AnalysisError> {
        let correlations: Vec<Vec<f64>> =
            self.alive.iter().map(|(_, line)| found.iter().map(|mode| line.correlation(mode)).collect()).collect();
        let before: Vec<Complex64> = self.alive.iter().map(|(_, line)| line.met.eigenvalue).collect();
        let after: Vec<Complex64> = found.iter().map(|mode| mode.met.eigenvalue).collect();
        let mut numbers = vec![None; found.len()];
        if !found.is_empty() {
            // The last modes may leave the computed ones.
            let deciding = DECIDING_LINES.min(self.problem.count).min(found.len());
            let common = |a: usize, b: usize| self.alive[a].1.correlation(&self.alive[b].1);
            let assignment = Assignment::new(&correlations, common, &before, &after, deciding);
            if let Some(from) = from.filter(|_| !assignment.clear && halved < MAX_HALVINGS) {
                let middle = if from > 0.0 && stiffness > 0.0 {
                    from.sqrt() * stiffness.sqrt()
                } else {
                    f64::midpoint(from, stiffness)
                };
                let (_, between) = self.problem.modes(middle)?;
                self.advance(Some(from), middle, &between, halved + 1)?;
                return self.advance(Some(middle), stiffness, found, halved + 1);
            }
            for ((line, index), kept) in self.alive.iter().zip(&assignment.states).zip(&assignment.kept) {
                if *kept > MIN_CONTINUATION {
                    numbers[*index] = Some(line);
                }
            }
        }
        let mut alive = Vec::new();
        for (mode, line) in found.iter().zip(numbers) {
            let distinct = after.iter().filter(|value| equal(**value, mode.met.eigenvalue)).count() == 1;
            alive.push(match line {
                // The shapes of equal critical speeds may be any combination.
                Some((number, known)) if !distinct => (*number, Found { met: mode.met.clone(), ..known.clone() }),
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
        Self { shape: met.shape.unscale(size), momentum: momentum.unscale(size), met }
    }

    /// |xᴴBx'|².
    fn correlation(&self, other: &Self) -> f64 {
        self.shape.dotc(&other.momentum).norm_sqr()
    }
}
