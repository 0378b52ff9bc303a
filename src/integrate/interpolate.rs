//! The motion within a step.
//!
//! Displacement, velocity and acceleration are known at both ends of a Runge–Kutta step. The displacement within it is
//! the quintic Hermite polynomial (error of order h⁶), and the velocity is its derivative (error of order h⁵).

use super::Halt;

/// A quantity at one instant that a method evaluates for several instants together.
#[derive(Clone, Copy, Debug)]
pub enum Deferred<'a> {
    /// Kinetic energy and elastic energy of the shafts, J.
    ShaftEnergies([f64; 2]),
    /// The values of all recorded combinations of coordinates.
    Combinations(&'a [f64]),
}

/// The motion over a step, for observers.
pub trait Trajectory {
    /// Elapsed time at the beginning, s.
    fn begin(&self) -> f64;

    /// Elapsed time at the end, s.
    fn end(&self) -> f64;

    /// Writes displacements and velocities of `coordinates` at their indices, one vector of all coordinates for each
    /// instant.
    fn states(&mut self, instants: &[f64], coordinates: &[usize], q: &mut [f64], v: &mut [f64]);

    /// Writes the displacements and velocities of `coordinates`, and behind the displacements of each instant the sums of
    /// displacements `combinations`, given as entries (index, coefficient). One place follows for the power of the distributed
    /// damping, see [`Self::gives_damping`]. All vectors have the same length.
    fn power_states(
        &mut self,
        instants: &[f64],
        coordinates: &[usize],
        combinations: &[Vec<(usize, f64)>],
        q: &mut [f64],
        v: &mut [f64],
    ) {
        self.states(instants, coordinates, q, v);
        for (_, q, _) in at_each(instants, q, v) {
            let (q, sums) = q.split_at_mut(q.len() - combinations.len() - 1);
            for (sum, entries) in sums.iter_mut().zip(combinations) {
                *sum = entries.iter().map(|(index, coefficient)| coefficient * q[*index]).sum();
            }
        }
    }

    /// Whether [`Self::power_states`] gives the power of the distributed damping. Otherwise, the velocities give it.
    fn gives_damping(&self) -> bool {
        false
    }

    /// Writes the accelerations of `coordinates` at their indices, one vector of all coordinates for each instant of the last call
    /// of [`Self::states`]. They follow from the state and the equation of motion.
    ///
    /// # Errors
    /// [`Halt`] where the equation is not defined.
    fn accelerations(&mut self, instants: &[f64], coordinates: &[usize], a: &mut [f64]) -> Result<(), Halt>;

    /// Evaluates the loads for the recorded combinations of coordinates at the instants of the last call of [`Self::states`],
    /// and returns whether [`Self::deferred`] gives the combinations: a motion in modal coordinates has rows for them. Otherwise
    /// they follow from the coordinates.
    ///
    /// # Errors
    /// [`Halt`] where the equation is not defined.
    fn combines(&mut self, _instants: &[f64]) -> Result<bool, Halt> {
        Ok(false)
    }

    /// Whether [`Self::deferred`] gives the energies of the shafts at the instants of [`Self::states`]. Otherwise, the
    /// displacements and velocities of all coordinates give them.
    fn defers_energies(&self) -> bool {
        false
    }

    /// Passes the quantities that a method evaluates for several instants together to `receive`. In a run, `receive` gets each kind of
    /// quantity once for every instant that [`Self::states`] was called for, in the order of the instants. The last instants wait for
    /// a later call, or for
    /// [`Observer::deferred`](super::Observer::deferred).
    fn deferred(&mut self, _receive: &mut dyn FnMut(Deferred<'_>)) {}

    /// Whether the step resolves every mode, so that a polynomial of low degree is the motion within it.
    fn is_resolved(&self) -> bool {
        true
    }

    /// Whether the next step begins with exactly the state at [`Self::end`].
    fn ends_at_state(&self) -> bool {
        false
    }

    /// All displacements at the end, if the method has computed them.
    fn end_displacement(&self) -> Option<&[f64]>;
}

/// Pairs each instant with its vectors of displacements and velocities, which are stored one after the other.
pub fn at_each<'a>(
    instants: &'a [f64],
    q: &'a mut [f64],
    v: &'a mut [f64],
) -> impl Iterator<Item = (f64, &'a mut [f64], &'a mut [f64])> {
    let len = (q.len() / instants.len().max(1)).max(1);
    let states = q.chunks_exact_mut(len).zip(v.chunks_exact_mut(len));
    instants.iter().zip(states).map(|(elapsed, (q, v))| (*elapsed, q, v))
}

/// A step with the states y (displacements, then velocities) and the derivatives ẏ at its ends.
#[derive(Clone, Copy, Debug)]
pub struct Span<'a> {
    /// Elapsed time at the beginning, s.
    pub start: f64,
    /// Length, s.
    pub step: f64,
    /// The beginning.
    pub before: StepEnd<'a>,
    /// The end.
    pub after: StepEnd<'a>,
}

/// The motion at an end of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepEnd<'a> {
    /// Displacements, then velocities.
    pub state: &'a [f64],
    /// Time derivative of the state.
    pub derivative: &'a [f64],
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

    /// Weights at `elapsed` of the cubic Hermite polynomial: for state and derivative at the beginning, then at the end.
    pub fn cubic(&self, elapsed: f64) -> [f64; 4] {
        let (h, s) = (self.step, (elapsed - self.start) / self.step);
        let rise = s * s * (3.0 - 2.0 * s);
        [1.0 - rise, h * s * (1.0 - s) * (1.0 - s), rise, -h * s * s * (1.0 - s)]
    }

    /// Writes the state at `elapsed` on the cubic.
    pub fn write_cubic(&self, elapsed: f64, state: &mut [f64]) {
        let weights = self.cubic(elapsed);
        let sides = [self.before.state, self.before.derivative, self.after.state, self.after.derivative];
        for (at, value) in state.iter_mut().enumerate() {
            *value = weights.iter().zip(sides).map(|(weight, side)| weight * side[at]).sum();
        }
    }

    /// Writes displacements and velocities of `coordinates` into the state `y`.
    pub fn write_state(&self, weights: &Weights, coordinates: impl Iterator<Item = usize>, y: &mut [f64]) {
        let half = y.len() / 2;
        for index in coordinates {
            (y[index], y[half + index]) = self.at(weights, index);
        }
    }

    /// Displacement and velocity of coordinate `index`.
    pub fn at(&self, weights: &Weights, index: usize) -> (f64, f64) {
        let velocity = self.before.state.len() / 2 + index;
        let ends = [
            self.before.state[index],
            self.after.state[index],
            self.before.state[velocity],
            self.after.state[velocity],
            self.before.derivative[velocity],
            self.after.derivative[velocity],
        ];
        let sum = |weights: &[f64; 6]| weights.iter().zip(&ends).map(|(weight, end)| weight * end).sum();
        (sum(&weights.displacement), sum(&weights.velocity))
    }
}
