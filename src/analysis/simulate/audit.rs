//! The energy audit: works are integrated over the interpolated motion of every step, by the three-point Gauss rule,
//! whose error is of higher order than that of the motion.

use super::Seen;
use crate::integrate::{Halt, System, Trajectory};
use crate::mesh::Law;
use crate::motion::Motion;

/// Abscissae on [0, 1] and weights.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Indices of the works of teeth and damping.
const TEETH: usize = 4;
const DAMPING: usize = 5;

/// Works since the start of a run, J.
#[derive(Clone, Debug)]
pub(super) struct Audit {
    works: [f64; 6],
    /// Elapsed time up to which they count.
    until: f64,
    coordinates: Vec<usize>,
    q: Vec<f64>,
    v: Vec<f64>,
    /// The laws of the steps that are counted; none before the first.
    laws: Option<Vec<i64>>,
}

impl Audit {
    /// An audit that begins at `start` (elapsed time) for states of `len` displacements.
    pub fn new(start: f64, len: usize) -> Self {
        Self {
            works: [0.0; 6],
            until: start,
            coordinates: (0..len).collect(),
            q: vec![0.0; len],
            v: vec![0.0; len],
            laws: None,
        }
    }

    /// Goes on from what the same run has counted.
    pub fn take_up(&mut self, seen: &Seen) {
        (self.works, self.until) = (seen.works, seen.until);
    }

    /// Works, and the elapsed time up to which they count.
    pub fn counted(&self) -> ([f64; 6], f64) {
        (self.works, self.until)
    }

    /// Counts what is done within a step, up to `end`; returns the works until then.
    pub fn count(&mut self, motion: &mut Motion, step: &mut impl Trajectory, end: f64) -> Result<[f64; 6], Halt> {
        let begin = self.until.max(step.begin());
        if end > begin {
            let part = (end - begin) / step.parts() as f64;
            for from in (0..step.parts()).map(|i| begin + i as f64 * part) {
                for (node, weight) in GAUSS {
                    let elapsed = from + node * part;
                    step.state(elapsed, &self.coordinates, &mut self.q, &mut self.v);
                    let powers = motion.powers(elapsed, &self.q, &self.v);
                    let powers = powers.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
                    for (work, power) in self.works.iter_mut().zip(powers) {
                        *work += weight * part * power;
                    }
                }
            }
            self.until = end;
        }
        Ok(self.works)
    }

    /// Sets the laws of the steps to come. Pairs that come into contact in a jump bring energy with them, which is work
    /// of the teeth; flanks that part while their damping still holds them drop what they store, which is damping.
    pub fn switch(
        &mut self,
        motion: &mut Motion,
        elapsed: f64,
        read: &mut dyn FnMut(&mut [f64], &mut [f64]),
        laws: &[i64],
    ) {
        read(&mut self.q, &mut self.v);
        let (q, v) = (&self.q, &self.v);
        let before = motion.mesh_energy(elapsed, q, v);
        motion.set_laws(laws);
        let Some(old) = self.laws.replace(laws.to_vec()) else {
            return;
        };
        let flanks = |laws: &[i64]| laws.chunks_exact(Law::CODE).map(|code| code[0]).collect::<Vec<_>>();
        let source = if flanks(&old) == flanks(laws) { TEETH } else { DAMPING };
        // Base circles that overlap stop the run elsewhere.
        if let (Ok(before), Ok(after)) = (before, motion.mesh_energy(elapsed, q, v)) {
            self.works[source] += after - before;
        }
    }
}
