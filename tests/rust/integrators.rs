//! Integrators applied to small systems with known solutions: order, interpolation, step control and counts.

use std::rc::Rc;

use crate::common::particles::{Particles, Witness, adaptive, integrate};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{
    Adaptive, FirstOrderSystem as _, Halt, Observer, RungeKutta, Span, State, Statistics, StepControl, StepEnd,
    StepInterval, Trajectory, run,
};
use proptest::prelude::*;

/// Two linear particles and one on a softening spring, all undamped. All frequencies are low.
fn pair_and_pendulum() -> (Particles, State) {
    (Particles::new(&[1.0, 9.0, 4.0], &[0.0, 0.0, -0.8]), State::new(vec![1.0, 0.3, 1.0, 0.0, -0.5, 0.4]))
}

/// Final state with steps of 2⁻ᵏ s, whose sum has no round-off.
fn fixed<const S: usize>(tableau: Tableau<S>, k: i32) -> Vec<f64> {
    let (mut system, mut state) = pair_and_pendulum();
    integrate(&mut system, tableau, StepControl::Fixed(2.0_f64.powi(-k)), &mut state, 4.0);
    assert_eq!(state.elapsed, 4.0);
    state.y
}

#[test]
fn observed_order_is_that_of_the_tableau() {
    let (mut system, _) = pair_and_pendulum();
    let reference = fixed(DORMAND_PRINCE, 11);
    let mut error = |y: &[f64]| {
        let difference: Vec<f64> = y.iter().zip(&reference).map(|(a, b)| a - b).collect();
        system.norm(&difference)
    };
    // At 2⁻⁷ the terms of the next order are a few per cent of the error. Round-off is negligible.
    let (coarse, fine) = (error(&fixed(RK4, 6)), error(&fixed(RK4, 7)));
    assert!(((coarse / fine).log2() - f64::from(RK4.order)).abs() < 0.2, "{}", (coarse / fine).log2());
    let (coarse, fine) = (error(&fixed(DORMAND_PRINCE, 6)), error(&fixed(DORMAND_PRINCE, 7)));
    assert!(((coarse / fine).log2() - f64::from(DORMAND_PRINCE.order)).abs() < 0.2, "{}", (coarse / fine).log2());
    // The linear particles have a closed-form solution.
    let y = fixed(DORMAND_PRINCE, 8);
    assert!((y[0] - 4.0_f64.cos()).abs() < 1e-12 && (y[3] + 4.0_f64.sin()).abs() < 1e-12);
}

#[test]
fn the_embedded_error_is_of_fourth_order() {
    let (mut system, state) = pair_and_pendulum();
    let mut error = |step: f64| {
        let mut method = RungeKutta::new(DORMAND_PRINCE, system.len());
        method.begin(&mut system, 0.0, &state.y).unwrap();
        method.step(&mut system, StepInterval { begin: 0.0, end: step, length: step }, &state.y).unwrap();
        method.error(&mut system, step)
    };
    // The error of one step has the order h⁵.
    let order = (error(0.02) / error(0.01)).log2();
    assert!((order - 5.0).abs() < 0.2, "{order}");
}

/// Interpolates a known motion from the states at both ends of one step.
fn interpolated(start: f64, step: f64, motion: impl Fn(f64) -> [f64; 3], at: f64) -> (f64, f64) {
    let ends = [motion(start), motion(start + step)].map(|[q, v, a]| ([q, v], [v, a]));
    let [before, after] = [0, 1].map(|end| StepEnd { state: &ends[end].0, derivative: &ends[end].1 });
    let span = Span { start, step, before, after };
    span.at(&span.weights(at), 0)
}

#[test]
fn interpolation_is_of_sixth_order_in_displacement_and_fifth_in_velocity() {
    let sine = |t: f64| [t.sin(), t.cos(), -t.sin()];
    let errors = |step: f64| {
        let at = 1.0 + 0.3 * step;
        let (q, v) = interpolated(1.0, step, sine, at);
        [(q - at.sin()).abs(), (v - at.cos()).abs()]
    };
    let (coarse, fine) = (errors(0.2), errors(0.1));
    for (index, order) in [(0, 6.0), (1, 5.0)] {
        let observed = (coarse[index] / fine[index]).log2();
        assert!((observed - order).abs() < 0.2, "{observed}");
    }
}

