//! The state of an integration, and its form as plain numbers.

/// The state between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Number of fixed steps, or of units of the time grid, since the origin.
    pub count: u64,
    /// Elapsed time since the origin, s.
    pub elapsed: f64,
    /// Length of the step to try next, s; zero before the first step.
    pub next_step: f64,
    /// Error of the previous step in multiples of its tolerance.
    pub previous_error: f64,
    /// Contact modes as integer codes of the system; empty before the first step.
    pub contact_modes: Vec<i64>,
    /// Displacements, then velocities; or the coordinates of the system, such as the modal state z.
    pub y: Vec<f64>,
    /// Modal state z for which `y` holds displacements and velocities, after a run in modal coordinates; otherwise empty.
    pub modal: Vec<f64>,
    /// What the method keeps between steps.
    pub method: MethodState,
}

/// What a method keeps between steps, besides the state.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum MethodState {
    /// No step has been taken.
    #[default]
    Start,
    /// A Runge–Kutta method.
    RungeKutta {
        /// Round-off that the sum of step lengths has accumulated, s.
        compensation: f64,
    },
    /// The exponential method.
    Exponential(ExponentialState),
}

/// What the exponential method keeps between steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExponentialState {
    /// Elapsed time of unit zero of the time grid, s.
    pub time_base: f64,
    /// Time from the unit `count` of the state to the state, s: positive after a contact change, until the next unit.
    pub since_unit: f64,
    /// Mean and variation of the force of each connection since the origin, or since the last change of the method; empty
    /// before the first step.
    pub force_variations: Vec<ForceVariation>,
    /// The previous step, from which the loads of the next step are predicted.
    pub history: StepHistory,
}

/// Mean and variation of a force over the time of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceVariation {
    /// Time, s.
    pub duration: f64,
    /// Mean, N.
    pub mean: f64,
    /// Integral over time of the squared difference from the mean, N²·s.
    pub squares: f64,
}

impl ForceVariation {
    /// Mean and variation at the beginning of a run, when the force is `force`, N.
    pub fn of(force: f64) -> Self {
        Self { duration: 0.0, mean: force, squares: 0.0 }
    }

    /// Mean and variation after one more step of `length`, s, at whose end the force is `force`, N. The sums follow West
    /// (1979): they do not subtract large numbers.
    pub fn with(self, force: f64, length: f64) -> Self {
        let duration = self.duration + length;
        let difference = force - self.mean;
        let mean = self.mean + difference * length / duration;
        Self { duration, mean, squares: self.squares + length * difference * (force - mean) }
    }

    /// Standard deviation over the time of the run, N.
    pub fn deviation(self) -> f64 {
        if self.duration > 0.0 { (self.squares / self.duration).sqrt() } else { 0.0 }
    }
}

/// The previous step of the exponential method; empty if there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepHistory {
    /// Evaluated loads, stage after stage, N or N·m.
    pub loads: Vec<f64>,
    /// Interface states, stage after stage.
    pub interface_states: Vec<f64>,
    /// Stiffness, then damping, of the contacts beyond the linear motion, stage after stage, N/m and N·s/m.
    pub residual_tangent: Vec<f64>,
    /// Length of the step, s.
    pub step: f64,
    /// Factor by which an iteration reduced the residual of the stage equations.
    pub contraction: f64,
}

impl State {
    /// The state at the beginning of a run.
    pub fn new(y: Vec<f64>) -> Self {
        Self {
            count: 0,
            elapsed: 0.0,
            next_step: 0.0,
            previous_error: 1.0,
            contact_modes: Vec::new(),
            y,
            modal: Vec::new(),
            method: MethodState::Start,
        }
    }

    /// The offset of the elapsed time that the method keeps, s: `compensation` or `since_unit`.
    pub fn time_offset(&self) -> f64 {
        match &self.method {
            MethodState::Start => 0.0,
            MethodState::RungeKutta { compensation } => *compensation,
            MethodState::Exponential(own) => own.since_unit,
        }
    }

    /// Modal state and method state, except for the time offset, as plain numbers. The length precedes each vector.
    pub fn method_numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        let mut push = |vector: &[f64]| {
            numbers.push(vector.len() as f64);
            numbers.extend_from_slice(vector);
        };
        if !self.modal.is_empty() {
            push(&self.modal);
        }
        if let MethodState::Exponential(ExponentialState { time_base, force_variations, history, .. }) = &self.method {
            push(&history.loads);
            push(&history.interface_states);
            push(&history.residual_tangent);
            push(
                &force_variations
                    .iter()
                    .flat_map(|force| [force.duration, force.mean, force.squares])
                    .collect::<Vec<f64>>(),
            );
            numbers.extend([*time_base, history.step, history.contraction]);
        }
        numbers
    }

    /// Sets modal state and method state from [`Self::time_offset`] and [`Self::method_numbers`]. Numbers of another form
    /// are ignored: the run then begins anew from `y`.
    pub fn set_method(&mut self, time_offset: f64, numbers: &[f64]) {
        let mut rest = Numbers(numbers);
        self.modal = rest.vector().unwrap_or_default();
        self.method = match rest.exponential(time_offset) {
            Some(own) => MethodState::Exponential(own),
            None => MethodState::RungeKutta { compensation: time_offset },
        };
    }
}

