//! What an integrator asks of a system, and what may stop it.

use super::{Span, Trajectory};
use crate::mesh::Overlap;

/// Why an integration stopped before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Halt {
    /// The base circles of a mesh overlap.
    Overlap {
        /// Index of the mesh.
        mesh: usize,
        /// How far.
        overlap: Overlap,
    },
    /// The state is not finite any more, or no step is short enough.
    Diverged,
    /// The observer asked for it.
    Interrupted,
}

/// A first-order system ẏ = f(t, y) of second-order origin: y holds displacements, then velocities, unless the system
/// says otherwise.
pub trait FirstOrderSystem {
    /// Length of y.
    fn len(&self) -> usize;

    /// Whether there is nothing to integrate.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes f(t, y) into `derivative`; `elapsed` is t, counted from the run's origin.
    ///
    /// # Errors
    /// [`Halt`] where f is not defined.
    fn derivative(&mut self, elapsed: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt>;

    /// The displacements that laws depend on (with their velocities), where the right-hand side changes its law at
    /// instants that depend on the motion; none where it never does.
    fn switching(&self) -> Option<&[usize]> {
        None
    }

    /// Writes the state within a step into `y`, as far as laws depend on it.
    fn within(&self, span: &Span<'_>, elapsed: f64, y: &mut [f64]) {
        let switching = self.switching().unwrap_or_default();
        span.whole(&span.weights(elapsed), switching.iter().copied(), y);
    }

    /// The motion over a step.
    fn trajectory<'a>(&'a mut self, span: Span<'a>) -> impl Trajectory + 'a {
        span
    }

    /// Writes displacements and velocities of a state.
    fn physical(&mut self, _elapsed: f64, y: &[f64], q: &mut [f64], v: &mut [f64]) {
        let (displacements, velocities) = y.split_at(y.len() / 2);
        q.copy_from_slice(displacements);
        v.copy_from_slice(velocities);
    }

    /// Writes the laws that hold at a state, of which only the [`Self::switching`] displacements and their velocities
    /// count, as numbers of the system's own.
    ///
    /// # Errors
    /// [`Halt`] where they are not defined.
    fn contact_modes_at(&mut self, _elapsed: f64, _y: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        contact_modes.clear();
        Ok(())
    }

    /// Sets the laws of the steps to come.
    fn set_contact_modes(&mut self, _laws: &[i64]) {}

    /// Energy norm of a difference of states: √(eᵀKe + ėᵀMė). Metres and radians have no other common measure.
    fn norm(&mut self, difference: &[f64]) -> f64;

    /// Energy norm of the deviation of a state from the system's equilibrium, the scale of a tolerance.
    fn size(&mut self, y: &[f64]) -> f64;
}

/// What looks at an integration while it runs.
pub trait Observer {
    /// Elapsed time up to which everything has been seen.
    fn next(&self) -> Option<f64>;

    /// Whether it wants to see every step, not only those that hold a time asked for.
    fn sees_every_step(&self) -> bool {
        false
    }

    /// Sees the motion over a step, up to `end`; called for every step that holds a time asked for.
    ///
    /// # Errors
    /// [`Halt`] where what it looks at is not defined.
    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt>;

    /// Sees that the laws of the system have changed; `read` writes displacements and velocities at that instant.
    fn switched(&mut self, _elapsed: f64, _read: &mut dyn FnMut(&mut [f64], &mut [f64]), _laws: &[i64]) {}

    /// Whether to go on, asked every few steps with the elapsed time.
    fn go_on(&mut self, elapsed: f64) -> bool;
}