proptest! {
    #![proptest_config(crate::common::cases(100))]

    #[test]
    fn interpolation_is_exact_for_a_quintic(
        c in prop::array::uniform6(-1.0..1.0), start in -2.0..2.0_f64, step in 1e-3..2.0_f64, part in 0.0..=1.0_f64,
    ) {
        let motion = |t: f64| {
            let s = t - start;
            let q = c.iter().rev().fold(0.0, |sum, c| sum * s + c);
            let v = (1..6).rev().fold(0.0, |sum, k| sum * s + k as f64 * c[k]);
            let a = (2..6).rev().fold(0.0, |sum, k| sum * s + (k * (k - 1)) as f64 * c[k]);
            [q, v, a]
        };
        let at = start + part * step;
        let ((q, v), exact) = (interpolated(start, step, motion, at), motion(at));
        // Values are at most 1e2 (a quintic at s = 2). The velocity divides their differences by the step length.
        prop_assert!((q - exact[0]).abs() < 1e-13 * 1e2 && (v - exact[1]).abs() < 1e-13 * 1e2 / step);
    }
}

proptest! {
    #![proptest_config(crate::common::cases(100))]

    #[test]
    fn the_cubic_interpolates_states_and_their_derivatives(
        c in prop::array::uniform4(-1.0..1.0), start in -2.0..2.0_f64, step in 1e-3..2.0_f64, part in 0.0..=1.0_f64,
    ) {
        let value = |t: f64| c.iter().rev().fold(0.0, |sum, c| sum * (t - start) + c);
        let slope = |t: f64| (1..4).rev().fold(0.0, |sum, k| sum * (t - start) + k as f64 * c[k]);
        let empty = StepEnd { state: &[], derivative: &[] };
        let span = Span { start, step, before: empty, after: empty };
        let at = start + part * step;
        let ends = [value(start), slope(start), value(start + step), slope(start + step)];
        let found: f64 = span.cubic(at).iter().zip(ends).map(|(weight, end)| weight * end).sum();
        // Values are at most 15 (a cubic at s = 2).
        prop_assert!((found - value(at)).abs() < 1e-14 * 15.0);
    }
}

/// q̈ = (p + 1)tᵖ. Records the evaluation times and returns NaN after the time `until`, s.
struct Clocked {
    power: i32,
    until: f64,
    times: Vec<f64>,
}

impl gearbow::integrate::FirstOrderSystem for Clocked {
    fn len(&self) -> usize {
        2
    }

    fn derivative(&mut self, elapsed: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        self.times.push(elapsed);
        let acceleration = f64::from(self.power + 1) * elapsed.powi(self.power);
        derivative.copy_from_slice(&[y[1], if elapsed > self.until { f64::NAN } else { acceleration }]);
        Ok(())
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        difference[1].abs()
    }

    fn size(&mut self, y: &[f64]) -> f64 {
        y[1].abs()
    }
}

#[test]
fn stages_are_evaluated_at_their_times() {
    fn check<const S: usize>(tableau: Tableau<S>) {
        // A method of order p integrates tᵖ⁻¹ exactly.
        let power = tableau.order as i32 - 1;
        let mut system = Clocked { power, until: f64::INFINITY, times: Vec::new() };
        let (mut method, mut statistics) = (RungeKutta::new(tableau, 2), Statistics::new());
        let mut state = State::new(vec![0.0; 2]);
        let nobody = &mut Witness::default();
        run(&mut system, &mut method, &StepControl::Fixed(0.1), &mut state, 2.05, nobody, &mut statistics).unwrap();
        let expected = state.elapsed.powi(power + 1);
        // Each of twenty steps has one rounding error.
        assert!((state.y[1] - expected).abs() < 1e-14 * expected, "{} {expected}", state.y[1]);
        // The last stage of a step is the first stage of the next, so both have exactly the same time.
        for (step, times) in system.times[1..].chunks(S - 1).enumerate() {
            assert_eq!(times[S - 2], (step + 1) as f64 * 0.1);
        }
    }
    check(RK4);
    check(DORMAND_PRINCE);
}

#[test]
fn a_step_with_a_non_finite_error_shrinks_tenfold() {
    let mut system = Clocked { power: 1, until: 5e-3, times: Vec::new() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, 2), Statistics::new());
    let (mut state, nobody) = (State::new(vec![0.0; 2]), &mut Witness::default());
    run(&mut system, &mut method, &adaptive(1e-6, 1.0), &mut state, 5e-4, nobody, &mut statistics).unwrap();
    // The steps of 1 s, 0.1 s and 10 ms are rejected. The step of 1 ms ends before the first NaN.
    assert_eq!(statistics.rejected, 3);
}

/// Requests the motion at one time.
struct Once {
    at: f64,
    seen: Option<[f64; 2]>,
}

impl Observer for Once {
    fn next(&self) -> Option<f64> {
        self.seen.is_none().then_some(self.at)
    }

    fn observe(&mut self, motion: &mut impl Trajectory, _: f64) -> Result<(), Halt> {
        self.seen = Some([motion.begin(), motion.end()]);
        Ok(())
    }

    fn continues(&mut self, _: f64) -> bool {
        true
    }
}

