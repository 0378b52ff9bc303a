//! Where within a step flanks may part or meet: how far each is from it, as a polynomial through what its nodes saw.

use super::quadrature::{MOST, QuadratureRule};
use super::step::Stepper;

/// Parts of a step between which flanks are followed; a step is at most a third of a swing.
const PARTS: usize = 8;
/// A flank that comes nearer than this part of its way over the step and turns back may have touched.
const NEAR: f64 = 0.1;
/// How much closer the turning point is looked for around where it was foretold.
const CLOSER: f64 = 16.0;

/// An instant at which another law may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CandidateEvent {
    /// As a part of the step.
    pub at: f64,
    /// Whether a flank turns back there: however little the polynomial is off, that decides.
    pub phasors: bool,
}

/// Weights of what is known at the beginning, at the nodes and at the end of a step.
type Weights = [f64; MOST + 2];

pub(super) struct ContactMonitor {
    /// Of the value at each of the parts, from the one before the beginning of the step to the one after its end.
    weights: [Weights; PARTS + 3],
    /// Of the last step, in order.
    pub candidates: Vec<CandidateEvent>,
}

impl ContactMonitor {
    /// A watch over so many meshes.
    pub fn new(rule: &QuadratureRule, meshes: usize) -> Self {
        let weights = std::array::from_fn(|part| rule.through((part as f64 - 1.0) / PARTS as f64));
        // Of either flank: every part but the beginning, and a turning point between any two of them.
        Self { weights, candidates: Vec::with_capacity(meshes * 2 * 2 * PARTS) }
    }

    /// Finds where the flanks of meshes that are not `unchanged` may part or meet within the last step.
    pub fn search(&mut self, stepper: &Stepper<'_>, unchanged: &[bool]) {
        self.candidates.clear();
        for (mesh, _) in unchanged.iter().enumerate().filter(|(_, unchanged)| !**unchanged) {
            for values in stepper.margins(mesh) {
                self.follow(&stepper.cache.rule, &values);
            }
        }
        self.candidates.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
    }

    /// Adds the suspects of one flank, which was so far from a change at the beginning, at the nodes and at the end.
    fn follow(&mut self, rule: &QuadratureRule, values: &Weights) {
        let known = &values[..rule.stages() + 2];
        let (least, most) = known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let near = NEAR * (most - least);
        // No polynomial of these goes so far beyond the values it goes through.
        if least > most - least {
            return;
        }
        let value = |weights: &Weights| weights.iter().zip(values).map(|(weight, value)| weight * value).sum::<f64>();
        let values = self.weights.map(|weights| value(&weights));
        for (part, around) in values.windows(3).enumerate() {
            let at = part as f64 / PARTS as f64;
            let &[before, here, after] = around else { continue };
            if part > 0 && here <= 0.0 {
                self.candidates.push(CandidateEvent { at, phasors: false });
            }
            if here > before || here >= after {
                continue;
            }
            let apart = 1.0 / (PARTS as f64 * CLOSER);
            let middle = at + vertex([before, here, after]) / PARTS as f64;
            let around = [middle - apart, middle, middle + apart].map(|at| value(&rule.through(at)));
            let turn = middle + apart * vertex(around).clamp(-1.0, 1.0);
            if around[1] <= near && (0.0..=1.0).contains(&turn) {
                self.candidates.push(CandidateEvent { at: turn, phasors: true });
            }
        }
    }
}

/// Where the parabola through three values at −1, 0 and 1 turns.
fn vertex([before, middle, after]: [f64; 3]) -> f64 {
    let bend = before - 2.0 * middle + after;
    if bend == 0.0 { 0.0 } else { (before - after) / (2.0 * bend) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a flank leaves that comes by with `depth` at `bottom`, as a parabola over the step.
    fn candidates(stages: usize, bottom: f64, depth: f64) -> Vec<CandidateEvent> {
        let rule = QuadratureRule::gauss(stages);
        let mut contact_monitor = ContactMonitor::new(&rule, 1);
        let mut values = [0.0; MOST + 2];
        let instants = [&[0.0], &rule.nodes[..], &[1.0]].concat();
        for (value, at) in values.iter_mut().zip(instants) {
            *value = (at - bottom).powi(2) - depth;
        }
        contact_monitor.follow(&rule, &values);
        contact_monitor.candidates
    }

    #[test]
    fn a_flank_that_turns_back_is_met_where_it_does() {
        for stages in 1..=4 {
            for (bottom, depth) in [(0.3, 0.0), (0.55, 1e-9), (0.97, -1e-9), (0.02, 1e-6), (0.5, 0.01)] {
                let found = candidates(stages, bottom, depth);
                let turn = found.iter().find(|candidate| candidate.phasors).map(|candidate| candidate.at);
                assert!(turn.is_some_and(|turn| (turn - bottom).abs() < 1e-9), "{stages} {bottom} {found:?}");
            }
        }
    }

    #[test]
    fn a_flank_that_stays_away_or_goes_on_is_left_alone() {
        for stages in 1..=4 {
            // It turns back too soon to have touched; it has turned before the step.
            for (bottom, depth) in [(0.5, -0.1), (-0.3, 0.05), (1.5, -2.0)] {
                assert_eq!(candidates(stages, bottom, depth), [], "{stages} {bottom}");
            }
            // It parts for good: from there on all is suspect.
            let found = candidates(stages, 1.4, 0.8);
            assert!(found.iter().all(|candidate| !candidate.phasors && candidate.at > 0.5), "{found:?}");
            assert_eq!(found.len(), 4);
        }
    }
}
