//! The integrators on systems small enough to know the answer of: order, interpolation, control, counts.

use std::rc::Rc;

use crate::common::particles::{Particles, Witness, adaptive, integrate};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{
    Adaptive, FirstOrderSystem as _, Halt, Observer, RungeKutta, Span, State, Statistics, StepControl, Trajectory, run,
};
use proptest::prelude::*;

/// An undamped pair, and a particle on a hardening spring of period 2π/ω·…: nothing here is fast.
fn pair_and_pendulum() -> (Particles, State) {
    (Particles::new(&[1.0, 9.0, 4.0], &[0.0, 0.0, -0.8]), State::new(vec![1.0, 0.3, 1.0, 0.0, -0.5, 0.4]))
}

/// End of the run by steps of 2⁻ᵏ, which add up exactly.
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
    // At 2⁻⁷ terms of the next order are a few percent of the error, and round-off nothing.
    let (coarse, fine) = (error(&fixed(RK4, 6)), error(&fixed(RK4, 7)));
    assert!(((coarse / fine).log2() - f64::from(RK4.order)).abs() < 0.2, "{}", (coarse / fine).log2());
    let (coarse, fine) = (error(&fixed(DORMAND_PRINCE, 6)), error(&fixed(DORMAND_PRINCE, 7)));
    assert!(((coarse / fine).log2() - f64::from(DORMAND_PRINCE.order)).abs() < 0.2, "{}", (coarse / fine).log2());
    // The linear pair alone has a closed form.
    let y = fixed(DORMAND_PRINCE, 8);
    assert!((y[0] - 4.0_f64.cos()).abs() < 1e-12 && (y[3] + 4.0_f64.sin()).abs() < 1e-12);
}

#[test]
fn the_embedded_error_is_of_fourth_order() {
    let (mut system, state) = pair_and_pendulum();
    let mut error = |step: f64| {
        let mut method = RungeKutta::new(DORMAND_PRINCE, system.len());
        method.begin(&mut system, 0.0, &state.y).unwrap();
        method.step(&mut system, (0.0, step), &state.y, step).unwrap();
        method.error(&mut system, step)
    };
    // Of one step, so h⁵.
    let order = (error(0.02) / error(0.01)).log2();
    assert!((order - 5.0).abs() < 0.2, "{order}");
}

/// A step of a motion that is known, with its ends.
fn interpolated(start: f64, step: f64, motion: impl Fn(f64) -> [f64; 3], at: f64) -> (f64, f64) {
    let ends = [motion(start), motion(start + step)].map(|[q, v, a]| ([q, v], [v, a]));
    let span = Span { start, step, before: (&ends[0].0, &ends[0].1), after: (&ends[1].0, &ends[1].1) };
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
        // Values up to 1e2 (a quintic at s = 2), differences of which the velocity divides by the step.
        prop_assert!((q - exact[0]).abs() < 1e-13 * 1e2 && (v - exact[1]).abs() < 1e-13 * 1e2 / step);
    }
}

proptest! {
    #![proptest_config(crate::common::cases(100))]

    #[test]
    fn the_cubic_goes_through_states_and_their_derivatives(
        c in prop::array::uniform4(-1.0..1.0), start in -2.0..2.0_f64, step in 1e-3..2.0_f64, part in 0.0..=1.0_f64,
    ) {
        let value = |t: f64| c.iter().rev().fold(0.0, |sum, c| sum * (t - start) + c);
        let slope = |t: f64| (1..4).rev().fold(0.0, |sum, k| sum * (t - start) + k as f64 * c[k]);
        let span = Span { start, step, before: (&[], &[]), after: (&[], &[]) };
        let at = start + part * step;
        let ends = [value(start), slope(start), value(start + step), slope(start + step)];
        let found: f64 = span.cubic(at).iter().zip(ends).map(|(weight, end)| weight * end).sum();
        // Values up to 15, a cubic at s = 2.
        prop_assert!((found - value(at)).abs() < 1e-14 * 15.0);
    }
}

