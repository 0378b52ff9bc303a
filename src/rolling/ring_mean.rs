//! Force of a ring averaged over the angles of the cage.
//!
//! The average of n discrete elements is an integral over the loaded zones, in which the races approach each other. In each half
//! of a zone, the points of the Gauss rule lie closer together towards its end, as in `mean.rs`.

use std::convert::Infallible;
use std::f64::consts::TAU;

use super::GAUSS;
use super::ring::{Ring, RingVector, Sums};
use crate::bearing_force::{BearingForce, Vector};
use crate::numerics::{Sample, maximum, root};

/// Angles at which a search for the ends of loaded zones begins: the approach of the races contains the angle and its double.
const STARTS: usize = 32;
/// Error of the angle of the largest approach, relative to a full turn.
const MAXIMUM_TOLERANCE: f64 = 1e-9;

impl Ring {
    /// Force and stiffness averaged over the angles of the cage.
    pub fn mean(&self, x: RingVector) -> BearingForce<5> {
        let density = self.count() as f64 / TAU;
        let mut sums = Sums::default();
        let mut add = |angle: f64, length: f64| self.add::<true>(&mut sums, &x, unit(angle), density * length);
        match self.loaded_zones(&x) {
            None => {
                // The trapezoidal rule is accurate to round-off for a smooth periodic function.
                let count = 2 * GAUSS.len();
                let step = TAU / count as f64;
                (0..count).for_each(|index| add(step * index as f64, step));
            }
            Some(zones) => {
                let grading = self.contact.grading();
                for [begin, end] in zones {
                    let (middle, half) = (f64::midpoint(begin, end), (end - begin) / 2.0);
                    for &(at, weight) in GAUSS.iter() {
                        let angle = half * (1.0 - (1.0 - at).powf(grading));
                        let length = weight * half * grading * (1.0 - at).powf(grading - 1.0);
                        add(middle + angle, length);
                        add(middle - angle, length);
                    }
                }
            }
        }
        sums.result()
    }

    /// Begin and end of the zones in which elements are loaded, rad; `None` if all are.
    fn loaded_zones(&self, x: &RingVector) -> Option<Vec<[f64; 2]>> {
        let sample = |at: f64| Sample { at, value: self.approach(x, unit(at)) };
        let step = TAU / STARTS as f64;
        let found: Vec<Sample> = (0..STARTS).map(|index| sample(step * index as f64)).collect();
        let highest = found.iter().copied().max_by(|a, b| a.value.total_cmp(&b.value))?;
        let end_between = |a: Sample, b: Sample| {
            // Approaches over the largest one, so that the tolerance of the root does not depend on the unit.
            let size = highest.value.abs().max(f64::MIN_POSITIVE);
            let ends = [a, b].map(|end| Sample { value: end.value / size, ..end });
            let Ok(at) = root(ends, |at| Ok::<_, Infallible>(sample(at).value / size));
            at
        };
        if highest.value <= 0.0 {
            // A zone that lies between two of the angles.
            let approach = |at: f64| Ok::<_, Infallible>(sample(at).value);
            let Ok(top) = maximum(highest.at - step, highest.at + step, MAXIMUM_TOLERANCE, approach);
            let around = [highest.at - step, highest.at + step].map(sample);
            return Some(if top.value > 0.0 {
                vec![around.map(|outside| end_between(outside, top))]
            } else {
                Vec::new()
            });
        }
        let first = (0..STARTS).find(|index| found[*index].value <= 0.0)?;
        let (mut zones, mut begin) = (Vec::new(), None);
        for index in first..first + STARTS {
            let turns = |index: usize| {
                let sample = found[index % STARTS];
                Sample { at: step * index as f64, ..sample }
            };
            let [before, after] = [turns(index), turns(index + 1)];
            match (before.value > 0.0, after.value > 0.0) {
                (false, true) => begin = Some(end_between(before, after)),
                (true, false) => zones.extend(begin.take().map(|begin| [begin, end_between(before, after)])),
                _ => {}
            }
        }
        Some(zones)
    }
}

fn unit(angle: f64) -> Vector {
    let (sine, cosine) = angle.sin_cos();
    [cosine, sine]
}

#[cfg(test)]
mod tests {
    use super::super::ring::tests::ring;
    use super::*;

    #[test]
    fn the_mean_force_is_the_average_over_the_cage_angles() {
        for line in [false, true] {
            for (clearance, x) in [
                (2e-5, [2e-5, -3e-5, 1e-5, 0.0, 0.0]),
                (0.0, [1e-5, 2e-5, -1e-5, 1e-5, 0.0]),
                (0.0, [1e-6, 0.0, 3e-5, 2e-5, 1e-5]),
                (-1e-5, [1e-6, 2e-6, 1e-6, 1e-6, 0.0]),
                (0.0, [0.0, 0.0, -1e-5, -2e-5, 0.0]),
            ] {
                let (ring, count) = (ring(line, clearance, 0.0), 20000);
                let mean = ring.mean(x);
                let mut sum = BearingForce::<5>::default();
                for i in 0..count {
                    let found = ring.at::<true>(x, TAU / 16.0 * f64::from(i) / f64::from(count));
                    for a in 0..5 {
                        sum.force[a] += found.force[a] / f64::from(count);
                        for b in 0..5 {
                            sum.stiffness[a][b] += found.stiffness[a][b] / f64::from(count);
                        }
                    }
                }
                let size = mean.force.iter().fold(0.0, |size: f64, force| size.max(force.abs()));
                let stiff = mean.stiffness[2][2];
                // The tangent of a line contact has the exponent 1/9: the sum converges slowly.
                let rough = if line { 1e-4 } else { 1e-6 };
                for a in 0..5 {
                    assert!((sum.force[a] - mean.force[a]).abs() <= 1e-8 * size + 1e-9, "{sum:?} {mean:?}");
                    for b in 0..5 {
                        let difference = (sum.stiffness[a][b] - mean.stiffness[a][b]).abs();
                        assert!(difference <= rough * stiff, "{line} {clearance} {a} {b} {difference} {stiff}");
                    }
                }
            }
        }
    }
}
