//! The energy audit: works are integrated over the motion of every step by the three-point Gauss rule. Its error is of
//! higher order than that of a motion which steps resolve. Where steps are longer than what moves within them, the rules
//! of seven and of fifteen points that contain it (Patterson 1968) follow until two of them agree, and the latter counts;
//! a step on which none do is halved. The same holds for teeth with tip relief, whatever the step: the relief begins
//! within a step, and the power of the teeth jumps there.

use std::ops::Range;

use super::RecorderState;
use crate::integrate::{FirstOrderSystem, Halt, Trajectory, at_each};
use crate::mesh::ContactMode;
use crate::model::Model;
use crate::motion::EquationOfMotion;

/// Abscissae on [0, 1], and the weights of each rule.
const RULES: [(f64, [f64; 3]); 15] = [
    (0.112_701_665_379_258_31, [5.0 / 18.0, 0.134_244_044_934_166_72, 0.067_207_627_621_892_11]),
    (0.5, [8.0 / 18.0, 0.225_458_269_329_237_07, 0.112_755_249_899_103_34]),
    (0.887_298_334_620_741_7, [5.0 / 18.0, 0.134_244_044_934_166_72, 0.067_207_627_621_892_11]),
    (0.019_754_365_645_989_858, [0.0, 0.052_328_113_013_233_63, 0.025_801_641_498_539_87]),
    (0.282_878_125_326_598_73, [0.0, 0.200_698_707_387_981_12, 0.100_314_264_688_494_51]),
    (0.717_121_874_673_401_3, [0.0, 0.200_698_707_387_981_12, 0.100_314_264_688_494_51]),
    (0.980_245_634_354_010_1, [0.0, 0.052_328_113_013_233_63, 0.025_801_641_498_539_87]),
    (0.003_084_018_393_622_489, [0.0, 0.0, 0.008_500_859_814_970_13]),
    (0.055_770_383_563_871_5, [0.0, 0.0, 0.046_463_597_657_562_27]),
    (0.189_448_526_631_386_8, [0.0, 0.0, 0.085_755_954_568_195_7]),
    (0.388_306_656_785_516_57, [0.0, 0.0, 0.109_578_429_200_793_75]),
    (0.611_693_343_214_483_4, [0.0, 0.0, 0.109_578_429_200_793_75]),
    (0.810_551_473_368_613_2, [0.0, 0.0, 0.085_755_954_568_195_7]),
    (0.944_229_616_436_128_5, [0.0, 0.0, 0.046_463_597_657_562_27]),
    (0.996_915_981_606_377_5, [0.0, 0.0, 0.008_500_859_814_970_13]),
];
/// How many of them each rule uses.
const POINTS: [usize; 3] = [3, 7, 15];

/// Two rules agree where they differ by this part of all that has been done.
const SAME: f64 = 1e-8;
/// How often a step is halved at most.
const HALVINGS: usize = 20;

/// Indices of the works of teeth and damping.
const TEETH: usize = 4;
const DAMPING: usize = 5;

/// Works over a part of a step by each rule, and the sum of their sizes had nothing cancelled, J.
#[derive(Clone, Copy, Debug, Default)]
struct Works {
    by: [[f64; 6]; 3],
    size: [f64; 3],
}

/// Works since the start of a run, J.
#[derive(Clone, Debug)]
pub(super) struct Audit {
    works: [f64; 6],
    /// Elapsed time up to which they count.
    until: f64,
    coordinates: Vec<usize>,
    /// Whether powers may jump within a step: tip relief begins at instants that no step ends at.
    kinked: bool,
    /// At the instants of a rule, one after the other.
    q: Vec<f64>,
    v: Vec<f64>,
    /// The laws of the steps that are counted; none before the first.
    contact_modes: Option<Vec<i64>>,
}

impl Audit {
    /// An audit that begins at `start` (elapsed time).
    pub fn new(start: f64, model: &Model) -> Self {
        let len = model.len();
        Self {
            kinked: model.meshes.iter().any(|mesh| mesh.teeth.is_relieved()),
            works: [0.0; 6],
            until: start,
            coordinates: (0..len).collect(),
            q: vec![0.0; RULES.len() * len],
            v: vec![0.0; RULES.len() * len],
            contact_modes: None,
        }
    }

    /// Goes on from what the same run has counted.
    pub fn take_up(&mut self, seen: &RecorderState) {
        (self.works, self.until) = (seen.works, seen.until);
    }

    /// Works, and the elapsed time up to which they count.
    pub fn counted(&self) -> ([f64; 6], f64) {
        (self.works, self.until)
    }

