//! Energy audit: integrates the power of every source of energy over each step.
//!
//! If the steps resolve every mode, the three-point Gauss rule is sufficient, because its error is of higher order than
//! that of the motion. Otherwise nested rules follow until two rules agree. A step on which none agree is halved. Works at
//! instants within a step are integrals of polynomials through the same powers. This also applies to teeth with tip relief,
//! because the relief starts within a step and the power of the teeth jumps there. Constant loads need no rule: their work is
//! the load times the displacement.

use std::ops::Range;

use super::RecorderState;
use super::audit_piece::{Piece, Rule, Sample};
use crate::integrate::quadrature_rules::{GAUSS, NESTED, NESTED_RULES, POINTS};
use crate::integrate::{FirstOrderSystem, Halt, Trajectory, at_each};
use crate::mesh::ContactMode;
use crate::model::Model;
use crate::motion::{EquationOfMotion, PowerCoordinates, PowerLoads};

/// Two rules agree if they differ by less than this multiple of the tolerance of the run, but at least and at most by these
/// fractions, times the total work. The difference is the error of the rule with fewer points.
const AGREEMENT: f64 = 0.1;
const AGREEMENTS: [f64; 2] = [1e-10, 1e-6];
/// The same, as a fraction of it, for each nested rule. The polynomials through five points also give the works within a
/// step, and a fast oscillation may agree by chance on few points.
const FRACTIONS: [f64; NESTED_RULES] = [0.0, 0.01, 1.0, 1.0];
/// Largest number of halvings of a step.
const MAX_HALVINGS: usize = 20;

/// Indices of the works of teeth and damping.
const TEETH: usize = 4;
const DAMPING: usize = 5;

/// Works since the start of a run, J.
#[derive(Clone, Debug)]
pub(super) struct Audit {
    works: [f64; 6],
    /// Elapsed time up to which the works are integrated, s.
    until: f64,
    /// Works at the beginning of the last step, and the parts of the step.
    works_before: [f64; 6],
    pieces: Vec<Piece>,
    /// Loads whose powers are sums over few coordinates.
    pub loads: PowerLoads,
    /// Coordinates from which powers follow, and all of them, ascending.
    selection: PowerCoordinates,
    coordinates: Vec<usize>,
    /// Number of all coordinates.
    len: usize,
    /// Difference of two rules that agree, as a fraction of the total work.
    agreement: f64,
    /// Whether powers can jump within a step, because tip relief starts within it.
    has_jumps: bool,
    /// The end of the last step, s, and the sample there, if the next step begins with the same state.
    last: Option<(f64, Sample)>,
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
        let room = NESTED.len() * (model.len() + selection.combinations.len());
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
            last: None,
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
            if step.is_resolved() && !self.has_jumps {
                let mut piece = Piece::new(begin, end, Rule::Gauss);
                self.evaluate(motion, step, 0..GAUSS.len(), &mut piece)?;
                self.keep(piece);
            } else {
                self.integrate_piece(motion, step, Piece::new(begin, end, Rule::Nested(0)), MAX_HALVINGS)?;
                self.last = self.last.filter(|_| step.ends_at_state());
            }
            self.until = end;
        }
        Ok(())
    }

    /// Works since the start of the run at an instant of the step that was integrated last, J, where the constant loads have
    /// these potentials, J.
    pub fn works_at(&self, elapsed: f64, potentials: &[f64]) -> [f64; 6] {
        if elapsed >= self.until {
            return self.works;
        }
        let mut works = self.works_before;
        for piece in self.pieces.iter().take_while(|piece| piece.span[0] < elapsed) {
            let part = ((elapsed - piece.span[0]) / piece.length()).min(1.0);
            let own = if part < 1.0 { piece.works_until(part, potentials) } else { piece.works() };
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
        let known = self.last.take().filter(|(at, _)| *at == piece.span[0]).map(|(_, sample)| sample);
        piece.samples[0] = known.unwrap_or_default();
        self.evaluate(motion, step, usize::from(known.is_some())..POINTS[0], &mut piece)?;
        self.last = Some((piece.span[1], piece.samples[1]));
        for rule in 1..NESTED_RULES {
            let coarse = piece.works();
            self.evaluate(motion, step, POINTS[rule - 1]..POINTS[rule], &mut piece)?;
            piece.rule = Rule::Nested(rule);
            let difference: f64 = piece.works().iter().zip(coarse).map(|(a, b)| (a - b).abs()).sum();
            let is_last = halvings == 0 && rule == NESTED_RULES - 1;
            if is_last || difference <= FRACTIONS[rule] * self.agreement * (total + piece.magnitude()) {
                self.keep(piece);
                return Ok(());
            }
        }
        let ([begin, end], middle) = (piece.span, piece.time(0.5));
        (self.last, piece.rule) = (Some((begin, piece.samples[0])), Rule::Nested(0));
        self.integrate_piece(motion, step, Piece { span: [begin, middle], ..piece }, halvings - 1)?;
        self.integrate_piece(motion, step, Piece { span: [middle, end], ..piece }, halvings - 1)
    }

    /// Adds the works of a part of the step.
    fn keep(&mut self, piece: Piece) {
        self.works.iter_mut().zip(piece.works()).for_each(|(work, added)| *work += added);
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
        let mut instants = [0.0; NESTED.len()];
        for (instant, (at, _)) in instants.iter_mut().zip(piece.rule.points_up_to(points.end)) {
            *instant = piece.time(at);
        }
        let instants = &instants[points.clone()];
        let (q, v) = (&mut self.q[..room], &mut self.v[..room]);
        step.power_states(instants, &self.coordinates, combinations, q, v);
        for (sample, (elapsed, q, v)) in piece.samples[points].iter_mut().zip(at_each(instants, q, v)) {
            let powers = motion.powers(&self.loads, elapsed, q, v);
            sample.powers = powers.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
            match piece.rule {
                Rule::Gauss => {
                    let constant = self.loads.times(v);
                    sample.powers.iter_mut().zip(constant).for_each(|(power, constant)| *power += constant);
                }
                Rule::Nested(_) => sample.potentials.copy_from_slice(&q[q.len() - 2..]),
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
        let len = self.len;
        let (q, v) = (&mut self.q[..len], &mut self.v[..len]);
        read(q, v);
        self.last = None;
        let before = motion.mesh_energy(elapsed, q, v);
        motion.set_contact_modes(contact_modes);
        let Some(old) = self.contact_modes.replace(contact_modes.to_vec()) else {
            return;
        };
        let flanks = |contact_modes: &[i64]| {
            contact_modes.chunks_exact(ContactMode::CODE_LENGTH).map(|code| code[0]).collect::<Vec<_>>()
        };
        let source = if flanks(&old) == flanks(contact_modes) { TEETH } else { DAMPING };
        // The integrator reports overlapping base circles.
        if let (Ok(before), Ok(after)) = (before, motion.mesh_energy(elapsed, q, v)) {
            self.works[source] += after - before;
        }
    }
}