/// q̈ = (p + 1)tᵖ, which remembers when it was asked, and is not a number beyond an instant.
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
fn stages_know_what_time_it_is() {
    fn check<const S: usize>(tableau: Tableau<S>) {
        // A method of order p is a rule that integrates tᵖ⁻¹ exactly.
        let power = tableau.order as i32 - 1;
        let mut system = Clocked { power, until: f64::INFINITY, times: Vec::new() };
        let (mut method, mut statistics) = (RungeKutta::new(tableau, 2), Statistics::new());
        let mut state = State::new(vec![0.0; 2]);
        let nobody = &mut Witness::default();
        run(&mut system, &mut method, &StepControl::Fixed(0.1), &mut state, 2.05, nobody, &mut statistics).unwrap();
        let expected = state.elapsed.powi(power + 1);
        // Twenty steps of a rounding each.
        assert!((state.y[1] - expected).abs() < 1e-14 * expected, "{} {expected}", state.y[1]);
        // The derivative at the end of a step is that at the beginning of the next: of one instant, to the last bit.
        for (step, times) in system.times[1..].chunks(S - 1).enumerate() {
            assert_eq!(times[S - 2], (step + 1) as f64 * 0.1);
        }
    }
    check(RK4);
    check(DORMAND_PRINCE);
}

#[test]
fn a_step_of_which_nothing_can_be_said_shrinks_tenfold() {
    let mut system = Clocked { power: 1, until: 5e-3, times: Vec::new() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, 2), Statistics::new());
    let (mut state, nobody) = (State::new(vec![0.0; 2]), &mut Witness::default());
    run(&mut system, &mut method, &adaptive(1e-6, 1.0), &mut state, 5e-4, nobody, &mut statistics).unwrap();
    // Of 1 s, 0.1 s and 10 ms; that of 1 ms is within what is a number.
    assert_eq!(statistics.rejected, 3);
}

/// Asks for the motion at one instant.
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

    fn go_on(&mut self, _: f64) -> bool {
        true
    }
}

#[test]
fn an_instant_at_the_end_of_a_step_is_seen_with_that_step() {
    let (mut system, mut state) = pair_and_pendulum();
    let (mut method, mut statistics) = (RungeKutta::new(RK4, system.len()), Statistics::new());
    let mut once = Once { at: 1.0, seen: None };
    let control = StepControl::Fixed(1.0 / 128.0);
    run(&mut system, &mut method, &control, &mut state, 1.0, &mut once, &mut statistics).unwrap();
    assert_eq!(once.seen, Some([127.0 / 128.0, 1.0]));
    // No step beyond is tried for it: four evaluations a step, and the first.
    assert_eq!(statistics.evaluations, 4 * 128 + 1);
}

#[test]
fn statistics_are_those_of_the_steps() {
    // A hardening spring wants short steps where it is stiff; elsewhere the limit holds.
    let mut system = Particles::new(&[1.0], &[3.0]);
    let mut witness = Witness { end: Some(60.0), ..Witness::default() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, 2), Statistics::new());
    let mut state = State::new(vec![2.0, 0.0]);
    let longest = 0.125;
    run(&mut system, &mut method, &adaptive(1e-4, longest), &mut state, 60.0, &mut witness, &mut statistics).unwrap();
    // The last step that is seen runs past the end and is not taken. Beginnings and ends round lengths to 1e-14.
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
    // What begins a run is counted once, however often the run is paused.
    let mut paused = Statistics { evaluations: 513, ..Statistics::new() };
    paused.begin(1);
    assert_eq!(paused.evaluations, 513);
}

#[test]
fn the_middle_of_a_step_is_as_good_as_its_end() {
    let (mut system, mut state) = pair_and_pendulum();
    let mut witness = Witness { end: Some(4.0), ..Witness::default() };
    let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, system.len()), Statistics::new());
    let control = StepControl::Fixed(1.0 / 64.0);
    run(&mut system, &mut method, &control, &mut state, 4.0, &mut witness, &mut statistics).unwrap();
    assert_eq!(witness.middles.len(), 256);
    for [time, q, v] in witness.middles {
        // The end is right to 1e-10 with this step.
        assert!((q - time.cos()).abs() < 2e-10 && (v + time.sin()).abs() < 2e-10);
    }
}

#[test]
fn the_controller_is_the_one_of_the_books() {
    let control = Adaptive { rtol: 1e-6, floor: 0.0, longest: 1.0 };
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    close(control.grow(5, 1.0, 1.0), 0.9);
    // 0.7/5 on the error and 0.4/5 on the one before.
    close(control.grow(5, 0.5, 1.0), 0.9 * 2.0_f64.powf(0.14));
    close(control.grow(5, 1.0, 0.5), 0.9 * 0.5_f64.powf(0.08));
    // No error at all counts as 1e-10 and grows no further than five times.
    close(control.grow(5, 0.0, 1.0), 5.0);
    // A previous error of nothing does not choke the step: it counts as 1e-4.
    close(control.grow(5, 1.0, 0.0), 0.9 * 1e-4_f64.powf(0.08));
    close(control.shrink(5, 32.0), 0.45);
    close(control.shrink(5, 1e9), 0.2);
    // Just above the tolerance a step must still shrink.
    assert!(control.shrink(5, 1.0 + 1e-12) < 0.9);
}