    /// Counts what is done within a step, up to `end`; returns the works until then.
    pub fn count(
        &mut self,
        motion: &mut EquationOfMotion,
        step: &mut impl Trajectory,
        end: f64,
    ) -> Result<[f64; 6], Halt> {
        let begin = self.until.max(step.begin());
        if end > begin {
            if step.is_resolved() && !self.kinked {
                let mut works = Works::default();
                self.work(motion, step, (begin, end - begin), 0..POINTS[0], &mut works)?;
                self.add(works.by[0]);
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
        motion: &mut EquationOfMotion,
        step: &mut impl Trajectory,
        (begin, length): (f64, f64),
        halvings: usize,
    ) -> Result<(), Halt> {
        let so_far: f64 = self.works.iter().map(|work| work.abs()).sum();
        let mut works = Works::default();
        let mut done = 0;
        for (rule, points) in POINTS.into_iter().enumerate().skip(1) {
            self.work(motion, step, (begin, length), done..points, &mut works)?;
            done = points;
            let missed: f64 = works.by[rule].iter().zip(works.by[rule - 1]).map(|(a, b)| (a - b).abs()).sum();
            let is_last = halvings == 0 && done == RULES.len();
            if is_last || missed <= SAME * (so_far + works.size[rule]) {
                self.add(works.by[rule]);
                return Ok(());
            }
        }
        let half = length / 2.0;
        self.count_part(motion, step, (begin, half), halvings - 1)?;
        self.count_part(motion, step, (begin + half, half), halvings - 1)
    }

    fn add(&mut self, works: [f64; 6]) {
        self.works.iter_mut().zip(works).for_each(|(work, done)| *work += done);
    }

    /// Adds what these points tell of a part of a step to its works.
    fn work(
        &mut self,
        motion: &mut EquationOfMotion,
        step: &mut impl Trajectory,
        (begin, length): (f64, f64),
        points: Range<usize>,
        works: &mut Works,
    ) -> Result<(), Halt> {
        let (len, count) = (self.coordinates.len(), points.len());
        let instants = RULES.map(|(at, _)| begin + at * length);
        let instants = &instants[points.clone()];
        let (q, v) = (&mut self.q[..count * len], &mut self.v[..count * len]);
        step.states(instants, &self.coordinates, q, v);
        for ((_, weights), (elapsed, q, v)) in RULES[points].iter().zip(at_each(instants, q, v)) {
            let powers = motion.powers(elapsed, q, v);
            let powers = powers.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
            for ((by, size), weight) in works.by.iter_mut().zip(&mut works.size).zip(weights) {
                for (work, power) in by.iter_mut().zip(powers) {
                    *work += weight * length * power;
                    *size += weight * length * power.abs();
                }
            }
        }
        Ok(())
    }

    /// Sets the laws of the steps to come. Pairs that come into contact in a jump bring energy with them, which is work
    /// of the teeth; flanks that part while their damping still holds them drop what they store, which is damping.
    pub fn switch(
        &mut self,
        motion: &mut EquationOfMotion,
        elapsed: f64,
        read: &mut dyn FnMut(&mut [f64], &mut [f64]),
        contact_modes: &[i64],
    ) {
        let len = self.coordinates.len();
        let (q, v) = (&mut self.q[..len], &mut self.v[..len]);
        read(q, v);
        let before = motion.mesh_energy(elapsed, q, v);
        motion.set_contact_modes(contact_modes);
        let Some(old) = self.contact_modes.replace(contact_modes.to_vec()) else {
            return;
        };
        let flanks = |contact_modes: &[i64]| {
            contact_modes.chunks_exact(ContactMode::CODE).map(|code| code[0]).collect::<Vec<_>>()
        };
        let source = if flanks(&old) == flanks(contact_modes) { TEETH } else { DAMPING };
        // Base circles that overlap stop the run elsewhere.
        if let (Ok(before), Ok(after)) = (before, motion.mesh_energy(elapsed, q, v)) {
            self.works[source] += after - before;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{POINTS, RULES};

    #[test]
    fn rules_integrate_polynomials() {
        for (rule, (points, degree)) in POINTS.into_iter().zip([5, 11, 23]).enumerate() {
            assert!(RULES[points..].iter().all(|(_, weights)| weights[rule] == 0.0));
            // About the middle: odd powers vanish.
            let integral = |power: i32| {
                RULES.iter().map(|(at, weights)| weights[rule] * (2.0 * at - 1.0).powi(power)).sum::<f64>()
            };
            let exact = |power: i32| if power % 2 == 0 { 1.0 / f64::from(power + 1) } else { 0.0 };
            let error = |power: i32| (integral(power) - exact(power)).abs();
            // As many terms as points are rounded.
            assert!((0..=degree).all(|power| error(power) < points as f64 * f64::EPSILON));
            assert!(error(degree + 1) > 1e-9);
        }
    }
}
