//! The energy audit: works are integrated over the motion of every step by the three-point Gauss rule. Its error is of
//! higher order than that of a motion which steps resolve. Steps that are longer than what moves within them are halved
//! until that rule and Kronrod's extension of it to seven points (1965) agree, and the latter counts.

use super::Seen;
use crate::integrate::{Halt, System, Trajectory};
use crate::mesh::Law;
use crate::motion::Motion;

/// Abscissae on [0, 1], weights of Gauss and of Kronrod.
const RULE: [(f64, f64, f64); 7] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0, 0.134_244_044_934_166_7),
    (0.5, 8.0 / 18.0, 0.225_458_269_329_237_06),
    (0.887_298_334_620_741_7, 5.0 / 18.0, 0.134_244_044_934_166_7),
    (0.019_754_365_645_989_88, 0.0, 0.052_328_113_013_233_63),
    (0.282_878_125_326_598_7, 0.0, 0.200_698_707_387_981_1),
    (0.717_121_874_673_401_3, 0.0, 0.200_698_707_387_981_1),
    (0.980_245_634_354_010_1, 0.0, 0.052_328_113_013_233_63),
];
/// How many of them are Gauss's.
const GAUSS: usize = 3;

/// The rules agree where they differ by this part of all that has been done.
const SAME: f64 = 1e-8;
/// How often a step is halved at most.
const HALVINGS: usize = 20;

/// Indices of the works of teeth and damping.
const TEETH: usize = 4;
const DAMPING: usize = 5;

/// Works over a part of a step by either rule, and the sum of their sizes had nothing cancelled, J.
#[derive(Clone, Copy, Debug, Default)]
struct Works {
    by_gauss: [f64; 6],
    by_kronrod: [f64; 6],
    size: f64,
}

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
            if step.is_resolved() {
                let done = self.works_over(motion, step, begin, end - begin, &RULE[..GAUSS])?.by_gauss;
                self.add(done);
            } else {
                self.count_part(motion, step, (begin, end - begin), HALVINGS)?;
            }
            self.until = end;
        }
        Ok(self.works)
    }

    /// Counts what is done within a part of a step, which is halved so often at most.
    fn count_part(
        &mut self,
        motion: &mut Motion,
        step: &mut impl Trajectory,
        (begin, length): (f64, f64),
        halvings: usize,
    ) -> Result<(), Halt> {
        let works = self.works_over(motion, step, begin, length, &RULE)?;
        let missed: f64 = works.by_gauss.iter().zip(works.by_kronrod).map(|(a, b)| (a - b).abs()).sum();
        let so_far: f64 = self.works.iter().map(|work| work.abs()).sum();
        if halvings > 0 && missed > SAME * (so_far + works.size) {
            let half = length / 2.0;
            self.count_part(motion, step, (begin, half), halvings - 1)?;
            self.count_part(motion, step, (begin + half, half), halvings - 1)
        } else {
            self.add(works.by_kronrod);
            Ok(())
        }
    }

    fn add(&mut self, works: [f64; 6]) {
        self.works.iter_mut().zip(works).for_each(|(work, done)| *work += done);
    }

    /// The works over a part of a step.
    fn works_over(
        &mut self,
        motion: &mut Motion,
        step: &mut impl Trajectory,
        begin: f64,
        length: f64,
        rule: &[(f64, f64, f64)],
    ) -> Result<Works, Halt> {
        let mut works = Works::default();
        for (node, gauss, kronrod) in rule {
            let elapsed = begin + node * length;
            step.state(elapsed, &self.coordinates, &mut self.q, &mut self.v);
            let powers = motion.powers(elapsed, &self.q, &self.v);
            let powers = powers.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
            for (i, power) in powers.iter().enumerate() {
                works.by_gauss[i] += gauss * length * power;
                works.by_kronrod[i] += kronrod * length * power;
                works.size += kronrod * length * power.abs();
            }
        }
        Ok(works)
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
