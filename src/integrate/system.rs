//! Interfaces of an integrator: the system, the motion over a step, and the observer.

use super::{Deferred, Span, Trajectory, at_each};
use crate::connection::{OutOfRange, Touch};
use crate::mesh::Overlap;

/// A first-order system ẏ = f(t, y). y holds displacements, then velocities, unless the system has its own coordinates.
pub trait FirstOrderSystem {
    /// Length of y.
    fn len(&self) -> usize;

    /// Whether y is empty.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes f(t, y) into `derivative`. `elapsed` is t, counted from the origin of the run, s.
    ///
    /// # Errors
    /// [`Halt`] where f is not defined.
    fn derivative(&mut self, elapsed: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt>;

    /// Indices of the displacements that decide, with their velocities, on the contact modes; none if the system has no
    /// contact modes.
    fn switching(&self) -> Option<&[usize]> {
        None
    }

    /// Interpolates the state within a step, as far as contact modes depend on it.
    fn within(&self, span: &Span<'_>, elapsed: f64, y: &mut [f64]) {
        let switching = self.switching().unwrap_or_default();
        span.write_state(&span.weights(elapsed), switching.iter().copied(), y);
    }

    /// The motion over a step.
    fn trajectory<'a>(&'a mut self, span: Span<'a>) -> impl Trajectory + 'a {
        SystemTrajectory { system: self, span }
    }

    /// Writes all displacements and velocities of a state.
    fn physical(&mut self, _elapsed: f64, y: &[f64], q: &mut [f64], v: &mut [f64]) {
        let (displacements, velocities) = y.split_at(y.len() / 2);
        q.copy_from_slice(displacements);
        v.copy_from_slice(velocities);
    }

    /// Writes the contact modes at a state as integer codes. Only the [`Self::switching`] displacements and their
    /// velocities are used.
    ///
    /// # Errors
    /// [`Halt`] where the contact modes are not defined.
    fn contact_modes_at(&mut self, _elapsed: f64, _y: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        contact_modes.clear();
        Ok(())
    }

    /// Sets the contact modes of the following steps.
    fn set_contact_modes(&mut self, _contact_modes: &[i64]) {}

    /// Energy norm √(eᵀKe + ėᵀMė) of a difference of states. It is a common measure of metres and radians.
    fn norm(&mut self, difference: &[f64]) -> f64;

    /// Energy norm of the deviation of a state from the equilibrium. A tolerance is relative to it.
    fn size(&mut self, y: &[f64]) -> f64;
}

/// Reads the motion during an integration.
pub trait Observer {
    /// Elapsed time of the next instant to observe, s; none if there is none left.
    fn next(&self) -> Option<f64>;

    /// Whether to call [`Self::observe`] for every step, not only for steps that contain [`Self::next`].
    fn sees_every_step(&self) -> bool {
        false
    }

    /// Reads the motion over a step up to `end`, s.
    ///
    /// # Errors
    /// [`Halt`] where a quantity is not defined.
    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt>;

    /// Receives new contact modes. `read` writes displacements and velocities at that instant.
    fn switched(&mut self, _elapsed: f64, _read: &mut dyn FnMut(&mut [f64], &mut [f64]), _contact_modes: &[i64]) {}

    /// Receives a quantity at one of the last instants that were observed, in their order: those that no
    /// [`Trajectory::deferred`] has passed before the end of the run.
    fn deferred(&mut self, _quantity: Deferred<'_>) {}

    /// Whether to continue. The loop over steps asks at regular intervals of steps.
    fn continues(&mut self, elapsed: f64) -> bool;
}

/// The motion of a system in displacements and velocities over a step.
struct SystemTrajectory<'a, S: ?Sized> {
    system: &'a mut S,
    span: Span<'a>,
}

impl<S: FirstOrderSystem + ?Sized> Trajectory for SystemTrajectory<'_, S> {
    fn begin(&self) -> f64 {
        self.span.start
    }

    fn end(&self) -> f64 {
        self.span.start + self.span.step
    }

    fn states(&mut self, instants: &[f64], coordinates: &[usize], q: &mut [f64], v: &mut [f64]) {
        for (elapsed, q, v) in at_each(instants, q, v) {
            let weights = self.span.weights(elapsed);
            for index in coordinates {
                (q[*index], v[*index]) = self.span.at(&weights, *index);
            }
        }
    }

    fn accelerations(&mut self, instants: &[f64], coordinates: &[usize], a: &mut [f64]) -> Result<(), Halt> {
        let len = self.span.before.state.len();
        let (mut y, mut derivative) = (vec![0.0; len], vec![0.0; len]);
        for (elapsed, a) in instants.iter().zip(a.chunks_exact_mut((len / 2).max(1))) {
            self.span.write_state(&self.span.weights(*elapsed), 0..len / 2, &mut y);
            self.system.derivative(*elapsed, &y, &mut derivative)?;
            coordinates.iter().for_each(|index| a[*index] = derivative[len / 2 + index]);
        }
        Ok(())
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        let y = self.span.after.state;
        Some(&y[..y.len() / 2])
    }
}

/// Why an integration stopped before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Halt {
    /// The base circles of a mesh overlap, so that its geometry is not defined.
    Overlap {
        /// Index of the mesh.
        mesh: usize,
        /// Radii and distance.
        overlap: Overlap,
    },
    /// A journal touches its bearing.
    Touch(Touch),
    /// The state is not finite, or no step is short enough.
    Diverged,
    /// The observer stopped the run.
    Interrupted,
}

impl Halt {
    /// The reason where a connection has no force; `mesh` is its index, if it is a mesh. Only meshes have base circles.
    pub fn out_of_range(mesh: Option<usize>, reason: OutOfRange) -> Self {
        match reason {
            OutOfRange::Overlap(overlap) => Self::Overlap { mesh: mesh.unwrap_or_default(), overlap },
            OutOfRange::Touch(touch) => Self::Touch(touch),
        }
    }
}
