//! Changes of contact mode within steps. A ball falls onto a spring; flight and contact phases have closed forms.

use crate::common::particles::{Witness, adaptive};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{
    FirstOrderSystem, Halt, Observer, RungeKutta, State, Statistics, StepControl, Trajectory, run,
};
use proptest::prelude::*;

/// ω of the spring, rad/s, and the acceleration by its preload, m/s². The force jumps where the contact mode changes.
const STIFF: f64 = 40.0;
const PUSH: f64 = 3.0;
const GRAVITY: f64 = 1.0;

/// A ball above a spring at q = 0: q̈ = −g in flight and q̈ = PUSH − ω²q − g in contact. The contact mode is 1 in
/// contact.
#[derive(Clone, Debug, Default)]
struct Ball {
    touched: bool,
    evaluations: u64,
}

impl FirstOrderSystem for Ball {
    fn len(&self) -> usize {
        2
    }

    fn derivative(&mut self, _: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        self.evaluations += 1;
        let spring = if self.touched { PUSH - STIFF * STIFF * y[0] } else { 0.0 };
        derivative.copy_from_slice(&[y[1], spring - GRAVITY]);
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        Some(&[0])
    }

    fn contact_modes_at(&mut self, _: f64, y: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        contact_modes.clear();
        contact_modes.push(i64::from(y[0] < 0.0));
        Ok(())
    }

    fn set_contact_modes(&mut self, contact_modes: &[i64]) {
        self.touched = contact_modes == [1];
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        (STIFF * difference[0]).hypot(difference[1])
    }

    fn size(&mut self, y: &[f64]) -> f64 {
        self.norm(y)
    }
}

fn drop_from(height: f64) -> State {
    State::new(vec![height, 0.0])
}

fn integrate<const S: usize>(tableau: Tableau<S>, control: StepControl, state: &mut State, end: f64) -> Statistics {
    let (mut ball, mut statistics) = (Ball::default(), Statistics::new());
    let mut method = RungeKutta::new(tableau, 2);
    run(&mut ball, &mut method, &control, state, end, &mut Witness::default(), &mut statistics).unwrap();
    assert_eq!(ball.evaluations, statistics.evaluations);
    statistics
}

/// Durations of the fall from `height` and of one contact phase, s. The contact oscillation has its centre at (PUSH −
/// g)/ω² above the spring.
fn durations(height: f64) -> [f64; 2] {
    let speed = (2.0 * GRAVITY * height).sqrt();
    let lift = (PUSH - GRAVITY) / STIFF;
    [speed / GRAVITY, 2.0 * (speed / lift).atan() / STIFF]
}

/// Exact state at `time`.
fn exact(height: f64, time: f64) -> [f64; 2] {
    let [fall, stroke] = durations(height);
    let since = (time + fall) % (2.0 * fall + stroke);
    let speed = GRAVITY * fall;
    if since <= 2.0 * fall {
        return [speed * since - GRAVITY * since * since / 2.0, speed - GRAVITY * since];
    }
    let (sin, cos) = (STIFF * (since - 2.0 * fall)).sin_cos();
    let middle = (PUSH - GRAVITY) / (STIFF * STIFF);
    [middle * (1.0 - cos) - speed / STIFF * sin, middle * STIFF * sin - speed * cos]
}

/// Error after the third contact phase in the energy norm. All runs use a uniform time grid, so the end time does not
/// depend on the method.
fn error<const S: usize>(tableau: Tableau<S>, control: StepControl) -> (f64, Statistics) {
    let mut state = drop_from(0.5);
    let statistics = integrate(tableau, control, &mut state, 7.0);
    let expected = exact(0.5, state.elapsed);
    (Ball::default().norm(&[state.y[0] - expected[0], state.y[1] - expected[1]]), statistics)
}