impl MethodState {
    /// Round-off that the sum of step lengths has accumulated, s.
    pub(super) fn compensation(&self) -> f64 {
        if let Self::RungeKutta { compensation } = self { *compensation } else { 0.0 }
    }
}

impl StepHistory {
    /// Removes the step.
    pub fn clear(&mut self) {
        for vector in [&mut self.loads, &mut self.interface_states, &mut self.residual_tangent] {
            vector.clear();
        }
    }

    /// Stores a step: loads, interface states and tangent, its length, s, and its contraction.
    pub fn set(&mut self, vectors: [&[f64]; 3], step: f64, contraction: f64) {
        let own = [&mut self.loads, &mut self.interface_states, &mut self.residual_tangent];
        for (own, vector) in own.into_iter().zip(vectors) {
            own.clear();
            own.extend_from_slice(vector);
        }
        (self.step, self.contraction) = (step, contraction);
    }

    /// Whether loads, interface states and tangent have these lengths.
    pub fn has_lengths(&self, lengths: [usize; 3]) -> bool {
        [self.loads.len(), self.interface_states.len(), self.residual_tangent.len()] == lengths
    }
}

/// Plain numbers that have not been read yet.
struct Numbers<'a>(&'a [f64]);

impl Numbers<'_> {
    fn number(&mut self) -> Option<f64> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// Reads a vector: its length, then its entries.
    fn vector(&mut self) -> Option<Vec<f64>> {
        let len = self.number()?;
        let (vector, rest) = self.0.split_at_checked(len as usize)?;
        self.0 = rest;
        (vector.len() as f64 == len).then(|| vector.to_vec())
    }

    fn exponential(&mut self, since_unit: f64) -> Option<ExponentialState> {
        let (loads, interface_states, residual_tangent) = (self.vector()?, self.vector()?, self.vector()?);
        let variations = self.vector()?;
        let force_variations = variations
            .chunks_exact(3)
            .map(|values| ForceVariation { duration: values[0], mean: values[1], squares: values[2] })
            .collect();
        let (time_base, step, contraction) = (self.number()?, self.number()?, self.number()?);
        let history = StepHistory { loads, interface_states, residual_tangent, step, contraction };
        self.0.is_empty().then_some(ExponentialState { time_base, since_unit, force_variations, history })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variation_of_a_force_weighs_values_with_the_lengths_of_their_steps() {
        // A mean of (1·2 + 3·5)/4 = 4.25 N, and a variance of (1·(2 − 4.25)² + 3·(5 − 4.25)²)/4 N².
        let force = ForceVariation::of(7.0).with(2.0, 1.0).with(5.0, 1.0).with(5.0, 2.0);
        assert!((force.mean - 4.25).abs() < 1e-15 && force.duration == 4.0);
        assert!((force.deviation() - 1.6875_f64.sqrt()).abs() < 1e-15);
        assert!(ForceVariation::of(7.0).deviation() == 0.0);
    }

    fn states() -> [State; 4] {
        let history = StepHistory {
            loads: vec![1.0, 2.0],
            interface_states: vec![3.0],
            residual_tangent: vec![],
            step: 1e-5,
            contraction: f64::INFINITY,
        };
        let force_variations = vec![ForceVariation::of(-3.0).with(4.0, 0.1), ForceVariation::of(0.0)];
        let own = ExponentialState { time_base: 0.5, since_unit: 1e-9, force_variations, history };
        let modal = vec![0.25, -0.5];
        let compensated = MethodState::RungeKutta { compensation: -1e-17 };
        [
            State { method: compensated.clone(), ..State::new(vec![0.0; 2]) },
            State { method: compensated, modal: modal.clone(), ..State::new(vec![0.0; 2]) },
            State { method: MethodState::Exponential(own), modal: modal.clone(), ..State::new(vec![0.0; 2]) },
            State { method: MethodState::Exponential(ExponentialState::default()), modal, ..State::new(vec![0.0; 2]) },
        ]
    }

    #[test]
    fn plain_numbers_give_the_same_state() {
        for state in states() {
            let mut read = State::new(state.y.clone());
            read.set_method(state.time_offset(), &state.method_numbers());
            assert_eq!(read, state);
        }
    }

    #[test]
    fn numbers_of_another_form_are_ignored() {
        for numbers in [&[][..], &[f64::NAN, 1.0], &[-1.0, 1.0], &[1e300], &[1.5, 2.0, 3.0], &[f64::INFINITY]] {
            let mut read = State::new(Vec::new());
            read.set_method(1e-17, numbers);
            assert!(read.modal.is_empty(), "{numbers:?}");
            assert_eq!(read.method, MethodState::RungeKutta { compensation: 1e-17 });
        }
    }
}
