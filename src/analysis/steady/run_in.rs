//! Running in: the state of the steady motion at the begin of a record, where the excitation has no common period or a long
//! one.
//!
//! Several runs start at different times before the record, all with the same modal state. At the begin of the record they differ
//! by their transients. The decay of the linear modes gives the part of this difference that is left in the longer run, and
//! the length that a run needs. The decay from one measured difference to the next one must agree with it.

use super::preconditioner::Preconditioner;
use super::solver::{MAX_STALLED_ERROR, STATE_ERROR_FACTOR, progress};
use super::{SteadyState, norm};
use crate::analysis::AnalysisError;
use crate::analysis::simulate::PeriodMap;
use crate::modal::{ModalStateSpace, ModePair};

/// Parts in which a run is counted, in a period of the slowest source.
pub const PARTS: f64 = 4.0;
/// Longest run before the record, in periods of the slowest source.
pub const LONGEST_RUN_IN: f64 = 200.0;
/// Factor on the predicted length of a run, and its largest and smallest growth.
const SAFETY: f64 = 1.1;
const LARGEST_GROWTH: u64 = 16;
const SMALLEST_GROWTH: f64 = 1.25;
/// Number of differences in a row that grow, after which the motion counts as unstable.
const MAX_GROWTHS: u32 = 2;
/// Largest transient part of the motion that may remain.
const MAX_TRANSIENT: f64 = 1e-2;

/// The state at the begin of a record.
pub struct Begin {
    /// The state z.
    pub state: Vec<f64>,
    /// Estimated transient part of it, relative to the motion.
    pub error: f64,
}

/// Finds the motion of a map that differs from one part of the run to the next, and records `samples` instants of `count`
/// parts.
///
/// # Errors
/// [`AnalysisError`] if the motion does not settle.
pub fn solve(map: &mut PeriodMap<'_>, count: u64, samples: usize) -> Result<SteadyState, AnalysisError> {
    let limit = STATE_ERROR_FACTOR * map.tolerance();
    let begin = settled(map, limit, (LONGEST_RUN_IN * PARTS) as u64)?;
    let (response, _) = map.record(count, &begin.state, samples)?;
    let warning = format!(
        "the motion has not settled: about {:.1e} of it are transient at the begin of the record; add damping, or give the response of a long run as initial",
        begin.error
    );
    Ok(SteadyState {
        response,
        period: f64::INFINITY,
        residual: begin.error,
        periods: (map.runs as f64 / PARTS).ceil() as usize,
        is_affine: map.is_affine(),
        warning: Some(warning).filter(|_| begin.error > MAX_STALLED_ERROR * map.tolerance()),
    })
}

/// The state after running in, whose transient part is at most `limit` of the motion; of the longest run up to `longest`
/// parts, a hundredth at most.
///
/// # Errors
/// [`AnalysisError::Convergence`] if more is transient.
pub fn settled(map: &mut PeriodMap<'_>, limit: f64, longest: u64) -> Result<Begin, AnalysisError> {
    let mut initial = map.initial();
    let size = map.size(&initial)?;
    let mut begin = Begin { state: initial.clone(), error: f64::INFINITY };
    // Transient of the run before at its end, and the difference in length from the run before that one.
    let mut before: Option<(f64, f64)> = None;
    let (mut shorter, mut count, mut errors) = (0, PARTS as u64, Vec::new());
    // Number of differences in a row that did not decay; velocity of rigid-body motions that a run gains.
    let mut growths = 0;
    let mut gained: Vec<f64> = Vec::new();
    while count <= longest {
        let mut state = match map.periods_from(-(count as i64), count, &initial, map.tolerance()) {
            Err(AnalysisError::Interrupted) => return Err(AnalysisError::Interrupted),
            // An unstable motion may grow until the gears have no valid contact geometry.
            Err(_) => break,
            Ok(state) => state,
        };
        let between = map.period() * (count - shorter) as f64;
        let linear = Preconditioner::new(map.linear(), between);
        let change: Vec<f64> = state.iter().zip(&begin.state).map(|(long, short)| long - short).collect();
        // What is left of the transient of the shorter run.
        let mut transient = linear.correct(&change);
        // Nothing damps these velocities: without a mean torque, the position returns.
        for entry in &linear.velocities {
            initial[*entry] += transient[*entry];
            state[*entry] += transient[*entry];
            transient[*entry] = 0.0;
        }
        let gain = linear.velocities.iter().map(|entry| state[*entry] - initial[*entry]).collect::<Vec<f64>>();
        let drifts = gain.iter().zip(&gained).map(|(gain, before)| (gain - before).abs()).fold(0.0, f64::max) / size;
        gained = gain;
        let own = (remaining(map.linear(), &transient, 0.0) / size).max(drifts);
        let modal = remaining(map.linear(), &transient, between) / size;
        let measured = before.map_or(f64::INFINITY, |(last, span)| own * (own / last).powf(between / span));
        growths = if before.is_some_and(|(last, _)| own >= last) { growths + 1 } else { 0 };
        // A small difference of two runs whose modes have decayed is the error of their integration.
        let stalls = modal <= limit && own <= MAX_STALLED_ERROR * map.tolerance();
        before = Some((own, between));
        begin = Begin { state, error: modal.max(if stalls { measured.min(own) } else { measured }) };
        if begin.error <= limit || stalls || growths == MAX_GROWTHS {
            break;
        }
        errors.push(begin.error.min(own) / limit);
        map.report(progress(&errors, begin.error.min(own) / limit));
        let predicted = shorter + needed(map, &transient, limit * size, longest);
        shorter = count;
        let least = (SMALLEST_GROWTH * count as f64).ceil() as u64;
        count = predicted.clamp(least, LARGEST_GROWTH * count);
    }
    if begin.error <= MAX_TRANSIENT {
        return Ok(begin);
    }
    Err(AnalysisError::Convergence(format!(
        "the motion does not settle within {:.4} s: it is unstable, contains frequencies that are none of the excitation, or its transient decays slowly; add damping, run in with simulate(), or give the response of such a run as initial",
        count.min(longest) as f64 * map.period()
    )))
}

/// Number of parts after which the modes leave `limit` of a transient, with a margin; at most `longest`.
fn needed(map: &PeriodMap<'_>, transient: &[f64], limit: f64, longest: u64) -> u64 {
    let is_left = |parts: f64| remaining(map.linear(), transient, parts * map.period()) > limit;
    let mut parts = 1.0;
    while parts < longest as f64 && is_left(parts) {
        parts *= SAFETY;
    }
    ((SAFETY * parts).ceil() as u64).min(longest)
}

/// Energy norm of a transient after a time, s, in which each mode decays; rigid-body positions do not count.
fn remaining(linear: &ModalStateSpace, transient: &[f64], time: f64) -> f64 {
    let (x, y) = transient.split_at(linear.slots);
    let parts = linear.pairs().iter().zip(x.iter().zip(y)).flat_map(|(pair, (x, y))| match pair {
        ModePair::Oscillation(value) => [x, y].map(|part| part * (value.re * time).exp()),
        ModePair::Real([first, second]) => [x * (first * time).exp(), y * (second * time).exp()],
        ModePair::RigidBodyPair(rate) => [0.0, y * (rate * time).exp()],
    });
    norm(&parts.collect::<Vec<f64>>())
}
