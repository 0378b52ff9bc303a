//! The error of a step, from what the polynomial of its loads misses.

use super::kernel;
use super::step::Stepper;
use crate::integrate::Halt;

/// Of a load that is not resolved, this part counts: the mean of |π|, and some more.
const UNRESOLVED: f64 = 0.5;

impl Stepper<'_> {
    /// Energy norm of the error of the last step. What the polynomial of its loads misses at either end tells the size
    /// and, by how much they differ, the pace of what it misses within.
    pub(super) fn error(&mut self, level: usize) -> f64 {
        if self.field.mesh_loads() == 0 {
            return 0.0;
        }
        let (loads, rule) = (self.field.loads(), &self.cache.rule);
        // π is odd or even about the middle.
        let even = if rule.stages() % 2 == 0 { 1.0 } else { -1.0 };
        let (begin, end) = (&mut self.defect, &mut self.changed);
        let meshes = begin.len();
        begin.copy_from_slice(&self.begin_load[..meshes]);
        end.copy_from_slice(&self.end_load[..meshes]);
        let [at_begin, at_end] = &rule.at_ends;
        for (load, (at_begin, at_end)) in self.loads.chunks_exact(loads).zip(at_begin.iter().zip(at_end)) {
            for ((begin, end), load) in begin.iter_mut().zip(end.iter_mut()).zip(load) {
                *begin -= at_begin * load;
                *end -= at_end * load;
            }
        }
        for (begin, end) in begin.iter_mut().zip(end) {
            (*begin, *end) = ((*end + even * *begin) / 2.0, *end - even * *begin);
        }
        let (size, change) = (self.bare(&self.defect), self.bare(&self.changed));
        self.defect_ratio = if change > 0.0 { change / size } else { 0.0 };
        self.unresolved_error = UNRESOLVED * size.max(change / 2.0);
        self.predicted_error(level, 1.0)
    }

    /// The error that the last one foretells for a step twice as long.
    pub(super) fn error_of_longer(&self, level: usize) -> f64 {
        self.predicted_error(level - 1, 2.0)
    }

    /// The error of a step of `level` that is so many times as long as the last one.
    ///
    /// Of a load that the modes do not outpace, the nodes miss what is orthogonal to all polynomials below s: next to
    /// nothing. One that changes faster than the step resolves, as at a kink, is missed by its whole size.
    fn predicted_error(&self, level: usize, longer: f64) -> f64 {
        let (step, stages) = (self.cache.time_grid.step(level), self.cache.rule.stages() as i32);
        let unresolved_error = (longer * self.defect_ratio).min(1.0).powi(stages);
        (self.cache.propagator(level).error(self.arch, &self.defect) + step * unresolved_error * self.unresolved_error)
            * longer.powi(stages)
    }

    /// Energy norm that what the polynomial of the loads misses at a part of the last step adds to a state in a second;
    /// the state there is `z`; `point` is room for what it sees, the others for its loads and those of the polynomial.
    pub(super) fn defect_at(
        &mut self,
        part: f64,
        elapsed: f64,
        z: &[f64],
        point: &mut [f64],
        [loads, polynomial]: [&mut [f64]; 2],
    ) -> Result<f64, Halt> {
        self.see(elapsed, z, point);
        self.load_at(elapsed, point, loads)?;
        self.loads_at(part, polynomial);
        for ((defect, load), polynomial) in self.changed.iter_mut().zip(loads).zip(polynomial) {
            *defect = *load - *polynomial;
        }
        Ok(UNRESOLVED * self.bare(&self.changed))
    }

    /// Energy norm that loads add to a state in a second.
    fn bare(&self, loads: &[f64]) -> f64 {
        kernel::form(self.arch, &self.cache.gram, loads).max(0.0).sqrt()
    }
}