#[test]
fn a_force_jump_does_not_reduce_the_order() {
    let at = |k: i32| error(RK4, StepControl::Fixed(2.0_f64.powi(-k)));
    let ((coarse, _), (fine, statistics)) = (at(9), at(10));
    let order = (coarse / fine).log2();
    // RK4 integrates the parabolic flights exactly. The fifth-order energy error of a contact phase changes the
    // following flights; its effect exceeds that of the fourth-order phase error. Without event location the order
    // would be one.
    assert!(order > 4.0, "{order}: {coarse:e} {fine:e}");
    // Three contact phases begin at 1, 3.1 and 5.2 s. Each has two contact changes.
    assert_eq!(statistics.events, 6);
    let (found, statistics) = error(DORMAND_PRINCE, adaptive(1e-10, 0.1));
    // Each of 400 steps has an error below the tolerance, relative to the size ω·0.5 = 20 of the motion.
    assert!(found < 400.0 * 1e-10 * 20.0, "{found:e}");
    assert_eq!(statistics.events, 6);
}

#[test]
fn a_contact_change_is_located_to_round_off() {
    // The witness records every step. One step ends at the first contact.
    let mut state = drop_from(0.5);
    let mut witness = Witness { end: Some(1.1), ..Witness::default() };
    let mut method = RungeKutta::new(RK4, 2);
    let control = StepControl::Fixed(0.03);
    run(&mut Ball::default(), &mut method, &control, &mut state, 1.1, &mut witness, &mut Statistics::new()).unwrap();
    let [fall, stroke] = durations(0.5);
    let ends: Vec<f64> = witness.seen.iter().map(|(start, step, _)| start + step).collect();
    let nearest = |time: f64| ends.iter().map(|end| (end - time).abs()).fold(f64::INFINITY, f64::min);
    // The first contact is accurate to 1e-13 of the step plus round-off of the time. The contact phase uses steps of
    // about one radian.
    assert!(nearest(fall) < 1e-14, "{:e}", nearest(fall));
    assert!(nearest(fall + stroke) < 1e-2, "{:e}", nearest(fall + stroke));
}

/// Records the contact changes of a run: time, s, displacement, m, and velocity, m/s.
#[derive(Default)]
struct Changes {
    seen: Vec<[f64; 3]>,
}

impl Observer for Changes {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _: &mut impl Trajectory, _: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn switched(&mut self, elapsed: f64, read: &mut dyn FnMut(&mut [f64], &mut [f64]), _: &[i64]) {
        let (mut q, mut v) = ([0.0], [0.0]);
        read(&mut q, &mut v);
        self.seen.push([elapsed, q[0], v[0]]);
    }

    fn continues(&mut self, _: f64) -> bool {
        true
    }
}

#[test]
fn observers_receive_the_time_of_each_contact_change() {
    let mut changes = Changes::default();
    let mut method = RungeKutta::new(RK4, 2);
    let control = StepControl::Fixed(2.0_f64.powi(-10));
    run(&mut Ball::default(), &mut method, &control, &mut drop_from(0.5), 2.0, &mut changes, &mut Statistics::new())
        .unwrap();
    // The initial contact mode and the two contact changes of the first contact phase.
    let [begin, touch, lift] = changes.seen[..] else { panic!("{:?}", changes.seen) };
    let [fall, stroke] = durations(0.5);
    assert_eq!(begin, [0.0, 0.5, 0.0]);
    // A contact phase of 3 rad takes 75 steps of fourth order. A repeated step ends close to the interpolated event.
    for ([time, q, v], expected) in [(touch, [fall, 0.0, -1.0]), (lift, [fall + stroke, 0.0, 1.0])] {
        assert!(
            (time - expected[0]).abs() < 1e-6 && q.abs() < 1e-10 && (v - expected[2]).abs() < 1e-5,
            "{time} {q} {v}"
        );
    }
}

/// A ball in free flight. The contact mode tells whether it is above a mark; the mark has no effect on the motion.
struct Marked {
    mark: f64,
}

impl FirstOrderSystem for Marked {
    fn len(&self) -> usize {
        2
    }

    fn derivative(&mut self, _: f64, y: &[f64], derivative: &mut [f64]) -> Result<(), Halt> {
        derivative.copy_from_slice(&[y[1], -GRAVITY]);
        Ok(())
    }

