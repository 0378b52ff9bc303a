//! One Runge–Kutta step, for any tableau.

use super::tableau::Tableau;
use super::{FirstOrderSystem, Halt};

/// Where a step begins and ends. The end may differ from the sum of beginning
/// and length by round-off.
#[derive(Clone, Copy, Debug)]
pub struct StepInterval {
    /// Elapsed time of the beginning, s.
    pub begin: f64,
    /// Elapsed time of the end, s.
    pub end: f64,
    /// Length, s.
    pub length: f64,
}

/// A tableau, and the last step that was taken with it.
#[derive(Clone, Debug)]
pub struct RungeKutta<const S: usize> {
    /// The coefficients.
    pub tableau: Tableau<S>,
    /// Derivatives ẏ at the stages.
    stages: [Vec<f64>; S],
    /// State at the end.
    end: Vec<f64>,
    /// Scratch: embedded error.
    error: Vec<f64>,
}

impl<const S: usize> RungeKutta<S> {
    /// Allocates the stages of a system with a state of length `len`.
    pub fn new(tableau: Tableau<S>, len: usize) -> Self {
        Self { tableau, stages: std::array::from_fn(|_| vec![0.0; len]), end: vec![0.0; len], error: vec![0.0; len] }
    }

    /// Evaluates the first stage of the next step.
    ///
    /// # Errors
    /// [`Halt`] of the system.
    pub fn begin(&mut self, system: &mut impl FirstOrderSystem, elapsed: f64, y: &[f64]) -> Result<(), Halt> {
        system.derivative(elapsed, y, &mut self.stages[0])
    }

    /// Takes a step from `y`. The first stage must be known. Stages at the end are evaluated at the end of the span itself,
    /// like the first stage of the next step.
    ///
    /// # Errors
    /// [`Halt`] of the system.
    pub fn step(&mut self, system: &mut impl FirstOrderSystem, span: StepInterval, y: &[f64]) -> Result<(), Halt> {
        for stage in 1..S {
            let (done, rest) = self.stages.split_at_mut(stage);
            combine(y, span.length, &self.tableau.weights[stage], done, &mut self.end);
            let node = self.tableau.nodes[stage];
            let time = if node < 1.0 { span.begin + node * span.length } else { span.end };
            system.derivative(time, &self.end, &mut rest[0])?;
        }
        Ok(())
    }

    /// Embedded error of the last step, in the norm of the system.
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

    /// Takes the end of the last step as the beginning of the next. `y` becomes the state there.
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

/// `out += step·Σ weights·stages`, with up to three stages in one pass. Zero weights are skipped.
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
