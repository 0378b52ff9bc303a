//! The motion within a step.
//!
//! Displacement, velocity and acceleration are known at both ends, so the displacement is a quintic Hermite polynomial
//! (error of order h⁶) and the velocity its derivative (h⁵), whatever method made the step.

/// The motion over a step.
pub trait Trajectory {
    /// Elapsed time at the beginning.
    fn begin(&self) -> f64;

    /// Elapsed time at the end.
    fn end(&self) -> f64;

    /// Writes displacements and velocities of `coordinates`, each at its index, instant after instant.
    fn states(&mut self, instants: &[f64], coordinates: &[usize], q: &mut [f64], v: &mut [f64]);

    /// Whether it is shorter than whatever moves: a low polynomial then is the motion within it.
    fn is_resolved(&self) -> bool {
        true
    }

    /// All displacements at the end, where they are at hand.
    fn end_displacement(&self) -> Option<&[f64]>;
}

/// Instants, each with its own part of displacements and velocities that stand instant after instant.
pub fn at_each<'a>(
    instants: &'a [f64],
    q: &'a mut [f64],
    v: &'a mut [f64],
) -> impl Iterator<Item = (f64, &'a mut [f64], &'a mut [f64])> {
    let len = (q.len() / instants.len().max(1)).max(1);
    let states = q.chunks_exact_mut(len).zip(v.chunks_exact_mut(len));
    instants.iter().zip(states).map(|(elapsed, (q, v))| (*elapsed, q, v))
}

impl Trajectory for Span<'_> {
    fn begin(&self) -> f64 {
        self.start
    }

    fn end(&self) -> f64 {
        self.start + self.step
    }

    fn states(&mut self, instants: &[f64], coordinates: &[usize], q: &mut [f64], v: &mut [f64]) {
        for (elapsed, q, v) in at_each(instants, q, v) {
            let weights = self.weights(elapsed);
            for index in coordinates {
                (q[*index], v[*index]) = self.at(&weights, *index);
            }
        }
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        let (y, _) = self.after;
        Some(&y[..y.len() / 2])
    }
}

/// A step with its ends: states y (displacements, then velocities) and their derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Span<'a> {
    /// Elapsed time at the beginning.
    pub start: f64,
    /// Length, s.
    pub step: f64,
    /// State and derivative at the beginning.
    pub before: (&'a [f64], &'a [f64]),
    /// State and derivative at the end.
    pub after: (&'a [f64], &'a [f64]),
}

/// Weights of the six end values for displacement and velocity at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    displacement: [f64; 6],
    velocity: [f64; 6],
}

impl Span<'_> {
    /// Weights of the instant `elapsed`.
    pub fn weights(&self, elapsed: f64) -> Weights {
        let h = self.step;
        let s = (elapsed - self.start) / h;
        let (s2, s3) = (s * s, s * s * s);
        let rise = s3 * (10.0 - 15.0 * s + 6.0 * s2);
        let slope = 30.0 * s2 * (1.0 - 2.0 * s + s2) / h;
        Weights {
            displacement: [
                1.0 - rise,
                rise,
                h * s * (1.0 - s2 * (6.0 - 8.0 * s + 3.0 * s2)),
                h * s3 * (-4.0 + 7.0 * s - 3.0 * s2),
                h * h * 0.5 * s2 * (1.0 - 3.0 * s + 3.0 * s2 - s3),
                h * h * 0.5 * s3 * (1.0 - 2.0 * s + s2),
            ],
            velocity: [
                -slope,
                slope,
                1.0 - s2 * (18.0 - 32.0 * s + 15.0 * s2),
                s2 * (-12.0 + 28.0 * s - 15.0 * s2),
                h * 0.5 * s * (2.0 - 9.0 * s + 12.0 * s2 - 5.0 * s3),
                h * 0.5 * s2 * (3.0 - 8.0 * s + 5.0 * s2),
            ],
        }
    }

    /// Weights at `elapsed` of the cubic through the states at both ends and their derivatives: those of the beginning,
    /// then those of the end.
    pub fn cubic(&self, elapsed: f64) -> [f64; 4] {
        let (h, s) = (self.step, (elapsed - self.start) / self.step);
        let rise = s * s * (3.0 - 2.0 * s);
        [1.0 - rise, h * s * (1.0 - s) * (1.0 - s), rise, -h * s * s * (1.0 - s)]
    }

    /// The state of `coordinates`, into `y`, displacements before velocities.
    pub fn whole(&self, weights: &Weights, coordinates: impl Iterator<Item = usize>, y: &mut [f64]) {
        let half = y.len() / 2;
        for index in coordinates {
            (y[index], y[half + index]) = self.at(weights, index);
        }
    }

    /// Displacement and velocity of coordinate `index`.
    pub fn at(&self, weights: &Weights, index: usize) -> (f64, f64) {
        let velocity = self.before.0.len() / 2 + index;
        let ends = [
            self.before.0[index],
            self.after.0[index],
            self.before.0[velocity],
            self.after.0[velocity],
            self.before.1[velocity],
            self.after.1[velocity],
        ];
        let sum = |weights: &[f64; 6]| weights.iter().zip(&ends).map(|(weight, end)| weight * end).sum();
        (sum(&weights.displacement), sum(&weights.velocity))
    }
}
