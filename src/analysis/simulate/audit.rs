//! Energy audit: integrates the power of every source of energy over each step.
//!
//! If the steps resolve every mode, the three-point Gauss rule is sufficient, because its error is of higher order than
//! that of the motion. Otherwise the nested rules of seven and fifteen points (Patterson 1968) follow until two rules
//! agree. A step on which none agree is halved. Works at instants within a step are integrals of polynomials through the same powers. This also applies to teeth with tip relief, because the relief starts
//! within a step and the power of the teeth jumps there.

use std::ops::Range;

use super::RecorderState;
use crate::integrate::{FirstOrderSystem, Halt, NESTED_RULES as RULES, RULE_POINTS as POINTS, Trajectory, at_each};
use crate::mesh::ContactMode;
use crate::model::Model;
use crate::motion::{EquationOfMotion, PowerCoordinates, PowerLoads};

/// Two rules agree if they differ by less than this multiple of the tolerance of the run, but at least and at most by these
/// fractions, times the total work. The difference is the error of the rule with fewer points.
const AGREEMENT: f64 = 0.1;
const AGREEMENTS: [f64; 2] = [1e-9, 1e-6];
/// Largest number of halvings of a step.
const MAX_HALVINGS: usize = 20;

/// Indices of the works of teeth and damping.
const TEETH: usize = 4;
const DAMPING: usize = 5;

/// A part of a step with the powers at its abscissae.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Elapsed time at the beginning, s.
    begin: f64,
    /// Length, s.
    length: f64,
    /// The rule with which its works are integrated.
    rule: usize,
    /// Powers of every source, W.
    powers: [[f64; 6]; RULES.len()],
}

impl Piece {
    fn new(begin: f64, length: f64) -> Self {
        Self { begin, length, rule: 0, powers: [[0.0; 6]; RULES.len()] }
    }

    /// Work of every source with a rule, J.
    fn works(&self, rule: usize) -> [f64; 6] {
        self.sum(rule, |power| power)
    }

    /// Integral of the absolute powers with a rule, J.
    fn magnitude(&self, rule: usize) -> f64 {
        self.sum(rule, f64::abs).iter().sum()
    }

    fn sum(&self, rule: usize, term: impl Fn(f64) -> f64) -> [f64; 6] {
        let mut sums = [0.0; 6];
        for ((_, weights), powers) in RULES[..POINTS[rule]].iter().zip(&self.powers) {
            for (sum, power) in sums.iter_mut().zip(powers) {
                *sum += weights[rule] * self.length * term(*power);
            }
        }
        sums
    }

    /// Work of every source from the beginning to the fraction `part`, J: the integral of the expansion of the powers in
    /// Legendre polynomials, whose coefficients the rule gives.
    fn works_until(&self, part: f64) -> [f64; 6] {
        let degree = DEGREES[self.rule];
        let at = legendre(2.0 * part - 1.0);
        let mut works = [0.0; 6];
        for ((node, weights), powers) in RULES[..POINTS[self.rule]].iter().zip(&self.powers) {
            let values = legendre(2.0 * node - 1.0);
            // (2k + 1) times the integral of the polynomial P_k from 0 to the fraction is (P_{k+1} - P_{k-1})/2.
            let higher = (1..=degree).map(|k| values[k] * (at[k + 1] - at[k - 1]) / 2.0).sum::<f64>();
            let weight = weights[self.rule] * self.length * (part + higher);
            works.iter_mut().zip(powers).for_each(|(work, power)| *work += weight * power);
        }
        works
    }
}

/// Degrees of the polynomials whose coefficients each rule gives: products of two of them are integrated exactly.
const DEGREES: [usize; 3] = [2, 5, 11];

/// The Legendre polynomials P_0 to P_12 at x in [-1, 1].
fn legendre(x: f64) -> [f64; 13] {
    let mut values = [1.0; 13];
    values[1] = x;
    for k in 1..12 {
        let order = k as f64;
        values[k + 1] = ((2.0 * order + 1.0) * x * values[k] - order * values[k - 1]) / (order + 1.0);
    }
    values
}

/// Works since the start of a run, J.
#[derive(Clone, Debug)]
pub(super) struct Audit {
    works: [f64; 6],
    /// Elapsed time up to which the works are integrated, s.
    until: f64,
    /// Works at the beginning of the last step, and the parts of the step.
    works_before: [f64; 6],
    pieces: Vec<Piece>,
    loads: PowerLoads,
    /// Coordinates from which powers follow, and all of them, ascending.
    selection: PowerCoordinates,
    coordinates: Vec<usize>,
    /// Number of all coordinates.
    len: usize,
    /// Difference of two rules that agree, as a fraction of the total work.
    agreement: f64,
    /// Whether powers can jump within a step, because tip relief starts within it.
    has_jumps: bool,
    /// Scratch: displacements and velocities at the abscissae of a rule, one vector after the other.
    q: Vec<f64>,
    v: Vec<f64>,
    /// Contact modes of the current step as integer codes; none before the first step.
    contact_modes: Option<Vec<i64>>,
}

