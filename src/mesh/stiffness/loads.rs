//! The loads of single tooth pairs, or of sections of their contact lines.

use super::lines::RULE;
use super::{ContactLines, Stiffness, ToothPair};
use crate::mesh::ContactPath;
use crate::scene::Engagement;

impl Stiffness {
    /// Tooth pairs of equal stiffness with sharp engagement; of helical teeth, if the path has an overlap.
    pub(in crate::mesh) fn even(path: &ContactPath) -> Self {
        let (pair, engagement) = (ToothPair::Uniform(1.0), Engagement::Sharp);
        if path.overlap > 0.0 {
            Self::Lines(ContactLines { pair, engagement })
        } else {
            Self::Pairs { pair, engagement, relief: None }
        }
    }

    /// Whether it consists of tooth pairs.
    pub fn has_pairs(&self) -> bool {
        !matches!(self, Self::Mean(_) | Self::Cycle(_))
    }

    /// Calls `visit(s, load)` with the position, m, and the relative load of every tooth pair at `deflection`, m; without tooth
    /// pairs there is none. Contact lines are divided at the positions `borders`, m, between which what is visited is smooth.
    pub(in crate::mesh) fn visit_loads(
        &self,
        path: &ContactPath,
        engaged: (i64, i64),
        deflection: f64,
        borders: [f64; 2],
        mut visit: impl FnMut(f64, f64),
    ) {
        let positions = |(first, last): (i64, i64)| (first..last + 1).map(|j| path.position + j as f64 * path.pitch);
        match self {
            Self::Mean(_) | Self::Cycle(_) => {}
            Self::Pairs { pair, engagement, relief } => {
                for s in positions(engagement.range(path, engaged)) {
                    let (entered, left) = (s - path.low, path.high - s);
                    let pressed = match relief {
                        Some(relief) => (deflection - relief.at(entered, left)[0]).max(0.0),
                        None => 1.0,
                    };
                    visit(s, engagement.weight(entered, left, path.pitch)[0] * pair.at(s, path.tangent)[0] * pressed);
                }
            }
            Self::Shared(shared) => {
                // F_i = κ_i (1 − f_i Σκf/(1 + Σκf²)) δ, from the inverse of diag(1/κ) + f fᵀ.
                let own = |s: f64| {
                    let weight = shared.engagement.weight(s - path.low, path.high - s, path.pitch)[0];
                    let body = shared.bodies[0].at(s).0 + shared.bodies[1].at(path.tangent - s).0;
                    (weight * shared.pair.at(s, path.tangent)[0], body.sqrt())
                };
                let range = shared.engagement.range(path, engaged);
                let sums = positions(range).map(own).fold([0.0, 0.0], |[with_root, with_body], (k, root)| {
                    [with_root + k * root, with_body + k * root * root]
                });
                for s in positions(range) {
                    let (k, root) = own(s);
                    visit(s, k * (1.0 - root * sums[0] / (1.0 + sums[1])));
                }
            }
            Self::Lines(lines) => {
                let half_ramp = lines.engagement.half_ramp(path.pitch);
                let ends = [path.low - half_ramp, path.high + half_ramp];
                let inside = |position: f64| position.clamp(ends[0], ends[1]);
                let mut marks =
                    [ends[0], path.low + half_ramp, path.high - half_ramp, ends[1], borders[0], borders[1]].map(inside);
                marks.sort_by(f64::total_cmp);
                for s in positions(lines.engagement.range(path, path.engaged())) {
                    let place = |position: f64| ((position - s) / path.overlap).clamp(-0.5, 0.5);
                    for piece in marks.windows(2) {
                        let (begin, length) = (place(piece[0]), place(piece[1]) - place(piece[0]));
                        for (at, weight) in RULE.iter().filter(|_| length > 0.0) {
                            let y = s + (begin + at * length) * path.overlap;
                            let engagement = lines.engagement.weight(y - path.low, path.high - y, path.pitch)[0];
                            visit(y, weight * length * engagement * lines.pair.at(y, path.tangent)[0]);
                        }
                    }
                }
            }
        }
    }

    /// Deflection under a force, m and N, on a path of contact.
    pub(in crate::mesh) fn deflection_under(&self, force: f64, path: &ContactPath) -> f64 {
        let state = |deflection: f64| self.elastic_state(|| *path, path.engaged(), deflection);
        // Newton's method from a deflection at which all pairs touch; the force is convex.
        let mut deflection = state(1.0).stiffness.recip() * force;
        if !self.is_relieved() {
            return deflection;
        }
        deflection = 1.0;
        for _ in 0..MAX_DEFLECTION_STEPS {
            let found = state(deflection);
            if found.stiffness <= 0.0 {
                break;
            }
            deflection -= (found.force - force) / found.stiffness;
        }
        deflection
    }
}

/// Steps of Newton's method for a deflection; the force is linear between the beginnings of contact of a few pairs.
const MAX_DEFLECTION_STEPS: usize = 20;