#[test]
fn an_output_time_at_the_end_of_a_step_belongs_to_that_step() {
    let (mut system, mut state) = pair_and_pendulum();
    let (mut method, mut statistics) = (RungeKutta::new(RK4, system.len()), Statistics::new());
    let mut once = Once { at: 1.0, seen: None };
    let control = StepControl::Fixed(1.0 / 128.0);
    run(&mut system, &mut method, &control, &mut state, 1.0, &mut once, &mut statistics).unwrap();
    assert_eq!(once.seen, Some([127.0 / 128.0, 1.0]));
    // The output needs no further step: four evaluations per step and one initial evaluation.
    assert_eq!(statistics.evaluations, 4 * 128 + 1);
}

#[test]
fn statistics_count_the_steps() {
    // The hardening spring requires short steps at large displacements. Elsewhere the step limit applies.
    let mut system = Particles::new(&[1.0], &[3.0]);
    let mut witness = Witness { end: Some(60.0), ..Witness::default() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, 2), Statistics::new());
    let mut state = State::new(vec![2.0, 0.0]);
    let longest = 0.125;
    run(&mut system, &mut method, &adaptive(1e-4, longest), &mut state, 60.0, &mut witness, &mut statistics).unwrap();
    // The last recorded step extends beyond the end and is not accepted. Step lengths from rounded times are accurate
    // to 1e-14.
    let (_, steps) = witness.seen.split_last().unwrap();
    let lengths = || steps.iter().map(|(_, step, _)| *step);
    assert_eq!(statistics.steps, steps.len() as u64);
    let at_limit = lengths().filter(|step| *step > longest - 1e-12).count() as u64;
    assert_eq!(statistics.at_limit, at_limit);
    assert!(0 < at_limit && at_limit < statistics.steps, "{at_limit} of {}", statistics.steps);
    assert!(lengths().any(|step| step > longest / 2.0 && step < 0.9 * longest), "some are nearly as long");
    assert!((statistics.shortest - lengths().fold(f64::INFINITY, f64::min)).abs() < 1e-13);
    assert_eq!(statistics.longest, longest);
    assert!(lengths().next_back().is_some_and(|last| last > statistics.shortest + 1e-6));

    let (mut system, mut state) = pair_and_pendulum();
    let fixed = integrate(&mut system, RK4, StepControl::Fixed(1.0 / 128.0), &mut state, 1.0);
    assert_eq!(fixed.at_limit, 0);
    // The initial evaluation is counted once, even if the run is paused several times.
    let mut paused = Statistics { evaluations: 513, ..Statistics::new() };
    paused.begin(1);
    assert_eq!(paused.evaluations, 513);
}

#[test]
fn interpolation_at_the_middle_of_a_step_is_as_accurate_as_the_end() {
    let (mut system, mut state) = pair_and_pendulum();
    let mut witness = Witness { end: Some(4.0), ..Witness::default() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, system.len()), Statistics::new());
    let control = StepControl::Fixed(1.0 / 64.0);
    run(&mut system, &mut method, &control, &mut state, 4.0, &mut witness, &mut statistics).unwrap();
    assert_eq!(witness.middles.len(), 256);
    for [time, q, v] in witness.middles {
        // The end state is accurate to 1e-10 with this step.
        assert!((q - time.cos()).abs() < 2e-10 && (v + time.sin()).abs() < 2e-10);
    }
}

#[test]
fn the_step_controller_follows_its_published_formula() {
    let control = Adaptive { rtol: 1e-6, floor: 0.0, longest: 1.0 };
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    close(control.grow(5, 1.0, 1.0), 0.9);
    // The exponents are 0.7/5 for the error and 0.4/5 for the previous error.
    close(control.grow(5, 0.5, 1.0), 0.9 * 2.0_f64.powf(0.14));
    close(control.grow(5, 1.0, 0.5), 0.9 * 0.5_f64.powf(0.08));
    // An error of zero counts as 1e-10. The step grows at most fivefold.
    close(control.grow(5, 0.0, 1.0), 5.0);
    // A previous error of zero does not prevent growth, because it counts as 1e-4.
    close(control.grow(5, 1.0, 0.0), 0.9 * 1e-4_f64.powf(0.08));
    close(control.shrink(5, 32.0), 0.45);
    close(control.shrink(5, 1e9), 0.2);
    // If the error is just above the tolerance, the step must still shrink.
    assert!(control.shrink(5, 1.0 + 1e-12) < 0.9);
}