impl Audit {
    /// Creates an audit of a run with a relative tolerance that begins at the elapsed time `start`, s.
    pub fn new(start: f64, tolerance: f64, model: &Model) -> Self {
        let selection = PowerCoordinates::new(model);
        let combined = selection.combinations.iter().flatten().map(|(index, _)| index);
        let mut coordinates: Vec<usize> =
            selection.displacements.iter().chain(&selection.velocities).chain(combined).copied().collect();
        coordinates.sort_unstable();
        coordinates.dedup();
        let room = RULES.len() * (model.len() + selection.combinations.len());
        Self {
            has_jumps: model.meshes.iter().any(|mesh| mesh.teeth.is_relieved()),
            works: [0.0; 6],
            until: start,
            works_before: [0.0; 6],
            pieces: Vec::new(),
            coordinates,
            len: model.len(),
            loads: PowerLoads::new(model),
            agreement: (AGREEMENT * tolerance).clamp(AGREEMENTS[0], AGREEMENTS[1]),
            selection,
            q: vec![0.0; room],
            v: vec![0.0; room],
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

    /// Integrates the works over a step up to `end`.
    pub fn integrate(&mut self, motion: &EquationOfMotion, step: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        let begin = self.until.max(step.begin());
        if end > begin {
            self.works_before = self.works;
            self.pieces.clear();
            let piece = Piece::new(begin, end - begin);
            if step.is_resolved() && !self.has_jumps {
                let mut piece = piece;
                self.evaluate(motion, step, 0..POINTS[0], &mut piece)?;
                self.keep(piece);
            } else {
                self.integrate_piece(motion, step, piece, MAX_HALVINGS)?;
            }
            self.until = end;
        }
        Ok(())
    }

    /// Works since the start of the run at an instant of the step that was integrated last, J.
    pub fn works_at(&self, elapsed: f64) -> [f64; 6] {
        if elapsed >= self.until {
            return self.works;
        }
        let mut works = self.works_before;
        for piece in self.pieces.iter().take_while(|piece| piece.begin < elapsed) {
            let part = ((elapsed - piece.begin) / piece.length).min(1.0);
            let own = if part < 1.0 { piece.works_until(part) } else { piece.works(piece.rule) };
            works.iter_mut().zip(own).for_each(|(work, added)| *work += added);
        }
        works
    }

    /// Integrates the works over a part of a step, with at most this number of halvings.
    fn integrate_piece(
        &mut self,
        motion: &EquationOfMotion,
        step: &mut impl Trajectory,
        mut piece: Piece,
        halvings: usize,
    ) -> Result<(), Halt> {
        let total: f64 = self.works.iter().map(|work| work.abs()).sum();
        let mut evaluated = 0;
        for (rule, points) in POINTS.into_iter().enumerate().skip(1) {
            self.evaluate(motion, step, evaluated..points, &mut piece)?;
            evaluated = points;
            let difference: f64 = piece.works(rule).iter().zip(piece.works(rule - 1)).map(|(a, b)| (a - b).abs()).sum();
            let is_last = halvings == 0 && evaluated == RULES.len();
            if is_last || difference <= self.agreement * (total + piece.magnitude(rule)) {
                piece.rule = rule;
                self.keep(piece);
                return Ok(());
            }
        }
        let half = piece.length / 2.0;
        self.integrate_piece(motion, step, Piece::new(piece.begin, half), halvings - 1)?;
        self.integrate_piece(motion, step, Piece::new(piece.begin + half, half), halvings - 1)
    }

    /// Adds the works of a part of the step.
    fn keep(&mut self, piece: Piece) {
        self.works.iter_mut().zip(piece.works(piece.rule)).for_each(|(work, added)| *work += added);
        self.pieces.push(piece);
    }

    /// Evaluates the powers at some abscissae of a part of the step.
    fn evaluate(
        &mut self,
        motion: &EquationOfMotion,
        step: &mut impl Trajectory,
        points: Range<usize>,
        piece: &mut Piece,
    ) -> Result<(), Halt> {
        let combinations = &self.selection.combinations;
        let room = points.len() * (self.len + combinations.len());
        let instants = RULES.map(|(at, _)| piece.begin + at * piece.length);
        let instants = &instants[points.clone()];
        let (q, v) = (&mut self.q[..room], &mut self.v[..room]);
        step.power_states(instants, &self.coordinates, combinations, q, v);
        for (powers, (elapsed, q, v)) in piece.powers[points].iter_mut().zip(at_each(instants, q, v)) {
            *powers = motion.powers(&self.loads, elapsed, q, v).map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
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
        let len = self.len;
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
    use super::{DEGREES, Piece, RULES};

    #[test]
    fn partial_works_of_polynomials_are_exact() {
        for (rule, degree) in DEGREES.into_iter().enumerate() {
            let mut piece = Piece { rule, ..Piece::new(3.0, 2.0) };
            for ((at, _), powers) in RULES.iter().zip(&mut piece.powers) {
                *powers = std::array::from_fn(|source| source as f64 * at.powi(degree as i32));
            }
            for part in [0.0, 0.1, 0.5, 0.77, 1.0] {
                let exact = 2.0 * f64::powi(part, degree as i32 + 1) / (degree + 1) as f64;
                // Fifteen abscissae with twelve polynomials each.
                let works = piece.works_until(part);
                assert!((works[1] - exact).abs() < 1e-14 && (works[5] - 5.0 * exact).abs() < 1e-13);
            }
        }
    }
}
