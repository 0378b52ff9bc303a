//! One Runge–Kutta step, for any tableau.

use super::tableau::Tableau;
use super::{FirstOrderSystem, Halt};

/// A tableau with the buffers that its stages need.
#[derive(Clone, Debug)]
pub struct RungeKutta<const S: usize> {
    /// The coefficients.
    pub tableau: Tableau<S>,
    stages: [Vec<f64>; S],
    end: Vec<f64>,
    error: Vec<f64>,
}

impl<const S: usize> RungeKutta<S> {
    /// Buffers for a system of length `len`.
    pub fn new(tableau: Tableau<S>, len: usize) -> Self {
        Self { tableau, stages: std::array::from_fn(|_| vec![0.0; len]), end: vec![0.0; len], error: vec![0.0; len] }
    }

    /// Evaluates the derivative that the next step begins with.
    ///
    /// # Errors
    /// [`Halt`] of the system.
    pub fn begin(&mut self, system: &mut impl FirstOrderSystem, elapsed: f64, y: &[f64]) -> Result<(), Halt> {
        system.derivative(elapsed, y, &mut self.stages[0])
    }

    /// Steps from `y` at `elapsed` by `step` to `end`, which round-off may part from their sum; the first stage must
    /// stand. Stages at the end are evaluated at `end` itself, as the next step would.
    ///
    /// # Errors
    /// [`Halt`] of the system.
    pub fn step(
        &mut self,
        system: &mut impl FirstOrderSystem,
        (elapsed, end): (f64, f64),
        y: &[f64],
        step: f64,
    ) -> Result<(), Halt> {
        for stage in 1..S {
            let (done, rest) = self.stages.split_at_mut(stage);
            combine(y, step, &self.tableau.weights[stage], done, &mut self.end);
            let node = self.tableau.nodes[stage];
            let time = if node < 1.0 { elapsed + node * step } else { end };
            system.derivative(time, &self.end, &mut rest[0])?;
        }
        Ok(())
    }

    /// The embedded error of the last step, in the system's norm.
    pub fn error(&mut self, system: &mut impl FirstOrderSystem, step: f64) -> f64 {
        self.error.fill(0.0);
        accumulate(step, &self.tableau.error, &self.stages, &mut self.error);
        system.norm(&self.error)
    }

    /// State at the end of the last step.
    pub fn end(&self) -> &[f64] {
        &self.end
    }

    /// Derivatives at the beginning and at the end of the last step.
    pub fn derivatives(&self) -> (&[f64], &[f64]) {
        (&self.stages[0], &self.stages[S - 1])
    }

    /// Takes the end of the last step as the beginning of the next; `y` gets its state.
    pub fn commit(&mut self, y: &mut Vec<f64>) {
        std::mem::swap(y, &mut self.end);
        self.stages.swap(0, S - 1);
    }
}

/// `out = y + step·Σ weights·stages`.
fn combine(y: &[f64], step: f64, weights: &[f64], stages: &[Vec<f64>], out: &mut [f64]) {
    out.copy_from_slice(y);
    accumulate(step, weights, stages, out);
}

/// `out += step·Σ weights·stages`, up to three stages a pass; weights of zero cost nothing.
fn accumulate(step: f64, weights: &[f64], stages: &[Vec<f64>], out: &mut [f64]) {
    let mut used = weights.iter().zip(stages).filter(|(weight, _)| **weight != 0.0);
    loop {
        match (used.next(), used.next(), used.next()) {
            (Some((a, k)), Some((b, l)), Some((c, m))) => {
                let (a, b, c) = (step * a, step * b, step * c);
                for (((out, k), l), m) in out.iter_mut().zip(k).zip(l).zip(m) {
                    *out += a * k + b * l + c * m;
                }
            }
            (Some((a, k)), Some((b, l)), None) => {
                let (a, b) = (step * a, step * b);
                for ((out, k), l) in out.iter_mut().zip(k).zip(l) {
                    *out += a * k + b * l;
                }
                return;
            }
            (Some((a, k)), None, _) => {
                let a = step * a;
                for (out, k) in out.iter_mut().zip(k) {
                    *out += a * k;
                }
                return;
            }
            _ => return,
        }
    }
}