#[test]
fn step_and_evaluation_counts_are_unchanged() {
    let counts = |statistics: Statistics| (statistics.steps, statistics.rejected, statistics.evaluations);
    let (mut system, mut state) = pair_and_pendulum();
    let fixed = integrate(&mut system, RK4, StepControl::Fixed(1.0 / 128.0), &mut state, 10.0);
    // Four evaluations per step and one initial evaluation.
    assert_eq!(counts(fixed), (1280, 0, 5121));
    assert_eq!((fixed.shortest, fixed.longest), (1.0 / 128.0, 1.0 / 128.0));

    let (mut system, mut state) = pair_and_pendulum();
    let smooth = integrate(&mut system, DORMAND_PRINCE, adaptive(1e-8, 1.0), &mut state, 40.0);
    let mut bouncing = Particles { hit: 1e4, ..Particles::new(&[1.0], &[0.0]) };
    let rough = integrate(&mut bouncing, DORMAND_PRINCE, adaptive(1e-6, 0.5), &mut State::new(vec![0.0, 3.0]), 40.0);
    let mut stiff = Particles::new(&[1.0, 1e6], &[0.0; 2]);
    let capped =
        integrate(&mut stiff, DORMAND_PRINCE, adaptive(1e-3, 9.8e-4), &mut State::new(vec![1.0, 0.0, 0.0, 0.0]), 1.0);
    // The last step of each run extends beyond the end and is not counted; it has six evaluations. A less efficient
    // integrator, or one that rejects more steps, changes these counts.
    assert_eq!([smooth, capped].map(counts), [(1375, 2, 8269), (1020, 0, 6127)]);
    assert_eq!(capped.at_limit, capped.steps);
    // Each impact multiplies round-off by a hundred, so these counts are reproducible to one twentieth.
    assert!(rough.steps.abs_diff(610) <= 30 && rough.rejected.abs_diff(130) <= 10, "{rough:?}");
    assert_eq!(rough.evaluations, 6 * (rough.steps + rough.rejected + 1) + 1);
}

#[test]
fn no_step_grows_right_after_a_rejection() {
    let mut system = Particles { hit: 1e4, ..Particles::new(&[1.0], &[0.0]) };
    let mut witness = Witness { end: Some(40.0), evaluations: Rc::clone(&system.evaluations), ..Witness::default() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, 2), Statistics::new());
    let mut state = State::new(vec![0.0, 3.0]);
    run(&mut system, &mut method, &adaptive(1e-6, 0.5), &mut state, 40.0, &mut witness, &mut statistics).unwrap();
    let mut rejections = 0;
    for triple in witness.seen.windows(3) {
        let [(_, _, before), (_, step, after), (_, next, _)] = triple else { unreachable!() };
        // Each attempt has six evaluations.
        let rejected = (after - before) / 6 - 1;
        rejections += rejected;
        assert!(rejected == 0 || next <= step, "{step} to {next} after {rejected} rejections");
    }
    assert!(rejections > 20, "a wall that is hit a dozen times: {rejections}");
    assert!(witness.seen.windows(2).any(|pair| pair[1].1 > 1.5 * pair[0].1), "steps do grow elsewhere");
}

/// Compares an uninterrupted run with the same run in parts.
fn split<const S: usize>(tableau: Tableau<S>, control: StepControl, stops: &[f64]) -> Result<(), TestCaseError> {
    let (mut system, mut whole) = pair_and_pendulum();
    system.hit = 50.0;
    let mut parts = whole.clone();
    integrate(&mut system, tableau, control, &mut whole, 10.0);
    for stop in stops.iter().chain(&[10.0]) {
        integrate(&mut system, tableau, control, &mut parts, *stop);
        prop_assert!(parts.elapsed <= *stop);
    }
    // Equality of floats means bitwise equality here, because no value is zero or NaN.
    prop_assert_eq!(parts, whole);
    Ok(())
}

proptest! {
    #![proptest_config(crate::common::cases(50))]

    #[test]
    fn a_run_in_two_parts_equals_the_whole_run(mut stops in prop::collection::vec(0.0..10.0_f64, 0..6)) {
        stops.sort_by(f64::total_cmp);
        split(RK4, StepControl::Fixed(0.0123), &stops)?;
        split(DORMAND_PRINCE, adaptive(1e-6, 0.5), &stops)?;
    }
}

#[test]
fn time_does_not_drift() {
    let mut system = Particles::new(&[1.0], &[0.0]);
    let (y, end) = (vec![1.0, 0.0], 1e4 + 0.05);
    // Repeated addition of 0.1 would have an error of 2e-8 after 1e5 steps. All adaptive steps have the maximum length.
    let mut state = State::new(y.clone());
    integrate(&mut system, RK4, StepControl::Fixed(0.1), &mut state, end);
    assert_eq!((state.count, state.elapsed), (100_000, 100_000.0 * 0.1));
    let mut state = State::new(y);
    integrate(&mut system, DORMAND_PRINCE, adaptive(0.5, 0.1), &mut state, end);
    assert_eq!((state.count, state.elapsed), (100_000, 100_000.0 * 0.1));
}
