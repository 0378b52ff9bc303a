//! Energy audit: integrates the power of every source of energy over each step.
//!
//! If the steps resolve every mode, the three-point Gauss rule is sufficient, because its error is of higher order than
//! that of the motion. Otherwise the nested rules of seven and fifteen points (Patterson 1968) follow until two rules
//! agree. A step on which none agree is halved. This also applies to teeth with tip relief, because the relief starts
//! within a step and the power of the teeth jumps there.

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
/// Number of abscissae of each rule.
const POINTS: [usize; 3] = [3, 7, 15];

/// Two rules agree if they differ by less than this fraction of the total work.
const AGREEMENT: f64 = 1e-8;
/// Largest number of halvings of a step.
const MAX_HALVINGS: usize = 20;

/// Indices of the works of teeth and damping.
const TEETH: usize = 4;
const DAMPING: usize = 5;

/// Works over a part of a step, J.
#[derive(Clone, Copy, Debug, Default)]
struct Works {
    /// Work of every source, for each rule.
    by_rule: [[f64; 6]; 3],
    /// Integral of the absolute powers, for each rule.
    magnitude: [f64; 3],
}

/// Works since the start of a run, J.
#[derive(Clone, Debug)]
pub(super) struct Audit {
    works: [f64; 6],
    /// Elapsed time up to which the works are integrated, s.
    until: f64,
    /// Indices of all coordinates.
    coordinates: Vec<usize>,
    /// Whether powers can jump within a step, because tip relief starts within it.
    has_jumps: bool,
    /// Scratch: displacements and velocities at the abscissae of a rule, one vector after the other.
    q: Vec<f64>,
    v: Vec<f64>,
    /// Contact modes of the current step as integer codes; none before the first step.
    contact_modes: Option<Vec<i64>>,
}

impl Audit {
    /// Creates an audit that begins at the elapsed time `start`, s.
    pub fn new(start: f64, model: &Model) -> Self {
        let len = model.len();
        Self {
            has_jumps: model.meshes.iter().any(|mesh| mesh.teeth.is_relieved()),
            works: [0.0; 6],
            until: start,
            coordinates: (0..len).collect(),
            q: vec![0.0; RULES.len() * len],
            v: vec![0.0; RULES.len() * len],
            contact_modes: None,
        }
    }

    /// Continues from a checkpoint.
    pub fn resume(&mut self, recorder_state: &RecorderState) {
        (self.works, self.until) = (recorder_state.works, recorder_state.until);
    }

    /// Works since the start, J, and the elapsed time up to which they are integrated, s.
    pub fn works(&self) -> ([f64; 6], f64) {
        (self.works, self.until)
    }

    /// Integrates the works over a step up to `end`. Returns the works since the start of the run, J.
    pub fn integrate(
        &mut self,
        motion: &mut EquationOfMotion,
        step: &mut impl Trajectory,
        end: f64,
    ) -> Result<[f64; 6], Halt> {
        let begin = self.until.max(step.begin());
        if end > begin {
            if step.is_resolved() && !self.has_jumps {
                let mut works = Works::default();
                self.add_points(motion, step, (begin, end - begin), 0..POINTS[0], &mut works)?;
                self.add(works.by_rule[0]);
            } else {
                self.integrate_part(motion, step, (begin, end - begin), MAX_HALVINGS)?;
            }
            self.until = end;
        }
        Ok(self.works)
    }

    /// Integrates the works over a part of a step, with at most this number of halvings.
    fn integrate_part(
        &mut self,
        motion: &mut EquationOfMotion,
        step: &mut impl Trajectory,
        (begin, length): (f64, f64),
        halvings: usize,
    ) -> Result<(), Halt> {
        let total: f64 = self.works.iter().map(|work| work.abs()).sum();
        let mut works = Works::default();
        let mut evaluated = 0;
        for (rule, points) in POINTS.into_iter().enumerate().skip(1) {
            self.add_points(motion, step, (begin, length), evaluated..points, &mut works)?;
            evaluated = points;
            let difference: f64 =
                works.by_rule[rule].iter().zip(works.by_rule[rule - 1]).map(|(a, b)| (a - b).abs()).sum();
            let is_last = halvings == 0 && evaluated == RULES.len();
            if is_last || difference <= AGREEMENT * (total + works.magnitude[rule]) {
                self.add(works.by_rule[rule]);
                return Ok(());
            }
        }
        let half = length / 2.0;
        self.integrate_part(motion, step, (begin, half), halvings - 1)?;
        self.integrate_part(motion, step, (begin + half, half), halvings - 1)
    }

    fn add(&mut self, works: [f64; 6]) {
        self.works.iter_mut().zip(works).for_each(|(work, added)| *work += added);
    }

    /// Adds the contribution of some abscissae to the works over a part of a step.
    fn add_points(
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
            for ((by_rule, magnitude), weight) in works.by_rule.iter_mut().zip(&mut works.magnitude).zip(weights) {
                for (work, power) in by_rule.iter_mut().zip(powers) {
                    *work += weight * length * power;
                    *magnitude += weight * length * power.abs();
                }
            }
        }
        Ok(())
    }

    /// Sets the contact modes of the following steps. The mesh energy jumps at a contact change. The jump counts as work of
    /// the teeth if tooth pairs enter or leave contact. It counts as dissipation if flanks separate, because damping can
    /// hold flanks together that still store energy.
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
        // The integrator reports overlapping base circles.
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
            // Integrals of odd powers about the middle vanish.
            let integral = |power: i32| {
                RULES.iter().map(|(at, weights)| weights[rule] * (2.0 * at - 1.0).powi(power)).sum::<f64>()
            };
            let exact = |power: i32| if power % 2 == 0 { 1.0 / f64::from(power + 1) } else { 0.0 };
            let error = |power: i32| (integral(power) - exact(power)).abs();
            // Each point contributes one rounding error.
            assert!((0..=degree).all(|power| error(power) < points as f64 * f64::EPSILON));
            assert!(error(degree + 1) > 1e-9);
        }
    }
}
