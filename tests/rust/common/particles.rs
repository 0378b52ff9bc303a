//! Small systems with known solutions.
#![allow(dead_code, clippy::unwrap_used, reason = "every test file uses a part of this one")]

use std::cell::Cell;
use std::rc::Rc;

use gearbow::integrate::tableau::Tableau;
use gearbow::integrate::{
    Adaptive, FirstOrderSystem, Halt, Observer, RungeKutta, State, Statistics, StepControl, Trajectory, run,
};

/// Particles q̈ᵢ = −ωᵢ² qᵢ − cᵢ qᵢ³ of unit mass; only products and sums, so counts do not depend on the platform.
#[derive(Clone, Debug)]
pub struct Particles {
    /// ωᵢ².
    pub square: Vec<f64>,
    /// cᵢ.
    pub cubic: Vec<f64>,
    /// Additional spring stiffness for q > 1. The force has a kink at q = 1.
    pub hit: f64,
    /// Evaluations of the derivative so far.
    pub evaluations: Rc<Cell<u64>>,
}

impl Particles {
    /// Particles with ωᵢ² = `square` and cᵢ = `cubic`.
    pub fn new(square: &[f64], cubic: &[f64]) -> Self {
        Self { square: square.to_vec(), cubic: cubic.to_vec(), hit: 0.0, evaluations: Rc::default() }
    }

    /// Energy of particle `index`.
    pub fn energy(&self, y: &[f64], index: usize) -> f64 {
        let (q, v) = (y[index], y[y.len() / 2 + index]);
        v * v / 2.0 + self.square[index] * q * q / 2.0 + self.cubic[index] * q.powi(4) / 4.0
    }
}

impl FirstOrderSystem for Particles {
    fn len(&self) -> usize {
        2 * self.square.len()
    }

    fn derivative(&mut self, _: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        self.evaluations.set(self.evaluations.get() + 1);
        let n = self.square.len();
        for i in 0..n {
            let q = y[i];
            derivative[i] = y[n + i];
            derivative[n + i] = -q * (self.square[i] + self.cubic[i] * q * q) - self.hit * (q - 1.0).max(0.0);
        }
        Ok(())
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        let (q, v) = difference.split_at(self.square.len());
        let sum: f64 = q.iter().zip(v).zip(&self.square).map(|((q, v), square)| square * q * q + v * v).sum();
        sum.sqrt()
    }

    fn size(&mut self, y: &[f64]) -> f64 {
        self.norm(y)
    }
}

/// Requests no output, or records every step until `end`.
#[derive(Default)]
pub struct Witness {
    /// End of the recording, s.
    pub end: Option<f64>,
    /// Start, s, length, s, and number of evaluations of every step.
    pub seen: Vec<(f64, f64, u64)>,
    /// (time, q₀, v₀) at 0.4 of the length of every step.
    pub middles: Vec<[f64; 3]>,
    /// Evaluation counter of the observed system.
    pub evaluations: Rc<Cell<u64>>,
    /// Number of calls of `go_on` after which the run stops.
    pub patience: Option<u64>,
}

impl Observer for Witness {
    fn next(&self) -> Option<f64> {
        let (last, end) = (self.seen.last().map_or(0.0, |(start, step, _)| start + step), self.end?);
        (last < end).then_some(last)
    }

    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        assert!((motion.end() - end).abs() <= 1e-12 * end);
        let step = motion.end() - motion.begin();
        self.seen.push((motion.begin(), step, self.evaluations.get()));
        let middle = motion.begin() + 0.4 * step;
        let (mut q, mut v) = ([0.0], [0.0]);
        motion.states(&[middle], &[0], &mut q, &mut v);
        self.middles.push([middle, q[0], v[0]]);
        Ok(())
    }

    fn continues(&mut self, _: f64) -> bool {
        self.patience.as_mut().is_none_or(|patience| {
            *patience = patience.saturating_sub(1);
            *patience > 0
        })
    }
}

/// Integrates `state` until `end`.
pub fn integrate<const S: usize>(
    system: &mut Particles,
    tableau: Tableau<S>,
    control: StepControl,
    state: &mut State,
    end: f64,
) -> Statistics {
    let (mut method, mut statistics) = (RungeKutta::new(tableau, system.len()), Statistics::new());
    run(system, &mut method, &control, state, end, &mut Witness::default(), &mut statistics).unwrap();
    statistics
}

/// Error control with an absolute floor of 1e-9.
pub fn adaptive(rtol: f64, longest: f64) -> StepControl {
    StepControl::Adaptive(Adaptive { rtol, floor: 1e-9, longest })
}