    fn switching(&self) -> Option<&[usize]> {
        Some(&[0])
    }

    fn contact_modes_at(&mut self, _: f64, y: &[f64], contact_modes: &mut Vec<i64>) -> Result<(), Halt> {
        contact_modes.clear();
        contact_modes.push(i64::from(y[0] > self.mark));
        Ok(())
    }

    fn norm(&mut self, difference: &[f64]) -> f64 {
        difference[0].hypot(difference[1])
    }

    fn size(&mut self, y: &[f64]) -> f64 {
        self.norm(y)
    }
}

#[test]
fn a_contact_within_one_step_is_found() {
    // Thrown up with 1 m/s, the ball is above the mark from 0.6 s to 1.4 s. One step contains both changes.
    let (mut changes, mut method) = (Changes::default(), RungeKutta::new(RK4, 2));
    let mut state = State::new(vec![0.0, 1.0]);
    run(
        &mut Marked { mark: 0.42 },
        &mut method,
        &StepControl::Fixed(2.0),
        &mut state,
        3.0,
        &mut changes,
        &mut Statistics::new(),
    )
    .unwrap();
    let times: Vec<f64> = changes.seen.iter().map(|change| change[0]).collect();
    let [begin, above, below] = times[..] else { panic!("{times:?}") };
    // The interpolation of a parabola is exact. The event time is accurate to 1e-13 of the step.
    assert!(begin == 0.0 && (above - 0.6).abs() < 1e-12 && (below - 1.4).abs() < 1e-12, "{times:?}");
}

#[test]
fn the_step_length_is_kept_after_a_contact_change() {
    // After an event the remainder of the grid step follows, so the grid does not move: 700 steps, six of them in two
    // pieces.
    let mut state = drop_from(0.6);
    let statistics = integrate(RK4, StepControl::Fixed(0.01), &mut state, 7.005);
    assert_eq!((state.count, state.elapsed), (700, 700.0 * 0.01));
    assert_eq!((statistics.steps, statistics.events), (706, 6));
    // From 0.5 m the first contact is at 1 s, which is the end of a step. There is no remainder.
    let statistics = integrate(RK4, StepControl::Fixed(0.01), &mut drop_from(0.5), 7.005);
    assert_eq!((statistics.steps, statistics.events), (705, 6));
}

#[test]
fn a_grazing_contact_does_not_stop_the_run() {
    // The ball rests at the contact change, and the spring force is nonzero at first contact. The contact mode changes
    // without end.
    let mut state = State::new(vec![0.0, 0.0]);
    let statistics = integrate(RK4, StepControl::Fixed(0.01), &mut state, 1.005);
    assert_eq!(state.count, 100);
    assert!(statistics.evaluations < 100_000, "{statistics:?}");
    assert!(state.y[0].abs() < 1e-2 && state.y[1].abs() < 0.2, "{:?}", state.y);
}

proptest! {
    #![proptest_config(crate::common::cases(60))]

    #[test]
    fn a_run_in_two_parts_equals_the_whole_run(
        mut stops in prop::collection::vec(0.0..8.0_f64, 0..6), height in 0.01..1.0_f64, exactly: bool,
    ) {
        // One stop may coincide with a contact change.
        if exactly {
            stops.push(durations(height)[0]);
        }
        stops.sort_by(f64::total_cmp);
        fn parts<const S: usize>(tableau: Tableau<S>, control: StepControl, stops: &[f64], height: f64) -> [State; 2] {
            let mut whole = drop_from(height);
            let mut parts = whole.clone();
            integrate(tableau, control, &mut whole, 8.0);
            for stop in stops.iter().chain(&[8.0]) {
                integrate(tableau, control, &mut parts, *stop);
            }
            [parts, whole]
        }
        let [parted, whole] = parts(RK4, StepControl::Fixed(0.0123), &stops, height);
        prop_assert_eq!(parted, whole);
        let [parted, whole] = parts(DORMAND_PRINCE, adaptive(1e-6, 0.1), &stops, height);
        prop_assert_eq!(parted, whole);
    }
}
