//! Energy audit: integrates the power of every source of energy over each step.
//!
//! If the steps resolve every mode, five points are sufficient, because the error of this rule is of higher order than that of
//! the motion. Otherwise the number of intervals is doubled until two rules agree. A step on which none agree is halved. Works
//! at instants within a step are integrals of polynomials through the same powers. This also applies to teeth with tip relief,
//! because the relief starts within a step and the power of the teeth jumps there. Constant loads need no rule: their work is
//! the load times the displacement.

use super::RecorderState;
use super::audit_piece::{MAX_INTERVALS, Piece, Sample};
use crate::integrate::{FirstOrderSystem, Halt, Trajectory, at_each};
use crate::mesh::ContactMode;
use crate::model::Model;
use crate::motion::{EquationOfMotion, PowerCoordinates, PowerLoads, SourceTerms};

/// Two rules agree if their works differ by less than this multiple of the tolerance of the run, but at least and at most by
/// these fractions, times the total work. The difference is the error of the rule with fewer points; that of the other one is
/// about a hundred times smaller.
const AGREEMENT_FACTOR: f64 = 0.1;
const AGREEMENT_RANGE: [f64; 2] = [1e-10, 1e-4];
/// Smallest number of intervals of a rule that is accepted.
const MIN_INTERVALS: usize = 4;
/// Largest number of halvings of a step.
const MAX_HALVINGS: usize = 20;

/// Works since the start of a run, J.
#[derive(Clone, Debug)]
pub(super) struct Audit {
    works: SourceTerms,
    /// Elapsed time up to which the works are integrated, s.
    until: f64,
    /// Works at the beginning of the last step.
    works_before: SourceTerms,
    /// Parts of the last step.
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
        if !model.scene.modal_damping.is_zero() || model.scene.rayleigh != [0.0; 2] {
            coordinates = (0..model.len()).collect();
        }
        coordinates.sort_unstable();
        coordinates.dedup();
        let room = (MAX_INTERVALS + 1) * (model.len() + selection.sums());
        Self {
            has_jumps: model.meshes.iter().any(|mesh| mesh.teeth.is_relieved()),
            works: SourceTerms::default(),
            until: start,
            works_before: SourceTerms::default(),
            pieces: Vec::new(),
            coordinates,
            len: model.len(),
            loads: PowerLoads::new(model),
            agreement: (AGREEMENT_FACTOR * tolerance).clamp(AGREEMENT_RANGE[0], AGREEMENT_RANGE[1]),
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
    pub fn works(&self) -> (SourceTerms, f64) {
        (self.works, self.until)
    }

    /// Integrates the works over a step up to `end`.
    pub fn integrate(&mut self, motion: &EquationOfMotion, step: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        let begin = self.until.max(step.begin());
        if end > begin {
            self.works_before = self.works;
            self.pieces.clear();
            self.integrate_piece(motion, step, Piece::new([begin, end]), MAX_HALVINGS)?;
            self.last = self.last.filter(|_| step.ends_at_state());
            self.until = end;
        }
        Ok(())
    }

    /// Works since the start of the run at an instant of the step that was integrated last, J, where the constant loads have
    /// these potentials, J.
    pub fn works_at(&self, elapsed: f64, potentials: &[f64]) -> SourceTerms {
        if elapsed >= self.until {
            return self.works;
        }
        let mut works = self.works_before;
        for piece in self.pieces.iter().take_while(|piece| piece.span[0] < elapsed) {
            works = works.plus(1.0, &piece.works_until(elapsed, potentials));
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
        let total = self.works.magnitude();
        let known = self.last.take().filter(|(at, _)| *at == piece.span[0]).map(|(_, sample)| sample);
        piece.samples[0] = known.unwrap_or_default();
        self.evaluate(motion, step, &mut piece, usize::from(known.is_some())..=1)?;
        self.last = Some((piece.span[1], piece.samples[MAX_INTERVALS]));
        let is_resolved = step.is_resolved() && !self.has_jumps;
        while piece.intervals < MAX_INTERVALS {
            let coarse = piece.works();
            piece.intervals *= 2;
            let new = (1..piece.intervals).step_by(2);
            self.evaluate(motion, step, &mut piece, new)?;
            let difference = piece.works().plus(-1.0, &coarse).magnitude();
            let agrees = difference <= self.agreement * (total + piece.magnitude());
            let is_last = halvings == 0 && piece.intervals == MAX_INTERVALS;
            if is_last || piece.intervals >= MIN_INTERVALS && (is_resolved || agrees) {
                self.keep(piece);
                return Ok(());
            }
        }
        let ([begin, end], middle) = (piece.span, piece.time(MAX_INTERVALS / 2));
        self.last = Some((begin, piece.samples[0]));
        self.integrate_piece(motion, step, Piece::new([begin, middle]), halvings - 1)?;
        self.integrate_piece(motion, step, Piece::new([middle, end]), halvings - 1)
    }

    /// Adds the works of a part of the step.
    fn keep(&mut self, piece: Piece) {
        self.works = self.works.plus(1.0, &piece.works());
        self.pieces.push(piece);
    }

    /// Evaluates the powers at some points of the rule of a part of the step.
    fn evaluate(
        &mut self,
        motion: &EquationOfMotion,
        step: &mut impl Trajectory,
        piece: &mut Piece,
        points: impl Iterator<Item = usize>,
    ) -> Result<(), Halt> {
        let (mut indices, mut instants, mut count) = ([0; MAX_INTERVALS], [0.0; MAX_INTERVALS], 0);
        for point in points {
            indices[count] = point * MAX_INTERVALS / piece.intervals;
            instants[count] = piece.time(indices[count]);
            count += 1;
        }
        let instants = &instants[..count];
        let room = count * (self.len + self.selection.sums());
        let (q, v) = (&mut self.q[..room], &mut self.v[..room]);
        step.power_states(instants, &self.coordinates, &self.selection.combinations, q, v);
        for (index, (elapsed, q, v)) in indices.into_iter().zip(at_each(instants, q, v)) {
            let known = step.gives_damping().then(|| q[q.len() - 1]);
            let damping = known.unwrap_or_else(|| motion.distributed_damping_power(v));
            let powers = motion.powers(&self.loads, elapsed, q, v, damping);
            let powers = powers.map_err(|(mesh, overlap)| Halt::Overlap { mesh, overlap })?;
            piece.samples[index] = Sample { powers, potentials: self.selection.potentials(q) };
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
        // The integrator reports overlapping base circles.
        if let (Ok(before), Ok(after)) = (before, motion.mesh_energy(elapsed, q, v)) {
            let keep_flanks = flanks(&old) == flanks(contact_modes);
            let source = if keep_flanks { &mut self.works.teeth } else { &mut self.works.damping };
            *source += after - before;
        }
    }
}
