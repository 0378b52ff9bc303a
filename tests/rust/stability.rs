//! Where explicit steps stay bounded, and what says so when they do not.

use crate::common::particles::{Particles, Witness, adaptive, integrate};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{
    FirstOrderSystem as _, Halt, Halted, RungeKutta, State, Statistics, StepControl, StepLimit, run,
};
use num_complex::Complex64;

#[test]
fn capped_steps_stay_bounded_on_undamped_stiffness() {
    let energy = |longest: f64| {
        let mut system = Particles::new(&[1e2, 1e8], &[0.0; 2]);
        // The fast oscillator holds 1e-10 of the energy: far below what the tolerance sees.
        let mut state = State::new(vec![0.1, 1e-9, 0.0, 0.0]);
        let before = system.energy(&state.y, 1);
        integrate(&mut system, DORMAND_PRINCE, adaptive(1e-3, longest), &mut state, 1.0);
        system.energy(&state.y, 1) / before
    };
    let capped = energy(DORMAND_PRINCE.imaginary_limit / 1e4);
    assert!(capped <= 1.0, "{capped}");
    // What the cap is for: error control alone reports success while the fast one grows.
    let uncapped = energy(1.0);
    assert!(uncapped > 1e4, "{uncapped}");
}

/// Amplitude of an undamped oscillator after `steps` of `angle` = hω each, begun at one.
fn amplitude<const S: usize>(tableau: Tableau<S>, angle: f64, steps: u32) -> f64 {
    let mut system = Particles::new(&[1.0], &[0.0]);
    let mut state = State::new(vec![1.0, 0.0]);
    integrate(&mut system, tableau, StepControl::Fixed(angle), &mut state, angle * (f64::from(steps) + 0.5));
    assert_eq!(state.count, u64::from(steps));
    system.norm(&state.y)
}

#[test]
fn the_stability_limits_are_where_the_tableaux_say() {
    // |R| − 1 is −9e-4 at 2.828 and +2e-3 at 2.83: thousands of steps tell.
    assert!(amplitude(RK4, RK4.imaginary_limit, 20_000) <= 1.0);
    assert!(amplitude(RK4, 2.83, 20_000) > 1e3);
    assert!(amplitude(DORMAND_PRINCE, DORMAND_PRINCE.imaginary_limit, 20_000) <= 1.0);
    // Beyond 0.997 Dormand–Prince grows, by 9e-5 a step at 1.1.
    assert!(amplitude(DORMAND_PRINCE, 1.1, 100_000) > 100.0);
}

/// R(z) of a tableau: its end after a step on ẏ = λy, hλ = z.
fn stability<const S: usize>(tableau: &Tableau<S>, z: Complex64) -> f64 {
    let mut stages = [Complex64::ZERO; S];
    let mut end = Complex64::ONE;
    for stage in 0..S {
        end = 1.0 + (0..stage).map(|j| stages[j] * tableau.weights[stage][j]).sum::<Complex64>();
        stages[stage] = z * end;
    }
    end.norm()
}

#[test]
fn every_decaying_motion_within_both_limits_is_stable() {
    fn check<const S: usize>(tableau: &Tableau<S>) {
        for i in 0..=600 {
            for j in 0..=600 {
                let re = -tableau.real_limit * f64::from(i) / 600.0;
                let im = tableau.imaginary_limit * f64::from(j) / 600.0;
                let z = Complex64::new(re, im);
                if z.norm() <= tableau.real_limit || i == 0 {
                    let growth = stability(tableau, z);
                    assert!(growth <= 1.0 + 4.0 * f64::EPSILON, "|R({z})| = {growth}");
                }
            }
        }
    }
    check(&RK4);
    check(&DORMAND_PRINCE);
    for (row, node) in DORMAND_PRINCE.weights.iter().zip(DORMAND_PRINCE.nodes) {
        assert!((row.iter().sum::<f64>() - node).abs() < 1e-14);
    }
    for (row, node) in RK4.weights.iter().zip(RK4.nodes) {
        assert!((row.iter().sum::<f64>() - node).abs() < 1e-15);
    }
}

#[test]
fn what_cannot_go_on_says_so() {
    let halted = |system: &mut Particles, y: Vec<f64>, witness: &mut Witness| {
        let (mut method, mut statistics) = (RungeKutta::new(DORMAND_PRINCE, 2), Statistics::new());
        let mut state = State::new(y);
        let result = run(system, &mut method, &adaptive(1e-6, 0.1), &mut state, 100.0, witness, &mut statistics);
        (result.unwrap_err(), state)
    };
    // q̈ = +q³ reaches infinity in a finite time, √2/q₀ for this start.
    let (Halted { halt, elapsed }, state) =
        halted(&mut Particles::new(&[0.0], &[-1.0]), vec![1.0, 0.5_f64.sqrt()], &mut Witness::default());
    assert_eq!(halt, Halt::Diverged);
    assert!((elapsed - 2.0_f64.sqrt()).abs() < 1e-3, "{elapsed}");
    assert!(state.y.iter().all(|value| value.is_finite()) && state.elapsed == elapsed);

    // A fixed step runs past that instant and finds out when nothing is finite any more.
    let (mut method, mut state) = (RungeKutta::new(RK4, 2), State::new(vec![1.0, 0.5_f64.sqrt()]));
    let mut exploding = Particles::new(&[0.0], &[-1.0]);
    let Halted { halt, elapsed } = run(
        &mut exploding,
        &mut method,
        &StepControl::Fixed(0.01),
        &mut state,
        100.0,
        &mut Witness::default(),
        &mut Statistics::new(),
    )
    .unwrap_err();
    assert_eq!((halt, elapsed), (Halt::Diverged, state.elapsed));
    assert!(elapsed > 1.4 && elapsed < 1.6 && state.y.iter().all(|value| value.is_finite()), "{elapsed}");

    let mut impatient = Witness { patience: Some(3), ..Witness::default() };
    let (Halted { halt, .. }, state) = halted(&mut Particles::new(&[1.0], &[0.0]), vec![1.0, 0.0], &mut impatient);
    assert_eq!((halt, state.count), (Halt::Interrupted, 128));

    let (Halted { halt, elapsed }, _) =
        halted(&mut Particles::new(&[1.0], &[0.0]), vec![f64::NAN, 0.0], &mut Witness::default());
    assert_eq!((halt, elapsed), (Halt::Diverged, 0.0));
    assert_eq!(
        [StepLimit::Step, StepLimit::Stability, StepLimit::Tolerance].map(StepLimit::name),
        ["step", "stability", "tolerance"]
    );
}