#[test]
fn counts_are_pinned() {
    let counts = |statistics: Statistics| (statistics.steps, statistics.rejected, statistics.evaluations);
    let (mut system, mut state) = pair_and_pendulum();
    let fixed = integrate(&mut system, RK4, StepControl::Fixed(1.0 / 128.0), &mut state, 10.0);
    // Four a step, and the first.
    assert_eq!(counts(fixed), (1280, 0, 5121));
    assert_eq!((fixed.shortest, fixed.longest), (1.0 / 128.0, 1.0 / 128.0));

    let (mut system, mut state) = pair_and_pendulum();
    let smooth = integrate(&mut system, DORMAND_PRINCE, adaptive(1e-8, 1.0), &mut state, 40.0);
    let mut bouncing = Particles { hit: 1e4, ..Particles::new(&[1.0], &[0.0]) };
    let rough = integrate(&mut bouncing, DORMAND_PRINCE, adaptive(1e-6, 0.5), &mut State::new(vec![0.0, 3.0]), 40.0);
    let mut stiff = Particles::new(&[1.0, 1e6], &[0.0; 2]);
    let capped =
        integrate(&mut stiff, DORMAND_PRINCE, adaptive(1e-3, 9.8e-4), &mut State::new(vec![1.0, 0.0, 0.0, 0.0]), 1.0);
    // The last step of each runs past the end: six evaluations that are no step. A slower integrator, or one that
    // rejects more, changes these.
    assert_eq!([smooth, capped].map(counts), [(1375, 2, 8269), (1020, 0, 6127)]);
    assert_eq!(capped.at_limit, capped.steps);
    // A wall multiplies round-off a hundredfold at every stroke: these hold to a twentieth.
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
        // Six evaluations an attempt.
        let rejected = (after - before) / 6 - 1;
        rejections += rejected;
        assert!(rejected == 0 || next <= step, "{step} to {next} after {rejected} rejections");
    }
    assert!(rejections > 20, "a wall that is hit a dozen times: {rejections}");
    assert!(witness.seen.windows(2).any(|pair| pair[1].1 > 1.5 * pair[0].1), "steps do grow elsewhere");
}

/// The same run at once and in parts.
fn split<const S: usize>(tableau: Tableau<S>, control: StepControl, stops: &[f64]) -> Result<(), TestCaseError> {
    let (mut system, mut whole) = pair_and_pendulum();
    system.hit = 50.0;
    let mut parts = whole.clone();
    integrate(&mut system, tableau, control, &mut whole, 10.0);
    for stop in stops.iter().chain(&[10.0]) {
        integrate(&mut system, tableau, control, &mut parts, *stop);
        prop_assert!(parts.elapsed <= *stop);
    }
    // PartialEq of floats, and none of them is zero or NaN: bit for bit.
    prop_assert_eq!(parts, whole);
    Ok(())
}

proptest! {
    #![proptest_config(crate::common::cases(50))]

    #[test]
    fn a_split_run_is_the_whole_run(mut stops in prop::collection::vec(0.0..10.0_f64, 0..6)) {
        stops.sort_by(f64::total_cmp);
        split(RK4, StepControl::Fixed(0.0123), &stops)?;
        split(DORMAND_PRINCE, adaptive(1e-6, 0.5), &stops)?;
    }
}

#[test]
fn time_does_not_drift() {
    let mut system = Particles::new(&[1.0], &[0.0]);
    let (y, end) = (vec![1.0, 0.0], 1e4 + 0.05);
    // 1e5 sums of 0.1 would be off by 2e-8; the adaptive steps are all at their limit.
    let mut state = State::new(y.clone());
    integrate(&mut system, RK4, StepControl::Fixed(0.1), &mut state, end);
    assert_eq!((state.count, state.elapsed), (100_000, 100_000.0 * 0.1));
    let mut state = State::new(y);
    integrate(&mut system, DORMAND_PRINCE, adaptive(0.5, 0.1), &mut state, end);
    assert_eq!((state.count, state.elapsed), (100_000, 100_000.0 * 0.1));
}
