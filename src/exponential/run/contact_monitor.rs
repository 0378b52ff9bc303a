//! Candidates for contact changes within a step, from the margin of each flank to the next contact change.

use crate::exponential::propagator::{PointValues, QuadratureRule};
use crate::exponential::step::Stepper;
use crate::numerics::ROOT_OF_ROUND_OFF;

/// Number of intervals in which the margins are followed. A step is at most a third of a period on the mesh stiffness.
const MARGIN_INTERVALS: usize = 8;
/// A minimum of the margin below this fraction of its range may be a contact change.
const NEAR_FRACTION: f64 = 0.1;
/// A minimum is refined on points that are closer together than the intervals by this factor.
const MINIMUM_REFINEMENT: f64 = 16.0;

/// A minimum so soon after touching flanks, as a fraction of the step, is round-off of their margin: its depth is at most
/// the square of this fraction of the range.
const TOUCHING_TIME: f64 = 1e-4;

/// An instant at which another contact mode may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exponential) struct CandidateEvent {
    /// Fraction of the step.
    pub at: f64,
    /// Whether the margin has a minimum there. The sign of a minimum decides, so that the motion itself is evaluated.
    pub is_minimum: bool,
}

pub(in crate::exponential) struct ContactMonitor {
    /// Interpolation weights at the ends of all intervals, including one before and one after the step.
    weights: [PointValues; MARGIN_INTERVALS + 3],
    /// Candidates of the last step in the order of time.
    pub candidates: Vec<CandidateEvent>,
}

impl ContactMonitor {
    /// Allocates the candidates of a number of connections.
    pub fn new(rule: &QuadratureRule, connections: usize) -> Self {
        let weights = std::array::from_fn(|point| rule.through((point as f64 - 1.0) / MARGIN_INTERVALS as f64));
        // Each of the two flanks has at most one candidate at the end of an interval and one minimum in it.
        Self { weights, candidates: Vec::with_capacity(connections * 2 * 2 * MARGIN_INTERVALS) }
    }

    /// Finds the candidates of the last step for all connections whose flank contact is not `unchanged`.
    pub fn search(&mut self, stepper: &Stepper<'_>, unchanged: &[bool]) {
        self.candidates.clear();
        for (connection, _) in unchanged.iter().enumerate().filter(|(_, unchanged)| !**unchanged) {
            for margins in stepper.margins(connection) {
                self.follow(&stepper.context.cache.rule, &margins);
            }
        }
        self.candidates.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
    }

    /// Adds the candidates of one flank with these margins.
    fn follow(&mut self, rule: &QuadratureRule, margins: &PointValues) {
        let known = &margins[..rule.stages() + 2];
        let (least, most) = known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let range = most - least;
        let near = NEAR_FRACTION * range;
        // The polynomial falls below its smallest known value by less than the range of the values.
        if least > range {
            return;
        }
        let value =
            |weights: &PointValues| weights.iter().zip(margins).map(|(weight, value)| weight * value).sum::<f64>();
        let values = self.weights.map(|weights| value(&weights));
        for (interval, around) in values.windows(3).enumerate() {
            let at = interval as f64 / MARGIN_INTERVALS as f64;
            let &[before, here, after] = around else { continue };
            if interval > 0 && here <= 0.0 {
                self.candidates.push(CandidateEvent { at, is_minimum: false });
            }
            if here > before || here >= after {
                continue;
            }
            let spacing = 1.0 / (MARGIN_INTERVALS as f64 * MINIMUM_REFINEMENT);
            let middle = at + vertex([before, here, after]) / MARGIN_INTERVALS as f64;
            let around = [middle - spacing, middle, middle + spacing].map(|at| value(&rule.through(at)));
            let minimum = middle + spacing * vertex(around).clamp(-1.0, 1.0);
            // Flanks touch at the beginning of the step, as after a contact change, if the margin there is round-off.
            let is_round_off = minimum.abs() <= TOUCHING_TIME && margins[0].abs() <= ROOT_OF_ROUND_OFF * range;
            if around[1] <= near && (0.0..=1.0).contains(&minimum) && !is_round_off {
                self.candidates.push(CandidateEvent { at: minimum, is_minimum: true });
            }
        }
    }
}

/// Abscissa of the vertex of the parabola through three values at −1, 0 and 1.
fn vertex([before, middle, after]: [f64; 3]) -> f64 {
    let curvature = before - 2.0 * middle + after;
    if curvature == 0.0 { 0.0 } else { (before - after) / (2.0 * curvature) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exponential::MAX_STAGES;

    /// Candidates of a flank whose margin over the step is a parabola with the minimum −`depth` at `bottom`.
    fn candidates(stages: usize, bottom: f64, depth: f64) -> Vec<CandidateEvent> {
        let rule = QuadratureRule::gauss(stages);
        let mut contact_monitor = ContactMonitor::new(&rule, 1);
        let mut margins = [0.0; MAX_STAGES + 2];
        let instants = [&[0.0], &rule.nodes[..], &[1.0]].concat();
        for (margin, at) in margins.iter_mut().zip(instants) {
            *margin = (at - bottom).powi(2) - depth;
        }
        contact_monitor.follow(&rule, &margins);
        contact_monitor.candidates
    }

    #[test]
    fn round_off_of_touching_flanks_is_no_candidate() {
        for stages in 1..=4 {
            assert_eq!(candidates(stages, 5e-6, 1e-11), [], "{stages}");
            // A deeper minimum, or a later one, can be a contact change.
            for (bottom, depth) in [(5e-6, 1e-7), (5e-4, 1e-9)] {
                assert_eq!(candidates(stages, bottom, depth).len(), 1, "{stages} {bottom}");
            }
        }
    }

    #[test]
    fn a_minimum_near_zero_is_a_candidate() {
        for stages in 1..=4 {
            for (bottom, depth) in [(0.3, 0.0), (0.55, 1e-9), (0.97, -1e-9), (0.02, 1e-6), (0.5, 0.01)] {
                let found = candidates(stages, bottom, depth);
                let minimum = found.iter().find(|candidate| candidate.is_minimum).map(|candidate| candidate.at);
                assert!(minimum.is_some_and(|minimum| (minimum - bottom).abs() < 1e-9), "{stages} {bottom} {found:?}");
            }
        }
    }

    #[test]
    fn a_flank_with_a_positive_margin_is_no_candidate() {
        for stages in 1..=4 {
            // The minimum is too far from zero, or lies before or after the step.
            for (bottom, depth) in [(0.5, -0.1), (-0.3, 0.05), (1.5, -2.0)] {
                assert_eq!(candidates(stages, bottom, depth), [], "{stages} {bottom}");
            }
        }
    }

    #[test]
    fn a_margin_that_stays_negative_gives_a_candidate_in_every_interval() {
        for stages in 1..=4 {
            let found = candidates(stages, 1.4, 0.8);
            assert!(found.iter().all(|candidate| !candidate.is_minimum && candidate.at > 0.5), "{found:?}");
            assert_eq!(found.len(), 4);
        }
    }
}
